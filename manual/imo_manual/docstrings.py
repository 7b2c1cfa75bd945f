"""numpydoc docstrings as reStructuredText for Sphinx: sections as lists, types from annotations where none is written."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache

from imo_manual.names import Argument, Module, Public, entries, modules, sections

_LISTS = ("Parameters", "Attributes", "Returns", "Raises", "Yields")
_KEPT = re.compile(r"(``[^`]+``|`[^`]+`)")
_SPECIAL = re.compile(r"[*|\\]|_(?=\W|$)")


def room_page(room: str) -> list[str]:
    """The page of a room: every module in it, with every public name."""
    lines: list[str] = []
    for module in modules():
        inside = module.name.removeprefix("imo_analysis").lstrip(".").split(".")[0]
        if (inside == room or (room == "top" and module.name.count(".") < 2 and not _is_room(inside))) and module.doc:
            lines += _module(module)
    return lines


@cache
def _is_room(name: str) -> bool:
    return any(module.name.startswith(f"imo_analysis.{name}.") for module in modules())


def _module(module: Module) -> list[str]:
    title = module.name.removeprefix("imo_analysis.")
    lines = [f".. py:module:: {module.name}", "", title, "-" * len(title), "", *_text(module.doc), ""]
    for one in module.public:
        lines += _public(one, "")
    return lines


def _public(one: Public, indent: str) -> list[str]:
    short = one.name.rpartition(".")[2]
    called = "" if one.kind == "property" else f"({', '.join(_written(argument) for argument in one.arguments)})"
    kind = {"property": "property", "method": "method", "class": "class", "function": "function"}[one.kind]
    body = [*_text(sections(one.doc)[""]), "", *_lists(one)]
    for member in one.members:
        body += _public(member, "")
    lines = [f".. py:{kind}:: {short}{called}", "", *(f"   {line}" if line else "" for line in body), ""]
    return [f"{indent}{line}" if line else "" for line in lines]


def _written(argument: Argument) -> str:
    """The argument in a signature: its default if that is short, no annotation (the list below has the types)."""
    if not argument.default:
        return f"{argument.mark}{argument.name}"
    short = argument.default if len(argument.default) < 24 and re.fullmatch(r"[\w.'\"\-(), ]+", argument.default) else "..."
    return f"{argument.name}={short}"


def _lists(one: Public) -> Iterator[str]:
    parts = sections(one.doc)
    known: set[str] = set()
    for head in _LISTS:
        if head not in parts:
            continue
        yield from (f"**{head}**", "")
        if head in ("Returns", "Yields"):
            yield from _returned(parts[head])
            continue
        for names, kind, text in entries(parts[head]):
            known.update(names)
            yield from _entry(", ".join(names), kind, text)
    for head, text in parts.items():
        if head and head not in _LISTS:
            yield from (f"**{head}**", "", *_text(text), "")
    typed = [f"``{argument.mark}{argument.name}: {argument.annotation}``" for argument in one.arguments
             if argument.name not in known and argument.annotation]
    if one.returns not in ("", "None") and "Returns" not in parts and one.kind != "class":
        typed.append(f"returns ``{one.returns}``")
    if typed and one.kind != "property":
        yield from (f"Types: {'; '.join(typed)}.", "")


def _returned(section: str) -> Iterator[str]:
    """What comes back: a line of its type, and what it is, indented."""
    head, *rest = section.splitlines()
    text = "\n".join(line.removeprefix("    ") for line in rest)
    yield from _entry(head, "", text)


def _entry(name: str, kind: str, text: str) -> Iterator[str]:
    names = ", ".join(f"``{part}``" for part in name.split(", "))
    if kind:
        kind = f"``{kind}``" if re.search(r"[\[\]|*.]", kind) and "`" not in kind else escaped(kind)
    yield f"- {names}{f' : {kind}' if kind else ''}"
    if text:
        yield ""
        yield from (f"  {line}" if line else "" for line in _text(text))
    yield ""


def _text(doc: str) -> list[str]:
    """The lines of a docstring with what is markup by accident escaped; literal blocks stay as they are."""
    lines: list[str] = []
    literal = listed = False
    for paragraph in re.split(r"\n[ ]*\n", doc.strip("\n")):
        margin = min(len(line) - len(line.lstrip()) for line in paragraph.splitlines() if line.strip())
        literal = literal and margin > 0
        listed = paragraph.startswith(("- ", "* ")) or (listed and margin > 0)
        apart = margin > 2 if listed else margin > 0
        if apart and not literal:  # a formula or a table of words set apart: as it is
            lines += ["  ::" if listed else "::", ""]
        keep = literal or apart
        lines += paragraph.splitlines() if keep else [_line(line) for line in escaped(paragraph).splitlines()]
        lines.append("")
        literal = paragraph.rstrip().endswith("::") or (literal and margin > 0)
    return lines


def _line(line: str) -> str:
    """A line whose bullet, if it has one, is one again."""
    return f"* {line[3:]}" if line.startswith("\\* ") else line


def escaped(text: str) -> str:
    """Text in which only backticks are markup."""
    return "".join(piece if number % 2 else _SPECIAL.sub(lambda found: f"\\{found[0]}", piece)
                   for number, piece in enumerate(_KEPT.split(text)))


# Links ----------------------------------------------------------------------------------------------------------------
@cache
def targets() -> dict[str, str]:
    """Full dotted name -> kind, of everything that the room pages describe."""
    found: dict[str, str] = {}
    for module in modules():
        found[module.name] = "module"
        for one in module.public:
            found[one.full] = one.kind
            found |= {member.full: member.kind for member in one.members}
    return found


def target(text: str, module: str, inside: str = "") -> str:
    """The full name that a name in backticks means in a docstring of this module, or nothing."""
    known = targets()
    text = text.removesuffix("()")
    places = [text, f"{module}.{text}", f"{module}.{inside}.{text}" if inside else text, f"imo_analysis.{text}"]
    for place in places:
        if place in known:
            return place
    room = module.rpartition(".")[0]
    for place in (f"{room}.{text}",):
        if place in known:
            return place
    ends = [one for one in known if one.endswith(f".{text}")]
    return ends[0] if len(ends) == 1 else ""
