"""Numbers: poles by three routes, operating points that are at rest, named state spaces, and refusals."""

from typing import Any

import numpy as np
import oracle_linearisation
import pytest
from oracle_pencils import frozen_poles
from pencil_case import MACHINE, gains

from imo_analysis.equations import plant
from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS
from imo_analysis.errors import InputError
from imo_analysis.pencils.error import (
    OperatingPoint,
    arguments,
    frozen_matrix,
    frozen_pencil,
    full_matrix,
    full_pencil,
    poles,
    poles_at,
)
from imo_analysis.pencils.jacobian import jacobian
from imo_analysis.pencils.reduced import reduced


def same(one: np.ndarray, other: np.ndarray, tolerance: float) -> None:
    """Two sets of poles, whatever their order."""
    from scipy.optimize import linear_sum_assignment

    distance = np.abs(one[:, None] - other[None, :])
    rows, columns = linear_sum_assignment(distance)
    assert distance[rows, columns].max() < tolerance, (one, other)


@pytest.mark.parametrize("name", OBSERVERS)
@pytest.mark.parametrize("omega", [-100.0, -3.0, 30.0, 60.0, 250.0])
def test_frozen_poles_by_three_routes(name: str, omega: float) -> None:
    """Batched eigenvalues, python-control and the polynomials derived by hand."""
    computed = poles_at(MACHINE, name, gains(name), OperatingPoint(omega, None))
    scale = np.abs(computed).max()
    parameters = dict(zip(PARAMETERS, MACHINE.observer_parameters, strict=True))
    same(computed, frozen_poles(name, parameters, gains(name), omega), 1e-9 * scale)
    same(computed, frozen_pencil(MACHINE, name, gains(name), omega).poles(), 1e-9 * scale)
    moving = reduced(name, "frozen").poles(arguments(jacobian(name), MACHINE, gains(name), OperatingPoint(omega, None)))
    same(np.concatenate([moving, np.zeros(len(computed) - len(moving))]), computed, 1e-9 * scale)


@pytest.mark.parametrize("name", OBSERVERS)
@pytest.mark.parametrize("omega", [60.0, -20.0])
def test_frozen_linearisation_against_complex_steps(name: str, omega: float) -> None:
    parameters = dict(zip(PARAMETERS, MACHINE.observer_parameters, strict=True))
    expected = oracle_linearisation.frozen(name, parameters, gains(name), omega)
    A = frozen_matrix(MACHINE, name, gains(name), omega)
    assert np.abs(A - expected).max() < 1e-12 * np.abs(A).max()


@pytest.mark.parametrize("name", [name for name in OBSERVERS if not name.endswith("printed_7")])
@pytest.mark.parametrize("point", [OperatingPoint(60.0, 0.5307, 3.0), OperatingPoint(-20.0, 0.4, 1.0)])
def test_full_linearisation_against_complex_steps(name: str, point: OperatingPoint) -> None:
    parameters = dict(zip(PARAMETERS, MACHINE.observer_parameters, strict=True))
    expected = oracle_linearisation.full(name, parameters, gains(name), point.omega, point.flux, point.slip)
    A = full_matrix(MACHINE, name, gains(name), point)
    assert np.abs(A - expected).max() < 1e-12 * np.abs(A).max()
    same(poles(A), np.linalg.eigvals(expected), 1e-9 * np.abs(poles(A)).max())
    same(poles(A), full_pencil(MACHINE, name, gains(name), point).poles(), 1e-9 * np.abs(poles(A)).max())


def test_the_supervisor_rests_in_the_turning_frame() -> None:
    """Its filters follow the regressors with the lag of a low-pass filter; the gate is shut, and its poles are the filters'."""
    point = OperatingPoint(60.0, 0.5307, 3.0)
    own = gains("supervised")
    with_filters = poles_at(MACHINE, "supervised", own, point, "full")
    for pole in (-own["eta"], -own["eta"] + 63j, -own["eta"] - 63j):
        assert np.abs(with_filters - pole).min() < 1e-9
    rest = poles_at(MACHINE, "across", gains("across") | {"g": 0.0}, point, "full")
    distance = np.abs(rest[:, None] - with_filters[None, :]).min(axis=1)
    assert distance.max() < 1e-6


def test_the_operating_point_is_at_rest() -> None:
    at = OperatingPoint(60.0, 0.5307, 3.0).quantities(MACHINE.observer_parameters)
    rates = plant.plant((at["i_ds"], at["i_qs"], at["phi_dr"], 0.0, 60.0), (at["u_ds"], at["u_qs"]), 63.0, 0.0,
                        MACHINE.plant_parameters)
    assert np.abs(rates[:4]).max() < 1e-9
    assert at["i_ds"] == pytest.approx(0.5307 / MACHINE.L_m)
    assert at["i_qs"] == pytest.approx(3.0 * 0.5307 / (MACHINE.alpha * MACHINE.L_m))


@pytest.mark.parametrize("name", ["consistent_12", "repaired"])
def test_what_steady_running_cannot_tell_is_neutral(name: str) -> None:
    """With constant flux, z and xi may keep constant offsets (+-j omega_s in the turning frame) and alpha trades with omega."""
    found = poles_at(MACHINE, name, gains(name), OperatingPoint(60.0, 0.5307, 3.0), "full")
    for neutral in (0.0, 63.0j, -63.0j):
        assert np.abs(found - neutral).min() < 1e-8


def test_sign_of_11_is_wrong_for_negative_speed() -> None:
    forward = poles_at(MACHINE, "consistent_12", gains("consistent_12"), OperatingPoint(60.0, 0.5307, 3.0), "full")
    backward = poles_at(MACHINE, "consistent_12", gains("consistent_12"), OperatingPoint(-60.0, 0.5307, -3.0), "full")
    assert forward.real.max() < 1e-8 and backward.real.max() > 1000
    mirrored = poles_at(MACHINE, "repaired", gains("repaired"), OperatingPoint(-60.0, 0.5307, -3.0), "full")
    same(mirrored, poles_at(MACHINE, "repaired", gains("repaired"), OperatingPoint(60.0, 0.5307, 3.0), "full"), 1e-7)


def test_state_space_has_names_and_works_in_python_control() -> None:
    import control

    system = full_pencil(MACHINE, "baseline", gains("baseline"), OperatingPoint(60.0, 0.5307, 3.0))
    assert system.state_labels == ["i_ds_tilde", "i_qs_tilde", "phi_dr_tilde", "phi_qr_tilde", "omega_tilde"]
    assert system.input_labels == ["i_ds_noise", "i_qs_noise", "u_ds_error", "u_qs_error", "omega_dot"]
    speed = system["omega_tilde", "omega_dot"]
    assert control.norm(speed, 2) > 0
    # a rate that stays on leaves an error, and a larger gain h leaves a smaller one
    faster = full_pencil(MACHINE, "baseline", gains("baseline") | {"h": 400.0}, OperatingPoint(60.0, 0.5307, 3.0))
    assert abs(faster["omega_tilde", "omega_dot"].dcgain()) < abs(speed.dcgain())


@pytest.mark.parametrize(("call", "message"), [
    (lambda: frozen_pencil(MACHINE, "repaired", {"k_1": 1.0, "kappa": 2.0}, 30.0), "gains of repaired are missing: k_3"),
    (lambda: frozen_pencil(MACHINE, "repaired", {"k_1": 1.0, "kappa": 2.0, "k_3": 1.0, "k_2": 1.0}, 30.0), "gain 'k_2'"),
    (lambda: frozen_pencil(MACHINE, "repaired", gains("repaired") | {"k_1": float("nan")}, 30.0), "k_1 = nan .* finite"),
    (lambda: frozen_pencil(MACHINE, "baseline", [1.0, 2.0], 30.0), "must be 5 numbers"),
    (lambda: frozen_pencil(MACHINE, "baseline", gains("baseline"), float("nan")), "omega = nan must be finite"),
    (lambda: full_pencil(MACHINE, "baseline", gains("baseline"), OperatingPoint(30.0, 0.0)), "flux = 0.0 Wb .* above 0"),
    (lambda: full_pencil(MACHINE, "baseline", gains("baseline"), OperatingPoint(30.0, None)), "flux = None"),
    (lambda: full_pencil(MACHINE, "repaired", gains("repaired") | {"alpha_l": 20.0}, OperatingPoint(30.0, 0.5)), "alpha_l"),
    (lambda: full_pencil(MACHINE, "baseline", gains("baseline"), OperatingPoint(np.ones(2), 0.5)), "one operating point"),
    (lambda: frozen_matrix(MACHINE, "baseline", gains("baseline"), 1.0, {"R_r": -1.0}), "R_r = -1 ohm must be above 0"),
    (lambda: frozen_matrix(MACHINE, "baseline", gains("baseline"), 1.0, {"L_m": 0.07}), r"L_m = 0.07 H .*\) = 0.0616997"),
    (lambda: frozen_matrix(MACHINE, "baseline", gains("baseline"), 1.0, {"k_2": 1.0}), "'k_2' is not a parameter of baseline"),
])
def test_refusals(call: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()
