"""The machine (1) in a frame that turns at omega_1, and the same machine in the coordinates (6).

Parameters ``p`` are ``(R_s, L_m, sigma, beta, alpha, mu, n_p, J)``; ``u`` is ``(u_ds, u_qs)``.
"""


def plant(x, u, omega_1, T_l, p):
    """Rates of ``(i_ds, i_qs, phi_dr, phi_qr, omega)``, equation (1).

    The speed row is the corrected one, mu (phi x i) - n_p T_l / J with omega the electrical speed (see `torque_gain`).
    """
    i_ds, i_qs, phi_dr, phi_qr, omega = x
    u_ds, u_qs = u
    R_s, L_m, sigma, beta, alpha, mu, n_p, J = p
    gamma = R_s / sigma + alpha * beta * L_m
    return (
        -gamma * i_ds + omega_1 * i_qs + beta * (alpha * phi_dr + omega * phi_qr) + u_ds / sigma,
        -gamma * i_qs - omega_1 * i_ds + beta * (alpha * phi_qr - omega * phi_dr) + u_qs / sigma,
        -alpha * phi_dr + (omega_1 - omega) * phi_qr + alpha * L_m * i_ds,
        -alpha * phi_qr - (omega_1 - omega) * phi_dr + alpha * L_m * i_qs,
        mu * (phi_dr * i_qs - phi_qr * i_ds) - n_p * T_l / J,
    )


def plant_z(x, u, omega, omega_1, p):
    """Rates of ``(i_ds, i_qs, z_1, z_2)``, equation (6), with the terms in omega_1 that the stationary frame hides."""
    i_ds, i_qs, z_1, z_2 = x
    u_ds, u_qs = u
    R_s, L_m, sigma, beta, alpha = p[:5]
    return (
        -R_s / sigma * i_ds - alpha * (1 + beta * L_m) * i_ds + (omega_1 - omega) * i_qs + alpha * z_1 + omega * z_2
        + u_ds / sigma,
        -R_s / sigma * i_qs - alpha * (1 + beta * L_m) * i_qs - (omega_1 - omega) * i_ds + alpha * z_2 - omega * z_1
        + u_qs / sigma,
        -R_s / sigma * i_ds + omega_1 * z_2 + u_ds / sigma,
        -R_s / sigma * i_qs - omega_1 * z_1 + u_qs / sigma,
    )


def torque(x, n_p, L_m, L_r):
    """Electromagnetic torque in N m of the state of (1), amplitude-invariant scaling."""
    i_ds, i_qs, phi_dr, phi_qr = x[:4]
    return 3 * n_p * L_m * (phi_dr * i_qs - phi_qr * i_ds) / (2 * L_r)
