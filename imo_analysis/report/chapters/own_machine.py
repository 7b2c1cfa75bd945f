"""The block on top of the first screen for a machine that is not the paper's: what works on it, and what would help."""

from __future__ import annotations

import math
from collections.abc import Sequence

from imo_analysis.report.metrics import Resting
from imo_analysis.report.modulation import Modulation
from imo_analysis.report.page import Html, inline, join, number, table, tag
from imo_analysis.report.scenarios import ExcitationResult, Scenario, outcome
from imo_analysis.report.words import typeset
from imo_analysis.simulation.summary import OFF, STRETCH
from imo_analysis.study import Study


def own_machine(
    study: Study, scenarios: Sequence[Scenario], results: Sequence[ExcitationResult], cured: Modulation | None
) -> Html:
    """A verdict on each observer, how it tracks in each run, whether alpha can be told from the speed, and what cures it."""
    head = ("run", "observer", "speed", "mean error at the end (rad/s)", "rms error there (rad/s)",
            "largest mean error (rad/s)", r"$\hat{\alpha} - \alpha$ (1/s)")
    rows = [row for scenario in scenarios for row in _rows(scenario)]
    return join(
        [
            tag("h2", "This machine", class_="sub"),
            tag("ul", *(tag("li", inline(line)) for line in verdicts(scenarios)), class_="verdicts"),
            table(head, rows, rf"{_alphas(study, scenarios)} Speeds are electrical. An estimate is judged by the last "
                              f"{STRETCH:g} s, or the last quarter of a shorter piece: it tracks where its mean error is below "
                              f"{100 * OFF:g} % of the speed. The largest is that of the stretches before each change of the "
                              "reference and before the end.", (3, 4, 5, 6)),
            tag("ul", *(tag("li", line) for line in (*_identifiable(results), _cure(cured)))),
        ]
    )


def _alphas(study: Study, scenarios: Sequence[Scenario]) -> str:
    """The true alpha, and the runs in which it is another one."""
    others = [f"{one.title}: {one.alpha:.4g} /s" for one in scenarios
              if math.isfinite(one.alpha) and not math.isclose(one.alpha, study.machine.alpha, rel_tol=1e-9)]
    return rf"$\alpha = {study.machine.alpha:.4g}$ /s" + (f" ({'; '.join(others)})." if others else ".")


def _ends(scenario: Scenario) -> list[Resting]:
    end = scenario.resting[-1].time
    return [one for one in scenario.resting if one.time == end]


def verdicts(scenarios: Sequence[Scenario]) -> list[str]:
    """A sentence on each observer: in how many runs it tracks, where it does not, and whether it drives."""
    lines = []
    for name in dict.fromkeys(one.observer for scenario in scenarios for one in _ends(scenario)):
        found = {scenario.title: outcome(one) for scenario in scenarios for one in _ends(scenario) if one.observer == name}
        fails = {title: said for title, said in found.items() if said != "tracks"}
        drives = [scenario.title for scenario in scenarios if scenario.driver == name]
        line = f"`{name}` tracks in {'all' if not fails else len(found) - len(fails) or 'none'} of {len(found)} runs"
        line += "".join(f"; it {said} in: {title}" for title, said in fails.items()) + "."
        lines.append(line + (f" It drives the machine in: {', '.join(drives)}." if drives else ""))
    return lines


def _rows(scenario: Scenario) -> list[tuple[object, ...]]:
    rows: list[tuple[object, ...]] = []
    for last in _ends(scenario):
        errors = [abs(one.omega - one.omega_hat) for one in scenario.resting if one.observer == last.observer]
        largest = math.nan if any(map(math.isnan, errors)) else max(errors)
        watches = scenario.driver not in ("", last.observer)
        rows.append((scenario.title, tag("code", last.observer), outcome(last) + (" (watches only)" if watches else ""),
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


def _cure(cured: Modulation | None) -> Html:
    where = tag("a", "the chapter on excitation", href="#excitation")
    if cured is None:
        return join(["What would cure it: no modulation of the flux was designed; the study has no observer of a kind for "
                     "which that is known (repaired, quiet), or modulates its flux already. See ", where, "."], "")
    if cured.design is None:
        return typeset(f"What would cure it: no modulation of the flux does it within the limits: {cured.refused}.")
    found = cured.design
    said = (f"What would cure it, for `{cured.observer}`: {100 * found.depth:.3g} % of modulation of the flux at "
            f"{found.frequency:.4g} rad/s, for {found.loss:.3g} W; the error of alpha then decays as exp(−{found.rate:.3g} t), "
            "t in s. Checked in closed loop in ")
    return join([inline(said), where, "."], "")
