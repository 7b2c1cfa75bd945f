"""The adaptive observer (8)-(11) in the paper's three conventions of the z feedback.

State ``(i_ds_hat, i_qs_hat, z_1_hat, z_2_hat, xi_1_hat, xi_2_hat, alpha_hat, omega_hat)``; ``p`` is ``(R_s, L_m, sigma,
beta, alpha)``, of which alpha is not used; ``gains`` is ``(k_1, k_2, k_3, g, K_p, alpha_l, delta)``. ``direction`` is the
Sign(omega) of (11), which Remark III.1 takes as known.

(8), (9) and (11) share two directions, in which errors of alpha_hat and of omega_hat push the currents: `alpha_direction` and
`speed_direction`. The current rows add them up with alpha_hat and omega_hat, the laws follow the current errors along them.
"""

from imo_analysis.equations.excitation import alpha_direction, speed_direction
from imo_analysis.equations.feedback import feedback_consistent_12, feedback_printed_7, feedback_printed_L
from imo_analysis.equations.projection import projection


def alpha_signal(i_tilde, i, xi_hat, beta, L_m):
    """The bracket of (9) without g, before the projection."""
    v_1 = alpha_direction(i, xi_hat, beta, L_m)
    return i_tilde[0] * v_1[0] + i_tilde[1] * v_1[1]


def speed_signal(i_tilde, i_hat, z_hat):
    """The bracket of (11), first line, without K_p and Sign."""
    v_2 = speed_direction(i_hat, z_hat)
    return i_tilde[0] * v_2[0] + i_tilde[1] * v_2[1]


def adaptive(x, i, u, p, gains, z_feedback, law_sign):
    """Rates of (8), (9) and (11) with the z feedback given and ``law_sign`` in place of Sign(omega)."""
    i_ds_hat, i_qs_hat, z_1_hat, z_2_hat, xi_1_hat, xi_2_hat, alpha_hat, omega_hat = x
    i_ds, i_qs = i
    u_ds, u_qs = u
    R_s, L_m, sigma, beta, _ = p
    k_1, _, k_3, g, K_p, alpha_l, delta = gains
    i_ds_tilde = i_ds - i_ds_hat
    i_qs_tilde = i_qs - i_qs_hat
    i_tilde = (i_ds_tilde, i_qs_tilde)
    v_1 = alpha_direction(i, (xi_1_hat, xi_2_hat), beta, L_m)
    v_2 = speed_direction((i_ds_hat, i_qs_hat), (z_1_hat, z_2_hat))
    return (
        -R_s / sigma * i_ds_hat + alpha_hat * v_1[0] + omega_hat * v_2[0] + k_1 * i_ds_tilde + u_ds / sigma,
        -R_s / sigma * i_qs_hat + alpha_hat * v_1[1] + omega_hat * v_2[1] + k_1 * i_qs_tilde + u_qs / sigma,
        -R_s / sigma * i_ds + z_feedback[0] + u_ds / sigma,
        -R_s / sigma * i_qs + z_feedback[1] + u_qs / sigma,
        -R_s / sigma * i_ds + k_3 * i_ds_tilde + u_ds / sigma,
        -R_s / sigma * i_qs + k_3 * i_qs_tilde + u_qs / sigma,
        projection(g * alpha_signal(i_tilde, i, (xi_1_hat, xi_2_hat), beta, L_m), alpha_hat, alpha_l, delta),
        K_p * law_sign * speed_signal(i_tilde, (i_ds_hat, i_qs_hat), (z_1_hat, z_2_hat)),
    )


def printed_7(x, i, u, direction, p, gains):
    """The expanded (8), with (9)-(11), as printed."""
    return adaptive(x, i, u, p, gains, feedback_printed_7(i[0] - x[0], i[1] - x[1], gains[1], x[7]), direction)


def printed_L(x, i, u, direction, p, gains):
    """(8) through its matrix L(omega_hat), with (9)-(11) as printed."""
    return adaptive(x, i, u, p, gains, feedback_printed_L(i[0] - x[0], i[1] - x[1], gains[1], x[7]), direction)


def consistent_12(x, i, u, direction, p, gains):
    """(8) with the z feedback that (12) needs, with (9)-(11) as printed."""
    return adaptive(x, i, u, p, gains, feedback_consistent_12(i[0] - x[0], i[1] - x[1], gains[1], x[7]), direction)
