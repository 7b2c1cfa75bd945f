"""Exact answers in python-flint: fractions of ``fmpq_mpoly`` that are never reduced, compared by cross multiplication."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any, cast

import flint

from imo_analysis.ledger.expression import Expr, evaluate
from imo_analysis.ledger.kernels.field_kernel import FieldKernel


class Quotient:
    """A fraction of multivariate polynomials. Sums over one denominator keep it; nothing is cancelled otherwise."""

    __slots__ = ("den", "num")

    def __init__(self, num: Any, den: Any) -> None:
        self.num = num
        self.den = den

    def __add__(self, other: Quotient) -> Quotient:
        if self.den == other.den:
            return Quotient(self.num + other.num, self.den)
        if other.den.is_one():
            return Quotient(self.num + other.num * self.den, self.den)
        if self.den.is_one():
            return Quotient(self.num * other.den + other.num, other.den)
        common = self.den.gcd(other.den)
        left, right = self.den / common, other.den / common
        return Quotient(self.num * right + other.num * left, self.den * right)

    def __sub__(self, other: Quotient) -> Quotient:
        return self + Quotient(-other.num, other.den)

    def __mul__(self, other: Quotient) -> Quotient:
        return Quotient(self.num * other.num, self.den * other.den)

    def __truediv__(self, other: Quotient) -> Quotient:
        if other.num.is_zero():
            raise ZeroDivisionError
        return Quotient(self.num * other.den, self.den * other.num)

    def __pow__(self, power: int) -> Quotient:
        return Quotient(self.num**power, self.den**power)

    def __neg__(self) -> Quotient:
        return Quotient(-self.num, self.den)


class FlintKernel(FieldKernel):
    """Settles by ``a d - c b = 0`` for ``a/b = c/d``."""

    name = "flint"

    def field(self, names: Sequence[str]) -> tuple[Mapping[str, Any], Callable[[Fraction], Any]]:
        """Generators and constants as quotients over 1."""
        context = flint.fmpq_mpoly_ctx.get(tuple(names) or ("unused",), flint.Ordering.lex)
        one = context.constant(1)
        return (
            {name: Quotient(gen, one) for name, gen in zip(names, context.gens(), strict=False)},
            lambda v: Quotient(context.constant(flint.fmpq(v.numerator, v.denominator)), one),
        )

    def value(self, tree: Expr, generators: Mapping[str, Any], constant: Callable[[Fraction], Any]) -> Quotient:
        """A tree in a field made by `field`."""
        return cast(Quotient, evaluate(tree, generators, constant))

    def equal(self, left: Quotient, right: Quotient) -> bool:
        """Cross multiplication; the denominators are not zero by construction."""
        return bool((left.num * right.den - right.num * left.den).is_zero())

    def rational(self, value: Fraction) -> Any:
        """FLINT's own rational."""
        return flint.fmpq(value.numerator, value.denominator)

    def show(self, element: Quotient) -> str:
        """The fraction in lowest terms as text, in Python syntax."""
        common = element.num.gcd(element.den)
        num, den = element.num / common, element.den / common
        leading = den.leading_coefficient()
        num, den = num / leading, den / leading
        if den.is_one():
            return str(num).replace("^", "**")
        return f"({num})/({den})".replace("^", "**")
