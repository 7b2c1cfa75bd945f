"""Exercises of lesson 5: the slip in (12), a certificate, a counterexample to (16), verdicts."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from imo_analysis.exercises.exercise import Exercise, Formula, Judged
from imo_analysis.ledger.claims.situations import BOUND, BREAKS_16, ERRORS, lyapunov_13
from imo_analysis.ledger.expression import Expr, Name, Relation, evaluate, parse, parse_relation
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.question import Question, Square
from imo_analysis.ledger.setting import setting
from imo_analysis.ledger.settings import errors
from imo_analysis.paper.contents import row

FORM = parse_relation("k_1*i_ds_tilde**2 + 2*w_1*i_ds_tilde + 2*w_1**2/k_1 >= 0")
WHERE = setting("form", "a quadratic form", {}, ("k_1 > 0",), units={"w_1": "A/s"})
MAY_CHANGE = (*ERRORS, "i_ds", "i_qs", "z_1", "z_2")
JUDGED = ("eq6.z_1", "eq12.i_qs", "eq16.bound")
VERDICTS = ("holds", "holds after correction", "fails", "not determined by the text")


def _slip() -> Expr:
    """Printed minus derived, the q row of (12)."""
    return parse_relation(row("eq12.i_qs").text).right - Name("i_qs_tilde_dot")


def _certificate(answer: Any) -> str:
    squares = []
    for pair in answer:
        if len(pair) != 2:
            return "Each entry is a pair: weight and base."
        squares.append(Square(parse(str(pair[0])), parse(str(pair[1]))))
    if kernel("flint").answer([Question("form", WHERE, FORM, "squares", squares=squares)])[0]:
        return ""
    total = sum((one.weight * one.base * one.base for one in squares), parse("0"))
    if kernel("flint").answer([Question("sum", WHERE, Relation("=", FORM.left, total), "identity")])[0]:
        return "The sum is right, but a weight is not seen to be positive for k_1 > 0."
    return f"Expanded, the sum is not the left side; left side minus sum = {kernel_residual(FORM.left, total)}"


def kernel_residual(left: Expr, right: Expr) -> str:
    """The difference of two formulas as text, in lowest terms."""
    from imo_analysis.ledger.kernels.flint_kernel import FlintKernel

    return FlintKernel().residual(WHERE, Relation("=", left, right))[0]


def _counterexample(answer: Any) -> str:
    base = {**BREAKS_16, **dict.fromkeys(MAY_CHANGE, 0)}
    strangers = sorted(set(answer) - set(MAY_CHANGE))
    if strangers:
        return f"{', '.join(strangers)} may not change; only errors and signals: {', '.join(MAY_CHANGE)}."
    point = {name: Fraction(value) for name, value in {**base, **answer}.items()}
    where = lyapunov_13()
    values = where.values(point)
    if point["omega"] * values["omega_hat"] <= 0:
        return "omega_hat = omega - omega_tilde must be positive like omega: otherwise V is not, and nothing is refuted."
    rate, bound = values["V_dot"], evaluate(parse(BOUND), values)
    if rate > bound:
        return ""
    said = f"Here V' = {rate} and the bound is {bound}: (16) is true at this state."
    if point["z_1_tilde"] == point["z_2_tilde"] == 0:
        return f"{said} The term to use has |z_tilde|^2 as a factor."
    return f"{said} omega_hat' = {values['omega_hat_dot']} is not negative."  # else that term alone breaks the bound


def _verdicts(answer: Any) -> str:
    if not isinstance(answer, Mapping) or set(answer) != set(JUDGED):
        return f"A dictionary with the keys {', '.join(JUDGED)} is asked for."
    if strangers := [verdict for verdict in answer.values() if verdict not in VERDICTS]:
        return f"{strangers[0]!r} is no verdict; choose from: {', '.join(VERDICTS)}."
    from imo_analysis.ledger.book import claims, entries

    found = {one.claim.id: str(one.verdict) for one in entries(("flint",), [one for one in claims() if one.id in JUDGED])}
    for name in JUDGED:
        if answer[name] != found[name]:
            return _VERDICT_HINTS[name]
    return ""


_VERDICT_HINTS = {
    "eq6.z_1": "eq6.z_1: compare your result of exercise 3.1 with the row of (6).",
    "eq12.i_qs": "eq12.i_qs: two signs are wrong, and with them put right the row is true.",
    "eq16.bound": "eq16.bound: your counterexample of exercise 5.3 stands against every edit that keeps its form.",
}
_GOOD = {"eq6.z_1": "holds", "eq12.i_qs": "holds after correction"}

EXERCISES: tuple[Exercise, ...] = (
    Formula(
        "5.1", _slip, errors,
        (("-(omega_tilde*i_ds_hat + omega*i_ds_tilde)", "Minus for plus is a difference of twice the term."),
         ("-2*omega_tilde*i_ds_hat", "That is one of the two slips; there is another in the same row."),
         ("-2*omega*i_ds_tilde", "That is one of the two slips; there is another in the same row."),
         ("-2*(omega_tilde*i_ds + omega*i_ds_tilde)",
          "The speed error multiplies the estimated current: this has one product too many.")),
        "Twice the two terms.", "Subtract the corrected row from the printed one; most terms cancel."),
    Judged(
        "5.2", _certificate,
        (([("k_1", "i_ds_tilde + w_1/k_1")], "left side minus sum"),
         ([("2/k_1", "w_1"), ("k_1", "i_ds_tilde")], "left side minus sum"),
         ([("2*k_1", "i_ds_tilde + w_1/k_1"), ("-k_1", "i_ds_tilde"), ("0", "w_1"), ("-2", "0"), ("1/k_1", "0")],
          "left side minus sum"),
         ([("k_1", "i_ds_tilde"), ("2/k_1", "w_1 + k_1*i_ds_tilde/2"), ("-k_1/2", "i_ds_tilde")], "not seen to be positive")),
        "Expand it once by hand: that is the whole proof."),
    Judged(
        "5.3", _counterexample,
        (({"i_ds_tilde": 1}, "has |z_tilde|^2 as a factor"),
         ({"i_ds_tilde": 1, "z_1_tilde": 4, "z_2": 1}, "is not negative"),
         ({"i_ds_tilde": 1, "z_1_tilde": 1, "z_2": -1, "omega_tilde": 2}, "must be positive"),
         ({"k_1": -5}, "may not change")),
        "One state refutes a bound for all states."),
    Judged(
        "5.4", _verdicts,
        (({**_GOOD, "eq16.bound": "holds after correction"}, "stands against every edit"),
         ({**_GOOD, "eq6.z_1": "fails", "eq16.bound": "fails"}, "exercise 3.1"),
         ({"eq6.z_1": "holds"}, "A dictionary with the keys"),
         ({**_GOOD, "eq16.bound": "false"}, "is no verdict"))),
)
