"""Closed intervals with rational ends: what a printed decimal number tells, carried exactly through a calculation."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt


@dataclass(frozen=True)
class Interval:
    """All numbers from ``low`` to ``high``, both included. Arithmetic encloses every possible result."""

    low: Fraction
    high: Fraction

    @classmethod
    def printed(cls, text: str) -> Interval:
        """What a decimal number printed with rounding can stand for: half a unit of its last digit to either side."""
        digits = len(text.partition(".")[2])
        half = Fraction(1, 2 * 10**digits)
        return cls(Fraction(text) - half, Fraction(text) + half)

    @classmethod
    def of(cls, value: Interval | Fraction | int) -> Interval:
        """The value itself, as an interval of no width where it is a number."""
        return value if isinstance(value, Interval) else cls(Fraction(value), Fraction(value))

    def __add__(self, other: Interval | Fraction | int) -> Interval:
        other = Interval.of(other)
        return Interval(self.low + other.low, self.high + other.high)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __sub__(self, other: Interval | Fraction | int) -> Interval:
        return self + -Interval.of(other)

    def __mul__(self, other: Interval | Fraction | int) -> Interval:
        other = Interval.of(other)
        products = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return Interval(min(products), max(products))

    def __truediv__(self, other: Interval | Fraction | int) -> Interval:
        other = Interval.of(other)
        if other.low <= 0 <= other.high:
            raise ZeroDivisionError("the divisor's interval holds zero")
        return self * Interval(1 / other.high, 1 / other.low)

    def square(self) -> Interval:
        """The squares; unlike ``x * x`` it knows that both factors are the same number."""
        ends = (self.low * self.low, self.high * self.high)
        return Interval(Fraction(0) if self.low <= 0 <= self.high else min(ends), max(ends))

    def meet(self, other: Interval) -> Interval | None:
        """What both hold, or None where they are disjoint."""
        low, high = max(self.low, other.low), min(self.high, other.high)
        return Interval(low, high) if low <= high else None

    def holds(self, value: Fraction | int) -> bool:
        """Whether the value lies inside."""
        return self.low <= value <= self.high

    def __str__(self) -> str:
        return f"[{float(self.low):.10g}, {float(self.high):.10g}]"


def square_root(value: Fraction, digits: int = 40) -> Interval:
    """An interval of width ``10**-digits`` that holds the square root of a rational number that is not negative."""
    if value < 0:
        raise ValueError("the square root of a negative number")
    scale = 10**digits
    root = isqrt(value.numerator * scale * scale // value.denominator)
    return Interval(Fraction(root, scale), Fraction(root + 1, scale))


def meet_all(intervals: list[Interval]) -> Interval | None:
    """What all hold, or None where there is nothing."""
    low, high = max(i.low for i in intervals), min(i.high for i in intervals)
    return Interval(low, high) if low <= high else None
