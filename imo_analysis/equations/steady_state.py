"""Closed forms of the regressors v_1, v_2 and of their mean Gram matrix for a rotor flux of given magnitude and speed.

The rotor rows of (1) give the current that a flux needs, so that with converged estimates both regressors follow from the
flux alone: v_2 = -j beta phi and v_1 = (beta / alpha) (j omega phi - phi'), for any motion. The modulated flux is
psi = psi_0 (1 + depth cos(frequency t)) at constant omega; means are over whole periods, in A^2.
"""


def current_of_flux(psi, psi_dot, slip, alpha, L_m):
    """``(i_d, i_q)`` along and across a rotor flux of magnitude psi that slips by ``slip`` past the rotor."""
    return (psi_dot / alpha + psi) / L_m, slip * psi / (alpha * L_m)


def regressors_of_flux(psi, psi_dot, slip, alpha, beta):
    """``(v_1, v_2)`` along and across the rotor flux: v_1 = -(beta/alpha) (psi' + j slip psi), v_2 = -j beta psi."""
    return (-beta * psi_dot / alpha, -beta * slip * psi / alpha), (0, -beta * psi)


def gram_constant_slip(psi, depth, frequency, slip, alpha, beta):
    """Means ``(v_1.v_1, v_1.v_2, v_2.v_2)`` while the flux is modulated at constant slip (the torque then ripples)."""
    flux = beta * beta * psi * psi * (1 + depth * depth / 2)
    swing = beta * beta * psi * psi * depth * depth * frequency * frequency / (2 * alpha * alpha)
    return slip * slip / (alpha * alpha) * flux + swing, slip / alpha * flux, flux


def gram_constant_torque(psi, depth, root, frequency, slip, alpha, beta):
    """The same means while the torque is held, so that slip psi^2 is constant and ``slip`` its value times 1 / psi_0^2.

    ``root`` is sqrt(1 - depth^2).
    """
    flux = beta * beta * psi * psi * (1 + depth * depth / 2)
    swing = beta * beta * psi * psi * depth * depth * frequency * frequency / (2 * alpha * alpha)
    inverse = slip * slip / (alpha * alpha) * beta * beta * psi * psi / (root * root * root)
    return inverse + swing, slip / alpha * beta * beta * psi * psi, flux


def determinant(gram):
    """g_11 g_22 - g_12^2 of a triple ``gram`` = ``(g_11, g_12, g_22)``."""
    return gram[0] * gram[2] - gram[1] * gram[1]


def slip_of_torque(torque, psi, n_p, L_r, alpha):
    """Slip in rad/s that a torque needs at constant flux psi: 2 alpha L_r T_e / (3 n_p psi^2)."""
    return 2 * alpha * L_r * torque / (3 * n_p * psi * psi)


def torque_at_zero_frequency(omega, psi, n_p, R_r):
    """Torque in N m at which a machine of electrical speed omega has zero stator frequency: -3 n_p psi^2 omega / (2 R_r)."""
    return -3 * n_p * psi * psi * omega / (2 * R_r)


def answer_of_line(nu, omega, alpha, damping, beta, L_m):
    """``(real, imaginary)`` part of what divides the forcing of a line at nu: j nu / H(j nu) of `excitation.bounds`, in 1/s^2.

    -nu^2 + j nu (damping + alpha (1 + beta L_m) - j omega) + (alpha - j omega) damping, with damping = R_s / sigma.
    """
    return nu * (omega - nu) + alpha * damping, nu * (damping + alpha * (1 + beta * L_m)) - omega * damping


def forcing_of_line(nu, omega, alpha, beta, L_m, sigma):
    """How errors of alpha, omega and R_s force the current along and across a flux line of 1 Wb at nu, times j nu.

    Three pairs: beta nu (nu - omega) / alpha, beta nu, and -(alpha + j (nu - omega))^2 / (sigma alpha L_m).
    """
    slip = nu - omega
    return (
        (beta * nu * slip / alpha, 0),
        (beta * nu, 0),
        ((slip * slip - alpha * alpha) / (sigma * alpha * L_m), -2 * slip / (sigma * L_m)),
    )


def speed_information(psi, beta, stator_frequency, duration, cosine):
    """What a window of constant flux and length T, ``duration`` in s, tells of omega when w is not known, in A^2 s.

    The Schur complement of the 4x4 Gram integral: beta^2 psi^2 (T - 2 (1 - cos(omega_s T)) / (omega_s^2 T)), where
    ``cosine`` is cos(omega_s T). It falls as omega_s^2 T^3 / 12 towards zero stator frequency.
    """
    mean = 2 * (1 - cosine) / (stator_frequency * stator_frequency * duration)
    return beta * beta * psi * psi * (duration - mean)
