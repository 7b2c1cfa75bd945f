"""The baselines that adapt R_s by other routes: last coefficient in numbers, growth in time, what they are without h_s."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from imo_analysis.equations.baseline import baseline
from imo_analysis.equations.resistance import baseline_resistance, baseline_turned
from imo_analysis.equations.steady_state import slip_of_torque
from imo_analysis.machine import preset
from imo_analysis.pencils.error import OperatingPoint, full_matrix, poles_at
from imo_analysis.pencils.operating import equilibrium
from imo_analysis.pencils.own import check_derivative, departures
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study

MACHINE = preset("table-iii-printed-alpha")
NAME, TURNED = "baseline_resistance", "baseline_turned"
FLUX = 0.5307
GAINS = {"l_1": 161.8, "l_2": 0.0, "l_3": 0.020431, "l_4": 0.0, "h": 100.0, "h_s": 0.03}


def slowest(omega: float, slip: float, name: str = NAME, **gains: float) -> complex:
    found = poles_at(MACHINE, name, {**GAINS, **gains}, OperatingPoint(omega, FLUX, slip), "full")
    return complex(found[np.argmax(found.real)])


def test_without_adaptation_it_is_the_baseline_with_the_resistance_that_it_has() -> None:
    x, rest = (3.0, -2.0, 0.4, 0.3, 50.0), ((2.0, 1.0), (90.0, -30.0), 1)
    p, gains = (0.7, 0.06, 0.004, 200.0, 9.0), (160.0, 1.0, 0.02, 0.3, 100.0)
    found = baseline_resistance((*x, 0.25), *rest, p, (*gains, 0.0))
    assert found == (*baseline(x, *rest, (0.95, *p[1:]), gains), 0.0)


@pytest.mark.parametrize("name", [NAME, TURNED])
def test_it_follows_the_machine_and_its_derivative_is_that_of_difference_quotients(name: str) -> None:
    assert departures(name) == {}
    check_derivative(name)


@pytest.mark.parametrize(("omega", "slip"), [(10.0, 3.0), (10.0, -3.0), (-150.0, 2.0), (2.0, -3.0), (60.0, -7.0)])
@pytest.mark.parametrize("further", [{}, {"l_1": 900.0, "l_2": -30.0, "l_3": -1.2, "l_4": 0.4, "h_s": 2.0}])
def test_the_product_of_the_poles_is_what_the_ledger_says(omega: float, slip: float, further: dict[str, float]) -> None:
    """Derived symbolically in `ledger.claims.resistance` with dual numbers; here in floats from sympy's derivative."""
    gains, m, frame = {**GAINS, **further}, MACHINE, omega + slip
    matrix = full_matrix(m, NAME, gains, OperatingPoint(omega, FLUX, slip))
    expected = 2 * gains["h"] * gains["h_s"] * m.beta**2 * FLUX**4 * frame * slip / (m.sigma * m.L_m**2)
    assert np.linalg.det(-matrix) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("omega", [7.0, 20.0, 150.0, -60.0])
def test_it_is_stable_driving_undecided_idle_and_unstable_generating(omega: float) -> None:
    slip = 3.0 if omega > 0 else -3.0
    assert slowest(omega, slip).real < -0.1
    assert abs(slowest(omega, 0.0)) < 1e-6
    for h_s in (0.003, 0.03, 0.3):
        worst = slowest(omega, -slip, h_s=h_s)
        assert worst.real > 1e-3
        assert abs(worst.imag) < 1e-9 or abs(omega) < 10  # a pair where the baseline itself is about to lose the speed


@pytest.mark.parametrize(("sense", "slip"), [(1, 3.0), (-1, -3.0)])
def test_turned_by_the_power_it_is_the_other_with_either_sign_of_h_s(sense: int, slip: float) -> None:
    """Far above P_0 at least; at P_0 with half of h_s, and without power with none."""
    omega, rest = 20.0, ((2.0, 1.0), (90.0, -30.0), 1)
    p, gains = MACHINE.observer_parameters, tuple(GAINS.values())
    x = (FLUX / MACHINE.L_m, slip * FLUX / (MACHINE.alpha * MACHINE.L_m), FLUX, 0.0, omega, 0.1)
    torque = FLUX * x[1]
    P_0 = abs(torque) * (omega + slip) * FLUX**2
    for size, share in ((1e-12, 1.0), (1.0, 0.5)):
        found = baseline_turned(x, *rest, p, (*gains, size * P_0))
        other = baseline_resistance(x, *rest, p, (*gains[:5], sense * share * gains[5]))
        np.testing.assert_allclose(found, other, rtol=1e-11)
    idle = baseline_turned((x[0], 0.0, *x[2:]), *rest, p, (*gains, P_0))
    assert idle[5] == 0.0


@pytest.mark.parametrize("omega", [7.0, 20.0, 150.0, -60.0])
@pytest.mark.parametrize("slip", [3.0, -3.0])
def test_turned_by_the_power_the_product_of_the_poles_is_positive_either_way(omega: float, slip: float) -> None:
    m, gains, frame = MACHINE, {**GAINS, "P_0": 4.0}, omega + slip
    power = frame * slip * FLUX**4 / (m.alpha * m.L_m)
    matrix = full_matrix(m, TURNED, gains, OperatingPoint(omega, FLUX, slip))
    expected = 2 * GAINS["h"] * GAINS["h_s"] * m.beta**2 * FLUX**4 * frame * slip / (m.sigma * m.L_m**2)
    assert np.linalg.det(-matrix) == pytest.approx(expected * power / (abs(power) + 4.0), rel=1e-7)
    assert np.linalg.det(-matrix) > 0
    if abs(omega) >= 20:
        assert slowest(omega, slip, TURNED, P_0=4.0).real < -1e-3


def test_turned_by_the_power_a_pair_of_poles_still_leaves_near_zero_stator_frequency() -> None:
    worst = slowest(10.0, -3.0, TURNED, P_0=4.0)
    assert worst.real == pytest.approx(0.24, abs=0.01) and abs(worst.imag) == pytest.approx(2.04, abs=0.01)


def test_turned_by_the_power_it_finds_the_resistance_generating_and_keeps_it_for_a_minute() -> None:
    """What a map that waits for seconds calls holding; the law that is not turned leaves it (below)."""
    run = _held(-10.0, TURNED, **{
        "simulation.duration": 60.0, "reference": {"shape": "linear", "time": [0.0, 0.3, 1.0], "omega": [0.0, 0.0, 75.0]}})
    assert float(run["R_s_shift"][-1]) == pytest.approx(-0.2 * MACHINE.R_s, rel=0.02)
    assert abs(float(run["omega_hat"][-1] - run["omega"][-1])) < 0.02


def _held(torque: float, name: str = NAME, **changes: Any) -> Any:
    turns = ", P_0 = 4.0" if name == TURNED else ""
    text = f"""
        title = "held"
        machine = {{ preset = "table-iii-printed-alpha" }}
        simulation = {{ duration = 4.0, record_every = 10 }}
        initial = {{ i_ds = 8.83, phi_dr = 0.5307 }}
        reference = {{ shape = "linear", time = [0.0, 0.3, 1.0], omega = [0.0, 0.0, 20.0] }}
        load = {{ shape = "linear", time = [0.0, 1.2, 1.4], T_l = [0.0, 0.0, {torque}] }}
        [drive]
        flux = 0.5307
        current_bandwidth = 1500.0
        flux_bandwidth = 30.0
        speed_bandwidth = 45.0
        voltage_limit = 400.0
        current_limit = 60.0
        [observers.{name}]
        kind = "{name}"
        gains = {{ l_1 = 161.8, l_2 = 0.0, l_3 = 0.020431, l_4 = 0.0, h = 100.0, h_s = 0.03{turns} }}
        initial = {{ i_ds_hat = 8.83, phi_dr_hat = 0.5307 }}
        errors = {{ R_s = 0.2 }}
    """
    return simulate(Study.from_toml(text).changed(changes)).sel(observer=name)


def test_driving_it_finds_the_resistance() -> None:
    """With R_s believed 20 % too high; the right shift takes that away."""
    run = _held(10.0)
    assert float(run["R_s_shift"][-1]) == pytest.approx(-0.2 * MACHINE.R_s, rel=0.02)
    assert abs(float(run["omega_hat"][-1] - run["omega"][-1])) < 0.02


def test_generating_it_leaves_the_right_resistance_at_the_rate_of_the_pencil() -> None:
    torque = -10.0
    slip = float(slip_of_torque(torque, FLUX, MACHINE.n_p, MACHINE.L_r, MACHINE.alpha))
    run = _held(torque, **{f"observers.{NAME}.errors.R_s": 0.0})
    shift = abs(run["R_s_shift"].sel(time=slice(1.9, 2.1)))
    assert float(shift[0]) > 1e-5 and float(shift[-1]) < 0.02
    rate = np.polyfit(shift["time"], np.log(shift), 1)[0]
    assert rate == pytest.approx(slowest(20.0, slip).real, rel=0.05)


def test_where_it_rests_a_wrong_resistance_is_corrected() -> None:
    at = equilibrium(MACHINE, NAME, GAINS, OperatingPoint(20.0, FLUX, 3.0), {"R_s": 0.2})
    assert at.reason == "" and abs(at.errors["omega_tilde"]) < 1e-6
    assert at.estimates["R_s_shift"] == pytest.approx(-0.2 * MACHINE.R_s)
    base = {name: value for name, value in GAINS.items() if name != "h_s"}
    without = equilibrium(MACHINE, "baseline", base, OperatingPoint(20.0, FLUX, 3.0), {"R_s": 0.2})
    assert abs(without.errors["omega_tilde"]) > 0.1
