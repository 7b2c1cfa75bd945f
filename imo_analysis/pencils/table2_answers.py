"""What Table II says and what it does not, question by question, each answer worked out in rational arithmetic.

The quadratic and its constants are in `table2_fit` and `table2_constants`, the impossible forms in `table2_proofs`. Here: how
far the digits fix the powers of the speed, what the columns differ in, whether that is fair, what Table III would have to be,
and what stays open whatever one would like to read into the digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import sympy as sp

from imo_analysis.equations import parameters
from imo_analysis.pencils.closed_form import closed_form
from imo_analysis.pencils.interval import Interval, meet_all
from imo_analysis.pencils.table2_constants import ranges
from imo_analysis.pencils.table2_fit import COLUMNS, PRINTED, SPEEDS, WITNESS, mismatches, product, scheduled, sum_interval
from imo_analysis.pencils.table2_proofs import (
    ALPHAS,
    BETA,
    L_M,
    R_S,
    SIGMA,
    invariants,
    matrix_reading,
    refutations,
    required_gains,
)

NUMBERS = sum(len(pair) * 2 for column in PRINTED.values() for pair in column.values())
_OMEGA = sp.Symbol("omega", real=True)


@dataclass(frozen=True)
class Answer:
    """One question about Table II.

    Attributes
    ----------
    question, answer : str
        In a sentence or two, with its numbers.
    determined : bool
        Whether the printed digits settle it; False where they leave it open, which is then what was shown.
    shown : bool
        Whether the calculation behind it came out as the answer says. Computed, not asserted.
    values : dict
        The numbers, as floats or pairs (low, high).
    """

    question: str
    answer: str
    determined: bool
    shown: bool
    values: dict[str, Any]


@cache
def powers() -> dict[str, Interval]:
    """For each column the powers r for which ``b + d abs(omega)^r`` can be the real part of the product, to 1e-4.

    Three speeds fix r: (100^r - 60^r) / (60^r - 30^r) grows with r and lies in the interval of the printed differences.
    """
    from mpmath import iv  # type: ignore[import-untyped]

    def above(r: Fraction, bound: Fraction, sign: int) -> bool:
        low, middle, high = (iv.mpf(omega) ** (iv.mpf(r.numerator) / r.denominator) for omega in SPEEDS)
        excess = (high - middle) / (middle - low) - iv.mpf(bound.numerator) / bound.denominator
        return bool(excess.a > 0) if sign > 0 else bool(excess.b < 0)

    found = {}
    for column in COLUMNS:
        first, second, third = (product(column, omega)[0] for omega in SPEEDS)
        ratio = (third - second) / (second - first)
        ends = []
        for sign, bound in ((-1, ratio.low), (1, ratio.high)):
            # from far out, where the bound is certainly passed, inwards to where it no longer certainly is
            outside, inside = (Fraction(1, 8), Fraction(8)) if sign < 0 else (Fraction(8), Fraction(1, 8))
            while abs(outside - inside) > Fraction(1, 10**5):
                middle = (outside + inside) / 2
                if above(middle, bound, sign):
                    outside = middle
                else:
                    inside = middle
            ends.append(outside)
        found[column] = Interval(*ends)
    return found


@cache
def by_column() -> dict[str, dict[str, Interval]]:
    """b, c and d as each column has them on its own, from the products of its pairs; enclosures."""
    found = {}
    for column in COLUMNS:
        real = {omega: product(column, omega)[0] for omega in SPEEDS}
        c = meet_all([-product(column, omega)[1] / omega for omega in SPEEDS])
        d = meet_all([(real[two] - real[one]) / (scheduled(column, two) - scheduled(column, one))
                      for one, two in ((30, 60), (60, 100), (30, 100))])
        if c is None or d is None:
            raise AssertionError(f"the {column} column has no common c or d")
        b = meet_all([real[omega] - d * scheduled(column, omega) for omega in SPEEDS])
        if b is None:
            raise AssertionError(f"the {column} column has no common b")
        found[column] = {"b": b, "c": c, "d": d}
    return found


@cache
def machines_with_the_same_table() -> tuple[dict[str, Fraction], ...]:
    """Rotor rates and gains that all give Table II's quadratic in (8) read as a matrix equation: examples of one family.

    The family is checked for every alpha at once, as an identity in alpha and omega.

    Raises
    ------
    AssertionError
        If it does not give the quadratic, or the quadratic not the table.
    """
    a, b, c, d = WITNESS
    form = invariants(matrix_reading("consistent_12"))
    alpha = sp.Symbol("alpha", positive=True)
    exact = {"R_s": _rational(c * SIGMA), "sigma": _rational(SIGMA), "beta": _rational(BETA), "L_m": _rational(L_M),
             "k_1": _rational(a - c) - alpha * _rational(1 + BETA * L_M), "k_2": _rational(d),
             "k_3": _rational(b) / alpha - _rational(c)}
    wanted = (_rational(a), _rational(b) + _rational(d) * _OMEGA**2, -_rational(c) * _OMEGA)
    for part, target in zip((form.a, form.D_re, form.D_im), wanted, strict=True):
        had = part.subs({symbol: exact[symbol.name] for symbol in part.free_symbols if symbol.name in exact})
        if sp.cancel(had - target) != 0:
            raise AssertionError("the family does not give the quadratic")
    if mismatches(a, b, c, d):
        raise AssertionError("the quadratic does not give the table")
    return tuple(
        {"R_s": c * SIGMA, "sigma": SIGMA, "alpha": value, "beta": BETA, "L_m": L_M, "k_1": a - c - value * (1 + BETA * L_M),
         "k_2": d, "k_3": b / value - c}
        for value in (*ALPHAS.values(), Fraction(20)))


def _rational(value: Fraction) -> Any:
    return sp.Rational(value.numerator, value.denominator)


@cache
def scheduled_baseline(column: str, omega: int) -> dict[str, Fraction]:
    """Gains (l_1, l_2, l_3, l_4) with which (2)-(3) has a column's poles at one speed, with Table III and its printed alpha.

    Checked against the baseline's own quadratic, which comes from differentiating its definition.

    Raises
    ------
    AssertionError
        If the gains do not give them.
    """
    a, b, c, d = WITNESS
    alpha = ALPHAS["printed"]
    real, imag = b + d * scheduled(column, omega), -c * omega
    size = alpha * alpha + omega * omega
    # the product is (alpha - j omega) (R_s/sigma + l_1 + beta l_3 + j beta l_4) where l_2 = 0
    x, y = (real * alpha - imag * omega) / size, (imag * alpha + real * omega) / size
    l_1 = a - parameters.current_decay(R_S, L_M, SIGMA, alpha, BETA) - alpha
    gains = {"l_1": l_1, "l_2": Fraction(0), "l_3": (x - l_1 - R_S / SIGMA) / BETA, "l_4": y / BETA}
    values = {"R_s": R_S, "L_m": L_M, "sigma": SIGMA, "beta": BETA, "alpha": alpha, "omega": Fraction(omega), **gains}
    form = closed_form("baseline")
    assert form is not None
    had = [part.subs({s: sp.Rational(values[s.name].numerator, values[s.name].denominator) for s in part.free_symbols})
           for part in form.coefficients]
    if [Fraction(int(value.p), int(value.q)) for value in had] != [a, -Fraction(omega), real, imag]:
        raise AssertionError(f"{column} at {omega} rad/s: these gains do not give the poles")
    return gains


def answers() -> tuple[Answer, ...]:
    """Every question that the table raises, with what is determined and what is not."""
    return (_quadratic(), _structure(), _difference(), _fairness(), _possible(), _table3(), _open())


def _pair(value: Interval) -> tuple[float, float]:
    return float(value.low), float(value.high)


def _text(value: Interval, digits: int = 6) -> str:
    return f"{float(value.low):.{digits}g} to {float(value.high):.{digits}g}"


def _quadratic() -> Answer:
    found = ranges()
    wrong = mismatches(*WITNESS)
    return Answer(
        "Which quadratic gives the table?",
        f"s^2 + (a - j omega) s + b - j c omega + d omega^2, with d abs(omega) in the baseline column, gives "
        f"{NUMBERS - len(wrong)} of {NUMBERS} printed numbers with four constants: "
        + "; ".join(f"{one.name} from {_text(one.outer, 7)}" for one in found)
        + f". {NUMBERS} numbers and four constants leave {NUMBERS - len(found)} that had to come out by themselves.",
        True, not wrong,
        {one.name: _pair(one.outer) for one in found} | {"numbers": NUMBERS, "constants": len(found)},
    )


def _structure() -> Answer:
    fits = powers()
    a = sum_interval()
    shown = fits["proposed"].holds(2) and fits["baseline"].holds(1) and not fits["proposed"].holds(1)
    return Answer(
        "Which structure does that imply?",
        f"Each pair adds up to -a + j omega with one a ({_text(a, 7)} /s) for both columns, as in any observer of (2)-(3) or "
        "(8) whose current feedback is constant. The real part of the product grows with omega to the power "
        f"{_text(fits['proposed'], 6)} in the proposed column and {_text(fits['baseline'], 4)} in the baseline one, as with a "
        "feedback of z through k_2 omega_hat, and through k_2 alone. Only positive speeds are printed: omega and "
        "abs(omega) cannot be told apart in the baseline "
        "column. The table fixes the polynomial; a matrix is fixed only up to a change of coordinates.",
        True, shown, {"a": _pair(a)} | {f"power_{column}": _pair(value) for column, value in fits.items()},
    )


def _difference() -> Answer:
    columns = by_column()
    d = WITNESS[3]
    gap = {omega: product("proposed", omega)[0] - product("baseline", omega)[0] for omega in SPEEDS}
    same = all(columns["proposed"][name].meet(columns["baseline"][name]) is not None for name in ("b", "c", "d"))
    shown = same and all(value.holds(d * (omega * omega - omega)) for omega, value in gap.items())
    return Answer(
        "In what do the two columns differ?",
        "In one factor omega_hat and in nothing else that the digits show: read separately, the columns have "
        + "; ".join(f"{name} {_text(columns['proposed'][name])} (proposed) and {_text(columns['baseline'][name])} (baseline)"
                    for name in ("b", "c", "d"))
        + f". The difference of their products is {float(d):g} (omega^2 - omega) at every speed.",
        True, shown,
        {f"{name}_{column}": _pair(value) for column, group in columns.items() for name, value in group.items()},
    )


def _fairness() -> Answer:
    slowest = {column: {omega: -max(Fraction(re) for re, _ in PRINTED[column][omega]) for omega in SPEEDS}
               for column in COLUMNS}
    beside = [f"{float(slowest['proposed'][omega]):g} against {float(slowest['baseline'][omega]):g} /s at {omega} rad/s"
              for omega in SPEEDS]
    impossible = [one.proved for one in refutations() if one.source == "(2)-(3)" and one.column == "baseline"]
    # one set of constants gives both columns, so with omega d in place of d the baseline column is the proposed one
    shown = not mismatches(*WITNESS) and all(impossible) and len(impossible) > 0
    return Answer(
        "Is the comparison fair?",
        "No. Both columns are one pencil with a small and a large gain: the proposed column has the baseline column's feedback "
        f"times omega, {SPEEDS[0]} to {SPEEDS[-1]} times as much. With that factor the baseline column is the proposed one, to "
        "the last digit. The slowest printed decay is "
        + ", ".join(beside)
        + ". And the baseline column belongs to no observer (2)-(3) with constant gains.",
        True, shown, {f"slowest_{column}": [float(slowest[column][w]) for w in SPEEDS] for column in COLUMNS},
    )


def _possible() -> Answer:
    forms = refutations()
    gains = {(column, omega): scheduled_baseline(column, omega) for column in COLUMNS for omega in SPEEDS}
    proved = all(one.proved for one in forms)
    return Answer(
        "Which of the printed matrices can give either column?",
        f"None, with Table III and real constant gains: {sum(one.proved for one in forms)} of {len(forms)} contradictions are "
        "exact. With gains that follow the speed (2)-(3) gives either column exactly, with other l_3 and l_4 at each speed: "
        "where poles lie says nothing of one structure against the other, only how the gains were chosen.",
        True, proved,
        {f"{column} {omega}": {name: float(value) for name, value in one.items()} for (column, omega), one in gains.items()},
    )


def _table3() -> Answer:
    c = next(one.outer for one in ranges() if one.name == "c")
    needed = required_gains()["printed"]
    factor = c / (R_S / SIGMA)
    millihenries = needed["sigma"] * 1000
    return Answer(
        "What would Table III have to be?",
        f"In (8) read as a matrix equation c is R_s/sigma, which would have to be {_text(c)} /s where Table III gives "
        f"{float(R_S / SIGMA):.6g}: {_text(factor, 5)} times as much. With R_s alone wrong it would be "
        f"{_text(needed['R_s'], 5)} ohm (printed {float(R_S):g}), with sigma alone {_text(millihenries, 5)} mH (from Table III "
        f"{float(SIGMA) * 1e3:.5g}). Which of the two, or how much of either, the table does not say; in (8) as "
        "expanded c is 0 and no Table III helps.",
        True, not c.holds(R_S / SIGMA),
        {"c": _pair(c), "factor": _pair(factor), "R_s": _pair(needed["R_s"]), "sigma": _pair(needed["sigma"])},
    )


def _open() -> Answer:
    found = machines_with_the_same_table()
    sets = [f"alpha = {float(one['alpha']):.5g} /s with k_1 = {float(one['k_1']):.5g} and k_3 = {float(one['k_3']):.5g} /s"
            for one in found]
    return Answer(
        "What is not determined?",
        "alpha, beta L_m, k_1 and k_3 enter through two sums only. "
        + "; ".join(sets)
        + " all give every printed digit, and any other alpha does with gains of its own. A match of such a value with one in "
        "Table III would be chance; so would be one with R_s or sigma alone, of which only the ratio counts. Also "
        "open: the sign of omega in the "
        "baseline column, h, K_p and g, which frozen-speed poles do not hold, and which program printed the table.",
        False, len(found) > 1, {"sets": [{name: float(value) for name, value in one.items()} for one in found]},
    )
