"""Formulas typeset as printed: symbols of the notation table, fractions built up, hats, tildes and dots in place."""

from __future__ import annotations

from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import Expr, Name, Number, Op, Relation
from imo_analysis.notation import symbol

_GREEK = ("psi", "phi", "xi", "rho", "kappa", "lambda", "theta", "tau", "zeta", "eta")
_SIGNS = {"=": "=", "<=": r"\le", ">=": r"\ge", "<": "<", ">": ">", "!=": r"\ne"}


def name_latex(name: str) -> str:
    """The symbol of a name; a name outside the table is set upright, its parts as subscript."""
    try:
        return symbol(name).latex
    except InputError:
        for suffix, accent in (("_dot", r"\dot"), ("_hat", r"\hat"), ("_tilde", r"\tilde")):
            if name.endswith(suffix):
                head, mark, rest = name_latex(name.removesuffix(suffix)).partition("_")
                return f"{accent}{{{head}}}{mark}{rest}"
        head, _, rest = name.partition("_")
        head = head if len(head) == 1 else rf"\{head}" if head in _GREEK else rf"\mathrm{{{head}}}"
        return f"{head}_{{{rest.replace('_', ',')}}}" if rest else head


def to_latex(tree: Expr) -> str:
    """LaTeX of a tree, in its printed order.

    Parameters
    ----------
    tree : Expr
        The formula.
    """
    return _set(tree)[0]


def relation_latex(relation: Relation) -> str:
    """LaTeX of a relation.

    Parameters
    ----------
    relation : Relation
        Two formulas and the sign between them.
    """
    return f"{to_latex(relation.left)} {_SIGNS[relation.op]} {to_latex(relation.right)}"


def _bracket(text: str, level: int, least: int) -> str:
    return text if level >= least else rf"\left({text}\right)"


def _set(tree: Expr) -> tuple[str, int]:
    """LaTeX and binding strength: 1 sum, 2 negative, 3 product, 9 closed."""
    if isinstance(tree, Name):
        return name_latex(tree.name), 9
    if isinstance(tree, Number):
        value = tree.value
        return (str(value), 9) if value.denominator == 1 else (rf"\frac{{{value.numerator}}}{{{value.denominator}}}", 4)
    assert isinstance(tree, Op)
    first, level = _set(tree.args[0])
    if tree.kind == "neg":
        return f"-{_bracket(first, level, 3)}", 2
    if tree.kind == "abs":
        return rf"\left|{first}\right|", 9
    if tree.kind == "**":
        return f"{_bracket(first, 9 if not isinstance(tree.args[0], Op) else 0, 9)}^{{{tree.args[1]}}}", 9
    second, other = _set(tree.args[1])
    if tree.kind == "/":
        minus = "-" if level == 2 else ""
        return rf"{minus}\frac{{{first.removeprefix('-') if minus else first}}}{{{second}}}", 2 if minus else 4
    if tree.kind == "*":
        words = any(part.startswith(r"\mathrm") for part in (first.rpartition(" ")[2], second))
        gap = r" \cdot " if isinstance(tree.args[1], Number) else r" \, " if words else " "
        return f"{_bracket(first, level, 2)}{gap}{_bracket(second, other, 3)}", 2 if level == 2 else 3
    return f"{first} {tree.kind} {_bracket(second, other, 3)}", 1
