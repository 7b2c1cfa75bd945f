"""The slips that a printed formula can carry: each sign, coefficient, exponent, index, hat and tilde changed in turn."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import NamedTuple

from imo_analysis.ledger.expression import Expr, Name, Number, Op, Relation
from imo_analysis.notation import SYMBOLS

_TWO = Number(Fraction(2))
_TURNED = {"<=": ">=", ">=": "<=", "<": ">", ">": "<"}


class Mutation(NamedTuple):
    """A formula with one slip: what was changed, and the result."""

    what: str
    relation: Relation


def mutations(relation: Relation, known: Callable[[str], bool]) -> list[Mutation]:
    """Every single slip of a relation, without repetition and without the relation itself.

    Parameters
    ----------
    relation : Relation
    known : callable
        Whether a name means something where the relation is settled; other names would be rejected too easily.
    """
    seen = {str(relation)}
    found: list[Mutation] = []

    def add(what: str, changed: Relation) -> None:
        text = str(changed)
        if text not in seen:
            seen.add(text)
            found.append(Mutation(what, changed))

    if relation.op in _TURNED:
        add("direction", Relation(_TURNED[relation.op], relation.left, relation.right))
    for what, left in _changed(relation.left, known, True):
        add(f"left: {what}", Relation(relation.op, left, relation.right))
    for what, right in _changed(relation.right, known, True):
        add(what, Relation(relation.op, relation.left, right))
    return found


def _changed(tree: Expr, known: Callable[[str], bool], term: bool) -> Iterator[tuple[str, Expr]]:
    """The tree with one slip. ``term``: it stands where it could carry a coefficient of its own."""
    if term and not (isinstance(tree, Op) and tree.kind in ("+", "-", "neg")):
        if not isinstance(tree, Number):
            yield f"coefficient 1 of {tree} to 2", _TWO * tree
        if not (isinstance(tree, Number) and tree.value == 0):
            yield f"sign of {tree}", -tree
    if isinstance(tree, Number):
        yield f"coefficient {tree.value} to {tree.value + 1}", Number(tree.value + 1)
        if tree.value != 1:
            yield f"coefficient {tree.value} to {tree.value - 1}", Number(tree.value - 1)
        return
    if isinstance(tree, Name):
        yield f"exponent 1 of {tree.name} to 2", tree**2
        for what, name in renamed(tree.name):
            if known(name):
                yield f"{what} of {tree.name}: {name}", Name(name)
        return
    assert isinstance(tree, Op)
    if tree.kind in "+-":
        yield f"sign before {tree.args[1]}", Op("-" if tree.kind == "+" else "+", tree.args)
        yield from (((what, Op(tree.kind, (a, tree.args[1]))) for what, a in _changed(tree.args[0], known, True)))
        yield from (((what, Op(tree.kind, (tree.args[0], b))) for what, b in _changed(tree.args[1], known, True)))
    elif tree.kind == "neg":
        yield f"sign of {tree.args[0]}", tree.args[0]
        yield from ((what, -a) for what, a in _changed(tree.args[0], known, True))
    elif tree.kind == "**":
        base, power = tree.args
        assert isinstance(power, Number)
        for new in (power.value + 1, power.value - 1):
            yield f"exponent {power.value} of {base} to {new}", base ** int(new)
        inner = ((what, a) for what, a in _changed(base, known, False) if not what.startswith("exponent 1 "))
        yield from ((what, Op("**", (a, power))) for what, a in inner)
    elif tree.kind == "abs":
        yield f"absolute value of {tree.args[0]}", tree.args[0]
        yield from ((what, abs(a)) for what, a in _changed(tree.args[0], known, False))
    else:
        first, second = tree.args
        yield from ((what, Op(tree.kind, (a, second))) for what, a in _changed(first, known, False))
        yield from ((what, Op(tree.kind, (first, b))) for what, b in _changed(second, known, tree.kind == "/"))


_AXES = ((re.compile(r"(?<=_)ds(?=_|$)"), "qs"), (re.compile(r"(?<=_)qs(?=_|$)"), "ds"),
         (re.compile(r"(?<=_)dr(?=_|$)"), "qr"), (re.compile(r"(?<=_)qr(?=_|$)"), "dr"))
_DIGIT = re.compile(r"^([A-Za-z]+)_(\d)(?=_|$)")


def renamed(name: str) -> list[tuple[str, str]]:
    """The names that a slip of index, hat or tilde makes of a name."""
    found = [("axis", pattern.sub(other, name)) for pattern, other in _AXES if pattern.search(name)]
    digit = _DIGIT.match(name)
    if digit:
        found += [("index", f"{digit[1]}_{other}{name[digit.end():]}") for other in "123" if other != digit[2]]
    base, rate = name.removesuffix("_dot"), "_dot" if name.endswith("_dot") else ""
    if base.endswith("_hat"):
        found += [("hat", base[:-4] + rate), ("hat to tilde", f"{base[:-4]}_tilde{rate}")]
    elif base.endswith("_tilde"):
        found += [("tilde", base[:-6] + rate), ("tilde to hat", f"{base[:-6]}_hat{rate}")]
    elif base in SYMBOLS:
        found += [("hat", f"{base}_hat{rate}"), ("tilde", f"{base}_tilde{rate}")]
    return [(what, other) for what, other in found if other != name]
