"""The edit that leads from one formula to another, token by token."""

from __future__ import annotations

import difflib
import re

_TOKEN = re.compile(r"\w+|\*\*|<=|>=|!=|\S|\s+")


def difference(printed: str, corrected: str) -> list[tuple[str, str]]:
    """The edit from one formula to another: pieces with ``=`` (in both), ``-`` (printed only), ``+`` (corrected only)."""
    old, new = _TOKEN.findall(printed), _TOKEN.findall(corrected)
    pieces: list[tuple[str, str]] = []
    for tag, a, b, c, d in difflib.SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if tag == "equal":
            pieces.append(("=", "".join(old[a:b])))
            continue
        if b > a:
            pieces.append(("-", "".join(old[a:b])))
        if d > c:
            pieces.append(("+", "".join(new[c:d])))
    return pieces
