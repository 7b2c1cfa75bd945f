"""The two-level inverter between the drive's voltage and the machine's: DC link, modulation, dead time.

Carrier modulation with the zero sequence that centres the pulses (space-vector modulation). A carrier period starts and
ends with all phases low, each phase is high from ``on`` to ``off`` in between, and the currents are sampled at its start.
During the dead time the current chooses the diode: a current out of the inverter delays the rising edge, a current into it
the falling edge, so that each pulse is short or long by the dead time (the sign is that of the sample). A phase that never
switches has no dead time. Voltage is referred to the machine's star point, amplitude-invariant.

``bridge`` is ``(dc_link, period, dead_time, carriers)``: V, s, s, carrier periods in a sample.
"""

HALF_SQRT_3 = 0.8660254037844386


def phases(v):
    """Three phase values of a vector ``v`` without zero sequence."""
    return v[0], -0.5 * v[0] + HALF_SQRT_3 * v[1], -0.5 * v[0] - HALF_SQRT_3 * v[1]


def vector(a, b, c):
    """The vector of three phase values ``a``, ``b``, ``c``; their zero sequence drops out."""
    return (2.0 * a - b - c) / 3.0, (b - c) / (2.0 * HALF_SQRT_3)


def reachable(u, bridge):
    """The voltage shortened to the hexagon that the DC link spans, its direction kept."""
    a, b, c = phases(u)
    span = max(a, max(b, c)) - min(a, min(b, c))
    scale = min(1.0, bridge[0] / max(span, 1e-9))
    return scale * u[0], scale * u[1]


def pulse(duty, i, bridge):
    """When a phase goes high and low within a carrier period, for its ``duty`` (0 to 1) and the current ``i`` out of it."""
    _, period, dead, _ = bridge
    on, off = 0.5 * period * (1.0 - duty), 0.5 * period * (1.0 + duty)
    late = dead if 0.0 < duty < 1.0 else 0.0
    on = on + (late if i > 0.0 else 0.0)
    off = off + (late if i < 0.0 else 0.0)
    # a pulse shorter than the dead time does not come; the diode takes over no later than the period ends
    return min(on, off), min(off, period)


def pulses(u, i, bridge):
    """``((on_a, on_b, on_c), (off_a, off_b, off_c))`` in s for a voltage within reach."""
    v, i = phases(u), phases(i)
    middle = 0.5 * (max(v[0], max(v[1], v[2])) + min(v[0], min(v[1], v[2])))
    on_a, off_a = pulse(min(max(0.5 + (v[0] - middle) / bridge[0], 0.0), 1.0), i[0], bridge)
    on_b, off_b = pulse(min(max(0.5 + (v[1] - middle) / bridge[0], 0.0), 1.0), i[1], bridge)
    on_c, off_c = pulse(min(max(0.5 + (v[2] - middle) / bridge[0], 0.0), 1.0), i[2], bridge)
    return (on_a, on_b, on_c), (off_a, off_b, off_c)


def mean_voltage(on, off, bridge):
    """The mean over a carrier period."""
    volts = bridge[0] / bridge[1]
    return vector(volts * (off[0] - on[0]), volts * (off[1] - on[1]), volts * (off[2] - on[2]))


def bridge_voltage(t, on, off, bridge):
    """The voltage at the time ``t`` of a carrier period."""
    return vector(
        bridge[0] if on[0] <= t < off[0] else 0.0,
        bridge[0] if on[1] <= t < off[1] else 0.0,
        bridge[0] if on[2] <= t < off[2] else 0.0,
    )


def edges(on, off, bridge):
    """The six switching times in order, between 0 and the end of the carrier period."""
    a, b, c = ordered(on[0], on[1], on[2])
    d, e, f = ordered(off[0], off[1], off[2])
    # merge of two ordered triples
    a, d = min(a, d), max(a, d)
    c, f = min(c, f), max(c, f)
    b, e = min(b, e), max(b, e)
    c, d = min(c, d), max(c, d)
    b, c = min(b, c), max(b, c)
    d, e = min(d, e), max(d, e)
    return 0.0, a, b, c, d, e, f, bridge[1]


def ordered(a, b, c):
    """Three numbers ``a``, ``b``, ``c`` in order."""
    low, high = min(a, b), max(a, b)
    return min(low, c), max(low, min(high, c)), max(high, c)
