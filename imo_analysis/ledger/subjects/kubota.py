"""The adaptive full-order observer of Kubota and Matsuse, (2)-(4): its error dynamics, the usual Lyapunov argument, and the
term that breaks it.

Tilde is true minus estimate. The definitions are those of `equations.plant` and `equations.baseline`. The usual argument
takes V = (|i_tilde|^2 + c |phi_tilde|^2)/2 + omega_tilde^2/(2 h), chooses the speed law so that the speed error leaves the
current rows, and forgets that it also drives the flux rows. References: Kubota, Matsuse, Nakano, IEEE Trans. Ind. Appl.
29(2), 1993; Kubota, Matsuse, IEEE Trans. Ind. Appl. 30(5), 1994.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from imo_analysis.equations import baseline, plant
from imo_analysis.ledger.audit import error_setting, with_lyapunov
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.expression import number, parse, parse_relation
from imo_analysis.ledger.setting import Setting


def machine(i_ds: Any, i_qs: Any, phi_dr: Any, phi_qr: Any, omega: Any, u_ds: Any, u_qs: Any,
            R_s: Any, L_m: Any, sigma: Any, beta: Any, alpha: Any) -> dict[str, Any]:
    """Currents and fluxes of (1) in the stationary frame; the speed is taken as constant."""
    p = (R_s, L_m, sigma, beta, alpha, 0, 1, Fraction(1))
    rates = plant.plant((i_ds, i_qs, phi_dr, phi_qr, omega), (u_ds, u_qs), 0, 0, p)
    return dict(zip(("i_ds", "i_qs", "phi_dr", "phi_qr"), rates[:4], strict=True))


def observer(i_ds_hat: Any, i_qs_hat: Any, phi_dr_hat: Any, phi_qr_hat: Any, omega_hat: Any, i_ds: Any, i_qs: Any,
             u_ds: Any, u_qs: Any, R_s: Any, L_m: Any, sigma: Any, beta: Any, alpha: Any,
             l_1: Any, l_2: Any, l_3: Any, l_4: Any, h: Any) -> dict[str, Any]:
    """(2)-(4) with the gain that commutes with rotations."""
    rates = baseline.baseline((i_ds_hat, i_qs_hat, phi_dr_hat, phi_qr_hat, omega_hat), (i_ds, i_qs), (u_ds, u_qs), 1,
                              (R_s, L_m, sigma, beta, alpha), (l_1, l_2, l_3, l_4, h))
    return dict(zip(("i_ds", "i_qs", "phi_dr", "phi_qr", "omega"), rates, strict=True))


def candidate(i_ds_tilde: Any, i_qs_tilde: Any, phi_dr_tilde: Any, phi_qr_tilde: Any, omega_tilde: Any, c: Any, h: Any) -> Any:
    """V in A^2; c in 1/H^2 weighs the flux errors."""
    return (i_ds_tilde**2 + i_qs_tilde**2) / 2 + c * (phi_dr_tilde**2 + phi_qr_tilde**2) / 2 + omega_tilde**2 / (2 * h)


GENERAL: Setting = with_lyapunov(
    error_setting("kubota", "the machine (1), stationary frame, omega constant, and the observer (2)-(4)", machine, observer,
                  ("sigma > 0", "beta > 0", "R_s > 0", "alpha > 0", "L_m > 0", "h > 0", "c > 0"), units={"c": "1/H^2"}),
    candidate)

# the gain for which all cross terms of currents and fluxes leave V', so that nothing but the speed error is in the way
MATCHED: Setting = GENERAL.extended(
    "kubota_matched", "the same with l_3 = alpha L_m + alpha beta / c and l_4 = beta omega / c",
    {"l_3": parse("alpha*L_m + alpha*beta/c"), "l_4": parse("beta*omega/c")}, hypotheses=("l_1 > 0",))
FAMILY: Setting = MATCHED.extended(
    "kubota_family", "that gain, no current error, and a flux error of e times the estimated flux (flux_d, flux_q), across it",
    {"i_ds_tilde": number(0), "i_qs_tilde": number(0), "phi_dr_tilde": parse("-e*flux_q"), "phi_qr_tilde": parse("e*flux_d"),
     "phi_dr": parse("flux_d + phi_dr_tilde"), "phi_qr": parse("flux_q + phi_qr_tilde")})

# V' > 0: parameters and gains 1, no current error, estimated flux (1, 0), flux error (0, 1), speed error 2
_GROWS = {**dict.fromkeys(MATCHED.free(parse_relation("V_dot <= 0")), 0),
          **dict.fromkeys(("R_s", "L_m", "sigma", "beta", "alpha", "h", "c", "l_1", "phi_dr", "phi_qr", "phi_qr_tilde"), 1),
          "omega_tilde": 2}
_CURRENTS = "-(R_s/sigma + alpha*beta*L_m + l_1)*(i_ds_tilde**2 + i_qs_tilde**2)"
_FLUXES = "c*alpha*(phi_dr_tilde**2 + phi_qr_tilde**2)"
_BREAKS = "c*omega_tilde*(phi_dr_hat*phi_qr_tilde - phi_qr_hat*phi_dr_tilde)"
_ROWS = {
    "i_ds": "i_ds_tilde_dot = -(R_s/sigma + alpha*beta*L_m + l_1)*i_ds_tilde + l_2*i_qs_tilde"
            " + beta*(alpha*phi_dr_tilde + omega*phi_qr_tilde) + beta*omega_tilde*phi_qr_hat",
    "i_qs": "i_qs_tilde_dot = -(R_s/sigma + alpha*beta*L_m + l_1)*i_qs_tilde - l_2*i_ds_tilde"
            " + beta*(alpha*phi_qr_tilde - omega*phi_dr_tilde) - beta*omega_tilde*phi_dr_hat",
    "phi_dr": "phi_dr_tilde_dot = -alpha*phi_dr_tilde - omega*phi_qr_tilde + (alpha*L_m - l_3)*i_ds_tilde + l_4*i_qs_tilde"
              " - omega_tilde*phi_qr_hat",
    "phi_qr": "phi_qr_tilde_dot = -alpha*phi_qr_tilde + omega*phi_dr_tilde + (alpha*L_m - l_3)*i_qs_tilde - l_4*i_ds_tilde"
              " + omega_tilde*phi_dr_hat",
    "omega": "omega_tilde_dot = -h*beta*(i_ds_tilde*phi_qr_hat - i_qs_tilde*phi_dr_hat)",
}
_WORDS = ("A gain that makes the observer stable at known speed is not enough: the speed error enters the flux rows with the"
          " estimated flux, and no measured signal cancels it.")

CLAIMS: list[Claim] = [
    *(Claim(f"kubota.error.{name}", "(2)-(4)", f"rate of the error of {name}", Verdict.HOLDS, GENERAL, printed=row)
      for name, row in _ROWS.items()),
    Claim("kubota.current-rows", "the usual argument", "the speed law cancels the speed error in the current rows",
          Verdict.HOLDS, GENERAL,
          printed="beta*omega_tilde*(i_ds_tilde*phi_qr_hat - i_qs_tilde*phi_dr_hat) + omega_tilde*omega_tilde_dot/h = 0",
          prose="This is how the law (4) is chosen."),
    Claim("kubota.derivative", "the usual argument", "what is left of V'", Verdict.CORRECTED, MATCHED,
          prose="With a gain that makes the linear part negative, V' is said to be negative for every speed error.",
          printed=f"V_dot = {_CURRENTS} - {_FLUXES}", corrected=f"V_dot = {_CURRENTS} - {_FLUXES} + {_BREAKS}",
          edit="add c omega_tilde (phi_hat x phi_tilde), the speed error in the flux rows", origin="paper",
          why="the derivation drops the flux rows of the speed error, as if the flux errors were zero",
          consequences=("kubota.negative", "kubota.flux-known", "kubota.bound"), note=_WORDS),
    Claim("kubota.negative", "the usual argument", "V' <= 0", Verdict.FAILS, MATCHED, printed="V_dot <= 0", point=_GROWS,
          note="The breaking term is of first order in the flux error and the damping of second, so that V grows near every"
               " state with a speed error and a flux: the candidate fails for every gain, not for this one only.",
          checks=(Algebra("evidence", "a family of such states: V' > 0 wherever 0 < alpha e < omega_tilde",
                          ("V_dot = c*e*(omega_tilde - alpha*e)*(flux_d**2 + flux_q**2)",), setting=FAMILY),)),
    Claim("kubota.flux-known", "the usual argument", "with the flux known, the argument is right", Verdict.HOLDS,
          GENERAL.extended("kubota_flux_known", "the same without flux errors",
                           {}, cases=({"phi_dr_tilde": 0, "phi_qr_tilde": 0},)),
          printed=f"V_dot = {_CURRENTS}", assumptions=("phi_hat = phi at all times, which is what is to be shown",)),
    Claim("kubota.needs-flux-error", "the usual argument", "a law that would cancel the term needs the flux error",
          Verdict.HOLDS, MATCHED, printed=f"V_dot - {_BREAKS} = {_CURRENTS} - {_FLUXES}",
          prose="Adding h c (phi_hat x phi_tilde) to (4) would make V' negative; phi_tilde is not measured.", mutate=False),
    Claim("kubota.bound", "ours", "what can be said: V' is bounded by the speed error", Verdict.HOLDS, MATCHED,
          printed=f"V_dot <= {_CURRENTS} + c*omega_tilde**2/(4*alpha)*(phi_dr_hat**2 + phi_qr_hat**2)",
          squares=(("c*alpha", "phi_qr_tilde - omega_tilde*phi_dr_hat/(2*alpha)"),
                   ("c*alpha", "phi_dr_tilde + omega_tilde*phi_qr_hat/(2*alpha)")),
          note="Completing the square in the flux errors: they stay within a ball whose size grows with the speed error."),
]
