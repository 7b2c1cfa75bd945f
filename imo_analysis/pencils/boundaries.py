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
                value, pole = _crossing(evaluate, (points[k], points[m]), (roots[k, branch], roots[m, branch]))
                found.append({"value": value, "im": float(pole.imag), "branch": branch + 1,
                              "direction": float(side[m, branch])})
    return sorted(found, key=lambda crossing: crossing["value"])


def _crossing(
    evaluate: Callable[[Any], np.ndarray], ends: tuple[float, float], poles_there: tuple[complex, complex]
) -> tuple[float, complex]:
    """Halve the step in which one branch crosses the axis; at each point the branch is the pole nearest to its chord."""
    (low, high), (left, right) = ends, poles_there
    for _ in range(60):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        candidates = evaluate(np.array([middle]))[0]
        pole = candidates[np.argmin(np.abs(candidates - 0.5 * (left + right)))]
        if np.sign(pole.real) == np.sign(left.real):
            low, left = middle, pole
        else:
            high, right = middle, pole
    return float(0.5 * (low + high)), left
