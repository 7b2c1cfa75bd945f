"""The baseline adaptive full-order observer (2)-(4) of Kubota, Matsuse and Nakano (IEEE Trans. Ind. Appl. 29(2), 1993).

Equation (3) is lost in the scan; it is the copy of (2) with L (y - y_hat), L = [[l_1, -l_2], [l_2, l_1], [l_3, -l_4],
[l_4, l_3]], the most general gain that commutes with rotations.
"""


def baseline(x, i, u, direction, p, gains):
    """Rates of ``(i_ds_hat, i_qs_hat, phi_dr_hat, phi_qr_hat, omega_hat)``, equations (2)-(4). Needs no direction.

    ``p`` is ``(R_s, L_m, sigma, beta, alpha)``, ``gains`` is ``(l_1, l_2, l_3, l_4, h)``.
    """
    i_ds_hat, i_qs_hat, phi_dr_hat, phi_qr_hat, omega_hat = x
    i_ds, i_qs = i
    u_ds, u_qs = u
    R_s, L_m, sigma, beta, alpha = p
    l_1, l_2, l_3, l_4, h = gains
    gamma = R_s / sigma + alpha * beta * L_m
    i_ds_tilde = i_ds - i_ds_hat
    i_qs_tilde = i_qs - i_qs_hat
    return (
        -gamma * i_ds_hat + beta * (alpha * phi_dr_hat + omega_hat * phi_qr_hat) + u_ds / sigma
        + l_1 * i_ds_tilde - l_2 * i_qs_tilde,
        -gamma * i_qs_hat + beta * (alpha * phi_qr_hat - omega_hat * phi_dr_hat) + u_qs / sigma
        + l_2 * i_ds_tilde + l_1 * i_qs_tilde,
        -alpha * phi_dr_hat - omega_hat * phi_qr_hat + alpha * L_m * i_ds_hat + l_3 * i_ds_tilde - l_4 * i_qs_tilde,
        -alpha * phi_qr_hat + omega_hat * phi_dr_hat + alpha * L_m * i_qs_hat + l_4 * i_ds_tilde + l_3 * i_qs_tilde,
        h * beta * (i_ds_tilde * phi_qr_hat - i_qs_tilde * phi_dr_hat),
    )
