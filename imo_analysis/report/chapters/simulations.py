"""The chapter with the runs of Figs 1-4 and the two z feedbacks that diverge as printed."""

from __future__ import annotations

import math
from collections.abc import Sequence

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.notation import symbol
from imo_analysis.report.figure_claims import figure_claims
from imo_analysis.report.metrics import BAND, Resting
from imo_analysis.report.own import meaning
from imo_analysis.report.page import Chapter, Html, answer, beside, figure, inline, join, number, prose, table, tag
from imo_analysis.report.paper_machine import is_paper
from imo_analysis.report.scenarios import Divergence, Scenario, at_end, not_drawn, outcome
from imo_analysis.report.words import typeset
from imo_analysis.simulation.summary import STRETCH
from imo_analysis.study import Study

Z_FEEDBACKS = ("printed_7", "printed_L", "consistent_12")  # kinds that differ in nothing else


_NOT_PRINTED = "The paper prints neither its gains nor its whole speed profile. "


def simulations_chapter(study: Study, scenarios: Sequence[Scenario], divergences: Sequence[Divergence]) -> Chapter:
    """Every scenario of the study: the run, its windows, and the numbers of both."""
    papers = is_paper(study.machine)
    observers = [
        (name, typeset(meaning(one.kind)), OBSERVERS[one.kind].source,
         inline(", ".join(f"${symbol(gain).latex} = {value:g}$" for gain, value in one.gains.items())))
        for name, one in study.observers.items()
    ]
    body = join(
        [
            prose(
                r"""
The machine (1) and field-oriented control on measured speed, unless a scenario of the study says otherwise (a drive's
imperfections, feedback from an observer), and every observer side by side on the same measurements. The
functions that are compiled for these runs are the ones that the ledger proves. """ + (_NOT_PRINTED if papers else "") + """What
is used here is in the study file beside this page, and each figure can be made again with the command under it. Speeds are
electrical.
"""
            ),
            table(("name", "what it is", "printed in", "gains (SI units)"), observers, "Observers of the study"),
            *(_claims(scenarios, study) if papers else ()),
            *(_scenario(scenario, papers) for scenario in scenarios),
            *_divergences(study, divergences),
            *_others(not_drawn(study)),
        ]
    )
    return Chapter("simulations", "Simulations", "Simulations", body)


def _scenario(scenario: Scenario, papers: bool) -> Html:
    """One run; of one's own machine the speed, and a window of it where an estimate does not track: the page stays small."""
    parts: list[object] = [tag("h3", typeset(scenario.titled[:1].upper() + scenario.titled[1:]))]
    if scenario.fault:
        parts.append(answer(typeset(scenario.fault)))
    calm = all(outcome(one) == "tracks" for one in at_end(scenario))
    shown = len(scenario.figures) if papers else 1 if calm else 2
    parts += [figure(drawn.svg, drawn.caption, drawn.caption, drawn.file) for drawn in scenario.figures[:shown]]
    if scenario.figures[shown:]:
        parts.append(beside("More figures of this run:", [drawn.file for drawn in scenario.figures[shown:]]))
    for window in scenario.windows:
        rows = [
            (one.observer, number(one.peak), number(one.rms),
             "not in the window" if math.isnan(one.settled) else number(1e3 * one.settled))
            for one in window.responses
        ]
        head = ("observer", "largest speed error (rad/s)", "rms speed error (rad/s)",
                f"error within {100 * BAND:g} % of the change of speed for good, from the start of the window (ms)")
        parts.append(table(head, rows, f"{window.title}: {window.start:g} to {window.stop:g} s", (1, 2, 3)))
    parts.append(_resting(scenario.resting))
    parts.append(tag("p", tag("code", scenario.command), class_="note"))
    return join(parts)


def _resting(states: Sequence[Resting]) -> Html:
    rows = [
        (f"{one.time:.2f}", f"{round(one.omega, 2) + 0.0:.2f}", one.observer, number(one.omega - one.omega_hat, sign=True),
         number(one.alpha_hat, 5), _percent(one.flux_error), _percent(one.z_error), _percent(one.xi_error))
        for one in states
    ]
    head = ("time (s)", "speed (rad/s)", "observer", "speed error (rad/s)", r"$\hat{\alpha}$ (1/s)", "flux error",
            r"$\tilde{z}$", r"$\tilde{\xi}$")
    return table(head, rows, f"Before each change of the reference and at the end: means of the last {STRETCH:g} s, or of "
                             "the last quarter of a shorter piece", (0, 1, 3, 4, 5, 6, 7))


def _percent(value: float) -> str:
    return "–" if math.isnan(value) else f"{number(100 * value, 2)} %"


def _others(names: Sequence[str]) -> list[object]:
    if not names:
        return []
    listed = join((tag("code", f"imo simulate study.toml --scenario {name}") for name in names), ", ")
    return [tag("p", Html("Scenarios of the study without <code>[[windows]]</code> are not drawn here; to run them: "), listed,
                Html("."), class_="note")]


def _claims(scenarios: Sequence[Scenario], study: Study) -> list[object]:
    """What the paper says of its figures beside what the same runs give here."""
    compared = figure_claims(scenarios, study)
    if not compared:
        return []
    rows = [(f"Fig. {one.figure}", typeset(one.says), typeset(one.here), one.verdict) for one in compared]
    return [tag("h3", "What the paper says of its figures"),
            table(("figure", "the paper says", "here", ""), rows,
                  "Beside the same runs with this study's gains, which the paper does not print")]


def _same_terms(study: Study) -> str:
    """Whether the observers of the scenario ``divergence`` have the same gains, in a sentence."""
    chosen = study.scenario("divergence")
    printed = [one for name, one in chosen.observers.items() if one.kind in Z_FEEDBACKS]
    first = printed[0] if printed else None
    same = first is not None and all(one.gains == first.gains for one in printed)
    return "the same gains and on the same measurements" if same else "the gains of its own and on the same measurements"


def _divergences(study: Study, divergences: Sequence[Divergence]) -> list[object]:
    if not divergences:
        return []
    parts: list[object] = [
        tag("h3", "The z feedbacks as printed"),
        prose(
            r"""
The paper prints the feedback of the z loop in three ways: in (7) and the expanded (8), in the matrix $L(\hat{\omega})$, and in
the error dynamics (12). """ + f"Those that the study has are run here with {_same_terms(study)}."
        ),
    ]
    rows = [(one.observer, typeset(one.source), one.outcome) for one in divergences]
    parts.append(table(("observer", "what it is", "what happens"), rows))
    lost = [one.observer for one in divergences if one.diverged]
    if lost:
        parts.append(answer(
            f"Lost: {', '.join(f'`{name}`' for name in lost)}. What the observer does is to lose the speed and not to find it "
            "again; the overflow later is that of the integrator at this step, and says nothing more." + _stay(divergences)))
    return parts


def _stay(divergences: Sequence[Divergence]) -> str:
    """Of the observers that do not overflow, those that have the speed at the end, and those that do not."""
    rest = [one for one in divergences if not one.diverged]
    right, wrong = ([f"`{one.observer}`" for one in rest if one.off is off] for off in (False, True))
    parts = ([f"{', '.join(right)} {'stays' if len(right) == 1 else 'stay'}"] if right else [])
    if wrong:
        parts.append(f"{', '.join(wrong)} {'is' if len(wrong) == 1 else 'are'} off the speed at the end without overflowing")
    return f" {'; '.join(parts)}." if parts else ""
