"""Seeded faults in the definitions themselves: every token of ``equations/*.py`` changed in turn must be caught.

A mutant is caught when a function no longer meets its complex form (`complex_forms`) at exact random points. One that is not
caught must be proved equal to the original by tracing both and comparing them in FLINT; otherwise it is a survivor.
"""

from __future__ import annotations

import ast
import copy
import importlib
import inspect
import pkgutil
import re
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from random import Random
from types import ModuleType
from typing import Any

from imo_analysis import equations
from imo_analysis.ledger.complex_forms import FORMS
from imo_analysis.ledger.expression import Name, Relation, as_expr
from imo_analysis.ledger.form import Form, flat
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.mutations import renamed
from imo_analysis.ledger.question import Question
from imo_analysis.ledger.setting import setting

_NOT_EQUATIONS = ("catalogue", "observer", "own", "plain")  # names, look-ups, and files of the user: no formula


@dataclass
class DefinitionReport:
    """What became of the seeded faults."""

    modules: int = 0
    functions: int = 0
    tried: int = 0
    killed: int = 0
    equivalent: list[str] = field(default_factory=list)
    survived: list[str] = field(default_factory=list)
    unchecked: list[str] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def ok(self) -> bool:
        """Nothing survived, and every definition has a second form."""
        return not self.survived and not self.unchecked

    def text(self) -> str:
        """For a terminal."""
        lines = [f"definitions: {self.tried} single-token mutants of {self.functions} functions in "
                 f"{self.modules} modules; killed {self.killed}, "
                 f"equivalent {len(self.equivalent)}, survived {len(self.survived)} ({self.seconds:.1f} s)"]
        lines += [f"  equivalent, proved by FLINT: {one}" for one in self.equivalent]
        lines += [f"  SURVIVED {one}" for one in self.survived]
        return "\n".join([*lines, *(f"  NO SECOND FORM for {one}" for one in self.unchecked)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {key: value for key, value in vars(self).items() if key != "seconds"}


def try_definitions(forms: Sequence[Form] = FORMS, only: str | None = None) -> DefinitionReport:
    """Seed every single-token fault in every definition (or those of one module), and see that each is caught."""
    start = time.perf_counter()
    report = DefinitionReport()
    for info in pkgutil.iter_modules(equations.__path__):
        if info.name in _NOT_EQUATIONS or only not in (None, info.name):
            continue
        module = importlib.import_module(f"{equations.__name__}.{info.name}")
        mine = {form.function: form for form in forms if form.module == info.name}
        defined = [name for name, one in inspect.getmembers(module, inspect.isfunction) if one.__module__ == module.__name__]
        report.unchecked += [f"{info.name}.{name}" for name in defined if name not in mine]
        report.modules += 1
        report.functions += len(defined)
        for what, name, mutant in _mutants(module):
            if name not in mine:
                continue  # reported above
            report.tried += 1
            # the changed function first; then those of the same module that may call it
            order = [*(one for one in mine.values() if one.function == name), *mine.values()]
            if not all(form.meets(getattr(mutant, form.function), Random(5)) for form in order):
                report.killed += 1
            elif _equal(mine[name], getattr(module, name), getattr(mutant, name)):
                report.equivalent.append(f"{info.name}.{name}: {what}")
            else:
                report.survived.append(f"{info.name}.{name}: {what}")
    report.seconds = time.perf_counter() - start
    return report


def _equal(form: Form, original: Callable[..., Any], mutant: Callable[..., Any]) -> bool:
    """Whether two functions are the same in exact algebra, by tracing both on names."""
    count = 0

    def name() -> Name:
        nonlocal count
        count += 1
        return Name(f"a_{count}")

    arguments = [name() if size == 0 else tuple(name() for _ in range(size)) for size in form.shape]
    try:
        left, right = flat(original(*arguments)), flat(mutant(*arguments))
    except Exception:  # a mutant that cannot be traced is not proved equal
        return False
    where = setting("mutant", "a definition and its mutant")
    questions = [Question(f"row{n}", where, Relation("=", as_expr(a), as_expr(b)), "identity")
                 for n, (a, b) in enumerate(zip(left, right, strict=True)) if a != b]
    return all(kernel("flint").answer(questions))


def _mutants(module: ModuleType) -> Iterator[tuple[str, str, Any]]:
    """Each single-token change of a module, compiled: ``(words, function, namespace)``."""
    tree = ast.parse(inspect.getsource(module))
    for function in tree.body:
        if not isinstance(function, ast.FunctionDef):
            continue
        nodes = [node for node in ast.walk(function) if node is not function]
        known = {node.id for node in nodes if isinstance(node, ast.Name)}
        known |= {node.arg for node in nodes if isinstance(node, ast.arg)}
        for position, node in enumerate(nodes):
            for what, change in _changes(node, known):
                mutant = copy.deepcopy(function)
                change([one for one in ast.walk(mutant) if one is not mutant][position])
                body = [mutant if one is function else one for one in tree.body]
                whole = ast.fix_missing_locations(ast.Module(body=body, type_ignores=[]))
                space: dict[str, Any] = {"__name__": module.__name__}
                exec(compile(whole, f"<mutant of {module.__name__}>", "exec"), space)  # our own source, one token changed
                yield f"line {getattr(node, 'lineno', '?')}: {what}", function.name, _Namespace(space)


class _Namespace:
    def __init__(self, space: dict[str, Any]) -> None:
        self.__dict__.update(space)


_SWAPS: dict[type[ast.operator], tuple[type[ast.operator], ...]] = {
    ast.Add: (ast.Sub,), ast.Sub: (ast.Add,), ast.Mult: (ast.Div, ast.Add), ast.Div: (ast.Mult,), ast.Pow: (ast.Mult,)}
_SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
_PAIRS = ((re.compile("_d(?=_|$)"), "_q"), (re.compile("_q(?=_|$)"), "_d"))


def _changes(node: ast.AST, known: set[str]) -> Iterator[tuple[str, Callable[[Any], None]]]:
    """The changes that a token admits, each as a function that applies it to a copy of the node."""
    if isinstance(node, ast.BinOp):
        for operator in _SWAPS[type(node.op)]:
            words = f"{ast.unparse(node)[:60]}: {_SIGNS[type(node.op)]} to {_SIGNS[operator]}"
            yield words, _put("op", operator())
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield f"{ast.unparse(node)[:60]}: minus dropped", _put("op", ast.UAdd())
    elif isinstance(node, ast.Constant) and type(node.value) is int:
        for value in (node.value + 1, node.value - 1):
            yield f"constant {node.value} to {value}", _put("value", value)
    elif isinstance(node, ast.Name) and node.id in known:
        for other in _others(node.id):
            if other in known:
                yield f"name {node.id} to {other}", _put("id", other)


def _put(attribute: str, value: Any) -> Callable[[Any], None]:
    return lambda node: setattr(node, attribute, value)


def _others(name: str) -> list[str]:
    """Names that differ by axis, index, hat or tilde."""
    found = [other for _, other in renamed(name)]
    return found + [pattern.sub(new, name) for pattern, new in _PAIRS if pattern.search(name)]
