"""Text with `code`, ``code`` and $formulas$ as docutils nodes, names of the notation table set as symbols; and tables of it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from docutils import nodes

from imo_analysis.report.words import unit as written_unit

_PIECE = re.compile(r"(``[^`]+``|`[^`]+`|\$[^$]+\$)")


def inline(text: str) -> list[nodes.Node]:
    """The nodes of one run of text."""
    found: list[nodes.Node] = []
    for piece in _PIECE.split(text):
        if piece.startswith("$") and len(piece) > 1:
            found.append(nodes.math(text=piece[1:-1]))
        elif piece.startswith("`") and len(piece) > 1:
            found.append(nodes.literal(text=piece.strip("`")))
        elif piece:
            found.append(nodes.Text(piece))
    return found


def paragraph(text: str) -> nodes.paragraph:
    """A paragraph of `inline` text."""
    node = nodes.paragraph()
    node += inline(text)
    return node


def unit(text: str) -> str:
    """A unit as people write it; nothing for what is no quantity."""
    return written_unit(text).replace(" ", "\u00a0") if text else ""


def table(head: Sequence[str], rows: Iterable[Sequence[str | nodes.Node]], widths: Sequence[int] | None = None) -> nodes.table:
    """A table whose cells are `inline` text or nodes; columns of a width of 6 and more are for sentences."""
    widths = widths or [1] * len(head)
    group = nodes.tgroup(cols=len(head))
    for width in widths:
        group += nodes.colspec(colwidth=width)
    top = nodes.thead()
    top += _row([paragraph(cell) for cell in head], widths)
    body = nodes.tbody()
    for row in rows:
        body += _row([cell if isinstance(cell, nodes.Node) else paragraph(cell) for cell in row], widths)
    group += [top, body]
    whole = nodes.table(classes=["wide"])
    whole += group
    return whole


def _row(cells: Sequence[nodes.Node], widths: Sequence[int]) -> nodes.row:
    row = nodes.row()
    for cell, width in zip(cells, widths, strict=True):
        entry = nodes.entry(classes=["said"] if width >= 6 else [])
        entry += cell
        row += entry
    return row


def section(title: str, anchor: str, *body: nodes.Node) -> nodes.section:
    """A section with its title and contents."""
    node = nodes.section(ids=[anchor], names=[anchor])
    head = nodes.title()
    head += inline(title)
    node += [head, *body]
    return node


def console(lines: Iterable[str]) -> nodes.literal_block:
    """Lines as they are typed."""
    text = "\n".join(lines)
    return nodes.literal_block(text, text, language="text")
