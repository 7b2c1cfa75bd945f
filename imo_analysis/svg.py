"""Matplotlib's SVG made small, steady and readable: text stays text, in reading order, and its letters are those of STIX.

`tidied` does that; `standalone` gives a file of its own the letters to be read with, for they are placed by the widths of STIX;
`inside_page` makes the same figure part of an HTML page, which brings a font along.
"""

from __future__ import annotations

import base64
import functools
import html
import re
import unicodedata
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

# Where a reader takes no fonts from the file and STIX is not installed, the faces of Times have its widths.
FONTS = "STIXGeneral,STIX,'STIX Two Text','Times New Roman',Times,'Liberation Serif',serif"

_NUMBERS = re.compile(r'\b(?:d|x|y|points|transform)="[^"]*"')
_LONG = re.compile(r"-?\d+\.\d{3,}")
_LINES = re.compile(r'\bd="((?:[ML] \S+ \S+\s+|z\s*)+)"')
_STYLE = re.compile(r"<defs>\s*<style[^>]*>.*?</style>\s*</defs>", re.DOTALL)
_ID = re.compile(r' id="([^"]*)"')
_REFERENCE = re.compile(r'(?:href="#|url\(#)([^")]+)')
_FORMULA = re.compile(r"<text>\s*((?:<tspan[^>]*>[^<]*</tspan>\s*)+)</text>")
_SPAN = re.compile(r'<tspan x="([^"]*)" y="([^"]*)" style="([^"]*)">([^<]*)</tspan>')
_ITALIC = re.compile(r'(<tspan[^>]*style=")font-style: italic; ([^>]*>)([^<]*)')

# A combining mark alone is set differently by every font; the spacing accent, centred, by none.
_ACCENTS = {"\u0302": "\u02c6", "\u0303": "\u02dc", "\u0307": "\u02d9", "\u0304": "\u00af", "\u0308": "\u00a8"}


def tidied(svg: str) -> str:
    """The figure without what no reader needs: comments, unused ids, digits finer than a hundredth of a point."""
    svg = svg[svg.index("<svg"):]
    svg = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = _STYLE.sub("", svg, count=1)
    svg = _FORMULA.sub(lambda found: f"<text>{''.join(_formula(found[1]))}</text>", svg)
    svg = re.sub(r"font-family: 'STIXGeneral'(?:, serif)?;? ?", "", svg)
    svg = re.sub(r' transform="rotate\(-?0 [^"]*\)"| style=""', "", svg)
    used = set(_REFERENCE.findall(svg))
    svg = _ID.sub(lambda found: found[0] if found[1] in used else "", svg)
    svg = _LINES.sub(lambda found: f' d="{_relative(found[1])}"', svg)
    svg = _NUMBERS.sub(lambda found: _LONG.sub(_short, found[0]), svg)
    svg = re.sub(r"\n\s*", "\n", svg)
    root = f'<svg font-family="{FONTS}" stroke-linejoin="round" stroke-linecap="butt"'
    return root + svg.removeprefix("<svg")


def _short(number: re.Match[str]) -> str:
    return f"{float(number[0]):.2f}".rstrip("0").rstrip(".")


def _relative(path: str) -> str:
    """A path of straight lines by its steps, in tenths of a point: finer than a screen or a printer, and half as long."""
    pieces = []
    x = y = 0
    for piece in path.split("M")[1:]:
        closed = "z" in piece
        numbers = [round(10 * float(number)) for number in piece.replace("L", " ").replace("z", " ").split()]
        points = list(zip(numbers[::2], numbers[1::2], strict=True))
        steps = [(points[0][0] - x, points[0][1] - y)]
        steps += [step for (a, b), (c, d) in pairwise(points) if (step := (c - a, d - b)) != (0, 0)]
        steps = steps if len(steps) > 1 or len(points) == 1 else [*steps, (0, 0)]  # a dot is drawn by its caps
        written = [f"{_tenth(a)}{_joined(_tenth(b))}" for a, b in steps]
        pieces.append(f"m{written[0]}" + ("l" + "".join([written[1], *map(_joined, written[2:])]) if len(written) > 1 else "")
                      + ("z" if closed else ""))
        x, y = points[0] if closed else points[-1]
    return "".join(pieces)


def _tenth(number: int) -> str:
    whole, rest = divmod(abs(number), 10)
    return ("-" if number < 0 else "") + (f"{whole or ''}.{rest}" if rest else str(whole))


def _joined(number: str) -> str:
    return number if number.startswith("-") else f" {number}"


def _formula(spans: str) -> Iterator[str]:
    """Matplotlib groups the letters of a formula by their style; here they stand from left to right, words together."""
    letters = sorted((_place(*letter) for letter in _SPAN.findall(spans)), key=lambda letter: letter[0])
    run: list[str] = []
    place: tuple[float, str, str] = (0.0, "", "")
    for x, y, style, text in letters:
        if not (run and (y, style) == place[1:] and "anchor" not in style):
            yield from _span(run, place)
            run, place = [], (x, y, style)
        run.append(text)
    yield from _span(run, place)


def _place(x: str, y: str, style: str, text: str) -> tuple[float, str, str, str]:
    """A letter where it begins, an accent where its middle is."""
    text = html.unescape(text).replace("\xa0", " ")
    if text not in _ACCENTS:
        return float(x), y, style, text
    size = float(re.search(r"font-size: ([\d.]+)px", style)[1])  # type: ignore[index]
    return float(x) + size * _middle(text), y, f"{style}; text-anchor: middle", _ACCENTS[text]


def _span(letters: list[str], place: tuple[float, str, str]) -> Iterator[str]:
    text = "".join(letters)
    if text:
        x, y, style = place
        yield f'<tspan x="{x:.4f}" y="{y}" style="{style}">{html.escape(text, quote=False)}</tspan>'


@functools.lru_cache(maxsize=16)
def _middle(mark: str) -> float:
    """Where the middle of a combining mark lies from its origin, in sizes of the font."""
    from matplotlib import get_data_path
    from matplotlib.ft2font import FT2Font, LoadFlags

    font = FT2Font(f"{get_data_path()}/fonts/ttf/STIXGeneral.ttf")
    font.set_size(100.0, 72.0)
    box = font.load_char(ord(mark), flags=LoadFlags.NO_HINTING).bbox
    return (box[0] + box[2]) / 2 / 64 / 100


def standalone(svg: str) -> str:
    """The figure with its letters inside, upright and italic, so that it looks the same where no STIX is installed.

    Parameters
    ----------
    svg : str
        From `tidied`.
    """
    rules = font_rule("Imo Figure", "figure.woff2")
    if "font-style: italic" in svg:
        rules += font_rule("Imo Figure", "figure-italic.woff2", "italic")
    end = svg.index(">") + 1
    opening = svg[:end].replace(f'font-family="{FONTS}"', f'font-family="\'Imo Figure\',{FONTS}"')
    return f"{opening}<style>{rules}</style>{svg[end:]}"


@functools.lru_cache(maxsize=4)
def font_rule(family: str, file: str, style: str = "normal") -> str:
    """The CSS rule that carries a font of ``imo_analysis/fonts`` inside a page or a figure."""
    data = base64.b64encode((Path(__file__).parent / "fonts" / file).read_bytes()).decode()
    slanted = "" if style == "normal" else f"font-style:{style};"
    return f'@font-face{{font-family:"{family}";{slanted}src:url(data:font/woff2;base64,{data}) format("woff2")}}'


def inside_page(svg: str, name: str, said: str) -> str:
    """The figure as a part of a page: its ids are its own, and italics are the letters of the page's math font.

    Parameters
    ----------
    svg : str
        From `tidied`.
    name : str
        Put before every id; unique in the page.
    said : str
        What a reader hears who cannot see the figure.
    """
    svg = re.sub(r'(id="|href="#|url\(#)', rf"\g<1>{name}-", svg)
    svg = _ITALIC.sub(lambda found: found[1] + found[2] + italic(found[3]), svg)
    svg = re.sub(r' (?:version|xmlns(?::xlink)?|font-family)="[^"]*"', "", svg.replace("xlink:href", "href"))
    return f'<svg role="img" aria-label="{html.escape(said, quote=True)}"' + svg.removeprefix("<svg")


def italic(text: str) -> str:
    """Letters as the italic letters of mathematics, U+1D434 and on."""
    return "".join(_italic(letter) for letter in html.unescape(text))


def _italic(letter: str) -> str:
    if letter == "h":
        return "\u210e"  # the one that stands elsewhere
    for first, last, base in (("A", "Z", 0x1D434), ("a", "z", 0x1D44E), ("Α", "Ω", 0x1D6E2), ("α", "ω", 0x1D6FC)):
        if first <= letter <= last and unicodedata.category(letter).startswith("L"):
            return chr(base + ord(letter) - ord(first))
    return html.escape({"ϕ": "\U0001d719", "ϵ": "\U0001d716", "ϑ": "\U0001d717"}.get(letter, letter), quote=False)
