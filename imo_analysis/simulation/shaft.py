"""What turns with the machine: Coulomb friction, and a load on an elastic shaft (two masses).

Speeds are electrical, the twist is a mechanical angle. ``shaft`` is ``(stiffness, damping, load_inertia, n_p)`` in N m, N m s,
kg m^2; ``coulomb`` is ``(level, knee)`` in N m and electrical rad/s.
"""

from math import sqrt

# Of the machine with an elastic shaft, after its own five.
SHAFT_STATES = ("omega_load", "twist")


def coulomb_torque(omega, coulomb):
    """Dry friction, smoothed: ``level`` against the motion, falling to zero within a few ``knee`` of standstill."""
    return coulomb[0] * omega / sqrt(omega * omega + coulomb[1] * coulomb[1])


def shaft_torque(omega, omega_load, twist, shaft):
    """Torque in N m that the shaft takes from the motor and gives to the load, which turns at ``omega_load``."""
    stiffness, damping, _, n_p = shaft
    return stiffness * twist + damping * (omega - omega_load) / n_p


def shaft_rates(omega, omega_load, twist, T_l, shaft):
    """Rates of `SHAFT_STATES`; the load torque acts on the far mass, at ``omega_load``."""
    _, _, load_inertia, n_p = shaft
    return n_p * (shaft_torque(omega, omega_load, twist, shaft) - T_l) / load_inertia, (omega - omega_load) / n_p
