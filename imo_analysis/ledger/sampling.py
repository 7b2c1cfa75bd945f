"""Exact rational points that satisfy the hypotheses, and from them a counterexample that is easy to check by hand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import islice
from random import Random

from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import Name, Number, Relation
from imo_analysis.ledger.setting import Setting, true_at

_TRIES = 4000


def points(setting: Setting, relations: Sequence[Relation], count: int, seed: int = 1, size: int = 97,
           zeros: bool = False) -> list[dict[str, Fraction]]:
    """Random points of small integers at which the hypotheses hold and the relations have values, case after case.

    Without ``zeros`` no value of a free name is 0, so that no term is hidden by another.

    Raises
    ------
    InputError
        If none is found: the hypotheses may contradict each other.
    """
    return [point for point, _ in islice(_points(setting, relations, seed, size, zeros), count)]


def _points(setting: Setting, relations: Sequence[Relation], seed: int, size: int,
            zeros: bool) -> Iterator[tuple[dict[str, Fraction], bool]]:
    """Points, each with whether all relations are true there."""
    random = Random(seed)
    variables = setting.free(*relations)
    hypotheses = setting.hypotheses_for(variables)
    signs = {one.left.name: one.op for one in hypotheses
             if isinstance(one.left, Name) and isinstance(one.right, Number) and one.right.value == 0}
    # the signs of free names are met by construction
    others = [one for one in hypotheses if not (isinstance(one.left, Name) and one.left.name in variables
                                                and one.left.name in signs and signs[one.left.name] == one.op)]
    found = 0
    for attempt in range(_TRIES):
        case = setting.cases[attempt % len(setting.cases)]
        # every other round with small numbers and zeros: there hypotheses such as a < b < a + 1 are met sooner, and
        # inequalities fail sooner, than where every term is at work
        small = attempt // len(setting.cases) % 2 == 1
        largest = 9 if small else size
        point = {}
        for name in variables:
            value = 0 if zeros and small and name not in signs and random.random() < 0.5 else random.randint(1, largest)
            if signs.get(name) == "=":
                value = 0
            negative = signs.get(name, "")[:1] == "<" or (signs.get(name, "")[:1] != ">" and random.random() < 0.5)
            point[name] = case.get(name, Fraction(-value if negative else value))
        answer = truth(setting, others if not case else hypotheses, relations, point)
        if answer is not None:
            found += 1
            yield point, answer
    if not found:
        listed = ", ".join(map(str, hypotheses))
        raise InputError(f"setting {setting.name}: no point satisfies {listed}; do they contradict each other?")


def truth(setting: Setting, hypotheses: Sequence[Relation], relations: Sequence[Relation],
          point: Mapping[str, Fraction]) -> bool | None:
    """Whether all relations are true at a point; None where a hypothesis does not hold or a value does not exist."""
    values = setting.values(point)
    try:
        if not all(true_at(one, values) for one in hypotheses):
            return None
        answers = [true_at(one, values) for one in relations]  # all of them, since any may lack a value
        return all(answers)
    except ZeroDivisionError:
        return None


def counterexample(setting: Setting, relation: Relation, certified: bool = False) -> dict[str, Fraction] | None:
    """A point at which the hypotheses hold and the relation does not, made as simple as it goes; None if none was met.

    An equation that is not an identity fails at almost every point, so that two a case are enough to suspect one; an
    inequality is tried at more, unless it comes with a certificate of its own. Nothing rests on that: what is not refuted
    goes to the kernels to be proved.
    """
    hypotheses = setting.hypotheses_for(setting.free(relation))
    tries = (2 if relation.op == "=" else 12 if certified else 60) * len(setting.cases)
    for point, answer in islice(_points(setting, [relation], 1, 97, relation.op != "="), tries):
        if not answer:
            fixed = {name for case in setting.cases for name in case}
            return _simpler(setting, hypotheses, relation, point, [name for name in point if name not in fixed])
    return None


def _simpler(setting: Setting, hypotheses: Sequence[Relation], relation: Relation, point: dict[str, Fraction],
             names: Sequence[str]) -> dict[str, Fraction]:
    """The point with as many names as possible at 0, and the others at 1, -1 or 2, where the relation still fails."""
    if not names:
        return point
    signs = {one.left.name: one.op for one in hypotheses if isinstance(one.left, Name) and one.op in (">", "<", "!=")}
    simplest = {name: Fraction({">": 1, "!=": 1, "<": -1}.get(signs.get(name, ""), 0)) for name in names}
    trials = [simplest] if len(names) > 1 else [{names[0]: Fraction(value)} for value in (0, 1, -1, 2)]
    for trial in trials:
        if truth(setting, hypotheses, [relation], {**point, **trial}) is False:
            return {**point, **trial}
    if len(names) == 1:
        return point
    half = len(names) // 2
    point = _simpler(setting, hypotheses, relation, point, names[:half])
    return _simpler(setting, hypotheses, relation, point, names[half:])
