"""Exact answers in sympy's field of rational functions (``sympy.polys.fields``): elements in lowest terms, no ``simplify``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from sympy.polys.domains import QQ
from sympy.polys.fields import FracField

from imo_analysis.ledger.kernels.field_kernel import FieldKernel


class SympyKernel(FieldKernel):
    """Settles by equality of normal forms in ``QQ(x_1, ..., x_n)``."""

    name = "sympy"

    def field(self, names: Sequence[str]) -> tuple[Mapping[str, Any], Callable[[Fraction], Any]]:
        """Generators and constants of sympy's fraction field."""
        field = FracField(tuple(names) or ("unused",), QQ, "lex")
        return dict(zip(names, field.gens, strict=False)), lambda v: field(QQ(v.numerator, v.denominator))

    def equal(self, left: Any, right: Any) -> bool:
        """Normal forms are unique."""
        return bool(left == right)

    def rational(self, value: Fraction) -> Any:
        """A rational of sympy's ground domain."""
        return QQ(value.numerator, value.denominator)

    def show(self, element: Any) -> str:
        """The normal form as text."""
        return str(element)
