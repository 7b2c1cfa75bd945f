"""What the paper says of its Figs 1-4 beside what the same runs give: only where the study has those runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from imo_analysis.paper.statements import ALPHA_FIGURE, ALPHA_FINAL, ALPHA_START, FIGURES
from imo_analysis.report.scenarios import Scenario
from imo_analysis.study import Study

PROPOSED = "consistent_12"  # the printed form for which the proof's terms cancel, and that runs
MUCH = 2.0  # times as large: much worse
DIGIT = 0.05  # half of the last printed digit of the end value, in 1/s


@dataclass(frozen=True)
class FigureClaim:
    """A figure's number, what the paper says of it, what the run here shows, and whether the two agree."""

    figure: int
    says: str
    here: str
    verdict: str


def figure_claims(scenarios: Sequence[Scenario], study: Study) -> list[FigureClaim]:
    """The claims on the figures that the study has as scenarios ``fig1`` to ``fig4``, with a baseline and the proposed one."""
    runs = {scenario.name: scenario for scenario in scenarios}
    baseline, proposed = (next((name for name, one in study.observers.items() if one.kind == kind), None)
                          for kind in ("baseline", PROPOSED))
    found = []
    if baseline is not None and proposed is not None:
        for figure in FIGURES:
            run = runs.get(f"fig{figure.number}")
            if run is not None and run.windows:
                found.append(_step(figure.number, figure.alpha_biased, run, baseline, proposed))
    last = runs.get(f"fig{ALPHA_FIGURE}")
    if last is not None and proposed is not None:
        found.append(_end(last, proposed, study))
    return found


def _step(number: int, biased: bool, run: Scenario, baseline: str, proposed: str) -> FigureClaim:
    """The window around a step of the speed: whose error is smaller, at its peak and in the mean."""
    window = run.windows[-1]
    one, other = ({response.observer: response for response in window.responses}[name] for name in (proposed, baseline))
    says = (f"with alpha off from the start ({ALPHA_START:g} /s), the baseline becomes much worse than the proposed observer"
            if biased else "the proposed observer follows better than the baseline")
    here = (f"largest error {one.peak:.3g} rad/s against {other.peak:.3g}, rms {one.rms:.3g} against {other.rms:.3g} rad/s "
            f"(`{proposed}` against `{baseline}`)")
    factor = MUCH if biased else 1.0
    better = [factor * mine < its for mine, its in ((one.peak, other.peak), (one.rms, other.rms))]
    return FigureClaim(number, says, here, "agrees" if all(better) else "in part" if any(better) else "does not agree")


def _end(run: Scenario, proposed: str, study: Study) -> FigureClaim:
    """Where alpha_hat ends, and what that hangs on."""
    bandwidth, alpha = study.drive.speed_bandwidth, study.machine.alpha
    chosen = bandwidth == Study.paper().drive.speed_bandwidth
    end = next(one.alpha_hat for one in reversed(run.resting) if one.observer == proposed)
    here = f"it ends at {end:.4g} /s" if math.isfinite(end) else "it is lost"
    here += ("; that depends on the drive, of which the paper prints nothing: " + (
        f"`speed_bandwidth = {bandwidth:g}` was chosen to give it" if chosen else f"here `speed_bandwidth = {bandwidth:g}`"))
    return FigureClaim(ALPHA_FIGURE, f"alpha_hat ends at {ALPHA_FINAL:g} /s, slightly off {alpha:.5g} /s", here,
                       "agrees" if abs(end - ALPHA_FINAL) <= DIGIT else "does not agree")
