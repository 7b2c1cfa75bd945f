"""Partial evaluation of the definitions: run them once on symbols, and see what must be computed how often.

Every value has a level: `CONSTANT` in a run, `HELD` over a sample, or `LIVE`. What is constant is computed once, with numpy,
for all machines together. A division by something of a lower level becomes a product with its reciprocal, additions of 0 and
products with 0 and 1 go away, signs move outwards until they cancel, ``(x + |x|) / 2`` is the larger of x and 0, and what
occurs twice is computed once. All but the reciprocal are exact, and the order of operations is the definition's: results
differ from those of the definition by rounding only.
"""

from __future__ import annotations

import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

CONSTANT, HELD, LIVE = range(3)
_TEXT = {"+": "({} + {})", "-": "({} - {})", "*": "({} * {})", "/": "({} / {})", "neg": "(-{})", "abs": "abs({})",
         "sqrt": "sqrt({})", "max": "max({}, {})", "min": "min({}, {})"}
_NUMPY: dict[str, Callable[..., Any]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "neg": np.negative, "abs": np.abs, "sqrt": np.sqrt,
    "max": np.maximum, "min": np.minimum,
}


_SIGNED = ("+", "-", "*", "/", "abs")


class Value:
    """A value of a `Trace`; arithmetic on it makes further ones."""

    __slots__ = ("args", "level", "op", "trace")

    def __init__(self, trace: Trace, op: str, args: tuple[Any, ...], level: int) -> None:
        self.trace, self.op, self.args, self.level = trace, op, args, level

    def __add__(self, other: Any) -> Any:
        return self.trace.combine("+", self, other)

    def __radd__(self, other: Any) -> Any:
        return self.trace.combine("+", other, self)

    def __sub__(self, other: Any) -> Any:
        return self.trace.combine("-", self, other)

    def __rsub__(self, other: Any) -> Any:
        return self.trace.combine("-", other, self)

    def __mul__(self, other: Any) -> Any:
        return self.trace.combine("*", self, other)

    def __rmul__(self, other: Any) -> Any:
        return self.trace.combine("*", other, self)

    def __truediv__(self, other: Any) -> Any:
        return self.trace.combine("/", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self.trace.combine("/", other, self)

    def __neg__(self) -> Any:
        return self.trace.combine("neg", self)

    def __abs__(self) -> Any:
        return self.trace.combine("abs", self)

    def __pow__(self, power: int) -> Any:
        if power == 1:
            return self
        return self ** (power - 1) * self

    def __bool__(self) -> bool:
        raise TypeError("a definition that branches on a value cannot be traced")


class Trace:
    """Values by name and by what they are made of; equal ones are the same object."""

    def __init__(self) -> None:
        self._known: dict[tuple[Any, ...], Value] = {}

    def inputs(self, names: Iterable[str], level: int) -> tuple[Value, ...]:
        """Values that come from outside."""
        return tuple(self._made("input", (name,), level) for name in names)

    def combine(self, op: str, *args: Any) -> Any:
        """A value computed from others, or from others and numbers."""
        numbers = [None if isinstance(arg, Value) else float(arg) for arg in args]
        if None not in numbers:
            return float(_NUMPY[op](*numbers))
        simple = _simplified(op, args, numbers)
        if simple is not None:
            return simple
        if op == "-" and ("-", *args[::-1]) in self._known:
            return self.combine("neg", self._known["-", *args[::-1]])
        if op in _SIGNED and any(map(_is_negative, args)):
            return self._signs_outside(op, args)
        if op == "*" and numbers[1] == 0.5 and (part := _positive_part(args[0])) is not None:
            return self.combine("max", part, 0.0)
        level = max(arg.level for arg in args if isinstance(arg, Value))
        if op == "/":
            below = args[1]
            if not isinstance(below, Value) or below.level < level:
                return self.combine("*", args[0], self.combine("/", 1.0, below))
        return self._made(op, tuple(args), level)

    def _signs_outside(self, op: str, args: tuple[Any, ...]) -> Any:
        """The same value with no sign before an argument. Rounding is symmetric, so that nothing changes."""
        bare = tuple(arg.args[0] if _is_negative(arg) else arg for arg in args)
        if op == "abs":
            return self.combine("abs", *bare)
        signs = tuple(map(_is_negative, args))
        if op in "*/":
            value = self.combine(op, *bare)
            return value if all(signs) else self.combine("neg", value)
        plus = signs[0] == (signs[1] != (op == "-"))
        if plus:
            value = self.combine("+", *bare)
            return self.combine("neg", value) if signs[0] else value
        return self.combine("-", *(bare[::-1] if signs[0] else bare))

    def _made(self, op: str, args: tuple[Any, ...], level: int) -> Value:
        key = (op, frozenset(args)) if op in "+*" else (op, *args)
        if key not in self._known:
            self._known[key] = Value(self, op, args, level)
        return self._known[key]

    def run(self, definition: Any, *args: Any) -> Any:
        """What a definition returns for values; ``sqrt``, ``max`` and ``min`` in it and in its module's become operations."""
        names = {**definition.__globals__, **{op: _operation(self, op) for op in ("sqrt", "max", "min")}}
        for name, one in definition.__globals__.items():
            if isinstance(one, types.FunctionType) and one.__module__ == definition.__module__:
                names[name] = types.FunctionType(one.__code__, names, name)
        return types.FunctionType(definition.__code__, names, definition.__name__)(*args)


def _operation(trace: Trace, op: str) -> Callable[..., Any]:
    return lambda *args: trace.combine(op, *args)


def _is_negative(value: Any) -> bool:
    return isinstance(value, Value) and value.op == "neg"


def _positive_part(value: Any) -> Any:
    """x, if the value is ``x + |x|``, which may stand as ``|y| - y`` with y = -x."""
    if not isinstance(value, Value) or value.op not in ("+", "-"):
        return None
    for size, other in (value.args, value.args[::-1]) if value.op == "+" else (value.args,):
        if isinstance(size, Value) and size.op == "abs" and size.args[0] is other:
            return other if value.op == "+" else -other
    return None


def _simplified(op: str, args: tuple[Any, ...], numbers: Sequence[float | None]) -> Any:
    if op == "+" and 0.0 in numbers:
        return args[0] if numbers[1] == 0.0 else args[1]
    if op == "-" and numbers[1] == 0.0:
        return args[0]
    if op == "-" and numbers[0] == 0.0:
        return -args[1]
    if op == "neg" and _is_negative(args[0]):
        return args[0].args[0]
    if op == "*" and 0.0 in numbers:
        return 0.0
    if op in "*/" and numbers[1] == 1.0:
        return args[0]
    if op == "*" and numbers[0] == 1.0:
        return args[1]
    return None


def statements(results: Sequence[Any], level: int, names: dict[int, str], prefix: str) -> tuple[list[str], list[Value]]:
    """Assignments that compute ``results``, and the values of lower level that they need.

    ``names`` has the text for each value by ``id``; it is extended by the values computed here, called ``prefix`` and a number.
    Needed values that have no text yet are the second result, in the order of their first use.
    """
    lines: list[str] = []
    needed: list[Value] = []

    def text(value: Any) -> str:
        if not isinstance(value, Value):
            return repr(float(value))
        if id(value) not in names:
            if value.level < level or value.op == "input":
                needed.append(value)
                names[id(value)] = f"{prefix}_{len(needed)}"
            else:
                made = _TEXT[value.op].format(*[text(arg) for arg in value.args])
                name = f"{prefix}{len(lines)}"
                lines.append(f"{name} = {made}")
                names[id(value)] = name
        return names[id(value)]

    for result in results:
        text(result)
    return lines, needed


def evaluated(values: Sequence[Value], given: Mapping[str, Any]) -> list[Any]:
    """Constant values as numbers or arrays, from those of the inputs by name."""
    done: dict[int, Any] = {}
    with np.errstate(all="ignore"):
        return [_evaluated(value, given, done) for value in values]


def _evaluated(value: Any, given: Mapping[str, Any], done: dict[int, Any]) -> Any:
    """One of them; not a function inside `evaluated`, which would hold on to all arrays until the next garbage collection."""
    if not isinstance(value, Value):
        return value
    if id(value) not in done:
        done[id(value)] = (given[value.args[0]] if value.op == "input"
                           else _NUMPY[value.op](*[_evaluated(arg, given, done) for arg in value.args]))
    return done[id(value)]
