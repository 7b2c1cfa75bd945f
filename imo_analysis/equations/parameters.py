"""The derived parameters of Table I: sigma, alpha, beta, gamma, mu."""


def leakage(L_s, L_m, L_r):
    """sigma = (L_s L_r - L_m^2) / L_r in H (Table I)."""
    return (L_s * L_r - L_m * L_m) / L_r


def rotor_rate(R_r, L_r):
    """alpha = R_r / L_r in 1/s (Table I)."""
    return R_r / L_r


def coupling(L_m, sigma, L_r):
    """beta = L_m / (sigma L_r) in 1/H (Table I)."""
    return L_m / (sigma * L_r)


def current_decay(R_s, L_m, sigma, alpha, beta):
    """gamma = R_s / sigma + alpha beta L_m in 1/s (Table I)."""
    return R_s / sigma + alpha * beta * L_m


def torque_gain(n_p, L_m, L_r, J):
    """mu = 3 n_p^2 L_m / (2 J L_r) in 1/(kg m^2).

    Table I prints 3 L_m / (2 L_r): without the inertia the units of (1) do not agree, and without the pole pairs omega
    cannot be both the electrical speed of the flux equations and the speed of the shaft.
    """
    return 3 * n_p * n_p * L_m / (2 * J * L_r)
