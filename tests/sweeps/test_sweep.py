"""Sweeps: what is drawn, what is refused, what comes out, and that killing and resuming change nothing."""

import io
import json
import sys
import warnings

import numpy as np
import pytest

from imo_analysis import cli
from imo_analysis.errors import InputError
from imo_analysis.report.sweep_figures import edges_of, shares, sweep_figure
from imo_analysis.simulation.run import simulate
from imo_analysis.sweeps import distributions, parts
from imo_analysis.sweeps import sweep as sweeps
from imo_analysis.sweeps.metrics import METRICS
from imo_analysis.sweeps.sweep import Plan, connected, sweep
from imo_analysis.sweeps.values import impossible, own_value, with_values

SHORT = {
    "simulation.duration": 0.1, "windows": [],
    "reference": {"time": [0.0, 0.05], "omega": [60.0, 80.0]},
    "initial": {"phi_dr": 0.5, "omega": 60.0, "i_ds": 8.0},
    "sweep": {"runs": 40, "seed": 4, "start": 0.02, "hold": 0.01, "band": 2.0,
              "fields": {"machine.R_r": {"relative": 0.5}, "machine": {"R_s": {"uniform": [0.3, 0.6]}}}},
}


def short(study, fields=None, **sweep):
    """A study of a tenth of a second with a sweep; ``fields`` replaces the fields."""
    data = {name: value for name, value in study.data.items() if name not in ("sweep", "scenarios")}
    plain = type(study).from_data(data).changed(SHORT)
    table = {**plain.data["sweep"], **sweep}
    if fields is not None:
        table["fields"] = fields
    return type(study).from_data({**plain.data, "sweep": table})


@pytest.fixture(scope="module")
def study(paper):
    return short(paper.only(["repaired", "baseline"]))


@pytest.fixture(scope="module")
def data(study):
    return sweep(study)


def test_the_data_set_is_labelled_whole_and_carries_its_study(data, study):
    assert data.sizes == {"observer": 2, "run": 40}
    assert set(METRICS) | {"possible"} == set(data.data_vars)
    assert all(one.attrs["units"] and one.attrs["long_name"] for one in data.data_vars.values())
    assert list(data.observer.values) == ["baseline", "repaired"] or list(data.observer.values) == ["repaired", "baseline"]
    assert data.attrs["schema"] == "imo-sweep/1" and data.attrs["study_sha256"] == study.sha256
    assert data["machine.R_r"].attrs["study_value"] == study.machine.R_r


@pytest.mark.parametrize("run", [0, 17, 39])
def test_each_run_is_the_study_it_says(data, study, run):
    """The numbers of a run, from the trajectory of its own study: an independent way through simulate and numpy."""
    one = Plan(study).study_of(run)
    trajectory = simulate(one)
    inside = trajectory.sel(time=slice(0.02 - 1e-9, None))
    for name in study.observers:
        found = data.sel(observer=name).isel(run=run)
        error = (inside.omega - inside.omega_hat.sel(observer=name)).values
        hat = inside.sel(observer=name)
        flux = np.hypot(inside.phi_dr - hat.phi_dr_hat, inside.phi_qr - hat.phi_qr_hat)
        np.testing.assert_allclose(found.speed_rms, np.sqrt(np.mean(error**2)), rtol=1e-8)
        np.testing.assert_allclose(found.speed_peak, np.max(np.abs(error)), rtol=1e-8)
        np.testing.assert_allclose(found.flux_rms, np.sqrt(np.mean(flux.values**2)), rtol=1e-8)
        np.testing.assert_allclose(found.flux_peak, np.max(flux.values), rtol=1e-8)
        outside = inside.time.values[np.abs(error) > 2.0]
        if outside.size and outside[-1] == inside.time.values[-1]:
            assert np.isnan(found.settling_time) and found.holds == 0
        else:
            settled = outside[-1] + 1e-3 - 0.02 if outside.size else 0.0
            assert found.settling_time == pytest.approx(settled, abs=1e-9)
            assert found.holds == (settled <= 0.08 - 0.01)
        if name == "repaired":
            np.testing.assert_allclose(found.excitation, _level(one, inside, name), rtol=1e-6)


def _level(study, inside, name):
    """Smallest eigenvalue of the mean of B^T B, summed row by row."""
    machine, at = study.observer_machine(name), inside.sel(observer=name)
    coupling = 1 + machine.beta * machine.L_m
    one = np.array([at.xi_1_hat - coupling * at.i_ds_meas, at.xi_2_hat - coupling * at.i_qs_meas])
    two = np.array([at.z_2_hat - at.i_qs_hat, at.i_ds_hat - at.z_1_hat])
    scale = np.sqrt(np.mean(np.sum(two**2, axis=0)))
    gram = np.zeros((4, 4))
    for k in range(one.shape[1]):
        rows = np.column_stack([np.eye(2), one[:, k] / scale, two[:, k] / scale])
        gram += rows.T @ rows / one.shape[1]
    return np.linalg.eigvalsh(gram)[0]


def test_nominal_observers_do_not_follow_the_machine(study):
    one = Plan(study).study_of(5)
    assert one.machine.R_r != study.machine.R_r
    assert one.observer_machine("baseline").R_r == pytest.approx(study.machine.R_r, rel=1e-14)
    own = Plan(study.changed({"sweep.believe": "own"})).study_of(5)
    assert own.observer_machine("baseline").R_r == own.machine.R_r == one.machine.R_r


def test_threads_and_chunks_change_no_bit(data, study, monkeypatch):
    monkeypatch.setattr(sweeps, "CHUNK", 7)
    sweeps.plan_of.cache_clear()
    again = sweep(study, jobs=2)
    sweeps.plan_of.cache_clear()
    assert data.identical(again)


def test_runs_over_grids_alone_are_one_a_point(study):
    grids = short(study, {"machine.R_r": {"linspace": [0.3, 0.5, 3]}, "machine.R_s": {"values": [0.4, 0.5]}})
    with pytest.warns(UserWarning, match="sweep.runs = 40 draws nothing") as caught:
        plan = Plan(grids)
    assert plan.runs == 6 and len(caught) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # where its text is computed elsewhere nobody is told again
        assert Plan(type(study).from_toml(plan.text)).runs == 6


def test_draws_do_not_depend_on_how_many_there_are(study):
    few, many = Plan(study), Plan(study.changed({"sweep.runs": 4000}))
    np.testing.assert_array_equal(few.values(0, 40)["machine.R_r"], many.values(0, 40)["machine.R_r"])
    values = many.values(0, 4000)
    assert abs(np.corrcoef(values["machine.R_r"], values["machine.R_s"])[0, 1]) < 0.05
    assert np.ptp(values["machine.R_s"]) < 0.3 and 0.44 < values["machine.R_s"].mean() < 0.46


@pytest.mark.parametrize(("spec", "mean", "deviation"), [
    ({"uniform": [2.0, 4.0]}, 3.0, 2 / 12**0.5), ({"normal": [5.0, 0.5]}, 5.0, 0.5), ({"relative": 0.5}, 10.0, 10 / 12**0.5),
])
def test_distributions_have_their_moments(spec, mean, deviation):
    values = distributions.draw("a", spec, 10.0, 1, np.arange(20_000))
    assert values.mean() == pytest.approx(mean, abs=5 * deviation / 20_000**0.5)
    assert values.std() == pytest.approx(deviation, rel=0.03)


def test_log_uniform_is_uniform_in_the_logarithm():
    values = np.log(distributions.draw("a", {"log_uniform": [0.01, 100.0]}, 0.0, 1, np.arange(20_000)))
    counts, _ = np.histogram(values, bins=10, range=(np.log(0.01), np.log(100)))
    assert counts.sum() == 20_000 and np.all(np.abs(counts - 2000) < 250)


def test_grids_are_products_and_draws_come_at_every_point(paper):
    study = short(paper.only(["repaired"]), runs=3, fields={
        "drive.feedback": {"values": ["measured", "repaired"]}, "reference.omega.1": {"linspace": [50, 70, 2]},
        "machine.R_r": {"relative": 0.1}})
    plan = Plan(study)
    values = plan.values(0, plan.runs)
    assert plan.runs == 12 and [chunk.variant for chunk in plan.chunks] == [0, 1]
    assert list(values["drive.feedback"]) == ["measured"] * 6 + ["repaired"] * 6
    assert list(values["reference.omega.1"]) == [50.0] * 3 + [70.0] * 3 + [50.0] * 3 + [70.0] * 3
    assert len(set(values["machine.R_r"])) == 3
    result = sweep(study)
    assert result.sizes["run"] == 12 and np.isfinite(result.speed_rms).all()


def test_what_lanes_do_not_know_is_run_one_by_one(paper, monkeypatch):
    study = short(paper.only(["repaired"]), runs=2, fields={"machine.R_r": {"relative": 0.1}})
    fast = sweep(study)
    monkeypatch.setattr(sweeps, "plain", lambda loop: False)
    slow = sweep(study)
    for name in ("speed_rms", "speed_peak", "flux_rms", "flux_peak", "settling_time", "excitation", "holds"):
        np.testing.assert_allclose(slow[name], fast[name], rtol=1e-8)
    real = sweep(study.changed({"sensors.current_resolution": 0.1}))
    assert np.isfinite(real.speed_rms).all() and not np.allclose(real.speed_rms, fast.speed_rms, rtol=1e-6)


def test_any_number_with_decimals_can_be_drawn(paper):
    """What lanes do not have is run one by one: each run is the study that it says, and the impossible are left out."""
    study = short(paper.only(["repaired", "baseline"]), runs=8, fields={
        "mechanics.coulomb": {"normal": [0.3, 0.3]}, "inverter.dead_time": {"uniform": [0.0, 4e-6]},
        "simulation.duration": {"uniform": [0.02, 0.1]}, "machine.R_r": {"relative": 0.3},
    }, start=0.0, hold=0.04).changed({"inverter.dc_link": 600.0})
    result, plan = sweep(study), Plan(study)
    assert result.identical(sweep(study, jobs=2))
    possible = result.possible.values == 1
    values = {name: result[name].values for name in plan.fields}
    assert np.array_equal(possible, (values["mechanics.coulomb"] >= 0) & (values["simulation.duration"] >= 0.04))
    counts = json.loads(result.attrs["refused"])
    assert sum(counts.values()) == (~possible).sum() > 1 and any("mechanics.coulomb" in text for text in counts)
    for run in np.flatnonzero(possible)[:2]:
        trajectory = simulate(plan.study_of(int(run)))
        assert plan.study_of(int(run)).inverter.dead_time == values["inverter.dead_time"][run]
        for name in study.observers:
            off = (trajectory.omega - trajectory.omega_hat.sel(observer=name)).values
            found = float(result.speed_peak.sel(observer=name, run=run))
            assert found == pytest.approx(np.abs(off).max(), rel=1e-12)
    assert np.isnan(result.speed_rms.values[:, ~possible]).all()


def test_impossible_machines_are_counted_and_left_out(paper):
    fields = {"machine.R_r": {"normal": [0.3, 0.3]}, "machine.L_m": {"relative": 0.05}}
    study = short(paper.only(["repaired"]), runs=60, fields=fields)
    result = sweep(study)
    possible = result.possible.values == 1
    values = {name: result[name].values for name in ("machine.R_r", "machine.L_m")}
    for run in range(60):
        try:
            with_values(study, {name: float(value[run]) for name, value in values.items()})
            built = True
        except InputError:
            built = False
        assert built == possible[run]
    counts = json.loads(result.attrs["refused"])
    assert sum(counts.values()) == (~possible).sum() > 0 and any("R_r of machine" in text for text in counts)
    assert np.isnan(result.speed_rms.values[:, ~possible]).all() and np.isfinite(result.speed_rms.values[:, possible]).all()


def test_many_machines_are_checked_in_no_time(paper):
    import time

    random = np.random.default_rng(0)
    values = {"machine.R_r": random.uniform(0.1, 1.0, 200_000), "machine.L_s": random.uniform(0.05, 0.07, 200_000)}
    start = time.process_time()
    wrong, reasons = impossible(paper, values, True)
    assert time.process_time() - start < 1.0
    assert wrong.sum() == (values["machine.L_s"] * paper.machine.L_r <= paper.machine.L_m**2).sum() and len(reasons) == 1


@pytest.mark.parametrize(("fields", "text"), [
    ({}, "sweep.fields is empty"),
    ({"machine.R_x": {"relative": 0.5}}, "machine.R_x"),
    ({"machine.R_r": {"relative": -0.5}}, "must be above 0"),
    ({"machine.R_r": {"relative": "50 %"}}, "a share of the study's own value"),
    ({"machine.R_r": {"uniform": [1.0, 0.5]}}, "must be above the first"),
    ({"machine.R_r": {"uniform": [0.1, 0.5], "seed": 3}}, "the keys uniform, seed"),
    ({"machine.R_r": {"log_uniform": [0.0, 0.5]}}, "above 0"),
    ({"machine.R_r": {"linspace": [0.1, 0.5, 0]}}, "count"),
    ({"machine.R_r": {"values": []}}, "at least one"),
    ({"machine.R_r": {"values": ["much"]}}, "must be a number in ohm"),
    ({"machine.R_r": 0.5}, "must be a table"),
    ({"reference.omega.7": {"uniform": [1, 2]}}, "entries 0 to 1"),
    ({"simulation.substeps": {"uniform": [1, 4]}}, "over a grid only"),
    ({"drive.feedback": {"uniform": [1, 4]}}, "over a grid only"),
    ({"mechanics.coulomb": {"uniform": [-2.0, -1.0]}}, "40 with study: mechanics.coulomb = ... N m must be 0 N m or above"),
    ({"machine.R_r": {"uniform": [-2.0, -1.0]}}, "none of the 40 runs"),
])
def test_faults_are_named_in_one_line(paper, fields, text):
    with pytest.raises(InputError, match=text) as caught:
        sweep(short(paper.only(["repaired"]), fields=fields))
    assert "\n" not in str(caught.value)


def test_own_values(paper):
    assert own_value(paper, "machine.R_r") == paper.machine.R_r
    assert own_value(paper, "observers.repaired.errors.R_s") == 0.0
    assert own_value(paper, "load.T_l.0") == 0.0


# The command ----------------------------------------------------------------------------------------------------------
@pytest.fixture
def file(study, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "study.toml"
    path.write_text(study.to_toml(), encoding="utf-8")
    monkeypatch.setattr(sweeps, "CHUNK", 10)
    sweeps.plan_of.cache_clear()
    yield path
    sweeps.plan_of.cache_clear()


def test_killed_and_resumed_is_the_same_to_the_byte(file, monkeypatch, capsys):
    assert cli.main(["sweep", "study.toml", "--out", "whole.nc", "--plot", "whole.svg"]) == 0
    made = []
    compute = sweeps.compute

    def dies(text, number, jobs=1):
        if len(made) == 2:
            raise KeyboardInterrupt
        made.append(number)
        return compute(text, number, jobs)

    monkeypatch.setattr(sweeps, "compute", dies)
    capsys.readouterr()
    assert cli.main(["sweep", "study.toml", "--out", "cut.nc"]) == 2
    assert "interrupted; 2 of 4 chunks are kept in cut.nc.parts: the same command with --resume" in capsys.readouterr().err
    parts = file.parent / "cut.nc.parts"
    assert not (file.parent / "cut.nc").exists() and len(list(parts.glob("chunk-*.npz"))) == 2
    assert cli.main(["sweep", "study.toml", "--out", "cut.nc"]) == 2
    assert "--resume" in capsys.readouterr().err
    (parts / "chunk-000001.npz").write_bytes(b"half a fi")  # damaged: computed again
    monkeypatch.setattr(sweeps, "compute", lambda *args: made.append(args[1]) or compute(*args))
    assert cli.main(["sweep", "study.toml", "--out", "cut.nc", "--plot", "cut.svg", "--resume"]) == 0
    assert sorted(made[2:]) == [1, 2, 3] and not parts.exists()
    for ending in (".nc", ".svg"):
        assert (file.parent / f"whole{ending}").read_bytes() == (file.parent / f"cut{ending}").read_bytes()


def test_the_file_reads_back_as_what_was_written(file):
    import xarray as xr

    assert cli.main(["sweep", "study.toml", "--out", "whole.nc"]) == 0
    with xr.open_dataset(file.parent / "whole.nc", engine="h5netcdf") as back:
        assert set(back.coords) == {"run", "observer", "machine.R_r", "machine.R_s"}
        assert len(sweep_figure(back.load()).axes) == 3
        from imo_analysis.study import Study

        assert back.identical(sweep(Study.load(file)))


@pytest.mark.parametrize(("change", "text"), [("versions", "its versions differs"), ("chunk", "its chunk differs")])
def test_resuming_with_another_program_is_refused(file, monkeypatch, capsys, change, text):
    compute = sweeps.compute
    monkeypatch.setattr(sweeps, "compute", lambda *args: (_ for _ in ()).throw(KeyboardInterrupt))
    assert cli.main(["sweep", "study.toml"]) == 2
    capsys.readouterr()
    if change == "versions":
        monkeypatch.setattr(parts, "version", lambda name: "0.0.1")
    else:
        monkeypatch.setattr(parts, "CHUNK", 11)
    monkeypatch.setattr(sweeps, "compute", compute)
    assert cli.main(["sweep", "study.toml", "--resume"]) == 2
    assert text in capsys.readouterr().err
    monkeypatch.undo()


def test_resuming_another_sweep_is_refused(file, monkeypatch, capsys):
    monkeypatch.setattr(sweeps, "compute", lambda *args: (_ for _ in ()).throw(KeyboardInterrupt))
    assert cli.main(["sweep", "study.toml"]) == 2
    assert cli.main(["sweep", "study.toml", "--resume", "--runs", "39"]) == 2
    assert "another sweep" in capsys.readouterr().err


def test_json_and_text(file, capsys):
    assert cli.main(["sweep", "study.toml", "--json", "-"]) == 0
    captured = capsys.readouterr()
    result = json.loads(captured.out)
    assert result["schema"] == "imo-sweep/1" and result["runs"] == 40 and set(result["observers"]) == {"repaired", "baseline"}
    assert 0 <= result["observers"]["repaired"]["holds"] <= 1
    assert "run/s" not in captured.err  # no progress bar into a pipe


def test_a_terminal_gets_a_progress_bar_with_its_rate(file, monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    assert cli.main(["sweep", "study.toml"]) == 0
    assert "40/40" in terminal.getvalue() and "run/s" in terminal.getvalue()


@pytest.mark.parametrize(("words", "text"), [
    (["--out", "a.csv"], ".nc"), (["--plot", "a.png"], ".svg"), (["--jobs", "0"], "1 or more"),
    (["--scheduler", "zz"], "--scheduler = zz does not answer (missing port number"),
    (["--out", "no/a.nc"], "there is no folder no"), (["--scenario", "fig9"], "fig9"), (["--runs", "0"], "1 or more"),
])
def test_wrong_options(file, capsys, words, text):
    assert cli.main(["sweep", "study.toml", *words]) == 2
    err = capsys.readouterr().err
    assert text in err and len(err.strip().splitlines()) == 1


def test_without_dask_it_says_what_to_install(file, monkeypatch, capsys):
    import sys

    monkeypatch.setitem(sys.modules, "distributed", None)
    assert cli.main(["sweep", "study.toml", "--scheduler", "tcp://127.0.0.1:1"]) == 2
    assert "pip install 'imo-analysis[sweep]'" in capsys.readouterr().err


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_to_the_bit(data, study):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None) as cluster:
        assert sweep(study, scheduler=cluster.scheduler_address).identical(data)


def test_a_cluster_without_workers_is_named(study, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(sweeps, "WORKERS_WITHIN", 0.3)
    with (
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=None) as cluster,
        pytest.raises(InputError, match=r"has no workers after 0.3 s; start some with: dask worker inproc://") as caught,
    ):
        connected(cluster.scheduler_address)
    assert "\n" not in str(caught.value)


# The picture ----------------------------------------------------------------------------------------------------------
def test_shares_count_runs(data):
    edges = [edges_of(data["machine.R_r"].values, 4)]
    share, count = shares(data, "repaired", edges, ["machine.R_r"])
    assert count.sum() == 40
    assert np.nansum(share * count) == pytest.approx(float(data.holds.sel(observer="repaired").sum()))


def test_figures_of_one_and_of_two_fields(data, paper):
    figure = sweep_figure(data)
    labels = figure.axes[0].get_ylabel(), figure._supxlabel.get_text()
    assert labels == ("$R_s$ off 0.439 Ω by (%)", "$R_r$ off 0.615 Ω by (%)")
    height, bound = _label_height(figure)
    assert height < bound
    grid = sweep(short(paper.only(["repaired"]), runs=1, fields={"machine.R_r": {"linspace": [0.4, 0.8, 9]}}))
    above, below = sweep_figure(grid).axes
    assert above.get_ylabel().endswith("(%)") and "(rad/s)" in below.get_ylabel()


def _label_height(figure):
    """Height of the label beside the first panel, and of the figure, in pixels."""
    figure.canvas.draw()
    return figure.axes[0].yaxis.label.get_window_extent().height, figure.get_window_extent().height


def test_nothing_to_draw_over(paper):
    one = sweep(short(paper.only(["repaired"]), runs=1, fields={"drive.feedback": {"values": ["measured"]}}))
    with pytest.raises(InputError, match="nothing to draw"):
        sweep_figure(one)


def test_the_paper_s_study_carries_a_sweep(paper):
    plan = Plan(paper)
    assert plan.runs == 10_000 and set(plan.fields) == {"machine.R_r", "machine.R_s"}


def test_a_cluster_that_does_not_answer_leaves_no_default_behind(study):
    dask = pytest.importorskip("dask")
    pytest.importorskip("distributed")
    with pytest.raises(InputError, match="does not answer"):
        connected("tcp://127.0.0.1:9")
    assert dask.config.get("scheduler", None) is None
