"""Poles that were computed at neighbouring points, joined to continuous branches.

Branches are carried on from point to point along their tangents, by the assignment of least total distance from where the
tangents lead. Where an assignment is not clear (a pole misses its place by more than half of what the next candidate does)
points in between are computed until it is, down to a 4096th of a step; places that stay unclear, such as a double pole, are
counted. Stretches where every assignment is clear are joined all at once, to the same branches.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

_DEPTH = 12
_BUDGET = 48  # points between two neighbours, so that a double pole does not cost 2^12 of them
_BLOCK = 65_536  # points at a time, for memory
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
    beside = evaluate(np.array([near]))[0]
    beside = beside[_order(raw[0], beside)]
    branches[0], slope = raw[0], (beside - raw[0]) / (near - points[0])
    chain, clear = _chained(points, raw, walk.tolerance)
    breaks = np.append(np.flatnonzero(~clear), len(points))
    unclear, k, order = 0, 1, None
    while k < len(points):
        if order is not None and clear[k]:  # as the walk would join them, all at once
            stop = int(breaks[np.searchsorted(breaks, k)])
            branches[k:stop] = chain[k:stop][:, order]
            slope = (branches[stop - 1] - branches[stop - 2]) / (points[stop - 1] - points[stop - 2])
            k = stop
            continue
        walk.budget = _BUDGET
        branches[k], slope, failed = walk.join(branches[k - 1], slope, raw[k], points[k - 1], points[k], _DEPTH)
        unclear += failed
        order = _order(branches[k], chain[k])
        if walk.budget < _BUDGET or not np.array_equal(chain[k - 1][order], branches[k - 1]):
            order = None  # the slope is not that of the chain's last step, or the chain jumps here
        k += 1
    return Track(branches, unclear)


def _chained(points: np.ndarray, raw: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """The poles in the order of their nearest neighbours, and which steps are clear along the tangent of the step before.

    The first step counts as not clear: it has none before it.
    """
    chain, clear = raw.copy(), np.zeros(len(points), dtype=bool)
    here = np.arange(raw.shape[1])
    order = here
    for start in range(1, len(points), _BLOCK):
        after = raw[start:start + _BLOCK]
        before = raw[start - 1:start - 1 + len(after)]
        nearest = np.abs(before[:, :, None] - after[:, None, :]).argmin(axis=-1)
        changes = np.flatnonzero(np.any(nearest != here, axis=-1))
        ends = [*changes, len(after)]
        chain[start:start + ends[0]] = after[:ends[0]][:, order]
        for first, last in pairwise(ends):
            if np.array_equal(np.sort(nearest[first]), here):  # else two have one neighbour: not clear below
                order = nearest[first][order]
            chain[start + first:start + last] = after[first:last][:, order]
    for start in range(2, len(points), _BLOCK):
        at = np.arange(start, min(start + _BLOCK, len(points)))
        step = ((points[at] - points[at - 1]) / (points[at - 1] - points[at - 2]))[:, None]
        ahead = chain[at - 1] + (chain[at - 1] - chain[at - 2]) * step
        clear[at] = _clear(np.abs(ahead[:, :, None] - chain[at][:, None, :]), here, chain[at], tolerance)
    return chain, clear


def _order(wanted: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Where each wanted value stands in the other array, which holds the same ones."""
    from scipy.optimize import linear_sum_assignment

    return np.asarray(linear_sum_assignment(np.abs(wanted[:, None] - there[None, :]))[1])


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
        clear = bool(_clear(distance, chosen, after, self.tolerance))
        if clear or depth == 0 or self.budget == 0:
            return ordered, (ordered - before) / (x_1 - x_0), not clear
        self.budget -= 1
        middle = 0.5 * (x_0 + x_1)
        between = self.evaluate(np.array([middle]))[0]
        half, slope, first = self.join(before, slope, between, x_0, middle, depth - 1)
        ordered, slope, second = self.join(half, slope, after, middle, x_1, depth - 1)
        return ordered, slope, first or second


def _clear(distance: np.ndarray, chosen: np.ndarray, after: np.ndarray, tolerance: float) -> Any:
    """Whether every pole misses its predicted place by less than half of what any other value misses it by.

    ``distance`` has the shape ``(..., n, n)``, ``after`` ``(..., n)``; so has the answer, without the last axis.
    """
    rows = np.arange(len(chosen))
    moved = distance[..., rows, chosen]
    other = np.abs(after[..., None, :] - after[..., chosen][..., :, None]) > tolerance
    rival = np.where(other, distance, np.inf).min(axis=-1)
    return np.all((moved <= tolerance) | (moved < 0.5 * rival), axis=-1)
