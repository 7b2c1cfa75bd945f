"""When alpha and omega cannot be told apart, and an adaptation that rests then: what of its proof remains.

These statements are ours.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from imo_analysis.equations import across, excitation, plant, supervised, transformation
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.noise import BOUND, across_errors, free_share, instead, rates_without_layer
from imo_analysis.ledger.expression import Name, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS, FULL, GAINS, MACHINE, VOLTAGES

ITEM = "Supervisor (ours)"
_MEANS, _S = names("m_1d m_1q m_2d m_2q"), Name("S")
_UNITS = {
    "opening": "1", "driven": "A^2", "a": "1/s", "b": "rad/s", "turning": "rad/s",
    **dict.fromkeys(("r_d", "r_q", "v_2d", "v_2q", "d_1d", "d_1q", "d_2d", "d_2q"), "A"),
    **dict.fromkeys(("w_1", "w_2", "seen_d", "seen_q"), "A 1/s"),
}


def _free_gate(S: Any, S_0: Any) -> Any:
    return Name("opening")


@cache
def supervised_errors() -> Setting:
    """`across_errors` with the gated alpha law: ``opening``, left free, is the gate, (r_d, r_q) what the alpha law sees."""
    base = across_errors()
    gains = (GAINS[0], Name("kappa"), *GAINS[2:], *names("eta S_0"))
    with instead(across, share=free_share), instead(supervised, share=free_share, gate=_free_gate):
        row = rates_without_layer(across, supervised.supervised, (*FULL, *_MEANS, _S), gains)
    v_1, v_2 = across.directions(FULL, Name("L_m"), Name("beta"))
    r = (v_1[0] - Name("c") * v_2[0], v_1[1] - Name("c") * v_2[1])
    defined: dict[str, Any] = {
        **base.definitions, **row, "r_d": r[0], "r_q": r[1],
        "v_2d": v_2[0], "v_2q": v_2[1],
        "driven": r[0] * Name("i_ds_tilde") + r[1] * Name("i_qs_tilde"),
    }
    text = "the machine (6) and the observer whose alpha law is across v_2 and gated, omega and alpha constant"
    return setting("supervised_errors", text, defined, base.hypotheses, base.cases,
                   {**base.units, **_UNITS})


@cache
def window() -> Setting:
    """The filters of the supervisor on their own, with free v_1 and v_2 = m_2 + d_2."""
    d_1, d_2 = names("d_1d d_1q"), names("d_2d d_2q")
    v_1 = (_MEANS[0] + d_1[0], _MEANS[1] + d_1[1])
    v_2 = (_MEANS[2] + d_2[0], _MEANS[3] + d_2[1])
    rates = supervised.running_gram(v_1, v_2, _MEANS, _S, Name("eta"))
    share = across.share(d_1, d_2)
    defined: dict[str, Any] = {
        **dict(zip(("m_1d_dot", "m_1q_dot", "m_2d_dot", "m_2q_dot", "S_dot"), rates, strict=True)),
        "r_d": d_1[0] - share * d_2[0], "r_q": d_1[1] - share * d_2[1], "opening": supervised.gate(_S, Name("S_0")),
    }
    return setting("supervisor_window", "the filters of the supervisor", defined, ("eta > 0", "S >= 0", "S_0 > 0"),
                   units=_UNITS)


@cache
def any_flux() -> Setting:
    """The machine at constant speed with converged estimates; (a, b) the errors of alpha and omega, w any constant.

    ``seen`` is what these errors do to the current rows: a v_1 + b v_2 + w.
    """
    flux, speed = names("phi_dr phi_qr"), Name("omega")
    beta, L_m = names("beta L_m")
    rates = plant.plant((*CURRENTS, *flux, speed), VOLTAGES, 0, Name("T_l"), (*MACHINE, *names("mu n_p J")))
    z = transformation.to_z(CURRENTS[0], CURRENTS[1], flux[0], flux[1], beta)
    v_1 = excitation.alpha_direction(CURRENTS, z, beta, L_m)
    v_2 = excitation.speed_direction(CURRENTS, z)
    a, b = names("a b")
    defined: dict[str, Any] = {
        "phi_dr_dot": rates[2], "phi_qr_dot": rates[3], "turning": speed - b * Name("alpha") / a,
        "seen_d": a * v_1[0] + b * v_2[0] + Name("w_1"), "seen_q": a * v_1[1] + b * v_2[1] + Name("w_2"),
    }
    return setting("any_flux", "the machine (1) at constant speed, estimates converged but for alpha and omega", defined,
                   ("alpha > 0", "L_m > 0", "sigma > 0", "beta > 0", "J > 0", "a != 0"), units=_UNITS)


@cache
def moments() -> Setting:
    """The filter S of the supervisor and powers of it, for any r across v_2, on an axis of its own."""
    S, r = names("S r")
    rate = supervised.running_gram((r, 0), names("m_2d m_2q"), (0, 0, *names("m_2d m_2q")), S, Name("eta"))[4]
    defined: dict[str, Any] = {
        "square": r * r, "S_dot": rate, "fourth_dot": 4 * S**3 * rate, "eighth_dot": 8 * S**7 * rate,
        "opening": supervised.gate(S, Name("S_0")),
    }
    return setting("supervisor_moments", "the filter S of the supervisor", defined, ("eta > 0", "S >= 0", "S_0 > 0"),
                   units={**_UNITS, "r": "A", "square": "A^2", "fourth_dot": "A^8/s", "eighth_dot": "A^16/s"})


_LEFT = " + (omega_tilde + c*alpha_tilde)*alpha_tilde*c_dot/K_p + (1 - opening)*alpha_tilde*driven"

CLAIMS = [
    Claim(
        id="excitation.circle", item=ITEM,
        title="at constant speed omega and alpha part, unless the flux runs evenly round a circle",
        expected=Verdict.HOLDS, setting=any_flux(),
        prose="Errors a of alpha and b of omega are unseen next to a constant w exactly while a v_1 + b v_2 + w = 0. With a "
              "!= 0 that is phi' = j (omega - b alpha / a) phi + alpha w / (a beta), whose solutions run evenly round a "
              "circle of any centre, or along a straight line. With a = 0 it is phi = w / (j b beta): a flux that stands.",
        printed=("seen_d = -a*beta/alpha*(phi_dr_dot + turning*phi_qr - alpha*w_1/(a*beta))",
                 "seen_q = -a*beta/alpha*(phi_qr_dot - turning*phi_dr - alpha*w_2/(a*beta))"),
    ),
    Claim(
        id="supervisor.decay", item=ITEM, title="what gating the alpha law leaves of the proof",
        expected=Verdict.HOLDS, setting=supervised_errors(),
        prose="Whatever the gate does, with the V of `across`: V' = -(k_1 + R_s/sigma + alpha (1 + beta L_m)) |i_tilde|^2 + "
              "(omega_tilde + c alpha_tilde) alpha_tilde c'/K_p + (1 - gate) alpha_tilde (r . i_tilde), r the part of v_1 "
              "across v_2. Open, it is the proof of `across`. Closed, alpha_hat stands still and V falls wherever r = 0, as "
              "at constant flux with xi_hat and z_hat right; where r moves and the gate is not open yet, V need not fall, "
              "and its growth is that last term.",
        printed=(f"V_dot = {BOUND}{_LEFT}",),
        checks=(
            Algebra("evidence", "the law itself", ("alpha_hat_dot = opening*g*driven", "omega_hat_dot + c*alpha_hat_dot = "
                    "K_p*(i_ds_tilde*v_2d + i_qs_tilde*v_2q)")),
        ),
    ),
    Claim(
        id="supervisor.threshold", item=ITEM, title="what bounds the gate, and the means of the powers of S",
        expected=Verdict.HOLDS, setting=moments(),
        prose="The gate is at most (S/S_0)^4, and the means of S^4 and S^8 at most those of r^8 and r^16. For r normal with "
              "variance s^2 the mean of the gate is then at most 105 (s^2/S_0)^4, and that of its square at most 15!! "
              "(s^2/S_0)^8.",
        printed=("opening*S_0**4 <= S**4",), squares=(("1/(S**4 + S_0**4)", "S**4"),),
        checks=(
            Algebra("evidence", "the mean of S^4", ("fourth_dot <= eta*(square**4 - S**4)",),
                    squares=(("eta", "(square - S)*(square + S)"), ("2*eta", "(square - S)*S"))),
            Algebra("evidence", "the mean of S^8", ("eighth_dot <= eta*(square**8 - S**8)",),
                    squares=(("eta", "(square - S)*(square**3 + square**2*S)"),
                             ("2*eta", "(square - S)*(square**2*S + square*S**2)"),
                             ("3*eta", "(square - S)*(square*S**2 + S**3)"), ("4*eta", "(square - S)*S**3"))),
        ),
        assumptions=("mean rates are zero where S is stationary", "the even moments of a normal r: 7!! s^8, 15!! s^16"),
    ),
    Claim(
        id="supervisor.window", item=ITEM, title="the supervisor's gate lies between 0 and 1, and opens for nothing but r",
        expected=Verdict.HOLDS, setting=window(),
        prose="S is a running mean square, so it never falls below zero; the gate is S^4 / (S^4 + S_0^4).",
        printed=("S_dot = eta*(r_d**2 + r_q**2 - S)", "opening*(S**4 + S_0**4) = S**4"),
        checks=(
            Algebra("evidence", "the gate is at least 0", ("opening >= 0",), squares=(("1/(S**4 + S_0**4)", "S**2"),)),
            Algebra("evidence", "and at most 1", ("opening <= 1",), squares=(("1/(S**4 + S_0**4)", "S_0**2"),)),
            Algebra("evidence", "a constant beside v_1 does not count: means and regressor move together",
                    ("m_1d_dot = eta*d_1d", "m_1q_dot = eta*d_1q", "m_2d_dot = eta*d_2d", "m_2q_dot = eta*d_2q")),
        ),
    ),
]
