"""Exercises of lesson 6: the stiffness D, the limit of the printed feedback, gains for a wish, the longest Euler step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from imo_analysis.exercises.exercise import Exercise, Formula, Judged, Number
from imo_analysis.exercises.lesson_01 import MACHINE
from imo_analysis.exercises.lesson_04 import rate_of
from imo_analysis.ledger.expression import Expr, Name, as_expr
from imo_analysis.ledger.setting import Setting
from imo_analysis.ledger.settings import errors
from imo_analysis.pencils.error import frozen_matrix
from imo_analysis.pencils.pole_rule import achieved

GAINS = {"k_1": 300.0, "k_2": 50.0, "k_3": 100.0}
DECAY, DAMPING, FASTEST, OMEGA = 50.0, 0.5, 1500.0, 150.0


def stiffness(observer: str) -> Expr:
    """D of w' = -D i_tilde at frozen speed, from the rates: w_1 = alpha xi_1 + omega z_2, an error of 1 A in i_ds."""
    where = errors(observer)
    known = {"alpha_tilde": 0, "omega_tilde": 0, "i_qs_tilde": 0}

    def effect(row: str) -> Any:
        return rate_of(where, row, {**known, "i_ds_tilde": 1}) - rate_of(where, row, {**known, "i_ds_tilde": 0})

    return as_expr(-(Name("alpha") * effect("xi_1_tilde_dot") + Name("omega") * effect("z_2_tilde_dot")))


def _where() -> Setting:
    """Frozen: omega_hat is omega and alpha_hat is alpha."""
    return errors("consistent_12").extended("frozen", cases=({"omega_tilde": 0, "alpha_tilde": 0},))


def _limit() -> float:
    """The speed at which the observer with L(omega_hat) loses stability, by bisection on its own pencil."""
    low, high = 0.01, 100.0
    for _ in range(60):
        middle = (low * high) ** 0.5
        largest = np.linalg.eigvals(frozen_matrix(MACHINE, "printed_L", GAINS, middle)).real.max()
        low, high = (low, middle) if largest > 1e-6 else (middle, high)
    return low


def _wish(answer: Any) -> str:
    if not isinstance(answer, Mapping) or set(answer) != set(GAINS):
        return "A dictionary with k_1, k_2 and k_3 is asked for."
    found = achieved(MACHINE, "consistent_12", {name: float(value) for name, value in answer.items()}, 0.0, OMEGA)
    text = f"Decay {found.decay:.1f} 1/s, damping {found.damping:.2f}, fastest pole {found.fastest:.0f} rad/s."
    if found.decay < DECAY * (1 - 1e-6):
        return f"{text} Too slow: near standstill k_3 alone is the spring, at speed k_1 must carry it."
    if found.damping < DAMPING * (1 - 1e-6):
        return f"{text} It swings: at high speed k_2 omega^2 is too stiff for this k_1."
    if found.fastest > FASTEST:
        return f"{text} A pole is too fast for the drive."
    return ""


def _step(pick: Any = np.argmax) -> float:
    poles = np.linalg.eigvals(frozen_matrix(MACHINE, "consistent_12", GAINS, 100.0))
    pole = sorted((one for one in poles if abs(one) > 1), key=abs)[-1 if pick is np.argmax else 0]
    return float(-2 * pole.real / abs(pole) ** 2)


def _magnitude() -> float:
    return float(np.abs(np.linalg.eigvals(frozen_matrix(MACHINE, "consistent_12", GAINS, 100.0))).max())


EXERCISES: tuple[Exercise, ...] = (
    Formula(
        "6.1", lambda: stiffness("consistent_12"), _where,
        (("alpha*k_3 - k_2*omega**2", "-j times -j is -1, and the minus in front of D makes it +."),
         ("alpha*k_3 + k_2*omega", "k_2 omega comes from the feedback, and another omega from w."),
         ("k_3 + k_2*omega**2", "The xi error enters w with the factor alpha."),
         ("alpha*k_3", "The z loop adds a term.")),
        "A spring that stiffens with speed.",
        "Differentiate w = alpha xi_tilde - j omega z_tilde with omega and alpha constant."),
    Number(
        "6.2", _limit, "rad/s",
        ((lambda w: w * w, "That is omega squared: take the root."),
         (lambda _: (GAINS["k_3"] / GAINS["k_2"]) ** 0.5, "The factor alpha is missing."),
         (lambda w: w / MACHINE.n_p, "That is the speed of the shaft; the electrical one is asked for."),
         (lambda _: (MACHINE.R_r / MACHINE.L_r * 2 / 3 * GAINS["k_3"] / GAINS["k_2"]) ** 0.5,
          "That is with R_r / L_r of Table III's resistance; the alpha of this lesson is the printed one.")),
        "A drive that stands still, in effect.", "Set alpha k_3 - k_2 omega^2 to zero."),
    Judged(
        "6.3", _wish,
        ((GAINS, "Too slow"), ({"k_1": 100.0, "k_2": 50.0, "k_3": 4000.0}, "It swings"),
         ({"k_1": 3000.0, "k_2": 1.0, "k_3": 40000.0}, "too fast for the drive"), ({"k_1": 300.0}, "A dictionary with")),
        "Met at every speed of the range, by the pencil and not by the rule."),
    Number(
        "6.4", _step, "s",
        ((lambda _: 2 / _magnitude(), "2 / |s| is right for a pole on the real axis; this one swings."),
         (lambda _: _step(np.argmin), "That is the other pair: its magnitude is smaller."),
         (lambda h: h / 2, "The 2 is lost: |1 + hs|^2 = 1 + 2 h Re s + h^2 |s|^2.")),
        "Compare it with the usual 100 us, and then with the one at 150 rad/s.",
        "Square |1 + hs| < 1 and solve for h.", tolerance=0.01),
)
