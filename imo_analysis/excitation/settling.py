"""How fast alpha_hat settles while the flux is modulated: averaged, in closed form, and by Floquet's multipliers.

Averaged over the modulation, the error of alpha_hat decays at

    rate = g sum_nu |v_1(nu)|^2 Re H(nu),
    H(nu) = 1 / (k + j (nu - omega) + (alpha k_3 + kappa |omega|) / (j nu)),

over the sidebands nu = omega_s +- n frequency of every line n of the flux's shape, |v_1| = beta psi depth |c_n| n frequency /
alpha (no load; a load does not change which part of v_1 is across v_2). Where a sideband nearly stands (nu within some rad/s
of 0) that is the rate of the larger part of the error only: the rest, of some per cent, settles far more slowly, and at nu = 0
never. The damping k is k_1 + R_s/sigma, and alpha (1 + beta
L_m) more where i_hat stands beside alpha_hat (claim ``noise.quiet``). The law of `across` is the same one once omega_hat has
followed, and that of `supervised` is g times its gate.

`floquet` knows nothing of this: it follows the error dynamics, differentiated from the observer's own equations, over one
period at constant speed and held torque, for the slowest multiplier in which alpha_hat moves and for what is left of its error
after a time.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.steady_state import current_of_flux
from imo_analysis.equations.supervised import gate
from imo_analysis.equations.transformation import to_z
from imo_analysis.excitation.swing import COSINE, Shape
from imo_analysis.machine import InductionMachine

Array = NDArray[np.float64]
QUIET = ("quiet", "across", "supervised")  # i_hat beside alpha_hat
KINDS = ("repaired", *QUIET)  # the observers whose alpha_hat settles in this way
DRIFTS = ("repaired", "quiet")  # those whose alpha_hat a change of speed moves (claim ``resting.drift``)
_STEPS = 2500.0  # a second, per step of the fourth-order rule: the currents' errors swing at sqrt(K_p) beta psi
_FILLED = 12.0  # time constants after which a filter is full to 1e-5
_MOVES = 1e-3  # share of alpha_hat in a Floquet mode, of the largest share, from which on it counts as moving


def settling_rate(
    machine: InductionMachine,
    gains: Mapping[str, float],
    flux: float,
    depth: float,
    frequency: float,
    omega: Any,
    slip: Any = 0.0,
    shape: Shape = COSINE,
    kind: str = "repaired",
) -> Any:
    """Averaged decay rate of the alpha error, in 1/s.

    Parameters
    ----------
    gains : mapping
        k_1, kappa, k_3, g; S_0 for ``supervised``.
    flux : float
        Mean flux in Wb; it swings by ``depth`` at ``frequency`` (rad/s).
    omega, slip : float or arrays that broadcast
        In rad/s.
    kind : str
        One of `KINDS`.
    """
    damping = gains["k_1"] + machine.R_s / machine.sigma
    if kind in QUIET:
        damping += machine.alpha * (1 + machine.beta * machine.L_m)
    omega, slip = np.broadcast_arrays(np.asarray(omega, float), np.asarray(slip, float))
    lines = np.concatenate([shape.orders, -shape.orders]) * frequency
    nu = (omega + slip)[..., None] + lines
    strength = (machine.alpha * gains["k_3"] + gains["kappa"] * np.abs(omega))[..., None]
    with np.errstate(divide="ignore", invalid="ignore"):
        answer = np.where(nu == 0, 0.0, np.real(1 / (damping + 1j * (nu - omega[..., None]) - 1j * strength / nu)))
    side = machine.beta * flux * depth / machine.alpha * np.tile(np.abs(shape.amplitudes), 2) * np.abs(lines)
    rate = gains["g"] * (side * side * answer).sum(axis=-1)
    if kind == "supervised":
        rate = rate * gate(seen_by_supervisor(machine, flux, depth, frequency, shape), gains["S_0"])
    return rate


def seen_by_supervisor(machine: InductionMachine, flux: float, depth: float, frequency: float, shape: Shape = COSINE) -> float:
    """S of the supervisor under modulation, in A^2: the mean square of v_1 across v_2, (beta psi'/alpha)^2."""
    swing = machine.beta * flux * depth * frequency / machine.alpha
    return swing * swing * shape.mean_square_rate


def opening_time(machine: InductionMachine, gains: Mapping[str, float], flux: float, depth: float, frequency: float,
                 shape: Shape = COSINE) -> float:
    """The time in s that `supervised` loses while its S fills, int (1 - gate(t) / gate) dt, with S (1 - exp(-eta t)); infinite
    without modulation.
    """
    S = seen_by_supervisor(machine, flux, depth, frequency, shape)
    if S == 0:
        return math.inf
    t = np.linspace(0.0, _FILLED, 2001)  # over 1 / eta
    lost = 1 - gate(S * (1 - np.exp(-t)), gains["S_0"]) / gate(S, gains["S_0"])
    return float(np.trapezoid(lost, t)) / gains["eta"]


def floquet(
    machine: InductionMachine,
    gains: Mapping[str, float],
    flux: float,
    depth: float,
    frequency: float,
    omega: Any,
    slip: Any = 0.0,
    shape: Shape = COSINE,
    kind: str = "repaired",
    time: float = 1.0,
) -> tuple[Array, Array]:
    """How the error of alpha_hat settles, by Floquet's multipliers. Parameters as `settling_rate`.

    ``kind`` may be any adaptive observer whose equations turn with the frame; ``supervised`` is `across` with g times the
    gate, for at no error its gate stands.

    Returns
    -------
    rate : array
        Decay rate of the slowest error in which alpha_hat moves, in 1/s; negative where it grows.
    left : array
        What is left of an error of alpha_hat alone after ``time`` (s), as a share of it: after the whole periods in it, and at
        the slowest rate for the rest.
    """
    from imo_analysis.pencils.jacobian import jacobian

    gains = dict(gains)
    if kind == "supervised":
        gains["g"] *= gate(seen_by_supervisor(machine, flux, depth, frequency, shape), gains["S_0"])
    derived = jacobian("across" if kind == "supervised" else kind, "full")
    both = np.broadcast_arrays(np.asarray(omega, float), np.asarray(slip, float))
    omega, slip = (np.atleast_1d(one)[:, None] for one in both)
    steps = max(64, math.ceil(2 * math.pi / frequency * _STEPS))
    h = 2 * math.pi / frequency / steps
    psi = flux * (1 + depth * shape.sampled(2 * steps))
    turning = slip * (flux / psi) ** 2
    i_d, i_q = current_of_flux(psi, flux * depth * frequency * shape.sampled(2 * steps, 1), turning, machine.alpha, machine.L_m)
    z_1, z_2 = to_z(i_d, i_q, psi, 0.0, machine.beta)
    values = {"R_s": machine.R_s, "L_m": machine.L_m, "sigma": machine.sigma, "beta": machine.beta, "alpha": machine.alpha,
              **gains, "i_ds": i_d, "i_qs": i_q, "z_1": z_1, "z_2": z_2, "omega": omega, "stator_frequency": omega + turning,
              "direction": np.where(omega < 0, -1.0, 1.0)}
    A = derived.system_matrix({name: values[name] for name in derived.arguments})
    over = _over_a_period(A, h)
    multipliers, modes = np.linalg.eig(over)
    rates = -np.log(np.abs(multipliers) + 1e-300) / (h * steps)
    alpha = derived.states.index("alpha_tilde")
    share = np.abs(modes[:, alpha])
    slowest = np.where(share > _MOVES * share.max(axis=1, keepdims=True), rates, np.inf).min(axis=1)
    periods = math.floor(time / (h * steps))
    left = np.abs(np.linalg.matrix_power(over, periods)[:, alpha, alpha])
    return slowest, left * np.exp(-slowest * (time - periods * h * steps))


def floquet_rate(*arguments: Any, **more: Any) -> Array:
    """The rate alone of `floquet`, which says what it takes."""
    return floquet(*arguments, **more)[0]


def _over_a_period(A: Array, h: float) -> Array:
    """The transition over a period of x' = A(t) x, A of shape (points, 2 steps, n, n), by Runge and Kutta's rule."""
    X = np.broadcast_to(np.eye(A.shape[-1]), (len(A), *A.shape[-2:])).copy()
    for k in range(0, A.shape[1], 2):
        first, middle, last = A[:, k], A[:, k + 1], A[:, (k + 2) % A.shape[1]]
        a = first @ X
        b = middle @ (X + h / 2 * a)
        c = middle @ (X + h / 2 * b)
        X = X + h / 6 * (a + 2 * b + 2 * c + last @ (X + h * c))
    return X
