"""What the definition of an observer may be made of, checked on its text: the line at fault is named, with what to write there.

Proof, linearisation and compiled run take the same function, so it must be straight-line arithmetic: ``+ - * /``, whole powers,
``abs``, tuples, and calls of such functions in the same file or out of `imo_analysis.equations`.
"""

from __future__ import annotations

import ast
import types
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

from imo_analysis.errors import InputError

ALLOWED = "plain arithmetic: + - * /, whole powers, abs, tuples, and functions made of them"
HIGHEST_POWER = 64
_INSTEAD: dict[type[ast.AST], str] = {
    ast.If: "an if; write max(v, 0) as (v + abs(v))/2, as imo_analysis.equations.projection does",
    ast.IfExp: "an if; write max(v, 0) as (v + abs(v))/2, as imo_analysis.equations.projection does",
    ast.Compare: "a comparison; write max(v, 0) as (v + abs(v))/2, as imo_analysis.equations.projection does",
    ast.For: "a loop; write its turns out",
    ast.While: "a loop; write its turns out",
    ast.List: "a list; write a tuple, (a, b)",
    ast.ListComp: "a list; write a tuple, (a, b)",
    ast.GeneratorExp: "a loop; write its turns out",
    ast.Dict: "a dictionary; write a tuple, (a, b)",
}
_SUMS = (ast.Add, ast.Sub, ast.Mult, ast.Div)


def check(function: types.FunctionType, tree: ast.Module, place: str) -> None:
    """Refuse a function of a file, or one that it calls, that is not `ALLOWED`.

    Parameters
    ----------
    function : function
        Defined in the file, or in `imo_analysis.equations`: those are plain.
    tree : ast.Module
        The file's text.
    place : str
        The file's name for messages.

    Raises
    ------
    InputError
        With the line and what to write there.
    """
    defined = {one.name: one for one in tree.body if isinstance(one, ast.FunctionDef)}
    seen: set[str] = set()
    waiting = [function]
    while waiting:
        one = waiting.pop()
        if one.__module__.startswith("imo_analysis.equations."):
            continue
        name = one.__name__
        if one.__module__ != function.__module__ or name not in defined or one.__code__.co_freevars:
            raise InputError(f"{place}: {name} comes from {one.__module__} or is made by a call; write it into this file as "
                             "a def of its own: beside imo_analysis.equations an observer is one file")
        if name not in seen:
            seen.add(name)
            waiting += _checked(defined[name], one.__globals__, place)


def _checked(definition: ast.FunctionDef, names: dict[str, Any], place: str) -> Iterator[types.FunctionType]:
    """Check one definition; the functions that it calls."""

    def refuse(node: ast.AST, what: str) -> InputError:
        line = getattr(node, "lineno", definition.lineno)
        return InputError(f"{place}, line {line}: {definition.name} has {what}. An observer is {ALLOWED}")

    arguments = definition.args
    if definition.decorator_list or arguments.defaults or arguments.vararg or arguments.kwarg or arguments.kwonlyargs:
        raise refuse(definition, "a decorator, a default or starred arguments; write def name(a, b)")
    local = {argument.arg for argument in (*arguments.posonlyargs, *arguments.args)}
    local |= {node.id for node in ast.walk(definition) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    called: list[types.FunctionType] = []

    def expression(node: ast.expr) -> None:
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                pass
            case ast.Name(id=name) if name in local or _constant(names.get(name)):
                pass
            case ast.Name(id=name):
                raise refuse(node, f"{name}, which is neither an argument nor a number of this file")
            case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=inner):
                expression(inner)
            case ast.BinOp(left=left, op=ast.Pow(), right=power):
                if not (isinstance(power, ast.Constant) and type(power.value) is int and 1 <= power.value <= HIGHEST_POWER):
                    raise refuse(node, f"a power that is not a whole number from 1 to {HIGHEST_POWER}; write 1/x for x**-1")
                expression(left)
            case ast.BinOp(left=left, op=op, right=right) if isinstance(op, _SUMS):
                expression(left)
                expression(right)
            case ast.Tuple(elts=parts):
                for part in parts:
                    expression(part.value if isinstance(part, ast.Starred) else part)
            case ast.Subscript(value=inner, slice=at) if _whole(at):
                expression(inner)
            case ast.Call(func=ast.Name(id="abs"), args=[inner], keywords=[]) if "abs" not in names:
                expression(inner)
            case ast.Call(func=ast.Name(id=name), args=given, keywords=[]) if isinstance(names.get(name), types.FunctionType):
                if name in ("sqrt", "max", "min"):
                    raise refuse(node, f"a function called {name}; give it another name")
                called.append(names[name])
                for one in given:
                    expression(one)
            case ast.Call(func=function):
                raise refuse(node, f"{ast.unparse(function)}(...), which is no such function of this file or of "
                                   "imo_analysis.equations (from ... import NAME)")
            case _:
                raise refuse(node, _INSTEAD.get(type(node), ast.unparse(node)))

    body = definition.body
    for n, statement in enumerate(body):
        match statement:
            case ast.Expr(value=ast.Constant(value=str())):
                pass
            case ast.Assign(targets=targets, value=value) if all(map(_names, targets)):
                expression(value)
            case ast.AugAssign(target=ast.Name(), op=op, value=value) if isinstance(op, _SUMS):
                expression(value)
            case ast.Return(value=ast.expr() as value) if n == len(body) - 1:
                expression(value)
            case _:
                raise refuse(statement, _INSTEAD.get(type(statement), ast.unparse(statement).partition("\n")[0]))
    if not isinstance(body[-1], ast.Return):
        raise refuse(definition, "no return at its end")
    return iter(called)


def _constant(value: Any) -> bool:
    """Whether a name of the file stands for a number or a tuple of numbers."""
    if isinstance(value, tuple):
        return all(map(_constant, value))
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _names(target: ast.expr) -> bool:
    return isinstance(target, ast.Name) or (isinstance(target, ast.Tuple) and all(map(_names, target.elts)))


def _whole(at: ast.expr) -> bool:
    """Whether an index is a whole number, or a slice between such."""
    if isinstance(at, ast.Slice):
        return at.step is None and all(one is None or _whole(one) for one in (at.lower, at.upper))
    bare = at.operand if isinstance(at, ast.UnaryOp) and isinstance(at.op, ast.USub) else at
    return isinstance(bare, ast.Constant) and type(bare.value) is int


def exact(function: Callable[..., Any]) -> Callable[..., Any]:
    """The same definition with its decimal numbers as fractions, 0.1 as 1/10, so that exact arguments give exact results."""
    assert isinstance(function, types.FunctionType)
    code = function.__code__
    names = {name: function.__globals__[name] for name in code.co_names if name in function.__globals__}
    names = {name: exact(value) if isinstance(value, types.FunctionType) else _fraction(value) for name, value in names.items()}
    constants = tuple(_fraction(value) for value in code.co_consts)
    return types.FunctionType(code.replace(co_consts=constants), {**function.__globals__, **names}, function.__name__)


def _fraction(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(_fraction(one) for one in value)
    return Fraction(repr(value)) if isinstance(value, float) and abs(value) < float("inf") else value
