"""`imo excite` from the outside."""

import json

import pytest
from synthetic import motion, observed

from imo_analysis.cli import main


@pytest.fixture
def run(tmp_path):
    path = tmp_path / "run.nc"
    observed(motion(slip=3.0)).to_netcdf(path, engine="h5netcdf")
    return path


def test_verdict_files_and_json(run, tmp_path, capsys):
    import xarray as xr

    plot, out, told = tmp_path / "x.svg", tmp_path / "gram.nc", tmp_path / "x.json"
    assert main(["excite", str(run), "--window", "0.2", "--plot", str(plot), "--out", str(out), "--json", str(told)]) == 0
    text = capsys.readouterr().out
    assert "alpha_hat and omega_hat along (1, -0.302)" in text and "never holds" in text
    assert plot.read_text().count("<svg") == 1
    data = json.loads(told.read_text())
    assert data["schema"] == "imo-excitation/1"
    reduced = data["observers"][0]["conditions"]["reduced"]
    assert reduced["rank"] == {"lowest": 3, "highest": 3} and reduced["lost"][0]["share"] == 1.0
    with xr.open_dataset(out, engine="h5netcdf") as saved:
        assert saved.sizes["reduced_state"] == 4 and saved.attrs["window"] == pytest.approx(0.2)


def test_json_on_standard_output_is_alone(run, capsys):
    assert main(["excite", str(run), "--observer", "plant", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["observers"][0]["observer"] == "plant"


def test_several_observers_get_a_file_each(run, tmp_path, capsys):
    assert main(["excite", str(run), "--observer", "plant", "--observer", "converged", "--out", str(tmp_path / "g.nc")]) == 0
    assert sorted(p.name for p in tmp_path.glob("g*")) == ["g-converged.nc", "g-plant.nc"]


@pytest.mark.parametrize(
    ("extra", "text"),
    [
        (["--window", "99"], "take a shorter window (--window)"),
        (["--every", "0"], "every = 0.0 s must be above 0 s"),
        (["--window", "nan"], "must be above 0 s"),
        (["--observer", "nobody"], "choose one of"),
        (["--si", "--scale", "1", "1"], "exclude each other"),
        (["--scale", "0", "1"], "must be above 0"),
        (["--threshold", "2"], "between 0 and 1"),
        (["--out", "/nowhere/x.nc"], "cannot write"),
        (["--window", "1e-9"], "take 3 samples, 0.0003 s, or more"),
        (["--machine", "none.toml"], "cannot read none.toml"),
        (["--accuracy", "1", "1"], "--accuracy cannot go with a run; give --design STUDY"),
        (["--within", "5", "--noise", "0.1", "--limit", "torque=1", "--speeds", "1", "--torques", "1", "--duty", "x.toml"],
         "--within, --noise, --limit, --duty, --speeds, --torques cannot go with a run"),
    ],
)
def test_bad_input_is_one_line_and_code_2(run, extra, text, capsys):
    assert main(["excite", str(run), *extra]) == 2
    error = capsys.readouterr().err
    assert text in error and error.count("\n") == 1


def test_a_missing_file(capsys):
    assert main(["excite", "none.nc"]) == 2
    assert "there is no such file" in capsys.readouterr().err


def test_help_fits_a_screen(capsys):
    with pytest.raises(SystemExit):
        main(["excite", "--help"])
    assert len(capsys.readouterr().out.splitlines()) <= 40


def test_an_hour_of_duty_is_a_study_that_reads_back(tmp_path, capsys):
    from imo_analysis.study import Study

    hour = tmp_path / "hour.toml"
    assert main(["excite", "--design", "paper", "--speeds", "50", "--torques", "0", "--duty", str(hour)]) == 0
    study = Study.load(hour)
    assert study.simulation.duration == 3600 and "supervised" in study.observers and study.drive.flux_modulation > 0
    assert main(["excite", "run.nc", "--duty", str(hour)]) == 2
    assert "--duty cannot go with a run; give --design STUDY" in capsys.readouterr().err


def test_a_record_without_a_study_needs_its_machine(tmp_path, capsys):
    """The error names the option, and the option does it."""
    import xarray as xr

    bare, machine = tmp_path / "bare.nc", tmp_path / "machine.toml"
    run = observed(motion(slip=3.0))
    xr.Dataset(run.data_vars, run.coords).to_netcdf(bare, engine="h5netcdf")
    assert main(["excite", str(bare)]) == 2
    assert "give the machine (--machine FILE)" in capsys.readouterr().err
    machine.write_text(run.attrs["study"])
    for one in (str(machine), "table-iii-printed-alpha"):
        assert main(["excite", str(bare), "--machine", one]) == 0
        assert "alpha_hat and omega_hat along (1, -0.302)" in capsys.readouterr().out


@pytest.mark.parametrize(("words", "named"), [
    (["--plot", "p.svg", "--out", "o.nc"], "--plot, --out"), (["--window", "1", "--every", "0.1"], "--window, --every"),
    (["--threshold", "0.1", "--si"], "--si, --threshold"), (["--scale", "1", "1", "--values", "true"], "--values, --scale"),
    (["--machine", "table-iii"], "--machine")])
def test_a_design_refuses_what_belongs_to_a_run(words, named, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["excite", "--design", "paper", *words]) == 2
    assert f"{named} cannot go with --design; for a design drop it" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_every_option_belongs_to_a_run_or_to_a_design():
    """No option can be given beside what it says nothing to, without a word."""
    from imo_analysis.cli import parser_of
    from imo_analysis.commands.excite import _OF_A_DESIGN, _OF_A_RUN

    options = {action.dest for action in parser_of("excite")._actions} - {"help", "json", "size", "run", "design", "observer"}
    assert options == {*_OF_A_RUN, *_OF_A_DESIGN}
