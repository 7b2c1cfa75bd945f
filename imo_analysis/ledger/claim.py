"""A claim of the paper as data, and the entry that settles it.

A claim says what is printed, what would be right, and which verdict its author expects. The verdict itself is computed
from the checks (`settle`), never copied.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from typing import Any

from imo_analysis.errors import InputError
from imo_analysis.ledger.setting import Setting


class Verdict(StrEnum):
    """What is known about a printed statement."""

    HOLDS = "holds"
    CORRECTED = "holds after correction"
    FAILS = "fails"
    OPEN = "not determined by the text"


ROLES = ("printed", "corrected", "refutes", "reading", "evidence")


@dataclass(frozen=True, eq=False)
class Algebra:
    """A check by exact algebra.

    Attributes
    ----------
    role : str
        ``printed``: what the paper says; true or refuted. ``corrected``: the repaired statement; must be true.
        ``refutes``: must be true, and shows that the printed statement is not. ``reading``: one way to read the text.
        ``evidence``: must be true, has no bearing on the verdict.
    text : str
        What it shows, in a line.
    relations : sequence of str
        Formulas with one relation sign each.
    setting : Setting, optional
        Where it differs from the claim's.
    squares : sequence of (str, str)
        For an inequality: weights and bases whose sum of ``weight * base**2`` is the larger side minus the smaller.
    point : mapping, optional
        A counterexample to use; otherwise a small one is searched for.
    """

    role: str
    text: str
    relations: Sequence[str]
    setting: Setting | None = None
    squares: Sequence[tuple[str, str]] = ()
    point: Mapping[str, int | Fraction] | None = None


@dataclass(frozen=True, eq=False)
class Computed:
    """A check by a function that returns ``(passed, what was found)``.

    ``exact`` says whether the function works in integers and fractions; otherwise it is numerical evidence and marked so.
    ``failing`` is a variant of the function's input which it must reject, ``passing`` one which it must accept: a check that
    passes needs the first, one that fails the second, for a check with one answer only is none.
    """

    role: str
    text: str
    function: Callable[..., tuple[bool, str]]
    exact: bool = False
    arguments: tuple[Any, ...] = ()
    failing: tuple[Any, ...] | None = None
    passing: tuple[Any, ...] | None = None


@dataclass(frozen=True)
class Trajectory:
    """A run that shows the verdict at work: the study's overlay and what to look at. Evidence, not proof."""

    scenario: str
    text: str
    command: str = ""


Check = Algebra | Computed


@dataclass(frozen=True, eq=False)
class Claim:
    """One statement of the paper.

    Attributes
    ----------
    id : str
        ``eq12.row1``: the item without brackets, then the part.
    item : str
        The paper's own number, ``(12)``, ``Table II``, ``Proposition IV.2``, or the section of a claim in the text.
    title : str
        What it says, in a line.
    expected : Verdict
        What its author expects; a computed verdict that differs is an error of the tool or of the claim.
    setting : Setting
    printed : str or sequence of str
        The formulas as printed.
    prose : str
        The statement in our words where it is not a formula, or needs a frame.
    corrected : str or sequence of str
        The formulas after the smallest edit that makes them true.
    edit : str
        That edit in words.
    squares : sequence of (str, str)
        Certificate for an inequality that holds (the corrected one, or the printed one where it holds).
    point : mapping, optional
        A counterexample to the printed formulas, when a particular one is wanted.
    checks : sequence of Check
        Further checks.
    trajectories : sequence of Trajectory
    assumptions : sequence of str
        Hypotheses in words, beyond those of the setting.
    origin, why : str
        ``scan``, ``paper`` or empty: where a slip comes from, and why we think so.
    consequences : sequence of str
        Ids of entries that fall, or change, with this one.
    note : str
        Anything else that the reader needs.
    mutate : bool
        Whether mutants of its formulas are tried.
    cited : str
        Where it rests on a theorem or an assumption that nothing here proves: its source. The verdict is then labelled.
    units : str
        Empty where all formulas are dimensionally consistent; otherwise what fails, in a few words, as expected.
    """

    id: str
    item: str
    title: str
    expected: Verdict
    setting: Setting
    printed: str | Sequence[str] = ()
    prose: str = ""
    corrected: str | Sequence[str] = ()
    edit: str = ""
    squares: Sequence[tuple[str, str]] = ()
    point: Mapping[str, int | Fraction] | None = None
    checks: Sequence[Check] = ()
    trajectories: Sequence[Trajectory] = ()
    assumptions: Sequence[str] = ()
    origin: str = ""
    why: str = ""
    consequences: Sequence[str] = ()
    note: str = ""
    mutate: bool = True
    cited: str = ""
    units: str = ""

    def __post_init__(self) -> None:
        for name in ("printed", "corrected"):
            value = getattr(self, name)
            object.__setattr__(self, name, (value,) if isinstance(value, str) else tuple(value))
        for check in self.checks:
            if check.role not in ROLES:
                raise InputError(f"claim {self.id}: role {check.role!r} must be one of {', '.join(ROLES)}")
        if self.expected is Verdict.CORRECTED and not self.edit:
            raise InputError(f"claim {self.id}: a correction needs its edit in words")
        if self.origin not in ("", "scan", "paper"):
            raise InputError(f"claim {self.id}: origin = {self.origin!r} must be 'scan', 'paper' or empty")

    @property
    def ours(self) -> bool:
        """Whether it is not in the paper: a repair, or a result beside it."""
        return self.item.endswith("(ours)")

    def formal(self) -> list[Check]:
        """All checks, those of the printed and corrected formulas first."""
        checks: list[Check] = []
        if self.printed:
            squares = () if self.corrected else self.squares
            checks.append(Algebra("printed", "the printed formulas", tuple(self.printed), squares=squares, point=self.point))
        if self.corrected:
            checks.append(Algebra("corrected", "the corrected formulas", tuple(self.corrected), squares=self.squares))
        return [*checks, *self.checks]


@dataclass(frozen=True, eq=False)
class Finding:
    """The outcome of one check on one formula.

    Attributes
    ----------
    id, role, text : str
    kind : str
        ``identity``, ``squares``, ``counterexample``, ``computed`` or ``numerical``.
    true : bool or None
        Whether the statement is true; None if nothing could settle it.
    statement : str
        The formula, where there is one.
    detail : dict
        ``residual``, ``point``, ``left``, ``right``, ``squares``, ``found``: what a reader needs to check it by hand.
    """

    id: str
    role: str
    text: str
    kind: str
    true: bool | None
    statement: str = ""
    detail: Mapping[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {"id": self.id, "role": self.role, "text": self.text, "kind": self.kind, "true": self.true,
                "statement": self.statement, **self.detail}


@dataclass(frozen=True, eq=False)
class Entry:
    """A claim with its settled result.

    Attributes
    ----------
    claim : Claim
    verdict : Verdict or None
        Computed; None if the checks do not settle it.
    findings : list of Finding
    errors : list of str
        Faults of the tool or of the claim: a kernel that disagrees, a verdict that is not the expected one, a denominator
        without a hypothesis. An entry with errors must not be trusted.
    kernels : tuple of str
        The kernels that agreed.
    unit_faults : list of str
        What is dimensionally inconsistent in the printed formulas.
    """

    claim: Claim
    verdict: Verdict | None
    findings: list[Finding]
    errors: list[str]
    kernels: tuple[str, ...]
    unit_faults: list[str] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """No error of the tool."""
        return not self.errors

    @property
    def label(self) -> str:
        """The verdict in words, with a mark where it rests on what is cited."""
        return str(self.verdict or "not settled") + (" (cited)" if self.claim.cited else "")

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON (`imo-ledger/1`), with every formula as text and as LaTeX."""
        from imo_analysis.ledger.difference import difference
        from imo_analysis.ledger.expression import parse_relation
        from imo_analysis.ledger.latex import relation_latex

        claim = self.claim

        def formulas(texts: Sequence[str]) -> list[dict[str, str]]:
            return [{"text": text, "latex": relation_latex(parse_relation(text))} for text in texts]

        return {
            "id": claim.id, "item": claim.item, "title": claim.title,
            "verdict": str(self.verdict) if self.verdict else None, "expected": str(claim.expected),
            "prose": claim.prose, "difference": [
                difference(old, new) for old, new in zip(claim.printed, claim.corrected, strict=False)],
            "printed": formulas(claim.printed), "corrected": formulas(claim.corrected), "edit": claim.edit,
            "setting": claim.setting.text,
            "hypotheses": [str(one) for one in claim.setting.hypotheses], "assumptions": list(claim.assumptions),
            "origin": claim.origin, "why": claim.why, "consequences": list(claim.consequences), "note": claim.note,
            "cited": claim.cited,
            "findings": [one.to_dict() for one in self.findings],
            "trajectories": [vars(one) for one in claim.trajectories],
            "units": self.unit_faults, "kernels": list(self.kernels), "errors": self.errors,
        }
