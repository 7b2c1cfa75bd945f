"""Where observers with parameter errors settle: exact cases, a scalar root, a simulation, folds, and refusals."""

import doctest
from typing import Any

import numpy as np
import oracle_linearisation as oracle
import pytest
from pencil_case import EQUIVARIANT, MACHINE, POINT, TRUE, gains

from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS, RUNNING_GRAM
from imo_analysis.errors import InputError
from imo_analysis.pencils import operating
from imo_analysis.pencils.error import OperatingPoint, full_matrix
from imo_analysis.pencils.operating import LOST, NO_LAW, STANDSTILL, equilibrium, pencil_with_errors, poles_with_errors
from imo_analysis.study import Study

WRONG = {"R_s": 0.1, "R_r": -0.2, "sigma": 0.15}


def believed(errors: dict[str, float]) -> dict[str, float]:
    """The believed parameters, by the machine's own constructor."""
    fields = {field: getattr(MACHINE, field) * (1 + error) for field, error in errors.items() if field != "sigma"}
    machine = MACHINE.with_values(**fields)
    if "sigma" in errors:
        machine = machine.with_values(L_s=machine.L_m**2 / machine.L_r + MACHINE.sigma * (1 + errors["sigma"]))
    return dict(zip(PARAMETERS, machine.observer_parameters, strict=True))


@pytest.mark.parametrize("name", EQUIVARIANT)
def test_without_errors_it_is_the_truth(name: str) -> None:
    at = equilibrium(MACHINE, name, gains(name), POINT)
    assert max(abs(float(error)) for error in at.errors.values()) < 1e-9 and at.reason == ""
    held = [k for k, state in enumerate(OBSERVERS[name].states) if state not in ("alpha_hat", *RUNNING_GRAM)]
    if name in ("across", "supervised"):
        A = full_matrix(MACHINE, "quiet", gains("quiet"), POINT)  # which they are while alpha_hat is held
    else:
        A = full_matrix(MACHINE, name, gains(name), POINT)
    system = pencil_with_errors(MACHINE, name, gains(name), POINT)
    assert np.abs(system.A - A[np.ix_(held, held)]).max() < 1e-9 * np.abs(A).max()


@pytest.mark.parametrize("name", EQUIVARIANT)
@pytest.mark.parametrize("point", [POINT, OperatingPoint(-40.0, 0.4, 2.0)])
def test_a_wrong_rotor_resistance_shifts_the_speed_by_the_slip_it_explains(name: str, point: OperatingPoint) -> None:
    """omega_hat = omega + slip (1 - alpha_hat / alpha), without any current error: the family of rest states."""
    for error in (-0.4, 0.5):
        at = equilibrium(MACHINE, name, gains(name), point, {"R_r": error})
        assert at.errors["omega_tilde"] == pytest.approx(point.slip * error, rel=1e-9)
        assert np.hypot(at.errors["i_ds_tilde"], at.errors["i_qs_tilde"]) < 1e-9
        assert abs(at.alpha_rate) < 1e-6


# given omega_hat those that adapt R_s are not linear
@pytest.mark.parametrize("name", [name for name in EQUIVARIANT if "R_s_shift" not in OBSERVERS[name].states])
@pytest.mark.parametrize("errors", [WRONG, {"R_s": -0.2}, {"L_m": 0.01, "L_r": -0.01}])
def test_against_a_scalar_root_and_complex_steps(name: str, errors: dict[str, float]) -> None:
    if name == "luenberger_printed_L":
        errors = {field: error / 20 for field, error in errors.items()}  # its state at rest ends soon
    at = equilibrium(MACHINE, name, gains(name), POINT, errors)
    assert at.reason == ""
    omega_hat = float(at.estimates["omega_hat"])
    root = oracle.resting_speed(name, TRUE, believed(errors), gains(name), 60.0, 0.5307, 3.0, 30.0)
    assert omega_hat == pytest.approx(root, rel=1e-9)
    assert abs(omega_hat - 60.0) > 1e-3
    kind = "quiet" if name in ("across", "supervised") else name
    steady = oracle.steady(TRUE, 60.0, 0.5307, 3.0)
    x = [float(at.values["alpha_hat"] if state == "alpha_hat" else at.estimates[state]) for state in OBSERVERS[kind].states]
    A = oracle.at_estimates(kind, believed(errors), gains(kind) | {"g": 0.0}, x, (steady["i"].real, steady["i"].imag),
                            (steady["u"].real, steady["u"].imag), 63.0, 1.0)
    held = [k for k, state in enumerate(OBSERVERS[kind].states) if state != "alpha_hat"]
    A = A[np.ix_(held, held)]
    system = pencil_with_errors(MACHINE, name, gains(name), POINT, errors)
    assert np.abs(system.A - A).max() < 1e-9 * np.abs(A).max()
    # noise and voltage error, and the flux, by complex steps too: errors are true minus estimate
    parameters, own = believed(errors), gains(kind) | {"g": 0.0}
    inputs = np.array([steady["i"].real, steady["i"].imag, steady["u"].real, steady["u"].imag])
    flux = OBSERVERS[kind].flux
    for k, label in enumerate(("i_ds_noise", "i_qs_noise", "u_ds_error", "u_qs_error")):
        v = inputs + 1j * oracle.STEP * (np.arange(4) == k)
        column = -oracle.rates_in_frame(kind, parameters, own, x, v[:2], v[2:], 63.0, 1.0).imag[held] / oracle.STEP
        at_input = system.input_labels.index(label)
        assert np.abs(system.B[:, at_input] - column).max() < 1e-9 * np.abs(system.B).max()
        through = -np.imag(flux(tuple(x), tuple(v[:2]), parameters["beta"])) / oracle.STEP
        row = system.output_labels.index("phi_dr_tilde")
        assert np.abs(system.D[row:row + 2, at_input] - through).max() < 1e-9
    for k, state in enumerate(held):
        y = np.array(x, dtype=complex)
        y[state] += oracle.STEP * 1j
        seen = np.imag(flux(tuple(y), tuple(inputs[:2]), parameters["beta"])) / oracle.STEP
        assert np.abs(system.C[row:row + 2, k] - seen).max() < 1e-9
    found, _ = poles_with_errors(MACHINE, name, gains(name), POINT, errors)
    expected = np.linalg.eigvals(A)
    assert max(np.abs(expected - pole).min() for pole in found) < 1e-7 * np.abs(expected).max()


@pytest.mark.parametrize("name", ["baseline", "luenberger_consistent_12", "quiet"])
def test_a_simulation_settles_there(name: str) -> None:
    """RK4 on the definitions in the frame of the flux, started from the truth."""
    wrong = believed(WRONG)
    own = gains(name) | ({"g": 0.0} if "g" in gains(name) else {})
    at = oracle.truth(name, TRUE, own, 60.0, 0.5307, 3.0)
    x = np.array(at["x"])
    if "alpha_hat" in OBSERVERS[name].states:
        x[6] = wrong["alpha"]

    def rates(y: np.ndarray) -> np.ndarray:
        return oracle.rates_in_frame(name, wrong, own, y, at["i"], at["u"], at["frame"], 1.0)

    h, late = 4e-4, []
    for step in range(10_000):
        a = rates(x)
        b = rates(x + h / 2 * a)
        c = rates(x + h / 2 * b)
        x = x + h / 6 * (a + 2 * b + 2 * c + rates(x + h * c))
        if step * h > 4.0 - 2 * np.pi / 63:  # the last turn: offsets that the currents do not see go on turning
            late.append(x[-1])
    rest = equilibrium(MACHINE, name, own, POINT, WRONG)
    assert np.mean(late) == pytest.approx(float(rest.estimates["omega_hat"]), abs=2e-3)
    assert abs(float(rest.errors["omega_tilde"])) > 0.1


@pytest.mark.parametrize("error", [{"R_s": 0.4}, {"sigma": 0.3}])
def test_offsets_stay_in_the_repaired_forms_and_grow_in_the_printed_one(error: dict[str, float]) -> None:
    """What the currents do not see: neutral to rounding where q is conserved, of its own pace where omega_hat feeds z_hat."""
    point = OperatingPoint(30.0, 0.5307, 3.0)
    pace = {}
    for name in ("repaired", "quiet", "consistent_12"):
        found, _ = poles_with_errors(MACHINE, name, gains(name), point, error)
        pace[name] = float(found[np.argmin(np.abs(found - 33j))].real)
    assert abs(pace["repaired"]) < 1e-9 and abs(pace["quiet"]) < 1e-9
    assert 1e-6 < pace["consistent_12"] < 0.1
    found, alone = poles_with_errors(MACHINE, "consistent_12", gains("consistent_12"), point, {"R_r": 0.4})
    assert abs(alone.errors["i_ds_tilde"]) < 1e-9 and abs(float(found[np.argmin(np.abs(found - 33j))].real)) < 1e-9


def test_where_a_branch_folds() -> None:
    """Braking at low speed with R_s believed too large: the smallest pole vanishes as the square root of the distance.

    The scalar root sees the same state before the end, and none behind it.
    """
    own, point = gains("consistent_12"), OperatingPoint(5.0, 0.5307, -3.0)

    def reasons(errors: Any) -> Any:
        return equilibrium(MACHINE, "consistent_12", own, point, {"R_s": errors}).reason

    inside, outside = 0.0, 0.05
    assert reasons(inside) == "" and reasons(outside) == LOST
    for _ in range(3):
        errors = np.linspace(inside, outside, 25)
        first = int(np.argmax(reasons(errors) != ""))
        inside, outside = errors[first - 1], errors[first]
    small = [float(np.abs(poles_with_errors(MACHINE, "consistent_12", own, point, {"R_s": inside - d})[0]).min())
             for d in (4e-4, 1e-4)]
    assert small[0] / small[1] == pytest.approx(2.0, rel=0.1)
    before = float(equilibrium(MACHINE, "consistent_12", own, point, {"R_s": inside - 1e-3}).estimates["omega_hat"])
    beside = [oracle.resting_speed("consistent_12", TRUE, believed({"R_s": inside + d}), own, 5.0, 0.5307, -3.0, 20.0)
              for d in (-1e-3, 1e-3)]
    assert beside[0] == pytest.approx(before, rel=1e-9) and np.isnan(beside[1])


def test_where_a_branch_runs_off() -> None:
    """The baseline, braking with R_s believed too large: 1/omega_hat goes to zero at a finite error, and no state is near."""
    own, point = gains("baseline"), OperatingPoint(5.0, 0.5307, -3.0)
    at = equilibrium(MACHINE, "baseline", own, point, {"R_s": np.array([0.06, 0.065, 0.07, 0.08])})
    inverse = 1 / at.estimates["omega_hat"][:3]
    assert 0.07 < np.polyfit(inverse, [0.06, 0.065, 0.07], 2)[-1] < 0.08
    assert at.reason[3] == LOST
    assert np.isnan(oracle.resting_speed("baseline", TRUE, believed({"R_s": 0.08}), own, 5.0, 0.5307, -3.0, 150.0))


def test_a_map_is_the_single_points_and_says_why_not() -> None:
    speeds = np.array([-60.0, -3.0, 60.0])
    errors = np.array([[-0.3], [0.2]])
    found, at = poles_with_errors(MACHINE, "repaired", gains("repaired"), OperatingPoint(speeds, 0.5307, 3.0), {"R_r": errors})
    assert found.shape == (2, 3, 7) and at.reason.shape == (2, 3)
    assert np.all(at.reason[:, 1] == STANDSTILL) and np.all(np.isnan(found[:, 1]))
    one, _ = poles_with_errors(MACHINE, "repaired", gains("repaired"), POINT, {"R_r": 0.2})
    assert np.abs(found[1, 2] - one).max() < 1e-9
    several = gains("repaired") | {"kappa": np.array([50.0, 70.0])}  # type: ignore[operator]
    both, _ = poles_with_errors(MACHINE, "repaired", several, POINT, {"R_r": 0.2})
    assert np.abs(both[1] - one).max() < 1e-9 and np.abs(both[0] - one).max() > 1
    assert equilibrium(MACHINE, "repaired", gains("repaired") | {"K_p": 0.0}, POINT).reason == NO_LAW
    assert np.all(np.isnan(at.errors["omega_tilde"][:, 1])) and np.all(np.isfinite(at.errors["omega_tilde"][:, ::2]))


@pytest.mark.parametrize("name", [name for name in EQUIVARIANT if "alpha_hat" in OBSERVERS[name].states])
def test_the_input_alpha_is_where_alpha_hat_is_held(name: str) -> None:
    """The DC gain from it to the speed error, and central differences of the states at rest."""
    system = pencil_with_errors(MACHINE, name, gains(name), POINT, {"R_s": 0.1})
    ends = [equilibrium(MACHINE, name, gains(name), POINT, {"R_s": 0.1}, MACHINE.alpha - a).errors for a in (-1e-4, 1e-4)]
    for row in ("omega_tilde", "phi_dr_tilde", "i_qs_tilde"):
        difference = (ends[1][row] - ends[0][row]) / 2e-4
        assert np.real(system[row, "alpha_tilde"].dcgain()) == pytest.approx(difference, rel=1e-4, abs=1e-9)


@pytest.mark.parametrize(("call", "message"), [
    (lambda: equilibrium(MACHINE, "printed_7", gains("printed_7"), POINT), "no state at rest while the flux turns"),
    (lambda: equilibrium(MACHINE, "baseline", gains("baseline"), POINT, {"J": 0.1}), "'J' is not a parameter that observers"),
    (lambda: equilibrium(MACHINE, "baseline", gains("baseline"), POINT, {"R_s": -1.0}), "R_s = .* must be above 0"),
    (lambda: equilibrium(MACHINE, "baseline", gains("baseline"), POINT, {"L_m": 0.3}), "L_m = 0.07813 H must be below"),
    (lambda: equilibrium(MACHINE, "baseline", gains("baseline"), POINT, {"sigma": -1.0}), "sigma must be above -1"),
    (lambda: equilibrium(MACHINE, "baseline", gains("baseline"), POINT, {"sigma": 0.1, "L_s": 0.1}), "one thing"),
    (lambda: equilibrium(MACHINE, "baseline", gains("baseline"), POINT, alpha_hat=6.6), "alpha_hat cannot be held"),
    (lambda: equilibrium(MACHINE, "quiet", gains("quiet"), POINT, alpha_hat=-1.0), "alpha_hat must be above 0"),
    (lambda: equilibrium(MACHINE, "quiet", gains("quiet"), OperatingPoint(60.0, None)), "flux of the operating point"),
    (lambda: equilibrium(MACHINE, "quiet", gains("quiet"), OperatingPoint(np.nan, 0.5)), "omega of the operating point"),
    (lambda: pencil_with_errors(MACHINE, "quiet", gains("quiet"), OperatingPoint(3.0, 0.5, -3.0)), "does not settle"),
    (lambda: pencil_with_errors(MACHINE, "quiet", gains("quiet"), OperatingPoint(np.ones(2), 0.5)), "one operating point"),
])
def test_operating_refusals(call: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()


def test_the_example_of_the_docstring() -> None:
    result = doctest.testmod(operating)
    assert result.attempted > 5 and result.failed == 0


def test_errors_are_those_of_a_study() -> None:
    """The same believed machine as a study with the same errors gives."""
    errors = {"R_s": 0.1, "L_m": 0.005}
    study = Study.paper()
    label = next(name for name, one in study.observers.items() if one.kind == "repaired")
    wrong = study.model_copy(update={"observers": {label: study.observers[label].model_copy(update={"errors": errors})}})
    at = equilibrium(study.machine, "repaired", gains("repaired"), POINT, errors)
    found = [float(at.values[key]) for key in PARAMETERS]
    assert found == pytest.approx(list(wrong.observer_machine(label).observer_parameters), rel=1e-12)
