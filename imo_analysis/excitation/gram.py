"""Gram matrices of a regressor over sliding windows, in one pass and without a subtraction.

Samples are summed into cells; a window is a whole number of cells. Window sums are put together from the suffix sums of one
group of cells and the prefix sums of the next (van Herk, Pattern Recognition Letters 13, 1992; Gil and Werman, IEEE PAMI 15,
1993). That costs two additions a cell whatever the window, carries no error from one window to the next, and keeps a NaN
inside the windows that contain it. A running difference of cumulative sums has none of these three properties.

Error: a window of n samples is a sum of n products in some order, so each entry is within
(n + 2) u sum |a_i a_j| of the exact sum, u = 2^-53; for the diagonal that is a relative error of (n + 2) u.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
UNIT_ROUNDOFF = 2.0**-53


def pairs(size: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Row and column of each stored entry of a symmetric matrix, upper triangle by rows."""
    return np.triu_indices(size)


def cell_grams(rows: Sequence[Sequence[Any]], samples_per_cell: int, samples: int) -> Array:
    """Sums of B^T B over cells of equal length.

    Parameters
    ----------
    rows : sequence of sequence of (float or array of shape (samples,))
        The rows of B, as an equation of `imo_analysis.equations.excitation` returns them for arrays of signals.
    samples_per_cell : int
        Samples in a cell; a last cell that is not full is left out.
    samples : int
        Number of samples.

    Returns
    -------
    array of shape (cells, size (size + 1) / 2)
        Upper triangles, in the order of `pairs`, in the square of the unit of B.
    """
    cells = samples // samples_per_cell
    used = cells * samples_per_cell
    size = len(rows[0])

    def by_cell(signal: Array) -> Array:
        return signal[:used].reshape(cells, samples_per_cell)

    sums = np.zeros((cells, size * (size + 1) // 2))
    for entry, (i, j) in enumerate(zip(*pairs(size), strict=True)):
        for row in rows:
            a, b = row[i], row[j]
            if np.ndim(a) == 0 and np.ndim(b) == 0:
                sums[:, entry] += samples_per_cell * (a * b)
            elif np.ndim(a) == 0:
                sums[:, entry] += a * by_cell(b).sum(axis=1) if a else 0.0
            elif np.ndim(b) == 0:
                sums[:, entry] += b * by_cell(a).sum(axis=1) if b else 0.0
            else:
                sums[:, entry] += np.einsum("cs,cs->c", by_cell(a), by_cell(b))
    return sums


def full(packed: Array, size: int) -> Array:
    """Symmetric matrices, shape (..., size, size), of packed upper triangles."""
    i, j = pairs(size)
    matrices = np.empty((*packed.shape[:-1], size, size))
    matrices[..., i, j] = packed
    matrices[..., j, i] = packed
    return matrices


class SlidingSum:
    """Sums over each run of ``length`` cells, fed block by block.

    Parameters
    ----------
    length : int
        Cells in a window.
    width : int
        Numbers in a cell.
    join : int
        Cells that are first added into one, so that a long window moves in larger steps.
    """

    def __init__(self, length: int, width: int, join: int = 1) -> None:
        self.length, self.join = length, join
        self._waiting = np.empty((0, width))
        self._held = np.empty((0, width))
        self._stretch = np.empty(0, dtype=np.int64)

    def within(self, cells: Array, stretch: NDArray[np.int64]) -> tuple[Array, NDArray[np.intp]]:
        """Take cells with the numbers of their stretches (``join`` must be 1); return the windows that lie in one stretch.

        Returns
        -------
        array of shape (windows, width)
            Oldest first.
        array of int, shape (windows,)
            Which of ``cells`` is the last of each.
        """
        held = np.concatenate([self._stretch, stretch])
        sums = self.push(cells)
        self._stretch = held[len(sums) :]
        last = np.arange(len(sums)) + self.length - 1
        inside = held[: len(sums)] == held[last]
        return sums[inside], last[inside] - (len(held) - len(cells))

    def push(self, cells: Array) -> Array:
        """Take cells; return the windows that they complete, oldest first, shape (windows, width)."""
        if self.join > 1:
            cells = np.concatenate([self._waiting, cells])
            ready = len(cells) // self.join * self.join
            self._waiting = cells[ready:].copy()
            cells = cells[:ready].reshape(-1, self.join, cells.shape[1]).sum(axis=1)
        held = np.concatenate([self._held, cells])
        windows = max(0, len(held) - self.length + 1)
        if not windows:
            self._held = held
            return held[:0]
        self._held = held[windows:].copy()
        return _window_sums(held, self.length)


def _window_sums(cells: Array, length: int) -> Array:
    windows, width = len(cells) - length + 1, cells.shape[1]
    groups = -(-len(cells) // length)
    padded = np.zeros((groups * length, width))
    padded[: len(cells)] = cells
    grouped = padded.reshape(groups, length, width)
    prefix = np.cumsum(grouped, axis=1).reshape(-1, width)
    suffix = np.cumsum(grouped[:, ::-1], axis=1)[:, ::-1].reshape(-1, width)
    sums = suffix[:windows].copy()
    inside = np.arange(windows) % length != 0
    sums[inside] += prefix[length - 1 : length - 1 + windows][inside]
    return sums
