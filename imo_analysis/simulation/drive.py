"""Rotor-flux-oriented control, sampled: flux and speed loops, current loops with decoupling, limits with anti-windup.

The paper names field-oriented control and prints nothing of it; this is the textbook form (W. Leonhard, Control of Electrical
Drives, 3rd ed., ch. 12). Plain functions of scalars, compiled like the equations. The frame is carried as the unit vector
``(c, s)`` of the flux, so that no sine is needed.

``p`` are the parameters of `equations.plant`; ``d`` is ``(T, current_bandwidth, flux_bandwidth, speed_bandwidth,
voltage_limit, current_limit, flux_floor)`` in SI units, where ``flux_floor`` bounds divisions by the flux from below.
"""

from math import sqrt

from imo_analysis.equations.plant import plant

# What `control` carries from sample to sample.
CONTROL_STATES = ("integral_d", "integral_q", "integral_speed")


def flux_model(phi, flow_before, i, omega, T, p):
    """The drive's own rotor flux a sample later and its present rate: the flux rows of (1) by Adams-Bashforth of order 2.

    ``flow_before`` is the rate of a sample ago. An explicit rule, so that the flux of the next sample is known before
    its currents are measured.
    """
    flow = flux_rates(phi, i, omega, p)
    return (phi[0] + T * (1.5 * flow[0] - 0.5 * flow_before[0]), phi[1] + T * (1.5 * flow[1] - 0.5 * flow_before[1])), flow


def flux_rates(phi, i, omega, p):
    """The flux rows of (1) for given currents."""
    return plant((i[0], i[1], phi[0], phi[1], omega), (0.0, 0.0), 0.0, 0.0, p)[2:4]


def orientation(phi, flux_floor):
    """``(c, s, magnitude, inverse)`` of a flux; below ``flux_floor`` the frame turns smoothly to the stationary one."""
    magnitude = sqrt(phi[0] * phi[0] + phi[1] * phi[1])
    inverse = 1.0 / max(magnitude, flux_floor)
    return phi[0] * inverse + (1.0 - magnitude * inverse), phi[1] * inverse, magnitude, inverse


def current_references(integral_speed, omega, magnitude, inverse, omega_ref, flux_ref, p, d):
    """The flux loop and the speed loop: ``(i_d_ref, i_q_ref, excess)``.

    ``integral_speed`` is the third of `CONTROL_STATES`, ``magnitude`` and ``inverse`` are those of `orientation`, ``omega_ref``
    and ``flux_ref`` as in `control`. ``excess`` is the acceleration that the current limit leaves of the one asked for, less
    that one, in rad/s^2.
    """
    _, L_m, _, _, alpha, mu, _, _ = p
    _, _, w_flux, w_speed, _, i_max, _ = d
    # flux loop: with this i_d the flux follows flux_ref with the bandwidth w_flux
    wanted = (flux_ref + (w_flux / alpha - 1.0) * (flux_ref - magnitude)) / L_m
    i_d_ref = min(max(wanted, -i_max), i_max)
    # speed loop: an acceleration by PI with active damping, as q current within what i_d leaves of the limit
    acceleration = w_speed * omega_ref - 2.0 * w_speed * omega + integral_speed
    amperes = inverse / mu
    room = sqrt(i_max * i_max - i_d_ref * i_d_ref)
    i_q_ref = min(max(acceleration * amperes, -room), room)
    return i_d_ref, i_q_ref, i_q_ref / amperes - acceleration


def control(state, i, omega, phi, omega_ref, flux_ref, p, d):
    """One sample of the control.

    Parameters
    ----------
    state : tuple of 3
        As named in `CONTROL_STATES`: two voltages (V) and an acceleration (rad/s^2).
    i, phi : tuple of 2
        Measured current (A) and rotor flux (Wb), stationary frame.
    omega, omega_ref : float
        Speed and its reference, electrical rad/s.
    flux_ref : float
        Reference of the flux magnitude in Wb.

    Returns
    -------
    tuple
        ``((u_ds, u_qs), state)``: the voltage to hold, stationary frame, and the next state.
    """
    R_s, L_m, sigma, beta, alpha, _, _, _ = p
    T, w_current, _, w_speed, u_max, _, flux_floor = d
    c, s, magnitude, inverse = orientation(phi, flux_floor)
    i_d = c * i[0] + s * i[1]
    i_q = c * i[1] - s * i[0]
    i_d_ref, i_q_ref, excess = current_references(state[2], omega, magnitude, inverse, omega_ref, flux_ref, p, d)
    integral_speed = state[2] + T * w_speed * (w_speed * (omega_ref - omega) + excess)
    # current loops: PI that cancels the decay gamma, with the couplings of the flux frame fed forward
    stator_frequency = omega + alpha * L_m * i_q * inverse
    gain = w_current * sigma
    u_d = gain * (i_d_ref - i_d) + state[0] - sigma * (stator_frequency * i_q + beta * alpha * magnitude)
    u_q = gain * (i_q_ref - i_q) + state[1] + sigma * (stator_frequency * i_d + beta * omega * magnitude)
    scale = min(1.0, u_max / max(sqrt(u_d * u_d + u_q * u_q), 1e-9))
    decay = T * (R_s / sigma + alpha * beta * L_m)
    integral_d = state[0] + decay * (gain * (i_d_ref - i_d) + (scale - 1.0) * u_d)
    integral_q = state[1] + decay * (gain * (i_q_ref - i_q) + (scale - 1.0) * u_q)
    u_d = scale * u_d
    u_q = scale * u_q
    return (c * u_d - s * u_q, s * u_d + c * u_q), (integral_d, integral_q, integral_speed)
