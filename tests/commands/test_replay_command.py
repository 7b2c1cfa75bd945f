"""``imo replay`` as a user runs it: files, flags, the table [replay], JSON, faults in one line."""

import json
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr
from replay_records import HEADER, start_up, steady, write

from imo_analysis import cli
from imo_analysis.errors import InputError
from imo_analysis.simulation.runfile import load_run
from imo_analysis.study import Study, paper_text

MACHINE = '[machine]\npreset = "table-iii"\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("replay")
    write(folder / "start.csv", start_up(0.4))
    (folder / "machine.toml").write_text(MACHINE)
    return folder


def imo(folder, *words):
    return cli.main(["replay", str(folder / "start.csv"), "--machine", str(folder / "machine.toml"), *map(str, words)])


def test_estimates_figure_and_json(folder, capsys):
    out, plot, report = folder / "est.nc", folder / "est.svg", folder / "est.json"
    assert imo(folder, "--observer", "repaired,baseline", "--out", out, "--plot", plot, "--json", report, "--after", "0.2") == 0
    text = capsys.readouterr().out
    assert "omega = column 'omega' in rad/s (electrical speed, taken as it is)" in text
    assert "instantaneous samples joined by straight lines" in text and "fits the machine" in text
    data = json.loads(report.read_text())
    assert data["schema"] == "imo-replay/1" and data["rows"] == 4000
    assert data["observers"]["repaired"]["counted_from"] == pytest.approx(0.2)
    assert "alpha_hat" in data["excitation"]["repaired"]["verdict"] or "holds" in data["excitation"]["repaired"]["verdict"]
    with xr.open_dataset(out, engine="h5netcdf") as run:
        assert run.attrs["schema"] == "imo-run/1" and list(run.observer.values) == ["repaired", "baseline"]
        error = (run.omega_hat - run.omega).sel(observer="repaired").values[2000:]
        assert data["observers"]["repaired"]["speed_error_std"] == pytest.approx(error.std(), rel=1e-9)
        assert "T_l" not in run and "phi_dr" not in run  # nobody knows them
    assert ElementTree.parse(plot).getroot().tag == "{http://www.w3.org/2000/svg}svg"
    imo(folder, "--observer", "repaired,baseline", "--out", folder / "again.nc", "--plot", folder / "again.svg")
    assert (folder / "again.svg").read_bytes() == plot.read_bytes()


def test_what_replay_writes_can_be_loaded_and_excited(folder, capsys):
    assert imo(folder, "--out", folder / "est.nc") == 0
    assert load_run(folder / "est.nc").sizes["time"] == 4000
    said = capsys.readouterr().out
    assert cli.main(["excite", str(folder / "est.nc"), "--window", "0.08"]) == 0
    sentence = next(line for line in capsys.readouterr().out.splitlines() if "reduced condition" in line)
    assert sentence in said


def test_without_a_speed_it_still_runs(folder, capsys):
    assert imo(folder, "--column", "omega=none", "--json", "-") == 0
    data = json.loads(capsys.readouterr().out)
    one = data["observers"]["repaired"]
    assert one["speed_error_rms"] is None and one["settled_at"] is None
    assert data["treatment"]["direction"] == "estimated"
    assert one["omega_hat"] == pytest.approx(start_up(0.4)[-1, 5], abs=2)
    assert imo(folder, "--column", "omega=none", "--out", folder / "blind.nc") == 0
    assert "omega" not in load_run(folder / "blind.nc")


def test_the_table_replay_and_flags_over_it(folder, capsys):
    rows = start_up(0.4)
    write(folder / "odd.csv", rows * [1e3, 1, 1, 1e3, 1e3, 30 / np.pi / 2], "tick,p,q,r,s,n")
    (folder / "odd.toml").write_text(MACHINE + """
[replay]
observers = ["luenberger_consistent_12"]
columns = { time = "tick", u_alpha = "p", u_beta = "q", i_alpha = "r", i_beta = "s" }
units = { time = "ms", current = "mA", speed = "rpm" }
voltage = "averaged"
bandwidth = 2000
""")
    words = ["replay", str(folder / "odd.csv"), "--machine", str(folder / "odd.toml"), "--json", "-"]
    assert cli.main(words) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["treatment"]["voltage"] == "averaged" and list(data["observers"]) == ["luenberger_consistent_12"]
    assert data["observers"]["luenberger_consistent_12"]["gains"]["k_1"] < 2800
    assert cli.main([*words, "--voltage", "linear", "--observer", "baseline", "--gain", "h=100"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["treatment"]["voltage"] == "linear" and data["observers"]["baseline"]["gains"]["h"] == 100


@pytest.mark.parametrize("kept", [True, False])
def test_a_verdict_over_gaps_names_no_temporary_file(folder, capsys, kept):
    rows = start_up(0.4)
    write(folder / "gap.csv", np.delete(rows, [2000, 2001], axis=0))
    words = ["replay", str(folder / "gap.csv"), "--machine", str(folder / "machine.toml"), "--gaps", "bridge"]
    assert cli.main([*words, *(["--out", str(folder / "gap.nc")] if kept else [])]) == 0
    said = capsys.readouterr().out
    assert "2 stretches between gaps, each judged on its own" in said and "no verdict" not in said
    assert "imo_replay" not in said and "est.nc" not in said


def test_no_verdict_names_no_temporary_file(folder, capsys):
    assert imo(folder, "--window", "5") == 0
    said = capsys.readouterr().out
    assert "no verdict: " in said and "imo_replay" not in said and "est.nc" not in said


def test_a_figure_of_observers_far_apart_and_of_few():
    """In logarithms only where one goes away."""
    from imo_analysis.report.replay_figure import replay_figure

    time = np.linspace(0, 1, 500)

    def scales(largest):
        errors = np.sin(40 * time) * np.array([[0.1], [0.2], [0.15], [0.1], [largest]])
        data = xr.Dataset({"omega_hat": (("observer", "time"), 100 * time + errors), "omega": ("time", 100 * time)},
                          coords={"time": time, "observer": ["baseline", "repaired", "quiet", "across", "printed_7"]})
        return replay_figure(data).axes[1].get_yscale()

    assert scales(0.5) == "linear" and scales(15.0) == "symlog"


def test_a_study_may_hold_the_table():
    study = Study.from_toml(paper_text() + '\n[replay]\nvoltage = "held"\n')
    assert study.replay.voltage == "held"
    with pytest.raises(InputError, match="replay"):
        Study.from_toml(paper_text() + '\n[replay]\nvolts = "held"\n')


def test_divergence_is_said_and_is_exit_code_1(folder, capsys):
    assert imo(folder, "--gain", "K_p=-50", "--out", folder / "lost.nc") == 1
    assert "repaired: diverged at t = " in capsys.readouterr().out
    assert (folder / "lost.nc").exists()


def test_a_mistake_stops_it_unless_it_is_trusted(folder, capsys):
    wrong = ["--unit", "current=mA", "--out", folder / "wrong.nc"]
    assert imo(folder, *wrong) == 2
    said = capsys.readouterr().err
    assert "does not fit the machine" in said and "currents in A were taken for mA" in said and said.count("\n") == 1
    assert not (folder / "wrong.nc").exists()
    assert imo(folder, *wrong, "--trust") in (0, 1)


@pytest.mark.parametrize(("words", "says"), [
    (["--out", "est.csv"], "must end in .nc"),
    (["--out", "/no-such-folder/est.nc"], "no folder"),
    (["--plot", "est.png"], "must end in .svg"),
    (["--every", "0"], "--every 0"),
    (["--column", "ia"], "NAME=VALUE"),
    (["--column", "ia=Ch9"], "no column 'Ch9'"),
    (["--unit", "current=V"], "choose one of: A, mA, kA"),
    (["--observer", "ekf"], "'ekf' is not known"),
    (["--gain", "k_1=fast"], "k_1"),
    (["--gain", "k_1=nan"], "must be finite"),
    (["--gain", "h=3"], "h is not known for repaired"),
    (["--observer", "repaired,consistent_12", "--gain", "h=3"], "h is not a gain of repaired, consistent_12"),
    (["--initial", "phi_dr_hat=1"], "phi_dr_hat is not known for repaired"),
    (["--rate", "-5"], "above 0 Hz"),
    (["--rate", "0"], "--rate 0 must be above 0 Hz"),
    (["--window", "0"], "--window 0 must be above 0 s"),
    (["--rate", "10"], "200 Hz to 20 MHz"),
    (["--bandwidth", "0"], "bandwidth = 0"),
    (["--voltage", "smooth"], "--voltage"),
    (["--column", "omega=none", "--direction", "measured"], "takes a recorded speed"),
])
def test_faults_are_one_line(folder, capsys, words, says):
    assert imo(folder, *words) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1


def test_files_that_are_not_there(folder, capsys):
    assert cli.main(["replay", "none.csv", "--machine", "table-iii"]) == 2
    assert cli.main(["replay", str(folder / "start.csv"), "--machine", "none.toml"]) == 2
    (folder / "bad.toml").write_text(MACHINE + "[replay]\nvoltage = 3\nspeed = 1\n")
    assert cli.main(["replay", str(folder / "start.csv"), "--machine", str(folder / "bad.toml")]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 3 and "none.csv" in said[0] and "none.toml" in said[1] and "voltage" in said[2]


def test_an_interrupted_run_leaves_nothing(folder, monkeypatch, capsys):
    from imo_analysis.replay import estimate_file as replay_file

    def stop(*args):
        raise KeyboardInterrupt

    monkeypatch.setattr(replay_file, "attributes", stop)
    before = set(folder.iterdir())
    assert imo(folder, "--out", folder / "half.nc") == 2
    assert set(folder.iterdir()) == before and "interrupted" in capsys.readouterr().err


def test_a_steady_record_is_not_identifiable_and_the_verdict_says_so(folder, capsys):
    write(folder / "steady.csv", steady(1.0), HEADER)
    assert cli.main(["replay", str(folder / "steady.csv"), "--machine", "table-iii"]) == 0
    said = capsys.readouterr().out
    assert "begun on the fly at omega_hat = 200" in said
    assert "lost: alpha_hat and omega_hat along (1, -0.755)" in said  # -slip/alpha = -5/6.6236


# A record that a simulation wrote ---------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """A study of a motor, its record of each sample and of one in ten; what `imo simulate` said of the repaired observer."""
    folder = tmp_path_factory.mktemp("own")
    study, report = folder / "study.toml", folder / "sim.json"
    assert cli.main(["study", "--init", str(study), "--machine", "motulator-2.2-kw"]) == 0
    words = ["simulate", str(study), "--scenario", "load"]
    assert cli.main([*words, "--every", "1", "--out", str(folder / "log.csv"), "--json", str(report)]) == 0
    assert cli.main([*words, "--out", str(folder / "thin.csv")]) == 0
    return folder, json.loads(report.read_text())["observers"]["repaired"]


def _again(folder, name, capsys, *words):
    capsys.readouterr()
    assert cli.main(["replay", str(folder / name), "--machine", str(folder / "study.toml"), "--voltage", "held", "--json", "-",
                     "--after", "3", *words]) == 0
    said = capsys.readouterr()
    return json.loads(said.out)["observers"], said.err


def test_a_record_of_a_simulation_gives_what_the_simulation_gave(own, capsys):
    folder, simulated = own
    observers, said = _again(folder, "log.csv", capsys)
    assert observers["repaired"]["gains_from"] == f"[observers.repaired.gains] of {folder / 'study.toml'}"
    assert "--initial study begins them so" in said and "by least squares over the first" in said
    assert observers["repaired"]["speed_error_rms"] == pytest.approx(simulated["speed_error_rms"], rel=0.2)
    begun, said = _again(folder, "log.csv", capsys, "--initial", "study")
    assert "least squares" not in said
    assert begun["repaired"]["omega_hat"] == pytest.approx(simulated["omega_hat"], abs=0.5)
    assert begun["repaired"]["speed_error_rms"] == pytest.approx(simulated["speed_error_rms"], rel=0.2)


def test_the_gains_are_the_studys_unless_the_rule_is_asked_for(own, capsys):
    folder, _ = own
    study = Study.load(folder / "study.toml")
    assert _again(folder, "log.csv", capsys)[0]["repaired"]["gains"] == study.observers["repaired"].gains
    for words, source in ((["--rule"], "the rule"), (["--bandwidth", "900"], "the rule, at 900 rad/s")):
        one = _again(folder, "log.csv", capsys, *words)[0]["repaired"]
        assert one["gains_from"] == source and one["gains"] != study.observers["repaired"].gains
    one = _again(folder, "log.csv", capsys, "--gain", "k_1=3000")[0]["repaired"]
    assert one["gains_from"].endswith("study.toml with k_1 as given")
    assert one["gains"] == {**study.observers["repaired"].gains, "k_1": 3000}
    (folder / "tuned.toml").write_text((folder / "study.toml").read_text().replace("K_p = ", "K_p = 2"))
    assert cli.main(["replay", str(folder / "log.csv"), "--machine", str(folder / "tuned.toml"), "--json", "-"]) in (0, 1)
    assert json.loads(capsys.readouterr().out)["observers"]["repaired"]["gains"]["K_p"] > 1e4


def test_a_record_with_one_sample_in_ten_is_warned_of(own, capsys):
    folder, _ = own
    assert "one in 10 of the samples of its 10000 Hz drive" in _again(folder, "thin.csv", capsys)[1]
    assert "one in" not in _again(folder, "log.csv", capsys)[1]


def test_a_start_that_no_study_has_is_refused(folder, capsys):
    assert imo(folder, "--initial", "study") == 2
    assert "has no [observers.repaired] to take the start from" in capsys.readouterr().err


def test_a_rate_may_have_a_unit(folder, capsys):
    assert imo(folder, "--rate", "10kHz", "--json", "-") == 0
    assert json.loads(capsys.readouterr().out)["sample_time"] == 1e-4
    assert imo(folder, "--rate", "10 ms") == 2
    assert '--rate = "10 ms" has the wrong unit; it must be in Hz' in capsys.readouterr().err
