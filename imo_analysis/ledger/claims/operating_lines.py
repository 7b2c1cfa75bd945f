"""Operating points: slip and torque, the line of zero stator frequency, what a window tells of the speed, and the answer of the
current to an error of a parameter, line by line of the flux. These statements are ours.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from imo_analysis.equations import parameters, plant, steady_state
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Name, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import MACHINE, VOLTAGES

ITEM = "Excitation (ours)"


@cache
def steady_torque() -> Setting:
    """The machine (1) at constant flux psi and slip: its torque as the speed row has it, J omega'/n_p + T_l."""
    psi, slip, omega, L_m, n_p, J = names("psi slip omega L_m n_p J")
    alpha = parameters.rotor_rate(*names("R_r L_r"))
    current = steady_state.current_of_flux(psi, 0, slip, alpha, L_m)
    mu = parameters.torque_gain(n_p, L_m, Name("L_r"), J)
    machine = (*names("R_s L_m sigma beta"), alpha, mu, n_p, J)
    rates = plant.plant((*current, psi, 0, omega), VOLTAGES, omega + slip, Name("T_l"), machine)
    defined: dict[str, Any] = {
        "torque": J / n_p * rates[4] + Name("T_l"), "flux_rate_d": rates[2], "flux_rate_q": rates[3],
        "slip_closed": steady_state.slip_of_torque(Name("torque"), psi, n_p, Name("L_r"), alpha),
        "line": steady_state.torque_at_zero_frequency(omega, psi, n_p, Name("R_r")),
    }
    return setting("steady_torque", "the machine (1) at constant flux magnitude and slip", defined,
                   ("psi > 0", "R_r > 0", "L_r > 0", "L_m > 0", "n_p > 0", "J > 0"),
                   units={"psi": "Wb", "torque": "N m", "line": "N m", "flux_rate_d": "Wb/s", "flux_rate_q": "Wb/s",
                          "slip_closed": "rad/s"})


@cache
def window_of_speed() -> Setting:
    """v_2 of a constant flux, and its integral over a window that ends at the angle whose half has the tangent ``half``."""
    half, psi, beta, turning, duration = names("half psi beta stator_frequency duration")
    cosine, sine = (1 - half * half) / (1 + half * half), 2 * half / (1 + half * half)
    _, v_2 = steady_state.regressors_of_flux(psi, 0, Name("slip"), Name("alpha"), beta)
    size = -v_2[1]
    angle_cosine, angle_sine = names("angle_cosine angle_sine")
    moving = {"angle_cosine": -turning * angle_sine, "angle_sine": turning * angle_cosine}

    def integral(which: int) -> Any:
        def value(angle_cosine: Any, angle_sine: Any, size: Any, turning: Any) -> Any:
            return size * angle_sine / turning if which else size * (angle_cosine - 1) / turning

        return value

    fixed = {"size": size, "turning": turning}
    values = {"angle_cosine": angle_cosine, "angle_sine": angle_sine, **fixed}
    sums = [integral(which)(cosine, sine, size, turning) for which in (0, 1)]
    defined: dict[str, Any] = {
        # v_2 = -j size exp(j angle): along d it is size sine, along q -size cosine
        "v_2d": size * angle_sine, "v_2q": -size * angle_cosine,
        "minus_sum_d_dot": rate_along(integral(0), values, moving), "minus_sum_q_dot": rate_along(integral(1), values, moving),
        "square": size * size, "sum_square": sums[0] * sums[0] + sums[1] * sums[1],
        "told": steady_state.speed_information(psi, beta, turning, duration, cosine),
    }
    return setting("window_of_speed", "a constant flux that turns at the stator frequency, seen over a window", defined,
                   ("stator_frequency != 0", "duration > 0", "beta > 0", "psi > 0"),
                   units={"half": "1", "psi": "Wb", "duration": "s", "angle_cosine": "1", "angle_sine": "1", "v_2d": "A",
                          "v_2q": "A", "minus_sum_d_dot": "A", "minus_sum_q_dot": "A", "square": "A^2", "sum_square": "A^2 s^2",
                          "told": "A^2 s"})


@cache
def line_of_flux() -> Setting:
    """The machine (1) in a frame that turns with a flux line psi at nu, and small errors of its parameters there.

    (x_d, x_q) is the current that they make, a, b and r the errors of alpha, omega and R_s; the flux that they make follows
    from the stator, and ``rotor_d``, ``rotor_q`` are the rates of the flux that are left, which must be zero.
    """
    nu, psi, omega = names("nu psi omega")
    R_s, L_m, sigma, beta, alpha = MACHINE
    i = steady_state.current_of_flux(psi, 0, nu - omega, alpha, L_m)
    x, (a, b, r) = names("x_d x_q"), names("a b r")
    damping = R_s / sigma
    y = (-(damping * x[1] + nu * x[0] + r / sigma * i[1]) / (nu * beta),
         (damping * x[0] - nu * x[1] + r / sigma * i[0]) / (nu * beta))

    def row(which: int) -> Any:
        def value(i_d: Any, i_q: Any, phi_d: Any, phi_q: Any, omega: Any, alpha: Any, R_s: Any, **rest: Any) -> Any:
            p = (R_s, rest["L_m"], rest["sigma"], rest["beta"], alpha, rest["mu"], rest["n_p"], rest["J"])
            u = (rest["u_ds"], rest["u_qs"])
            return plant.plant((i_d, i_q, phi_d, phi_q, omega), u, rest["nu"], rest["T_l"], p)[which]

        at = {"i_d": i[0], "i_q": i[1], "phi_d": psi, "phi_q": 0, "omega": omega, "alpha": alpha, "R_s": R_s, "L_m": L_m,
              "sigma": sigma, "beta": beta, "nu": nu, **{one: Name(one) for one in ("mu", "n_p", "J", "u_ds", "u_qs", "T_l")}}
        small = {"i_d": x[0], "i_q": x[1], "phi_d": y[0], "phi_q": y[1], "omega": b, "alpha": a, "R_s": r}
        return rate_along(value, at, small)

    stator = [row(k) + beta * row(k + 2) for k in (0, 1)]
    D = steady_state.answer_of_line(nu, omega, alpha, damping, beta, L_m)
    forced = steady_state.forcing_of_line(nu, omega, alpha, beta, L_m, sigma)
    F = [psi * (a * forced[0][k] + b * forced[1][k] + r * forced[2][k]) for k in (0, 1)]
    defined: dict[str, Any] = {
        "stator_d": stator[0], "stator_q": stator[1], "rotor_d": row(2), "rotor_q": row(3),
        "D_real": D[0], "D_imaginary": D[1], "F_d": F[0], "F_q": F[1],
    }
    return setting("line_of_flux", "the machine (1) on a line of its flux, with small errors of its parameters", defined,
                   ("alpha > 0", "L_m > 0", "sigma > 0", "beta > 0", "J > 0", "nu != 0"),
                   units={"nu": "rad/s", "psi": "Wb", "x_d": "A", "x_q": "A", "a": "1/s", "b": "rad/s", "r": "ohm",
                          "stator_d": "A/s", "stator_q": "A/s", "rotor_d": "Wb/s", "rotor_q": "Wb/s", "D_real": "1/s^2",
                          "D_imaginary": "1/s^2", "F_d": "A/s^2", "F_q": "A/s^2"})


CLAIMS = [
    Claim(
        id="excitation.slip", item=ITEM, title="the slip that a torque needs, and the line of zero stator frequency",
        expected=Verdict.HOLDS, setting=steady_torque(),
        prose="At constant flux the slip is 2 R_r T_e / (3 n_p psi^2). The stator frequency omega + slip is zero on the line "
              "T_e = -(3 n_p psi^2 / (2 R_r)) omega of the speed-torque plane, and only there: in the second and fourth "
              "quadrant, steeper the stronger the flux.",
        printed=("flux_rate_d = 0", "flux_rate_q = 0", "slip = slip_closed",
                 "torque - line = 3*n_p*psi**2/(2*R_r)*(omega + slip)"),
    ),
    Claim(
        id="excitation.window", item=ITEM, title="what a window of constant flux tells of the speed",
        expected=Verdict.HOLDS, setting=window_of_speed(),
        prose="The Schur complement of the Gram integral of [I, v_2] over T: the integral of |v_2|^2 less the square of that "
              "of v_2 over T. It is beta^2 psi^2 (T - 2 (1 - cos(omega_s T)) / (omega_s^2 T)).",
        printed=("minus_sum_d_dot = -v_2d", "minus_sum_q_dot = -v_2q", "told = square*duration - sum_square/duration"),
        assumptions=("the integral of v_2 from an angle of 0 is minus the sum at the last angle, for it starts at 0",),
    ),
    Claim(
        id="excitation.response", item=ITEM, title="the current's answer to errors of alpha, omega and R_s, line by line",
        expected=Verdict.HOLDS, setting=line_of_flux(),
        prose="On a line psi of the rotor flux at nu the answer is x = F / D: D the determinant of the machine at j nu, "
              "F = psi (beta nu (nu - omega)/alpha a + beta nu b - (alpha + j (nu - omega))^2/(sigma alpha L_m) r). The "
              "Cramer-Rao bounds are made of these.",
        printed=("stator_d = 0", "stator_q = 0", "-nu*beta*rotor_q = D_real*x_d - D_imaginary*x_q - F_d",
                 "nu*beta*rotor_d = D_real*x_q + D_imaginary*x_d - F_q"),
        checks=(
            Algebra("evidence", "one line tells only one combination of alpha and omega",
                    ("F_d = psi*beta*nu*((nu - omega)/alpha*a + b) + psi*r*((nu - omega)**2 - alpha**2)/(sigma*alpha*L_m)",)),
        ),
    ),
]
