"""Lyapunov functions of the error dynamics, and the combinations of errors that are observable (w) or conserved (q).

Errors are true minus estimate. ``(13)`` is the paper's, with its one slip put right; the others are the repairs. In complex
shorthand w = alpha xi_tilde - j omega z_tilde and q = k_3 z_tilde - j kappa s xi_tilde, with s the direction of rotation.
"""


def corrected_13(i_ds_tilde, i_qs_tilde, z_1_tilde, z_2_tilde, xi_1_tilde, xi_2_tilde, alpha_tilde, omega_tilde,
                 alpha, omega, omega_hat, k_2, k_3, g, K_p):
    """V of (13) in A^2, with alpha/(2 k_3) where alpha/(2 k_2) is printed. Needs omega and omega_hat of one sign."""
    return (
        (i_ds_tilde**2 + i_qs_tilde**2) / 2
        + omega / (2 * k_2 * omega_hat) * (z_1_tilde**2 + z_2_tilde**2)
        + alpha / (2 * k_3) * (xi_1_tilde**2 + xi_2_tilde**2)
        + alpha_tilde**2 / (2 * g)
        + omega_tilde**2 / (2 * K_p)
    )


def with_direction(i_ds_tilde, i_qs_tilde, z_1_tilde, z_2_tilde, xi_1_tilde, xi_2_tilde, alpha_tilde, omega_tilde,
                   alpha, omega, direction, kappa, k_3, g, K_p):
    """V in A^2 of the repaired observer: the z term has the weight |omega| / (2 kappa), |omega| = s omega."""
    return (
        (i_ds_tilde**2 + i_qs_tilde**2) / 2
        + direction * omega / (2 * kappa) * (z_1_tilde**2 + z_2_tilde**2)
        + alpha / (2 * k_3) * (xi_1_tilde**2 + xi_2_tilde**2)
        + alpha_tilde**2 / (2 * g)
        + omega_tilde**2 / (2 * K_p)
    )


def reduced(i_ds_tilde, i_qs_tilde, w_1, w_2, alpha_tilde, omega_tilde, strength, g, K_p):
    """V in A^2 on the observable errors alone; ``strength`` in 1/s^2 is the c > 0 of w' = -c i_tilde."""
    return (
        (i_ds_tilde**2 + i_qs_tilde**2) / 2
        + (w_1**2 + w_2**2) / (2 * strength)
        + alpha_tilde**2 / (2 * g)
        + omega_tilde**2 / (2 * K_p)
    )


def observable(z_1_tilde, z_2_tilde, xi_1_tilde, xi_2_tilde, alpha, omega):
    """``(w_1, w_2)`` in A/s, w = alpha xi_tilde - j omega z_tilde: all that the current errors see of z and xi."""
    return alpha * xi_1_tilde + omega * z_2_tilde, alpha * xi_2_tilde - omega * z_1_tilde


def conserved(z_1_tilde, z_2_tilde, xi_1_tilde, xi_2_tilde, kappa, k_3, direction):
    """``(q_1, q_2)`` in A/s, q = k_3 z_tilde - j kappa s xi_tilde: constant for the repaired observer, whatever happens."""
    return k_3 * z_1_tilde + kappa * direction * xi_2_tilde, k_3 * z_2_tilde - kappa * direction * xi_1_tilde
