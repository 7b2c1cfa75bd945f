"""``imo poles`` from the outside: tables, sweeps, files, pictures and refusals."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import oracle_linearisation
import pytest
import xarray as xr
from scipy.optimize import linear_sum_assignment

from imo_analysis.cli import main
from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS
from imo_analysis.machine import InductionMachine
from imo_analysis.study import Study


def test_table_beside_the_printed_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["poles", "--omega", "30,60,100", "--json", "-"]) == 0
    out, err = capsys.readouterr()
    data = json.loads(out)
    assert data["schema"] == "imo-poles/1"
    entry = next(row for row in data["table"] if row["observer"] == "consistent_12" and row["omega"] == 60.0)
    assert entry["at_zero"] == 2 and entry["column"] == "proposed"
    assert sorted(re for re, _ in entry["printed"]) == [-248.28, -248.28, -247.11, -247.11]
    assert "24 of Table II's 24 numbers" in err and "-347.97 + 13.97j" in err


def test_sweep_with_a_range_that_begins_with_a_dash(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plot, plane, out, table = (tmp_path / name for name in ("a.svg", "b.svg", "c.nc", "c.csv"))
    command = ["poles", "--over", "omega=-150:150:31", "--observer", "baseline", "consistent_12"]
    assert main([*command, "--plot", str(plot), "--map", str(plane), "--out", str(out)]) == 0
    assert main([*command, "--out", str(table)]) == 0
    assert "neutral" in xr.load_dataset(out, engine="h5netcdf").coords
    assert plot.read_text().count("<svg") == 1 and "rad/s" not in capsys.readouterr().err
    with xr.open_dataset(out, engine="h5netcdf") as data:
        assert dict(data.sizes) == {"observer": 2, "omega": 31, "branch": 6}
        assert data["re"].attrs["units"] == "1/s"
        values = {(str(o), float(w), int(b)): float(data["re"].sel(observer=o, omega=w, branch=b))
                  for o in ("baseline", "consistent_12") for w in (-150.0, 0.0, 150.0) for b in (1, 4)}
    with table.open(newline="") as file:
        rows = {(r["observer"], float(r["omega"]), int(r["branch"])): float(r["re"]) for r in csv.DictReader(file)}
    assert len(rows) == 31 * (4 + 6)
    assert all(rows[key] == value for key, value in values.items())
    # the same data gives the same picture, byte for byte
    again = tmp_path / "d.svg"
    assert main([*command, "--plot", str(again)]) == 0
    assert again.read_bytes() == plot.read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.svg", "b.svg", "c.csv", "c.nc", "d.svg"]


def test_adaptation_and_other_parameters(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["poles", "--full", "2", "--omega", "60", "--observer", "repaired", "--json", "-"]) == 0
    poles = json.loads(capsys.readouterr().out)["table"][0]["poles"]
    assert len(poles) == 8 and min(abs(re) + abs(im - 62.0) for re, im in poles) < 1e-6
    assert main(["poles", "--over", "k_2=0:100:11", "--at", "60", "--observer", "printed_L", "--json", "-"]) == 0
    data = json.loads(capsys.readouterr().out)["sweep"]
    assert data["over"] == "k_2" and data["unstable"]["printed_L"] == 10


def _poles_of(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert main(["poles", *arguments, "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("full", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_every_observer_and_convention_against_complex_steps(full: bool, capsys: pytest.CaptureFixture[str]) -> None:
    """The eigenvalues that the command writes, against a linearisation by complex steps that shares no code with it: 1e-9."""
    speeds = "30,-100" if not full else "60"
    data = _poles_of(capsys, "--observer", "all", f"--omega={speeds}", *(["--full", "2"] if full else []))
    seen = {row["observer"] for row in data["table"]}
    assert seen == set(OBSERVERS) and data["refused"] == {}
    m, l_1 = Study.paper().machine, Study.paper().observers["baseline"].gains["l_1"]
    h_s = m.alpha / 10 * m.sigma * (m.gamma + m.alpha + l_1) * (m.L_m / Study.paper().drive.flux) ** 2
    P_0 = 0.3 * m.alpha * Study.paper().drive.flux ** 4 / m.L_m
    assert data["assumed"] == ({
        "supervised": {"eta": 1.0, "S_0": 1.0}, "baseline_resistance": {"h_s": pytest.approx(h_s)},
        "baseline_turned": {"h_s": pytest.approx(h_s), "P_0": pytest.approx(P_0)}} if full else {})
    for row in data["table"]:
        if row.get("floquet"):
            assert row["observer"].endswith("printed_7")
            continue
        machine, setup = data["machine"][row["observer"]], data["observers"][row["observer"]]
        parameters = InductionMachine(**machine)
        p = dict(zip(PARAMETERS, parameters.observer_parameters, strict=True))
        if full:
            matrix = oracle_linearisation.full(setup["kind"], p, setup["gains"], row["omega"], row["flux"], row["slip"])
        else:
            gains = {gain: setup["gains"].get(gain, 1.0) for gain in OBSERVERS[setup["kind"]].gains}
            matrix = oracle_linearisation.frozen(setup["kind"], p, gains, row["omega"])
        found = np.array([complex(*pole) for pole in row["poles"]] + [0.0] * row.get("at_zero", 0))
        distance = np.abs(found[:, None] - np.linalg.eigvals(matrix)[None, :])
        chosen = linear_sum_assignment(distance)
        assert distance[chosen].max() < 1e-9 * np.abs(found).max(), row["observer"]


def test_map_over_two_parameters_and_its_contours(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture, out = tmp_path / "map.svg", tmp_path / "map.nc"
    data = _poles_of(capsys, "--over", "omega=-60:60:13", "--over", "k_2=1:80:9", "--observer", "consistent_12", "printed_L",
                     "--map", str(picture), "--show", "damping", "--out", str(out))
    found = data["map"]
    assert found["dims"] == ["observer", "k_2", "omega"] and len(found["decay"]) == 2 and len(found["decay"][0]) == 9
    assert found["stable_share"]["consistent_12"] == 1.0 and 0 < found["stable_share"]["printed_L"] < 0.5
    assert picture.read_text().count("<svg") == 1
    with xr.open_dataset(out, engine="h5netcdf") as whole:
        assert dict(whole.sizes) == {"observer": 2, "omega": 13, "k_2": 9, "branch": 6}
    limits = [(w, k) for w, k in zip(found["limit_omega"][1], found["limit_k_2"][1], strict=True) if w is not None]
    assert len(limits) == 18
    alpha = data["machine"]["printed_L"]["R_r"] / data["machine"]["printed_L"]["L_r"]
    for w, k in limits:
        assert abs(w) == pytest.approx((alpha * 100.0 / k) ** 0.5, rel=1e-9)


def test_a_map_with_no_stable_point_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["poles", "--over", "omega=20:60:5", "--over", "k_2=20:60:5", "--observer", "printed_L"]) == 0
    said = capsys.readouterr().out
    assert "printed_L: no stable point on this map; the least unstable is omega = 20 rad/s, k_2 = 20, with" in said


def test_cloud_and_units(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "cloud.svg"
    ranges = ("--over", "R_r=300 mohm:0.6 ohm", "--over", "omega=-300 rpm:300 rpm")
    command = ("--cloud", "200:7", *ranges, "--observer", "repaired")
    data = _poles_of(capsys, *command, "--map", str(picture))["sweep"]
    assert data["dims"] == ["observer", "sample", "branch"] and len(data["R_r"]) == 200
    assert 0.3 <= min(data["R_r"]) < 0.32 and max(data["R_r"]) <= 0.6 and max(map(abs, data["omega"])) <= 31.42
    assert _poles_of(capsys, *command)["sweep"] == data, "the same seed draws the same cloud"
    assert _poles_of(capsys, "--cloud", "200:8", *command[2:])["sweep"]["R_r"] != data["R_r"]
    assert "<svg" in picture.read_text()


def test_where_stability_ends_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    data = _poles_of(capsys, "--over", "omega=1:20:20", "--observer", "printed_L", "baseline")
    limit = (data["observers"]["printed_L"]["gains"]["k_3"] * 9.9354 / 50.0) ** 0.5
    assert {round(one["value"], 6) for one in data["sweep"]["boundaries"]["printed_L"]} == {round(limit, 6)}
    assert data["sweep"]["boundaries"]["baseline"] == []


def test_observers_that_cannot_do_it_do_not_stop_the_others(capsys: pytest.CaptureFixture[str]) -> None:
    data = _poles_of(capsys, "--over", "kappa=10:60:3", "--at", "60")
    assert data["sweep"]["observer"] == ["repaired"] and "'kappa' is not a parameter of baseline" in data["refused"]["baseline"]


def test_a_sweep_of_one_point(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plot, plane = tmp_path / "a.svg", tmp_path / "b.svg"
    assert main(["poles", "--over", "omega=60:60:1", "--plot", str(plot), "--map", str(plane)]) == 0
    assert "unstable at 0 of 1 points" in capsys.readouterr().out and plot.is_file() and plane.is_file()


def test_machine_file_takes_the_place_of_the_studys(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from imo_analysis.machine import preset

    path = tmp_path / "machine.toml"
    path.write_text(preset("table-iii").to_toml())
    results = []
    for machine in (str(path), "table-iii"):
        assert main(["poles", "--omega", "30", "--machine", machine, "--json", "-"]) == 0
        results.append(json.loads(capsys.readouterr().out)["table"])
    assert results[0] == results[1]


@pytest.mark.parametrize(("arguments", "message"), [
    (["--over", "omega=0:1:0"], "--over omega = 0:1:0 is empty; COUNT must be 1 or more"),
    (["--over", "omega=0:1:1"], "has one point but two ends"),
    (["--over", "omega=-150:150"], "must be NAME=START:STOP:COUNT"),
    (["--over", "omega=-150:150:3:4"], "must be NAME=START:STOP:COUNT"),
    (["--over", "omega=-150:150:few"], "with a whole number of points"),
    (["--over", "omega"], "must be NAME=START:STOP:COUNT"),
    (["--over", "omega=150:-150:3"], "STOP above START"),
    (["--over", "omega=nan:1:3"], "must have finite ends"),
    (["--over", "omega=0:1:99999999999"], "too many points"),
    (["--over", "omega=1:2:4000", "--over", "k_2=1:2:4000", "--observer", "consistent_12"], "16000000 points; at most"),
    (["--over", "omega=1:2:3", "--over", "omega=1:2:3"], "--over omega is given twice"),
    (["--over", "omega=1:2:3", "--over", "omega_hat=1:2:3"], "are one quantity"),
    (["--over", "R_r=1:2:3", "--over", "alpha=1:2:3", "--at", "60"], "are one quantity"),
    (["--over", "R_r=0.3 ohm:0.6:3", "--at", "60"], "0.6 has no unit and 0.3 ohm has one"),
    (["--over", "R_r=300 mH:600 mH:3", "--at", "60"], "wrong unit; it must be in ohm"),
    (["--over", "R_r=0.3 ?:0.6 ?:3", "--at", "60"], "wrong unit"),
    (["--over", "R_r=-0.3:0.6:3", "--at", "60"], "R_r = -0.3 ohm must be above 0"),
    (["--over", "omega=1:2:3", "--over", "k_2=1:2:3", "--plot", "a.svg", "--observer", "consistent_12"], "use --map for two"),
    (["--over", "omega=1:2:3", "--show", "colour"], "--show colour is not in the map"),
    (["--cloud", "100"], "needs ranges: --over NAME=A:B"),
    (["--cloud", "many", "--over", "omega=1:2"], "must be COUNT or COUNT:SEED"),
    (["--cloud", "100", "--over", "omega=2:1"], "STOP above START"),
    (["--cloud", "100", "--over", "omega=1:2:3"], "must be NAME=START:STOP with --cloud"),
    (["--over", "sigma=0:0.01:3", "--at", "60"], "sigma = 0 H must be above 0"),
    (["--over", "alpha=-5:5:3", "--at", "60"], "alpha = -5 1/s must be above 0"),
    (["--over", "R_r_error=-1:0.5:3", "--at", "60"], "R_r = 0 ohm must be above 0"),
    (["--over", "omega=-1e9:1e9:3"], "must lie within +-1e+06 rad/s"),
    (["--over", "flux=0:1:3", "--at", "60", "--full", "2"], "of the operating point must be above 0"),
    (["--at", "60"], "for single speeds use --omega"),
    (["--at", "60", "--over", "omega=1:2:3"], "both give the speed"),
    (["--at", "nan", "--over", "k_1=1:2:3"], "--at nan must be a speed within"),
    (["--show", "damping", "--over", "omega=1:2:3"], "says what --map draws"),
    (["--over", "omega=6:6:1", "--over", "k_2=1:2:3", "--observer", "consistent_12", "--map", "a.svg"], "needs two or more"),
    (["--observer", "all", "baseline"], "--observer all stands alone"),
    (["--omega", "30,nan"], "must be finite"),
    (["--omega", "fast"], '--omega = "fast" is not a number with a unit'),
    (["--omega", "300 rpm, 60"], "60 has no unit and 300 rpm has one"),
    (["--at", "60 A", "--over", "k_1=1:2:3"], "wrong unit; it must be in rad/s"),
    (["--tune", "50:0.7"], "must be DECAY:DAMPING:OMEGA_MAX"),
    (["--tune", "50:0.7:fast"], "--tune = \"fast\" is not a number with a unit"),
    (["--over", "R_r=300:900:5", "--at", "60"], "has no unit, and 300 ohm is 488 times the machine's 0.615 ohm; if it is "
                                                'meant, write the unit: --over "R_r=300 ohm:900 ohm:5"'),
    (["--over", "L_s=0.0001:0.0002:5", "--at", "60"], "0.0002 H is 0.00325 times the machine's 0.0615 H"),
    (["--over", "L_m=0.05:0.07:5", "--at", "60"], "L_m = 0.07 H must be below sqrt(L_s L_r) = 0.0616997 H"),
    (["--over", "omega=1:60", "--over", "k_1=100:200", "--cloud", "50", "--plot", "a.svg"],
     "--plot draws over one parameter, and there are omega, k_1; use --map for a cloud"),
    (["--omega", ","], "must be numbers with commas between"), (["--omega", ""], "--omega is empty"),
    (["--observer", "kalman"], "observer = 'kalman' is not known; choose from: baseline"),
    (["--over", "k_2=0:1:3"], "needs the speed: --at"),
    (["--over", "mass=0:1:3", "--at", "3"], "'mass'"),
    (["--over", "J=0:1:3", "--at", "3"], "'J' is not a parameter of baseline"),
    (["--plot", "poles.png"], "must end in .svg"),
    (["--out", "poles.txt"], "must end in .nc or .csv"),
    (["--machine", "nowhere.toml"], "cannot read nowhere.toml"),
    (["nowhere.toml"], "cannot read nowhere.toml"),
    (["--over", "omega=0:1:3", "--out", "no/such/folder/x.nc"], "cannot write no/such/folder/x.nc"),
    (["--full", "nan"], "--full nan must be a slip within"),
    (["--full", "1e300"], "--full 1e300 must be a slip within"),
    (["--over", "k_2=-1e300:1e300:5", "--at", "60", "--observer", "consistent_12"], "must lie within +-1e+09"),
    (["--over", "omega=1:2:3", "--plot", "a.svg", "--map", "./a.svg"], "--plot and --map both write ./a.svg"),
    (["--over", "omega=1:2:3", "--out", "a.csv", "--json", "a.csv"], "--json and --out both write a.csv"),
    (["--full", "2", "--observer", "printed_7", "--over", "omega=20:60:3"], "no time-invariant linearisation"),
    (["--full", "2", "--observer", "printed_7", "--over", "omega=2:6:3", "--over", "R_r_error=0:1:3"], "no state at rest"),
    (["--full", "2", "--observer", "printed_7", "--omega", "-2"], "the flux stands still"),
])
def test_bad_input_is_one_line_and_code_2(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["poles", *arguments]) == 2
    error = capsys.readouterr().err
    lines = [line for line in error.splitlines() if line.startswith("imo:")]
    assert len(lines) == 1 and message in lines[0], error


def test_what_is_swept_is_said_with_its_unit(capsys):
    """The answer shows what a number was taken for."""
    assert main(["poles", "--over", "R_r=300 ohm:600 ohm:3", "--at", "60", "--observer", "baseline"]) == 0
    assert "at R_r = 300 ohm;" in capsys.readouterr().out
    assert main(["poles", "--over", "k_2=-20:20:5", "--at", "60", "--observer", "consistent_12"]) == 0
    assert "crosses the imaginary axis at k_2 = -0.275983333\n" in capsys.readouterr().out


def test_speeds_with_units_and_where_the_stator_frequency_is_zero(capsys: pytest.CaptureFixture[str]) -> None:
    rows = _poles_of(capsys, "--omega", "300 rpm, 600 rpm", "--full", "-300 rpm", "--observer", "repaired")["table"]
    assert [row["omega"] for row in rows] == pytest.approx([10 * np.pi, 20 * np.pi])
    assert [row["slip"] for row in rows] == pytest.approx([-10 * np.pi] * 2)
    assert [row["undetermined"] for row in rows] == [True, False]
    assert sum(abs(complex(*pole)) < 1e-6 for pole in rows[0]["poles"]) >= 4
    assert main(["poles", "--omega", "0,60", "--full", "0", "--observer", "baseline"]) == 0
    assert capsys.readouterr().out.count("stator frequency is zero: nothing determines omega_hat") == 1
    assert main(["poles", "--over", "omega=-20:20:5", "--full", "0", "--observer", "baseline"]) == 0
    assert "at 1 of 5 pairs of speed and slip the stator frequency is zero" in capsys.readouterr().out
    assert main(["poles", "--over", "k_1=200:400:3", "--at", "300 rpm", "--observer", "repaired"]) == 0
    capsys.readouterr()
    tuned = [_poles_of(capsys, "--tune", text, "--observer", "repaired", "--omega", "60")["observers"]
             for text in ("50:0.7:157.07963267948966", "50 1/s:0.7:1500 rpm")]
    assert tuned[0] == tuned[1]


def test_branches_that_may_be_swapped_are_said_and_do_not_make_a_crossing(capsys: pytest.CaptureFixture[str]) -> None:
    """Over seven speeds branches cannot be told apart at zero; the limit is where it is over many."""
    few = ["--over", "omega=-150:150:7", "--full", "2", "--observer", "consistent_12"]
    assert main(["poles", *few]) == 0
    said = capsys.readouterr().out
    assert "may be swapped from there on; give --over omega more points than 7" in said
    data, fine = (_poles_of(capsys, "--over", f"omega=-150:150:{count}", *few[2:])["sweep"] for count in (7, 3002))
    assert data["unclear"] > 0
    ends, exact = ({round(one["value"], 6) for one in found["boundaries"]["consistent_12"]} for found in (data, fine))
    assert ends and ends <= exact, (ends, exact)
