"""Poles that were computed at neighbouring points, joined to continuous branches.

Branches are carried on from point to point along their tangents, by the assignment of least total distance from where the
tangents lead. Where an assignment is not clear (a pole misses its place by more than half of what the next candidate does)
points in between are computed until it is, down to a 4096th of a step; places that stay unclear, such as a double pole, are
counted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

_DEPTH = 12
_BUDGET = 48  # points between two neighbours, so that a double pole does not cost 2^12 of them
SAME = 1e-9  # of the largest pole: closer than this, two poles are one


@dataclass(frozen=True)
class Track:
    """Poles with continuous branches: ``branches`` of shape (points, n), and how many steps stayed unclear."""

    branches: np.ndarray
    unclear: int


def track(points: np.ndarray, evaluate: Callable[[Any], np.ndarray]) -> Track:
    """Join the poles of neighbouring points to branches, with more points where that is not clear."""
    raw = evaluate(points)
    if len(points) == 1:
        return Track(raw, 0)
    walk = _Walk(evaluate, SAME * float(np.abs(raw).max()))
    branches = np.empty_like(raw)
    near = points[0] + (points[1] - points[0]) / 1024
    beside = _nearest(raw[0], evaluate(np.array([near]))[0])
    branches[0], slope = raw[0], (beside - raw[0]) / (near - points[0])
    unclear = 0
    for k in range(1, len(points)):
        walk.budget = _BUDGET
        branches[k], slope, failed = walk.join(branches[k - 1], slope, raw[k], points[k - 1], points[k], _DEPTH)
        unclear += failed
    return Track(branches, unclear)


def _nearest(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    from scipy.optimize import linear_sum_assignment

    return np.asarray(after[linear_sum_assignment(np.abs(before[:, None] - after[None, :]))[1]])


@dataclass
class _Walk:
    """Carries branches from one point to the next; ``budget`` is how many points in between it may still compute."""

    evaluate: Callable[[Any], np.ndarray]
    tolerance: float
    budget: int = 0

    def join(
        self, before: np.ndarray, slope: np.ndarray, after: np.ndarray, x_0: float, x_1: float, depth: int
    ) -> tuple[np.ndarray, np.ndarray, bool]:
        """``after`` in the order of ``before``, the slopes there, and whether the order stayed unclear somewhere."""
        from scipy.optimize import linear_sum_assignment

        distance = np.abs((before + slope * (x_1 - x_0))[:, None] - after[None, :])
        chosen = linear_sum_assignment(distance)[1]
        ordered = after[chosen]
        clear = _clear(distance, chosen, after, self.tolerance)
        if clear or depth == 0 or self.budget == 0:
            return ordered, (ordered - before) / (x_1 - x_0), not clear
        self.budget -= 1
        middle = 0.5 * (x_0 + x_1)
        between = self.evaluate(np.array([middle]))[0]
        half, slope, first = self.join(before, slope, between, x_0, middle, depth - 1)
        ordered, slope, second = self.join(half, slope, after, middle, x_1, depth - 1)
        return ordered, slope, first or second


def _clear(distance: np.ndarray, chosen: np.ndarray, after: np.ndarray, tolerance: float) -> bool:
    """Whether every pole misses its predicted place by less than half of what any other value misses it by."""
    rows = np.arange(len(chosen))
    moved = distance[rows, chosen]
    other = np.abs(after[None, :] - after[chosen][:, None]) > tolerance
    rival = np.where(other, distance, np.inf).min(axis=1)
    return bool(np.all((moved <= tolerance) | (moved < 0.5 * rival)))
