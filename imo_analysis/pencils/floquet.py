"""Stability about a turning flux where it is not a matter of poles: observers whose equations change when the axes turn.

The z feedback that (7) prints does not commute with rotations. About a turning flux its linearisation is then periodic in any
frame, and what decides is Floquet's exponents: every error is a sum of e^(s t) times a periodic function, with s known up to
multiples of j times the stator frequency. For observers that do commute they are the poles, and serve as a check.

While the flux stands still (slip = -omega) the linearisation is time-invariant all the same, and `standing_matrix` gives it; it
depends on where the flux stands.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from imo_analysis.equations.own import shown
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.pencils.error import Gains, OperatingPoint, arguments
from imo_analysis.pencils.jacobian import derive, pairs

_VECTORS = (("i_ds", "i_qs"), ("z_1", "z_2"), ("xi_1", "xi_2"), ("phi_dr", "phi_qr"), ("m_1d", "m_1q"), ("m_2d", "m_2q"))
_DECAY = 12.0  # within a block no error falls by more than e^-12, so that none drowns in the rounding of another
_LARGEST = 800  # rows of the matrix whose eigenvalues are taken
_STEPS = 2**17
_TOLERANCE = 1e-9  # of the largest exponent, between one step width and half of it


def matrix_along(machine: InductionMachine, name: str, gains: Gains, point: OperatingPoint, angle: Any) -> np.ndarray:
    """System matrices of the full linearisation while the flux is at the given angles, in the frame of the flux.

    Parameters
    ----------
    machine, name, gains
        As for `imo_analysis.pencils.error.full_matrix`, for any observer of the catalogue.
    point : OperatingPoint
        One steady state.
    angle : float or array
        Of the rotor flux against the axes in which the observer is written, in rad.

    Returns
    -------
    array, shape ``angle.shape + (n, n)``
        In 1/s. It is the same at every angle for an observer that commutes with rotations.
    """
    derived = derive(name, "full")
    values = arguments(derived, machine, gains, point)
    angle = np.asarray(angle, dtype=float)
    cos, sin = np.cos(angle), np.sin(angle)
    for first, second in _VECTORS:
        if first in values:
            along, across = values[first], values[second]
            values[first], values[second] = cos * along - sin * across, sin * along + cos * across
    frame = float(values["stator_frequency"])
    values["stator_frequency"] = 0.0
    n = len(derived.states)
    turn, still = np.zeros((*angle.shape, n, n)), np.zeros((n, n))
    turn[..., range(n), range(n)] = 1.0
    names = [state.removesuffix("_tilde") for state in derived.states]
    for d, q in ((names.index(first), names.index(second)) for first, second in pairs(names)):
        turn[..., d, d] = turn[..., q, q] = cos
        turn[..., q, d], turn[..., d, q] = sin, -sin
        still[d, q], still[q, d] = frame, -frame
    A = np.broadcast_to(derived.system_matrix(values), turn.shape)
    return np.swapaxes(turn, -1, -2) @ A @ turn + still


def standing_matrix(
    machine: InductionMachine, name: str, gains: Gains, point: OperatingPoint, angle: float = 0.0
) -> np.ndarray:
    """The system matrix of the full linearisation about a flux that stands still at this angle (rad), ``(n, n)``, in 1/s.

    Raises
    ------
    InputError
        If the flux turns: slip is not -omega.
    """
    if point.omega + point.slip != 0:
        raise InputError(
            f"the flux turns at {point.omega + point.slip:g} rad/s; it stands still for slip = {-point.omega:g} rad/s, and "
            "where it turns use floquet_exponents"
        )
    return matrix_along(machine, name, gains, point, angle)


def floquet_exponents(machine: InductionMachine, name: str, gains: Gains, point: OperatingPoint) -> np.ndarray:
    """Floquet exponents of the full linearisation about a turning flux, shape ``(n,)``, complex, in 1/s.

    Parameters
    ----------
    machine, name, gains
        As for `imo_analysis.pencils.error.full_matrix`, for any observer of the catalogue.
    point : OperatingPoint
        One steady state with the flux turning.

    Returns
    -------
    array
        Sorted by real, then imaginary part. Imaginary parts are known up to multiples of the stator frequency, and taken next
        to zero; real parts below zero mean stable. The step is halved until all agree to 1e-9 of the largest.

    Raises
    ------
    InputError
        If the flux stands still, or turns so slowly that an error dies out many times over in one period.
    """
    frequency = point.omega + point.slip
    if frequency == 0:
        raise InputError("the flux stands still; its poles are those of standing_matrix, and depend on where it stands")
    period = 2 * np.pi / abs(frequency)
    sample = matrix_along(machine, name, gains, point, np.linspace(0, 2 * np.pi, 8, endpoint=False))
    decay = float(np.ptp(np.linalg.eigvals(sample).real))
    blocks = max(2, int(np.ceil(decay * period / _DECAY)))
    if blocks * sample.shape[-1] > _LARGEST:
        raise InputError(
            f"stator frequency = {frequency:g} rad/s is too low for Floquet exponents: errors decay by "
            f"e^-{decay * period:.0f} in a period; "
            f"take {2 * np.pi * decay * sample.shape[-1] / (_DECAY * _LARGEST):.2g} rad/s or more, or a standing flux"
        )
    steps = blocks * int(np.ceil(64 / blocks))
    before: np.ndarray | None = None
    while steps <= _STEPS:
        found = _exponents(machine, name, gains, point, blocks, steps, period)
        if before is not None and _apart(before, found, abs(frequency)) <= _TOLERANCE * np.abs(found).max():
            return found
        before, steps = found, 2 * steps
    raise InputError(f"the Floquet exponents of {shown(name)} do not settle with {steps // 2} steps a period; take smaller "
                     "gains")


def _exponents(machine: InductionMachine, name: str, gains: Gains, point: OperatingPoint, blocks: int, steps: int, period: float
               ) -> np.ndarray:
    """The exponents from a period of ``steps`` steps.

    The product of the blocks' transition matrices would lose every error that decays fast to rounding. The matrix that has the
    blocks on its cyclic subdiagonal keeps them: its eigenvalues are all ``blocks``-th roots of the product's.
    """
    frequency = np.sign(point.omega + point.slip)
    A = _transitions(lambda share: matrix_along(machine, name, gains, point, 2 * np.pi * frequency * share), steps, period)
    n = A.shape[-1]
    parts = A.reshape(blocks, steps // blocks, n, n)
    cyclic = np.zeros((blocks * n, blocks * n))
    for k in range(blocks):
        product = np.eye(n)
        for part in parts[k]:
            product = part @ product
        row = (k + 1) % blocks
        cyclic[row * n:(row + 1) * n, k * n:(k + 1) * n] = product
    every = np.log(np.linalg.eigvals(cyclic).astype(complex)) * (blocks / period)
    turn = 2 * np.pi / period
    # one of the copies, that differ by j times the stator frequency: cut the circle of imaginary parts at its widest gap
    around = np.sort(np.mod(every.imag, turn))
    gaps = np.diff(np.append(around, around[0] + turn))
    widest = int(np.argmax(gaps))
    cut = around[widest] + gaps[widest] / 2 - turn
    chosen = every[(every.imag >= cut) & (every.imag < cut + turn)]
    if len(chosen) != n:
        raise InputError(f"the Floquet exponents of {shown(name)} cannot be told apart at this operating point; move it a "
                         "little")
    imaginary = chosen.imag - turn * np.round(chosen.imag / turn)
    imaginary[np.abs(imaginary) <= _TOLERANCE * np.abs(chosen).max()] = 0.0  # real ones, but for rounding
    return np.sort(chosen.real + 1j * imaginary)


def _transitions(matrix: Any, steps: int, period: float) -> np.ndarray:
    """Transition matrices of x' = A(t) x over the steps of a period, by Magnus' method of fourth order.

    ``matrix`` takes shares of the period. (Blanes, Casas, Oteo and Ros, Phys. Rep. 470, 2009.)
    """
    from scipy.linalg import expm

    h = period / steps
    middle = (np.arange(steps) + 0.5) / steps
    early, late = (matrix(middle + side * np.sqrt(3) / (6 * steps)) for side in (-1, 1))
    return np.asarray(expm(h / 2 * (early + late) - h * h * np.sqrt(3) / 12 * (early @ late - late @ early)))


def _apart(one: np.ndarray, other: np.ndarray, turn: float) -> float:
    """Largest distance between two sets of exponents, matched, up to multiples of j times the stator frequency."""
    from scipy.optimize import linear_sum_assignment

    difference = one[:, None] - other[None, :]
    distance = np.hypot(difference.real, difference.imag - turn * np.round(difference.imag / turn))
    return float(distance[linear_sum_assignment(distance)].max())
