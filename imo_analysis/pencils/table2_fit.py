"""Table II explained, exactly: the one complex quadratic behind its 24 numbers, and which constants the rounding allows.

Findings, all recomputed by the functions here in rational arithmetic:

* Each printed pair at omega_hat sums to ``-a + j omega_hat`` with the same a for both columns and all speeds.
* The product of each pair is ``b - j c omega_hat + d omega_hat^2`` in the proposed column and
  ``b - j c omega_hat + d |omega_hat|`` in the baseline column, with the same b, c, d. So with four real constants

      s^2 + (a - j omega_hat) s + b - j c omega_hat + d (omega_hat^2 or |omega_hat|) = 0

  gives all 24 printed numbers to the last digit (only positive speeds are printed, so omega_hat and its magnitude cannot be
  told apart in the baseline column), and the columns differ in that one factor omega_hat: d = 50 fits, and the
  proposed column is what a z feedback k_2 omega_hat with k_2 = 50 gives, the baseline column what k_2 alone gives.
  So the column called baseline is not an observer of the form (2)-(4) with constant gains (`table2_proofs` has the proof).
* The printed quadratic belongs to the error dynamics ``i~' = (-a + j omega) i~ + alpha xi~ - j omega z~``,
  ``xi~' = -(b / alpha) i~``, ``z~' = -(c + j d omega) i~`` (z~' = -(c + j d) i~ for the baseline column). In (8) as expanded
  c is 0. Where (8) is read as the matrix equation A(omega_hat) x_hat + L (y - y_hat), with estimates in every place,
  c is R_s/sigma, b is alpha (R_s/sigma + k_3) and a is R_s/sigma + alpha (1 + beta L_m) + k_1.
* c = 254.6 /s is not Table III's R_s/sigma = 139.47 /s. With that reading R_s/sigma is the only machine quantity that the
  table determines; alpha, beta L_m, k_1 and k_3 enter as two sums and cannot be told apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from imo_analysis.errors import InputError
from imo_analysis.paper.tables import EIGENVALUES
from imo_analysis.pencils.interval import Interval, meet_all, square_root

COLUMNS = ("proposed", "baseline")
# column -> speed in rad/s -> the two members of the pairs, (real, imaginary) as printed, that add up to -a + j omega_hat
Table = Mapping[str, Mapping[int, tuple[tuple[str, str], tuple[str, str]]]]
PRINTED: Table = {
    column: {pair.omega_hat: (pair.first, pair.second) for pair in EIGENVALUES if pair.column == column} for column in COLUMNS
}
SPEEDS = tuple(PRINTED["proposed"])

# One quadratic of many that gives all 24 numbers: a, c in 1/s, b in 1/s^2, d. `mismatches` proves it; d = 50 is k_2 = 50.
WITNESS = (Fraction("495.3915"), Fraction("6074.7"), Fraction("254.585"), Fraction(50))


def scheduled(column: str, omega: int) -> int:
    """The factor of d in a column: omega^2 (proposed) or abs(omega) (baseline)."""
    if column not in COLUMNS:
        raise InputError(f"column = {column!r} must be one of: {', '.join(COLUMNS)}")
    return omega * omega if column == "proposed" else abs(omega)


def sum_interval(table: Table | None = None) -> Interval:
    """The interval of a that every pair's real parts allow. Each pair's imaginary parts are checked to add up to omega_hat.

    ``table`` stands in the place of `PRINTED`, here and below.
    """
    intervals = []
    for column, rows in (PRINTED if table is None else table).items():
        for omega, (fast, slow) in rows.items():
            intervals.append(-(Interval.printed(fast[0]) + Interval.printed(slow[0])))
            if not (Interval.printed(fast[1]) + Interval.printed(slow[1])).holds(omega):
                raise AssertionError(f"{column} at {omega} rad/s: the imaginary parts do not add up to the speed")
    a = meet_all(intervals)
    if a is None:
        raise AssertionError("the sums of the printed pairs share no constant")
    return a


def product(column: str, omega: int, table: Table | None = None) -> tuple[Interval, Interval]:
    """Real and imaginary part of the product of a pair, enclosed, with the sum of the pair used to tighten the rounding."""
    (fast_re, fast_im), (slow_re, slow_im) = (PRINTED if table is None else table)[column][omega]
    a = sum_interval(table)
    x_1 = _both(Interval.printed(fast_re), -a - Interval.printed(slow_re))
    y_1 = _both(Interval.printed(fast_im), Interval.of(omega) - Interval.printed(slow_im))
    x_2 = _both(Interval.printed(slow_re), -a - Interval.printed(fast_re))
    y_2 = _both(Interval.printed(slow_im), Interval.of(omega) - Interval.printed(fast_im))
    return x_1 * x_2 - y_1 * y_2, x_1 * y_2 + x_2 * y_1


@dataclass(frozen=True)
class Digits:
    """What the digits of a column say of its pairs, by speed: the sum -a + j omega and the product D.

    Attributes
    ----------
    a : Interval
    D_re, D_im : dict of int to Interval
    """

    a: Interval
    D_re: dict[int, Interval]
    D_im: dict[int, Interval]

    @property
    def c_0(self) -> dict[int, Interval]:
        """Square of the product's magnitude."""
        return {omega: value.square() + self.D_im[omega].square() for omega, value in self.D_re.items()}


def digits(column: str, table: Table | None = None) -> Digits:
    """The digits of a column, read together with those of the other one."""
    both = {omega: product(column, omega, table) for omega in SPEEDS}
    return Digits(sum_interval(table), {omega: one[0] for omega, one in both.items()},
                  {omega: one[1] for omega, one in both.items()})


def as_printed(a: Fraction, products: Mapping[int, tuple[Fraction, Fraction]], places: int = 6) -> Table:
    """The table that would be printed of pairs with the sum -a + j omega and these products, the same in both columns.

    Parameters
    ----------
    a : Fraction
        In 1/s.
    products : mapping of int to (Fraction, Fraction)
        Real and imaginary part of each pair's product, by speed.
    places : int
        Digits after the point, more than the paper's, so that rounding hides nothing.
    """
    rows = {}
    for omega, (real, imag) in products.items():
        one, other = ((_decimal(re.low, places), _decimal(im.low, places)) for re, im in _pair(a, omega, real, imag))
        rows[omega] = (one, other)
    return dict.fromkeys(COLUMNS, rows)


def _decimal(value: Fraction, places: int) -> str:
    scaled = round(value * 10**places)
    return f"{'-' if scaled < 0 else ''}{abs(scaled) // 10**places}.{abs(scaled) % 10**places:0{places}d}"


def _both(one: Interval, other: Interval) -> Interval:
    both = one.meet(other)
    if both is None:
        raise AssertionError(f"{one} and {other} share nothing")
    return both


def roots(a: Fraction, b: Fraction, c: Fraction, d: Fraction, column: str, omega: int) -> list[tuple[Interval, Interval]]:
    """Both roots of the quadratic, faster decay first, each as rational intervals for real and imaginary part, width 1e-39."""
    return _pair(a, omega, b + d * scheduled(column, omega), -c * omega)


def _pair(a: Fraction, omega: int, product_re: Fraction, product_im: Fraction) -> list[tuple[Interval, Interval]]:
    delta_re, delta_im = a * a - omega * omega - 4 * product_re, -2 * a * omega - 4 * product_im
    modulus = square_root(delta_re * delta_re + delta_im * delta_im)
    x = _root_of((modulus + delta_re) * Fraction(1, 2))
    y = _root_of((modulus - delta_re) * Fraction(1, 2))
    if delta_im < 0:
        y = -y
    low = ((-x - a) * Fraction(1, 2), (-y + omega) * Fraction(1, 2))
    high = ((x - a) * Fraction(1, 2), (y + omega) * Fraction(1, 2))
    return [low, high]


def _root_of(interval: Interval) -> Interval:
    return Interval(square_root(max(interval.low, Fraction(0))).low, square_root(interval.high).high)


def mismatches(a: Fraction, b: Fraction, c: Fraction, d: Fraction) -> list[str]:
    """Which of the 24 printed numbers the quadratic does not give to the printed digit. Proven, not floating point."""
    wrong = []
    for column in COLUMNS:
        for omega, pair in PRINTED[column].items():
            computed = roots(a, b, c, d, column, omega)
            ordered = computed if _matches(computed[0][0], pair[0][0]) else computed[::-1]
            for (re, im), (re_text, im_text) in zip(ordered, pair, strict=True):
                for value, text in ((re, re_text), (im, im_text)):
                    if not _matches(value, text):
                        wrong.append(f"{column} {omega} rad/s: printed {text}, quadratic gives {float(value.low):.4f}")
    return wrong


def _matches(value: Interval, text: str) -> bool:
    allowed = Interval.printed(text)
    return allowed.low <= value.low and value.high <= allowed.high
