"""The baseline that adapts the stator resistance as well: why its law is as it is, that it cannot brake, and what turns it.

The law adapts R_s along the current, as is usual for this observer; the statements are ours. R_s_tilde is the true R_s minus
what the observer believes, the R_s that it was given and R_s_shift. Matrices are found as in
`imo_analysis.ledger.claims.scheduled`.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from imo_analysis.equations import plant, resistance
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.scheduled import adaptive_determinant
from imo_analysis.ledger.expression import Name, names, parse
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS, MACHINE, PHYSICAL, VOLTAGES

ITEM = "Adapted R_s (ours)"
_WHICH = ("i_ds", "i_qs", "phi_dr", "phi_qr", "omega")
_ERRORS = tuple(f"{one}_tilde" for one in (*_WHICH, "R_s"))
_GAINS = names("l_1 l_2 l_3 l_4 h h_s")
_UNITS = {"R_s_given": "ohm", "psi": "Wb", "at_zero": "ohm 1/s^5/H", "V": "A^2", "weight": "s/(Wb^3 A)", "power": "Wb^3 A/s"}


def _errors(name: str, text: str, sign: int) -> Setting:
    """Machine, observer and errors; ``sign`` turns the law of the resistance round."""
    hats = (*(Name(f"{one}_hat") for one in _WHICH), Name("R_s_shift"))
    given = (Name("R_s_given"), *MACHINE[1:])
    rates = resistance.baseline_resistance(hats, CURRENTS, VOLTAGES, Name("direction"), given, _GAINS)
    true = plant.plant(names(" ".join(_WHICH)), VOLTAGES, 0, Name("T_l"), (*MACHINE, *names("mu n_p J")))
    defined: dict[str, Any] = {f"{one}_hat": Name(one) - Name(f"{one}_tilde") for one in _WHICH}
    defined |= {"R_s_shift": Name("R_s") - Name("R_s_given") - Name("R_s_tilde")}
    moving = dict(zip(_WHICH, (*true[:4], 0), strict=True))
    defined |= {f"{one}_tilde_dot": moving[one] - rate for one, rate in zip(_WHICH, rates[:5], strict=True)}
    defined |= {"R_s_tilde_dot": rates[5] * -sign}
    defined |= {
        "V": parse("(i_ds_tilde**2 + i_qs_tilde**2)/2 + omega_tilde**2/(2*h) + R_s_tilde**2/(2*h_s*sigma)"),
        "V_dot": parse("i_ds_tilde*i_ds_tilde_dot + i_qs_tilde*i_qs_tilde_dot + omega_tilde*omega_tilde_dot/h"
                       " + R_s_tilde*R_s_tilde_dot/(h_s*sigma)")}
    return setting(name, text, defined, ("sigma > 0", "h > 0", "h_s > 0", "J != 0"), units=_UNITS)


@cache
def errors() -> Setting:
    """The machine (1) and the observer, omega and R_s constant, and their errors."""
    return _errors("resistance_errors", "the machine (1) and the baseline that adapts R_s, omega and R_s constant", 1)


@cache
def turned() -> Setting:
    """The same with the law of the resistance turned round."""
    return _errors("resistance_turned", "the same with the opposite sign in the law of the resistance", -1)


@cache
def loop(turned_by_power: bool = False) -> Setting:
    """Errors near zero at constant speed, slip and flux psi, in the frame of the flux, where the machine rests.

    With ``turned_by_power`` h_s is multiplied by ``weight`` times ``power``, which is what baseline_turned takes for the power
    across the air gap; its weight is 1/(abs(power) + P_0).
    """
    power = resistance.power_across((*CURRENTS, Name("psi"), 0, Name("omega")), MACHINE)
    way = Name("weight") * power if turned_by_power else 1
    steady = {"i_ds": parse("psi/L_m"), "i_qs": parse("slip*psi/(alpha*L_m)"), "omega": parse("stator_frequency - slip")}
    at_zero = adaptive_determinant(resistance.baseline_resistance, (*_GAINS[:5], _GAINS[5] * way), 0, further=(0,))
    name, more = ("resistance_by_power", ", h_s turned by the power") if turned_by_power else ("resistance_loop", "")
    return setting(name, "errors of the baseline that adapts R_s, to first order, omega, slip and flux psi constant, in the "
                   f"frame of the flux{more}", {**steady, **({"power": power} if turned_by_power else {}), "at_zero": at_zero},
                   (*PHYSICAL, "h > 0", "h_s > 0", "psi > 0"), units=_UNITS)


_DAMPING = "-(R_s/sigma + alpha*beta*L_m + l_1)*(i_ds_tilde**2 + i_qs_tilde**2)"
_FLUX = ("beta*(alpha*(i_ds_tilde*phi_dr_tilde + i_qs_tilde*phi_qr_tilde)"
         " + omega*(i_ds_tilde*phi_qr_tilde - i_qs_tilde*phi_dr_tilde))")
_LAST = "2*h*h_s*beta**2*psi**4*stator_frequency*slip/(sigma*L_m**2)"
_AGAINST = loop().extended("resistance_against", definitions={"stator_frequency": parse("-share*slip")},
                           hypotheses=("slip != 0", "share > 0"))

CLAIMS: list[Claim] = [
    Claim(
        id="resistance.right", item=ITEM, title="right estimates stay right",
        expected=Verdict.HOLDS,
        setting=errors().extended("resistance_right", cases=(dict.fromkeys(_ERRORS, 0),)),
        printed=tuple(f"{one}_dot = 0" for one in _ERRORS), mutate=False,
        prose="With the right currents, flux, speed and resistance, whatever resistance it was given, no error appears.",
    ),
    Claim(
        id="resistance.derivative", item=ITEM, title="the error of the resistance leaves the derivative of V",
        expected=Verdict.HOLDS, setting=errors(), printed=f"V_dot = {_DAMPING} + {_FLUX}",
        prose="V = |i_tilde|^2/2 + omega_tilde^2/(2 h) + R_s_tilde^2/(2 h_s sigma). Its derivative holds neither R_s_tilde nor "
              "omega_tilde: sign and scale of both laws are chosen so.",
        assumptions=("omega and R_s constant",),
        note="The last term is the flux error, of which V knows nothing: it is driven by the speed error, as in the baseline "
             "(kubota.derivative), and nothing makes the whole negative. resistance.generating shows that nothing can.",
    ),
    Claim(
        id="resistance.flux_known", item=ITEM, title="with the flux known, V does not grow",
        expected=Verdict.HOLDS,
        setting=errors().extended("resistance_flux_known", hypotheses=("R_s/sigma + alpha*beta*L_m + l_1 > 0",),
                                  cases=({"phi_dr_tilde": 0, "phi_qr_tilde": 0},)),
        printed=("V_dot <= 0",),
        squares=(("R_s/sigma + alpha*beta*L_m + l_1", "i_ds_tilde"), ("R_s/sigma + alpha*beta*L_m + l_1", "i_qs_tilde")),
        assumptions=("phi_hat = phi at all times, which is what is to be shown",),
    ),
    Claim(
        id="resistance.sign", item=ITEM, title="with the law of the other sign the error of the resistance is left twice",
        expected=Verdict.HOLDS, setting=turned(),
        printed=f"V_dot = {_DAMPING} + {_FLUX} - 2*R_s_tilde/sigma*(i_ds_tilde*i_ds_hat + i_qs_tilde*i_qs_hat)",
        note="Of either sign and without bound in R_s_tilde: V then grows for some errors, with the flux known too.",
    ),
    Claim(
        id="resistance.last", item=ITEM, title="the last coefficient of the characteristic polynomial",
        expected=Verdict.HOLDS, setting=loop(), printed=(f"at_zero = {_LAST}",),
        prose="To first order, for errors of current, flux, speed and resistance, where the machine rests. Of the gains of the "
              "baseline none but h is in it.",
        assumptions=("omega, slip and flux constant; the whole commutes with rotations, so that it may be seen from the flux",),
        note="Idle, without slip, it is zero: a pole stands at zero, since an error of the resistance then looks like one of "
             "flux and speed, and what it settles at hangs on the start. Zero stator frequency is the same for every observer.",
    ),
    Claim(
        id="resistance.generating", item=ITEM, title="generating, zero error is unstable whatever the gains are",
        expected=Verdict.HOLDS, setting=_AGAINST, printed=("at_zero <= 0",),
        squares=(("2*h*h_s*beta**2*psi**4*share/(sigma*L_m**2)", "slip"),),
        prose="Where slip and stator frequency have opposite signs, as in a machine that brakes faster than its slip, the last "
              "coefficient is negative, and a pole is real and positive.",
        assumptions=("a polynomial that is negative at zero and grows without bound has a positive zero (intermediate value)",),
        checks=(Algebra("evidence", "the last coefficient, which is not zero there",
                        ("at_zero = -2*h*h_s*beta**2*psi**4*share*slip**2/(sigma*L_m**2)",)),),
        note="The growth is that of the adaptation, and slow at speed: for the paper's machine, its gains and h_s = 0.03, with "
             "a slip of -3 rad/s, 1.86 1/s at 10 rad/s and 0.17 1/s at 150 (`imo poles --full`). The sign of stator frequency "
             "times slip is that of the power across the air gap, torque times stator frequency.",
    ),
    Claim(
        id="resistance.power", item=ITEM, title="what is taken for the power has the sign of stator frequency times slip",
        expected=Verdict.HOLDS, setting=loop(turned_by_power=True),
        printed=("power = psi**4*stator_frequency*slip/(alpha*L_m)",),
        prose="By the currents, fluxes and speed of the machine where it rests.",
    ),
    Claim(
        id="resistance.by_power", item=ITEM, title="turned round where the machine generates, the law has no such pole",
        expected=Verdict.HOLDS,
        setting=loop(turned_by_power=True).extended("resistance_weighted", hypotheses=("weight > 0",)),
        printed=("at_zero >= 0",),
        squares=(("2*h*h_s*weight*beta**2*psi**8/(sigma*alpha*L_m**3)", "stator_frequency*slip"),),
        prose="With the factor power/(abs(power) + P_0) on h_s, as in baseline_turned, or any positive one times the power, "
              "the last coefficient is never negative.",
        assumptions=("the factor is that of the machine: its own errors multiply a current error, and are of second order",),
        note="Necessary, not sufficient: poles still leave in pairs near zero stator frequency, and V proves nothing where the "
             "sign is turned. How it does on a motor shows the manual, in 'My own observer'.",
    ),
]
