"""The derivative along a vector field by dual numbers: V' = V(Dual(x, f)).rate, in any algebra, with no computer algebra."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any


class Dual:
    """A value and its rate. Mixes with plain values, whose rate is zero; works over floats, fractions, trees, ring elements."""

    __slots__ = ("rate", "value")

    def __init__(self, value: Any, rate: Any = 0) -> None:
        self.value = value
        self.rate = rate

    def __add__(self, other: Any) -> Dual:
        value, rate = _parts(other)
        return Dual(self.value + value, _plus(self.rate, rate))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Dual:
        value, rate = _parts(other)
        return Dual(self.value - value, _plus(self.rate, _times(-1, rate)))

    def __rsub__(self, other: Any) -> Dual:
        return Dual(other - self.value, _times(-1, self.rate))

    def __mul__(self, other: Any) -> Dual:
        value, rate = _parts(other)
        return Dual(self.value * value, _plus(_times(value, self.rate), _times(self.value, rate)))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        value, rate = _parts(other)
        change = _plus(_times(value, self.rate), _times(-1, _times(self.value, rate)))
        return Dual(self.value / value, change if _zero(change) else change / (value * value))

    def __rtruediv__(self, other: Any) -> Dual:
        return Dual(other, 0) / self

    def __pow__(self, power: int) -> Dual:
        return Dual(self.value**power, _times(power * self.value ** (power - 1), self.rate) if power else 0)

    def __neg__(self) -> Dual:
        return Dual(-self.value, _times(-1, self.rate))

    def __abs__(self) -> Dual:
        return Dual(abs(self.value), _times(abs(self.value) / self.value, self.rate) if not _zero(self.rate) else 0)


def _parts(other: Any) -> tuple[Any, Any]:
    return (other.value, other.rate) if isinstance(other, Dual) else (other, 0)


def _zero(value: Any) -> bool:
    """A rate that is the literal 0; kept out of products so that trees stay small."""
    return isinstance(value, int) and value == 0


def _plus(a: Any, b: Any) -> Any:
    return b if _zero(a) else a if _zero(b) else a + b


def _times(a: Any, b: Any) -> Any:
    return 0 if _zero(a) or _zero(b) else -b if isinstance(a, int) and a == -1 else a * b


def rate_along(function: Callable[..., Any], values: Mapping[str, Any], rates: Mapping[str, Any]) -> Any:
    """The time derivative of ``function(**values)`` when each value moves at its rate; names without a rate stand still."""
    result = function(**{name: Dual(value, rates.get(name, 0)) for name, value in values.items()})
    return result.rate if isinstance(result, Dual) else 0
