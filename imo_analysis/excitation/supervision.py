"""The supervisor's threshold S_0 from the noise of the current: above what noise alone makes of S, below what modulation makes.

S is the running mean square of r, the part of v_1 across v_2 (claim ``supervisor.window``). At constant flux r is noise, of a
variance s^2 that follows from the equations of the observer (their Jacobian) and of the drive's current loop, driven by white
noise of the current: a Lyapunov equation (`noise_floor`). With e^2 the variance of the current error along r, both normal,

    mean of the gate <= 105 (s^2 / S_0)^4,        |mean rate of alpha_hat| <= c g s e (s^2 / S_0)^4,  c = sqrt(3 15!!) = 2466,

for the gate is at most (S / S_0)^4, the mean of S^n at most that of r^(2n) (claim ``supervisor.threshold``), and a normal r has
the moments 105 s^8 and 15!! s^16 (Schwarz's inequality for the rest). So S_0 = s^2 (c g s e / rate)^(1/4) bounds the drift.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.steady_state import current_of_flux
from imo_analysis.equations.transformation import to_z
from imo_analysis.excitation.bounds import slip_at
from imo_analysis.machine import InductionMachine
from imo_analysis.study_tables import Drive

Array = NDArray[np.float64]
EIGHTH, SIXTEENTH = 105, 2027025  # moments of a standard normal variable: 7!!, 15!!
_RATE = math.sqrt(3 * SIXTEENTH)
OPEN = 0.9  # the gate that a modulation must reach


@dataclass(frozen=True)
class NoiseFloor:
    """What noise makes of the supervisor's signals at constant flux: variances in A^2.

    Attributes
    ----------
    across : float
        s^2, the mean of S.
    error : float
        e^2, of the measured current error along r.
    """

    across: float
    error: float

    def gate(self, S_0: float) -> float:
        """Upper bound of the mean of the gate."""
        return EIGHTH * (self.across / S_0) ** 4

    def drift(self, g: float, S_0: float) -> float:
        """Upper bound of the mean rate of alpha_hat, in 1/s^2."""
        return _RATE * g * math.sqrt(self.across * self.error) * (self.across / S_0) ** 4

    def threshold(self, g: float, drift: float) -> float:
        """The smallest S_0, in A^2, at which `drift` is at most ``drift`` (1/s^2)."""
        return float(self.across * (_RATE * g * math.sqrt(self.across * self.error) / drift) ** 0.25)


def noise_floor(machine: InductionMachine, gains: Mapping[str, float], drive: Drive, noise: float, omega: float, torque: float,
                eta: float = 1.0, step: float = 1e-4) -> NoiseFloor:
    """Variances at one speed and load.

    Parameters
    ----------
    gains : mapping
        Of the observer `across` that is supervised.
    drive : Drive
        Its flux and current bandwidth: the noise moves the currents themselves through its loop.
    noise : float
        Standard deviation of each current sample and axis, in A.
    omega, torque : float
        In rad/s and N m.
    eta : float
        Rate of the supervisor's filters, 1/s.
    step : float
        Time from sample to sample, in s.
    """
    from scipy.linalg import solve_continuous_lyapunov

    slip = slip_at(machine, torque, drive.flux)
    A, B, C = _error_filter(machine, gains, drive.flux, omega, slip, eta)
    n = len(A)
    F = np.zeros((n + 2, n + 2))  # with the true current and flux along the flux, as the noise moves them
    F[:n, :n] = A
    F[n, n] = -drive.current_bandwidth
    F[n + 1, n:] = machine.alpha * machine.L_m, -machine.alpha
    G = np.vstack([B, [[-drive.current_bandwidth, 0.0], [0.0, 0.0]]])
    out = np.concatenate([C, [-machine.beta * machine.L_m, machine.beta]])  # less (beta/alpha) psi'
    P = solve_continuous_lyapunov(F, -G @ G.T * (noise * noise * step))
    return NoiseFloor(float(out @ P @ out), float(noise * noise + P[0, 0]))


def _error_filter(machine: InductionMachine, gains: Mapping[str, float], flux: float, omega: float, slip: float, eta: float,
                  ) -> tuple[Array, Array, Array]:
    """Noise to r by the errors of `across` at rest, alpha_hat standing still: x' = A x + B n, r = C x, in the flux's frame.

    x is (i_tilde, w, omega_tilde, d_1, d_2) with d_k the deviations of v_k from their running means. Errors of xi_hat and z_hat
    that leave w are open integrators of the noise; none of these sees them.
    """
    A, B = _frozen_alpha(machine, gains, flux, omega, slip)
    L = 1 + machine.beta * machine.L_m
    v = np.zeros((4, 7))  # v_1 and v_2 of the estimates, by the errors (i, z, xi, omega)
    v[[0, 1], [0, 1]], v[[0, 1], [4, 5]] = L, -1.0
    v[2, [1, 3]], v[3, [0, 2]] = (1.0, -1.0), (-1.0, 1.0)
    means = np.kron(np.eye(2), [[-eta, omega + slip], [-omega - slip, -eta]])
    whole = np.block([[A, np.zeros((7, 4))], [eta * v, means]])
    x = np.zeros((9, 11))
    x[[0, 1], [0, 1]] = 1.0
    x[2, [4, 3]], x[3, [5, 2]] = (machine.alpha, omega), (machine.alpha, -omega)
    x[4, 6] = 1.0
    x[5:] = np.hstack([v, -np.eye(4)])
    reduced = x @ whole @ np.linalg.pinv(x)
    r = np.zeros(9)
    r[5], r[7] = 1.0, -slip / machine.alpha
    return reduced, x @ np.vstack([B, np.zeros((4, 2))]), r


def _frozen_alpha(machine: InductionMachine, gains: Mapping[str, float], flux: float, omega: float, slip: float,
                  ) -> tuple[Array, Array]:
    """A and B (by the current noise) of the errors (i, z, xi, omega) of `across` at constant flux."""
    from imo_analysis.pencils.jacobian import jacobian

    i = current_of_flux(flux, 0.0, slip, machine.alpha, machine.L_m)
    z = to_z(i[0], i[1], flux, 0.0, machine.beta)
    derived = jacobian("across", "full")
    values = {"R_s": machine.R_s, "L_m": machine.L_m, "sigma": machine.sigma, "beta": machine.beta, "alpha": machine.alpha,
              **gains, "i_ds": i[0], "i_qs": i[1], "z_1": z[0], "z_2": z[1], "omega": omega,
              "direction": -1.0 if omega < 0 else 1.0, "stator_frequency": omega + slip}
    matrix = derived.evaluate({name: values[name] for name in derived.arguments})
    kept = [k for k, state in enumerate(derived.states) if state != "alpha_tilde"]
    first = len(derived.states) + derived.inputs.index("i_ds_noise")
    return matrix[np.ix_(kept, kept)], matrix[kept, first:first + 2]


def ceiling(S: float) -> float:
    """The largest S_0 at which an excitation S opens the gate by `OPEN`, in A^2."""
    return float(S * ((1 - OPEN) / OPEN) ** 0.25)


def between(low: float, high: float) -> float:
    """The S_0 that is as many times above ``low`` as below ``high``."""
    return math.sqrt(low * high)
