"""The block on top of the first screen for a machine that is not the paper's: which observer works, how far off, and why."""

from __future__ import annotations

import math
from collections.abc import Sequence

from imo_analysis.report.metrics import Resting
from imo_analysis.report.modulation import Modulation
from imo_analysis.report.own import Cured, Standing, run_of
from imo_analysis.report.page import Html, answer, inline, join, number, table, tag
from imo_analysis.report.scenarios import ExcitationResult, Scenario, judged, outcome
from imo_analysis.report.words import typeset
from imo_analysis.simulation.judge import STRETCH, criterion, size, spared
from imo_analysis.study import Study


def own_machine(
    study: Study, scenarios: Sequence[Scenario], found: Sequence[Standing], said: tuple[Sequence[str], Sequence[str]],
    results: Sequence[ExcitationResult], cured: Modulation | None, tried: Sequence[Cured] = (),
) -> Html:
    """What to take and why, a verdict on each observer, its errors in each run, and what a modulation of the flux cures.

    Parameters
    ----------
    study : Study
    scenarios : sequence of Scenario
    found : sequence of Standing
        Best first.
    said : tuple of 2 sequence of str
        `imo_analysis.report.own.advice` and `imo_analysis.report.own.verdicts`.
    results : sequence of ExcitationResult
    cured : Modulation, optional
    tried : sequence of Cured
        The runs in which its observer is off, with the modulation.
    """
    order = [one.observer for one in found]
    advice, verdicts = said
    where = tag("a", "the chapter on a drive as it is", href="#drive")
    return join(
        [
            answer(*(typeset(line) for line in advice)),
            tag("h2", "Observer by observer, best first", class_="sub"),
            tag("ol", *(tag("li", typeset(line)) for line in verdicts), class_="verdicts"),
            tag("p", "Ordered by the share of the points of the map at which the loop closed on it holds, in ", where,
                "; then by the runs in which it tracks. Where it does not hold, small differences of the way there decide "
                "how far off the speed ends.", class_="note"),
            _errors(study, scenarios, order),
            tag("details", tag("summary", "The same runs in more numbers"), _table(study, scenarios, order), class_="more"),
            tag("p", _cure(cured, tried, study.machine.n_p)),
            tag("details", tag("summary", "Whether the rotor's parameter can be told apart from the speed, run by run"),
                tag("ul", *(tag("li", line) for line in _identifiable(results))), class_="more"),
        ]
    )


def _errors(study: Study, scenarios: Sequence[Scenario], order: Sequence[str]) -> Html:
    """The mean error at the end of each run, an observer a column."""
    rows = []
    for scenario in scenarios:
        ends = {one.observer: one for one in judged(scenario)}
        easier, _ = spared(run_of(study, scenario))
        row: list[object] = [_title(scenario)]
        for name in order:
            one = ends.get(name)
            watches = not scenario.driven and scenario.driver not in ("", name)
            remark = (" (watches)" if watches else "") + (" (with the right parameters)" if name in easier else "")
            row.append("–" if one is None else _cell(one, study.machine.n_p) + remark)
        rows.append(row)
    return table(("run", *(f"`{name}`" for name in order)), rows,
                 "Where the estimates end: whether it tracks, and its mean error in rad/s, electrical, in % of the "
                 f"speed, and in r/min of the shaft. It tracks where that is within {criterion()}." + _each(scenarios))


def _each(scenarios: Sequence[Scenario]) -> str:
    """How a run is to be read that every observer drove once, if there is one."""
    drawn = next((one.driver for one in scenarios if one.driven), "")
    return drawn and (" A run “driven by each” was made once with each observer as the one whose estimates drive the machine. "
                      "It holds if its estimate tracks and the machine ends as close to the wanted speed; the error is the "
                      f"larger of both. Drawn below is the one that `{drawn}` drives.")


def _title(scenario: Scenario) -> Html:
    """The run, and whose estimate drives in it."""
    return typeset(f"{scenario.title}, driven by each" if scenario.driven else scenario.titled)


def _word(one: Resting) -> str:
    """The outcome; of an estimate that drives, whether it holds."""
    said = outcome(one)
    return said if math.isnan(one.wanted) else {"tracks": "holds", "is off": "does not hold"}.get(said, said)


def _cell(one: Resting, n_p: int) -> str:
    said = _word(one)
    return said if said == "is lost" else f"{said.removeprefix('is ')}, {size(one.error, one.omega, n_p)}"


def _table(study: Study, scenarios: Sequence[Scenario], order: Sequence[str]) -> Html:
    head = ("run", "observer", "speed", "mean error at the end (rad/s)", "rms error there (rad/s)",
            "largest mean error (rad/s)", r"$\hat{\alpha} - \alpha$ (1/s)")
    rows = [row for scenario in scenarios for row in _rows(scenario, order)]
    return table(head, rows, rf"{_alphas(study, scenarios)} Speeds are electrical. An estimate is judged by the last "
                             f"{STRETCH:g} s, or the last quarter of a shorter piece. The largest is that of the stretches "
                             "before each change of the reference and before the end.", (3, 4, 5, 6))


def _alphas(study: Study, scenarios: Sequence[Scenario]) -> str:
    """The true alpha, and the runs in which it is another one."""
    others = [f"{one.title}: {one.alpha:.4g} /s" for one in scenarios
              if math.isfinite(one.alpha) and not math.isclose(one.alpha, study.machine.alpha, rel_tol=1e-9)]
    return rf"$\alpha = {study.machine.alpha:.4g}$ /s" + (f" ({'; '.join(others)})." if others else ".")


def _rows(scenario: Scenario, order: Sequence[str]) -> list[tuple[object, ...]]:
    rows: list[tuple[object, ...]] = []
    for last in sorted(judged(scenario), key=lambda one: order.index(one.observer)):
        errors = [abs(one.error) for one in scenario.driven or scenario.resting if one.observer == last.observer]
        largest = math.nan if any(map(math.isnan, errors)) else max(errors)
        watches = not scenario.driven and scenario.driver not in ("", last.observer)
        rows.append((_title(scenario), tag("code", last.observer), _word(last) + (" (watches only)" if watches else ""),
                     number(errors[-1]), number(last.rms), number(largest), number(last.alpha_hat - scenario.alpha, sign=True)))
    return rows


def _identifiable(results: Sequence[ExcitationResult]) -> list[Html]:
    """The reduced condition along each run, in a sentence."""
    lines = []
    for result in results:
        one = result.summary["conditions"].get("reduced")
        if one is None:
            continue
        share = one["holding"] / one["windows"] if one["windows"] else 0.0
        can = "can" if share > 0.5 else "cannot" if share < 0.05 else "can only at times"
        why = f" Mostly lost: {one['lost'][0]['text']}." if one["lost"] else ""
        lines.append(typeset(f"{result.title}: alpha {can} be told apart from the speed: the condition for it holds in "
                             f"{one['holding']} of {one['windows']} windows.{why}"))
    return lines or [inline("No run is long enough for a window of the excitation conditions.")]


def _cure(cured: Modulation | None, tried: Sequence[Cured], n_p: int) -> Html:
    where = tag("a", "the chapter on excitation", href="#excitation")
    if cured is None:
        return join(["A modulation of the flux, which makes alpha identifiable, was not designed; the study has no observer of",
                     " a kind for which that is known (repaired, quiet), or modulates its flux already. See ", where, "."], "")
    if cured.design is None:
        return typeset(f"No modulation of the flux makes alpha identifiable within the limits: {cured.refused}.")
    found = cured.design
    said = (f"A modulation of the flux makes alpha identifiable for `{cured.observer}`; a wrong stator resistance stays. "
            f"{100 * found.depth:.3g} % at {found.frequency:.4g} rad/s does, for {found.loss:.3g} W; with right parameters the "
            f"error of alpha then decays as exp(−{found.rate:.3g} t), t in s. {tried_on(cured.observer, tried, n_p)} More in ")
    return join([typeset(said), where, "."], "")


def tried_on(observer: str, tried: Sequence[Cured], n_p: int) -> str:
    """What the modulation does to the runs in which the observer is off, in sentences."""
    if not tried:
        return f"`{observer}` tracks in every run without it."
    groups: dict[bool, list[str]] = {True: [], False: []}
    for one in tried:
        groups[outcome(one.after) == "tracks"].append(f"“{one.title}” ({_from(one.before, n_p)} to {_from(one.after, n_p)})")
    lines = [f"With it `{observer}` tracks in {' and '.join(groups[True])}." if groups[True] else "",
             f"It does not cure {' nor '.join(groups[False])}." if groups[False] else ""]
    return " ".join(line for line in lines if line)


def _from(end: Resting, n_p: int) -> str:
    return "lost" if outcome(end) == "is lost" else size(end.error, end.omega, n_p).split(" (")[0]
