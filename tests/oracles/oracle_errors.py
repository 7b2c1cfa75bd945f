"""A second route to the ledger's central numbers: machine and observers as complex equations, derivatives by small steps.

Written from the vector equations, without `equations/` and without the ledger.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Case:
    """Parameters, gains and the true state; complex numbers are d + j q."""

    rate: float  # R_s / sigma
    coupling: float  # 1 + beta L_m
    alpha: float
    omega: float
    k_1: float
    k_2: float
    k_3: float
    g: float
    K_p: float
    i: complex
    z: complex


# z feedback as a function of (current error, gain): what is added to the rate of z_hat.
FEEDBACK = {
    "printed_7": lambda e, gain: complex(-gain * e.real, gain * e.imag),
    "printed_L": lambda e, gain: -1j * gain * e,
    "consistent_12": lambda e, gain: 1j * gain * e,
}


def error_rates(case: Case, e, z, xi, a, w, feedback, gain, sign=1.0):
    """Rates of the errors (current, z, xi, alpha, omega): true minus estimate; the voltage cancels and is left out."""
    i_hat, z_hat, xi_hat = case.i - e, case.z - z, case.z - xi
    alpha_hat, omega_hat = case.alpha - a, case.omega - w
    true_i = (
        -case.rate * case.i
        - case.alpha * case.coupling * case.i
        + 1j * case.omega * case.i
        + (case.alpha - 1j * case.omega) * case.z
    )
    hat_i = (
        -case.rate * i_hat
        - alpha_hat * case.coupling * case.i
        + 1j * omega_hat * i_hat
        + alpha_hat * xi_hat
        - 1j * omega_hat * z_hat
        + case.k_1 * e
    )
    hat_alpha = case.g * (e.conjugate() * (xi_hat - case.coupling * case.i)).real
    hat_omega = case.K_p * sign * (e.conjugate() * (-1j) * (z_hat - i_hat)).real
    return true_i - hat_i, -FEEDBACK[feedback](e, gain), -case.k_3 * e, -hat_alpha, -hat_omega
