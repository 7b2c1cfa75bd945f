"""Where stability ends: the values of a swept parameter at which a pole crosses the imaginary axis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.pencils.branches import SAME, track
from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.pencils.setup import Setup
from imo_analysis.pencils.sweep import SweptKind, axes, evaluator


def stability_boundaries(
    observer: Setup, over: Mapping[str, Any], point: OperatingPoint | None = None, kind: SweptKind = "frozen"
) -> list[dict[str, float]]:
    """Where a pole crosses the imaginary axis, to 1e-9 of the value.

    Crossings are looked for between neighbouring values, on tracked branches, and then halved in as far as floating point
    goes; what remains is the rounding of the pole. A branch that stays on the axis by structure is not counted; two crossings
    within one step are missed: use a finer sweep.

    Parameters
    ----------
    observer, over, point, kind
        As in `imo_analysis.pencils.sweep.pole_sweep`, with one parameter.

    Returns
    -------
    list of dict
        Keys ``value`` (of what is swept), ``im`` (rad/s, of the pole there), ``branch`` and ``direction`` (+1 when it becomes
        unstable with rising value), in the order of the sweep.
    """
    swept = axes(over)
    if len(swept) != 1:
        raise InputError("boundaries are looked for along one parameter; stability_map finds those over two")
    (name, points), = swept.items()
    evaluate = evaluator(observer.machine, observer.observer, observer.gains, name, point, kind).moving
    roots = track(points, evaluate).branches
    tolerance = SAME * float(np.abs(roots).max())
    side = np.where(np.abs(roots.real) <= tolerance, 0, np.sign(roots.real))
    found = []
    for branch in range(roots.shape[1]):
        off = np.flatnonzero(side[:, branch])  # a value where the pole is on the axis lies between its neighbours
        for k, m in pairwise(off):
            if side[k, branch] * side[m, branch] < 0 and m - k <= 2:
                crossing = _crossing(evaluate, (points[k], points[m]), (roots[k, branch], roots[m, branch]))
                if crossing is None:
                    continue
                value, pole = crossing
                found.append({"value": value, "im": float(pole.imag), "branch": branch + 1,
                              "direction": float(side[m, branch])})
    return sorted(found, key=lambda crossing: crossing["value"])


def _crossing(
    evaluate: Callable[[Any], np.ndarray], ends: tuple[float, float], poles_there: tuple[complex, complex]
) -> tuple[float, complex] | None:
    """Halve the step in which one branch crosses the axis; at each point the branch is the pole nearest to its chord.

    Where branches were swapped within the step the chord leads astray, to a place with as many unstable poles on either side.
    Then it is their number that is followed; None where that is the same at both ends.
    """
    left, right = poles_there

    def on_the_left(middle: float) -> bool:
        nonlocal left, right
        candidates = evaluate(np.array([middle]))[0]
        pole = candidates[np.argmin(np.abs(candidates - 0.5 * (left + right)))]
        if same := bool(np.sign(pole.real) == np.sign(left.real)):
            left = pole
        else:
            right = pole
        return same

    low, high = _halved(ends, on_the_left)
    if _unstable(evaluate, low) != _unstable(evaluate, high):
        return 0.5 * (low + high), left
    before = _unstable(evaluate, ends[0])
    if before == _unstable(evaluate, ends[1]):
        return None
    low, high = _halved(ends, lambda middle: _unstable(evaluate, middle) == before)
    there = evaluate(np.array([low]))[0]
    return 0.5 * (low + high), there[np.argmin(np.abs(there.real))]


def _halved(ends: tuple[float, float], on_the_left: Callable[[float], bool]) -> tuple[float, float]:
    """The interval halved as far as floating point goes."""
    low, high = map(float, ends)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if on_the_left(middle) else (low, middle)
    return low, high


def _unstable(evaluate: Callable[[Any], np.ndarray], value: float) -> int:
    return int(np.sum(evaluate(np.array([value]))[0].real > 0))
