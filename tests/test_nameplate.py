"""Name plates: the parameters reproduce the plate, checked on the plain plant; and the study that is written from one."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from imo_analysis import cli, nameplate
from imo_analysis.efficiency import NEVER, UNUSUAL, efficiency_at
from imo_analysis.equations.plant import plant
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.nameplate import Nameplate, machine_of, rated_flux, remarks
from imo_analysis.study import Study

PLATE = {"power": "2.2 kW", "voltage": "400 V", "current": "5 A", "frequency": "50 Hz", "speed": "1430 rpm",
         "power_factor": 0.8}


def steady(machine: InductionMachine, voltage: float, stator_frequency: float, slip: float) -> np.ndarray:
    """Currents and fluxes at constant voltage on the d axis: the linear part of the plain plant, solved."""
    omega = stator_frequency - slip

    def rates(x, u):
        return np.array(plant((*x, omega), u, stator_frequency, 0, machine.plant_parameters)[:4])

    matrix = np.array([rates(unit, (0, 0)) for unit in np.eye(4)]).T
    return np.linalg.solve(matrix, -rates(np.zeros(4), (voltage, 0)))


@pytest.mark.parametrize("starting_current", [None, 4.5])
def test_the_machine_reproduces_the_plate(starting_current: float | None) -> None:
    more = {} if starting_current is None else {"starting_current": starting_current}
    plate = Nameplate.build(PLATE | more)
    machine = machine_of(plate, {"J": 0.015})
    i_d, i_q, phi_d, phi_q = steady(machine, plate.phase_voltage, plate.stator_frequency, plate.slip)
    assert math.hypot(i_d, i_q) == pytest.approx(5 * math.sqrt(2), rel=1e-9)
    assert i_d / math.hypot(i_d, i_q) == pytest.approx(0.8, rel=1e-9)
    torque = 1.5 * machine.n_p * machine.L_m / machine.L_r * (phi_d * i_q - phi_q * i_d)
    assert torque * plate.speed == pytest.approx(2200, rel=1e-9)
    assert rated_flux(plate, machine) == pytest.approx((math.hypot(phi_d, phi_q), math.hypot(i_d, i_q)), rel=1e-9)
    if starting_current is not None:
        form = machine.inverse_gamma()
        impedance = complex(form["R_s"] + form["R_R"], plate.stator_frequency * form["L_sgm"])
        assert plate.phase_voltage / abs(impedance) == pytest.approx(4.5 * 5 * math.sqrt(2), rel=1e-9)


def test_a_known_machine_comes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    true = InductionMachine.from_inverse_gamma(n_p=2, R_s=3.7, R_R=2.1, L_sgm=0.021, L_M=0.224, J=0.015)
    slip, stator_frequency, u = 14.0, 2 * math.pi * 50, 400 * math.sqrt(2 / 3)
    i_d, i_q, phi_d, phi_q = steady(true, u, stator_frequency, slip)
    speed = (stator_frequency - slip) / 2
    plate = Nameplate.build({
        "voltage": 400, "frequency": 50, "speed": speed, "current": math.hypot(i_d, i_q) / math.sqrt(2),
        "power_factor": i_d / math.hypot(i_d, i_q), "power": 3 * (phi_d * i_q - phi_q * i_d) * speed})
    monkeypatch.setattr(nameplate, "TYPICAL_LEAKAGE", 0.021 * stator_frequency * math.hypot(i_d, i_q) / u)
    assert machine_of(plate, {"J": 0.015}).inverse_gamma() == pytest.approx(true.inverse_gamma(), rel=1e-9)


@pytest.mark.parametrize(("changed", "said"), [
    ({"speed": "1500 rpm"}, "a little .* below the synchronous"),
    ({"speed": "170 rad/s"}, "a little"),
    ({"speed": 1430}, r'1430 rad/s, 1.366e\+04 rpm, must be .* did you mean "1430 rpm"\?'),
    ({"speed": 3100}, r"must be .* has it its unit"),
    ({"speed": "1430 furlongs"}, "rpm or r/min .also 1/min, min.-1, min-1, U/min"),
    ({"power_factor": -0.8}, r"power_factor = -0.8 must be above 0$"),
    ({"power_factor": 80}, 'below 1, as in 0.84 or "84 %"'),
    ({"efficiency": 1.1}, "efficiency = 1.1 must be below 1"),
    ({"voltage": "400/690 V"}, 'write the value of yours, "400 V" in delta or "690 V" in star'),
    ({"connection": "zigzag"}, 'must be "star" or "delta"'),
    ({"cos_phi": 0.8, "curr": 5}, "cos_phi is not a known key; did you mean power_factor.*curr .* did you mean current"),
    ({"power": "4 kW"}, "an efficiency of 1.44"),
    ({"power": "2.75 kW"}, "over the air gap, more than"),
    ({"power": 2.2}, "an efficiency of 0.000794.* the unit of the power"),
    ({"power_factor": 1.2}, "below 1"),
    ({"voltage": "400 A"}, "wrong unit"),
    ({"volts": 400}, "not a known key"),
    ({"current": 0}, "above 0"),
    ({"efficiency": "96 %"}, r"efficiency = 96 % must be below 95\.3 %, for the slip alone takes the rest, 14\.7 of 314\.2"),
    ({"efficiency": "50 %"}, r"contradicts voltage, current .* with which 2200 W at the shaft are 79\.4 %; .* check the five"),
    ({"efficiency": "50 %", "current": 8}, r"efficiency = 50 % must be above 56\.\d %: no motor of 2200 W loses more"),
    ({"current": 9}, "an efficiency of 0.441; it must be between 0.57 and 1"),
    ({"starting_current": 40}, r"must be below 5\.\d+, which the resistances .* give a measured R_s, or leave the starting"),
])
def test_a_plate_that_cannot_be_is_refused(changed: dict, said: str) -> None:
    with pytest.raises(InputError, match=said):
        machine_of(Nameplate.build(PLATE | changed), {"J": 0.015})


@pytest.mark.parametrize("R_s", ["12 ohm", "0.01 ohm"])
def test_a_resistance_that_contradicts_the_plate_is_refused(R_s: str) -> None:
    """Stator copper, air gap and shaft must add up; what a plate's losses in iron and friction leave open is allowed."""
    if R_s == "0.01 ohm":
        assert machine_of(Nameplate.build(PLATE), {"J": 0.015, "R_s": R_s}).R_s == 0.01
        return
    with pytest.raises(InputError, match=r"12 ohm leaves .* W of the plate's .* W for the air gap"):
        machine_of(Nameplate.build(PLATE), {"J": 0.015, "R_s": R_s})


@pytest.mark.parametrize("unit", ["r/min", "RPM", "min^-1", "min-1", "min⁻¹", "U/min", "1/min"])
def test_speeds_as_plates_print_them(unit: str) -> None:
    assert Nameplate.build(PLATE | {"speed": f"1430 {unit}"}).speed == Nameplate.build(PLATE).speed


def test_other_units_of_plates() -> None:
    assert Nameplate.build(PLATE | {"power": "3 hp"}).power == pytest.approx(2237.1, abs=0.01)
    assert Nameplate.build(PLATE | {"power_factor": "80 %"}).power_factor == 0.8
    for text in ("150 kg cm^2", "0.015 kgm2", "0.015 kgm²", "150 kgcm²", "15 g m^2"):
        inertia = machine_of(Nameplate.build(PLATE), {"J": text}).J
        assert inertia == pytest.approx(0.015, rel=1e-12)


def test_two_connections_on_one_plate() -> None:
    both = PLATE | {"voltage": "230/400 V", "current": "8.66/5 A"}
    star, delta = (Nameplate.build(both | {"connection": name}) for name in ("star", "delta"))
    assert (star.voltage, star.current, delta.voltage, delta.current) == (400, 5, 230, 8.66)
    assert remarks(star, {})[0] == "taken as 400 V, star, 5 A" and remarks(delta, {})[0] == "taken as 230 V, delta, 8.66 A"
    only = {name: value for name, value in both.items() if name != "power_factor"} | {"connection": "star"}
    assert remarks(Nameplate.build(only), {}) == ["taken as 400 V, star, 5 A"]
    for voltage, current, fixed in (("230/400 V", "5/8.66 A", "8.66/5 A"), ("400/230 V", "8.66/5 A", "5/8.66 A")):
        with pytest.raises(InputError, match=f'the lower voltage goes with the higher current; write "{fixed}"'):
            Nameplate.build(both | {"voltage": voltage, "current": current, "connection": "star"})
    assert Nameplate.build(PLATE | {"connection": "delta"}) == Nameplate.build(PLATE)  # line values: it makes no difference


@pytest.mark.parametrize(("power", "efficiency"), [(0.75, 72.1), (2.2, 79.7), (4, 83.1), (45, 91.7), (200, 94.0)])
def test_the_lowest_class_of_standard_motors(power: float, efficiency: float) -> None:
    """The nominal limits that IEC 60034-30-1 tabulates for IE1, four poles, 50 Hz."""
    assert 100 * efficiency_at(1, 1e3 * power) == pytest.approx(efficiency, abs=0.06)
    assert efficiency_at(NEVER, 1e3 * power) < efficiency_at(UNUSUAL, 1e3 * power) < efficiency_at(1, 1e3 * power)
    assert efficiency_at(1, 1e8) == efficiency_at(1, 2e5)


@pytest.mark.parametrize(("poles", "power", "voltage", "current", "frequency", "speed", "power_factor", "efficiency"), [
    (2, 25, 400, 0.13, 50, 2700, 0.70, 0.40), (8, 30, 400, 0.32, 50, 640, 0.55, 0.25), (4, 90, 400, 0.41, 50, 1320, 0.63, 0.5),
    (8, 180, 400, 0.85, 50, 660, 0.61, 0.50), (2, 750, 400, 1.61, 50, 2875, 0.84, 0.807),
    (4, 746, 460, 1.5, 60, 1725, 0.74, 0.825), (8, 7500, 400, 17.8, 50, 720, 0.74, 0.826),
    (2, 7500, 400, 18.5, 50, 2840, 0.80, 0.75), (2, 149e3, 460, 222, 60, 3570, 0.9, 0.95),
    (4, 1e6, 690, 980, 50, 1492, 0.88, 0.968),
])
def test_motors_as_they_are_sold_are_not_refused(
    poles: int, power: float, voltage: float, current: float, frequency: float, speed: float, power_factor: float,
    efficiency: float,
) -> None:
    """Small and large, of two to eight poles, 50 and 60 Hz, one a canned rotor; and what is said of those without a class."""
    plate = Nameplate.build({"power": power, "voltage": voltage, "current": current, "frequency": frequency,
                             "speed": f"{speed} rpm", "power_factor": power_factor, "efficiency": efficiency})
    assert 2 * machine_of(plate, {"J": 0.01}).n_p == poles
    unusual = [text for text in remarks(plate, {}) if "UNUSUAL" in text]
    assert all(("carried on to smaller ones, would have" in text) == (power < 120) for text in unusual)
    assert bool(unusual) == (power == 7500 and poles == 2)


def test_a_starting_current_is_taken_where_the_resistance_is_measured() -> None:
    """A motor of 1.1 kW with little copper loss: all that the stator loses, as R_s, would allow less than it draws."""
    plate = Nameplate.build({"power": 1100, "voltage": 400, "current": 2.4, "frequency": 50, "speed": "1445 rpm",
                             "power_factor": 0.79, "starting_current": 7.3})
    with pytest.raises(InputError, match=r"7\.3 must be below 6\.83.*estimated.* give a measured R_s"):
        machine_of(plate, {"J": 0.01})
    machine = machine_of(plate, {"J": 0.01, "R_s": 5.5})
    form = machine.inverse_gamma()
    leakage = plate.stator_frequency * form["L_sgm"] * 2.4 * math.sqrt(3) / 400
    assert 0.05 < leakage < 0.2
    with pytest.raises(InputError, match=r"30 must be below .*, and the least leakage allow; leave the starting current out"):
        machine_of(Nameplate.build(PLATE | {"starting_current": 30}), {"J": 0.015, "R_s": 3.0})


def test_an_efficiency_that_is_only_unusual_is_said() -> None:
    slow = PLATE | {"current": 6.2}  # 64 %
    assert "UNUSUAL" in remarks(Nameplate.build(slow), {})[1] and "IE1, has 80 %" in remarks(Nameplate.build(slow), {})[1]
    assert not any("UNUSUAL" in text for text in remarks(Nameplate.build(PLATE), {}))
    without = {name: value for name, value in PLATE.items() if name != "current"}
    assert Nameplate.build(without | {"efficiency": "64 %"}).current == pytest.approx(6.2, abs=0.01)
    with pytest.raises(InputError, match=r"50 % must be above 56\.\d %"):
        Nameplate.build(without | {"efficiency": "50 %"})


def test_an_efficiency_stands_in_for_what_is_missing() -> None:
    efficiency = 2200 / (math.sqrt(3) * 400 * 5 * 0.8)
    for name, value in (("current", 5), ("power_factor", 0.8)):
        plate = Nameplate.build({key: one for key, one in PLATE.items() if key != name} | {"efficiency": efficiency})
        assert getattr(plate, name) == pytest.approx(value, rel=1e-12)
    with pytest.raises(InputError, match=r"makes a power factor of 1\.05"):
        Nameplate.build({key: one for key, one in PLATE.items() if key != "power_factor"} | {"efficiency": 0.605})


def test_what_is_said_of_a_plate() -> None:
    """Both numbers of a contradiction, and a range for R_s that holds the measured 3.7 ohm of this motor."""
    said = remarks(Nameplate.build(PLATE), {})
    assert len(said) == 2 and "an efficiency of 79.4 %" in said[0]
    low, high = (float(x) for x in re.search(r"between (\S+) and (\S+) ohm", said[1]).groups())
    assert low < 3.7 < machine_of(Nameplate.build(PLATE), {"J": 0.015}).R_s < high < 2 * 3.7
    assert len(remarks(Nameplate.build(PLATE), {"R_s": 3.7})) == 1
    assert not any("CONTRADICTION" in text for text in remarks(Nameplate.build(PLATE | {"efficiency": "80.5 %"}), {}))
    said = remarks(Nameplate.build(PLATE | {"efficiency": "88 %"}), {})
    assert "efficiency is 88.0 %, which needs 4.511 A where it has 5 A" in said[1]


def test_what_is_said_of_a_plate_stands_in_the_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study = tmp_path / "study.toml"
    assert cli.main(["study", "--init", str(study), "--machine", str(_file(tmp_path, "J = 0.015"))]) == 0
    text = f"R_s = {Study.load(study).machine.R_s:.3g} ohm is estimated from the plate, between"
    assert f"plate: {text}" in capsys.readouterr().out and f"# Plate: {text}" in study.read_text()


@pytest.mark.parametrize(("text", "said"), [
    ("", "has no motor in it: write a [nameplate]"),
    ("[machine]\nR_s = 3.7\nLm = 0.2\n", "did you mean L_m?; give all of R_s"),
    ("[nameplate]\ncurrent = 15.2 A  # line\n", 'in line 2 write "15.2 A", in quotes'),
    ("[nameplate]\ncurrent = 15,2\n", "in line 2 write 15.2, with a point"),
    ("[nameplate]\ncurrent = 15,2 A\n", 'in line 2 write "15.2 A", in quotes and with a point'),
])
def test_a_motor_file_gone_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, said: str) -> None:
    (tmp_path / "motor.toml").write_text(text)
    assert cli.main(["study", "--init", str(tmp_path / "study.toml"), "--machine", str(tmp_path / "motor.toml")]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


def test_what_is_missing_is_named() -> None:
    for name in ("power", "speed"):
        with pytest.raises(InputError, match=f"{name} is missing"):
            Nameplate.build({key: value for key, value in PLATE.items() if key != name})
    with pytest.raises(InputError, match="no plate has the inertia"):
        machine_of(Nameplate.build(PLATE), {})


def _file(folder: Path, machine: str) -> Path:
    values = {key: f'"{value}"' if isinstance(value, str) else value for key, value in PLATE.items()}
    path = folder / "motor.toml"
    plate = "".join(f"{key} = {value}\n" for key, value in values.items())
    path.write_text(f"[nameplate]\n{plate}[machine]\n{machine}\n")
    return path


def test_the_study_of_a_motor(tmp_path: Path) -> None:
    motor = _file(tmp_path, 'name = "a"\nJ = 0.015\nR_s = "3.7 ohm"')
    study = tmp_path / "study.toml"
    assert cli.main(["study", "--init", str(study), "--machine", str(motor)]) == 0
    written = Study.load(study)
    assert written.machine.R_s == 3.7 and written.title == "a"
    assert list(written.scenarios) == ["speed", "load", "flux", "alpha", "warm", "slow", "brake", "closed", "closed_off"]
    assert max(written.reference.omega) == pytest.approx(2 * 1430 * math.pi / 30, rel=1e-3)
    assert max(written.scenario("load").load_torque.T_l) == pytest.approx(2200 / (1430 * math.pi / 30), rel=1e-3)
    assert written.drive.flux < written.drive.voltage_limit / (2 * math.pi * 50)
    assert written.scenario("closed").drive.feedback in written.observers
    # what starts wrong, and what is believed: 20 % of the flux, 30 % of alpha, 5 % of R_s, each in its own run
    machine, (i, flux) = written.machine, (written.initial.i_ds, written.initial.phi_dr)
    start = {name: written.scenario(name).observers for name in written.scenarios}
    assert start["flux"]["baseline"].initial["phi_dr_hat"] == pytest.approx(0.8 * flux, rel=1e-3)
    assert start["flux"]["repaired"].initial["z_1_hat"] == pytest.approx(i + 0.8 * machine.beta * flux, rel=1e-3)
    assert start["alpha"]["quiet"].initial["alpha_hat"] == pytest.approx(1.3 * machine.alpha, rel=1e-3)
    assert all(one.errors == {"R_s": 0.05} for one in start["closed_off"].values())


def test_a_plate_where_a_machine_is_needed(tmp_path: Path) -> None:
    motor, study = _file(tmp_path, "J = 0.015"), tmp_path / "study.toml"
    with pytest.raises(InputError, match=r"make a study of it, imo study --init study.toml --machine \S*motor.toml"):
        InductionMachine.load(str(motor))
    with pytest.raises(InputError, match="is a motor, not a study"):
        Study.load(motor)
    assert cli.main(["study", "--init", str(study), "--machine", str(motor)]) == 0
    assert InductionMachine.load(str(study)).n_p == 2


@pytest.mark.parametrize(("machine", "said"), [
    ("J = 0.015\nR_r = 2.1", "lacks R_s, L_m"),
    ("J = 0.015\nR_s = 3.7\nR_r = 2.1\nL_m = 0.22\nL_s = 0.24\nL_r = 0.24\nn_p = 1", "does not fit the plate"),
    ("R_s = 3.7", "no plate has the inertia"),
])
def test_a_motor_file_that_contradicts_itself(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], machine: str, said: str
) -> None:
    assert cli.main(["study", "--init", str(tmp_path / "study.toml"), "--machine", str(_file(tmp_path, machine))]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "study.toml").exists()


@pytest.mark.parametrize("name", ["name_plate", "Nameplate", "plate"])
def test_a_near_miss_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    motor = _file(tmp_path, "J = 0.015")
    motor.write_text(motor.read_text().replace("[nameplate]", f"[{name}]"))
    assert cli.main(["study", "--init", str(tmp_path / "study.toml"), "--machine", str(motor)]) == 2
    assert f"[{name}] is not a table of a machine file; did you mean [nameplate]?" in capsys.readouterr().err
    assert not (tmp_path / "study.toml").exists()


def test_plate_or_parameters_the_same_runs(tmp_path: Path) -> None:
    """All of the machine without its plate makes a study with the same runs and observers."""
    plated, whole, again = (tmp_path / name for name in ("plated.toml", "whole.toml", "again.toml"))
    assert cli.main(["study", "--init", str(plated), "--machine", str(_file(tmp_path, "J = 0.015"))]) == 0
    first = Study.load(plated)
    whole.write_text(first.machine.to_toml())
    assert cli.main(["study", "--init", str(again), "--machine", str(whole), "--flux", str(first.drive.flux)]) == 0
    second = Study.load(again)
    assert list(second.scenarios) == list(first.scenarios) and list(second.observers) == list(first.observers)
    assert second.machine.R_r == first.machine.R_r and second.drive.flux == pytest.approx(first.drive.flux)
    for name, one in first.observers.items():
        same = {gain: value for gain, value in one.gains.items() if gain in ("k_1", "k_3", "K_p", "alpha_l", "delta")}
        assert {gain: second.observers[name].gains[gain] for gain in same} == pytest.approx(same, rel=1e-2)
