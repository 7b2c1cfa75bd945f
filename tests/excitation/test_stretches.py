"""Excitation over a record with gaps: each stretch gives what it gives alone, and no window joins two."""

import numpy as np
import pytest
import xarray as xr
from synthetic import MACHINE, motion

from imo_analysis.errors import InputError
from imo_analysis.excitation import signals, words
from imo_analysis.excitation.conditions import CONDITIONS, Scale
from imo_analysis.excitation.stretches import stretches_of
from imo_analysis.excitation.trajectory import excitation

STEP = 1e-3
SCALE = Scale(100.0, 80.0)
PARTS = ((0, 900), (930, 1600), (1601, 1660), (1700, 3000), (3004, 4000))  # the third is shorter than a window


def record():
    """Four seconds: the flux is modulated in the first and in the third, and constant in the others."""
    pieces = [motion(1.0, STEP, modulation=depth, frequency=2 * np.pi, start=k) for k, depth in enumerate((0.1, 0.0, 0.1, 0.0))]
    return xr.concat(pieces, "time")


def broken(run, parts):
    """The samples of these parts alone, with the places where each of them begins."""
    first = np.cumsum([0, *(stop - start for start, stop in parts)])[:-1]
    kept = np.concatenate([np.arange(*part) for part in parts])
    return run.isel(time=kept), signals.Gaps(first, STEP)


def judged(run, gaps=None, window=0.1, **more):
    return excitation(signals.select(signals.of_dataset(run, MACHINE), "plant", gaps=gaps), window, scale=SCALE, **more)


def test_each_stretch_gives_what_it_gives_alone():
    """Eigenvalues, counts, instants and ends of windows, in order; the scale, which is the record's, given to both."""
    run = record()
    together = judged(*broken(run, PARTS))
    alone = [judged(run.isel(time=slice(*part))) for part in PARTS if part[1] - part[0] >= 100]
    assert len(alone) == 4
    for name in CONDITIONS:
        values = np.concatenate([one[f"{name}_eigenvalue"].values for one in alone])
        assert np.allclose(together[f"{name}_eigenvalue"].values, values, rtol=1e-12, atol=1e-13 * values.max())
        for key in ("windows", "holding", "undefined", "transitions"):
            assert together[f"{name}_holds"].attrs[key] == sum(one[f"{name}_holds"].attrs[key] for one in alone)
        lowest = min(one[f"{name}_holds"].attrs["lowest"] for one in alone)
        assert together[f"{name}_holds"].attrs["lowest"] == pytest.approx(lowest)
        assert together[f"{name}_holding"].values.tolist() == [
            0 if n is None else alone[n][f"{name}_holds"].attrs["holding"] for n in (0, 1, None, 2, 3)]
        assert np.array_equal(together[f"{name}_instant"], np.concatenate([one[f"{name}_instant"] for one in alone]))
        lengths, holding = (together[f"{name}_{key}"].values.tolist() for key in ("level_window", "level_holds"))
        level = dict(zip(lengths, holding, strict=True))
        for length, holds in level.items():
            each = [bool(one[f"{name}_level_holds"].sel({f"{name}_level_window": length}, method="nearest")) for one in alone]
            assert holds == all(each)
        assert max(level) == pytest.approx(0.1), "no longer window than the one that was asked for"
    assert np.allclose(together["time"], np.concatenate([one["time"] for one in alone]), rtol=0, atol=1e-12)
    assert 0 < together["reduced_holds"].attrs["holding"] < together["reduced_holds"].attrs["windows"]
    assert together["reduced_holds"].attrs["transitions"] > 0, "the test has something to tell apart"


def test_a_gap_inside_a_window_leaves_no_window_there():
    """Two loads, neither of which tells alpha from the speed: a window over both does, and there must be none."""
    both = xr.concat([motion(0.5, STEP, slip=2.0), motion(0.5, STEP, slip=6.0, start=0.5)], "time")
    cut, gaps = broken(both, ((0, 450), (503, 1000)))
    result = judged(cut, gaps, conditions=["reduced"])
    assert result["reduced_holds"].attrs["holding"] == 0 and result["reduced_holds"].attrs["undefined"] == 0
    ends = result["time"].values
    assert ends.min() == pytest.approx(0.1) and ends.max() == pytest.approx(0.983, abs=0.02)
    assert not ((ends > 0.45 + 1e-9) & (ends < 0.603 - 1e-9)).any(), "the first window behind the gap begins there"
    joined = cut.assign_coords(time=np.arange(cut.sizes["time"]) * STEP)
    assert judged(joined, conditions=["reduced"])["reduced_holds"].attrs["holding"] > 0


def test_what_is_said_of_the_stretches():
    result = judged(*broken(record(), PARTS), conditions=["reduced"])
    text = words.verdict(result)
    assert "5 stretches between gaps, each judged on its own: 3.84 of their 3.925 s are in windows" in text
    assert "1 stretch is too short for one" in text
    assert "of 4 stretches with a value it holds throughout in 1, 0.9 s (0 to 0.9 s), in part in 2, nowhere in 1" in text
    assert "of the run" not in text
    data = words.summary(result)
    assert (data["stretches"], data["stretches_too_short"]) == (5, 1)
    assert data["time_judged"] == pytest.approx(3.84) and data["time"] == pytest.approx(3.925)
    rows = data["conditions"]["reduced"]["stretches"]
    assert [round(row["start"], 6) for row in rows] == [0.0, 0.93, 1.7, 3.004]
    assert sum(row["windows"] for row in rows) == data["conditions"]["reduced"]["windows"]
    whole = words.summary(judged(record(), conditions=["reduced"]))
    assert "stretches" not in whole and "stretches" not in whole["conditions"]["reduced"]


def test_all_stretches_too_short():
    cut, gaps = broken(record(), tuple((start, start + 60) for start in range(0, 4000, 100)))
    with pytest.raises(InputError, match=r"window = 0.1 s must be at most that of the longest of 40 stretches between gaps, "
                                         r"0.06 s; take a shorter window") as caught:
        judged(cut, gaps)
    assert "\n" not in str(caught.value)
    assert judged(cut, gaps, window=0.05)["reduced_holds"].attrs["windows"] == 40 * 2


@pytest.mark.parametrize("parts", [((0, 1), (5, 4000)), ((0, 3990), (3999, 4000)), ((0, 1), (5, 3990), (3999, 4000))])
def test_a_gap_right_behind_the_start_or_before_the_end(parts):
    """A stretch of one sample has no window; the rest is as without it."""
    run = record()
    longest = max(parts, key=lambda part: part[1] - part[0])
    alone, together = judged(run.isel(time=slice(*longest))), judged(*broken(run, parts))
    assert np.allclose(alone["reduced_eigenvalue"], together["reduced_eigenvalue"], rtol=1e-12, atol=1e-15)
    assert int((together["stretch_judged"] == 0).sum()) == len(parts) - 1


def test_nan_in_one_stretch_is_left_out_of_that_alone():
    run = record()
    run["i_ds"].values[200] = np.nan
    result = judged(*broken(run, PARTS), conditions=["reduced"])
    windows, undefined = (result["reduced_holds"].attrs[key] for key in ("windows", "undefined"))
    assert 0 < undefined < windows and result["reduced_judged"].values.sum() == windows - undefined
    assert "windows hold NaN and are left out" in words.verdict(result)


def test_a_time_that_is_uneven_between_gaps_is_named():
    cut, gaps = broken(record(), PARTS)
    time = cut["time"].values.copy()
    time[1000] += 0.5 * STEP
    with pytest.raises(InputError, match="not evenly spaced: sample 1000"):
        judged(cut.assign_coords(time=time), gaps)


@pytest.mark.parametrize(("cell", "least", "samples"), [(1, 1, 7), (3, 2, 10), (5, 1, 1), (4, 3, 1000)])
def test_batches_hold_every_cell_once_and_none_across_a_gap(cell, least, samples):
    """Against a plain loop, for stretches of all lengths, long runs of short ones included; no batch is far too long."""
    length = np.random.default_rng(1).integers(1, 20, 300)
    length[50:200] = 1
    first = np.concatenate([[0], np.cumsum(length)[:-1]])
    stretches = stretches_of(first, int(length.sum()), first * STEP)
    wanted = [(n, k, list(range(a + k * cell, a + (k + 1) * cell)))
              for n, (a, size) in enumerate(zip(first, length, strict=True)) if size // cell >= least
              for k in range(size // cell)]
    found = []
    for batch in stretches.batches(cell, least, samples):
        rows = np.arange(batch.part.start, batch.part.stop)
        assert len(rows) <= 2 * max(samples, cell)
        picked = (rows if batch.pick is None else rows[batch.pick]).reshape(-1, cell)
        found += [(int(n), int(k), row.tolist()) for n, k, row in zip(batch.stretch, batch.place, picked, strict=True)]
    assert found == wanted


def test_many_gaps_take_no_longer():
    """Samples in stretches of 40 against the same in one; windows of ten."""
    from time import perf_counter

    run = motion(200.0, STEP, modulation=0.1)
    first = np.arange(0, 200_000, 40)
    took = []
    for gaps in (None, signals.Gaps(first, STEP)):
        begun = perf_counter()
        result = judged(run, gaps, window=0.01, conditions=["reduced"])
        took.append(perf_counter() - begun)
    assert result["reduced_holds"].attrs["windows"] == 5_000 * 16
    assert took[1] < 3 * took[0]
