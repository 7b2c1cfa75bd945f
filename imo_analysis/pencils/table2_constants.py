"""The ranges that the rounding of Table II leaves to the four constants of its quadratic, with exact certificates.

Near a printed root m the quadratic's root is m + delta with

    delta = -F(m) / K - (delta^2 + (a - a_0) delta) / K,    F(m) = m^2 + (a - j omega) m + b - j c omega + d f,
    K = 2 m + a_0 - j omega,

and F is affine in (a, b, c, d). So 'delta is within the rounding' is two linear inequalities in the constants, with a
remainder that is bounded exactly. The range of a constant is then a linear programme. Floating point only proposes which
four inequalities decide; the bound itself is their exact rational combination with multipliers that are not negative
(duality), so it cannot be wrong.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from imo_analysis.pencils.interval import Interval
from imo_analysis.pencils.table2_fit import COLUMNS, PRINTED, WITNESS, mismatches, scheduled, sum_interval

NAMES = ("a", "b", "c", "d")
UNITS = {"a": "1/s", "b": "1/s^2", "c": "1/s", "d": "1 (proposed), 1/s (baseline)"}
Row = tuple[tuple[Fraction, Fraction, Fraction, Fraction], Fraction]


@dataclass(frozen=True)
class Range:
    """What is known of one constant.

    Attributes
    ----------
    name : str
        ``a``, ``b``, ``c`` or ``d``.
    outer : Interval
        No value outside gives all 24 printed numbers.
    inner : Interval
        Both ends do, with suitable values of the other three.
    """

    name: str
    outer: Interval
    inner: Interval


@cache
def inequalities() -> tuple[Row, ...]:
    """Rows ``(coefficients of a, b, c, d; bound)`` with ``coefficients . constants <= bound`` for every fitting quadratic."""
    rows: list[Row] = []
    a = sum_interval()
    a_0, a_half = (a.low + a.high) / 2, (a.high - a.low) / 2
    for column in COLUMNS:
        for omega, pair in PRINTED[column].items():
            f = Fraction(scheduled(column, omega))
            for re, im in pair:
                x, y = Fraction(re), Fraction(im)
                half = Interval.printed(re).high - x
                k_re, k_im = 2 * x + a_0, 2 * y - omega
                size = k_re * k_re + k_im * k_im
                remainder = _remainder(half, a_half, (k_re, k_im))
                # F(m) = constant + a m + b - j c omega + d f, as coefficients of (a, b, c, d, 1), real and imaginary
                real = (x, Fraction(1), Fraction(0), f, x * x - y * y + omega * y)
                imag = (y, Fraction(0), Fraction(-omega), Fraction(0), 2 * x * y - omega * x)
                for part in (
                    [-(r * k_re + i * k_im) / size for r, i in zip(real, imag, strict=True)],
                    [-(i * k_re - r * k_im) / size for r, i in zip(real, imag, strict=True)],
                ):
                    one, two, three, four, constant = part
                    rows.append(((one, two, three, four), half + remainder - constant))
                    rows.append(((-one, -two, -three, -four), half + remainder + constant))
    return tuple(rows)


def _remainder(half: Fraction, a_half: Fraction, K: tuple[Fraction, Fraction]) -> Fraction:
    """Above ``abs((delta^2 + (a - a_0) delta) / K)`` for every delta within the rounding and every a that fits."""
    longest = 2 * half  # above |delta|, which is at most sqrt(2) half
    return (longest * longest + a_half * longest) / max(abs(K[0]), abs(K[1]))


def upper_bound(objective: tuple[int, int, int, int]) -> tuple[Fraction, tuple[float, ...]]:
    """An exact upper bound of ``objective . constants`` over all fitting quadratics, and where it is nearly reached."""
    import numpy as np
    from scipy.optimize import linprog

    rows = inequalities()
    centre = np.array([float(value) for value in WITNESS])
    scale = np.array([1e-2, 1.0, 1e-2, 1e-3])
    matrix = np.array([[float(entry) for entry in row] for row, _ in rows]) * scale
    # the bounds are formed exactly about the centre before they become floats: they are small differences of large numbers
    bounds = np.array([float(bound - sum(e * w for e, w in zip(row, WITNESS, strict=True))) for row, bound in rows])
    found = linprog(-np.array(objective) * scale, A_ub=matrix, b_ub=bounds, bounds=(None, None), method="highs-ds")
    if found.status != 0:
        raise AssertionError(f"the linear programme for {objective} was not solved: {found.message}")
    active = [int(k) for k in np.argsort(found.ineqlin.marginals)[:4]]
    multipliers = _solve([[rows[k][0][n] for k in active] for n in range(4)], [Fraction(o) for o in objective])
    if min(multipliers) < 0:
        raise AssertionError(f"no certificate for {objective}: a multiplier is negative")
    bound = sum((y * rows[k][1] for y, k in zip(multipliers, active, strict=True)), Fraction(0))
    return bound, tuple(centre + found.x * scale)


def _solve(matrix: list[list[Fraction]], right: list[Fraction]) -> list[Fraction]:
    """Gauss elimination in rational numbers."""
    n = len(right)
    work = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for k in range(n):
        pivot = next(r for r in range(k, n) if work[r][k] != 0)
        work[k], work[pivot] = work[pivot], work[k]
        work[k] = [entry / work[k][k] for entry in work[k]]
        for r in range(n):
            if r != k:
                work[r] = [entry - work[r][k] * top for entry, top in zip(work[r], work[k], strict=True)]
    return [row[n] for row in work]


@cache
def ranges() -> tuple[Range, ...]:
    """The range of each constant, outer bounds certified by duality, inner ones by quadratics that fit exactly."""
    result = []
    for k, name in enumerate(NAMES):
        ends = []
        for sign in (-1, 1):
            objective = tuple(sign if n == k else 0 for n in range(4))
            bound, place = upper_bound(objective)  # type: ignore[arg-type]
            ends.append((sign * bound, _fitting(place)[k]))
        result.append(Range(name, Interval(ends[0][0], ends[1][0]), Interval(ends[0][1], ends[1][1])))
    return tuple(result)


def _fitting(place: tuple[float, ...]) -> tuple[Fraction, ...]:
    """A rational quadratic next to ``place`` that fits all 24 numbers, found by stepping towards the witness."""
    for step in (Fraction(1, 1000), Fraction(1, 100), Fraction(1, 20), Fraction(1, 4)):
        a, b, c, d = (Fraction(p).limit_denominator(10**9) * (1 - step) + w * step for p, w in zip(place, WITNESS, strict=True))
        if not mismatches(a, b, c, d):
            return a, b, c, d
    return WITNESS
