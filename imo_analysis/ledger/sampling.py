"""Exact rational points that satisfy the hypotheses, and from them a counterexample that is easy to check by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from random import Random

from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import Name, Number, Relation
from imo_analysis.ledger.setting import Setting, true_at

_TRIES = 4000


def points(setting: Setting, relations: Sequence[Relation], count: int, seed: int = 1,
           size: int = 30) -> list[dict[str, Fraction]]:
    """Random points of small integers at which the hypotheses hold and no denominator of the relations vanishes.

    Raises
    ------
    InputError
        If none is found: the hypotheses may contradict each other.
    """
    random = Random(seed)
    variables = setting.free(*relations)
    hypotheses = setting.hypotheses_for(variables)
    signs = {one.left.name: one.op for one in hypotheses
             if isinstance(one.left, Name) and isinstance(one.right, Number) and one.right.value == 0}
    found: list[dict[str, Fraction]] = []
    for attempt in range(_TRIES):
        case = setting.cases[attempt % len(setting.cases)]
        point = {}
        for name in variables:
            value = random.randint(1, size)
            negative = signs.get(name, "")[:1] == "<" or (signs.get(name, "")[:1] != ">" and random.random() < 0.5)
            point[name] = case.get(name, Fraction(-value if negative else value))
        if admits(setting, hypotheses, relations, point):
            found.append(point)
            if len(found) == count:
                return found
    if found:
        return found
    listed = ", ".join(map(str, hypotheses))
    raise InputError(f"setting {setting.name}: no point satisfies {listed}; do they contradict each other?")


def admits(setting: Setting, hypotheses: Sequence[Relation], relations: Sequence[Relation],
           point: Mapping[str, Fraction]) -> bool:
    """Whether the hypotheses hold at a point and the relations have values there."""
    values = setting.values(point)
    try:
        if not all(true_at(one, values) for one in hypotheses):
            return False
        for relation in relations:
            true_at(relation, values)
    except ZeroDivisionError:
        return False
    return True


def counterexample(setting: Setting, relation: Relation, tries: int = 40) -> dict[str, Fraction] | None:
    """A point at which the hypotheses hold and the relation does not, made as simple as it goes; None if none was met.

    Each value is replaced by 0, 1, -1 or 2 where the relation still fails, so that a person can follow the arithmetic.
    """
    hypotheses = setting.hypotheses_for(setting.free(relation))

    def breaks(point: Mapping[str, Fraction]) -> bool:
        return admits(setting, hypotheses, [relation], point) and not true_at(relation, setting.values(point))

    for point in points(setting, [relation], tries):
        if not breaks(point):
            continue
        fixed = {name for case in setting.cases for name in case}
        for name in point:
            if name in fixed:
                continue
            for simple in (0, 1, -1, 2):
                trial = {**point, name: Fraction(simple)}
                if breaks(trial):
                    point = trial
                    break
        return point
    return None
