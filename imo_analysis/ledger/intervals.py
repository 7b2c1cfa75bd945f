"""Printed decimals as exact intervals: what a number with so many digits may have been before it was rounded."""

from __future__ import annotations

from fractions import Fraction

from imo_analysis.errors import InputError

Interval = tuple[Fraction, Fraction]


def printed(text: str) -> Interval:
    """The closed interval of numbers that round to a printed decimal: ``"9.9354"`` is (9.93535, 9.93545).

    Raises
    ------
    InputError
        If the text is not a decimal.
    """
    try:
        value = Fraction(text)
        digits = text.strip().lower()
        mantissa, _, exponent = digits.partition("e")
        places = len(mantissa.partition(".")[2])
        half = Fraction(1, 2) / Fraction(10) ** places * Fraction(10) ** int(exponent or 0)
    except ValueError:
        raise InputError(f"{text!r} is not a printed decimal, such as 9.9354 or 60.1e-3") from None
    if "/" in text:
        raise InputError(f"{text!r} is not a printed decimal, such as 9.9354 or 60.1e-3")
    return value - half, value + half


def add(a: Interval, b: Interval) -> Interval:
    """Sum."""
    return a[0] + b[0], a[1] + b[1]


def multiply(a: Interval, b: Interval) -> Interval:
    """Product."""
    every = [x * y for x in a for y in b]
    return min(every), max(every)


def divide(a: Interval, b: Interval) -> Interval:
    """Quotient.

    Raises
    ------
    InputError
        If the divisor contains zero.
    """
    if b[0] <= 0 <= b[1]:
        raise InputError(f"division by the interval [{b[0]}, {b[1]}], which contains zero")
    return multiply(a, (1 / b[1], 1 / b[0]))


def overlap(a: Interval, b: Interval) -> bool:
    """Whether the two have a number in common: a printed value is compatible with a computed one."""
    return a[0] <= b[1] and b[0] <= a[1]
