"""LaTeX of the definitions: a plain function is run on names of the notation table, and what comes out is typeset.

No formula of the manual is typed: a page names a function, and the function itself writes its equations.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS, Observer
from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import Expr, Name, Number, Op, as_expr, number, parse
from imo_analysis.ledger.latex import name_latex, to_latex

SHORT = ("projection", "share", "gate")  # helpers that the observers show by their sign
WIDTH = 62  # how many signs fit on a line of a page

# helper functions that a formula shows by their sign, not written out: name -> sign
SIGNS = {
    "projection": r"\mathrm{Proj}",
    "share": "c",
    "gate": "G",
    "alpha_signal": r"\rho_{\alpha}",
    "speed_signal": r"\rho_{\omega}",
}


def find(place: str) -> Callable[..., Any]:
    """The function at ``package.module:name``.

    Raises
    ------
    InputError
        If there is none.
    """
    module, _, name = place.partition(":")
    found = getattr(import_module(module), name, None)
    if not callable(found):
        raise InputError(f"{place} is not a function of a definition module; write imo_analysis.equations.MODULE:NAME")
    return found


def equations(function: Callable[..., Any], given: Mapping[str, str], left: Sequence[str] = (),
              short: Sequence[str] = ()) -> list[str]:
    """LaTeX of each component that a definition returns.

    Parameters
    ----------
    function : callable
        A plain function of scalars and tuples of scalars.
    given : mapping of str to str
        For an argument that is not a symbol of its own name, what it is: names or formulas, parted by spaces.
    left : sequence of str
        Names of what is returned, for the left sides.
    short : sequence of str
        Helpers among `SIGNS` to show by their sign.

    Raises
    ------
    InputError
        If the arguments do not fit.
    """
    values = {name: _value(name, given) for name in inspect.signature(function).parameters}
    unknown = set(given) - set(values)
    if unknown:
        raise InputError(f"{function.__name__} has no argument {', '.join(sorted(unknown))}")
    shown: dict[str, str] = {}
    with _shown(short, shown):
        found = function(**values)
    rows = [_plain(as_expr(one)) for one in _flat(found)]
    if left and len(left) != len(rows):
        raise InputError(f"{function.__name__} returns {len(rows)} components, and {len(left)} names were given")
    heads = [name_latex(one) for one in left] or [""] * len(rows)
    return [_put_back(_row(head, row), shown) for head, row in zip(heads, rows, strict=True)]


def with_sign(rows: Sequence[str], sign: str, columns: int) -> str:
    """One formula ``sign = ...`` of the rows that `equations` gives, as a matrix of this many columns if there are several.

    Raises
    ------
    InputError
        If they do not fill it.
    """
    if len(rows) % columns:
        raise InputError(f"{len(rows)} components do not fill rows of {columns}")
    if len(rows) == 1:
        return f"{sign} = {rows[0]}"
    body = r" \\ ".join(" & ".join(rows[start : start + columns]) for start in range(0, len(rows), columns))
    return rf"{sign} = \begin{{pmatrix}}{body}\end{{pmatrix}}"


# the paper's number of a row: by the observer's source and the state, the rest of the states under ""
NUMBERS = {
    "(2)-(4)": {"omega_hat": "(4)", "": "(2), (3)"},
    "(7), (11)": {"omega_hat": "(11)", "": "(7)"},
    "(8)-(11)": {"alpha_hat": "(9), (10)", "omega_hat": "(11)", "": "(8)"},
}


def observer_equations(name: str) -> tuple[str, list[tuple[str, str]]]:
    """The observer of the catalogue that this one is made from, or none, and the rates that differ from it: LaTeX and number.

    The rates of that other observer stand in brackets with its name.
    """
    one: Observer = OBSERVERS[name]
    here = _module(one)
    used = [other for other, its in OBSERVERS.items() if vars(here).get(other) is its.rates and _module(its) is not here]
    base = used[0] if used else ""
    given = {"x": " ".join(one.states), "i": "i_ds i_qs", "u": "u_ds u_qs", "p": " ".join(PARAMETERS),
             "gains": " ".join(one.gains)}
    names = [f"{state}_dot" for state in one.states]
    rows = equations(one.rates, given, names, (*SHORT, *([base] if base else ())))
    numbers = NUMBERS.get(one.source, {})
    return base, [(row, numbers.get(name.removesuffix("_dot"), numbers.get("", "")))
                  for name, row in zip(names, rows, strict=True) if row != f"{name_latex(name)} = {_bracketed(name, base)}"]


def _module(one: Observer) -> Any:
    return sys.modules[one.rates.__module__]


def _bracketed(name: str, base: str) -> str:
    return rf"\left[{name_latex(name)}\right]_{{\mathrm{{{base}}}}}"


def _value(name: str, given: Mapping[str, str]) -> Any:
    if name not in given:
        return Name(name)
    parts = tuple(parse(part) for part in given[name].split())
    return parts if len(parts) > 1 else parts[0]


def _flat(found: Any) -> Iterator[Any]:
    if isinstance(found, tuple):
        for one in found:
            yield from _flat(one)
    else:
        yield found


@contextmanager
def _shown(short: Sequence[str], shown: dict[str, str]) -> Iterator[None]:
    """Put a sign in the place of each helper, in every module of the definitions that uses it, for a while."""
    changed: list[tuple[Any, str, Any]] = []
    for name in short:
        for module in [one for key, one in sys.modules.items() if key.startswith("imo_analysis.equations.")]:
            if inspect.isfunction(getattr(module, name, None)):
                changed.append((module, name, getattr(module, name)))
    try:
        for module, name, _ in changed:
            setattr(module, name, _rates_of(name, shown) if name in OBSERVERS else _stand_in(name, shown))
        yield
    finally:
        for module, name, function in changed:
            setattr(module, name, function)


def _rates_of(name: str, shown: dict[str, str]) -> Callable[..., tuple[Expr, ...]]:
    """An observer whose rates are only named."""

    def rates(*_: Any) -> tuple[Expr, ...]:
        return tuple(_kept(_bracketed(f"{state}_dot", name), shown) for state in OBSERVERS[name].states)

    return rates


def _kept(latex: str, shown: dict[str, str]) -> Name:
    key = f"shown{len(shown)}x"
    shown[key] = latex
    return Name(key)


def _stand_in(name: str, shown: dict[str, str]) -> Callable[..., Expr]:
    sign = SIGNS[name]

    def written(*arguments: Any) -> Expr:
        latex = sign
        if name in ("projection", "gate"):
            said = arguments[:2] if name == "projection" else arguments[:1]
            latex = rf"{sign}\left({', '.join(to_latex(_plain(as_expr(one))) for one in said)}\right)"
        return _kept(latex, shown)

    return written


def _put_back(latex: str, shown: Mapping[str, str]) -> str:
    for key in reversed(list(shown)):  # one may stand inside a later one
        latex = latex.replace(rf"\mathrm{{{key}}}", shown[key])
    return latex


def _row(head: str, tree: Expr) -> str:
    """``head = terms`` on as many lines as it takes."""
    lines: list[list[str]] = [[]]
    width = len(_signs(head)) + 2
    for sign, term in _terms(tree):
        piece = to_latex(term)
        if sign == "-" and isinstance(term, Op) and term.kind in ("+", "-"):
            piece = rf"\left({piece}\right)"
        elif sign == "+" and piece.startswith("-"):
            sign, piece = "-", piece[1:]
        if lines[-1] and width + len(_signs(piece)) > WIDTH:
            lines.append([])
            width = 3
        width += len(_signs(piece)) + 2
        first = len(lines) == 1 and not lines[-1]
        lines[-1].append(piece if first and sign == "+" else f"{sign} {piece}")
    texts = [" ".join(one) for one in lines]
    start = f"{head} &= " if head else "& "
    if len(texts) == 1:
        return f"{head} = {texts[0]}" if head else texts[0]
    body = r" \\ ".join([start + texts[0], *(rf"& \quad {one}" for one in texts[1:])])
    return rf"\begin{{aligned}}{body}\end{{aligned}}"


def _plain(tree: Expr) -> Expr:
    """Without factors of one and terms of zero, which stand where a definition is run on a number."""
    if not isinstance(tree, Op):
        return tree
    args = tuple(_plain(one) for one in tree.args)
    kind = tree.kind
    values = [one.value if isinstance(one, Number) else None for one in args]
    if kind == "*" and 0 in values:
        return number(0)
    if kind in ("*", "/") and values[1] == 1:
        return args[0]
    if kind == "*" and values[0] == 1:
        return args[1]
    if (kind == "/" and values[0] == 0) or (kind == "neg" and values[0] == 0):
        return number(0)
    if kind in ("+", "-") and values[1] == 0:
        return args[0]
    if kind == "+" and values[0] == 0:
        return args[1]
    if kind == "-" and values[0] == 0:
        return -args[1]
    return Op(kind, args)


def _terms(tree: Expr, sign: str = "+") -> Iterator[tuple[str, Expr]]:
    """The terms of the outermost sum, in their printed order."""
    if isinstance(tree, Op) and tree.kind in ("+", "-") and sign == "+":
        yield from _terms(tree.args[0])
        yield tree.kind, tree.args[1]
    elif isinstance(tree, Op) and tree.kind == "neg" and sign == "+" and not isinstance(tree.args[0], Op):
        yield "-", tree.args[0]
    else:
        yield sign, tree


def _signs(latex: str) -> str:
    """What is seen of it, roughly: a fraction is as wide as its longer part."""
    for _ in range(4):
        latex = re.sub(r"\\frac\{([^{}]*)\}\{([^{}]*)\}", lambda found: max(found[1], found[2], key=len), latex)
        latex = re.sub(r"\\(?:hat|dot|tilde|mathrm|bar)\{([^{}]*)\}", r"\1", latex)
    latex = re.sub(r"\\(?:left|right|quad)", "", latex)
    return re.sub(r"\\[A-Za-z]+", "x", latex).translate(str.maketrans("", "", "{}_^ "))
