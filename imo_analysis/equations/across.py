"""The quiet observer with alpha_hat adapted only by what omega_hat cannot explain, so that it stops when excitation is lost.

v_1 is split into c v_2 and a rest across v_2. With xi_hat and z_hat right the rest is -(beta/alpha) psi' along the flux: it is
zero while the flux magnitude is constant, whatever the slip does, so that neither speed steps nor load move alpha_hat then.
omega_hat takes over c alpha_hat', so that omega_hat + c alpha_hat moves by the speed law alone.

State and gains as `repaired`.
"""

from imo_analysis.equations.excitation import alpha_direction, speed_direction
from imo_analysis.equations.projection import projection
from imo_analysis.equations.quiet import quiet

FLOOR = 1  # A^2, added to |v_2|^2 so that no flux makes no division by zero


def directions(x, L_m, beta):
    """``(v_1, v_2)`` of the estimates: how the errors of alpha and of omega act on the currents, in A."""
    i_hat = (x[0], x[1])
    return alpha_direction(i_hat, (x[4], x[5]), beta, L_m), speed_direction(i_hat, (x[2], x[3]))


def share(v_1, v_2):
    """c, the share of v_2 in v_1."""
    return (v_1[0] * v_2[0] + v_1[1] * v_2[1]) / (v_2[0] * v_2[0] + v_2[1] * v_2[1] + FLOOR)


def across(x, i, u, direction, p, gains):
    """Rates of the quiet observer with the alpha law across v_2."""
    rates = quiet(x, i, u, direction, p, gains)
    _, L_m, _, beta, _ = p
    _, _, _, g, _, alpha_l, delta = gains
    v_1, v_2 = directions(x, L_m, beta)
    c = share(v_1, v_2)
    signal = (v_1[0] - c * v_2[0]) * (i[0] - x[0]) + (v_1[1] - c * v_2[1]) * (i[1] - x[1])
    alpha_rate = projection(g * signal, x[6], alpha_l, delta)
    return (*rates[:6], alpha_rate, rates[7] - c * alpha_rate)
