"""Floquet exponents: the poles where both exist, a monodromy by complex steps through the definitions, order four, refusals."""

from typing import Any

import numpy as np
import oracle_linearisation as oracle
import pytest
from pencil_case import EQUIVARIANT, MACHINE, POINT, TRUE, gains

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.pencils import floquet
from imo_analysis.pencils.error import OperatingPoint, arguments, full_matrix, poles_at
from imo_analysis.pencils.floquet import floquet_exponents, matrix_along, standing_matrix

TURNING = [name for name in OBSERVERS if name not in EQUIVARIANT]


@pytest.mark.parametrize("name", EQUIVARIANT)
def test_they_are_the_poles_where_both_exist(name: str) -> None:
    found = floquet_exponents(MACHINE, name, gains(name), POINT)
    poles = poles_at(MACHINE, name, gains(name), POINT, "full")
    assert floquet._apart(found, poles, 63.0) < 1e-9 * np.abs(poles).max()
    along = matrix_along(MACHINE, name, gains(name), POINT, np.array([0.0, 1.0, 4.0]))
    whole = full_matrix(MACHINE, name, gains(name), POINT)
    assert np.abs(along - whole).max() < 1e-12 * np.abs(whole).max()


def _multipliers(name: str, omega: float, flux: float, slip: float, steps: int) -> np.ndarray:
    """Eigenvalues of a turn's monodromy: RK4 in the stationary frame on complex steps from the truth, which itself is exact."""
    at = oracle.steady(TRUE, omega, flux, slip)
    frame = omega + slip
    period = 2 * np.pi / abs(frame)
    h = period / steps
    states = OBSERVERS[name].states

    def slopes(t: float, y: np.ndarray) -> np.ndarray:
        i, z, u = (at[key] * np.exp(1j * frame * t) for key in ("i", "z", "u"))
        true = {"i_ds_hat": i.real, "i_qs_hat": i.imag, "z_1_hat": z.real, "z_2_hat": z.imag, "xi_1_hat": z.real,
                "xi_2_hat": z.imag, "alpha_hat": TRUE["alpha"], "omega_hat": omega}
        x = np.array([true[state] for state in states])[:, None] + 1e-150j * y  # small enough for what grows by e^90 in a turn
        return oracle.rates_in_frame(name, TRUE, gains(name), x, (i.real, i.imag), (u.real, u.imag), 0.0,
                                     -1.0 if omega < 0 else 1.0).imag / 1e-150

    y = np.eye(len(states))
    for k in range(steps):
        t = k * h
        a = slopes(t, y)
        b = slopes(t + h / 2, y + h / 2 * a)
        c = slopes(t + h / 2, y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + slopes(t + h, y + h * c))
    return np.linalg.eigvals(y)


@pytest.mark.parametrize(("name", "omega", "slip"), [("luenberger_printed_7", 60.0, 3.0), ("printed_7", -100.0, -3.0)])
def test_against_a_monodromy_by_complex_steps(name: str, omega: float, slip: float) -> None:
    multipliers = _multipliers(name, omega, 0.5307, slip, 2000)
    found = floquet_exponents(MACHINE, name, gains(name), OperatingPoint(omega, 0.5307, slip))
    period = 2 * np.pi / abs(omega + slip)
    seen = multipliers[np.abs(multipliers) > 1e-7 * np.abs(multipliers).max()]  # below, rounding has drowned them
    expected = np.log(seen.astype(complex)) / period
    distance = np.abs(np.exp((found[None, :] - expected[:, None]) * period) - 1).min(axis=1)
    assert len(seen) >= 1 and distance.max() < 1e-6 * np.abs(found).max() * period
    assert found.real.max() > 50  # as printed in (7), it cannot run


@pytest.mark.parametrize("name", TURNING)
def test_what_the_currents_do_not_see_is_neutral(name: str) -> None:
    """Constant offsets of z and xi, and with constant flux alpha against omega: three exponents that are zero."""
    found = floquet_exponents(MACHINE, name, gains(name), POINT)
    neutral = np.sort(np.abs(found))[:3]
    assert (neutral.max() < 1e-6) == ("xi_1_hat" in OBSERVERS[name].states)


@pytest.mark.parametrize("name", OBSERVERS)
def test_control_linearizes_the_definitions_to_the_same(name: str) -> None:
    """python-control's finite differences of the nonlinear observer, in the axes at rest, while the flux is along d."""
    import control

    from imo_analysis.pencils.jacobian import derive
    from imo_analysis.simulation.nonlinear import observer_system

    at = oracle.truth(name, TRUE, gains(name), 60.0, 0.5307, 3.0)
    nonlinear = observer_system(name, MACHINE, gains(name))
    linear = control.linearize(nonlinear, at["x"], [*at["i"], *at["u"], 60.0], eps=1e-6)
    derived = derive(name, "full")
    whole = derived.evaluate(arguments(derived, MACHINE, gains(name), POINT) | {"stator_frequency": 0.0})
    n = len(derived.states)
    # errors are true minus estimate, and what is measured acts on the estimate
    for found, exact in ((linear.A, whole[:n, :n]), (linear.B[:, :4], -whole[:n, n:n + 4]),
                         (linear.C[n:], whole[n + n:, :n]), (linear.D[n:, :4], -whole[n + n:, n:n + 4])):
        assert np.abs(found - exact).max(initial=0.0) < 1e-6 * np.abs(whole).max()


def test_the_steps_are_of_fourth_order() -> None:
    def growth(steps: int) -> float:
        return float(floquet._exponents(MACHINE, "luenberger_printed_7", gains("luenberger_printed_7"), POINT, 4, steps,
                                        2 * np.pi / 63).real.max())

    exact = growth(2048)
    errors = [abs(growth(steps) - exact) for steps in (128, 256)]
    assert 3.7 < np.log2(errors[0] / errors[1]) < 4.3


def test_a_standing_flux_is_time_invariant_and_its_direction_matters() -> None:
    point = OperatingPoint(20.0, 0.5, -20.0)
    A = standing_matrix(MACHINE, "repaired", gains("repaired"), point, 0.7)
    assert np.abs(A - full_matrix(MACHINE, "repaired", gains("repaired"), point)).max() < 1e-12 * np.abs(A).max()
    own = gains("luenberger_printed_7")
    one, other = (standing_matrix(MACHINE, "luenberger_printed_7", own, point, angle) for angle in (0.0, 0.7))
    expected = oracle.full("luenberger_printed_7", TRUE, own, 20.0, 0.5, -20.0)
    assert np.abs(one - expected).max() < 1e-12 * np.abs(expected).max()
    slowest = [np.sort(np.linalg.eigvals(A).real)[-2] for A in (one, other)]
    assert abs(slowest[0] - slowest[1]) > 10


@pytest.mark.parametrize(("call", "message"), [
    (lambda: floquet_exponents(MACHINE, "printed_7", gains("printed_7"), OperatingPoint(3.0, 0.5, -3.0)), "flux stands still"),
    (lambda: floquet_exponents(MACHINE, "printed_7", gains("printed_7"), OperatingPoint(0.5, 0.5, 0.1)), "too low for Floquet"),
    (lambda: standing_matrix(MACHINE, "printed_7", gains("printed_7"), POINT), "flux turns at 63 rad/s"),
    (lambda: floquet_exponents(MACHINE, "kalman", {}, POINT), "'kalman' is not known"),
])
def test_floquet_refusals(call: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()
