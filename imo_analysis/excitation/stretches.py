"""A record in stretches: where samples are missing, no window joins what was before with what comes after."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Batch:
    """Some cells of the stretches, in order, none of them across a gap.

    Attributes
    ----------
    part : slice
        Of the samples, from the first cell to the last.
    pick : ndarray of int, or None
        Which of these samples are in the cells; None for all of them.
    stretch : ndarray of int, shape (cells,)
        Number of the stretch of each cell.
    place : ndarray of int, shape (cells,)
        Number of each cell in its stretch.
    """

    part: slice
    pick: Indices | None
    stretch: Indices
    place: Indices


@dataclass(frozen=True)
class Stretches:
    """Stretches of evenly spaced samples.

    Attributes
    ----------
    first, length : ndarray of int, shape (stretches,)
        First sample and number of samples of each.
    start : ndarray, shape (stretches,)
        Time of the first sample in s.
    """

    first: Indices
    length: Indices
    start: Array

    def __len__(self) -> int:
        return len(self.first)

    def cells(self, cell: int, least: int) -> Indices:
        """Whole cells of ``cell`` samples in each stretch; none in one that has fewer than ``least``."""
        found = self.length // cell
        return np.where(found >= least, found, 0)

    def batches(self, cell: int, least: int, samples: int) -> Iterator[Batch]:
        """All cells, about ``samples`` samples at a time, and never more than twice as many with those left out between them.

        Parameters
        ----------
        cell, least : int
            As in `cells`.
        samples : int
        """
        count = self.cells(cell, least)
        before = np.concatenate([[0], np.cumsum(count)])
        at, step = 0, max(1, samples // cell)
        while at < before[-1]:
            number = np.arange(at, min(at + step, before[-1]))
            stretch = np.searchsorted(before, number, side="right") - 1
            place = number - before[stretch]
            first = self.first[stretch] + cell * place
            near = max(1, int(np.searchsorted(first + cell, first[0] + 2 * samples, side="right")))
            first = first[:near]
            whole = first[-1] - first[0] == cell * (near - 1)
            pick = None if whole else ((first - first[0])[:, None] + np.arange(cell)).ravel()
            yield Batch(slice(int(first[0]), int(first[-1]) + cell), pick, stretch[:near], place[:near])
            at += near


def stretches_of(first: NDArray[Any], samples: int, start: NDArray[Any]) -> Stretches:
    """Stretches by their first samples, rising from 0, and the times of these in s."""
    first = np.asarray(first, dtype=np.int64)
    return Stretches(first, np.diff(np.append(first, samples)), np.asarray(start, dtype=float))
