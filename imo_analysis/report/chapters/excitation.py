"""The chapter on persistence of excitation: can this drive tell alpha and speed apart along these runs?"""

from __future__ import annotations

from collections.abc import Sequence

from imo_analysis.excitation.conditions import CONDITIONS
from imo_analysis.report.page import Chapter, Html, figure, join, prose, table, tag
from imo_analysis.report.scenarios import ExcitationResult
from imo_analysis.report.words import typeset


def excitation_chapter(results: Sequence[ExcitationResult], more: Sequence[Html] = ()) -> Chapter:
    """Verdicts along the runs, with eigenvalues and lost directions.

    Parameters
    ----------
    results : sequence of ExcitationResult
    more : sequence of Html
        Further sections: maps, the explanation of the end value of alpha_hat, the design.
    """
    body = join(
        [
            prose(
                r"""
The speed and alpha estimates converge only if the signals of the drive excite every direction of the unknown errors. The paper
asks for that with (19): the Gram matrix $\int_t^{t+T} B^{*T} B^{*} \, d\tau$ of six error components must stay above a positive
level in every window. Here it is computed along the runs above, together with the reduced condition on the four components
that the outputs can show: $w = \alpha \tilde{\xi} - \mathrm{j} \omega \tilde{z}$ (two), $\tilde{\alpha}$ and $\tilde{\omega}$.

The columns are scaled to pure numbers of like size; a direction is lost in a window when its eigenvalue is below the
threshold. The scaling and the threshold stand with each result.
"""
            ),
            _overview(results),
            *(_result(result) for result in results),
            *more,
        ]
    )
    return Chapter("excitation", "Excitation", "Excitation and identifiability", body)


def _overview(results: Sequence[ExcitationResult]) -> Html:
    rows = []
    for result in results:
        for name, one in result.summary["conditions"].items():
            lost = join((tag("p", typeset(f"{where['text']} ({_share(where['share'])})")) for where in one["lost"][:3]), "")
            low, high = one["rank"]["lowest"], one["rank"]["highest"]
            rank = f"{low}" if low == high else f"{low} to {high}"
            rows.append((result.title, CONDITIONS[name].title, f"{rank} of {len(one['states'])}",
                         f"{one['holding']} of {one['windows']}", lost or "none"))
    head = ("run", "condition", "rank", "holds in windows", "directions that are lost (share of the windows)")
    return table(head, rows, "The verdicts along the runs")


def _share(share: float) -> str:
    return "all" if share == 1 else f"{100 * share:.3g} %"


def _result(result: ExcitationResult) -> Html:
    window = f"windows of {result.summary['window']:g} s every {result.summary['every']:g} s"
    note = f"{result.summary['scaling']}; threshold {result.summary['threshold']:g} of the largest; {window}."
    shown = figure(result.figure.svg, result.figure.caption, result.figure.caption, result.figure.file)
    return tag("details", tag("summary", typeset(f"Eigenvalues over time: {result.title}")), shown,
               tag("p", typeset(note), class_="note"), class_="more", open="" if result.open else None)
