"""The machine on its shaft: the plant (1) in the stationary frame with load torque and viscous friction."""

from imo_analysis.equations.plant import plant


def machine_rates(x, u, T_l, p, friction):
    """Rates of the state ``x`` = ``(i_ds, i_qs, phi_dr, phi_qr, omega)``, ``p`` as in `plant.plant`.

    The shaft carries ``T_l + B omega_m``; ``friction`` is B / n_p, so that it multiplies the electrical speed.
    """
    return plant(x, u, 0.0, T_l + friction * x[4], p)


def direction_of(omega):
    """The direction of rotation that an observer is told: +1 from standstill on, -1 below.

    Rounding must not choose between the two at standstill, so that a millionth of a rad/s still counts as standstill.
    """
    return 1.0 if omega >= -1e-6 else -1.0
