"""Where the start leaves alpha_hat, predicted from the study before any simulation, and why there.

While the flux builds up, v_1 has a part beta psi'/alpha across v_2 that only an error of alpha can fill. Were xi_hat exact,
the error would be forgotten: slowly seen, as exp(-g/(k_1 + R_s/sigma) int (beta psi'/alpha)^2 dt), and the integral of psi'^2
is flux_bandwidth psi^2 / 2. But the current error that corrects alpha_hat moves xi_hat too, by k_3, and when v_1 fades
alpha_hat stands where v_1 alpha_tilde cancels what that left. `share_left` is the exact sum of both at standstill.

An acceleration during the build-up would raise alpha_hat as later ones do (`imo_analysis.excitation.resting`), were both copies
left alone (`left_alone`), and what it adds is forgotten only as far as the flux still moves. But the copies are corrected, and
remember: since the flux turns past what they do, neither part need have the sign that it has at standstill or on exact copies.
`landing` counts all of it: it integrates the error dynamics, the difference of the plain definitions, along the motion that the
flux loop and the speed loop make of the study's first reference, with currents at their references. No voltage, no current
loop, no sampling: these shape the first milliseconds, while the flux is too small to orient the drive, and are what the
prediction misses.

Where the flux stands, the repaired observer conserves `equations.drift.balance` and q = k_3 z_tilde - j kappa s xi_tilde; with
the family of rest states (three numbers) they fix where it ends. q is conserved through the start as well, while the direction
stays, so that from exact copies of z it ends on the one state of the family where both are exact again. The paper's observer
conserves no such q while omega_hat moves, and keeps errors in both.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations import drift, lyapunov
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.plant import plant_z
from imo_analysis.equations.steady_state import slip_of_torque
from imo_analysis.equations.transformation import to_z
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.simulation.drive import current_references, orientation
from imo_analysis.simulation.loaded_machine import direction_of, machine_rates
from imo_analysis.simulation.run import BOUND, drive_parameters

if TYPE_CHECKING:
    from imo_analysis.study import Study

Pair = tuple[float, float]
Array = NDArray[np.float64]
_BUILT_UP = 30.0  # time constants of the slower loop after which nothing of the start is left in the motion
_ACCURACY = 1e-7
_RESTED = 0.1  # of the speed, or of alpha, by which omega_hat may miss the family of rest states once flux and speed stand


@dataclass(frozen=True)
class Rest:
    """A rest state: estimates in 1/s and rad/s, errors of the two copies of z in A."""

    alpha_hat: float
    omega_hat: float
    xi_tilde: Pair
    z_tilde: Pair


@dataclass(frozen=True)
class Landing:
    """Where the start leaves the errors: before the first step of the speed, or once flux and speed have long stood.

    Attributes
    ----------
    time : float
        Up to which the start was followed, in s.
    rest : Rest
        The state then; of the repaired observer, where nothing comes in between, the rest state that follows.
    from_error, from_motion : float
        What is left of the initial error of alpha_hat, and what the acceleration of the start adds, in 1/s: their sum is
        alpha_hat less the true alpha.
    """

    time: float
    rest: Rest
    from_error: float
    from_motion: float

    @property
    def alpha_hat(self) -> float:
        """The estimate that the start leaves, in 1/s."""
        return self.rest.alpha_hat


def landing(study: Study, observer: str) -> Landing:
    """Where an adaptive observer lands after the start of a study.

    Parameters
    ----------
    study : Study
        Its initial state, first reference and load, flux, bandwidths and current limit are used. The drive and the observer are
        taken to know their machine, the drive to measure the speed, and sensors and inverter to be ideal.
    observer : str
        Name of an adaptive observer in the study.

    Raises
    ------
    InputError
        If the observer's errors grow without bound, it is not at rest although flux and speed have long stood, it does not
        adapt alpha, the flux is modulated, the reference is not of steps or the load not constant.
    """
    states = OBSERVERS[study.observers[observer].kind].states if observer in study.observers else ()
    if "alpha_hat" not in states:
        raise InputError(f"{observer!r} is not an adaptive observer of the study; it has no alpha_hat to land")
    if study.drive.flux_modulation:
        raise InputError(f"drive.flux_modulation = {study.drive.flux_modulation:g} Wb must be 0: a landing is predicted for a "
                         "flux that builds up and then stands")
    if study.reference.shape != "steps" or len(set(study.load_torque.T_l)) > 1:
        raise InputError("a landing is predicted for steps of the speed at constant load; "
                         'set reference.shape = "steps" and one T_l')
    start = _errors_at_start(study, observer)
    at = states.index("alpha_hat")
    time, rest = _rest_after(study, observer, start)
    bare = _rest_after(study, observer, np.where(np.arange(len(start)) == at, 0.0, start))[1] if start[at] else rest
    return Landing(time, rest, rest.alpha_hat - bare.alpha_hat, bare.alpha_hat - study.machine.alpha)


def left_alone(study: Study, observer: str) -> Study:
    """The study with both copies of an adaptive observer left alone: k_3 and the feedback of z_hat zero."""
    gains = study.observers[observer].gains
    return study.changed({f"observers.{observer}.gains.{name}": 0.0 for name in ("k_2", "kappa", "k_3") if name in gains})


def share_left(machine: InductionMachine, gains: Mapping[str, float], flux: float, flux_bandwidth: float) -> float:
    """What the build-up of the flux at standstill leaves of a small initial error of alpha_hat, as a share of it.

    The flux is that of a first-order build-up from zero, without a limit of the current. The sum of `drift.forgetting_ratio`'s
    products is the hypergeometric 1F2(1/2; 1/2 + r_1, 1/2 + r_2; -strength/4), where r_1 + r_2 = decay/2 and r_1 r_2 =
    memory/4; without k_3, and where the current error follows at once, it is exp(-strength / (2 decay)).

    Parameters
    ----------
    machine : InductionMachine
    gains : mapping
        k_1, k_3 and g, as for the paper's observer and the repaired one.
    flux, flux_bandwidth : float
        The flux in Wb and the bandwidth of its loop in rad/s.
    """
    swing = machine.beta * flux / machine.alpha
    strength = gains["g"] * swing * swing
    decay = (gains["k_1"] + machine.R_s / machine.sigma) / flux_bandwidth
    memory = machine.alpha * gains["k_3"] / flux_bandwidth**2
    with localcontext() as context:
        context.prec = 30 + math.ceil(math.sqrt(strength))  # the terms grow to exp(sqrt(strength)) before they fall
        numbers = [Decimal(value) for value in (strength, decay, memory)]
        term = total = Decimal(1)
        n = 0
        while abs(term) > Decimal(10) ** -20 or n * n < strength:
            n += 1
            term *= drift.forgetting_ratio(n, *numbers)
            total += term
        return float(total)


def loops(study: Study) -> Callable[[Sequence[float]], tuple[Pair, tuple[float, ...]]]:
    """The motion that flux loop and speed loop make of the first reference, with currents at their references.

    Returns
    -------
    callable
        From ``(phi_dr, phi_qr, omega, integral_speed)``, stationary frame, to the currents in A and the rates of these four.
    """
    machine, d = study.machine, drive_parameters(study)
    w_speed, flux_floor = d[3], d[6]
    omega_ref, load, p = study.reference.omega[0], study.load_torque.T_l[0], machine.plant_parameters
    friction = machine.B / machine.n_p

    def motion(x: Sequence[float]) -> tuple[Pair, tuple[float, ...]]:
        phi, omega = (x[0], x[1]), x[2]
        c, s, magnitude, inverse = orientation(phi, flux_floor)
        i_d, i_q, excess = current_references(x[3], omega, magnitude, inverse, omega_ref, study.drive.flux, p, d)
        i = (c * i_d - s * i_q, s * i_d + c * i_q)
        rates = machine_rates((*i, *phi, omega), (0.0, 0.0), load, p, friction)
        return i, (*rates[2:], w_speed * (w_speed * (omega_ref - omega) + excess))

    return motion


def error_rates(study: Study, observer: str) -> Callable[..., list[float]]:
    """The error dynamics: machine less observer, the voltage cancels.

    Returns
    -------
    callable
        ``rates(errors, i, phi, omega, omega_dot)`` in the stationary frame, ``errors`` true minus estimate in the order of the
        observer's states. What only the observer has (the filters of ``supervised``) counts as zero in the machine.
    """
    machine, settings = study.machine, study.observers[observer]
    known, p, gains = OBSERVERS[settings.kind], machine.observer_parameters, settings.gain_values

    def rates(errors: Sequence[float], i: Pair, phi: Pair, omega: float, omega_dot: float) -> list[float]:
        z = to_z(*i, *phi, machine.beta)
        moving = plant_z((*i, *z), (0.0, 0.0), omega, 0.0, p)
        more = [0.0] * (len(known.states) - 8)
        true = (*i, *z, *z, machine.alpha, omega, *more)
        estimate = tuple(value - error for value, error in zip(true, errors, strict=True))
        hat = known.rates(estimate, i, (0.0, 0.0), direction_of(omega), p, gains)
        return [a - b for a, b in zip((*moving, *moving[2:], 0.0, omega_dot, *more), hat, strict=True)]

    return rates


def _errors_at_start(study: Study, observer: str) -> Array:
    first, settings = study.initial, study.observers[observer]
    z = to_z(first.i_ds, first.i_qs, first.phi_dr, first.phi_qr, study.machine.beta)
    true = [first.i_ds, first.i_qs, *z, *z, study.machine.alpha, first.omega]
    hat = np.array(settings.initial_values)
    return np.pad(true, (0, len(hat) - 8)) - hat


def _rest_after(study: Study, observer: str, start: Array) -> tuple[float, Rest]:
    """How far the start was followed from these errors, and where it ends."""
    machine, settings = study.machine, study.observers[observer]
    built_up = _BUILT_UP / min(study.drive.flux_bandwidth, study.drive.speed_bandwidth)
    time = min([built_up, study.simulation.duration, *study.reference.time[1:2]])
    omega, errors = _follow(study, observer, start, time)
    error = dict(zip(OBSERVERS[settings.kind].states, errors, strict=True))
    xi, z = (error["xi_1_hat"], error["xi_2_hat"]), (error["z_1_hat"], error["z_2_hat"])
    state = Rest(machine.alpha - error["alpha_hat"], omega - error["omega_hat"], xi, z)
    if time < built_up:
        return time, state
    torque = study.load_torque.T_l[0] + machine.B * omega / machine.n_p
    slip = slip_of_torque(torque, study.drive.flux, machine.n_p, machine.L_r, machine.alpha)
    speed, _ = drift.rest(state.alpha_hat, z, omega, slip, machine.alpha)
    if abs(state.omega_hat - speed) > _RESTED * max(abs(omega), machine.alpha):
        raise InputError(f"{observer!r} does not land: {time:.3g} s after the start omega_hat is {state.omega_hat:.4g} rad/s, "
                         f"where it could rest at {speed:.4g} rad/s only; take other gains, or another observer")
    if settings.kind != "repaired" or not settings.gains["kappa"] or not settings.gains["k_3"]:
        return time, state
    gains = [settings.gains[name] for name in ("g", "K_p", "k_3", "kappa")]
    gains[3] *= direction_of(omega)
    return time, predict_rest(state.alpha_hat, state.omega_hat, xi, z, omega=omega, slip=slip, alpha=machine.alpha, gains=gains)


def _follow(study: Study, observer: str, start: Array, end: float) -> tuple[float, list[float]]:
    """Speed and errors at a time, from errors at time 0."""
    from scipy.integrate import solve_ivp

    motion, errors = loops(study), error_rates(study, observer)

    def rates(_: float, y: Array) -> list[float]:
        x = y.tolist()
        i, moved = motion(x[:4])
        return [*moved, *errors(x[4:], i, (x[0], x[1]), x[2], moved[2])]

    def bounded(_: float, y: Array) -> float:
        return BOUND - float(np.abs(y).sum())

    bounded.terminal = True  # type: ignore[attr-defined]
    first = study.initial
    y = np.concatenate([[first.phi_dr, first.phi_qr, first.omega, 0.0], start])
    done = solve_ivp(rates, (0.0, end), y, method="LSODA", rtol=_ACCURACY, atol=_ACCURACY, events=bounded)
    if done.t[-1] < end:
        raise InputError(f"{observer!r} does not land: its errors grow without bound within {done.t[-1]:.3g} s of the start; "
                         "take other gains")
    return float(done.y[2, -1]), done.y[4:, -1].tolist()


def conserved(alpha_hat: float, omega_hat: float, xi_tilde: Pair, z_tilde: Pair, slip: float, alpha: float,
              gains: Sequence[float]) -> tuple[float, float, float]:
    """``(balance, q_1, q_2)`` of the repaired observer; ``gains`` is ``(g, K_p, k_3, kappa s)``."""
    k_3, kappa_s = gains[2], gains[3]
    q = lyapunov.conserved(*z_tilde, *xi_tilde, kappa_s, k_3, 1)
    return float(drift.balance(alpha_hat, omega_hat, xi_tilde, z_tilde, slip, alpha, gains)), float(q[0]), float(q[1])


def predict_rest(alpha_hat: float, omega_hat: float, xi_tilde: Pair, z_tilde: Pair, *, omega: float, slip: float, alpha: float,
                 gains: Sequence[float]) -> Rest:
    """Where the repaired observer comes to rest at constant flux, speed and slip, from what it conserves.

    Parameters
    ----------
    alpha_hat, omega_hat : float
        At the start, in 1/s and rad/s; the current error is small against what it will become, or zero.
    xi_tilde, z_tilde : pair of float
        Errors at the start, in A.
    omega, slip, alpha : float
        True speed, slip and alpha.
    gains : sequence
        ``(g, K_p, k_3, kappa s)``, kappa not zero.

    Raises
    ------
    InputError
        If no rest state with alpha_hat > 0 has these conserved values.
    """
    from scipy.optimize import brentq

    target, q_1, q_2 = conserved(alpha_hat, omega_hat, xi_tilde, z_tilde, slip, alpha, gains)
    k_3, kappa_s = gains[2], gains[3]

    def state(value: float) -> Rest:
        speed = omega + slip / alpha * (alpha - value)
        factor = k_3 + kappa_s * speed / value  # q = factor z_tilde on the family
        z = (q_1 / factor, q_2 / factor)
        speed, xi = drift.rest(value, z, omega, slip, alpha)
        return Rest(value, speed, xi, z)

    def miss(value: float) -> float:
        rest = state(value)
        return conserved(value, rest.omega_hat, rest.xi_tilde, rest.z_tilde, slip, alpha, gains)[0] - target

    for width in (1.05, 1.3, 2.0, 5.0, 20.0):
        low, high = alpha_hat / width, alpha_hat * width
        if miss(low) * miss(high) <= 0:
            return state(float(brentq(miss, low, high, xtol=1e-13, rtol=1e-14)))
    raise InputError("no rest state with alpha_hat > 0 has these conserved values")
