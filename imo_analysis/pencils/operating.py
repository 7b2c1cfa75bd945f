"""Where an observer that believes wrong parameters settles, and its linearisation there, for whole maps at once.

The machine runs in a steady state; the observer is told its currents and voltages, but computes with other parameters. In the
frame of the flux it then rests at estimates that are wrong: the speed is biased and the current errors need not vanish. They
are found by Newton's method with the exact derivative, followed from no error to the given one, so that it is the state that
belongs to the true one. Two things have no such state, and are not pretended to have one:

- alpha_hat. At constant flux the laws (9) and (11) see one signal, so that with the right other parameters alpha_hat rests
  anywhere on a line, and with wrong ones in general nowhere on it. It is held at what is believed, and the rate at which its
  law would move it from there is given (``alpha_rate``; zero: it rests).
- Any estimate at zero stator frequency, where nothing determines omega_hat.

For maps::

    poles_with_errors(machine, name, gains, point, errors) -> (poles of shape (..., n), Equilibrium)

with ``point`` an `OperatingPoint` of arrays and ``errors`` relative errors by machine field, such as
``{"R_r": np.linspace(-0.5, 0.5, 101)}``, that broadcast; NaN, with the reason, where there is no such state.

Examples
--------
The repaired observer at 10 rad/s believes R_s 20 % too large:

>>> from imo_analysis.machine import PRESETS
>>> from imo_analysis.pencils.error import OperatingPoint
>>> from imo_analysis.pencils.operating import equilibrium, poles_with_errors
>>> machine, point = PRESETS["table-iii-printed-alpha"], OperatingPoint(omega=10.0, flux=0.5307, slip=3.0)
>>> gains = dict(k_1=300, kappa=50, k_3=100, g=1, K_p=100, alpha_l=0.05, delta=0.01)
>>> at = equilibrium(machine, "repaired", gains, point, {"R_s": 0.2})
>>> print(f"speed error {at.errors['omega_tilde']:.2f} rad/s; its law would move alpha_hat at {at.alpha_rate:.3g} /s^2")
speed error -1.01 rad/s; its law would move alpha_hat at -1.84 /s^2

A wrong R_r shifts the speed by the slip that it explains, at any speed, and nothing else:

>>> poles, at = poles_with_errors(machine, "repaired", gains, OperatingPoint([10.0, 60.0], 0.5307, 3.0), {"R_r": 0.5})
>>> print(at.errors["omega_tilde"].round(9), poles.real.max(axis=-1).round(9) + 0.0)
[1.5 1.5] [0. 0.]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.catalogue import PARAMETERS, RUNNING_GRAM
from imo_analysis.equations.own import shown
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.pencils.error import MACHINE_FIELDS, Gains, OperatingPoint, gain_values, machine_parameters, poles
from imo_analysis.pencils.held import HeldRates, held_rates, with_held_alpha
from imo_analysis.pencils.jacobian import known_observer, pairs

if TYPE_CHECKING:
    import control

_SHORTEST = 2.0**-14  # of the way from no error to the whole error
_NEWTON = 8
_STRAIGHT = 0.5  # of a step may be corrected after Newton's first move
_TOLERANCE = 1e-11  # of the size of each estimate
STANDING = 1e-6  # rad/s, a stator frequency that counts as zero
STANDSTILL = "stator frequency is zero: nothing determines omega_hat"
NO_LAW = "the gain of the speed adaptation is zero: nothing determines omega_hat"
LOST = "the state at rest ends on the way from no error to this one"


@dataclass(frozen=True)
class Equilibrium:
    """Where an observer rests, in the frame of the true flux. Arrays of the shape that the inputs broadcast to.

    Attributes
    ----------
    estimates : dict of str to array
        Every estimate by name (``i_ds_hat`` ... ``omega_hat``) and the estimated flux; NaN where there is no such state.
    errors : dict of str to array
        True minus estimate, ``i_ds_tilde`` ... ``omega_tilde`` and the flux error ``phi_dr_tilde, phi_qr_tilde``.
    alpha_rate : array
        Rate at which the observer's own law would move alpha_hat from where it is held, in 1/s^2; 0 for observers that do not
        estimate alpha.
    reason : array of str
        Empty where there is a state at rest, else why not.
    values : dict of str to array
        All that the derivative takes, at the equilibrium.
    """

    estimates: dict[str, np.ndarray]
    errors: dict[str, np.ndarray]
    alpha_rate: np.ndarray
    reason: np.ndarray
    values: dict[str, np.ndarray]


def equilibrium(
    machine: InductionMachine,
    name: str,
    gains: Gains,
    point: OperatingPoint,
    errors: Mapping[str, Any] | None = None,
    alpha_hat: Any = None,
) -> Equilibrium:
    """Where an observer with parameter errors settles.

    Parameters
    ----------
    machine : InductionMachine
        The true machine.
    name : str
        The observer, as in the catalogue; one that commutes with rotations.
    gains : mapping or sequence of float
        Its gains; arrays broadcast.
    point : OperatingPoint
        Steady state of the true machine; floats or arrays that broadcast.
    errors : mapping, optional
        Relative errors of the believed R_s, R_r, L_m, L_s, L_r, or of the leakage sigma (put into L_s), floats or arrays:
        believed = true (1 + error), as in studies.
    alpha_hat : float or array, optional
        Where alpha_hat is held, in 1/s; at the believed R_r / L_r where left out. Only for observers that estimate it.

    Raises
    ------
    InputError
        For unknown names, and for numbers that no machine, observer or operating point can have.
    """
    law = held_rates(name)
    observer = known_observer(name)
    if alpha_hat is not None and "alpha_hat" not in observer.states:
        raise InputError(f"alpha_hat cannot be held elsewhere in {shown(name)}: it does not estimate alpha; use errors of R_r")
    (true, believed, fixed), shape = _numbers(machine, name, gains, point, dict(errors or {}), alpha_hat)
    whose = {state: state if state in true else state.removesuffix("_hat") for state in (*law.states, *law.outputs)}
    start = {state: true[whose[state]] for state in law.states}
    x = np.stack(list(start.values()), axis=-1)
    moving = np.abs(true["stator_frequency"]) > STANDING
    n = len(law.states)
    lawless = ~np.any(law.derivative({**true, **fixed, **start})[:, law.states.index("omega_hat"), :n], axis=-1)
    found = np.zeros(x.shape[0], dtype=bool)
    lanes = np.flatnonzero(moving & ~lawless)
    here, told = ({key: value[lanes] for key, value in group.items()} for group in (true | fixed, believed))
    x[lanes], found[lanes] = _follow(law, x[lanes], here, told, _scales(start, true["stator_frequency"])[lanes])
    x[~found] = np.nan
    values = {**true, **fixed, **believed, **dict(zip(law.states, x.T, strict=True))}
    flux = law.rates(values)[:, n:]
    estimates = {**dict(zip(law.states, x.T, strict=True)), **dict(zip(law.outputs, flux.T, strict=True))}
    errors_of = {f"{key.removesuffix('_hat')}_tilde": true[whose[key]] - value for key, value in estimates.items()}
    reason = np.where(found, "", np.where(~moving, STANDSTILL, np.where(lawless, NO_LAW, LOST)))
    return Equilibrium(
        {key: value.reshape(shape) for key, value in estimates.items()},
        {key: value.reshape(shape) for key, value in errors_of.items()},
        _alpha_rate(name, values).reshape(shape), reason.reshape(shape),
        {key: value.reshape(shape) for key, value in values.items()})


def poles_with_errors(
    machine: InductionMachine,
    name: str,
    gains: Gains,
    point: OperatingPoint,
    errors: Mapping[str, Any] | None = None,
    alpha_hat: Any = None,
) -> tuple[np.ndarray, Equilibrium]:
    """Poles of the linearisation where an observer with parameter errors settles, alpha_hat held; and that state.

    Arguments as for `equilibrium`. The poles have the shape ``(..., n)``, in 1/s, and are NaN where there is no such state.
    Observers with xi have two poles at plus and minus j times the stator frequency: constant offsets of z_hat and xi_hat that
    the currents do not see. In the repaired forms they are there by structure, for q = k_3 z_tilde - j kappa s xi_tilde turns
    alone whatever is believed. In the paper's conventions omega_hat acts on z_hat through what current error remains, so that
    with a wrong R_s or leakage these two move off the axis, and may grow, slowly.
    """
    at = equilibrium(machine, name, gains, point, errors, alpha_hat)
    law = held_rates(name)
    n = len(law.states)
    A = law.derivative(at.values)[..., :n, :n]
    result = np.full(A.shape[:-1], np.nan, dtype=complex)
    there = at.reason == ""
    result[there] = poles(A[there])
    return result, at


def pencil_with_errors(
    machine: InductionMachine,
    name: str,
    gains: Gains,
    point: OperatingPoint,
    errors: Mapping[str, float] | None = None,
    alpha_hat: float | None = None,
) -> control.StateSpace:
    """The linearisation where an observer with parameter errors settles, as a `control.StateSpace` with named signals.

    States are the errors' deviations from where they rest; inputs the noise on the measured currents (A), the error of the
    voltages (V), and ``alpha_tilde`` (1/s), the deviation of the held alpha_hat, where the observer has one; outputs the
    states and the error of the estimated flux (Wb). The machine keeps its steady state: with wrong parameters its transients
    act on the errors too, and are not part of this.

    Raises
    ------
    InputError
        As `equilibrium`, and where there is no state at rest.
    """
    import control

    at = equilibrium(machine, name, gains, point, errors, alpha_hat)
    if at.reason.ndim:
        raise InputError("a state space takes one operating point; use poles_with_errors for many")
    if reason := str(at.reason):
        raise InputError(f"{shown(name)} does not settle with errors {dict(errors or {})}: {reason}; change the point or the "
                         "errors")
    law = held_rates(name)
    n, measured = len(law.states), slice(len(law.states), len(law.states) + 4)
    d = law.derivative(at.values)
    # errors are true minus estimate: what is measured or told acts with the sign turned, alpha_hat = alpha - alpha_tilde not
    B = np.concatenate([-d[:n, measured], d[:n, n + 4:]], axis=1)
    D = np.concatenate([-d[n:, measured], d[n:, n + 4:]], axis=1)
    inputs = ["i_ds_noise", "i_qs_noise", "u_ds_error", "u_qs_error", *(["alpha_tilde"] if B.shape[1] > 4 else [])]
    states = [f"{state.removesuffix('_hat')}_tilde" for state in law.states]
    flux = [output not in law.states for output in law.outputs]
    return control.ss(
        d[:n, :n], B, np.concatenate([np.eye(n), d[n:, :n][flux]]), np.concatenate([np.zeros((n, B.shape[1])), D[flux]]),
        states=states, inputs=inputs, name=f"{known_observer(name).name}_with_errors", remove_useless_states=False,
        outputs=[*states, *(f"{o.removesuffix('_hat')}_tilde" for o, new in zip(law.outputs, flux, strict=True) if new)])


def _numbers(
    machine: InductionMachine, name: str, gains: Gains, point: OperatingPoint, errors: dict[str, Any], alpha_hat: Any
) -> tuple[list[dict[str, np.ndarray]], tuple[int, ...]]:
    """True quantities, believed parameters, and what stays as it is on the way, each flat; and the common shape."""
    fields = _believed_fields(machine, errors)
    speeds = {key: np.asarray(getattr(point, key), dtype=float) for key in ("omega", "slip")}
    flux = np.asarray(np.nan if point.flux is None else point.flux, dtype=float)
    for key, value in speeds.items():
        if not np.all(np.isfinite(value)):
            raise InputError(f"{key} of the operating point must be finite at every point, in rad/s")
    if not np.all(np.isfinite(flux) & (flux > 0)):
        raise InputError("flux of the operating point must be above 0 Wb at every point")
    true = dict(zip(PARAMETERS, machine.observer_parameters, strict=True))
    at = OperatingPoint(speeds["omega"], flux, speeds["slip"]).quantities(machine.observer_parameters)
    estimated = (*at, *true, *RUNNING_GRAM)
    true |= {state: 0.0 for state in known_observer(name).states if state.removesuffix("_hat") not in estimated}
    believed = machine_parameters(machine, fields)
    if "alpha_hat" in known_observer(name).states:
        true["alpha_hat"] = machine.alpha
        believed["alpha_hat"] = believed["alpha"] if alpha_hat is None else np.asarray(alpha_hat, dtype=float)
        if not np.all(np.isfinite(believed["alpha_hat"]) & (believed["alpha_hat"] > 0)):
            raise InputError("alpha_hat must be above 0 /s at every point")
    fixed = {**gain_values(name, gains), "direction": np.where(speeds["omega"] < 0, -1.0, 1.0)}
    groups = [{**at, **true}, believed, fixed]
    shape = np.broadcast_shapes(*(np.shape(value) for group in groups for value in group.values()))
    return [{key: np.broadcast_to(np.asarray(value, dtype=float), shape).ravel() for key, value in group.items()}
            for group in groups], shape


def _believed_fields(machine: InductionMachine, errors: dict[str, Any]) -> dict[str, np.ndarray]:
    """The believed machine fields from relative errors; an error of the leakage sigma is put into L_s."""
    known = (*MACHINE_FIELDS, "sigma")
    if unknown := [field for field in errors if field not in known]:
        raise InputError(f"errors: {unknown[0]!r} is not a parameter that observers use; choose from {', '.join(known)}")
    fields = {field: getattr(machine, field) * (1 + np.asarray(error, dtype=float))
              for field, error in errors.items() if field != "sigma"}
    if "sigma" in errors:
        if "L_s" in fields:
            raise InputError("errors of sigma and of L_s are one thing: the leakage is put into L_s; leave one of them out")
        sigma = machine.sigma * (1 + np.asarray(errors["sigma"], dtype=float))
        if not np.all(np.isfinite(sigma) & (sigma > 0)):
            raise InputError("errors of sigma must be above -1 and finite at every point")
        L_m = fields.get("L_m", np.asarray(machine.L_m))
        fields["L_s"] = sigma + L_m * L_m / fields.get("L_r", np.asarray(machine.L_r))
    return fields


def _scales(start: dict[str, np.ndarray], frequency: np.ndarray) -> np.ndarray:
    """What a negligible change of each estimate is measured by: the size of its vector, the stator frequency, or its own size.
    A correction, which begins at zero, has none: the others tell whether all have settled."""
    sizes = {name: np.where(start[name] == 0, np.inf, np.abs(start[name])) for name in start}
    for d, q in pairs(start):
        sizes[d] = sizes[q] = np.hypot(start[d], start[q])
    sizes["omega_hat"] = np.hypot(start["omega_hat"], frequency)
    return np.stack(list(sizes.values()), axis=-1)


def _follow(
    law: HeldRates, x: np.ndarray, true: dict[str, np.ndarray], believed: dict[str, np.ndarray], scale: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """From the true parameters to the believed ones, each lane with steps of its own; the states, and where it arrived.

    A step counts only if Newton's first move is about the whole of it, and is halved where not: near the end of a branch, and
    in a jump to another one, it never is, so that neither passes for the state that belongs to the true one.
    """
    x, share, step = x.copy(), np.zeros(len(x)), np.ones(len(x))
    going = np.arange(len(x))
    while going.size:
        there = np.minimum(share[going] + step[going], 1.0)
        values = {key: value[going] for key, value in true.items()}
        values |= {key: (1 - there) * values[key] + there * value[going] for key, value in believed.items()}
        arrived, good = _newton(law, x[going], values, scale[going])
        x[going[good]], share[going[good]] = arrived[good], there[good]
        step[going] *= np.where(good, 2.0, 0.5)
        going = going[(share[going] < 1) & (step[going] >= _SHORTEST)]
    return x, share == 1


def _newton(law: HeldRates, x: np.ndarray, values: dict[str, np.ndarray], scale: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Newton's method from x; where it ends, and whether it settled there on a nearly straight way."""
    n = len(law.states)
    before, first = x, np.zeros_like(x)
    for attempt in range(_NEWTON):
        values |= dict(zip(law.states, x.T, strict=True))
        move = _solve(law.derivative(values)[..., :n, :n], -law.rates(values)[..., :n])
        first = move if attempt == 0 else first
        x = x + move
        settled = np.all(np.abs(move) <= _TOLERANCE * scale, axis=-1)
        if np.all(settled | ~np.isfinite(move[:, 0])):
            break
    bent = np.max(np.abs(x - before - first) / scale, axis=-1)
    return x, settled & (bent <= _STRAIGHT * np.max(np.abs(first) / scale, axis=-1) + _NEWTON * _TOLERANCE)


def _solve(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The solutions of a batch of equations, NaN where one is singular or not finite."""
    finite = np.all(np.isfinite(A), axis=(-1, -2)) & np.all(np.isfinite(b), axis=-1)
    safe = np.where(finite[:, None, None], A, np.eye(A.shape[-1]))
    finite &= np.linalg.slogdet(safe)[0] != 0
    safe = np.where(finite[:, None, None], A, np.eye(A.shape[-1]))
    solution = np.linalg.solve(safe, np.where(finite[:, None], b, 0.0)[..., None])[..., 0]
    return np.where(finite[:, None], solution, np.nan)


def _alpha_rate(name: str, values: dict[str, np.ndarray]) -> np.ndarray:
    """The rate of alpha_hat by the observer's own law, of `across` for one that is supervised."""
    observer = with_held_alpha(known_observer(name))
    if "alpha_hat" not in observer.states:
        return np.zeros(values["omega_hat"].shape)
    rates = observer.rates(
        tuple(values[state] for state in observer.states), (values["i_ds"], values["i_qs"]), (values["u_ds"], values["u_qs"]),
        values["direction"], tuple(values[key] for key in PARAMETERS), tuple(values[gain] for gain in observer.gains))
    return np.asarray(rates[observer.states.index("alpha_hat")])
