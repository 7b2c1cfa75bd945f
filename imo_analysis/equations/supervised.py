"""The observer `across` with a supervisor: alpha_hat adapts while a running Gram matrix shows excitation, and rests otherwise.

Five filters of rate eta run beside the observer, a window of length 1/eta over the regressor [I, v_1, v_2] of the reduced
condition. The means of v_1 and v_2 take out what I explains, the unknown constant offsets of xi_hat and z_hat among it. What
then remains of v_1 across v_2 is squared and averaged: S, the Gram entry that only an error of alpha can fill, as the law of
`across` sees it. The gate S^4 / (S^4 + S_0^4) scales that law.

``x`` is the state of `across`, then m_1d, m_1q, m_2d, m_2q, S. ``gains`` are those of `across`, then eta and S_0.
"""

from imo_analysis.equations.across import across, directions, share


def gate(S, S_0):
    """How far the alpha law is open, from 0 to 1: a half where the excitation is S_0."""
    return S**4 / (S**4 + S_0**4)


def running_gram(v_1, v_2, means, S, eta):
    """Rates of the filters: of the means of v_1 and v_2, and of S."""
    d_1 = (v_1[0] - means[0], v_1[1] - means[1])
    d_2 = (v_2[0] - means[2], v_2[1] - means[3])
    c = share(d_1, d_2)
    r = (d_1[0] - c * d_2[0], d_1[1] - c * d_2[1])
    return eta * d_1[0], eta * d_1[1], eta * d_2[0], eta * d_2[1], eta * (r[0] * r[0] + r[1] * r[1] - S)


def supervised(x, i, u, direction, p, gains):
    """Rates of the observer `across` with its alpha law gated, and of the filters."""
    rates = across(x[:8], i, u, direction, p, gains[:7])
    v_1, v_2 = directions(x, p[1], p[3])
    open_rate = gate(x[12], gains[8]) * rates[6]
    return (
        *rates[:6],
        open_rate,
        rates[7] + share(v_1, v_2) * (rates[6] - open_rate),
        *running_gram(v_1, v_2, x[8:12], x[12], gains[7]),
    )
