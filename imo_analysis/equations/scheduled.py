"""The baseline (2)-(4) with the gain of Kubota, Matsuse and Nakano (IEEE Trans. Ind. Appl. 29(2), 1993), by omega_hat.

The gain puts the poles of the observer at k times those of the machine, whatever the speed. Theirs multiplies i_hat - i, with
a_r11 = -gamma, a_r22 = -alpha, a_i22 = omega_hat, a_r21 = alpha L_m and c = 1/beta: g_1 = (k-1)(a_r11 + a_r22),
g_2 = (k-1) a_i22, g_3 = (k^2-1)(c a_r11 + a_r21) - c (k-1)(a_r11 + a_r22), g_4 = -c (k-1) a_i22. Here it multiplies
i - i_hat, so that each l is minus that g; the ledger derives it anew (`imo derive scheduled`).
"""

from imo_analysis.equations.baseline import baseline


def proportional_gain(k, omega_hat, p):
    """``(l_1, l_2, l_3, l_4)`` that puts the poles at ``k`` times the machine's; ``p`` is ``(R_s, L_m, sigma, beta,
    alpha)``."""
    R_s, L_m, sigma, beta, alpha = p
    gamma = R_s / sigma + alpha * beta * L_m
    l_1 = (k - 1) * (gamma + alpha)
    l_2 = (1 - k) * omega_hat
    return l_1, l_2, ((k * k - 1) * R_s / sigma - l_1) / beta, -l_2 / beta


def baseline_scheduled(x, i, u, direction, p, gains):
    """Rates of `baseline`, its gain following omega_hat. ``gains`` is ``(k, h)``; k = 1 is no feedback at all."""
    k, h = gains
    return baseline(x, i, u, direction, p, (*proportional_gain(k, x[4], p), h))
