"""Exact answers in a polynomial ring of sympy (``sympy.polys.rings``), with denominators kept as products of their factors.

No greatest common divisor is ever computed and nothing is simplified: a sum is brought to the least common multiple of the
factors that were divided by, and two quotients are equal if their numerators over it are.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from sympy.polys.domains import QQ
from sympy.polys.rings import PolyElement, PolyRing

from imo_analysis.ledger.kernels.field_kernel import FieldKernel


class Ratio:
    """A polynomial over a product of factors; ``den`` counts each factor."""

    __slots__ = ("den", "num")

    def __init__(self, num: PolyElement, den: Counter[PolyElement]) -> None:
        self.num = num
        self.den = den

    def over(self, den: Counter[PolyElement]) -> PolyElement:
        """The numerator over a multiple of the denominator."""
        num = self.num
        for factor, power in den.items():
            if power > self.den[factor]:
                num = num * factor ** (power - self.den[factor])
        return num

    def __add__(self, other: Ratio) -> Ratio:
        den = self.den | other.den
        return Ratio(self.over(den) + other.over(den), den)

    def __sub__(self, other: Ratio) -> Ratio:
        den = self.den | other.den
        return Ratio(self.over(den) - other.over(den), den)

    def __mul__(self, other: Ratio) -> Ratio:
        return Ratio(self.num * other.num, self.den + other.den)

    def __truediv__(self, other: Ratio) -> Ratio:
        if not other.num:
            raise ZeroDivisionError
        below = other.den - self.den
        above = self.den - other.den
        num = self.num
        for factor, power in below.items():
            num = num * factor**power
        return Ratio(num, above + Counter(_factors(other.num)))

    def __pow__(self, power: int) -> Ratio:
        return Ratio(self.num**power, Counter({factor: power * count for factor, count in self.den.items()}))

    def __neg__(self) -> Ratio:
        return Ratio(-self.num, self.den)


def _factors(poly: PolyElement) -> dict[PolyElement, int]:
    """A monomial as its variables and coefficient, anything else as it is."""
    if len(poly) != 1:
        return {poly: 1}
    (exponents, coefficient), = poly.terms()
    found = {gen: power for gen, power in zip(poly.ring.gens, exponents, strict=True) if power}
    if coefficient != 1:
        found[poly.ring.ground_new(coefficient)] = 1
    return found


class SympyKernel(FieldKernel):
    """Settles by equal numerators over a common denominator in ``QQ[x_1, ..., x_n]``."""

    name = "sympy"

    def field(self, names: Sequence[str]) -> tuple[Mapping[str, Any], Callable[[Fraction], Any]]:
        """Generators and constants as ratios over the empty product."""
        ring = PolyRing(tuple(names) or ("unused",), QQ, "lex")
        return (
            {name: Ratio(gen, Counter()) for name, gen in zip(names, ring.gens, strict=False)},
            lambda v: Ratio(ring.ground_new(QQ(v.numerator, v.denominator)), Counter()),
        )

    def equal(self, left: Ratio, right: Ratio) -> bool:
        """Equal numerators over the least common multiple."""
        den = left.den | right.den
        return bool(left.over(den) == right.over(den))

    def rational(self, value: Fraction) -> Any:
        """A rational of sympy's ground domain."""
        return QQ(value.numerator, value.denominator)

    def show(self, element: Ratio) -> str:
        """The quotient in lowest terms as text."""
        whole = element.num.ring.one
        for factor, power in element.den.items():
            whole = whole * factor**power
        num, den = element.num.cancel(whole)
        return f"{num}" if den == 1 else f"({num})/({den})"
