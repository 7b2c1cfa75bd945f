"""Closed forms of the excitation: what the flux's motion makes of the regressors of (19), and when alpha and omega part.

These statements are ours, not the paper's; they stand beside (19) because they say when its reduced form can hold. Cosine and
sine are given by a free half-angle tangent, so that identities in them are identities in rational functions.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from imo_analysis.equations import excitation, plant, steady_state, transformation
from imo_analysis.ledger.claim import Claim, Verdict
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Name, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import MACHINE, VOLTAGES, machine

ITEM = "Excitation (ours)"
_UNITS = {
    "psi": "Wb", "psi_dot": "Wb/s", "flux_rate_d": "Wb/s", "flux_rate_q": "Wb/s", "depth": "1", "frequency": "rad/s",
    "half": "1", "angle_sine": "1", "angle_cosine": "1", "root": "1", "swing_dot": "1", "swing_of_rate_dot": "1/s^2",
    "swing_of_inverse_dot": "1", "gram_determinant": "A^4", "held_determinant": "A^4",
    **{f"v_{k}_{axis}{end}": "A" for k in (1, 2) for axis in "dq" for end in ("", "_closed")},
    **{f"{letter}_{entry}": "A^2" for letter in "vg" for entry in (11, 12, 22)},
}


@cache
def flux_frame() -> Setting:
    """The machine (1) seen from its rotor flux: psi along d, nothing along q, the frame turning at omega + slip."""
    psi, psi_dot, slip, omega = names("psi psi_dot slip omega")
    alpha, beta, L_m = names("alpha beta L_m")
    current = steady_state.current_of_flux(psi, psi_dot, slip, alpha, L_m)
    rates = plant.plant((*current, psi, 0, omega), VOLTAGES, omega + slip, Name("T_l"), (*MACHINE, *names("mu n_p J")))
    z = transformation.to_z(current[0], current[1], psi, 0, beta)
    v_1 = excitation.alpha_direction(current, z, beta, L_m)
    v_2 = excitation.speed_direction(current, z)
    closed = steady_state.regressors_of_flux(psi, psi_dot, slip, alpha, beta)
    defined: dict[str, Any] = {
        "flux_rate_d": rates[2], "flux_rate_q": rates[3],
        "v_1_d": v_1[0], "v_1_q": v_1[1], "v_2_d": v_2[0], "v_2_q": v_2[1],
        "v_1_d_closed": closed[0][0], "v_1_q_closed": closed[0][1], "v_2_q_closed": closed[1][1],
    }
    return setting("flux_frame", "the machine (1) in the frame of its rotor flux, estimates converged", defined,
                   ("alpha > 0", "L_m > 0", "sigma > 0", "beta > 0", "J > 0", "psi > 0"), units=_UNITS)


def _swing(sine: Any, cosine: Any, frequency: Any, depth: Any) -> Any:
    """The part of the antiderivative of (1 + depth cosine)^2 that comes back after a period."""
    return 2 * depth * sine / frequency + depth * depth * sine * cosine / (2 * frequency)


def _swing_of_rate(sine: Any, cosine: Any, frequency: Any, depth: Any) -> Any:
    """The same for (depth frequency sine)^2."""
    return -depth * depth * frequency * sine * cosine / 2


def _swing_of_inverse(sine: Any, cosine: Any, frequency: Any, depth: Any) -> Any:
    """The same for (1 - depth^2) / (1 + depth cosine)^2 - 1 / (1 + depth cosine)."""
    return -depth * sine / (frequency * (1 + depth * cosine))


def _rate(function: Any) -> Any:
    """Rate along cosine' = -frequency sine, sine' = frequency cosine."""
    sine, cosine, frequency, depth = names("angle_sine angle_cosine frequency depth")
    values = {"sine": sine, "cosine": cosine, "frequency": frequency, "depth": depth}
    return rate_along(function, values, {"sine": frequency * cosine, "cosine": -frequency * sine})


@cache
def modulated() -> Setting:
    """A flux psi (1 + depth cos) at constant omega and slip, with its mean Gram matrix and the swings about it."""
    half, psi, depth, frequency, slip = names("half psi depth frequency slip")
    alpha, beta = names("alpha beta")
    sine, cosine = names("angle_sine angle_cosine")
    v_1, v_2 = steady_state.regressors_of_flux(psi * (1 + depth * cosine), -psi * depth * frequency * sine, slip, alpha, beta)
    gram = steady_state.gram_constant_slip(psi, depth, frequency, slip, alpha, beta)
    held = steady_state.gram_constant_torque(psi, depth, Name("root"), frequency, slip, alpha, beta)
    defined: dict[str, Any] = {
        "angle_cosine": (1 - half * half) / (1 + half * half), "angle_sine": 2 * half / (1 + half * half),
        "g_11": gram[0], "g_12": gram[1], "g_22": gram[2],
        "v_11": v_1[0] * v_1[0] + v_1[1] * v_1[1], "v_12": v_1[0] * v_2[0] + v_1[1] * v_2[1],
        "v_22": v_2[0] * v_2[0] + v_2[1] * v_2[1],
        "swing_dot": _rate(_swing), "swing_of_rate_dot": _rate(_swing_of_rate),
        "swing_of_inverse_dot": _rate(_swing_of_inverse),
        "gram_determinant": steady_state.determinant(gram),
        "held_determinant": steady_state.determinant(held),
    }
    return setting("modulated_flux", "a rotor flux whose magnitude is modulated by a cosine at constant speed", defined,
                   ("alpha > 0", "beta > 0", "psi > 0", "frequency > 0", "root > 0", "1 + depth*angle_cosine != 0",
                    "depth*angle_cosine + 1 != 0"),
                   units=_UNITS)


CLAIMS = [
    Claim(
        id="excitation.flux", item=ITEM, title="the regressors of (19) follow from the rotor flux alone",
        expected=Verdict.HOLDS, setting=flux_frame(),
        prose="With converged estimates, in the frame of the rotor flux psi that slips past the rotor: "
              "v_1 = -(beta/alpha) (psi' + j slip psi) and v_2 = -j beta psi, for any motion.",
        printed=("flux_rate_d = psi_dot", "flux_rate_q = 0", "v_1_d = v_1_d_closed", "v_1_q = v_1_q_closed",
                 "v_2_d = 0", "v_2_q = v_2_q_closed"),
    ),
    Claim(
        id="excitation.parting", item=ITEM, title="at any instant, only a moving flux magnitude parts alpha and omega",
        expected=Verdict.HOLDS, setting=flux_frame(),
        prose="v_1 - (slip/alpha) v_2 = -(beta/alpha) psi' along the flux: with constant flux magnitude the two regressors are "
              "parallel at every instant, and their cross product is beta^2 psi psi' / alpha.",
        printed=("v_1_q = slip/alpha*v_2_q", "v_1_d = -beta*psi_dot/alpha",
                 "v_1_d*v_2_q - v_1_q*v_2_d = beta**2*psi*psi_dot/alpha"),
        note="A slip that changes makes the fixed direction (1, -slip/alpha) change, so that a window over it can have full "
             "rank even at constant flux.",
    ),
    Claim(
        id="excitation.standstill", item=ITEM, title="at zero stator frequency the current knows neither alpha nor omega",
        expected=Verdict.HOLDS, setting=machine("0"),
        prose="sigma (i' + beta phi') = u - R_s i: where all rates are zero, zero stator frequency, the current is u / R_s "
              "whatever alpha and omega are.",
        printed=("sigma*z_1_dot = u_ds - R_s*i_ds", "sigma*z_2_dot = u_qs - R_s*i_qs"),
    ),
    Claim(
        id="excitation.gram_slip", item=ITEM, title="mean Gram matrix under flux modulation at constant slip",
        expected=Verdict.HOLDS, setting=modulated(),
        prose="Each product of regressors is its mean plus the rate of something periodic.",
        printed=("v_22 = g_22 + beta**2*psi**2*swing_dot", "v_12 = g_12 + slip/alpha*beta**2*psi**2*swing_dot",
                 "v_11 = g_11 + beta**2*psi**2/alpha**2*(slip**2*swing_dot + swing_of_rate_dot)"),
    ),
    Claim(
        id="excitation.gram_torque", item=ITEM, title="the means that a held torque needs",
        expected=Verdict.HOLDS, setting=modulated(),
        prose="1/(1 + depth cos)^2 is 1/(1 - depth^2) times 1/(1 + depth cos) plus a periodic rate; the mean of "
              "1/(1 + depth cos) is 1/sqrt(1 - depth^2), for that is the rate of Kepler's eccentric anomaly.",
        printed=("(1 - depth**2)/(1 + depth*angle_cosine)**2 = 1/(1 + depth*angle_cosine) + swing_of_inverse_dot",),
        assumptions=("|depth| < 1", "mean of 1/(1 + depth cos) over a period: 1/sqrt(1 - depth^2) (Kepler)"),
    ),
    Claim(
        id="excitation.determinant", item=ITEM, title="how far apart modulation drives alpha and omega",
        expected=Verdict.HOLDS, setting=modulated(),
        prose="The determinant of the mean Gram matrix of (v_1, v_2): at constant slip it is beta^4 psi^4 depth^2 Omega^2 "
              "(1 + depth^2/2) / (2 alpha^2), whatever the slip; at held torque the swing of the slip adds to it.",
        printed=("gram_determinant = beta**4*psi**4*depth**2*frequency**2*(1 + depth**2/2)/(2*alpha**2)",
                 "held_determinant = gram_determinant + beta**4*psi**4*slip**2/alpha**2*((1 + depth**2/2)/root**3 - 1)"),
        assumptions=("root = sqrt(1 - depth^2)",),
    ),
]
