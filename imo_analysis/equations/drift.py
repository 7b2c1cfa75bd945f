"""Where alpha_hat comes to rest: the balance that the adaptation laws (9) and (11) keep, and the drift of a speed change.

At constant flux magnitude v_1 = (slip/alpha) v_2, so both laws are driven by the same signal, and alpha_hat can only move along
with omega_hat: d alpha_hat = (g / K_p) (slip / alpha) d omega_hat, up to terms in xi_tilde and z_tilde that `balance` counts.
"""


def balance(alpha_hat, omega_hat, xi_tilde, z_tilde, slip, alpha, gains):
    """What constant flux and constant slip conserve in the repaired observer, in A^2 s.

    ``gains`` is ``(g, K_p, k_3, kappa_s)`` with kappa_s = kappa times the direction. Without slip the terms of omega_hat and
    z_tilde drop out, and the balance holds for the paper's observer too.
    """
    g, K_p, k_3, kappa_s = gains
    xi_square = xi_tilde[0] * xi_tilde[0] + xi_tilde[1] * xi_tilde[1]
    z_square = z_tilde[0] * z_tilde[0] + z_tilde[1] * z_tilde[1]
    return alpha_hat / g - xi_square / (2 * k_3) - slip / alpha * (omega_hat / K_p - z_square / (2 * kappa_s))


def drift_rate(slip, alpha, g, K_p):
    """d alpha_hat / d omega_hat at constant flux, in 1/s per rad/s."""
    return g * slip / (K_p * alpha)


def drift_of_acceleration(square_integral, load_term, psi, L_m, mu, g, K_p):
    """alpha_hat's drift over a speed change at constant flux psi, in 1/s: always upwards without load.

    ``square_integral`` is the integral of omega'^2 in rad^2/s^3, ``load_term`` that of (n_p T_l / J) omega'.
    """
    return g / K_p * L_m / (mu * psi * psi) * (square_integral + load_term)


def square_integral_of_step(step, bandwidth, limit):
    """Integral of omega'^2 over a first-order step response of a bandwidth whose acceleration is limited, step > 0.

    ``limit`` is the acceleration reached: the smaller of the drive's limit and bandwidth times step.
    """
    return limit * (step - limit / bandwidth) + limit * limit / (2 * bandwidth)


def forgetting_ratio(n, strength, decay, memory):
    """Ratio of the n-th term to the one before in the series of what a build-up of the flux leaves of an error of alpha_hat.

    At standstill, for psi' = w psi exp(-w t), with ``strength`` = g (beta psi/alpha)^2, ``decay`` = (k_1 + R_s/sigma) / w and
    ``memory`` = alpha k_3 / w^2. `adjoint_term` is what the series solves.
    """
    odd = 2 * n - 1
    return -strength * odd / (2 * n * (odd * odd + decay * odd + memory))


def adjoint_term(n, term, w, v_0):
    """``(p_i, p_w, p_a)``: how much of errors of i, of w = alpha xi and of alpha along the flux the n-th term counts at time 0.

    p_i i_tilde + p_w w + p_a alpha_tilde is constant along the errors, and at the end it is alpha_tilde. In time p_i and p_w go
    as exp(w t) x^n and p_a as x^n, with x = exp(-2 w t); ``v_0`` is -v_1 along the flux at time 0, beta psi w/alpha.
    """
    return -2 * n * w * term / v_0, -2 * n * term / ((2 * n - 1) * v_0), term


def rest(alpha_hat, z_tilde, omega, slip, alpha):
    """``(omega_hat, xi_tilde)`` of the rest state with this alpha_hat and z_tilde, at constant flux, speed and slip.

    omega_tilde = -(slip/alpha) alpha_tilde and alpha_hat xi_tilde = j omega_hat z_tilde: a family of three dimensions.
    """
    omega_hat = omega + slip / alpha * (alpha - alpha_hat)
    return omega_hat, (-omega_hat * z_tilde[1] / alpha_hat, omega_hat * z_tilde[0] / alpha_hat)
