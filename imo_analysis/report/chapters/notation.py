"""The chapter with Table I: every symbol, once, as the program knows it."""

from __future__ import annotations

from imo_analysis.notation import SYMBOLS
from imo_analysis.report.page import Chapter, Html, join, prose, table, tag


def notation_chapter() -> Chapter:
    """Table I of the paper, with the symbols that this project adds."""
    rows = [
        (f"${entry.latex}$", tag("code", entry.name), _unit(entry.unit), entry.meaning, entry.source)
        for entry in SYMBOLS.values()
    ]
    body = join(
        [
            prose(
                r"""
Names used in every equation, data file and figure. Complex shorthand: $x = x_d + \mathrm{j} x_q$. The frame is the stationary
one, $\omega_1 = 0$, unless a formula shows $\omega_1$.

A hat is an estimate (`_hat`), a tilde is an error, true minus estimate (`_tilde`), a dot is a rate of change (`_dot`, written
last): `alpha_hat_dot` is $\dot{\hat{\alpha}}$. "Ours" marks a symbol that the paper does not have.
"""
            ),
            table(("symbol", "name", "unit", "meaning", "source"), rows),
        ]
    )
    return Chapter("notation", "Notation", "Notation", body)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _unit(unit: str) -> Html:
    """A unit as people write it: 1/(kg m^2) with a raised exponent."""
    pieces = unit.split("^")
    written = pieces[0]
    for piece in pieces[1:]:
        digits = len(piece) - len(piece.lstrip("-0123456789"))
        written += piece[:digits].translate(_RAISED) + piece[digits:]
    return tag("span", "–" if unit == "1" else written.replace("ohm", "Ω"))
