"""An observer of the user's own, from a file beside the study, through every command."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from light_dossier import light
from own_files import ADAPTED, GAINS, copy_of, own_text
from replay_runs import prepared

from imo_analysis import cli
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.own import located
from imo_analysis.errors import InputError
from imo_analysis.pencils.error import OperatingPoint, poles_at
from imo_analysis.pencils.operating import poles_with_errors
from imo_analysis.pencils.setup import Setup
from imo_analysis.pencils.stability import stability_map
from imo_analysis.replay.estimate import Treatment, estimate
from imo_analysis.report.dossier import write_dossier
from imo_analysis.simulation.run import simulate
from imo_analysis.simulation.runfile import load_run, save_run
from imo_analysis.study import Study
from imo_analysis.sweeps.batch import run_batch
from imo_analysis.sweeps.sensorless_map import sensorless_map
from imo_analysis.sweeps.sweep import Plan, compute

COPIED = ("baseline", "repaired")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study with the baseline and an observer of its own, in a folder of their own."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "mine.py").write_text(own_text())
    base = Study.paper().only(["baseline"]).changed({
        "title": "own", "simulation": {"duration": 0.6, "record_every": 1}, "windows": [],
        "initial": {"i_ds": 8.83, "phi_dr": 0.5307, "omega": 20.0},
        "reference": {"time": [0.0], "omega": [20.0]}, "load": {"time": [0.0, 0.1], "T_l": [0.0, 5.0]},
        "observers.baseline.initial": {"i_ds_hat": 8.83, "phi_dr_hat": 0.5307, "omega_hat": 20.0},
        "sweep": {"runs": 20, "start": 0.1, "hold": 0.05, "fields": {"observers.baseline.errors.R_s": {"values": [0.1]}}},
    })
    data = {key: value for key, value in base.data.items() if key != "scenarios"}
    table = {**data["sweep"], "fields": {"machine.R_s": {"relative": 0.2}}, "scenario": ""}
    text = Study.from_data({**data, "sweep": table}).to_toml()
    gains = ", ".join(f"{name} = {value}" for name, value in GAINS.items())
    (folder / "study.toml").write_text(
        f'{text}\n[observers.mine]\nkind = "mine.py"\ngains = {{ {gains} }}\n'
        "initial = { i_ds_hat = 8.83, phi_dr_hat = 0.5307, omega_hat = 20.0 }\nerrors = { R_s = 0.1 }\n")
    return folder


@pytest.fixture(scope="module")
def study(folder):
    return Study.load(folder / "study.toml")


def imo(*words):
    return cli.main([str(word) for word in words])


def test_study_says_whether_right_estimates_stay_right(folder, capsys):
    assert imo("study", folder / "study.toml", "--json", folder / "study.json") == 0
    said = capsys.readouterr().out
    assert "mine.py: at zero error the estimates follow the machine: yes" in said
    assert "\nbaseline with the right parameters beside mine with wrong ones; " in said
    assert "[observers.baseline.errors]" in said
    assert json.loads((folder / "study.json").read_text())["own"] == {"mine.py": []}
    (folder / "slip.py").write_text(own_text(ADAPTED.replace("-gains[5] * along", "R_s - gains[5] * along")))
    (folder / "slip.toml").write_text((folder / "study.toml").read_text().replace('"mine.py"', '"slip.py"'))
    assert imo("study", folder / "slip.toml") == 0
    said = capsys.readouterr()
    assert "slip.py: at zero error the estimates follow the machine: no\n" in said.out
    assert "  the rate of R_s_shift is off by R_s: 0.439 ohm/s at 30 rad/s, idle\n" in said.out
    assert said.err.count("\n") == 1 and said.err.startswith("imo: warning: ") and "R_s_shift leaves the machine" in said.err
    assert "no estimate of a quantity" not in said.out
    (folder / "slip.py").write_text((folder / "slip.py").read_text().replace("R_s_shift", "Rs_hat"))
    assert imo("study", folder / "slip.toml") == 0
    assert "  Rs_hat is no estimate of a quantity that is known here, and so counted as zero" in capsys.readouterr().out


def test_simulate_records_its_states_with_their_units_and_excite_says_what_does_not_apply(folder, capsys):
    run = folder / "run.nc"
    assert imo("simulate", folder / "study.toml", "--out", run, "--plot", folder / "run.svg") == 0
    assert "  mine " in capsys.readouterr().out
    data = load_run(run)
    assert data.R_s_shift.attrs["units"] == "ohm" and np.isnan(data.R_s_shift.sel(observer="baseline")).all()
    believed = 0.1 * Study.load(folder / "study.toml").machine.R_s
    assert -believed < float(data.R_s_shift.sel(observer="mine")[-1]) < -0.2 * believed  # on its way to what is true
    assert imo("excite", run, "--observer", "mine") == 2
    assert capsys.readouterr().err.startswith("imo: observer 'mine' of ") and imo("excite", run) == 0


def test_a_run_says_which_text_made_it_and_its_study_is_refused_once_that_has_changed(folder, study, tmp_path):
    (tmp_path / "mine.py").write_text(own_text())
    (tmp_path / "study.toml").write_text((folder / "study.toml").read_text())
    text = Study.load(tmp_path / "study.toml").to_toml()
    assert f'kind = "{located("mine.py", tmp_path)}"' in text and Study.from_toml(text).to_toml() == text
    code = f"from imo_analysis.study import Study; Study.from_toml({text!r})"

    def said():
        return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=dict(os.environ)).stderr

    assert said() == ""
    (tmp_path / "mine.py").write_text(own_text() + "# changed\n")
    assert "has changed: the hash of its text now begins with" in said()
    (tmp_path / "mine.py").unlink()
    assert "cannot read the observer" in said() and "in its place on every computer" in said()


def test_poles_at_known_speed_are_the_baseline_s_and_with_the_adaptation_there_is_one_more(folder, capsys):
    out = folder / "poles.json"
    assert imo("poles", folder / "study.toml", "--omega", "20", "--json", out) == 0
    assert "mine: 196 entries of its error dynamics agree, differentiated and as exact difference" in capsys.readouterr().out
    study = Study.load(folder / "study.toml")
    machine, kind = study.machine, study.observers["mine"].kind
    point = OperatingPoint(20.0, 0.5307, 3.0)
    baseline = study.observers["baseline"].gains
    np.testing.assert_array_equal(poles_at(machine, kind, GAINS, point), poles_at(machine, "baseline", baseline, point))
    whole = poles_at(machine, kind, GAINS, point, "full")
    off = poles_at(machine, kind, {**GAINS, "h_R": 0.0}, point, "full")
    assert whole.shape == (6,) and min(abs(off)) == 0  # without a gain it does not move
    np.testing.assert_allclose(np.sort_complex(off[np.abs(off) > 0]),
                               np.sort_complex(poles_at(machine, "baseline", baseline, point, "full")), rtol=1e-9)
    over = ("--over", "h_R=0.01:0.1:5", "--full", "3", "--at", "20")
    assert imo("poles", folder / "study.toml", *over, "--observer", "mine") == 0


def test_an_axis_of_an_own_gain_has_its_symbol_once(study):
    setup = Setup.of_study(study, "mine")
    over = {"omega": [10.0, 20.0, 30.0], "h_R": [0.01, 0.02, 0.03]}
    axes = stability_map(setup, over, OperatingPoint(20.0, 0.5307, 3.0), "full").plot().axes[0]
    assert axes.get_ylabel() == r"$h_{R}$ (ohm/(A^2 s))" and axes.get_xlabel().startswith("electrical speed $")


def test_poles_take_a_file_by_its_name_with_the_gains_that_the_study_has(folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    assert imo("poles", "study.toml", "--observer", "mine.py", "--omega", "20") == 0
    assert "mine.py (mine), alpha = " in capsys.readouterr().out
    assert imo("poles", "--observer", "mine.py", "--omega", "20", "--full", "2") == 2
    assert "imo: gains of mine are missing: h_R" in capsys.readouterr().err
    assert imo("poles", "--observer", "gone.py") == 2
    assert "imo: cannot read the observer " in capsys.readouterr().err


def test_sweep_in_lanes_resumed_and_by_a_worker_process(folder, study):
    out = folder / "sweep.nc"
    assert imo("sweep", folder / "study.toml", "--out", out) == 0
    assert imo("sweep", folder / "study.toml", "--out", out, "--resume") == 0
    with xr.open_dataset(out, engine="h5netcdf") as data:
        run = 7
        one = simulate(Plan(study).study_of(run)).sel(time=slice(0.1 - 1e-9, None), observer="mine")
        error = np.sqrt(np.mean((one.omega - one.omega_hat) ** 2))
        np.testing.assert_allclose(data.speed_rms.sel(observer="mine")[run], error, rtol=1e-6)
    code = ("import json, sys\nfrom imo_analysis.sweeps.sweep import compute\n"
            "part = compute(sys.stdin.read(), 0)\nprint(json.dumps(part['speed_rms'].tolist()))")
    text = Plan(study).text
    there = subprocess.run([sys.executable, "-c", code], input=text, capture_output=True, text=True, check=True).stdout
    assert json.loads(there) == compute(text, 0)["speed_rms"].tolist()  # as a worker elsewhere has it, to the bit


def test_the_loop_closed_on_it_holds_where_the_baseline_s_does_not(study):
    """Driving at 12 rad/s and 10 N m, the stator resistance believed 40 % too high."""
    wrong = study.changed({f"observers.{name}.errors.R_s": 0.4 for name in study.observers})
    plane = sensorless_map(wrong, [12.0], [10.0])
    assert plane.holds.values.ravel().tolist() == [0, 1] and list(plane.observer.values) == ["baseline", "mine"]


@pytest.mark.slow
def test_the_dossier_has_it_among_the_observers(study, tmp_path):
    with light():
        written = write_dossier(study.changed({"machine.R_r": 0.6}), tmp_path / "out", lambda line: None)
    page = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert not written.faults
    assert page.count(" adapted; in <code>mine.py</code>, where right estimates stay right") == 2  # table, and first screen
    assert "mine,mine.py," in (tmp_path / "out" / "table2.csv").read_text(encoding="utf-8")


def test_replay_by_file_by_name_and_with_gains_from_flags(folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    assert imo("simulate", "study.toml", "--out", "log.csv") == 0
    for name, out in (("mine.py", "a.nc"), ("mine", "b.nc")):
        assert imo("replay", "log.csv", "--machine", "study.toml", "--observer", name, "--voltage", "held", "--out", out) == 0
    said = capsys.readouterr().out
    assert "mine: last omega_hat" in said and "gains of [observers.mine.gains] of study.toml" in said
    flags = [word for name, value in GAINS.items() for word in ("--gain", f"{name}={value}")]
    bare = ("replay", "log.csv", "--machine", "table-iii-printed-alpha", "--observer", "mine.py", "--voltage", "held")
    assert imo(*bare, "--out", "c.nc", *flags) == 0
    first, second, third = (load_run(name) for name in ("a.nc", "b.nc", "c.nc"))
    xr.testing.assert_equal(first, second)
    np.testing.assert_array_equal(first.omega_hat, third.omega_hat)
    assert first.R_s_shift.attrs["units"] == "ohm"
    capsys.readouterr()
    assert imo(*bare) == 2
    assert capsys.readouterr().err.startswith("imo: mine: the rule has no gains for an observer of your own; give all of them")


def test_tune_says_why_not(folder, capsys):
    assert imo("tune", folder / "study.toml", "--observer", "mine") == 2
    assert capsys.readouterr().err == ("imo: observer 'mine' (mine.py) cannot be tuned: the search does not know how gains of "
                                       "your own act; vary them with imo sweep, in [sweep.fields]\n")


def test_a_file_that_cannot_be_used_ends_every_command_with_one_line(folder, tmp_path, capsys):
    (tmp_path / "mine.py").write_text(own_text("    if x[4] > 0:\n        return x\n    return x\n"))
    (tmp_path / "study.toml").write_text((folder / "study.toml").read_text())
    for command in ("study", "simulate", "poles", "sweep", "tune", "report"):
        assert imo(command, tmp_path / "study.toml", *(["--out", tmp_path / "out.nc"] if command == "sweep" else [])) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1 and "observers.mine" in said
        assert "mine.py, line 10: rates has an if; write max(v, 0) as" in said
    (tmp_path / "mine.py").unlink()
    assert imo("study", tmp_path / "study.toml") == 2
    assert "study.toml: observers.mine: cannot read the observer " in capsys.readouterr().err
    with pytest.raises(InputError, match=r"kind = 'mine' is not a known observer; choose one of: .*; or a file of your own"):
        Study.paper().changed({"observers.mine": {"gains": {}}})


# A copy of an observer of the catalogue is that observer, to the bit ------------------------------------------------
@pytest.fixture(scope="module")
def copies(tmp_path_factory, turning):
    """A study with observers of the catalogue, the same with their copies, and the copies' kinds."""
    folder = tmp_path_factory.mktemp("copies")
    kinds = {}
    for kind in COPIED:
        (folder / f"{kind}_copy.py").write_text(copy_of(kind, f"{kind} copied"))
        kinds[kind] = located(f"{kind}_copy.py", folder)
    original = turning.only(COPIED)
    return original, original.changed({f"observers.{kind}.kind": own for kind, own in kinds.items()}), kinds


def test_a_copy_is_simulated_alike(copies):
    xr.testing.assert_equal(simulate(copies[0]), simulate(copies[1]))


def test_a_copy_closes_the_loop_alike(copies):
    first, second = (simulate(one.changed({"drive.feedback": "repaired"})) for one in copies[:2])
    xr.testing.assert_equal(first, second)


def test_a_copy_runs_in_lanes_alike(copies):
    values = {"machine.R_s": np.linspace(0.4, 0.5, 16)}
    first, second = (run_batch(one.only(["repaired"]), values) for one in copies[:2])
    for name, ends in first.ends.items():
        np.testing.assert_array_equal(ends, second.ends[name])
    for name, tally in first.tallies.items():
        np.testing.assert_array_equal(tally, second.tallies[name])


@pytest.mark.parametrize("kind", COPIED)
def test_a_copy_has_the_same_poles(copies, kind):
    original, _, kinds = copies
    machine, gains, point = original.machine, original.observers[kind].gains, OperatingPoint(40.0, 0.5, 2.0)
    for which in ("frozen", "full"):
        first, second = (poles_at(machine, one, gains, point, which) for one in (kind, kinds[kind]))
        np.testing.assert_array_equal(first, second)
    first, second = (poles_with_errors(machine, one, gains, point, {"R_s": 0.1})[0] for one in (kind, kinds[kind]))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("kind", COPIED)
def test_a_copy_is_replayed_alike(copies, kind, tmp_path):
    original, _, kinds = copies
    save_run(simulate(original), tmp_path / "log.csv")
    found = []
    for name in (kind, kinds[kind]):
        log, _, runners = prepared(tmp_path / "log.csv", original.machine, [name], Treatment("held", "held", "forward"),
                                   gains=dict(original.observers[kind].gains))
        found.append(next(iter(estimate(log, runners))).values)
    for name, values in found[0].items():
        np.testing.assert_array_equal(values, found[1][name])
    assert OBSERVERS[kinds[kind]].rates.__code__.co_code == OBSERVERS[kind].rates.__code__.co_code
