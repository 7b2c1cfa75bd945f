"""What is kept of a run when only its summary is wanted: plain functions of scalars, compiled into the batch kernel.

A tally is updated once a record. It stops when its observer, or the machine, is lost: selections, no branches, so that the
same text works on sixteen lanes at once.
"""

from imo_analysis.equations.excitation import alpha_direction, speed_direction

# Rows of a tally: the machine's, every observer's, and those of an observer with z_hat and xi_hat.
MACHINE = ("lost",)
OBSERVER = ("lost", "speed_square", "speed_peak", "flux_square", "flux_peak", "outside", "speed_sum")
REGRESSOR = ("v_1d", "v_1q", "v_2d", "v_2q", "v_11", "v_12", "v_22")


def watched(lost, size, bound, number):
    """The number of the first record at which ``size`` was not below ``bound``, NaN included; -1 until then."""
    return number if (lost < 0.0) & (not size < bound) else lost


def tallied(tally, lost, omega, omega_hat, phi, phi_hat, band, number):
    """`OBSERVER` without ``lost``: sums of (squared) errors, largest errors, the last record at which the speed was off.

    ``number`` is that of the record, ``band`` the error in rad/s above which the speed is off.
    """
    speed_square, speed_peak, flux_square, flux_peak, outside, speed_sum = tally
    well = lost < 0.0
    error = omega - omega_hat
    speed = abs(error)
    flux_d = phi[0] - phi_hat[0]
    flux_q = phi[1] - phi_hat[1]
    flux = flux_d * flux_d + flux_q * flux_q
    return (
        speed_square + (speed * speed if well else 0.0),
        max(speed_peak, speed if well else 0.0),
        flux_square + (flux if well else 0.0),
        max(flux_peak, flux if well else 0.0),
        outside if speed <= band else number,
        speed_sum + (error if well else 0.0),
    )


def excited(sums, lost, i, i_hat, z_hat, xi_hat, beta, L_m):
    """`REGRESSOR`: the sums that make the Gram matrix of the reduced regressor [I, v_1, v_2]."""
    a = alpha_direction(i, xi_hat, beta, L_m)
    b = speed_direction(i_hat, z_hat)
    well = lost < 0.0
    v_1d = a[0] if well else 0.0
    v_1q = a[1] if well else 0.0
    v_2d = b[0] if well else 0.0
    v_2q = b[1] if well else 0.0
    return (
        sums[0] + v_1d, sums[1] + v_1q, sums[2] + v_2d, sums[3] + v_2q,
        sums[4] + (v_1d * v_1d + v_1q * v_1q),
        sums[5] + (v_1d * v_2d + v_1q * v_2q),
        sums[6] + (v_2d * v_2d + v_2q * v_2q),
    )
