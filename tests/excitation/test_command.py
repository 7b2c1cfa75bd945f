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
    assert "--duty needs --design" in capsys.readouterr().err
