"""The dimension of a formula from the units of the notation table, and the subexpression at which it breaks."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import Expr, Name, Number, Op, Relation
from imo_analysis.notation import Dimension, symbol
from imo_analysis.notation import dimension as unit_dimension

_BASES = ("kg", "m", "s", "A")
_NONE: Dimension = (Fraction(0),) * 4


class UnitError(InputError):
    """Two parts of a formula that cannot be added or compared."""


def dimension_text(dimension: Dimension) -> str:
    """A dimension in words of base units, ``kg m^2/(s^2 A)``."""
    def part(wanted: int) -> list[str]:
        return [base if abs(power) == 1 else f"{base}^{abs(power)}"
                for base, power in zip(_BASES, dimension, strict=True) if power * wanted > 0]

    above, below = part(1), part(-1)
    if not below:
        return " ".join(above) or "1"
    under = below[0] if len(below) == 1 else f"({' '.join(below)})"
    return f"{' '.join(above) or '1'}/{under}"


def dimension_of(tree: Expr, units: Mapping[str, str] | None = None) -> Dimension | None:
    """The dimension of a tree; None for a literal zero, which fits anywhere.

    Parameters
    ----------
    tree : Expr
    units : mapping of str to str, optional
        Units of names that differ from, or are not in, the notation table.

    Raises
    ------
    UnitError
        With the subexpression at fault: ``adding A/s to A in ...``.
    """
    if isinstance(tree, Name):
        return unit_dimension((units or {}).get(tree.name) or symbol(tree.name).unit)
    if isinstance(tree, Number):
        return None if tree.value == 0 else _NONE
    assert isinstance(tree, Op)
    first = dimension_of(tree.args[0], units)
    if tree.kind in ("neg", "abs"):
        return first
    if tree.kind == "**":
        assert isinstance(tree.args[1], Number)
        power = tree.args[1].value
        return None if first is None else _map(first, first, lambda a, _: a * power)
    second = dimension_of(tree.args[1], units)
    if tree.kind in "+-":
        if first is not None and second is not None and first != second:
            word = "adding" if tree.kind == "+" else "subtracting"
            order = (second, "to", first) if tree.kind == "+" else (second, "from", first)
            raise UnitError(f"{word} {dimension_text(order[0])} {order[1]} {dimension_text(order[2])} in {tree}")
        return second if first is None else first
    if first is None or second is None:
        return None
    return _map(first, second, lambda a, b: a + b if tree.kind == "*" else a - b)


def _map(a: Dimension, b: Dimension, rule: object) -> Dimension:
    assert callable(rule)
    return (rule(a[0], b[0]), rule(a[1], b[1]), rule(a[2], b[2]), rule(a[3], b[3]))


def unit_faults(relation: Relation, units: Mapping[str, str] | None = None) -> list[str]:
    """What is dimensionally inconsistent in a relation; empty if nothing is."""
    try:
        left, right = dimension_of(relation.left, units), dimension_of(relation.right, units)
    except UnitError as error:
        return [str(error)]
    if left is not None and right is not None and left != right:
        return [f"{dimension_text(left)} on the left, {dimension_text(right)} on the right of {relation}"]
    return []
