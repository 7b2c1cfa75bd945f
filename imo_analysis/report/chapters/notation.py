"""The chapter with Table I: every symbol, once, as the program knows it."""

from __future__ import annotations

from imo_analysis.notation import SYMBOLS
from imo_analysis.report.page import Chapter, join, prose, table, tag
from imo_analysis.report.words import typeset, unit


def notation_chapter() -> Chapter:
    """Table I of the paper, with the symbols that this project adds."""
    rows = [
        (f"${entry.latex}$", tag("code", entry.name), unit(entry.unit), typeset(entry.meaning), entry.source)
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
