"""The repaired observer: the sign moves out of the speed law (11) into the z loop, which no longer uses omega_hat.

Same state as `adaptive`; ``gains`` is ``(k_1, kappa, k_3, g, K_p, alpha_l, delta)`` with kappa in 1/s. With kappa = 0 no
knowledge of the direction of rotation is needed.
"""

from imo_analysis.equations.adaptive import adaptive
from imo_analysis.equations.feedback import feedback_consistent_12


def repaired(x, i, u, direction, p, gains):
    """Rates of the repaired observer: z_tilde' = kappa s (i_qs_tilde, -i_ds_tilde), no sign in the speed law."""
    return adaptive(x, i, u, p, gains, feedback_consistent_12(i[0] - x[0], i[1] - x[1], gains[1], direction), 1)
