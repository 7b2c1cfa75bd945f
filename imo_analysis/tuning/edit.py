"""The text of a study with other gains: nothing but the numbers of the gains changes, comments and layout stay.

Gains stand as an inline table, ``gains = { k_1 = 300.0, ... }`` under ``[observers.NAME]``, or as a table
``[observers.NAME.gains]``. Text that is laid out in another way is left to the writer, which knows no comments.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping

_KEY = r"""(?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')"""
_HEADER = re.compile(rf"^[ \t]*\[+[ \t]*({_KEY}(?:[ \t]*\.[ \t]*{_KEY})*)[ \t]*\]+", re.MULTILINE)
_INLINE = re.compile(r"^[ \t]*gains[ \t]*=[ \t]*\{([^}]*)\}", re.MULTILINE)


def edited(text: str, gains: Mapping[str, Mapping[str, float]]) -> str | None:
    """The text with other gains, or None where it cannot be edited to mean just that.

    Parameters
    ----------
    text : str
        TOML of a study.
    gains : mapping of str to mapping
        All gains by observer.
    """
    wanted = tomllib.loads(text)
    for name, values in gains.items():
        changed = _observer(text, name, values)
        if changed is None:
            return None
        text = changed
        wanted["observers"][name]["gains"] = dict(values)
    try:
        return text if tomllib.loads(text) == wanted else None
    except tomllib.TOMLDecodeError:
        return None


def _observer(text: str, name: str, values: Mapping[str, float]) -> str | None:
    for path, inline in ((("observers", name, "gains"), False), (("observers", name), True)):
        if (span := _table(text, path)) is None:
            continue
        start, stop = span
        if inline:
            table = _INLINE.search(text, start, stop)
            if table is None:
                return None
            start, stop = table.span(1)
        body = text[start:stop]
        for gain, value in values.items():
            # after the start of a line, a brace or a comma, so that no comment is taken for it
            found = list(re.finditer(rf"(?m)(?:^|[{{,])[ \t]*{re.escape(gain)}[ \t]*=[ \t]*([^,\s#}}]+)", body))
            if len(found) != 1:
                return None
            body = body[: found[0].start(1)] + repr(value) + body[found[0].end(1) :]
        return text[:start] + body + text[stop:]
    return None


def _table(text: str, path: tuple[str, ...]) -> tuple[int, int] | None:
    """Where the body of a table begins and ends."""
    heads = list(_HEADER.finditer(text))
    for number, head in enumerate(heads):
        if tuple(key.strip("\"' \t") for key in re.findall(_KEY, head[1])) == path:
            return head.end(), heads[number + 1].start() if number + 1 < len(heads) else len(text)
    return None
