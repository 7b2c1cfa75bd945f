"""LaTeX to MathML that every current browser shows without a script, and the coloured difference of two formulas.

`latex2mathml` does the work; what it gets wrong for this project's formulas (accents that stretch, a matrix with an exponent,
aligned rows) is put right before and after it.
"""

from __future__ import annotations

import html
import re
import xml.etree.ElementTree as ET
from difflib import SequenceMatcher
from functools import lru_cache

from imo_analysis.svg import font_rule

_SPACE = "http://www.w3.org/1998/Math/MathML"
ET.register_namespace("", _SPACE)

# accent as latex2mathml writes it -> the character that math fonts centre above a letter
_ACCENTS = {"^": "\u02c6", "~": "\u02dc", "\u02d9": "\u02d9", "\u00af": "\u00af"}
_ENVIRONMENT = re.compile(r"\\begin\{([pbvB]?matrix|cases)\}")
_FIRST = (
    (re.compile(r"\\operatorname\*?\{([^{}]*)\}"), r"\\mathrm{\1}"),
    (re.compile(r"\\(begin|end)\{(aligned|split|gathered)\}"), r"\\\1{align*}"),
    (re.compile(r"\\(?:tag|label)\{[^{}]*\}|\\nonumber|\\displaystyle"), ""),
    (re.compile(r"\\[lr]Vert"), r"\\|"),
    (re.compile(r"\\[lr]vert"), "|"),
)


def mathml(latex: str, display: bool = False) -> str:
    """MathML of a formula.

    Parameters
    ----------
    latex : str
        LaTeX of mathematics, without dollar signs.
    display : bool
        In display size; it still flows with the text, so that its place is the page's choice.

    Returns
    -------
    str
        A ``<math>`` element. A formula that cannot be read is shown as its source, marked with class ``unread``.
    """
    return _convert(latex.strip(), display)


@lru_cache(maxsize=4096)
def _convert(latex: str, display: bool) -> str:
    from latex2mathml.converter import convert

    text = latex
    for pattern, replacement in _FIRST:
        text = pattern.sub(replacement, text)
    text = _braced_environments(text)
    try:
        written = convert(text)
        root = ET.fromstring(_characters(written))
    except Exception:  # latex2mathml raises a dozen types of its own, none of them documented
        return f'<code class="unread">{html.escape(latex)}</code>'
    aligned = "{align*}" in text
    for node in root.iter():
        _repair(node)
        _signs(node)
        if aligned and node.tag.endswith("mtr"):
            for column, cell in enumerate(node):
                cell.attrib.pop("columnalign", None)
                side = "left" if column % 2 else "right"
                cell.set("style", f"text-align: {side}; padding-{side}: 0.1em")
    root.attrib.pop("display", None)
    root.set("alttext", latex)  # what a copy of the page without MathML needs
    if display:
        root.set("displaystyle", "true")
    # HTML knows the element without its namespace, and a page has thousands of them
    return ET.tostring(root, encoding="unicode", short_empty_elements=False).replace(f' xmlns="{_SPACE}"', "")


def _characters(written: str) -> str:
    """Replace numeric entities (of markup characters too) so that an XML parser reads what a browser would."""
    return re.sub(r"&(?!#?\w+;)", "&amp;", written)


def _braced_environments(text: str) -> str:
    """Put braces around a matrix, so that an exponent belongs to the whole of it."""
    match = _ENVIRONMENT.search(text)
    if not match:
        return text
    name = match[1]
    depth, position = 1, match.end()
    for edge in re.finditer(r"\\(begin|end)\{" + re.escape(name) + r"\}", text[position:]):
        depth += 1 if edge[1] == "begin" else -1
        if depth == 0:
            end = position + edge.end()
            inner = _braced_environments(text[match.end() : position + edge.start()])
            return f"{text[: match.start()]}{{\\begin{{{name}}}{inner}{edge[0]}}}{_braced_environments(text[end:])}"
    return text


def _repair(node: ET.Element) -> None:
    tag = node.tag.rpartition("}")[2]
    children = list(node)
    if tag == "mover" and len(children) == 2 and children[1].tag.endswith("mo"):
        accent = (children[1].text or "").strip()
        if accent in _ACCENTS:
            node.set("accent", "true")
            children[1].text = _ACCENTS[accent]
            children[1].set("stretchy", "false")
    elif tag in ("munder", "mover") and len(children) == 2:
        for child in children:
            if child.tag.endswith("mo") and (child.text or "") in ("\u23de", "\u23df"):
                child.set("stretchy", "true")
    elif tag == "mtd" and node.get("columnalign"):
        node.set("style", f"text-align: {node.get('columnalign')}")  # MathML Core knows the style only


# latex2mathml leaves the sides of these to the browser, which sets them too wide
_TIGHT = {"|": "0", "\u2016": "0", "/": "0.08em"}
_OPENING = frozenset("=<>(,[{\u2264\u2265\u2260\u2248\u2261\u21d2\u00b7|\u2212+")


def _signs(node: ET.Element) -> None:
    """A minus after an equals sign or an opening bracket is a prefix; browsers take it for a subtraction and set it wide."""
    before: ET.Element | None = None
    for child in node:
        if child.tag.endswith("mo") and child.text in _TIGHT and "stretchy" not in child.attrib:
            child.set("lspace", _TIGHT[child.text])
            child.set("rspace", _TIGHT[child.text])
            child.set("stretchy", "false")
        opened = before is not None and before.tag.endswith("mo") and (before.text or "") in _OPENING
        if opened and child.tag.endswith("mo") and child.text in ("\u2212", "+"):
            child.set("form", "prefix")
        before = child


def font_face() -> str:
    """The CSS rule that carries the math font inside the page."""
    return font_rule("Imo Math", "math.woff2")


# Differences --------------------------------------------------------------------------------------------------------
_ATOM = re.compile(r"\\[A-Za-z]+|\\.|\s+|.", re.DOTALL)
_ARGUMENTS = {"frac": 2, "dfrac": 2, "tfrac": 2, "sqrt": 1, "hat": 1, "dot": 1, "ddot": 1, "tilde": 1, "bar": 1, "mathrm": 1,
              "text": 1, "operatorname": 1, "boldsymbol": 1, "mathbf": 1, "overline": 1, "widehat": 1, "mathbb": 1}
_PAIRED = re.compile(r"\\(?:begin\{[^}]*\}|end\{[^}]*\}|left(?![a-z])|right(?![a-z]))")


def atoms(latex: str) -> list[str]:
    """Cut a formula at its outermost level: a command with its arguments, a bracketed group, a letter with its scripts."""
    pieces: list[str] = []
    position = 0
    while position < len(latex):
        start = position
        position = _one(latex, position)
        if not latex[start:position].strip():
            continue
        while position < len(latex) and latex[position] in "_^'":
            position = position + 1 if latex[position] == "'" else _one(latex, position + 1)
        pieces.append(latex[start:position].strip())
    return pieces


def _one(text: str, position: int) -> int:
    """Where the atom that starts at ``position`` ends."""
    while position < len(text) and text[position].isspace():
        position += 1
    if position >= len(text):
        return position
    if text[position] == "{":
        return _closing(text, position)
    pair = _PAIRED.match(text, position)
    if pair:
        return _paired(text, position)
    match = _ATOM.match(text, position)
    assert match is not None
    position = match.end()
    for _ in range(_ARGUMENTS.get(match[0][1:], 0) if match[0].startswith("\\") else 0):
        position = _one(text, position)
    return position


def _closing(text: str, position: int) -> int:
    depth = 0
    while position < len(text):
        if text[position] == "\\":
            position += 2
            continue
        depth += {"{": 1, "}": -1}.get(text[position], 0)
        position += 1
        if depth == 0:
            return position
    return position


def _paired(text: str, position: int) -> int:
    """The end of ``\\left( ... \\right)`` or of an environment that begins at ``position``."""
    depth = 0
    for edge in _PAIRED.finditer(text, position):
        opens = edge[0].startswith(("\\begin", "\\left"))
        depth += 1 if opens else -1
        if depth == 0:
            end = edge.end()
            return _ATOM.match(text, end).end() if edge[0] == "\\right" and end < len(text) else end  # type: ignore[union-attr]
    return len(text)


def difference(printed: str, derived: str) -> tuple[str, str]:
    """Both formulas with the parts that differ marked by ``\\class{differs}``, inside fractions and brackets too."""
    first, second = atoms(printed), atoms(derived)
    marked: tuple[list[str], list[str]] = ([], [])
    for what, a, b, c, d in SequenceMatcher(None, first, second, autojunk=False).get_opcodes():
        if what == "equal":
            marked[0].extend(first[a:b])
            marked[1].extend(second[c:d])
        elif b - a == d - c:
            for one, other in zip(first[a:b], second[c:d], strict=True):
                for side, piece in enumerate(_inside(one, other) or (_mark(one), _mark(other))):
                    marked[side].append(piece)
        else:
            marked[0].extend(map(_mark, first[a:b]))
            marked[1].extend(map(_mark, second[c:d]))
    return " ".join(marked[0]), " ".join(marked[1])


def _mark(piece: str) -> str:
    return piece if piece in ("&", "\\\\") else f"\\class{{differs}}{{{piece}}}"


_FRACTION = re.compile(r"\\[dt]?frac")
_BRACKETS = re.compile(r"(\\left.)(.*)(\\right.)((?:[_^].*)?)", re.DOTALL)


def _inside(one: str, other: str) -> tuple[str, str] | None:
    """The difference of two fractions, or of two brackets with the same exponent, part by part."""
    if _FRACTION.match(one) and _FRACTION.match(other):
        parts = [_arguments(piece) for piece in (one, other)]
        if all(len(part) == 2 for part in parts):
            over, under = (difference(a, b) for a, b in zip(*parts, strict=True))
            return f"\\frac{{{over[0]}}}{{{under[0]}}}", f"\\frac{{{over[1]}}}{{{under[1]}}}"
    a, b = _BRACKETS.fullmatch(one), _BRACKETS.fullmatch(other)
    if a and b and (a[1], a[3], a[4]) == (b[1], b[3], b[4]):
        left, right = difference(a[2], b[2])
        return f"{a[1]}{left}{a[3]}{a[4]}", f"{a[1]}{right}{a[3]}{a[4]}"
    return None


def _arguments(fraction: str) -> list[str]:
    """The contents of the braces of a plain fraction; empty when something follows them."""
    position = fraction.index("c") + 1
    parts = []
    while position < len(fraction):
        end = _one(fraction, position)
        parts.append(fraction[position:end].strip().removeprefix("{").removesuffix("}"))
        position = end
    return parts
