"""Exercises of lesson 3: the rate of z, drift by an offset, the symmetry of the three feedbacks, the product of the poles."""

from __future__ import annotations

from typing import Any

from imo_analysis.equations import feedback, plant
from imo_analysis.exercises.exercise import Choice, Exercise, Formula, Number, equal
from imo_analysis.exercises.lesson_01 import MACHINE
from imo_analysis.ledger.expression import Expr, Name, as_expr, names
from imo_analysis.ledger.gauss import Gauss
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import machine

RULES = {"printed_7": feedback.feedback_printed_7, "printed_L": feedback.feedback_printed_L,
         "consistent_12": feedback.feedback_consistent_12}


def _drift() -> float:
    """z_tilde' of (6) minus the same row with 20 mA more current, u and z alike."""
    p = MACHINE.observer_parameters
    true = plant.plant_z((0.0, 0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0, p)
    return true[2] - plant.plant_z((0.02, 0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0, p)[2]


def _symmetric() -> set[str]:
    """The feedbacks that turn by 90 degrees when the current error does, decided exactly."""
    d, q, k, w = names("i_ds_tilde i_qs_tilde k_2 omega_hat")
    where = setting("turn", "a turn by 90 degrees")
    found = set()
    for name, rule in RULES.items():
        before, after = rule(d, q, k, w), rule(-q, d, k, w)
        if equal(where, as_expr(after[0]), -as_expr(before[1])) and equal(where, as_expr(after[1]), as_expr(before[0])):
            found.add(name)
    return found


def _product() -> tuple[Expr, Expr]:
    """(alpha - j omega) F; a current error of 1 A on the d axis shows F, the feedback being what is added to the estimate."""
    one: Any = feedback.feedback_consistent_12(1, 0, Name("k_2"), Name("omega"))
    value = Gauss(Name("alpha"), -Name("omega")) * Gauss(as_expr(one[0]), as_expr(one[1]))
    return as_expr(value.re), as_expr(value.im)


def _where() -> Setting:
    return setting("poles", "the Luenberger observer at frozen speed")


EXERCISES: tuple[Exercise, ...] = (
    Formula(
        "3.1", lambda: machine().definitions["z_1_dot"], machine,
        (("-R_s*i_ds + u_ds", "That is the rate of the stator flux; z is that over sigma."),
         ("-gamma*i_ds + u_ds/sigma", "gamma still holds the rotor's part, alpha beta L_m, which the flux row cancels."),
         ("R_s/sigma*i_ds + u_ds/sigma", "The resistive drop takes flux away: its sign."),
         ("-R_s/sigma*i_ds + u_ds/sigma + omega*z_2",
          "The speed terms cancel: + beta omega phi_qr against - beta omega phi_qr.")),
        "The stator's voltage law over sigma: no omega, no alpha.", "Add beta times the third row of (1) to the first."),
    Number(
        "3.2", _drift, "A/s",
        ((lambda d: -d, "That is how the estimate moves; the error is true minus estimate."),
         (lambda d: d * MACHINE.sigma, "Divide by sigma: z is the stator flux over sigma, the drop R_s i is in V."),
         (lambda d: d * MACHINE.gamma * MACHINE.sigma / MACHINE.R_s,
          "gamma is the decay of the current; in z only R_s / sigma is left."),
         (lambda d: 0.05 * d, "That has the 5 % of the R_s question; here R_s is right and the current is wrong.")),
        "In a minute this is a large error: no drive runs on a bare voltage model.", "Only the term with the current differs."),
    Choice(
        "3.3", _symmetric,
        {"printed_7": "printed_7 is (-d, q) times a factor. Turned input gives (q, d), turned output (-q, -d): it is a mirror.",
         "printed_L": "printed_L: (q, -d). Turned input gives (d, q), and the output turned by 90 degrees is (d, q) as well.",
         "consistent_12": "consistent_12: (-q, d) is itself a turn by 90 degrees, and turns commute."},
        "Symmetry alone leaves two, which differ in sign."),
    Formula(
        "3.4", _product, _where,
        ((("-k_2*omega**2", "-alpha*k_2*omega"), "The sign is that of L(omega_hat): here F = + j k_2 omega."),
         (("k_2*omega**2", "-alpha*k_2*omega"), "The real part is right. j times alpha is + j alpha."),
         (("-k_2*omega**2", "alpha*k_2*omega"), "The imaginary part is right. -j times j is + 1."),
         (("alpha*k_2*omega", "k_2*omega**2"), "Real and imaginary part are exchanged."),
         (("k_2*omega", "alpha*k_2"), "F has a factor omega, from the speed-scheduled gain.")),
        "The real part is a restoring force that goes with the speed squared.",
        "The product is the determinant, (alpha - j omega) F."),
)
