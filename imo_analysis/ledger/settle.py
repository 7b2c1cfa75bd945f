"""From a claim to its entry: put the questions, let every kernel answer, compute the verdict, compare with the expected one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from imo_analysis.errors import InputError
from imo_analysis.ledger.claim import Algebra, Claim, Computed, Entry, Finding, Verdict
from imo_analysis.ledger.expression import (
    Expr,
    Name,
    Relation,
    evaluate,
    free_names,
    number,
    parse,
    parse_relation,
    substitute,
)
from imo_analysis.ledger.kernels.field_kernel import FieldKernel
from imo_analysis.ledger.question import Kernel, Question, Square
from imo_analysis.ledger.sampling import counterexample
from imo_analysis.ledger.setting import Setting
from imo_analysis.ledger.signs import UndecidedSign, uncovered_denominators, without_abs
from imo_analysis.ledger.units import unit_faults


@dataclass(frozen=True, eq=False)
class _Planned:
    question: Question
    role: str
    text: str
    statement: str


def settle(claims: Iterable[Claim], kernels: Sequence[Kernel]) -> list[Entry]:
    """Settle claims with one or more kernels, which must agree.

    Parameters
    ----------
    claims : iterable of Claim
    kernels : sequence of Kernel
        Each answers every question. The questions do not depend on the kernel.
    """
    claims = list(claims)
    plans: list[list[_Planned]] = []
    faults: list[list[str]] = []
    for claim in claims:
        try:
            planned, wrong = plan(claim)
        except InputError as error:
            planned, wrong = [], [str(error)]
        plans.append(planned)
        faults.append(wrong)
    questions = [one.question for planned in plans for one in planned]
    answers = [dict(zip((q.id for q in questions), kernel.answer(questions), strict=True)) for kernel in kernels]
    return [
        _entry(claim, planned, wrong, kernels, answers)
        for claim, planned, wrong in zip(claims, plans, faults, strict=True)
    ]


def plan(claim: Claim) -> tuple[list[_Planned], list[str]]:
    """The questions of a claim, and the faults of the claim itself."""
    planned: list[_Planned] = []
    faults: list[str] = []
    numbers: Counter[str] = Counter()
    for check in claim.formal():
        if not isinstance(check, Algebra):
            continue
        numbers[check.role] += 1
        where = check.setting or claim.setting
        for row, text in enumerate(check.relations):
            key = f"{claim.id}.{check.role}" + (str(numbers[check.role]) if numbers[check.role] > 1 else "")
            if len(check.relations) > 1:
                key += f".{row + 1}"
            relation = parse_relation(text)
            question = ask(key, where, relation, check)
            planned.append(_Planned(question, check.role, check.text, text))
            if question.kind != "counterexample":
                faults += denominators(where, relation, [tree for one in question.squares for tree in (one.weight, one.base)])
    return planned, faults


def denominators(where: Setting, relation: Relation, squares: Sequence[Expr] = ()) -> list[str]:
    """Denominators without a hypothesis, in words: of a relation, of its squares, and of what they use."""
    trees = [relation.left, relation.right, *squares]
    trees += [where.definitions[name] for name in where.used(relation, *(Relation("=", one, one) for one in squares))]
    return [
        f"the denominator {one} needs a hypothesis that it is not zero (setting {where.name})"
        for one in uncovered_denominators(trees, where.hypotheses, where.definitions)
        if not (isinstance(one, Name) and all(case.get(one.name) for case in where.cases))
    ]


def ask(key: str, where: Setting, relation: Relation, check: Algebra) -> Question:
    """The question for a relation: a counterexample where exact points show one, otherwise a proof."""
    point: Mapping[str, Fraction] | None
    if check.point is not None:
        point = {name: Fraction(value) for name, value in check.point.items()}
        missing = [name for name in where.free(relation) if name not in point]
        if missing:
            raise InputError(f"{key}: the given point has no value for {', '.join(missing)}")
    else:
        point = counterexample(where, relation, bool(check.squares))
    if point is not None:
        return Question(key, where, relation, "counterexample", point=point)
    if relation.op == "=":
        return Question(key, where, relation, "identity")
    return Question(key, where, relation, "squares",
                    squares=[Square(parse(weight), parse(base)) for weight, base in check.squares])


def _entry(claim: Claim, planned: Sequence[_Planned], faults: Sequence[str], kernels: Sequence[Kernel],
           answers: Sequence[Mapping[str, bool]]) -> Entry:
    errors = list(faults)
    findings: list[Finding] = []
    for one in planned:
        question = one.question
        said = {kernel.name: answer[question.id] for kernel, answer in zip(kernels, answers, strict=True)}
        if not all(said.values()):
            yes = ", ".join(name for name, answer in said.items() if answer) or "none"
            no = ", ".join(name for name, answer in said.items() if not answer)
            word = "kernels disagree" if any(said.values()) else "not settled"
            errors.append(f"{question.id}: {word} on the {question.kind} {one.statement} (confirmed: {yes}; not: {no})"
                          + "".join(f"; {reason}" for reason in _undecided(question)))
        true = question.kind != "counterexample" if all(said.values()) else None
        detail = _detail(question, kernels)
        findings.append(Finding(question.id, one.role, one.text, question.kind, true, one.statement, detail))
    for check in claim.checks:
        if isinstance(check, Computed):
            passed, found = check.function(*check.arguments)
            kind = "computed" if check.exact else "numerical"
            findings.append(Finding(claim.id, check.role, check.text, kind, passed, detail={"found": found}))
            if check.failing is not None and check.function(*check.failing)[0]:
                errors.append(f"{claim.id}: the check {check.text!r} passes an input that it must reject")
            if check.passing is not None and not check.function(*check.passing)[0]:
                errors.append(f"{claim.id}: the check {check.text!r} rejects an input that it must pass")
            if (check.failing if passed else check.passing) is None:
                word = "rejects" if passed else "passes"
                errors.append(f"{claim.id}: the check {check.text!r} needs an input that it {word}, or it has but one answer")
    for finding in findings:
        if finding.role in ("corrected", "refutes", "evidence") and not finding.true:
            errors.append(f"{finding.id}: the {finding.role} statement {finding.statement or finding.text!r} is not true")
    verdict = compute_verdict(findings)
    if verdict is not claim.expected:
        errors.append(f"{claim.id}: the verdict computed is {verdict or 'none'!s}, expected was {claim.expected!s}")
    units = [fault for text in claim.printed for fault in unit_faults(parse_relation(text), claim.setting.units)]
    if bool(units) != bool(claim.units):
        errors.append(f"{claim.id}: units {'; '.join(units) or 'agree'}, expected was {claim.units or 'that they agree'}")
    return Entry(claim, verdict, findings, errors, tuple(kernel.name for kernel in kernels), units)


def _undecided(question: Question) -> list[str]:
    """The absolute values of which the field kernels do not know the sign, in words."""
    setting = question.setting
    relation = question.relation
    try:
        for tree in (relation.left, relation.right, *(setting.definitions[name] for name in setting.used(relation))):
            for case in setting.cases:
                in_case = {name: number(value) for name, value in case.items()}
                hypotheses = [Relation(one.op, substitute(one.left, in_case), substitute(one.right, in_case))
                              for one in setting.hypotheses]
                without_abs(substitute(tree, in_case), hypotheses,
                            {name: substitute(one, in_case) for name, one in setting.definitions.items()})
    except UndecidedSign as error:
        return [str(error)]
    return []


def compute_verdict(findings: Sequence[Finding]) -> Verdict | None:
    """The verdict that follows from the findings alone."""
    printed = [one.true for one in findings if one.role == "printed"]
    corrected = [one.true for one in findings if one.role == "corrected"]
    readings = [one.true for one in findings if one.role == "reading"]
    refuted = False in printed or any(one.role == "refutes" and one.true for one in findings)
    if refuted:
        if not corrected:
            return Verdict.FAILS
        return Verdict.CORRECTED if all(corrected) else None
    if printed:
        return Verdict.HOLDS if all(printed) else None
    if readings and None not in readings:
        return Verdict.OPEN if True in readings and False in readings else Verdict.HOLDS if all(readings) else Verdict.FAILS
    return Verdict.OPEN


def _detail(question: Question, kernels: Sequence[Kernel]) -> dict[str, Any]:
    """What a reader needs to follow the finding by hand."""
    setting, relation = question.setting, question.relation
    if question.kind == "counterexample":
        assert question.point is not None
        values = setting.values(question.point)
        left, right = evaluate(relation.left, values), evaluate(relation.right, values)
        names = dict.fromkeys([*free_names(relation.left), *free_names(relation.right)])
        shown = next((kernel for kernel in reversed(kernels) if isinstance(kernel, FieldKernel)), None)
        residual = shown.residual(setting, relation) if shown and relation.op == "=" else []
        return {"residual": " | ".join(dict.fromkeys(residual)),
                "point": {name: str(value) for name, value in question.point.items()},
                "values": {name: str(values[name]) for name in names if name not in question.point},
                "left": str(left), "right": str(right)}
    if question.kind == "squares":
        return {"squares": [{"weight": str(one.weight), "base": str(one.base)} for one in question.squares]}
    return {"residual": "0"}
