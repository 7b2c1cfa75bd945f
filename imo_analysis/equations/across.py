"""The quiet observer with alpha_hat adapted only by what omega_hat cannot explain, so that it stops when excitation is lost.

v_1 is split into c v_2 and a rest across v_2. With xi_hat and z_hat right the rest is -(beta/alpha) psi' along the flux: it is
zero while the flux magnitude is constant, whatever the slip does, so that neither speed steps nor load move alpha_hat then.
omega_hat takes over c alpha_hat', so that omega_hat + c alpha_hat moves by the speed law alone.

State and gains as `repaired`.
"""

from imo_analysis.equations.adaptive import alpha_signal
from imo_analysis.equations.excitation import alpha_direction, speed_direction
from imo_analysis.equations.projection import projection
from imo_analysis.equations.quiet import quiet

FLOOR = 1  # A^2, added to |v_2|^2 so that no flux makes no division by zero


def across(x, i, u, direction, p, gains):
    """Rates of the quiet observer with the alpha law across v_2."""
    rates = quiet(x, i, u, direction, p, gains)
    _, L_m, _, beta, _ = p
    _, _, _, g, _, alpha_l, delta = gains
    i_hat = (x[0], x[1])
    i_tilde = (i[0] - x[0], i[1] - x[1])
    v_1 = alpha_direction(i_hat, (x[4], x[5]), beta, L_m)
    v_2 = speed_direction(i_hat, (x[2], x[3]))
    c = (v_1[0] * v_2[0] + v_1[1] * v_2[1]) / (v_2[0] * v_2[0] + v_2[1] * v_2[1] + FLOOR)
    signal = alpha_signal(i_tilde, i_hat, (x[4], x[5]), beta, L_m) - c * (v_2[0] * i_tilde[0] + v_2[1] * i_tilde[1])
    alpha_rate = projection(g * signal, x[6], alpha_l, delta)
    return (*rates[:6], alpha_rate, rates[7] - c * alpha_rate)
