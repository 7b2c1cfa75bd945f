"""Exercises of lesson 4: the law for one state, the weight of xi, the speed law, the term that stays."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from imo_analysis.equations import adaptive
from imo_analysis.exercises.exercise import Choice, Exercise, Formula, written_out
from imo_analysis.ledger.audit import error_setting, with_lyapunov
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Expr, Name, as_expr, names, number, substitute
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import errors


def _one_state() -> Setting:
    """The plant and observer of the first section, with the law as a name that is to be found."""
    where = error_setting("one_state", "one state", lambda x, u, a: {"x": -a * x + u},
                          lambda x, x_hat, u, a_hat, k, law: {"x": -a_hat * x + u + k * (x - x_hat), "a": law}, ("g > 0",))
    return with_lyapunov(where, lambda x_tilde, a_tilde, g: x_tilde**2 / 2 + a_tilde**2 / (2 * g))


def _law() -> Expr:
    """The law for which a_tilde leaves V': V' is affine in the law, and is solved for it at a_tilde = 1 against a_tilde = 0."""

    def rate(**values: int) -> Any:
        return rate_of(_one_state(), "V_dot", values)

    slope = rate(law=1, a_tilde=1) - rate(law=0, a_tilde=1)
    return as_expr((rate(law=0, a_tilde=0) - rate(law=0, a_tilde=1)) / slope)


def _weight() -> Expr:
    """Of the xi error: minus the effect of xi_1_tilde on i_ds_tilde' over that of i_ds_tilde on xi_1_tilde'."""
    where = errors("consistent_12")
    state = ("i_ds_tilde", "xi_1_tilde", "alpha_tilde", "omega_tilde")  # to first order: the other errors are zero

    def effect(row: str, cause: str) -> Any:
        return rate_of(where, row, {name: int(name == cause) for name in state}) - rate_of(where, row, dict.fromkeys(state, 0))

    return as_expr(-effect("i_ds_tilde_dot", "xi_1_tilde") / effect("xi_1_tilde_dot", "i_ds_tilde"))


def rate_of(where: Setting, row: str, values: dict[str, int]) -> Any:
    """A defined name in free names alone, with some of them replaced."""
    return substitute(written_out(where, Name(row)), {name: number(value) for name, value in values.items()})


def _speed_law() -> Any:
    errors_of_i, i_hat, z_hat = names("i_ds_tilde i_qs_tilde"), names("i_ds_hat i_qs_hat"), names("z_1_hat z_2_hat")
    return Name("K_p") * adaptive.speed_signal(errors_of_i, i_hat, z_hat)


def _last_term() -> str:
    """What the moving weight does to V while omega_hat falls, from the derivative of the weight alone, at one point."""
    size: Any = rate_along(lambda omega, omega_hat: omega / omega_hat, {"omega": Fraction(1), "omega_hat": Fraction(2)},
                           {"omega_hat": Fraction(-1)})
    return "b" if size > 0 else "a" if size < 0 else "c"


EXERCISES: tuple[Exercise, ...] = (
    Formula(
        "4.1", _law, _one_state,
        (("g*x*x_tilde", "The sign: the error of a moves against its estimate, a_tilde' = - a_hat'."),
         ("-x*x_tilde/g", "g is upside down: V has 1/g, so the law has g."),
         ("-g*x_hat*x_tilde", "This observer multiplies a_hat by the measured x, so x carries the error of a, not x_hat."),
         ("-x*x_tilde", "Without g the terms cancel for g = 1 only."),
         ("-g*x_tilde", "The factor x is missing: without signal there is nothing to learn from.")),
        "Error times the signal by which the parameter acts.", "Set the sum of the two terms with a_tilde to zero."),
    Formula(
        "4.2", _weight, lambda: setting("weight", "the weight of xi_tilde", {}, ("k_3 != 0", "k_2 != 0")),
        (("alpha/k_2", "That is what (13) prints, and its unit is 1/s: xi is fed back with k_3."),
         ("alpha/(2*k_3)", "The half is already in front: V has p_xi / 2."),
         ("k_3/alpha", "Upside down: alpha - p_xi k_3 = 0."),
         ("alpha*k_3", "p_xi times k_3 must equal alpha."),
         ("1/k_3", "The unit must be 1; the cross term carries alpha.")),
        "alpha is unknown, but it need not be known: a weight is used in the proof only.", "Solve alpha - p_xi k_3 = 0."),
    Formula(
        "4.3", _speed_law, lambda: errors("consistent_12"),
        (("K_p*(i_ds_tilde*(z_1_hat - i_ds_hat) + i_qs_tilde*(z_2_hat - i_qs_hat))",
          "The turn by -j is missing: this is along the flux, and the speed acts across it."),
         ("K_p*(i_ds_tilde*(z_2_hat - i_qs_hat) + i_qs_tilde*(z_1_hat - i_ds_hat))", "-j(a + jb) = b - ja: the second sign."),
         ("K_p*direction*(i_ds_tilde*(z_2_hat - i_qs_hat) - i_qs_tilde*(z_1_hat - i_ds_hat))",
          "Nothing in the derivation brings a Sign(omega); (11) has one, and for omega < 0 it makes the law diverge."),
         ("K_p*(i_ds_tilde*z_2_hat - i_qs_tilde*z_1_hat)", "z_hat alone; the flux is z_hat - i_hat."),
         ("i_ds_tilde*(z_2_hat - i_qs_hat) - i_qs_tilde*(z_1_hat - i_ds_hat)", "The gain K_p is missing.")),
        "Current error across the flux, in other letters.", "Write v_2 in components, then the dot product."),
    Choice(
        "4.4", _last_term,
        {"a": "Put numbers in: omega = 1, omega_hat = 2, omega_hat' = -1; the term is minus (1)(-1) over something positive.",
         "b": "",
         "c": "omega is constant, but the weight has omega_hat in it, and that moves."},
        "Converging from above feeds V."),
)
