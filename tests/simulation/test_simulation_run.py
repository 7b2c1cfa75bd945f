"""The data set of a run: its contract, its reproducibility, divergence, noise, and the loop closed on an estimate."""

import json

import numpy as np
import pytest

from imo_analysis.errors import Diverged, InputError
from imo_analysis.simulation import run as runs
from imo_analysis.simulation.inputs import inputs, normals
from imo_analysis.simulation.run import simulate
from imo_analysis.simulation.summary import summary
from imo_analysis.study import Study


@pytest.fixture(scope="module")
def short(paper):
    return paper.changed({"simulation.duration": 0.2, "simulation.record_every": 1})


def same(a, b):
    return all(np.array_equal(a[name].values, b[name].values, equal_nan=a[name].dtype.kind == "f") for name in a.variables)


def test_contract(short):
    run = simulate(short)
    assert run["omega"].dims == ("time",) and run["omega_hat"].dims == ("observer", "time")
    assert list(run["observer"].values) == ["baseline", "consistent_12", "repaired"]
    for name, values in run.data_vars.items():
        assert {"units", "long_name", "latex"} <= set(values.attrs), name
    assert run["torque"].attrs["units"] == "N m" and run["time"].attrs["units"] == "s"
    assert np.isnan(run["alpha_hat"].sel(observer="baseline")).all()
    assert np.array_equal(run["time"].values, np.arange(2000) * 1e-4)
    assert Study.from_toml(run.attrs["study"]).sha256 == run.attrs["study_sha256"] == short.sha256
    assert "numba" in json.loads(run.attrs["versions"]) and run.attrs["schema"] == "imo-run/1"


def test_nobody_changes_what_another_computes(short):
    together = simulate(short)
    for names in (["repaired"], ["consistent_12", "baseline"]):
        apart = simulate(short.only(names))
        assert same(apart, together.sel(observer=names))
    assert np.array_equal(simulate(short.only([]))["i_ds"].values, together["i_ds"].values)


def test_recording_and_stretches_change_nothing(short, monkeypatch):
    noisy = short.changed({"sensors.current_noise": 0.1})
    whole = simulate(noisy)
    assert same(simulate(noisy.changed({"simulation.record_every": 7})), whole.isel(time=slice(None, None, 7)))
    monkeypatch.setattr(runs, "_STRETCH", 331)
    assert same(simulate(noisy), whole)
    assert same(simulate(noisy.changed({"simulation.record_every": 7})), whole.isel(time=slice(None, None, 7)))


def test_noise_is_the_seed_s(short):
    noisy = short.changed({"sensors.current_noise": 0.1})
    other = noisy.changed({"simulation.seed": 2})
    assert same(simulate(noisy), simulate(noisy)) and not same(simulate(noisy), simulate(other))
    part = inputs(noisy, 500, 100)
    assert np.array_equal(part, inputs(noisy, 0, 1000)[:, 500:600])
    one, two = normals(5, np.arange(200_000))
    assert abs(one.mean()) < 0.01 and abs(one.std() - 1) < 0.01 and abs(np.mean(one * two)) < 0.01
    assert abs(np.mean(one[1:] * one[:-1])) < 0.01 and abs(np.mean(one**4) - 3) < 0.1


def test_sensor_errors_are_what_is_measured(short):
    run = simulate(short.changed({"sensors.current_offset": [0.5, -0.25], "sensors.current_gain": [1.01, 0.98]}))
    np.testing.assert_allclose(run["i_ds_meas"], 1.01 * run["i_ds"] + 0.5, rtol=1e-14)
    np.testing.assert_allclose(run["i_qs_meas"], 0.98 * run["i_qs"] - 0.25, rtol=1e-14)


def test_held_samples_approach_continuous_ones(short):
    """The effect of holding the samples falls with the sampling period."""
    gaps = []
    for T in (1e-4, 5e-5):
        base = short.changed({"simulation.sample_time": T, "simulation.duration": 1.0, "reference.omega": [20.0] * 4})
        held = simulate(base.changed({"sensors.sampling": "sampled"}))
        free = simulate(base)
        gap = np.abs(held["phi_dr_hat"] - free["phi_dr_hat"]).sel(observer="repaired").values[-2000:]
        gaps.append(gap.max())
    assert 0 < gaps[1] < 0.75 * gaps[0]


def test_divergence_keeps_the_run_and_says_when(paper):
    with pytest.raises(Diverged) as caught:
        simulate(paper.scenario("divergence"))
    fault = caught.value
    assert "observer printed_7 diverged at t = " in str(fault) and "observer printed_L diverged" in str(fault)
    run = fault.data
    lost = run["omega_hat"].sel(observer="printed_7").values
    assert np.isfinite(lost[run["time"].values < fault.time]).all() and np.isnan(lost[run["time"].values >= fault.time]).all()
    assert np.isfinite(run["omega_hat"].sel(observer="repaired")).all()
    assert run["time"].values[-1] == pytest.approx(9.999)
    assert set(fault.state) >= {"omega_hat", "z_1_hat"}


def test_a_machine_that_leaves_the_numbers_ends_the_run(paper):
    study = paper.only([]).changed({"simulation.duration": 1.0, "simulation.sample_time": 0.02, "simulation.record_every": 1})
    with pytest.raises(Diverged, match="the machine diverged at t = ") as caught:
        simulate(study)
    assert caught.value.data["time"].values[-1] < caught.value.time <= 1.0
    assert np.isfinite(caught.value.data["omega"]).all()


def test_the_loop_closes_on_an_estimate(paper):
    base = paper.changed({"simulation.duration": 3.0, "reference.time": [0.0, 2.0], "reference.omega": [60.0, 80.0]})
    measured = simulate(base)
    closed = simulate(base.changed({"drive.feedback": "consistent_12"}))
    assert abs(float(closed["omega"][-1]) - 80.0) < 0.5
    assert not np.array_equal(closed["omega"].values, measured["omega"].values)
    assert list(closed["observer"].values) == list(measured["observer"].values)
    alone = simulate(base.changed({"drive.feedback": "consistent_12"}).only(["consistent_12"]))
    assert same(alone, closed.sel(observer=["consistent_12"]))


def test_alpha_hat_of_fig_4(paper):
    """The paper's Fig. 4 ends at 10.5; the gains that run gave 10.47 after the step from 40 to 100 rad/s."""
    run = simulate(paper.only(["consistent_12"]))
    assert float(run["alpha_hat"].sel(time=44.9, method="nearest")[0]) == pytest.approx(10.47, abs=0.01)
    fig4 = simulate(paper.scenario("fig4").only(["consistent_12"]))
    assert float(fig4["alpha_hat"][0, -1]) == pytest.approx(10.5, abs=0.05)


def test_a_run_that_does_not_fit_the_memory_is_refused(paper):
    with pytest.raises(InputError, match=r"record_every = 1 keeps 1000000000 records.* make it \d+ or more"):
        simulate(paper.changed({"simulation.duration": 1e5, "simulation.record_every": 1}))


def test_modulating_the_flux_finds_alpha(paper):
    """At constant speed and flux the repaired observer stops beside alpha; with the flux modulated it finds it."""
    base = paper.only(["repaired"]).changed({
        "simulation.duration": 30.0, "reference.time": [0.0], "reference.omega": [60.0], "load.T_l": [5.0]})
    moved = base.changed({"drive.flux_modulation": 0.05, "drive.flux_modulation_frequency": 10.0})
    still, found = (float(simulate(study)["alpha_hat"][0, -1]) for study in (base, moved))
    assert abs(still - paper.machine.alpha) > 0.1
    assert abs(found - paper.machine.alpha) < 1e-3


@pytest.mark.parametrize(("error", "noise", "off"), [(0.0, 0.0, False), (1.0, 0.0, False), (3.0, 0.0, True), (0.0, 15.0, True),
                                                     (0.0, 8.0, False), (np.nan, 0.0, True)])
def test_a_summary_says_who_ends_off_the_speed(error: float, noise: float, off: bool) -> None:
    """100 rad/s: the mean may be 2 rad/s off, the rms 10; judged by the last half second alone."""
    import xarray as xr

    time = np.linspace(0, 2, 2001)
    swing = noise * np.sqrt(2) * np.sin(2 * np.pi * 20 * time)
    hat = np.where(time < 1.4, 0.0, 100.0 - error - swing)
    run = xr.Dataset({"omega": ("time", np.full(2001, 100.0)), "omega_hat": (("observer", "time"), hat[None]),
                      "alpha_hat": (("observer", "time"), np.full((1, 2001), np.nan))}, {"time": time, "observer": ["one"]})
    assert summary(run)["one"]["off"] is off
