"""What an observer's full linearisation says of its speed estimate: how fast, how calm, how noisy and how wrong, for batches.

About a steady state in the frame of the flux, with alpha_hat held, the errors obey ``x' = A x + B n``, with the speed error
among them. Its modes ``A v = lambda v`` split the answer of the speed error to an error of the speed (a step of the true
speed), and to white noise on the currents, into sums of exponentials, from which all numbers here follow. Modes that neither of
the two answers contains are left out: the offsets of z_hat and xi_hat that no current shows.

Where the observer believes wrong parameters, the same is done about the state in which it then rests
(`imo_analysis.pencils.operating`). There the currents do show those offsets, faintly: they stay what they were, and turn with
the stator frequency as a ripple of the speed that no gain damps. They are left out there too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.machine import InductionMachine
from imo_analysis.pencils.error import Gains, OperatingPoint, arguments, gain_values, machine_parameters
from imo_analysis.pencils.held import held_rates, with_held_alpha
from imo_analysis.pencils.jacobian import jacobian, known_observer
from imo_analysis.pencils.operating import equilibrium

Array = NDArray[np.float64]
BAND = 0.02  # of the first error: within it the estimate counts as settled
RECOVERY = 4.0  # time constants: exp(-4) is 1.8 %
_UNSEEN = 1e-8  # of the largest mode: less is rounding
_NEWTON = 5
_NEUTRAL = 1e-6  # of the stator frequency
_TIMES = np.geomspace(2e-4, 8.0, 340)  # s


@dataclass(frozen=True)
class Response:
    """Numbers of the speed estimate, each an array of the shape that points, gains and errors broadcast to.

    Attributes
    ----------
    settling : ndarray
        Time in s after which an error of the speed estimate stays below `BAND` of its first value; infinity where it does not.
    overshoot : ndarray
        How far the error swings to the other side, as a share of its first value.
    recovery : ndarray
        `RECOVERY` time constants of the slowest mode in s: after that a wrong start of any kind, of the flux too, is forgotten.
    noise : ndarray
        Deviation of the speed estimate in rad/s for white noise on both currents of density 1 A^2 s; infinity if unstable.
    bias : ndarray
        Error of the speed at rest in rad/s, true minus estimate; NaN where there is no state at rest.
    lag : ndarray
        By how much the estimate stays behind a speed that rises evenly, in rad/s for 1 rad/s^2: in s.
    fastest : ndarray
        Largest magnitude of a mode in rad/s: what the sampling has to bear.
    """

    settling: Array
    overshoot: Array
    recovery: Array
    noise: Array
    bias: Array
    lag: Array
    fastest: Array


def response(
    machine: InductionMachine,
    name: str,
    gains: Gains,
    point: OperatingPoint,
    errors: Mapping[str, Any] | None = None,
    times: Array = _TIMES,
    band: float = BAND,
    quick: bool = False,
) -> Response:
    """The numbers of one observer.

    Parameters
    ----------
    machine : InductionMachine
        The true machine.
    name : str
        The observer, as in the catalogue.
    gains : mapping of str to float or array
        By name.
    point : OperatingPoint
        Steady state; floats or arrays, which broadcast with gains and errors.
    errors : mapping, optional
        Relative errors of what the observer believes, by machine field.
    times : ndarray
        Increasing times in s at which the answer is looked at: settling times are of this resolution.
    band : float
        What counts as settled, as a share.
    quick : bool
        Find the state at rest by a few steps of Newton's method from the right one, instead of following it: for a search.
    """
    A, B, bias = linearisation(machine, name, gains, point, errors, quick)
    there = np.isfinite(bias)
    A = np.where(there[..., None, None], A, np.eye(A.shape[-1]))
    B = np.where(there[..., None, None], B, 0.0)
    modes, right = np.linalg.eig(A)
    left = np.linalg.inv(right)
    speed = right[..., -1, :]  # omega_tilde is the last state
    offsets = _offsets(name, modes, np.asarray(point.omega + point.slip, dtype=float))
    step = np.where(offsets, 0.0, speed * left[..., :, -1])
    noisy = np.where(offsets[..., None], 0.0, speed[..., None] * (left @ B))
    size = np.linalg.norm(noisy, axis=-1)
    seen = (np.abs(step) > _UNSEEN * np.abs(step).max(axis=-1, keepdims=True)) | (
        size > _UNSEEN * size.max(axis=-1, keepdims=True))
    decay = np.where(seen, -modes.real, np.inf).min(axis=-1)
    stable = there & (decay > 0)
    settling, overshoot = _answer(modes, np.where(seen & (modes.real < 0), step, 0.0), times, band)
    lag = np.divide(step, -modes, out=np.zeros_like(step), where=seen & (modes != 0)).sum(axis=-1).real
    power = np.where(seen[..., None], noisy, 0.0)
    pairs = power @ np.conj(np.swapaxes(power, -1, -2))
    sums = -(modes[..., :, None] + np.conj(modes[..., None, :]))
    variance = np.divide(pairs, sums, out=np.zeros_like(pairs), where=pairs != 0).sum(axis=(-1, -2)).real
    return Response(
        np.where(stable, settling, np.inf), np.where(stable, overshoot, np.inf),
        np.divide(RECOVERY, decay, out=np.full(decay.shape, np.inf), where=stable),
        np.sqrt(np.where(stable, np.maximum(variance, 0.0), np.inf)), bias, np.where(stable, lag, np.inf),
        np.where(seen, np.abs(modes), 0.0).max(axis=-1))


def linearisation(
    machine: InductionMachine, name: str, gains: Gains, point: OperatingPoint, errors: Mapping[str, Any] | None = None,
    quick: bool = False,
) -> tuple[Array, Array, Array]:
    """``A`` and ``B`` (noise of the currents) of the errors with alpha_hat held, the speed error last; and the speed's bias."""
    if errors and quick:
        return _near(machine, name, gains, point, errors)
    if errors:
        at = equilibrium(machine, name, gains, point, errors)
        law = held_rates(name)
        n = len(law.states)
        whole = law.derivative(at.values)
        return whole[..., :n, :n], -whole[..., :n, n : n + 2], at.errors["omega_tilde"]
    derived = jacobian(with_held_alpha(known_observer(name)).name, "full")
    kept = [k for k, state in enumerate(derived.states) if state != "alpha_tilde"]
    whole = derived.evaluate(arguments(derived, machine, _without_supervisor(derived.observer, gains), point))
    n = len(derived.states)
    A = whole[..., kept, :][..., kept]
    return A, whole[..., kept, n : n + 2], np.zeros(A.shape[:-2])


def _near(
    machine: InductionMachine, name: str, gains: Gains, point: OperatingPoint, errors: Mapping[str, Any]
) -> tuple[Array, Array, Array]:
    """`linearisation` at the state at rest that Newton's method finds from the right one; NaN where it finds none."""
    law = held_rates(name)
    n = len(law.states)
    fields = {field: getattr(machine, field) * (1 + np.asarray(error, dtype=float)) for field, error in errors.items()}
    believed = machine_parameters(machine, fields)
    values: dict[str, Any] = {**point.quantities(machine.observer_parameters), **believed, **gain_values(name, gains)}
    true = {**values, "alpha": machine.alpha}
    values |= {"alpha_hat": believed["alpha"], "direction": np.where(np.asarray(point.omega) < 0, -1.0, 1.0)}
    start = [np.asarray(true[state.removesuffix("_hat")], dtype=float) for state in law.states]
    shape = np.broadcast_shapes(*(np.shape(values[key]) for key in values), *(one.shape for one in start))
    x = np.stack([np.broadcast_to(one, shape) for one in start], axis=-1)
    size = 1 + np.abs(x)
    move = x
    for _ in range(_NEWTON):
        values |= dict(zip(law.states, np.moveaxis(x, -1, 0), strict=True))
        slope = law.derivative(values)[..., :n, :n]
        slope = np.where(np.isfinite(slope).all(axis=(-1, -2), keepdims=True), slope, np.eye(n))
        move = np.linalg.solve(slope + 1e-12 * np.eye(n), law.rates(values)[..., :n, None])[..., 0]
        x = np.where(np.isfinite(move), x - move, x)
    values |= dict(zip(law.states, np.moveaxis(x, -1, 0), strict=True))
    whole = law.derivative(values)
    found = (np.abs(move) < 1e-6 * size).all(axis=-1) & np.isfinite(whole).all(axis=(-1, -2))
    return whole[..., :n, :n], -whole[..., :n, n : n + 2], np.where(found, np.asarray(point.omega) - x[..., -1], np.nan)


def _without_supervisor(name: str, gains: Gains) -> Gains:
    """The gains that the observer with this name has, out of those of one that supervises it."""
    if not isinstance(gains, Mapping):
        return gains
    return {gain: value for gain, value in gains.items() if gain in known_observer(name).gains}


def _offsets(name: str, modes: Any, frequency: Array) -> NDArray[np.bool_]:
    """Which modes are the constant offsets of z_hat and xi_hat: those at -+j times the stator frequency, by structure."""
    if "xi_1_hat" not in known_observer(name).states:
        return np.zeros(modes.shape, dtype=bool)
    off = np.abs(modes - 1j * np.copysign(frequency[..., None], modes.imag))
    return np.asarray(off < _NEUTRAL * (1 + np.abs(frequency[..., None])))


def _answer(modes: Any, step: Any, times: Array, band: float) -> tuple[Array, Array]:
    """Settling time and overshoot of the sum of exponentials."""
    # of a conjugate pair one mode, twice; what is unstable is left out by the caller and must not overflow
    upper = modes.imag >= 0
    weight = np.where(upper, np.where(modes.imag > 0, 2.0, 1.0) * step, 0.0)
    kept = max(int(np.count_nonzero(weight, axis=-1).max(initial=1)), 1)
    order = np.argsort(weight == 0, axis=-1, kind="stable")[..., :kept]
    weight, rate = (np.take_along_axis(one, order, axis=-1) for one in (weight, modes))
    rate = np.where(weight != 0, np.minimum(rate.real, 0.0) + 1j * rate.imag, 0.0)
    answer = (weight[..., None, :] @ np.exp(rate[..., None] * times))[..., 0, :].real
    outside = np.abs(answer) > band
    last = len(times) - 1 - np.argmax(outside[..., ::-1], axis=-1)
    after = np.minimum(last + 1, len(times) - 1)
    settling = np.where(outside.any(axis=-1), times[after], times[0])
    return np.where(outside[..., -1], np.inf, settling), np.maximum(-answer.min(axis=-1), 0.0)
