"""Coq rejects a mutant by proof: at a rational point it differs from the original, which holds there with the hypotheses.

The lemmas live over Q, where ``vm_compute`` decides them at once; a rational point refutes an identity over the reals too.
Denominators that Coq would silently take as 1/0 = 0 do not occur: the points were chosen where every value exists.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from imo_analysis.ledger.expression import Expr, Name, Number, Op, Relation
from imo_analysis.ledger.kernels.coq_kernel import CoqKernel
from imo_analysis.ledger.kernels.coq_script import coq_name, lemma_name
from imo_analysis.ledger.question import Kernel

if TYPE_CHECKING:
    from imo_analysis.ledger.mutants import Mutant

HEADER = """\
Require Import QArith Qabs List.
Import ListNotations.
Open Scope Q_scope.
Definition equal (a b : Q) := Qeq_bool a b.
Definition below (a b : Q) := (Qle_bool a b && negb (Qeq_bool a b))%bool.
"""
_TESTS = {"=": "equal {0} {1}", "!=": "negb (equal {0} {1})", "<": "below {0} {1}", ">": "below {1} {0}",
          "<=": "Qle_bool {0} {1}", ">=": "Qle_bool {1} {0}"}


def not_rejected(one: Kernel, mutants: Sequence[Mutant]) -> list[int]:
    """Positions of the mutants that Coq does not prove different from their original."""
    assert isinstance(one, CoqKernel)
    groups: dict[tuple[object, ...], list[int]] = {}
    for number, mutant in enumerate(mutants):
        assert mutant.point is not None
        groups.setdefault((id(mutant.original), tuple(mutant.point.items())), []).append(number)
    blocks = [_block(number, [mutants[n] for n in members]) for number, members in enumerate(groups.values())]
    passed = one.accepts(HEADER, blocks)
    doubtful = [n for members, good in zip(groups.values(), passed, strict=True) if not good for n in members]
    alone = one.accepts(HEADER, [_block(n, [mutants[n]]) for n in doubtful])
    return [n for n, good in zip(doubtful, alone, strict=True) if not good]


def _block(number: int, mutants: Sequence[Mutant]) -> str:
    """A module with the point, the definitions, and one lemma for all mutants of a statement."""
    original = mutants[0].original
    setting, point = original.setting, mutants[0].point
    assert point is not None
    relations = [original.relation, *(mutant.question.relation for mutant in mutants)]
    free = [name for name in setting.free(*relations, *setting.hypotheses) if name in point]
    used = setting.used(*relations, *setting.hypotheses)
    tests = [_test(one) for one in setting.hypotheses]
    lines = [
        f"Module M{number}. (* {original.id} *)",
        *(f"Definition {coq_name(name)} : Q := {_number(point[name])}." for name in free),
        *(f"Definition {coq_name(name)} : Q := {_text(setting.definitions[name])}." for name in used),
        f"Definition original : bool := {_test(original.relation)}.",
        f"Definition original_difference : Q := {_difference(original.relation)}.",
        "Definition hypotheses : bool := forallb (fun one => one) [" + "; ".join(tests) + "].",
        "Definition rejected : list bool := [",
        ";\n".join(f"  {_rejection(mutant)}" for mutant in mutants),
        "].",
        f"Lemma {lemma_name(original.id)}_mutants :",
        "  (hypotheses && original && forallb (fun one => one) rejected)%bool = true.",
        "Proof. vm_compute. reflexivity. Qed.",
        f"End M{number}.",
    ]
    return "\n".join(lines) + "\n"


def _rejection(mutant: Mutant) -> str:
    """That a mutant is false at the point, or at least not the original."""
    relation = mutant.question.relation
    return f"negb ({_test(relation)})" if mutant.refuted else f"negb (equal ({_difference(relation)}) original_difference)"


def _test(relation: Relation) -> str:
    return _TESTS[relation.op].format(f"({_text(relation.left)})", f"({_text(relation.right)})")


def _difference(relation: Relation) -> str:
    return f"({_text(relation.left)}) - ({_text(relation.right)})"


def _number(value: Fraction) -> str:
    text = f"{value.numerator}" if value.denominator == 1 else f"{value.numerator} / {value.denominator}"
    return f"({text})" if value < 0 or value.denominator != 1 else text


def _text(tree: Expr) -> str:
    """A tree in the syntax of Q, where a power has an integer exponent."""
    if isinstance(tree, Name):
        return coq_name(tree.name)
    if isinstance(tree, Number):
        return _number(tree.value)
    assert isinstance(tree, Op)
    first = _text(tree.args[0])
    if tree.kind == "neg":
        return f"(- {first})"
    if tree.kind == "abs":
        return f"(Qabs ({first}))"
    if tree.kind == "**":
        power = tree.args[1]
        assert isinstance(power, Number)
        return f"({first} ^ {power.value})" if power.value >= 0 else f"(/ ({first} ^ {-power.value}))"
    return f"({first} {tree.kind} {_text(tree.args[1])})"
