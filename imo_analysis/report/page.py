"""Pieces of HTML, and the one self-contained page. Everything that comes from data is escaped here, once."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from imo_analysis.report.breaking import broken
from imo_analysis.report.math import font_face, mathml
from imo_analysis.report.numbers import in_formula, tidied
from imo_analysis.report.numbers import number as number  # written with the other pieces of a page
from imo_analysis.svg import inside_page

_ASSETS = Path(__file__).parent / "assets"


class Html(str):
    """Text that is HTML already; any other text is escaped where it is put in."""

    __slots__ = ()


@dataclass(frozen=True)
class Chapter:
    """A chapter of the dossier: anchor, short name for the list of chapters, title and contents."""

    anchor: str
    name: str
    title: str
    body: Html


def text(value: object) -> Html:
    """A value as HTML: `Html` as it is, everything else escaped."""
    return value if isinstance(value, Html) else Html(html.escape(str(value), quote=True))


def join(parts: Iterable[object], between: str = "\n") -> Html:
    """The parts one after the other, escaped where needed."""
    return Html(between.join(text(part) for part in parts))


def tag(name: str, *parts: object, **attributes: object) -> Html:
    """An element; ``class_`` and ``for_`` give class and for, an underscore in a name a dash, and None leaves one out."""
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{html.escape(str(value), quote=True)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return Html(f"<{name}{written}>{join(parts, '')}</{name}>")


def prose(source: str) -> Html:
    """Paragraphs of plain text with ``code`` in backticks and $formulas$ in dollars; blank lines part the paragraphs."""
    return join(tag("p", inline(paragraph)) for paragraph in source.strip().split("\n\n") if paragraph.strip())


def inline(source: object) -> Html:
    """One run of text with backticks and dollars."""
    if isinstance(source, Html):
        return source
    pieces: list[Html] = []
    for place, piece in enumerate(str(source).split("`")):
        if place % 2:
            pieces.append(tag("code", piece))
            continue
        for inner, part in enumerate(piece.split("$")):
            pieces.append(Html(mathml(in_formula(part))) if inner % 2 else text(tidied(part)))
    return join(pieces, "")


def formula(latex: str) -> Html:
    """A formula on its own line, a long one in rows, in a box that scrolls when it is too wide all the same."""
    return tag("div", Html(mathml(broken(latex), display=True)), class_="scroll formula")


def table(head: Sequence[object], rows: Iterable[Sequence[object]], caption: str = "", numeric: Iterable[int] = ()) -> Html:
    """A table; columns in ``numeric`` are set to the right, and a column that holds nothing but dashes is left out."""
    lines, right = list(rows), set(numeric)
    empty = {k for k in range(len(head)) if lines and all(row[k] == "–" for row in lines)}

    def cells(kind: str, row: Sequence[object]) -> Html:
        parted = _parted if kind == "th" else _deviation_below
        shown = ((k, parted(inline(cell))) for k, cell in enumerate(row) if k not in empty)
        return join((tag(kind, cell, class_="n" if k in right else None) for k, cell in shown), "")

    title = tag("caption", inline(caption)) if caption else Html("")
    body = join(tag("tr", cells("td", row)) for row in lines)
    return tag("div", tag("table", title, tag("thead", tag("tr", cells("th", head))), tag("tbody", body)), class_="scroll")


def _parted(cell: Html) -> Html:
    """A head whose names may be broken after an underscore, and nowhere else."""
    return Html(re.sub(r"<code>[^<]*</code>", lambda name: name[0].replace("_", "_<wbr/>"), cell))


def _deviation_below(cell: Html) -> Html:
    """A mean with its deviation, which may go on the next line where the table is wide."""
    return Html(cell.replace(" ± ", " ±<wbr/> "))


_COLUMN, _WIDE = 518.4, 56.0  # points of a figure as wide as a column, and its width in the page in rem
_LEGIBLE = 9.0  # px: no text of a figure is smaller on a phone
_FONT_SIZE = re.compile(r"font(?:-size)?:[^;\"]*?([\d.]+)px")
_PLACE = "\ue000"  # stands for a figure's number until the page is put together


def figure(svg: str, caption: str, alt: str, file: str) -> Html:
    """A figure inside the page, its text as text, with a number, a caption, and a link to its file if there is one."""
    from imo_analysis.report.words import typeset  # which is made of these pieces

    wide = float(re.search(r'viewBox="0 0 (\S+)', svg)[1])  # type: ignore[index]
    least = math.ceil(wide * _LEGIBLE / min(map(float, _FONT_SIZE.findall(svg)), default=_LEGIBLE))
    size = f"max-width:{min(_WIDE, _WIDE * wide / _COLUMN):.1f}rem;--least:{least}px"
    image = Html(inside_page(svg, f"f{_PLACE}", re.sub(r"[$`\\{}]", "", alt)))
    link = tag("span", " File: ", tag("a", file, href=file), ".") if file else ""
    below = tag("figcaption", tag("b", f"Figure {_PLACE}. "), typeset(caption), link)
    return tag("figure", tag("div", image, class_="plate", style=size), below)


def beside(words: str, files: Sequence[str]) -> Html:
    """Figures that stay outside the page, as links to their files; where there are none, which command writes them."""
    links = join((tag("a", file, href=file) for file in files if file), ", ")
    return tag("p", words, " ", links or "beside the page of imo report without --small", ".", class_="note")


def numbered(body: str) -> str:
    """The figures of a page counted from one."""
    pieces = re.split(r"(<figure.*?</figure>)", body, flags=re.DOTALL)
    return "".join(piece.replace(_PLACE, str((k + 1) // 2)) if k % 2 else piece for k, piece in enumerate(pieces))


def answer(*parts: object) -> Html:
    """A framed sentence or two: what a chapter found."""
    return tag("div", *(tag("p", inline(part)) for part in parts), class_="answer")


def asset(name: str) -> str:
    """The text of a file in ``assets``."""
    return (_ASSETS / name).read_text(encoding="utf-8")


def page(title: str, first_screen: Html, chapters: Sequence[Chapter], footer: Html) -> str:
    """The whole page: style, font, script and figures inside, nothing loaded from anywhere."""
    items = join((tag("li", tag("a", c.name, href=f"#{c.anchor}")) for c in chapters), "")
    listed = tag("ol", tag("li", tag("a", "Verdicts", href="#top")), items)
    navigation = tag("nav", tag("p", "imo report", class_="name"), listed, aria_label="Chapters")
    sections = join(tag("section", tag("h2", c.title), c.body, id=c.anchor) for c in chapters)
    body = tag("div", navigation, tag("main", tag("section", first_screen, id="top"), sections, tag("footer", footer)),
               class_="frame")
    head = (
        '<meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{font_face()}\n{asset('page.css')}</style>"
        '<script>document.documentElement.className="js"</script>'
    )
    script = f"<script>{asset('page.js')}</script>"
    return f'<!DOCTYPE html>\n<html lang="en">\n<head>{head}</head>\n<body>\n{numbered(body)}\n{script}\n</body>\n</html>\n'
