"""Formulas as immutable trees, in the order in which they are printed.

A tree is made in two ways: by running a plain definition of ``equations/`` on names (its operators build the tree: a
trace), or by `parse`, which reads a Python-syntax formula through a whitelist. `evaluate` walks a tree in any algebra:
fractions, ring elements, intervals, Coq text. Nothing here simplifies anything.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from imo_analysis.errors import InputError

LIMIT = 20_000  # characters of a formula; a longer one is a mistake, and deep nesting would exhaust the stack


class Expr:
    """A formula. ``+ - * /``, integer powers, ``abs`` and negation build larger ones; numbers may be mixed in."""

    __slots__ = ()

    def __add__(self, other: Any) -> Expr:
        return _binary("+", self, other)

    def __radd__(self, other: Any) -> Expr:
        return _binary("+", other, self)

    def __sub__(self, other: Any) -> Expr:
        return _binary("-", self, other)

    def __rsub__(self, other: Any) -> Expr:
        return _binary("-", other, self)

    def __mul__(self, other: Any) -> Expr:
        return _binary("*", self, other)

    def __rmul__(self, other: Any) -> Expr:
        return _binary("*", other, self)

    def __truediv__(self, other: Any) -> Expr:
        return _binary("/", self, other)

    def __rtruediv__(self, other: Any) -> Expr:
        return _binary("/", other, self)

    def __pow__(self, power: int) -> Expr:
        if not isinstance(power, int) or isinstance(power, bool):
            raise InputError(f"power {power!r}: only integer powers are formulas here")
        return Op("**", (self, Number(Fraction(power))))

    def __neg__(self) -> Expr:
        return Op("neg", (self,))

    def __pos__(self) -> Expr:
        return self

    def __abs__(self) -> Expr:
        return Op("abs", (self,))

    def __str__(self) -> str:
        return to_text(self)


@dataclass(frozen=True, slots=True, repr=False)
class Name(Expr):
    """A quantity by its name in the notation table, or a free name that a claim declares."""

    name: str


@dataclass(frozen=True, slots=True, repr=False)
class Number(Expr):
    """An exact rational."""

    value: Fraction


@dataclass(frozen=True, slots=True, repr=False)
class Op(Expr):
    """An operation: ``+ - * / **`` on two trees, ``neg`` and ``abs`` on one. The exponent is an integer `Number`."""

    kind: str
    args: tuple[Expr, ...]


def number(value: int | Fraction) -> Expr:
    """A number as a tree; a negative one as the negative of a positive one, as it is printed."""
    value = Fraction(value)
    return -Number(-value) if value < 0 else Number(value)


def as_expr(value: Any) -> Expr:
    """A tree as it is, an int or Fraction as a `Number`.

    Raises
    ------
    InputError
        For anything else: a float is not exact.
    """
    if isinstance(value, Expr):
        return value
    if isinstance(value, (int, Fraction)) and not isinstance(value, bool):
        return number(value)
    raise InputError(f"{value!r} in a formula: only names, integers and fractions are exact; write 1.5 as Fraction(3, 2)")


def _binary(kind: str, left: Any, right: Any) -> Expr:
    return Op(kind, (as_expr(left), as_expr(right)))


def names(*which: str) -> tuple[Name, ...]:
    """Names to feed to a plain definition; ``names("i_ds i_qs")`` and ``names("i_ds", "i_qs")`` are the same.

    Parameters
    ----------
    *which : str
        Names, parted by spaces.
    """
    return tuple(Name(one) for text in which for one in text.split())


@dataclass(frozen=True, slots=True)
class Relation:
    """``left op right`` with op one of ``=``, ``<=``, ``>=``, ``<``, ``>``, ``!=``."""

    op: str
    left: Expr
    right: Expr

    def __str__(self) -> str:
        return f"{to_text(self.left)} {self.op} {to_text(self.right)}"


# ---------------------------------------------------------------- reading

_BINARY = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}


def parse(text: str) -> Expr:
    """The tree of a formula in Python syntax: names, numbers, ``+ - * /``, ``**`` with an integer, ``abs()``, brackets.

    Decimals are read exactly: ``0.1`` is one tenth.

    Parameters
    ----------
    text : str
        The formula.

    Raises
    ------
    InputError
        For anything else, with the part that is not understood.
    """
    if len(text) > LIMIT:
        raise InputError(f"formula of {len(text)} characters: the limit is {LIMIT}; split it")
    try:
        body = ast.parse(text.strip(), mode="eval").body
        return _from_ast(body, text.strip())
    except SyntaxError as error:
        raise InputError(f"formula {_short(text)}: not a formula near column {error.offset or 1}") from None
    except (RecursionError, MemoryError):
        raise InputError(f"formula {_short(text)}: nested too deeply") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"formula {_short(text)}: {error}") from None


def _short(text: str) -> str:
    return repr(text if len(text) < 60 else text[:57] + "...")


def _from_ast(node: ast.AST, text: str) -> Expr:
    if isinstance(node, ast.Name):
        return Name(node.id)
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return Number(Fraction(ast.get_source_segment(text, node) or ""))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -_from_ast(node.operand, text)
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return Op(_BINARY[type(node.op)], (_from_ast(node.left, text), _from_ast(node.right, text)))
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        power, sign = node.right, 1
        if isinstance(power, ast.UnaryOp) and isinstance(power.op, ast.USub):
            power, sign = power.operand, -1
        if isinstance(power, ast.Constant) and type(power.value) is int and power.value <= 64:
            return _from_ast(node.left, text) ** (sign * power.value)
    if (
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "abs"
        and len(node.args) == 1 and not node.keywords
    ):
        return abs(_from_ast(node.args[0], text))
    part = ast.get_source_segment(text, node) or text
    raise InputError(
        f"formula {_short(text)}: cannot read {_short(part)}; allowed: names, numbers, + - * /, ** with an integer, abs()"
    )


def parse_relation(text: str) -> Relation:
    """``left = right``, or with ``<= >= < > !=``, both sides as in `parse`.

    Parameters
    ----------
    text : str
        The relation.

    Raises
    ------
    InputError
        If there is not exactly one relation sign.
    """
    for op in ("!=", "<=", ">=", "<", ">", "="):
        if op in text:
            left, _, right = text.partition(op)
            return Relation(op, parse(left), parse(right))
    raise InputError(f"relation {_short(text)}: no relation sign; write for example 'z_1 = i_ds + beta*phi_dr'")


# ---------------------------------------------------------------- walking


def evaluate(tree: Expr, env: Mapping[str, Any] | Callable[[str], Any], constant: Callable[[Fraction], Any] = lambda v: v,
             memo: dict[int, Any] | None = None) -> Any:
    """The value of a tree in any algebra.

    Parameters
    ----------
    tree : Expr
    env : mapping or callable
        The value of each name.
    constant : callable
        Turns a Fraction into the algebra's number.
    memo : dict, optional
        Values of subtrees by ``id``, kept between calls on trees that stay alive: a mutant shares most of its subtrees.
    """
    look = env if callable(env) else env.__getitem__

    def walk(node: Expr) -> Any:
        if isinstance(node, Name):
            return look(node.name)
        if isinstance(node, Number):
            return constant(node.value)
        if memo is not None and id(node) in memo:
            return memo[id(node)]
        assert isinstance(node, Op)
        first = walk(node.args[0])
        if node.kind == "neg":
            value = -first
        elif node.kind == "abs":
            value = abs(first)
        elif node.kind == "**":
            exponent = node.args[1]
            assert isinstance(exponent, Number)
            power = int(exponent.value)
            if power == 0:  # some algebras refuse 0**0
                value = constant(Fraction(1))
            else:
                value = first ** power if power > 0 else constant(Fraction(1)) / first ** (-power)
        else:
            second = walk(node.args[1])
            if node.kind == "+":
                value = first + second
            elif node.kind == "-":
                value = first - second
            elif node.kind == "*":
                value = first * second
            else:
                value = first / second
        if memo is not None:
            memo[id(node)] = value
        return value

    return walk(tree)


def substitute(tree: Expr, definitions: Mapping[str, Expr]) -> Expr:
    """The tree with defined names replaced, once: definitions are not searched again."""
    return evaluate(tree, lambda name: definitions.get(name) or Name(name), Number)


def free_names(tree: Expr) -> list[str]:
    """Names in the order of their first appearance."""
    seen: dict[str, None] = {}
    for node in walk(tree):
        if isinstance(node, Name):
            seen.setdefault(node.name)
    return list(seen)


def walk(tree: Expr) -> Iterator[Expr]:
    """Every subtree, the tree itself first, in printed order."""
    stack = [tree]
    while stack:
        node = stack.pop()
        yield node
        if isinstance(node, Op):
            stack.extend(reversed(node.args))


# ---------------------------------------------------------------- writing

_LEVEL = {"+": 1, "-": 1, "neg": 2, "*": 3, "/": 3, "**": 5, "abs": 9}


def _level(tree: Expr) -> int:
    """Binding strength; a product that begins with a minus binds as a negative does."""
    if isinstance(tree, Op):
        if tree.kind in "*/" and _level(tree.args[0]) == 2:
            return 2
        return _LEVEL[tree.kind]
    if isinstance(tree, Number) and tree.value.denominator != 1:
        return 3
    return 9


def to_text(tree: Expr) -> str:
    """The formula in the syntax that `parse` reads; ``parse(to_text(tree)) == tree`` for trees made by `parse`."""
    if isinstance(tree, Name):
        return tree.name
    if isinstance(tree, Number):
        return str(tree.value)
    assert isinstance(tree, Op)

    def put(child: Expr, least: int) -> str:
        return to_text(child) if _level(child) >= least else f"({to_text(child)})"

    first = tree.args[0]
    if tree.kind == "neg":
        return f"-{put(first, 4)}"
    if tree.kind == "abs":
        return f"abs({to_text(first)})"
    if tree.kind == "**":
        return f"{put(first, 9)}**{to_text(tree.args[1])}"
    if tree.kind in "+-":
        return f"{put(first, 1)} {tree.kind} {put(tree.args[1], 3)}"
    return f"{put(first, 2)}{tree.kind}{put(tree.args[1], 5)}"
