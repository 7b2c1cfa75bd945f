"""Excitation along a run: ranks, lost directions, instants, degenerate logs, memory."""

import math

import numpy as np
import pytest
import xarray as xr
from synthetic import MACHINE, motion, observed

from imo_analysis.equations import excitation as equations
from imo_analysis.errors import InputError
from imo_analysis.excitation import signals, words
from imo_analysis.excitation.conditions import CONDITIONS, NO_SCALE
from imo_analysis.excitation.trajectory import excitation


def of(run, observer="plant", values="true"):
    return signals.select(signals.of_dataset(run, MACHINE), observer, values)


def test_constant_flux_loses_alpha_and_omega_along_the_slip():
    run = motion(slip=3.0)
    result = excitation(of(run))
    assert set(result.reduced_rank.values.tolist()) == {3}
    assert set(result.corrected_19_rank.values.tolist()) == {3}
    lost = words.lost_directions(result, "reduced")
    assert [one.share for one in lost] == [1.0]
    assert lost[0].slopes[1] == pytest.approx(-3.0 / MACHINE.alpha, rel=1e-9)
    assert "alpha_hat and omega_hat along (1, -0.302)" in words.verdict(result)
    assert "xi_hat and z_hat along alpha xi_tilde = j omega z_tilde" in words.verdict(result)


def test_modulated_flux_restores_the_reduced_condition_but_not_19():
    result = excitation(of(motion(modulation=0.05)))
    assert result.reduced_holds.values.all()
    assert not result.printed_19_holds.values.any() and not result.corrected_19_holds.values.any()
    assert set(result.corrected_19_rank.values.tolist()) == {4}
    assert "holds in every window" in words.verdict(result)


def test_the_sign_slip_of_the_print_hides_the_loss():
    """With the printed sign, constant flux looks as if alpha and omega were told apart: rank 4 where the truth is 3."""
    result = excitation(of(motion(slip=3.0)))
    assert set(result.printed_19_rank.values.tolist()) == {4}


def test_no_load_and_zero_stator_frequency():
    idle = excitation(of(motion(slip=0.0)))
    assert [one.text for one in words.lost_directions(idle, "reduced")] == ["alpha_hat alone"]
    stopped = excitation(of(motion(omega=-2.0, slip=2.0)))
    assert set(stopped.reduced_rank.values.tolist()) == {2}
    assert "2 directions in" in words.verdict(stopped)


def test_zero_flux_is_said_before_any_scaled_number():
    result = excitation(of(motion() * 0))
    assert words.standstill(result) == ["there is no flux, z_hat = i_hat throughout: nothing tells of alpha_hat and omega_hat "
                                        "(nor is there a current to scale by; 1 A is taken)"]
    assert words.standstill(result)[0] in words.verdict(result).split("\n")[1]
    assert set(result.reduced_rank.values.tolist()) == {2}
    assert words.standstill(excitation(of(motion()))) == []


def test_constant_signals_are_said_to_stand_still():
    """At zero stator frequency every signal is constant; the slightest turn is not."""
    still = excitation(of(motion(omega=-2.0, slip=2.0)))
    assert "the signals stand still, as at zero stator frequency" in words.verdict(still).split("\n")[1]
    assert words.standstill(excitation(of(motion(omega=-2.0, slip=2.001)))) == []


def test_infinity_in_a_log_is_not_called_nan():
    run = motion()
    run["i_ds"].values[7000] = math.inf
    text = words.verdict(excitation(of(run)))
    assert "windows hold infinite values and are left out" in text and "NaN" not in text
    run["i_qs"].values[100] = math.nan
    assert "windows hold NaN or infinite values and are left out" in words.verdict(excitation(of(run)))


@pytest.mark.parametrize(("conditions", "least"), [(("reduced",), 2), (tuple(CONDITIONS), 3)])
def test_a_window_of_too_few_samples_is_refused(conditions, least):
    """Each sample adds two rows: with one sample fewer no Gram matrix can have full rank, with as many one can."""
    step, source = 1e-4, of(motion(modulation=0.1))
    with pytest.raises(InputError, match=f"take {least} samples, {least * step:g} s, or more"):
        excitation(source, (least - 1) * step, conditions=conditions)
    with pytest.raises(InputError, match="holds 1 sample"):
        excitation(source, 1e-9, conditions=conditions)
    assert excitation(source, least * step, conditions=conditions).attrs["window"] == pytest.approx(least * step)


def test_levels_are_those_of_all_windows_of_a_length():
    """Weak modulation in the middle of strong: the level of every length by direct sums, and the shortest that holds."""
    run, weak = motion(duration=4.0, modulation=0.1), motion(duration=1.0, modulation=0.004, start=1.0)
    for name in ("i_ds", "i_qs", "phi_dr", "phi_qr"):
        run[name].values[10_000:20_000] = weak[name].values
    source = of(run)
    result = excitation(source, 0.4, every=0.1, conditions=["reduced"])
    rows = CONDITIONS["reduced"].of(source.block(slice(0, source.samples)), MACHINE)
    dense = np.array([[np.broadcast_to(v, (source.samples,)) for v in row] for row in rows])
    dense = dense * result.reduced_factor.values[:, None]
    cells = np.einsum("ricn,rjcn->cij", *[dense.reshape(2, 4, 40, 1000)] * 2) / 1000
    assert result.reduced_level_window.values == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 4.0])
    for length, level, holds in zip(result.reduced_level_window.values, result.reduced_level.values,
                                    result.reduced_level_holds.values, strict=True):
        n = round(length / 0.1)
        step = max(1, n // 4) if n < 40 else 1
        values = np.array([np.linalg.eigvalsh(cells[k:k + n].mean(axis=0)) for k in range(0, 40 - n + 1, step)])
        assert holds == (values[:, 0] > 1e-4 * values[:, -1]).all()
        if holds or length >= 0.4:
            assert level == pytest.approx(values[:, 0].min(), rel=1e-9)
            assert len(values) < 4 or values[-1, 0] > 1.5 * level or n == 4  # the last one is not the worst
        else:
            assert math.isnan(level)
    shortest = result.reduced_level_window.values[result.reduced_level_holds.values][0]
    assert 0.4 < shortest < 4.0
    assert f"T = {shortest:.3g} s, with m = " in words.verdict(result)


def test_gram_matrices_agree_with_direct_sums_in_si():
    run = motion(duration=0.2, modulation=0.1)
    source = of(run)
    block = source.block(slice(0, source.samples))
    result = excitation(source, 0.05, every=0.01, scale=NO_SCALE)
    for name in CONDITIONS:
        rows = CONDITIONS[name].of(block, MACHINE)
        dense = np.array([[np.broadcast_to(v, (source.samples,)) for v in row] for row in rows])
        for k, end in enumerate(result.time.values):
            stop = round(end / source.step)
            part = dense[:, :, stop - 500 : stop]
            direct = np.linalg.eigvalsh(np.einsum("rit,rjt->ij", part, part) / 500)
            np.testing.assert_allclose(result[f"{name}_eigenvalue"].values[k], direct, atol=1e-12 * direct[-1], rtol=1e-7)


def test_instants_of_appearing_and_disappearing():
    """Modulation between 1 s and 2 s: excitation appears with the first window that sees it and goes with the last."""
    run = motion(duration=3.0)
    middle = motion(duration=1.0, modulation=0.1, start=1.0)
    for name in ("i_ds", "i_qs", "phi_dr", "phi_qr"):
        run[name].values[10_000:20_000] = middle[name].values
    result = excitation(of(run), 0.1)
    assert result.reduced_appears.values.tolist() == [True, False]
    assert result.reduced_instant.values == pytest.approx([1.02, 2.1], abs=0.0201)
    assert result.reduced_level.sel(reduced_level_window=0.1).item() < 1e-15
    assert "excitation appears at 1.02 s, disappears at 2.1 s" in words.verdict(result)
    assert words.instants_text(excitation(of(motion())), "reduced") == ""


def test_estimated_values_and_a_run_with_an_observer():
    run = observed(motion(modulation=0.05), alpha_hat=6.6)
    source = signals.of_dataset(run)
    assert signals.adaptive_observers(source) == ["converged"]
    result = excitation(signals.select(source, "converged", "estimated"))
    assert result.attrs["values"] == "estimated" and not result.corrected_19_holds.values.any()


def test_a_nan_in_a_log_is_left_out_and_said():
    run = motion()
    run["i_ds"].values[7000] = math.nan
    result = excitation(of(run))
    assert 0 < result.reduced_holds.attrs["undefined"] <= 6
    assert "hold NaN and are left out" in words.verdict(result)
    assert np.isnan(result.reduced_eigenvalue.values).any(axis=1).sum() == result.reduced_holds.attrs["undefined"]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda r: r.isel(time=slice(0, 1)), "1 sample"),
        (lambda r: r.isel(time=slice(0, 50)), "take a shorter window"),
        (lambda r: r.drop_vars("phi_dr"), "lacks phi_dr"),
        (lambda r: r.assign_coords(time=r.time.values**2), r"not evenly spaced.* imo replay --gaps bridge judges"),
        (lambda r: r.assign_coords(time=r.time.values * math.nan), "must increase"),
        (lambda r: r * math.nan, "without NaN"),
        (lambda r: r.rename(time="t"), "no dimension 'time'"),
    ],
)
def test_logs_that_cannot_be_used_get_one_line(change, text):
    with pytest.raises(InputError, match=text) as error:
        excitation(of(change(motion())))
    assert "\n" not in str(error.value)


def test_an_observer_without_xi_is_refused():
    run = observed(motion())
    run["xi_1_hat"] = run.xi_1_hat * math.nan
    with pytest.raises(InputError, match="says nothing about it"):
        signals.select(signals.of_dataset(run), "converged")
    with pytest.raises(InputError, match="choose one of: converged, plant"):
        signals.select(signals.of_dataset(run), "other")


@pytest.mark.parametrize(("window", "every"), [(0.0, None), (math.nan, None), (0.1, 0.2), (0.1, -1.0)])
def test_impossible_windows(window, every):
    with pytest.raises(InputError, match="must be above 0 s"):
        excitation(of(motion(duration=0.3)), window, every=every)


def test_thinning_keeps_the_worst_and_counts_all():
    source = of(motion(duration=4.0, modulation=0.05))
    whole, thin = excitation(source), excitation(source, max_rows=20)
    assert thin.sizes["time"] <= 22 < whole.sizes["time"]
    assert thin.reduced_holds.attrs["windows"] == whole.reduced_holds.attrs["windows"] == whole.sizes["time"]
    assert thin.reduced_eigenvalue.values[:, 0].min() == whole.reduced_eigenvalue.values[:, 0].min()


def test_shares_of_what_is_lost_are_of_all_windows_not_of_the_kept():
    """Half excited, thinned to the worst of neighbours: what holds and what is lost add up to all windows."""
    run = observed(motion(duration=4.0, modulation=0.05))
    still = observed(motion(duration=4.0, slip=3.0))
    mixed = run.assign({name: run[name].where(np.mod(run.time, 0.5) < 0.25, still[name]) for name in run})
    thin = excitation(signals.select(signals.of_dataset(mixed), "converged"), 0.02, max_rows=15)
    holds, lost = thin.reduced_holds.attrs, words.lost_directions(thin, "reduced")
    share = holds["holding"] / holds["windows"]
    assert 0.2 < share < 0.8 and float(thin.reduced_holds.mean()) < share - 0.1
    assert share + sum(one.share for one in lost) == pytest.approx(1.0)


def test_a_file_gives_the_same_as_the_data_set(tmp_path):
    run = observed(motion(modulation=0.02))
    path = tmp_path / "run.nc"
    run.to_netcdf(path, engine="h5netcdf")
    with signals.open_file(path) as source:
        from_file = excitation(signals.select(source, "converged"))
    xr.testing.assert_identical(from_file, excitation(signals.select(signals.of_dataset(run), "converged")))


def test_files_that_are_not_runs(tmp_path):
    path = tmp_path / "x.nc"
    path.write_text("no")
    for bad in (path, tmp_path / "none.nc"):
        with pytest.raises(InputError, match="cannot read"), signals.open_file(bad):
            pass


def test_memory_does_not_grow_with_the_run(tmp_path):
    """Peak memory of a run eight times as long stays the same (the file is read by slices)."""
    import tracemalloc

    import h5netcdf

    peaks = []
    for copies in (5, 40):
        path = tmp_path / f"{copies}.nc"
        run = observed(motion(duration=20.0, step=1e-3))
        many = {k: v.transpose("time", ...).values for k, v in run.data_vars.items()}
        with h5netcdf.File(path, "w") as file:
            file.attrs["study"] = run.attrs["study"]
            samples = copies * run.sizes["time"]
            file.dimensions = {"time": samples, "observer": 1}
            file.create_variable("time", ("time",), data=np.arange(samples) * 1e-3)
            file.create_variable("observer", ("observer",), data=np.array([b"converged"]))
            for name, values in many.items():
                dims = ("time", "observer")[: values.ndim]
                file.create_variable(name, dims, data=np.concatenate([values] * copies))
        tracemalloc.start()
        with signals.open_file(path) as source:
            excitation(signals.select(source, "converged"), max_rows=100)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0] and peaks[1] < 60e6


def test_the_reduced_rows_are_those_of_the_observer():
    """v_1 and v_2 are the derivatives of the observer's current rows by alpha_hat and omega_hat: the very definitions agree."""
    import sympy

    from imo_analysis.equations.adaptive import consistent_12

    names = sympy.symbols("i1 i2 a1 a2 z1 z2 x1 x2 al om R L s b k1 k2 k3 g K l d u1 u2")
    i1, i2, a1, a2, z1, z2, x1, x2, al, om, R, L, s, b, k1, k2, k3, g, K, low, d, u1, u2 = names
    rates = consistent_12((a1, a2, z1, z2, x1, x2, al, om), (i1, i2), (u1, u2), 1, (R, L, s, b, 0), (k1, k2, k3, g, K, low, d))
    rows = equations.reduced((i1, i2), (a1, a2), (z1, z2), (x1, x2), al, om, b, L)
    for row, rate in zip(rows, rates[:2], strict=True):
        assert sympy.expand(sympy.diff(rate, al) - row[2]) == 0
        assert sympy.expand(sympy.diff(rate, om) - row[3]) == 0


@pytest.mark.slow
def test_a_minute_at_10_khz_takes_under_a_second():
    import time

    source = of(motion(duration=60.0, modulation=0.05))
    best = math.inf
    for _ in range(3):
        begin = time.process_time()
        excitation(source)
        best = min(best, time.process_time() - begin)
    assert best < 1.0
