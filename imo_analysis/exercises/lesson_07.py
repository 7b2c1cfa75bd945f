"""Exercises of lesson 7: the ratio of the regressors, the speed error beside it, the rank of (19), a modulation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from imo_analysis.equations import drift, excitation, steady_state
from imo_analysis.exercises.exercise import Exercise, Formula, Judged, Number
from imo_analysis.exercises.lesson_01 import FLUX, MACHINE
from imo_analysis.ledger.expression import Expr, as_expr, names
from imo_analysis.ledger.setting import Setting, setting

SLIP = 5.0  # rad/s
DEPTH, FREQUENCY, APART = 0.15, 60.0, 0.5


def _ratio() -> Expr:
    psi, slip, alpha, beta = names("psi slip alpha beta")
    v_1, v_2 = steady_state.regressors_of_flux(psi, 0, slip, alpha, beta)
    return as_expr(v_1[1] / v_2[1])


def _where() -> Setting:
    return setting("ratio", "constant flux", {}, ("alpha != 0",))


def _speed_error() -> float:
    return -float(drift.rest(6.6, (0.0, 0.0), 0.0, SLIP, MACHINE.alpha)[0])


def _rank() -> float:
    generator = np.random.default_rng(7)
    stack: list[Any] = []
    for _ in range(40):
        i, i_hat, z_hat, xi_hat = generator.normal(size=(4, 2))
        stack += list(excitation.corrected_19(i, i_hat, z_hat, xi_hat, 10.0, 100.0, 300.0, 0.06))
    return float(np.linalg.matrix_rank(np.array(stack)))


def _modulation(answer: Any) -> str:
    if not isinstance(answer, Mapping) or set(answer) != {"depth", "frequency"}:
        return "A dictionary with depth and frequency is asked for."
    depth, frequency = float(answer["depth"]), float(answer["frequency"])
    if not (0 <= depth <= DEPTH and 0 <= frequency <= FREQUENCY):
        return f"The depth must be 0 .. {DEPTH}, the frequency 0 .. {FREQUENCY:g} rad/s."
    gram = steady_state.gram_constant_slip(FLUX, depth, frequency, SLIP, MACHINE.alpha, MACHINE.beta)
    reached = steady_state.determinant(gram) / (gram[0] * gram[2])
    if reached >= APART:
        return ""
    if depth * frequency == 0:
        return "With constant flux v_1 and v_2 lie on one line."
    return f"sin^2 is {reached:.2f}: compare depth times frequency with the slip."


EXERCISES: tuple[Exercise, ...] = (
    Formula(
        "7.1", _ratio, _where,
        (("alpha/slip", "Upside down: c multiplies v_2."),
         ("slip", "The unit: v_1 and v_2 are both in A, so c has none."),
         ("beta*slip/alpha", "beta stands in both and cancels.")),
        "Without load v_1 vanishes: no rotor current, no news of its resistance.", "Divide the q components."),
    Number(
        "7.2", _speed_error, "rad/s",
        ((lambda e: -e, "The sign: the current sees the sum omega_tilde + c alpha_tilde, and that is zero."),
         (lambda _: -MACHINE.alpha / SLIP * (MACHINE.alpha - 6.6), "c is slip over alpha, not alpha over slip."),
         (lambda _: -SLIP / 6.6 * (MACHINE.alpha - 6.6), "c has the true alpha: it says how the flux really lies."),
         (lambda e: e / MACHINE.n_p, "Slip and omega are both electrical: no pole pairs."),
         (lambda _: -(MACHINE.alpha - 6.6), "Weigh the error of alpha with c.")),
        "Too little rotor resistance believed, too little slip subtracted, speed too high.",
        "Set omega_tilde + c alpha_tilde to zero."),
    Number(
        "7.3", _rank, "1",
        ((lambda _: 6.0, "The first four columns are constant and have two rows: they span a plane, not four dimensions."),
         (lambda _: 2.0, "That is the rank at one instant; v_1 and v_2 move from one to the next."),
         (lambda _: 5.0, "One dark direction would be real; these are complex, and come in twos.")),
        "Two directions stay dark whatever the signals do, so (19) never holds.",
        "Count the constant plane, then the arrows that move.",
        tolerance=0.001),
    Judged(
        "7.4", _modulation,
        (({"depth": 0.0, "frequency": 50.0}, "on one line"), ({"depth": 0.15, "frequency": 10.0},
          "compare depth times frequency"),
         ({"depth": 0.5, "frequency": 50.0}, "The depth must be"), ({"depth": 0.1}, "A dictionary with")),
        "The alpha error can now be told from the speed error."),
)
