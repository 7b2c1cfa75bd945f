"""The second form of a definition: what it is called, how its arguments are drawn, and whether a function meets it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from random import Random
from typing import Any

from imo_analysis.ledger.gauss import Gauss


@dataclass(frozen=True)
class Form:
    """The oracle of one definition.

    Attributes
    ----------
    module, function : str
    shape : tuple of int
        One entry an argument: 0 for a scalar, n for a tuple of n scalars.
    value : callable
        The complex form, on the same arguments.
    arguments : callable, optional
        Makes arguments from a `Random` where they must satisfy a relation.
    """

    module: str
    function: str
    shape: tuple[int, ...]
    value: Callable[..., Any]
    arguments: Callable[[Random], tuple[Any, ...]] | None = None

    def sample(self, random: Random) -> tuple[Any, ...]:
        """Arguments at random: fractions that are not zero, of both signs."""
        if self.arguments:
            return self.arguments(random)

        def one() -> Fraction:
            return Fraction(random.choice((-1, 1)) * random.randint(1, 60), random.randint(1, 12))

        return tuple(one() if size == 0 else tuple(one() for _ in range(size)) for size in self.shape)

    def meets(self, function: Callable[..., Any], random: Random, points: int = 4) -> bool:
        """Whether a function gives the values of the complex form; one that fails to compute does not."""
        for _ in range(points):
            arguments = self.sample(random)
            expected = flat(self.value(*arguments))
            try:
                found = flat(function(*arguments))
            except Exception:  # a mutant may fail in any way, and each is a kill
                return False
            if len(found) != len(expected) or not all(map(_same, found, expected)):
                return False
        return True


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, float) or isinstance(b, float):
        return isinstance(a, (int, float, Fraction)) and math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12)
    return bool(a == b)


def flat(value: Any) -> list[Any]:
    """The scalars in nested tuples and complex numbers, in order."""
    if isinstance(value, Gauss):
        return [value.re, value.im]
    if isinstance(value, (tuple, list)):
        return [one for part in value for one in flat(part)]
    return [value]
