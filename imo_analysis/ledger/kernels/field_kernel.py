"""What the two field kernels share: the walk over cases, definitions and hypotheses. The arithmetic is each kernel's own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from imo_analysis.ledger.expression import Expr, Name, Number, Relation, evaluate, free_names, substitute
from imo_analysis.ledger.question import Question
from imo_analysis.ledger.setting import COMPARE, Setting
from imo_analysis.ledger.signs import UndecidedSign, nonnegative, uncovered_denominators, without_abs


class FieldKernel(ABC):
    """Settles questions in the field of rational functions over the rationals."""

    name: str

    @abstractmethod
    def field(self, names: Sequence[str]) -> tuple[Mapping[str, Any], Callable[[Fraction], Any]]:
        """The generators by name, and the map from rationals to constants."""

    @abstractmethod
    def equal(self, left: Any, right: Any) -> bool:
        """Whether two elements are the same."""

    @abstractmethod
    def rational(self, value: Fraction) -> Any:
        """A rational of this kernel's own arithmetic, with the order relations."""

    @abstractmethod
    def show(self, element: Any) -> str:
        """An element as a formula."""

    def answer(self, questions: Sequence[Question]) -> list[bool]:
        """For each question, whether it is confirmed."""
        spaces: dict[int, list[_Space]] = {}
        by_setting: dict[int, list[Question]] = {}
        for question in questions:
            by_setting.setdefault(id(question.setting), []).append(question)
        for key, group in by_setting.items():
            spaces[key] = self._spaces(group[0].setting, [tree for one in group for tree in _trees(one)])
        return [
            self._counterexample(one) if one.kind == "counterexample" else all(s.settles(one) for s in spaces[id(one.setting)])
            for one in questions
        ]

    def residual(self, setting: Setting, relation: Relation) -> list[str]:
        """``left - right`` as a formula in the free names, once a case; none where the sign of an ``abs`` is not known."""
        try:
            return [
                self.show(space.value(relation.left) - space.value(relation.right))
                for space in self._spaces(setting, [relation.left, relation.right])
            ]
        except UndecidedSign:
            return []

    def _spaces(self, setting: Setting, trees: Sequence[Expr]) -> list[_Space]:
        names = dict.fromkeys(setting.free(*(Relation("=", tree, Number(Fraction(0))) for tree in trees)))
        return [_Space(self, setting, case, list(names)) for case in setting.cases]

    def _counterexample(self, question: Question) -> bool:
        """Check the point in this kernel's own rationals: all hypotheses hold and the relation does not."""
        setting, relation = question.setting, question.relation
        assert question.point is not None
        point = {name: self.rational(value) for name, value in question.point.items()}
        values: dict[str, Any] = dict(point)
        try:
            for name in setting.used(relation, *setting.hypotheses):
                if name in values or not set(setting.free(Relation("=", Name(name), Name(name)))) <= set(point):
                    continue
                values[name] = evaluate(setting.definitions[name], values, self.rational)
            known = set(point)
            hypotheses = [one for one in setting.hypotheses if set(setting.free(one)) <= known]
            return (
                any(all(question.point.get(n, v) == v for n, v in case.items()) for case in setting.cases)
                and all(self._true(one, values) for one in hypotheses)
                and not self._true(relation, values)
            )
        except ZeroDivisionError:
            return False

    def _true(self, relation: Relation, values: Mapping[str, Any]) -> bool:
        left = evaluate(relation.left, values, self.rational)
        right = evaluate(relation.right, values, self.rational)
        return bool(COMPARE[relation.op](left, right))


def _trees(question: Question) -> list[Expr]:
    return [question.relation.left, question.relation.right, *(tree for s in question.squares for tree in (s.weight, s.base))]


class _Space:
    """One case of a setting in a kernel's field, with the values of names and subtrees kept."""

    def __init__(self, kernel: FieldKernel, setting: Setting, case: Mapping[str, Fraction], names: list[str]) -> None:
        self._kernel = kernel
        self._case = {name: Number(value) if value >= 0 else -Number(-value) for name, value in case.items()}
        self._generators, self._constant = kernel.field([name for name in names if name not in case])
        self._definitions = {name: self._in_case(tree) for name, tree in setting.definitions.items()}
        self._hypotheses = [
            Relation(one.op, self._in_case(one.left), self._in_case(one.right)) for one in setting.hypotheses
        ]
        self._values: dict[str, Any] = {}
        self._memo: dict[int, Any] = {}
        self._alive: list[Expr] = []  # the memo goes by id, so that the trees must outlive it

    def _in_case(self, tree: Expr) -> Expr:
        return substitute(tree, self._case) if self._case and not self._case.keys().isdisjoint(free_names(tree)) else tree

    def _look(self, name: str) -> Any:
        if name in self._generators:
            return self._generators[name]
        if name not in self._values:
            self._values[name] = self.value(self._definitions[name])
        return self._values[name]

    def value(self, tree: Expr) -> Any:
        """The tree as a field element."""
        tree = without_abs(self._in_case(tree), self._hypotheses, self._definitions)
        self._alive.append(tree)
        return evaluate(tree, self._look, self._constant, self._memo)

    def settles(self, question: Question) -> bool:
        """Whether an identity or a sum of squares is confirmed in this case.

        A denominator that vanishes, one in the squares that may vanish, and an ``abs`` of unknown sign are refusals.
        """
        relation = question.relation
        try:
            left, right = self.value(relation.left), self.value(relation.right)
            if question.kind == "identity":
                return relation.op == "=" and self._kernel.equal(left, right)
            if question.kind != "squares" or relation.op not in ("<=", ">="):
                return False
            total = right if relation.op == "<=" else left
            for square in question.squares:
                weight, base = self._in_case(square.weight), self._in_case(square.base)
                if not nonnegative(weight, self._hypotheses, self._definitions):
                    return False
                if uncovered_denominators([weight, base], self._hypotheses, self._definitions):
                    return False
                size = self.value(base)
                total = total - self.value(weight) * size * size
            return self._kernel.equal(total, left if relation.op == "<=" else right)
        except (ZeroDivisionError, UndecidedSign):
            return False
