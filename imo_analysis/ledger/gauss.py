"""Complex numbers with exact parts, x = x_d + j x_q; Python's own are floats."""

from __future__ import annotations

from fractions import Fraction
from typing import Any


class Gauss:
    """A complex number with exact parts."""

    __slots__ = ("im", "re")

    def __init__(self, re: Any, im: Any = 0) -> None:
        self.re, self.im = re, im

    def __add__(self, other: Any) -> Gauss:
        other = _gauss(other)
        return Gauss(self.re + other.re, self.im + other.im)

    def __sub__(self, other: Any) -> Gauss:
        return self + _gauss(other) * -1

    def __mul__(self, other: Any) -> Gauss:
        other = _gauss(other)
        return Gauss(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)

    __radd__ = __add__
    __rmul__ = __mul__

    def __neg__(self) -> Gauss:
        return self * -1

    def __truediv__(self, other: Any) -> Gauss:
        other = _gauss(other)
        size = other.re**2 + other.im**2
        return self * Gauss(Fraction(other.re) / size, -Fraction(other.im) / size)

    def conjugate(self) -> Gauss:
        """x_d - j x_q."""
        return Gauss(self.re, -self.im)

    @property
    def pair(self) -> tuple[Any, Any]:
        """(x_d, x_q)."""
        return self.re, self.im


def _gauss(value: Any) -> Gauss:
    return value if isinstance(value, Gauss) else Gauss(value)


J = Gauss(0, 1)


def cross(a: Gauss, b: Gauss) -> Any:
    """Im(conj(a) b), the moment of b about a."""
    return (a.conjugate() * b).im


def dot(a: Gauss, b: Gauss) -> Any:
    """Re(conj(a) b)."""
    return (a.conjugate() * b).re
