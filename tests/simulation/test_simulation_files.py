"""Runs in files, and the commands simulate and study: what they write, what they refuse, and their exit codes."""

import json
import os
import signal
from xml.etree import ElementTree

import numpy as np
import pytest

from imo_analysis.cli import main
from imo_analysis.errors import InputError
from imo_analysis.simulation import run as runs
from imo_analysis.simulation.run import simulate
from imo_analysis.simulation.runfile import load_run, save_run
from imo_analysis.study import paper_text


@pytest.fixture(scope="module")
def run(paper):
    return simulate(paper.changed({"simulation.duration": 0.2}))


@pytest.mark.parametrize("ending", [".nc", ".csv", ".parquet"])
def test_there_and_back(run, tmp_path, ending):
    if ending == ".parquet":
        pytest.importorskip("pyarrow")
    path = tmp_path / f"run{ending}"
    save_run(run, path)
    again = load_run(path)
    assert again.equals(run) and dict(again.attrs) == dict(run.attrs)
    assert again["omega_hat"].attrs == run["omega_hat"].attrs and again["time"].attrs == run["time"].attrs
    assert os.listdir(tmp_path) == [path.name]


def test_a_run_without_observers(paper, tmp_path):
    alone = simulate(paper.only([]).changed({"simulation.duration": 0.01}))
    save_run(alone, tmp_path / "run.nc")
    assert load_run(tmp_path / "run.nc").sizes["observer"] == 0


@pytest.mark.parametrize(("name", "content", "words"), [
    ("a.nc", b"not a NetCDF file", "is not a run that can be read"),
    ("a.nc", b"", "is not a run that can be read"),
    ("a.csv", b"time,omega\n0,1\n", "for a recorded log use: imo replay"),
    ("a.csv", b"# {broken\n", "is not a run that can be read"),
    ("a.csv", b"\xff\xfe\x00", "is not a run that can be read"),
    ("a.parquet", b"PAR1", "is not a run that can be read"),
    ("a.txt", b"", "the ending '.txt' is not known; use one of: .nc, .csv, .parquet"),
])
def test_what_is_no_run_is_refused(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_run(tmp_path / name)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_another_netcdf_is_refused(run, tmp_path):
    other = run.copy()
    other.attrs["schema"] = "weather/1"
    save_run(other, tmp_path / "w.nc")
    with pytest.raises(InputError, match=r"its schema is 'weather/1', not 'imo-run/1'"):
        load_run(tmp_path / "w.nc")
    with pytest.raises(InputError, match="there is no such file"):
        load_run(tmp_path / "none.nc")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a short study in it, as the place to work in."""
    text = paper_text().replace("duration = 60.0", "duration = 0.5")
    (tmp_path / "study.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_simulate_writes_what_it_says(folder, capsys):
    assert main(["simulate", "study.toml", "--out", "run.nc", "--plot", "run.svg", "--json", "-"]) == 0
    said = capsys.readouterr()
    data = json.loads(said.out)
    assert data["schema"] == "imo-simulate/1" and data["diverged"] is None and data["records"] == 500
    found = load_run("run.nc")
    assert data["observers"]["repaired"]["omega_hat"] == pytest.approx(float(found["omega_hat"].sel(observer="repaired")[-1]))
    assert ElementTree.parse(folder / "run.svg").getroot().tag == "{http://www.w3.org/2000/svg}svg"
    assert "wrote run.nc" in said.err


def test_divergence_keeps_the_run_and_exits_1(folder, capsys):
    (folder / "d.toml").write_text(paper_text())
    assert main(["simulate", "d.toml", "--scenario", "divergence", "--out", "d.nc", "--json", "d.json"]) == 1
    said = capsys.readouterr()
    assert "imo: observer printed_7 diverged at t = " in said.err and "Traceback" not in said.err
    assert np.isnan(load_run("d.nc")["omega_hat"].sel(observer="printed_7")[-1])
    assert json.loads((folder / "d.json").read_text())["observers"]["printed_7"]["lost_at"] > 0


@pytest.mark.parametrize(("arguments", "words"), [
    (["none.toml"], "cannot read none.toml"),
    (["study.toml", "--scenario", "fig9"], "choose one of: fig1"),
    (["study.toml", "--out", "run.txt"], "the ending '.txt' is not known"),
    (["study.toml", "--out", "nowhere/run.nc"], "there is no folder nowhere"),
    (["study.toml", "--plot", "run.png"], "figures are SVG"),
])
def test_bad_input_exits_2_in_one_line(folder, capsys, arguments, words):
    assert main(["simulate", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1
    assert sorted(os.listdir(folder)) == ["study.toml"]


def test_an_interrupt_leaves_nothing_half_written(folder, capsys, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(runs, "inputs", interrupted)
    assert main(["simulate", "study.toml", "--out", "run.nc"]) == 2
    assert "interrupted" in capsys.readouterr().err
    assert sorted(os.listdir(folder)) == ["study.toml"]


def test_a_full_disk_leaves_nothing_half_written(run, tmp_path):
    """A limit on the size of files stands for the disk."""
    resource = pytest.importorskip("resource")
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, old[1]))
        for name in ("run.csv", "run.nc"):
            with pytest.raises(InputError, match="cannot write"):
                save_run(run, tmp_path / name)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)
        signal.signal(signal.SIGXFSZ, handler)
    assert os.listdir(tmp_path) == []


def test_windows_beyond_the_run_are_told(folder, capsys):
    text = (folder / "study.toml").read_text().replace("[excitation]", """[[windows]]
title = "half out"
start = 0.4
stop = 0.9
[[windows]]
title = "out"
start = 2.0
stop = 3.0
[excitation]""")
    (folder / "w.toml").write_text(text)
    assert main(["simulate", "w.toml", "--plot", "w.svg"]) == 0
    said = capsys.readouterr().out
    assert "window 'half out' (0.4 to 0.9 s) is drawn to the end of the run" in said
    assert "window 'out' (2 to 3 s) holds no records and is not drawn" in said


def test_an_observer_lost_before_its_first_record_has_no_errors(folder, capsys):
    """What is on record is the start alone, where nothing has had time to be wrong."""
    text = (folder / "study.toml").read_text().replace("k_1 = 300.0, k_2 = 50.0", "k_1 = 1e9, k_2 = 50.0")
    (folder / "lost.toml").write_text(text.replace("record_every = 10 ", "record_every = 5000 "))
    assert main(["simulate", "lost.toml", "--json", "lost.json"]) == 1
    said = capsys.readouterr().out
    one = json.loads((folder / "lost.json").read_text())["observers"]["consistent_12"]
    assert "consistent_12  no record after the start" in said and "rms" not in said and one["speed_error_rms"] is None


def test_study_init_with_another_machine(folder, capsys):
    (folder / "motor.toml").write_text('R_s = "7.5 ohm"\nn_p = 2\nR_r = 5.6\nL_m = 0.42\nL_s = 0.445\nL_r = 0.445\nJ = 0.003\n')
    assert main(["study", "--init", "mine.toml", "--machine", "motor.toml", "--json", "mine.json"]) == 0
    assert json.loads((folder / "mine.json").read_text())["study"]["machine"]["R_s"] == 7.5
    assert "# Gains by the rule of thumb" in (folder / "mine.toml").read_text()
    assert main(["simulate", "mine.toml", "--scenario", "closed", "--out", "closed.nc"]) == 0


def test_study_init(folder, capsys):
    assert main(["study", "--init", "mine.toml"]) == 0
    assert (folder / "mine.toml").read_text() == paper_text()
    assert main(["study", "--init", "mine.toml"]) == 2
    assert "exists already" in capsys.readouterr().err
    (folder / "mine.toml").write_text("x")
    assert main(["study", "--init", "mine.toml", "--force"]) == 0
    assert (folder / "mine.toml").read_text() == paper_text()
    capsys.readouterr()
    assert main(["study", "mine.toml", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["study"]["title"] == "paper"
