"""What an exercise is and how an answer is judged: right, wrong with a hint, or not given yet (``...``).

The right answer is computed from the definitions when it is needed, never typed in. Every exercise lists wrong answers that
people give, each with the hint that it gets; the tests try them all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Protocol

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import Expr, Relation, free_names, parse, substitute
from imo_analysis.ledger.setting import Setting
from imo_analysis.quantity import si_value

LESSONS = 10


@dataclass(frozen=True)
class Outcome:
    """The judgement of an answer: ``right`` is None where none is given yet; ``text`` is what the student reads."""

    right: bool | None
    text: str


class Exercise(Protocol):
    """Anything that can judge an answer."""

    @property
    def id(self) -> str:
        """Lesson and number, such as ``"3.2"``."""

    def judge(self, answer: Any) -> Outcome:
        """Judge an answer that is not ``...``."""

    def wrong(self) -> list[tuple[Any, str]]:
        """Wrong answers, each with the hint that it must get."""


def exercises(lesson: int) -> tuple[Exercise, ...]:
    """All exercises of a lesson, in order."""
    return tuple(import_module(f"imo_analysis.exercises.lesson_{lesson:02d}").EXERCISES)


def exercise(identifier: str) -> Exercise:
    """The exercise of an id such as ``"3.2"``.

    Raises
    ------
    InputError
        If there is none.
    """
    lesson = identifier.partition(".")[0]
    if lesson.isdigit() and 1 <= int(lesson) <= LESSONS:
        for one in exercises(int(lesson)):
            if one.id == identifier:
                return one
        have = ", ".join(one.id for one in exercises(int(lesson)))
        raise InputError(f'check("{identifier}"): lesson {lesson} has the exercises {have}')
    raise InputError(f'check("{identifier}"): an exercise is named by lesson and number, such as "3.2"; lessons 1 to {LESSONS}')


def judge(identifier: str, answer: Any) -> Outcome:
    """Judge an answer; an answer that cannot be understood is wrong, and the text says why.

    Raises
    ------
    InputError
        If there is no such exercise.
    """
    one = exercise(identifier)
    if answer is Ellipsis:
        return Outcome(None, f"{identifier}: not answered yet.")
    try:
        outcome = one.judge(answer)
    except InputError as error:
        outcome = Outcome(False, str(error))
    except Exception as error:  # an answer may be a function of the student's, which can raise anything
        outcome = Outcome(False, f"this answer cannot be evaluated ({type(error).__name__}: {error}).")
    word = "right" if outcome.right else "not yet"
    return Outcome(outcome.right, f"{identifier}: {word}. {outcome.text}".strip())


@dataclass(frozen=True)
class Number:
    """A number with a unit, or several in order.

    Attributes
    ----------
    id : str
    truth : callable
        Returns the number, or a tuple of numbers.
    unit : str
        SI; text such as ``"8.8 mH"`` is taken too.
    mistakes : sequence of (callable, hint)
        Each callable makes the wrong answer from the true one.
    why : str
        Said with a right answer.
    hint : str
        Said where no known mistake fits.
    tolerance : float
        Relative to the largest of the numbers.
    """

    id: str
    truth: Callable[[], Any]
    unit: str
    mistakes: Sequence[tuple[Callable[[Any], Any], str]]
    why: str = ""
    hint: str = ""
    tolerance: float = 0.01

    def judge(self, answer: Any) -> Outcome:
        """Compare with the truth, then with the known mistakes."""
        truth = self._values(self.truth())
        given = self._values(answer)
        if len(given) != len(truth):
            return Outcome(False, f"{len(truth)} numbers are asked for, this is {len(given)}.")
        if not np.all(np.isfinite(given)):
            return Outcome(False, "a finite number is asked for.")
        if self._same(given, truth):
            return Outcome(True, self.why)
        for value, hint in self.wrong():
            if self._same(given, self._values(value)):
                return Outcome(False, hint)
        return Outcome(False, self.hint)

    def wrong(self) -> list[tuple[Any, str]]:
        """The declared mistakes, then what everyone may do: a sign, a prefix."""
        truth = self.truth()
        declared = [(make(truth), hint) for make, hint in self.mistakes]
        values = self._values(truth)
        common = [(-values, "The size is right; look at the sign."),
                  (1e3 * values, f"A factor of 1000 too large: is it in {self.unit}?"),
                  (1e-3 * values, f"A factor of 1000 too small: is it in {self.unit}?")]
        taken = [self._values(value) for value, _ in declared]
        return declared + [(tuple(map(float, value)), hint) for value, hint in common
                           if not any(self._same(value, one) for one in taken)]

    def _values(self, answer: Any) -> Any:
        many = isinstance(answer, Iterable) and not isinstance(answer, str) and np.ndim(answer) > 0  # type: ignore[arg-type]
        return np.array([self._value(one) for one in (np.ravel(np.array(answer, dtype=object)) if many else [answer])])

    def _value(self, one: Any) -> float:
        if isinstance(one, str):
            joined = self.unit.replace(" ", "")  # people write Nm
            return float(one) if self.unit == "1" else si_value(one.replace(joined, self.unit), self.unit, "the answer")
        if isinstance(one, bool):
            raise InputError("a number is asked for.")
        if isinstance(one, complex):  # numpy's would be made real in silence
            if one.imag:
                raise InputError("a real number is asked for, this is complex.")
            return float(one.real)
        return float(one)

    def _same(self, one: Any, other: Any) -> bool:
        return len(one) == len(other) and bool(np.max(np.abs(one - other)) <= self.tolerance * np.max(np.abs(other)))


@dataclass(frozen=True)
class Formula:
    """A formula, or several in order, in the names of the notation table; equal means equal as rational functions.

    Attributes
    ----------
    id : str
    truth : callable
        Returns a formula or a tuple of them: a tree, or text.
    where : callable
        Returns the setting, whose definitions may be used in an answer or written out.
    mistakes : sequence of (text or tuple of texts, hint)
    why, hint : str
        As for `Number`.
    """

    id: str
    truth: Callable[[], Any]
    where: Callable[[], Setting]
    mistakes: Sequence[tuple[Any, str]]
    why: str = ""
    hint: str = ""

    def judge(self, answer: Any) -> Outcome:
        """Compare with the truth exactly, then with the known mistakes."""
        where, truth, given = self.where(), self.right(), _trees(answer)
        if len(given) != len(truth):
            return Outcome(False, f"{len(truth)} formulas are asked for, this is {len(given)}.")
        known = {*where.definitions, *where.units, *(name for tree in truth for name in free_names(tree))}
        known |= set(where.free(*(Relation("=", tree, tree) for tree in truth)))
        strangers = sorted({name for tree in given for name in free_names(tree)} - known - _table())
        if strangers:
            return Outcome(False,
                f"{', '.join(strangers)}: no such symbol; the names are those of the text, such as i_ds_tilde.")
        if any(name.endswith("_dot") or name == "V" for tree in given for name in free_names(tree)):
            return Outcome(False, "Write it in signals and parameters: no rates, and no V.")
        if self._same(where, given, truth):
            return Outcome(True, self.why)
        for value, hint in self.wrong():
            if self._same(where, given, _trees(value)):
                return Outcome(False, hint)
        return Outcome(False, self.hint)

    def right(self) -> tuple[Expr, ...]:
        """The truth in free names alone."""
        return tuple(written_out(self.where(), tree) for tree in _trees(self.truth()))

    def wrong(self) -> list[tuple[Any, str]]:
        """The declared mistakes, and the negative."""
        negative = tuple(-tree for tree in self.right())
        declared = [_trees(value) for value, _ in self.mistakes]
        same = any(self._same(self.where(), negative, one) for one in declared)
        return [*self.mistakes, *([] if same else [(negative, "Only the sign is wrong.")])]

    @staticmethod
    def _same(where: Setting, given: tuple[Expr, ...], truth: tuple[Expr, ...]) -> bool:
        return len(given) == len(truth) and all(equal(where, a, b) for a, b in zip(given, truth, strict=True))


def written_out(where: Setting, tree: Expr) -> Expr:
    """A formula in free names alone: every name that a setting defines replaced by what it stands for."""
    for _ in range(len(where.definitions)):
        if not any(name in where.definitions for name in free_names(tree)):
            break
        tree = substitute(tree, where.definitions)
    return tree


def equal(where: Setting, a: Expr, b: Expr) -> bool:
    """Whether two formulas are equal as rational functions, in every case of a setting."""
    from imo_analysis.ledger.kernels import kernel
    from imo_analysis.ledger.question import Question

    return all(kernel("flint").answer([Question("equal", where, Relation("=", a, b), "identity")]))


def _trees(answer: Any) -> tuple[Expr, ...]:
    """Text, a tree, a sympy expression, a number, or a sequence of such, as trees."""
    if isinstance(answer, (list, tuple)):
        return tuple(tree for one in answer for tree in _trees(one))
    if isinstance(answer, str):
        return (parse(answer.replace("^", "**")),)
    if isinstance(answer, Expr):
        return (answer,)
    if isinstance(answer, int) and not isinstance(answer, bool):
        return (parse(str(answer)),)
    import sympy

    if isinstance(answer, sympy.Basic):
        from imo_analysis.ledger.audit import from_sympy

        return (from_sympy(answer),)
    raise InputError('a formula is asked for, as text such as "i_ds + beta*phi_dr" or as a sympy expression.')


def _table() -> set[str]:
    from imo_analysis.notation import SYMBOLS

    return {name + end for name in SYMBOLS for end in ("", "_hat", "_tilde", "_dot")}


@dataclass(frozen=True)
class Choice:
    """One answer out of some, or a set of them.

    Attributes
    ----------
    id : str
    right : callable
        Returns the right key, or the set of right keys.
    hints : mapping
        Each key that can be chosen, with what to say where it is chosen wrongly (or left out wrongly, with several).
    why : str
        Said with the right answer.
    """

    id: str
    right: Callable[[], Any]
    hints: Mapping[str, str]
    why: str = ""

    def judge(self, answer: Any) -> Outcome:
        """Compare as sets; the hint is that of the first key that is wrong."""
        right = _keys(self.right())
        given = _keys(answer)
        if strangers := sorted(given - set(self.hints)):
            return Outcome(False, f"{', '.join(strangers)}: choose from {', '.join(self.hints)}.")
        if given == right:
            return Outcome(True, self.why)
        if given and given < right:
            return Outcome(False, "What you chose is right, but there is more.")
        wrongly = [key for key in self.hints if key in given - right]
        return Outcome(False, self.hints[wrongly[0]] if wrongly else "Choose at least one.")

    def wrong(self) -> list[tuple[Any, str]]:
        """Every other key alone; with several right ones also too few of them, and each wrong one added to them."""
        right = _keys(self.right())
        others = [key for key in self.hints if key not in right]
        answers: list[tuple[Any, str]] = [(key, self.hints[key]) for key in others]
        if len(right) > 1:
            answers += [({*right, key}, self.hints[key]) for key in others]
            answers += [({key}, "there is more") for key in sorted(right)]
        return answers


def _keys(answer: Any) -> set[str]:
    return {answer} if isinstance(answer, str) else {str(one) for one in answer}


@dataclass(frozen=True)
class Judged:
    """An answer that has a property, where many are right: gains, a counterexample, a function.

    Attributes
    ----------
    id : str
    fault : callable
        Returns what is wrong with an answer, or an empty text.
    examples : sequence of (answer, hint)
        Wrong answers, with a piece of the text that each must get.
    why : str
        Said with a right answer.
    """

    id: str
    fault: Callable[[Any], str]
    examples: Sequence[tuple[Any, str]] = field(default_factory=tuple)
    why: str = ""

    def judge(self, answer: Any) -> Outcome:
        """Ask for the fault."""
        fault = self.fault(answer)
        return Outcome(not fault, fault or self.why)

    def wrong(self) -> list[tuple[Any, str]]:
        """The examples."""
        return list(self.examples)
