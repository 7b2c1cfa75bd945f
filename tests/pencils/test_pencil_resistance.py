"""The baseline that adapts R_s by other routes: its last coefficient in numbers, its growth in time, what it is without h_s."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from imo_analysis.equations.baseline import baseline
from imo_analysis.equations.resistance import baseline_resistance
from imo_analysis.equations.steady_state import slip_of_torque
from imo_analysis.machine import preset
from imo_analysis.pencils.error import OperatingPoint, full_matrix, poles_at
from imo_analysis.pencils.operating import equilibrium
from imo_analysis.pencils.own import check_derivative, departures
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study

MACHINE = preset("table-iii-printed-alpha")
NAME = "baseline_resistance"
FLUX = 0.5307
GAINS = {"l_1": 161.8, "l_2": 0.0, "l_3": 0.020431, "l_4": 0.0, "h": 100.0, "h_s": 0.03}


def slowest(omega: float, slip: float, **gains: float) -> complex:
    found = poles_at(MACHINE, NAME, {**GAINS, **gains}, OperatingPoint(omega, FLUX, slip), "full")
    return complex(found[np.argmax(found.real)])


def test_without_adaptation_it_is_the_baseline_with_the_resistance_that_it_has() -> None:
    x, rest = (3.0, -2.0, 0.4, 0.3, 50.0), ((2.0, 1.0), (90.0, -30.0), 1)
    p, gains = (0.7, 0.06, 0.004, 200.0, 9.0), (160.0, 1.0, 0.02, 0.3, 100.0)
    found = baseline_resistance((*x, 0.25), *rest, p, (*gains, 0.0))
    assert found == (*baseline(x, *rest, (0.95, *p[1:]), gains), 0.0)


def test_it_follows_the_machine_and_its_derivative_is_that_of_difference_quotients() -> None:
    assert departures(NAME) == {}
    check_derivative(NAME)


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


def _held(torque: float, **changes: Any) -> Any:
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
        [observers.{NAME}]
        gains = {{ l_1 = 161.8, l_2 = 0.0, l_3 = 0.020431, l_4 = 0.0, h = 100.0, h_s = 0.03 }}
        initial = {{ i_ds_hat = 8.83, phi_dr_hat = 0.5307 }}
        errors = {{ R_s = 0.2 }}
    """
    return simulate(Study.from_toml(text).changed(changes)).sel(observer=NAME)


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
