"""The chapter on the stability proof: each step with its verdict, what breaks, and the repairs."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from imo_analysis.ledger.claim import Entry
from imo_analysis.ledger.expression import parse_relation
from imo_analysis.ledger.latex import relation_latex
from imo_analysis.report.chapters.ledger import anchor, badge, label
from imo_analysis.report.growth import RISES, Growth
from imo_analysis.report.page import Chapter, Html, answer, figure, formula, join, number, prose, table, tag
from imo_analysis.report.scenarios import Drawn
from imo_analysis.report.words import typeset

_PROOF = ("eq12", "eq13", "eq14", "eq15", "projection-inequality", "sign-operator", "eq16", "bounded-from-16", "eq17", "eq18",
          "lemma-IV.1", "barbalat-step", "proposition-IV.2")
_CONVERGENCE = ("eq19", "eq20", "eq21", "eq22", "eq23", "proposition-IV.3", "proposition-IV.4")
_V = (r"V = \frac{1}{2}|\tilde{i}|^{2} + \frac{\omega}{2 k_2 \hat{\omega}} |\tilde{z}|^{2} + "
      r"\frac{\alpha}{2 k_3} |\tilde{\xi}|^{2} + \frac{1}{2 g} \tilde{\alpha}^{2} + \frac{1}{2 K_p} \tilde{\omega}^{2}")
REPAIR = "repair"


def theorem_chapter(entries: Sequence[Entry], grown: Sequence[Growth], drawn: Drawn | None) -> Chapter:
    """Propositions IV.2 to IV.4 step by step, V along a run, and every repair in the ledger."""
    repairs = [entry for entry in entries if entry.claim.id.startswith(REPAIR)]
    body = join(
        [
            prose("The paper's stability result rests on one function (with $k_3$ where (13) prints $k_2$):"),
            formula(_V),
            prose(
                r"""
If its rate is at most $-(k_1 + R_s/\sigma)|\tilde{i}|^{2}$, then it never grows, all errors stay bounded, and the current
errors tend to zero. The question is whether that rate follows from the observer as printed. These are the steps, in order; each
opens in the ledger.
"""
            ),
            _steps(entries, _PROOF, "Proposition IV.2: boundedness"),
            prose(
                r"""
Two things carry the whole argument. First, the terms in $\tilde{z}$ cancel only when the z feedback has the pattern of (12).
Second, the weight $\omega / (2 k_2 \hat{\omega})$ moves with $\hat{\omega}$: its own rate leaves a term in
$\dot{\hat{\omega}} |\tilde{z}|^{2}$ that no sign operator removes, because the sign of $\dot{\hat{\omega}}$ is not that of
$\omega$.
"""
            ),
            *_growth(grown, drawn),
            _steps(entries, _CONVERGENCE, "Propositions IV.3 and IV.4: convergence"),
            prose("The argument is told from the beginning, each step with its check, in the project's `derivations`; "
                  "`imo notebook --out DIR` writes them as notebooks."),
            tag("h3", "Repairs"),
            prose("Each of these has a proof in the ledger; what it costs is said with it.") if repairs else
            prose("The ledger holds no repair."),
            *(_repair(entry) for entry in repairs),
        ]
    )
    return Chapter("theorem", "Theorem and repairs", "The theorem, what breaks, and the repairs", body)


def _growth(grown: Sequence[Growth], drawn: Drawn | None) -> list[Html]:
    if drawn is None:
        return []
    rises = [one for one in grown if one.rise > RISES]
    falls = [one for one in grown if one.rise <= RISES]
    sentences = [
        f"`{one.observer}`: V rises to {number(one.rise)} times an earlier value."
        + ("" if math.isnan(one.crossing) else f" At {1e3 * one.crossing:.1f} ms $\\hat{{\\omega}}$ passes zero, where (13) is "
           "not defined and V grows without bound.")
        for one in rises
    ]
    sentences += [f"`{one.observer}`: V never rises." for one in falls]
    return [
        prose("It shows along a trajectory, too. The scenario `lyapunov` of the study holds the speed constant and puts "
              "everything else of (13) right; V is computed from the run by the definitions that the ledger proves (for the "
              "repaired observer, its own V)."),
        figure(drawn.svg, drawn.caption, drawn.caption, drawn.file),
        answer(*sentences),
    ]


def item_of(entry: Entry) -> str:
    """The item that an entry belongs to: ``eq7`` for ``eq07.row3``."""
    return re.sub(r"^eq0+", "eq", entry.claim.id.split(".row")[0])


def belongs(entry: Entry, item: str) -> bool:
    """Whether an entry is the item or a part of it."""
    own = item_of(entry)
    return own == item or own.startswith(f"{item}.")


def _steps(entries: Sequence[Entry], items: Sequence[str], caption: str) -> Html:
    rows = [
        (tag("a", typeset(label(entry)), href=f"#{anchor(entry.claim.id)}"), typeset(entry.claim.title), badge(entry.verdict),
         typeset(entry.claim.edit))
        for item in items for entry in entries if belongs(entry, item)
    ]
    return table(("step", "says", "verdict", "correction"), rows, caption)


def _repair(entry: Entry) -> Html:
    claim = entry.claim
    title = tag("a", typeset(claim.title), href=f"#{anchor(claim.id)}")
    parts: list[object] = [tag("h4", title, Html(" "), badge(entry.verdict))]
    if claim.prose:
        parts.append(tag("p", typeset(claim.prose)))
    parts += [formula(relation_latex(parse_relation(text))) for text in (*claim.printed, *claim.corrected)]
    if claim.assumptions:
        parts.append(tag("p", Html("Assumes: "), typeset("; ".join(claim.assumptions)), Html(".")))
    if claim.note:
        parts.append(tag("p", typeset(claim.note)))
    return join(parts)
