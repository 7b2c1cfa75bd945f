"""Long formulas in rows: broken before a plus or a minus, so that they fit a column on a screen and on paper."""

from __future__ import annotations

import re

from imo_analysis.report.math import atoms

LINE = 37.0  # em: what a row may be wide by `width`, which is seldom less than what a browser sets
_RELATIONS = frozenset(("=", "<", ">", r"\le", r"\ge", r"\ne"))
_SIGNS = frozenset(("+", "-"))
_NO_WIDTH = re.compile(r"\\(?:hat|tilde|dot|ddot|bar|left|right|mathrm)(?![a-z])|&")
_FRACTION = re.compile(r"\\[dt]?frac")
_BRACKETS = re.compile(r"\\left(.)(.*)\\right(.)((?:[_^].*)?)", re.DOTALL)
_SCRIPT = re.compile(r"[_^](?:\{([^{}]*)\}|(\\?\w))")
_GLYPH = re.compile(r"\\[A-Za-z]+|[^\s{}]")
_SIGN, _LETTER, _RAISED = 1.3, 0.6, 0.42  # em


def broken(latex: str) -> str:
    """The formula, in aligned rows where it is one relation that is wider than `LINE`."""
    pieces = atoms(latex)
    relation = next((k for k, piece in enumerate(pieces) if piece in _RELATIONS), None)
    if relation is None or "\\\\" in latex or width(latex) <= LINE:
        return latex
    left = " ".join(pieces[:relation])
    rows, row = [], [f"{left} &{pieces[relation]}"]
    for term in _terms(pieces[relation + 1:]):
        if len(row) > 1 and width(" ".join((*row, term))) > LINE:
            rows.append(" ".join(row))
            row = [r"&\quad"]
        row.append(term)
    rows.append(" ".join(row))
    return latex if len(rows) == 1 else r"\begin{aligned}" + r" \\ ".join(rows) + r"\end{aligned}"


def _terms(pieces: list[str]) -> list[str]:
    """The terms of a sum, each with its sign; a coloured sign (``\\class{differs}{+}``) is a sign, too."""
    found: list[list[str]] = [[]]
    for k, piece in enumerate(pieces):
        coloured = piece == r"\class" and pieces[k + 2: k + 3] in (["{+}"], ["{-}"])
        if (piece in _SIGNS or coloured) and found[-1] and pieces[k - 2: k - 1] != [r"\class"]:
            found.append([])
        found[-1].append(piece)
    return [" ".join(one) for one in found]


def width(latex: str) -> float:
    """About how wide a formula is set, in em."""
    return sum(map(_wide, atoms(latex.replace(r"\class{differs}", ""))))


def _wide(atom: str) -> float:
    if _FRACTION.match(atom):
        return max(map(width, _parts(atom)))
    brackets = _BRACKETS.fullmatch(atom)
    if brackets:
        return _glyphs(brackets[1] + brackets[3] + brackets[4]) + width(brackets[2])
    return _glyphs(atom)


def _glyphs(text: str) -> float:
    text = _NO_WIDTH.sub("", text)
    raised = sum(len(_GLYPH.findall(one or other)) for one, other in _SCRIPT.findall(text))
    signs = _GLYPH.findall(_SCRIPT.sub("", text))
    return _RAISED * raised + sum(_SIGN if one in _SIGNS or one in _RELATIONS else _LETTER for one in signs)


def _parts(fraction: str) -> tuple[str, str]:
    """What stands above and below the line."""
    depth, cut = 0, []
    for k, letter in enumerate(fraction):
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if (letter == "{" and depth == 1) or (letter == "}" and depth == 0):
            cut.append(k)
    return fraction[cut[0] + 1: cut[1]], fraction[cut[2] + 1: cut[3]]
