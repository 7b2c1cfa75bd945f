"""The block on top of the first screen for a machine that is not the paper's: what works on it, and what would help."""

from __future__ import annotations

import math
from collections.abc import Sequence

from imo_analysis.report.modulation import Modulation
from imo_analysis.report.page import Html, inline, join, number, table, tag
from imo_analysis.report.scenarios import OFF, ExcitationResult, Scenario
from imo_analysis.report.words import typeset
from imo_analysis.study import Study


def own_machine(
    study: Study, scenarios: Sequence[Scenario], results: Sequence[ExcitationResult], cured: Modulation | None
) -> Html:
    """Whether each observer tracks in each run, whether alpha can be told from the speed there, and what would cure it."""
    head = ("run", "observer", "speed", "error at the end (rad/s)", "largest error (rad/s)", r"$\hat{\alpha} - \alpha$ (1/s)")
    rows = [row for scenario in scenarios for row in _rows(scenario)]
    return join(
        [
            tag("h2", "This machine", class_="sub"),
            table(head, rows, rf"{_alphas(study, scenarios)} The largest error is that of the instants just "
                              "before each change of the reference and of the end.", (3, 4, 5)),
            tag("ul", *(tag("li", line) for line in (*_identifiable(results), _cure(cured)))),
            tag("h2", "The paper", class_="sub"),
        ]
    )


def _alphas(study: Study, scenarios: Sequence[Scenario]) -> str:
    """The true alpha, and the runs in which it is another one."""
    others = [f"{one.title}: {one.alpha:.4g} /s" for one in scenarios
              if math.isfinite(one.alpha) and not math.isclose(one.alpha, study.machine.alpha, rel_tol=1e-9)]
    return rf"$\alpha = {study.machine.alpha:.4g}$ /s" + (f" ({'; '.join(others)})." if others else ".")


def _rows(scenario: Scenario) -> list[tuple[object, ...]]:
    end = scenario.resting[-1].time
    rows: list[tuple[object, ...]] = []
    for last in (one for one in scenario.resting if one.time == end):
        errors = [abs(one.omega - one.omega_hat) for one in scenario.resting if one.observer == last.observer]
        largest = math.nan if any(map(math.isnan, errors)) else max(errors)
        rows.append((scenario.title, tag("code", last.observer), verdict(errors[-1], last.omega), number(errors[-1]),
                     number(largest), number(last.alpha_hat - scenario.alpha, sign=True)))
    return rows


def verdict(error: float, omega: float) -> str:
    """Whether an estimate is that speed at the end: ``tracks``, ``is off`` or ``is lost``."""
    if math.isnan(error):
        return "is lost"
    return "tracks" if error <= OFF * max(abs(omega), 1.0) else "is off"


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
