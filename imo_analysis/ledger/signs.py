"""What the hypotheses say about the sign of a formula, by rules that can be checked at a glance.

Used for the weights of a sum of squares and for denominators: nothing is guessed, an unknown sign is an empty answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import Expr, Name, Number, Op, Relation, walk

# A sign is the set of what the value may be, out of negative, zero and positive.
Sign = frozenset[str]
ANY: Sign = frozenset("-0+")
_FROM_OP = {">": "+", ">=": "0+", "<": "-", "<=": "-0", "!=": "-+", "=": "0"}


class UndecidedSign(InputError):
    """An absolute value whose argument may have either sign."""


def sign(tree: Expr, hypotheses: Sequence[Relation], definitions: Mapping[str, Expr] | None = None) -> Sign:
    """The possible signs of a tree under hypotheses of the form ``formula op 0``."""
    definitions = definitions or {}
    facts = [
        (one.left, frozenset(_FROM_OP[one.op])) for one in hypotheses
        if isinstance(one.right, Number) and one.right.value == 0
    ]
    return _sign(tree, facts, definitions)


def _sign(tree: Expr, facts: list[tuple[Expr, Sign]], definitions: Mapping[str, Expr]) -> Sign:
    known = ANY
    for left, what in facts:
        if left == tree:
            known = known & what
    return known & _rule(tree, facts, definitions)


def _rule(tree: Expr, facts: list[tuple[Expr, Sign]], definitions: Mapping[str, Expr]) -> Sign:
    if isinstance(tree, Number):
        return frozenset("+" if tree.value > 0 else "-" if tree.value < 0 else "0")
    if isinstance(tree, Name):
        return _sign(definitions[tree.name], facts, definitions) if tree.name in definitions else ANY
    assert isinstance(tree, Op)
    first = _sign(tree.args[0], facts, definitions)
    if tree.kind == "neg":
        return _flip(first)
    if tree.kind == "abs":
        return frozenset("+" if one in "+-" else "0" for one in first)
    if tree.kind == "**":
        power = tree.args[1]
        assert isinstance(power, Number)
        if power.value == 0:
            return frozenset("+")
        return first if power.value % 2 else frozenset("+" if one in "+-" else "0" for one in first)
    second = _sign(tree.args[1], facts, definitions)
    if tree.kind in "*/":
        if tree.kind == "*" and tree.args[0] == tree.args[1]:
            return frozenset("+" if one in "+-" else "0" for one in first)
        return frozenset(_product(a, b) for a in first for b in second)
    return frozenset().union(*(_sum(a, b) for a in first for b in (second if tree.kind == "+" else _flip(second))))


def _flip(which: Sign) -> Sign:
    return frozenset({"+": "-", "-": "+", "0": "0"}[one] for one in which)


def _product(a: str, b: str) -> str:
    return "0" if "0" in (a, b) else "+" if a == b else "-"


def _sum(a: str, b: str) -> Sign:
    if a == b:
        return frozenset(a)
    if "0" in (a, b):
        return frozenset(b if a == "0" else a)
    return ANY


def nonnegative(tree: Expr, hypotheses: Sequence[Relation], definitions: Mapping[str, Expr] | None = None) -> bool:
    """Whether the hypotheses make the tree >= 0."""
    return "-" not in sign(tree, hypotheses, definitions)


def nonzero(tree: Expr, hypotheses: Sequence[Relation], definitions: Mapping[str, Expr] | None = None) -> bool:
    """Whether the hypotheses keep the tree away from zero."""
    return "0" not in sign(tree, hypotheses, definitions)


def without_abs(tree: Expr, hypotheses: Sequence[Relation], definitions: Mapping[str, Expr] | None = None) -> Expr:
    """The tree with every ``abs(x)`` replaced by ``x`` or ``-x``, as the hypotheses tell.

    Raises
    ------
    UndecidedSign
        If they do not tell; the claim then needs a case or a hypothesis.
    """
    if not isinstance(tree, Op):
        return tree
    args = tuple(without_abs(arg, hypotheses, definitions) for arg in tree.args)
    if tree.kind != "abs":
        return tree if all(a is b for a, b in zip(args, tree.args, strict=True)) else Op(tree.kind, args)
    possible = sign(tree.args[0], hypotheses, definitions)
    if "-" not in possible:
        return args[0]
    if "+" not in possible:
        return -args[0]
    raise UndecidedSign(f"abs({tree.args[0]}): its sign does not follow from the hypotheses; add one, or split into cases")


def uncovered_denominators(trees: Sequence[Expr], hypotheses: Sequence[Relation],
                           definitions: Mapping[str, Expr]) -> list[Expr]:
    """The denominators in some trees that the hypotheses do not keep away from zero."""
    found: list[Expr] = []
    for tree in trees:
        for node in walk(tree):
            if isinstance(node, Op):
                below = node.args[1] if node.kind == "/" else None
                if node.kind == "**" and isinstance(node.args[1], Number) and node.args[1].value < 0:
                    below = node.args[0]
                if below is not None and below not in found and not nonzero(below, hypotheses, definitions):
                    found.append(below)
    return found
