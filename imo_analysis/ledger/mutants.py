"""Checks that can fail: every claim that is true is run on all single slips of its formulas, and must reject each unequal one.

Which slips are unequal is decided without any kernel, by exact fractions at points where the hypotheses hold: a difference
at one point is a proof. The other slips must be confirmed as true by every kernel: they are the equivalent ones.

Of an inequality, a slip that is false at a point is told from one that may still be true: there only the certificate, the
sum of squares, no longer fits. Where a statement has cases, a slip that shows in one case only is tried for each of them.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

from imo_analysis.ledger.claim import Claim
from imo_analysis.ledger.expression import Expr, Name, Relation, as_expr, evaluate
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.mutations import Mutation, mutations
from imo_analysis.ledger.question import Kernel, Question
from imo_analysis.ledger.sampling import points
from imo_analysis.ledger.setting import COMPARE, Setting
from imo_analysis.ledger.settle import plan

_POINTS = 4  # for an equation: a slip differs from it almost everywhere, but small numbers make 0 and 1 now and then
_TRIES = 24  # for an inequality, which a slip may leave true almost everywhere


@dataclass(frozen=True, eq=False)
class Mutant:
    """A slip of a true statement.

    Attributes
    ----------
    question : Question
        The statement with the slip, put as the true one was.
    original : Question
    what : str
        The slip in words.
    point : mapping or None
        Where the two differ, in exact fractions; None if they agree at every point that was tried.
    refuted : bool
        Whether the slip is false at the point. An equation that differs is; an inequality that differs may still be true.
    """

    question: Question
    original: Question
    what: str
    point: Mapping[str, Fraction] | None
    refuted: bool = False

    def __str__(self) -> str:
        return f"{self.original.id}: {self.what}: {self.question.relation}"


@dataclass
class MutantReport:
    """What became of the mutants, kernel by kernel.

    Attributes
    ----------
    claims, tried : int
        How many true formulas, and how many slips of them.
    rejected : dict of str to int
        How many each kernel rejected.
    equivalent, missed : list of str
        Slips that change nothing, and those that a kernel took for true.
    certificates : int
        How many of the rejected are inequalities not refuted at a point.
    seconds : float
        Time taken.
    """

    claims: int = 0
    tried: int = 0
    rejected: dict[str, int] = field(default_factory=dict)
    equivalent: list[str] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)
    certificates: int = 0
    seconds: float = 0.0

    @property
    def ok(self) -> bool:
        """None missed, and some tried."""
        return not self.missed

    def text(self) -> str:
        """For a terminal."""
        lines = [f"mutants: {self.tried} of {self.claims} true formulas tried; rejected by "
                 + ", ".join(f"{name} {count}" for name, count in self.rejected.items())
                 + f"; equivalent {len(self.equivalent)}; missed {len(self.missed)} ({self.seconds:.1f} s)"]
        if self.certificates:
            lines.append(f"  {self.certificates} of the rejected are inequalities not refuted at a point: they may be true, "
                         "and only their sum of squares no longer fits")
        lines += [f"  equivalent, residual 0: {one}" for one in self.equivalent]
        return "\n".join([*lines, *(f"  MISSED {one}" for one in self.missed)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {"claims": self.claims, "tried": self.tried, "rejected": self.rejected,
                "equivalent": self.equivalent, "missed": self.missed, "certificates": self.certificates}


def try_mutants(claims: Iterable[Claim], kernels: Sequence[str | Kernel]) -> MutantReport:
    """Run every slip of every true formula through the kernels.

    Parameters
    ----------
    claims : iterable of Claim
        Those whose formulas are varied.
    kernels : sequence of str or Kernel
        Each must reject every mutant that is not equal.
    """
    start = time.perf_counter()
    true = [one.question for claim in claims if claim.mutate for one in plan(claim)[0]
            if one.role in ("printed", "corrected") and one.question.kind != "counterexample"]
    mutants = [mutant for question in true for mutant in of_question(question)]
    report = MutantReport(claims=len(true), tried=len(mutants))
    unequal = [one for one in mutants if one.point is not None]
    equal = [one for one in mutants if one.point is None]
    report.certificates = sum(not one.refuted for one in unequal)
    doubtful: dict[str, int] = {}
    for which in kernels:
        one = kernel(which) if isinstance(which, str) else which
        accepted = _accepted(one, unequal)
        report.rejected[one.name] = len(unequal) - len(accepted)
        report.missed += [f"by {one.name}: {unequal[number]}" for number in accepted]
        for mutant, confirmed in zip(equal, one.answer([m.question for m in equal]) if equal else [], strict=True):
            doubtful[str(mutant)] = doubtful.get(str(mutant), 0) + confirmed
    for text, confirmed_by in doubtful.items():
        if confirmed_by == len(kernels):
            report.equivalent.append(text)
        else:
            report.missed.append(f"equal at {_POINTS} points, but confirmed by {confirmed_by} of {len(kernels)}: {text}")
    report.seconds = time.perf_counter() - start
    return report


def of_question(question: Question) -> list[Mutant]:
    """The mutants of a true statement, each with a point at which it differs from the original."""
    setting, relation = question.setting, question.relation
    meaningful = set(setting.definitions) | set(_all_free(setting, relation))
    slips = mutations(relation, meaningful.__contains__)
    if not slips:
        return []
    slips += _in_one_case(relation, setting.cases)
    places = _places(setting, Relation("=", relation.left, relation.right), _POINTS if relation.op == "=" else _TRIES)
    known = [setting.values(place) for place in places]
    originals = [_difference(relation, values, {}) for values in known]
    memos: list[dict[int, Any]] = [{} for _ in places]
    found = []
    for number, slip in enumerate(slips):
        point, refuted = None, False
        for place, values, original, memo in zip(places, known, originals, memos, strict=True):
            difference = _difference(slip.relation, values, memo)
            if difference is not None and original is not None and not COMPARE[slip.relation.op](difference, 0):
                point, refuted = place, True
                break
            if difference != original and point is None:
                point = place
        changed = Question(f"{question.id}.m{number}", setting, slip.relation, question.kind, squares=question.squares)
        found.append(Mutant(changed, question, slip.what, point, refuted))
    return found


def _in_one_case(relation: Relation, cases: Sequence[Mapping[str, Fraction]]) -> list[Mutation]:
    """For each of several cases the relation with a term added that is zero in all other cases."""
    found = []
    for case in cases if len(cases) > 1 else ():
        gap: Expr = as_expr(1)
        for other in cases:
            if other is not case:
                away: Expr = as_expr(0)
                for name, value in other.items():
                    away = away + (Name(name) - value) ** 2
                gap = gap * away
        words = ", ".join(f"{name} = {value}" for name, value in case.items())
        found.append(Mutation(f"in the case {words} only", Relation(relation.op, relation.left + gap, relation.right)))
    return found


def _difference(relation: Relation, values: Mapping[str, Fraction], memo: dict[int, Any]) -> Fraction | None:
    """``left - right`` at a point, None where it has no value."""
    try:
        return Fraction(evaluate(relation.left, values, memo=memo)) - evaluate(relation.right, values, memo=memo)
    except ZeroDivisionError:
        return None


def _all_free(setting: Setting, relation: Relation) -> list[str]:
    """Free names of a relation and of the whole setting."""
    return setting.free(relation, *(Relation("=", tree, tree) for tree in setting.definitions.values()), *setting.hypotheses)


def _places(setting: Setting, relation: Relation, count: int) -> list[dict[str, Fraction]]:
    """Points in every case, with a value for every name of the setting, since a slip may bring in any of them."""
    whole = [relation, *(Relation("=", tree, tree) for tree in setting.definitions.values()), *setting.hypotheses]
    each = -(-count // len(setting.cases))
    return [point for number, case in enumerate(setting.cases)
            for point in points(replace(setting, cases=(case,)), whole, each, seed=7 + number, size=97)]


def _accepted(one: Kernel, mutants: Sequence[Mutant]) -> list[int]:
    """Positions of the mutants that a kernel does not reject.

    A field kernel must not confirm the mutant's statement. For Coq a failed proof would show nothing, so it must prove that
    the mutant differs from the original at the point.
    """
    if one.name == "coq":
        from imo_analysis.ledger.kernels.coq_mutants import not_rejected

        return not_rejected(one, mutants)
    return [number for number, confirmed in enumerate(one.answer([m.question for m in mutants])) if confirmed]
