"""The baseline (2)-(4) that adapts the stator resistance as well, along the current, as is usual for this observer.

What the observer believes of R_s is moved by the current error along its current. ``R_s_shift`` is what it adds to the R_s
that it was given; so it starts where the baseline does, at zero, and an error of the given R_s acts on both alike.

``baseline_turned`` turns that law round where, by its own estimates, the machine generates, and rests it where no power crosses
the air gap (ours; `imo_analysis.ledger.claims.resistance` says why). What it takes for the power is that across the air gap
times |phi|^2, with the power in units of L_m / L_r, so that neither L_r nor a division by the flux is needed: in Wb^3 A/s.
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


def power_across(x, p):
    """Power across the air gap times |phi|^2 in Wb^3 A/s, by an observer's currents, fluxes and speed ``x``: sign and zero."""
    _, L_m, _, _, alpha = p
    torque = x[2] * x[1] - x[3] * x[0]
    return torque * (x[4] * (x[2] * x[2] + x[3] * x[3]) + alpha * L_m * torque)


def power_of_slip(stator_frequency, slip, alpha, L_m, flux):
    """`power_across` of a machine at rest, in Wb^3 A/s, from stator frequency and slip in rad/s and the flux in Wb."""
    return stator_frequency * slip * flux**4 / (alpha * L_m)


def baseline_turned(x, i, u, direction, p, gains):
    """Rates of `baseline_resistance` with h_s P / (|P| + P_0) for h_s; ``gains`` are those of it and P_0, in Wb^3 A/s."""
    power = power_across(x, p)
    h_s = gains[5] * power / (abs(power) + gains[6])
    return baseline_resistance(x, i, u, direction, p, (*gains[:5], h_s))
