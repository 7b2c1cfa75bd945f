"""The Luenberger observer (7) with known alpha, and its speed adaptation (11), in the paper's three conventions.

State ``(i_ds_hat, i_qs_hat, z_1_hat, z_2_hat, omega_hat)``, ``p`` is ``(R_s, L_m, sigma, beta, alpha)``, ``gains`` is
``(k_1, k_2, K_p)``.
"""

from imo_analysis.equations.excitation import alpha_direction, speed_direction
from imo_analysis.equations.feedback import feedback_consistent_12, feedback_printed_7, feedback_printed_L


def luenberger(x, i, u, p, gains, z_feedback, law_sign):
    """Rates of (7) with the z feedback given, and of omega_hat by (11) with ``law_sign`` in place of Sign(omega)."""
    i_ds_hat, i_qs_hat, z_1_hat, z_2_hat, omega_hat = x
    i_ds, i_qs = i
    u_ds, u_qs = u
    R_s, L_m, sigma, beta, alpha = p
    k_1, _, K_p = gains
    i_ds_tilde = i_ds - i_ds_hat
    i_qs_tilde = i_qs - i_qs_hat
    v_1 = alpha_direction(i, (z_1_hat, z_2_hat), beta, L_m)
    v_2 = speed_direction((i_ds_hat, i_qs_hat), (z_1_hat, z_2_hat))
    return (
        -R_s / sigma * i_ds_hat + alpha * v_1[0] + omega_hat * v_2[0] + k_1 * i_ds_tilde + u_ds / sigma,
        -R_s / sigma * i_qs_hat + alpha * v_1[1] + omega_hat * v_2[1] + k_1 * i_qs_tilde + u_qs / sigma,
        -R_s / sigma * i_ds + z_feedback[0] + u_ds / sigma,
        -R_s / sigma * i_qs + z_feedback[1] + u_qs / sigma,
        K_p * law_sign * (i_ds_tilde * v_2[0] + i_qs_tilde * v_2[1]),
    )


def luenberger_printed_7(x, i, u, direction, p, gains):
    """(7) and (11) as printed."""
    return luenberger(x, i, u, p, gains, feedback_printed_7(i[0] - x[0], i[1] - x[1], gains[1], x[4]), direction)


def luenberger_printed_L(x, i, u, direction, p, gains):
    """(7) with the z feedback of L(omega_hat), and (11) as printed."""
    return luenberger(x, i, u, p, gains, feedback_printed_L(i[0] - x[0], i[1] - x[1], gains[1], x[4]), direction)


def luenberger_consistent_12(x, i, u, direction, p, gains):
    """(7) with the z feedback that (12) needs, and (11) as printed."""
    return luenberger(x, i, u, p, gains, feedback_consistent_12(i[0] - x[0], i[1] - x[1], gains[1], x[4]), direction)
