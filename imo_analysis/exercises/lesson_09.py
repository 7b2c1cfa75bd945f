"""Exercises of lesson 9: the sign in (11), the strength c, where a wrong direction is harmless, a repair with its proof."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import Any

from imo_analysis.derivation_tools import TurningFlux, follow
from imo_analysis.equations import adaptive, lyapunov, repaired
from imo_analysis.equations.feedback import feedback_consistent_12, feedback_printed_7
from imo_analysis.exercises.exercise import Choice, Exercise, Formula, Judged, Number
from imo_analysis.exercises.lesson_01 import FLUX, MACHINE
from imo_analysis.exercises.lesson_06 import stiffness
from imo_analysis.ledger.claims.situations import BOUND, ERRORS, with_function
from imo_analysis.ledger.expression import Name, Relation, as_expr, evaluate, names, parse
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.question import Question
from imo_analysis.ledger.setting import Setting
from imo_analysis.ledger.settings import errors

GAINS = (300.0, 50.0, 100.0, 1.0, 100.0, 0.05, 0.01)
KAPPA, K_3 = 50.0, 100.0


def _edit(law: int, turn: int) -> Any:
    """The observer of (12) with another sign of the speed law and of the z feedback; law 0 keeps Sign(omega), negated."""
    def rates(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
        z = feedback_consistent_12(i[0] - x[0], i[1] - x[1], turn * gains[1], x[7])
        return adaptive.adaptive(x, i, u, p, gains, z, law or -direction)

    return rates


@cache
def _working() -> frozenset[str]:
    """The edits with which the speed error stays below its first value in both directions, along runs."""
    found = set()
    for key, rates in (("a", _edit(1, 1)), ("b", _edit(1, -1)), ("c", _edit(0, 1))):
        good = True
        for direction in (1, -1):
            plant = TurningFlux(MACHINE, 100.0 * direction, 105.0 * direction, FLUX)
            _, i, z, _ = plant.at(0.0)
            start = (i.real, i.imag, *(0.98 * v for v in (z.real, z.imag, z.real, z.imag)), MACHINE.alpha, 90.0 * direction)
            path = follow(rates, start, plant, GAINS, direction, 0.03, 1e-4)
            good = good and abs(path[-1][1][7] - plant.omega) < 10.0
        if good:
            found.add(key)
    return frozenset(found)


def _limit() -> float:
    """The speed at which c vanishes with the wrong direction: c is linear in the speed, so two values of it tell."""
    tree = stiffness("repaired")
    values = dict.fromkeys(errors("repaired").free(Relation("=", tree, tree)), Fraction(1))
    values |= {"alpha": Fraction(MACHINE.alpha), "k_3": Fraction(K_3), "kappa": Fraction(KAPPA), "direction": Fraction(-1)}
    at_rest, at_one = (evaluate(tree, {**values, "omega": Fraction(omega)}) for omega in (0, 1))
    return float(at_rest / (at_rest - at_one))


def _proof(answer: Any) -> str:
    if not callable(answer):
        return "A function of (i_ds_tilde, i_qs_tilde, kappa, direction) is asked for."
    tilde = (Name("i_ds") - Name("i_ds_hat"), Name("i_qs") - Name("i_qs_hat"))
    given = answer(*tilde, *names("kappa direction"))
    if not isinstance(given, (tuple, list)) or len(given) != 2:
        return "The function must return two values: what is added to the rates of z_1_hat and z_2_hat."
    base = errors("repaired")
    without_feedback = (Name("k_1"), 0, *names("k_3 g K_p alpha_l delta"))
    state = names("i_ds_hat i_qs_hat z_1_hat z_2_hat xi_1_hat xi_2_hat alpha_hat omega_hat")
    bare = repaired.repaired(state, names("i_ds i_qs"), names("u_ds u_qs"), Name("direction"),
                             names("R_s L_m sigma beta alpha"), without_feedback)
    where: Setting = base.extended("own_repair", definitions={
        "z_1_hat_dot": as_expr(bare[2]) + as_expr(given[0]), "z_2_hat_dot": as_expr(bare[3]) + as_expr(given[1])})
    where = where.extended("own_repair", definitions=with_function(lyapunov.with_direction, ERRORS),
                           hypotheses=("kappa != 0", "k_3 != 0", "g != 0", "K_p != 0"))
    claim = Relation("=", Name("V_dot"), parse(BOUND))
    if kernel("flint").answer([Question("own", where, claim, "identity")])[0]:
        return ""
    from imo_analysis.ledger.kernels.flint_kernel import FlintKernel

    rest = next(text for text in FlintKernel().residual(where, claim) if text != "0")
    return f"V' has a term too many; in a direction in which it fails, V' minus the bound = {rest}"


EXERCISES: tuple[Exercise, ...] = (
    Choice(
        "9.1", _working,
        {"a": "",
         "b": "omega_hat in the feedback changes its sign by itself; reversed, p_z is negative in both directions.",
         "c": "Then the law is wrong forwards, where it was right."},
        "One sign less, and the mirror image works."),
    Formula(
        "9.2", lambda: stiffness("repaired"), lambda: errors("repaired"),
        (("alpha*k_3 - kappa*direction*omega", "-j times -j is -1, and the minus in front of c makes it +."),
         ("alpha*k_3 + kappa*omega**2", "That would be a gain kappa omega; here only the direction is in it."),
         ("alpha*k_3 + kappa*direction", "w has z_tilde with the factor omega."),
         ("k_3 + kappa*direction*omega", "w has xi_tilde with the factor alpha."),
         ("alpha*k_3 + kappa*omega", "The direction is in the feedback, so it is in c.")),
        "With the right direction this is alpha k_3 + kappa |omega|.",
        "Differentiate w with alpha and omega constant, and keep s as direction."),
    Number(
        "9.3", _limit, "rad/s",
        ((lambda _: K_3 / KAPPA, "alpha is missing."),
         (lambda w: w**0.5, "No root here: the gain has no omega_hat, so c is linear in omega."),
         (lambda w: w / MACHINE.n_p, "That is the speed of the shaft."),
         (lambda _: KAPPA / (MACHINE.alpha * K_3), "Upside down.")),
        "The dangerous region, where one may take the direction wrong, is covered.", "Set c to zero with s omega = -|omega|."),
    Judged(
        "9.4", _proof,
        ((lambda d, q, kappa, s: (kappa * s * q, -kappa * s * d), "a term too many"),
         (lambda d, q, kappa, s: (-kappa * q, kappa * d), "a term too many"),
         (lambda d, q, kappa, s: feedback_printed_7(d, q, kappa, s), "a term too many"),
         (lambda d, q, kappa, s: -kappa * q, "must return two values"),
         ("-kappa*i_qs_tilde", "A function of")),
        "Proved, in both directions, exactly."),
)
