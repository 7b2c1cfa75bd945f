"""The sums behind the Gram matrices: against exact sums, for any blocking, and linear in the length whatever the window."""

import math
import time
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imo_analysis.excitation.gram import UNIT_ROUNDOFF, SlidingSum, cell_grams, full, pairs

RANDOM = np.random.default_rng(20180710)


def exact(rows, part):
    """sum B^T B over a slice in rational arithmetic."""
    size = len(rows[0])
    total = [[Fraction(0)] * size for _ in range(size)]
    for row in rows:
        for k in range(part.start, part.stop):
            values = [Fraction(float(v if np.ndim(v) == 0 else v[k])) for v in row]
            for i in range(size):
                for j in range(size):
                    total[i][j] += values[i] * values[j]
    return total


def test_windows_meet_the_stated_error_bound_against_exact_sums():
    samples, cell, length = 240, 4, 5
    big = 10.0 ** RANDOM.uniform(-8, 8, samples)
    rows = ((3.0, 0, RANDOM.normal(size=samples) * big), (0, 2.5, RANDOM.normal(size=samples)))
    windows = SlidingSum(length, 6).push(cell_grams(rows, cell, samples))
    assert len(windows) == samples // cell - length + 1
    for start in range(0, len(windows), 7):
        part = slice(start * cell, (start + length) * cell)
        truth = exact(rows, part)
        absolute = exact(tuple(tuple(np.abs(v) for v in row) for row in rows), part)
        for entry, (i, j) in enumerate(zip(*pairs(3), strict=True)):
            bound = (cell * length + 2) * UNIT_ROUNDOFF * float(absolute[i][j])
            assert abs(float(Fraction(float(windows[start, entry])) - truth[i][j])) <= bound


def test_a_running_difference_would_fail_where_this_does_not():
    """After a large transient, cumulative sums lose the small signal; window sums do not."""
    signal = np.concatenate([np.full(1000, 1e9), np.full(1000, 1e-3)])
    cells = cell_grams(((signal,),), 10, len(signal))
    window = SlidingSum(10, 1).push(cells)[-1, 0]
    cumulative = np.cumsum(cells[:, 0])
    assert window == pytest.approx(100 * 1e-6, rel=1e-12)
    assert cumulative[-1] - cumulative[-11] != pytest.approx(100 * 1e-6, rel=0.1)


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 12), st.integers(1, 4), st.lists(st.integers(1, 17), min_size=1, max_size=12))
def test_blocks_do_not_matter(length, join, sizes):
    cells = np.arange(float(sum(sizes)))[:, None] ** 2
    whole = SlidingSum(length, 1, join).push(cells)
    sliding, at, parts = SlidingSum(length, 1, join), 0, []
    for size in sizes:
        parts.append(sliding.push(cells[at : at + size]))
        at += size
    joined = cells[: len(cells) // join * join, 0].reshape(-1, join).sum(axis=1)
    direct = [joined[k : k + length].sum() for k in range(len(joined) - length + 1)]
    assert np.concatenate(parts)[:, 0].tolist() == whole[:, 0].tolist() == direct


def test_a_nan_stays_in_the_windows_that_contain_it():
    cells = np.ones((40, 1))
    cells[17] = math.nan
    windows = SlidingSum(6, 1).push(cells)[:, 0]
    assert np.flatnonzero(np.isnan(windows)).tolist() == list(range(12, 18))
    assert (windows[np.isfinite(windows)] == 6).all()


def test_packed_triangles_unfold_symmetrically():
    matrix = full(np.arange(6.0)[None], 3)[0]
    assert (matrix == matrix.T).all() and matrix[0].tolist() == [0, 1, 2]


@pytest.mark.slow
def test_the_cost_does_not_depend_on_the_window():
    cells = RANDOM.normal(size=(200_000, 10))
    cost = []
    for length in (5, 5000):
        best = math.inf
        for _ in range(3):
            begin = time.perf_counter()
            SlidingSum(length, 10).push(cells)
            best = min(best, time.perf_counter() - begin)
        cost.append(best)
    assert cost[1] < 3 * cost[0]
