"""Exercises of lesson 10: the cost of a leak, a feedback matched to constant weights, its poles, its limit."""

from __future__ import annotations

import cmath
from typing import Any

from imo_analysis.equations import luenberger, plant
from imo_analysis.exercises.exercise import Exercise, Formula, Judged, Number
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Expr, Name, Relation, as_expr, names, number, parse, substitute
from imo_analysis.ledger.gauss import Gauss
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.kernels.flint_kernel import FlintKernel
from imo_analysis.ledger.question import Question
from imo_analysis.ledger.setting import Setting, setting

BOUND = "-(k_1 + R_s/sigma)*(i_ds_tilde**2 + i_qs_tilde**2)"
_STATES = ("i_ds", "i_qs", "z_1", "z_2")
_ERRORS = ("i_ds_tilde", "i_qs_tilde", "z_1_tilde", "z_2_tilde", "omega_tilde")


def matched(i_ds_tilde: Any, i_qs_tilde: Any, kappa: Any, alpha: Any, omega: Any) -> tuple[Any, Any]:
    """F i_tilde with F = kappa (alpha + j omega), the conjugate of the path from z to i: V with the weight 1/kappa falls."""
    return kappa * (alpha * i_ds_tilde - omega * i_qs_tilde), kappa * (alpha * i_qs_tilde + omega * i_ds_tilde)


def own_errors(feedback: Any, known_speed: bool) -> Setting:
    """(6) and the observer (7) with a z feedback, the law (11) without sign, and V with the weight 1/kappa.

    ``feedback(i_ds_tilde, i_qs_tilde, kappa, alpha, omega_hat)``.
    """
    hats = names("i_ds_hat i_qs_hat z_1_hat z_2_hat omega_hat")
    i, u, machine = names("i_ds i_qs"), names("u_ds u_qs"), names("R_s L_m sigma beta alpha")
    given = feedback(i[0] - hats[0], i[1] - hats[1], Name("kappa"), Name("alpha"), hats[4])
    if not isinstance(given, (tuple, list)) or len(given) != 2:
        raise ValueError("the function must return two values: what is added to the rates of z_1_hat and z_2_hat")
    true = plant.plant_z(names(*_STATES), u, Name("omega"), 0, machine)
    rates = luenberger.luenberger(hats, i, u, machine, names("k_1 kappa K_p"), given, 1)
    defined: dict[str, Any] = {f"{name}_hat": Name(name) - Name(f"{name}_tilde") for name in (*_STATES, "omega")}
    defined |= {f"{name}_tilde_dot": as_expr(a) - as_expr(b) for name, a, b in zip(_STATES, true, rates, strict=False)}
    defined["omega_tilde_dot"] = -as_expr(rates[4])

    def energy(i_ds_tilde: Any, i_qs_tilde: Any, z_1_tilde: Any, z_2_tilde: Any, omega_tilde: Any, kappa: Any, K_p: Any) -> Any:
        return (i_ds_tilde**2 + i_qs_tilde**2) / 2 + (z_1_tilde**2 + z_2_tilde**2) / (2 * kappa) + omega_tilde**2 / (2 * K_p)

    values = {name: Name(name) for name in (*_ERRORS, "kappa", "K_p")}
    defined["V_dot"] = rate_along(energy, values, {name: Name(f"{name}_dot") for name in _ERRORS})
    cases = ({"omega_tilde": 0},) if known_speed else ({},)
    return setting("own", "the machine (6) and an own observer", defined, ("sigma != 0", "kappa != 0", "K_p != 0"), cases)


def _proof(answer: Any) -> str:
    if not callable(answer):
        return "A function of (i_ds_tilde, i_qs_tilde, kappa, alpha, omega) is asked for."
    where = own_errors(answer, True)
    claim = Relation("=", Name("V_dot"), parse(BOUND))
    if kernel("flint").answer([Question("own", where, claim, "identity")])[0]:
        return ""
    return f"V' has a rest: V' minus the bound = {FlintKernel().residual(where, claim)[0]}"


def _rest() -> Expr:
    """V' minus the bound with the matched feedback, the speed estimated."""
    return Name("V_dot") - parse(BOUND)


def _stiffness() -> Expr:
    """(alpha - j omega) F from the matched feedback for an error of 1 A on the d axis; its imaginary part must vanish."""
    one = matched(number(1), number(0), *names("kappa alpha omega"))
    product = Gauss(Name("alpha"), -Name("omega")) * Gauss(*one)
    where = setting("D", "the product of the poles")
    zero = Relation("=", as_expr(product.im), number(0))
    assert kernel("flint").answer([Question("real", where, zero, "identity")])[0]
    return substitute(as_expr(product.re), {})


EXERCISES: tuple[Exercise, ...] = (
    Number(
        "10.1", lambda: cmath.phase(30j / (30j + 10)), "rad",
        ((lambda a: a * 180 / cmath.pi, "That is in degrees; the answer is asked for in rad."),
         (lambda _: cmath.phase(30j + 10), "That is the angle of the denominator alone."),
         (lambda _: 10 / 30, "The tangent of the angle, not the angle: this is too large for the small-angle rule."),
         (lambda _: abs(30j / (30j + 10)), "That is the ratio of the magnitudes.")),
        "Nearly twenty degrees: the field is not where the drive thinks.",
        "Divide the leaky answer by the true one.", tolerance=0.005),
    Judged(
        "10.2", _proof,
        ((lambda d, q, kappa, alpha, omega: (kappa * (alpha * d + omega * q), kappa * (alpha * q - omega * d)),
          "V' has a rest"),
         (lambda d, q, kappa, alpha, omega: (kappa * alpha * d, kappa * alpha * q), "V' has a rest"),
         (lambda d, q, kappa, alpha, omega: (-kappa * (alpha * d - omega * q), -kappa * (alpha * q + omega * d)),
          "V' has a rest"),
         (lambda d, q, kappa, alpha, omega: kappa * d, "must return two values"),
         ("kappa*(alpha + j*omega)", "A function of")),
        "Feed back along the transpose of how you see."),
    Formula(
        "10.3", _stiffness, lambda: setting("D", "the product of the poles"),
        (("kappa*(alpha**2 - omega**2)", "(alpha - j omega)(alpha + j omega): minus j squared is plus."),
         ("kappa*(alpha + omega)**2", "A number times its conjugate has no mixed term."),
         ("kappa*omega**2", "The path through alpha is there too, and at standstill it is all there is."),
         ("alpha**2 + omega**2", "F has the factor kappa.")),
        "Positive at every speed: the path from z to i never vanishes.", "Multiply (alpha - j omega) with F."),
    Formula(
        "10.4", _rest, lambda: own_errors(matched, False),
        (("omega_tilde*(i_ds_tilde*z_1_tilde + i_qs_tilde*z_2_tilde)",
          "There is a j between: it is the cross product, not the dot product."),
         ("kappa*omega_tilde*(i_ds_tilde*z_2_tilde - i_qs_tilde*z_1_tilde)", "kappa cancels with the weight 1/kappa."),
         ("omega_hat*(i_ds_tilde*z_2_tilde - i_qs_tilde*z_1_tilde)", "Only the difference omega - omega_hat is left.")),
        "Third order, no sign, nothing measured to cancel it: a local result.",
        "Write the two cross terms, one with omega, one with omega_hat."),
)
