"""The machine (1) with main-flux saturation, in the Gamma form: its magnetising inductance falls with the stator flux.

The curve is 1 / L_s(psi) = (1 + (psi^2 / knee^2)^power) / L_s: L_s is the unsaturated inductance, and half of it is left at
|psi| = knee. The leakage is linear. The magnetising current is a function of the flux and along it, hence there is a field
energy, and the power balance holds exactly. With ``knee`` infinite this is (1) in the states below. The form is that of
G. R. Slemon, IEEE Trans. Ind. Appl. 25 (6), 1989.

States ``x`` are ``(psi_ds, psi_qs, phi_dr, phi_qr, omega)`` in the stationary frame: stator flux in place of stator current,
because the current follows from the fluxes in closed form and not the other way round. ``phi`` is the rotor flux of (1), which
the Gamma form sees k times as large. Parameters ``q`` are ``(R_s, R_R, L_ell, L_s, k, n_p, J, knee, power)`` with
R_R, L_ell and k of `InductionMachine.gamma_form`, ``power`` a whole number.
"""


def inverse_inductance(psi_squared, q):
    """1 / L_s(psi) in 1/H for a squared stator flux, ``psi_squared`` in Wb^2."""
    return (1 + (psi_squared / (q[7] * q[7])) ** q[8]) / q[3]


def stator_current(x, q):
    """``(i_ds, i_qs)``: the magnetising current less that of the rotor."""
    gamma = inverse_inductance(x[0] * x[0] + x[1] * x[1], q)
    _, _, L_ell, _, k, _, _, _, _ = q
    return gamma * x[0] + (x[0] - k * x[2]) / L_ell, gamma * x[1] + (x[1] - k * x[3]) / L_ell


def saturated_torque(x, i, n_p):
    """Electromagnetic torque in N m of stator flux and stator current."""
    return 3 * n_p * (x[0] * i[1] - x[1] * i[0]) / 2


def saturated_plant(x, u, T_l, q):
    """Rates of the states."""
    R_s, R_R, L_ell, _, k, n_p, J, _, _ = q
    i = stator_current(x, q)
    rate = R_R / L_ell
    return (
        u[0] - R_s * i[0],
        u[1] - R_s * i[1],
        -rate * (x[2] - x[0] / k) - x[4] * x[3],
        -rate * (x[3] - x[1] / k) + x[4] * x[2],
        n_p * (saturated_torque(x, i, n_p) - T_l) / J,
    )



def loaded(x, u, T_l, q, friction):
    """As `loaded_machine.machine_rates`, with its ``friction``."""
    return saturated_plant(x, u, T_l + friction * x[4], q)
