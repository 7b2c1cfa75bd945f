"""The repaired observer with the estimated current in place of the measured one wherever alpha_hat meets it.

In (8) and (9) alpha_hat multiplies the measured current, which carries the same noise as the current error: the mean of that
product drives alpha_hat down at 2 g (1 + beta L_m) times the variance of the noise, without end. With i_hat there the square
of the noise drops out, the proof of the repaired observer stands, and alpha (1 + beta L_m) is added to its damping. What
noise is left reaches alpha_hat through the estimates only.

State and gains as `repaired`.
"""

from imo_analysis.equations.adaptive import alpha_signal
from imo_analysis.equations.projection import projection
from imo_analysis.equations.repaired import repaired


def quiet(x, i, u, direction, p, gains):
    """Rates of the repaired observer with (1 + beta L_m) i_hat in the current rows and in (9)."""
    rates = repaired(x, i, u, direction, p, gains)
    _, L_m, _, beta, _ = p
    _, _, _, g, _, alpha_l, delta = gains
    alpha_hat = x[6]
    i_tilde = (i[0] - x[0], i[1] - x[1])
    damping = alpha_hat * (1 + beta * L_m)
    signal = alpha_signal(i_tilde, (x[0], x[1]), (x[4], x[5]), beta, L_m)
    return (
        rates[0] + damping * i_tilde[0],
        rates[1] + damping * i_tilde[1],
        rates[2],
        rates[3],
        rates[4],
        rates[5],
        projection(g * signal, alpha_hat, alpha_l, delta),
        rates[7],
    )
