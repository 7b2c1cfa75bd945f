"""The baseline (2)-(4) that adapts the stator resistance as well: Kubota and Matsuse, IEEE Trans. Ind. Appl. 30(5), 1994.

What the observer believes of R_s is moved by the current error along its current. ``R_s_shift`` is what it adds to the R_s
that it was given; so it starts where the baseline does, at zero, and an error of the given R_s acts on both alike.
"""

from imo_analysis.equations.baseline import baseline


def resistance_rate(x, i, h_s):
    """Rate of R_s_shift in ohm/s; ``x`` begins with the currents of the observer, ``h_s`` in ohm/(A^2 s)."""
    return -h_s * ((i[0] - x[0]) * x[0] + (i[1] - x[1]) * x[1])


def gain_of_rate(rate, sigma, decay, L_m, flux):
    """The h_s with which an error of R_s decays at ``rate`` (1/s) at the magnetising current, flux and speed being right.

    The current error, which decays at ``decay``, follows that of R_s at once: -R_s_tilde i / (sigma decay).
    """
    return rate * sigma * decay * (L_m / flux) * (L_m / flux)


def baseline_resistance(x, i, u, direction, p, gains):
    """Rates of `baseline`, run with R_s + R_s_shift, and of R_s_shift. ``gains`` are those of `baseline` and h_s."""
    R_s, L_m, sigma, beta, alpha = p
    believed = (R_s + x[5], L_m, sigma, beta, alpha)
    return (*baseline(x[:5], i, u, direction, believed, gains[:5]), resistance_rate(x, i, gains[5]))
