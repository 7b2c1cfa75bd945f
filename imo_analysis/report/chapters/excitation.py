"""The chapter on persistence of excitation: can this drive tell alpha and speed apart along these runs?"""

from __future__ import annotations

from collections.abc import Sequence

from imo_analysis.excitation.conditions import CONDITIONS
from imo_analysis.report.page import Chapter, Html, figure, inline, join, prose, table, tag
from imo_analysis.report.scenarios import ExcitationResult


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
            *(_result(result) for result in results),
            *more,
        ]
    )
    return Chapter("excitation", "Excitation", "Excitation and identifiability", body)


def _result(result: ExcitationResult) -> Html:
    rows = []
    for name, one in result.summary["conditions"].items():
        lost = "; ".join(f"{where['text']} ({100 * where['share']:.3g} % of the windows)" for where in one["lost"][:4])
        rows.append((CONDITIONS[name].title, f"{len(one['states'])}", f"{one['rank']['lowest']} to {one['rank']['highest']}",
                     f"{one['holding']} of {one['windows']}", lost or "none"))
    sentences = [line.strip() for line in result.summary["verdict"].splitlines()]
    head = ("condition", "size", "rank", "windows in which it holds", "directions that are lost")
    return join(
        [
            tag("h3", result.title),
            tag("div", *(tag("p", inline(f"{line[0].upper()}{line[1:]}")) for line in sentences), class_="answer"),
            table(head, rows),
            figure(result.figure.svg, result.figure.caption, result.figure.caption, result.figure.file),
            tag("p", f"Scaling: {result.summary['scaling']}. Threshold: {result.summary['threshold']:g} of the largest.", class_="note"),
        ]
    )
