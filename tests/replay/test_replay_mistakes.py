"""A record that does not fit: what is recognised and named, and what a machine a little off is not taken for."""

import math
from dataclasses import replace

import numpy as np
import pytest
from replay_records import IMMEC_MACHINE, TABLE, held_voltage, start_up, steady, write
from replay_runs import cut, prepared, replayed

from imo_analysis.errors import InputError
from imo_analysis.replay.check import Level, fit
from imo_analysis.replay.estimate import Treatment
from imo_analysis.replay.gains import default_gains
from imo_analysis.replay.logs import Log
from imo_analysis.replay.mistakes import check
from imo_analysis.replay.survey import survey


def _mistaken(rows, name):
    u, i = rows[:, 1] + 1j * rows[:, 2], rows[:, 3] + 1j * rows[:, 4]
    rows = rows.copy()
    if name == "mA":
        i = 1e3 * i
    elif name == "kV":
        u = u / 1e3
    elif name == "lines":
        u = u * math.sqrt(3) * np.exp(1j * math.pi / 6)
    elif name == "sign":
        i = -i
    elif name == "shifted":
        i = i * np.exp(2j * math.pi / 3)
    elif name == "swapped":
        i = i.conj() * np.exp(2j * math.pi / 3)
    elif name == "ms":
        rows[:, 0] *= 10
    elif name == "rpm":
        rows[:, 5] *= 30 / math.pi
    elif name == "shaft":
        rows[:, 5] /= 2
    elif name == "reversed":
        rows[:, 5] *= -1
    elif name in SCALES:
        u = u * SCALES[name]
    elif name in RATES:
        rows[:, 0] *= RATES[name]
    rows[:, 1], rows[:, 2], rows[:, 3], rows[:, 4] = u.real, u.imag, i.real, i.imag
    return rows


SCALES = {"u rms": 1 / math.sqrt(2), "i rms": math.sqrt(2), "u small": 1 / math.sqrt(3), "u large": math.sqrt(3),
          "u one and a half": 1.5, "i one and a half": 1 / 1.5}
RATES = {"twice": 2.0, "half": 0.5, "tenfold": 10.0, "10 % slow": 1.1, "20 % fast": 0.8}
MISTAKES = {
    "u rms": "voltages are rms values taken for peak", "i rms": "currents are rms values taken for peak",
    "u small": r"voltages are sqrt\(3\) times too small", "u large": r"voltages are sqrt\(3\) times too large",
    "u one and a half": "voltages are 3/2 times too large", "i one and a half": "currents are 3/2 times too large",
    **dict.fromkeys(RATES, "--rate 10000"),
    "mA": "unit current=mA", "kV": "unit voltage=kV", "lines": "line-to-line", "sign": "wrong sign",
    "shifted": "shifted by one", "swapped": "two phases of .* currents", "rpm": "speed=rpm",
    "shaft": "mechanical speed was taken for an electrical",
    "reversed": "the speed has the wrong sign",
}


@pytest.mark.parametrize("measured", [True, False])
@pytest.mark.parametrize("name", list(MISTAKES))
def test_a_mistake_is_named_and_not_computed_with(folder, name, measured):
    if not measured and name in ("rpm", "shaft", "reversed"):
        pytest.skip("nothing is mistaken where no speed is read")
    if not measured and name in ("10 % slow", "20 % fast"):
        pytest.skip("without a speed, inductances that are as far off look the same")
    path = write(folder / f"{name}.csv", _mistaken(start_up(), name))
    _, found, _ = prepared(path, TABLE, columns=None if measured else {"omega": "none"}, treatment=Treatment())
    with pytest.raises(InputError, match=MISTAKES[name]) as caught:
        check(found.stretch, found, TABLE)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("measured", [True, False])
@pytest.mark.parametrize("errors", [
    {}, {"R_r": 0.5}, {"R_r": -0.3}, {"R_s": 0.3}, *({"L_m": e, "L_s": e, "L_r": e} for e in (0.02, 0.2, -0.2)),
])
def test_a_machine_that_is_a_little_off_is_no_mistake(started, errors, measured):
    _, found, _ = prepared(started, TABLE, columns=None if measured else {"omega": "none"}, treatment=Treatment())
    machine = TABLE.with_values(**{key: getattr(TABLE, key) * (1 + e) for key, e in errors.items()})
    result = check(found.stretch, found, machine)
    assert result is not None and result.good()


def test_a_record_that_begins_magnetised_fits_without_a_speed_too(folder):
    """Begun without flux, the observer that stands in for the speed would be led astray, and the record be refused."""
    path = write(folder / "on.csv", cut(start_up(0.5), 1500))
    _, found, _ = prepared(path, TABLE, columns={"omega": "none"}, treatment=Treatment())
    result = check(found.stretch, found, TABLE)
    assert abs(result.factor - 1) < 0.05 and result.share > 0.99


def test_the_wrong_machine_is_refused(started):
    _, found, _ = prepared(started, TABLE)
    with pytest.raises(InputError, match="does not fit the machine 'IMMEC'"):
        check(found.stretch, found, IMMEC_MACHINE)


@pytest.mark.parametrize("turn", [21.3, -21.3])
def test_voltages_that_no_mistake_explains_are_refused(started, turn):
    """Turned by this angle they are 0.37 off 1: more than half a sample, less than any exchange of phases."""
    _, found, _ = prepared(started, TABLE)
    u = (found.stretch.u_ds + 1j * found.stretch.u_qs) * np.exp(1j * math.radians(turn))
    with pytest.raises(InputError, match=f"turned by {turn:.0f} degrees. Check columns"):
        check(replace(found.stretch, u_ds=u.real, u_qs=u.imag), found, TABLE)


def test_voltages_that_the_currents_do_not_account_for_are_refused(started):
    """A turning voltage from elsewhere, a quarter of a percent of the power and 18 % of it."""
    _, found, _ = prepared(started, TABLE)
    s = found.stretch
    u, time = s.u_ds + 1j * s.u_qs, s.time
    for size, good in ((0.05, True), (0.42, False)):
        other = u + size * np.abs(u) * np.exp(-130j * time)
        changed = replace(s, u_ds=other.real, u_qs=other.imag)
        found_fit = fit(other, s.i_ds + 1j * s.i_qs, s.omega, 1e-4, TABLE)
        assert abs(found_fit.factor - 1) < 0.2 and (found_fit.share > 0.99 if good else 0.5 < found_fit.share < 0.89)
        if good:
            assert check(changed, found, TABLE)
        else:
            with pytest.raises(InputError, match="does not fit the machine"):
                check(changed, found, TABLE)


def _phases(rows):
    """Columns of three phases and a speed, with the common mode of an inverter in the voltages."""
    turn = np.exp(-2j * np.pi / 3 * np.arange(3))
    u, i = ((rows[:, k] + 1j * rows[:, k + 1])[:, None] * turn for k in (1, 3))
    common = 280 + 0.15 * np.abs(u[:, :1]) * np.cos(3 * np.angle(u[:, :1]))
    return np.hstack([rows[:, :1], u.real + common, i.real, rows[:, 5:]])


@pytest.mark.parametrize(("change", "columns", "words"), [
    ({}, {}, None),
    ({1: 0.0}, {}, "voltage of phase a .*--column u_a=none"), ({2: -1.0}, {}, "voltage of phase b"),
    ({3: 0.6}, {}, "voltage of phase c"), ({1: 0.0}, {"u_a": "none"}, None), ({3: 0.98}, {}, None),
    ({1: 0.0}, {"u_b": "none"}, "voltages swing along one line .*phase a"),
    ({3: 0.0}, {"u_b": "none"}, "voltages swing along one line .*phase c"),
    ({5: 0.0}, {"i_c": "none"}, "currents swing along one line .*phase b"),
])
def test_a_channel_that_is_dead_reversed_or_scaled_is_named(folder, change, columns, words):
    rows = _phases(start_up())
    if columns.keys() & {"u_a", "u_b"}:
        rows[:, 1:4] -= rows[:, 1:4].mean(axis=1, keepdims=True)  # against the star point: two are enough
    for column, factor in change.items():
        rows[:, column] *= factor
    path = write(folder / "phases.csv", rows, "time,ua,ub,uc,ia,ib,ic,omega")
    found = survey(Log.open(path, 2, columns))
    if words is None:
        assert check(found.stretch, found, TABLE)
    else:
        with pytest.raises(InputError, match=words):
            check(found.stretch, found, TABLE, "linear", str(path))


@pytest.mark.parametrize("rate", [500.0, 1e3, 2e3, 1e4])
def test_the_right_record_has_factor_one(rate):
    """At 500 Hz straight lines between samples, 0.4 rad apart, lack a hundredth of the voltages; the flux is exact."""
    rows = start_up(rate=rate)
    found = fit(rows[:, 1] + 1j * rows[:, 2], rows[:, 3] + 1j * rows[:, 4], rows[:, 5], 1 / rate, TABLE)
    assert abs(found.factor - 1) < 0.01 * (500 / rate) ** 2 + 1e-4 and found.share > 0.9999


def test_the_check_knows_what_a_voltage_stands_for():
    rows = held_voltage(rate=1e3, omega=180.0, frequency=185.0)
    u, i, omega = rows[:, 1] + 1j * rows[:, 2], rows[:, 3] + 1j * rows[:, 4], rows[:, 5]
    off = {voltage: abs(fit(u, i, omega, 1e-3, TABLE, voltage).factor - 1) for voltage in ("linear", "held", "averaged")}
    # what is left of "held" is the ripple of the currents about the straight lines between their samples
    assert 3 * off["held"] < 0.15 < 1.3 * off["linear"] < off["averaged"]


def test_nothing_is_said_where_nothing_turns(folder):
    rows = steady(0.05)
    rows[:, 1:] = [10.0, 0.0, 10.0 / TABLE.R_s, 0.0, 0.0]
    found = survey(Log.open(write(folder / "dc.csv", rows), 2))
    assert check(found.stretch, found, TABLE) is None
    with pytest.raises(InputError, match="give all gains"):
        prepared(folder / "dc.csv", TABLE)
    gains = default_gains("repaired", TABLE, Level(100.0, 0.5), 1000.0)
    data, _, _ = replayed(folder / "dc.csv", TABLE, gains=gains)
    assert np.isfinite(data.omega_hat.values).all()
