"""The question that a kernel answers: is this relation true under the hypotheses, and the ways to show that it is or is not.

A question never depends on a kernel, so that the answers of three kernels can be compared.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

from imo_analysis.ledger.expression import Expr, Relation
from imo_analysis.ledger.setting import Setting


@dataclass(frozen=True)
class Square:
    """One term ``weight * base**2`` of a sum of squares; the weight must be seen to be >= 0 from the hypotheses."""

    weight: Expr
    base: Expr


@dataclass(frozen=True, eq=False)
class Question:
    """A statement for a kernel to confirm.

    Attributes
    ----------
    id : str
    setting : Setting
    relation : Relation
    kind : str
        ``identity``: left = right everywhere. ``squares``: left <= right (or >=) because the difference is the sum of
        ``squares``. ``counterexample``: at ``point`` the hypotheses hold and the relation does not.
    point : mapping of str to Fraction
        Values of the free names, for a counterexample.
    squares : sequence of Square
    """

    id: str
    setting: Setting
    relation: Relation
    kind: str
    point: Mapping[str, Fraction] | None = None
    squares: Sequence[Square] = ()


class Kernel(Protocol):
    """A way to settle questions exactly."""

    name: str

    def answer(self, questions: Sequence[Question]) -> list[bool]:
        """For each question, whether the kernel confirms it."""
