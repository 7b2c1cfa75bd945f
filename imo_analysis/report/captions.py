"""Captions of a run's figures: what is drawn, how to read it, and what it shows, in the run's own numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from imo_analysis.excitation.conditions import CONDITIONS
from imo_analysis.report.metrics import Resting, StepResponse
from imo_analysis.report.numbers import number

if TYPE_CHECKING:
    from imo_analysis.report.drift import DriftRow
    from imo_analysis.study_tables import Window


def at_end(states: Sequence[Resting]) -> list[Resting]:
    """The states at the last time of a run."""
    return [one for one in states if one.time == states[-1].time]


def _listed(values: Iterable[tuple[str, float, str]], sign: bool = False) -> str:
    """Names with their numbers and units; NaN means that the estimate is lost."""
    return ", ".join(f"`{name}` " + ("lost" if math.isnan(value) else f"{number(value, sign=sign)}{unit}")
                     for name, value, unit in values)


def whole_speed(states: Sequence[Resting], gone: Sequence[str], noisy: bool) -> str:
    """Of the speed over a whole run."""
    ends = _listed(((one.observer, one.omega - one.omega_hat, " rad/s") for one in at_end(states)), sign=True)
    left = f" The error of {', '.join(f'`{name}`' for name in gone)} leaves the axes." if gone else ""
    bars = " Of a noisy line: the mean, with bars from the lowest to the highest value." if noisy else ""
    return ("Above: speed, true and estimated; short peaks may leave the axes. Below: the error of each estimate. At the end "
            f"it is, in the mean: {ends}.{left}{bars}")


def part_speed(window: Window, responses: Sequence[StepResponse], gone: Sequence[str]) -> str:
    """Of the speed in a window: the largest errors, the smallest first."""
    order = sorted(responses, key=lambda one: math.inf if math.isnan(one.peak) else one.peak)
    left = f"; the error of {', '.join(f'`{name}`' for name in gone)} leaves the axes" if gone else ""
    said = f": {window.caption}" if window.caption else ""
    return (f"{window.title[:1].upper()}{window.title[1:]}, {window.start:g} to {window.stop:g} s"
            f"{said}. Largest error of the speed: {_listed((one.observer, one.peak, ' rad/s') for one in order)}{left}.")


def alpha(states: Sequence[Resting], true: float) -> str:
    """Of the estimates of alpha."""
    ends = [one for one in at_end(states) if not math.isnan(one.alpha_hat)]
    off = {one.observer: number(100 * (one.alpha_hat / true - 1), 2, sign=True) for one in ends}
    listed = ", ".join(f"`{one.observer}` {number(one.alpha_hat)} /s ({off[one.observer]} %)" for one in ends)
    said = f"at the end: {listed or 'lost'}; the machine has {number(true, 4)} /s"
    return f"The estimate of alpha, with the true value, and the speed below it; {said}."


def drift(title: str, rows: Sequence[DriftRow]) -> str:
    """Of alpha_hat beside its predictions."""
    last = {row.observer: row for row in rows}
    listed = "; ".join(f"`{name}` {row.end:.2f}, {row.start + row.step_from_motion:.2f} and {row.from_study:.2f} /s"
                       for name, row in last.items())
    return (f"{title}: the estimate of alpha, simulated, predicted from the motion of the machine (dots), and from the study "
            f"alone (crosses), as the chapter on excitation explains. In this order, at the end: {listed}.")


def flux(states: Sequence[Resting]) -> str:
    """Of the flux error."""
    ends = _listed((one.observer, 100 * one.flux_error, " %") for one in at_end(states))
    return f"Length of the error of the estimated rotor flux, relative to the flux. At the end: {ends}."


def excitation(title: str, subject: str, found: dict[str, Any]) -> str:
    """Of the eigenvalues of the Gram matrices along a run."""
    held = "; ".join(f"{CONDITIONS[name].title}: in {one['holding']} of {one['windows']} windows"
                     for name, one in found["conditions"].items())
    return (f"{title}; {subject}: eigenvalues of the scaled Gram matrix over windows of {number(found['window'])} s. Grey: the "
            f"smallest is above the threshold, and every direction is excited. {held}.")
