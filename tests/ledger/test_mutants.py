"""Mutants: which slips are made, that every kernel rejects them, and that a weak kernel is found out."""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from imo_analysis.ledger.claim import Claim, Verdict
from imo_analysis.ledger.complex_forms import FORMS
from imo_analysis.ledger.definition_mutants import try_definitions
from imo_analysis.ledger.expression import parse_relation
from imo_analysis.ledger.form import Form
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.mutants import of_question, try_mutants
from imo_analysis.ledger.mutations import mutations, renamed
from imo_analysis.ledger.question import Question
from imo_analysis.ledger.setting import true_at
from imo_analysis.ledger.settings import errors
from imo_analysis.ledger.settle import plan

CLAIM = Claim("z", "(12)", "the rate of the z error", Verdict.HOLDS, errors(),
              printed="z_1_tilde_dot = k_2*omega_hat*i_qs_tilde")
SQUARES = Claim("s", "", "a sum of squares", Verdict.HOLDS, errors(), printed="0 <= beta*i_ds_tilde**2 + 3*i_qs_tilde**2",
                squares=(("beta", "i_ds_tilde"), ("3", "i_qs_tilde")))


class Weak:
    """A kernel that confirms everything."""

    name = "weak"

    def answer(self, questions: Sequence[Question]) -> list[bool]:
        return [True] * len(questions)


class FirstCaseOnly:
    """A kernel that settles a statement in its first case and takes the others for granted."""

    name = "first case only"

    def __init__(self) -> None:
        self._sound = kernel("flint")

    def answer(self, questions: Sequence[Question]) -> list[bool]:
        first = [replace(one, setting=replace(one.setting, cases=one.setting.cases[:1])) for one in questions]
        return self._sound.answer(first)


class Lax(Form):
    """A second form that any function meets."""

    def meets(self, *_: object, **__: object) -> bool:
        return True


def test_every_kind_of_slip_is_made() -> None:
    relation = parse_relation("z_1_tilde_dot = k_2*omega_hat*i_qs_tilde - 2*z_1**2")
    made = {str(one.relation) for one in mutations(relation, lambda name: True)}
    for slip in (
        "z_1_tilde_dot = k_2*omega_hat*i_qs_tilde + 2*z_1**2",    # sign
        "z_1_tilde_dot = -(k_2*omega_hat*i_qs_tilde) - 2*z_1**2",  # sign of the first term
        "z_1_tilde_dot = k_2*omega_hat*i_qs_tilde - 3*z_1**2",    # coefficient
        "z_1_tilde_dot = 2*(k_2*omega_hat*i_qs_tilde) - 2*z_1**2",  # implicit coefficient
        "z_1_tilde_dot = k_2*omega_hat*i_qs_tilde - 2*z_1**3",    # exponent
        "z_1_tilde_dot = k_2*omega_hat**2*i_qs_tilde - 2*z_1**2",  # implicit exponent
        "z_1_tilde_dot = k_3*omega_hat*i_qs_tilde - 2*z_1**2",    # index
        "z_1_tilde_dot = k_2*omega_hat*i_ds_tilde - 2*z_1**2",    # axis
        "z_1_tilde_dot = k_2*omega*i_qs_tilde - 2*z_1**2",        # hat dropped
        "z_1_tilde_dot = k_2*omega_tilde*i_qs_tilde - 2*z_1**2",  # hat to tilde
        "z_1_tilde_dot = k_2*omega_hat*i_qs - 2*z_1**2",          # tilde dropped
        "z_1_tilde_dot = k_2*omega_hat*i_qs_hat - 2*z_1**2",      # tilde to hat
        "z_1_tilde_dot = k_2*omega_hat*i_qs_tilde - 2*z_1_hat**2",  # hat added
        "z_2_tilde_dot = k_2*omega_hat*i_qs_tilde - 2*z_1**2",    # on the left as well
    ):
        assert slip in made, slip
    assert len(made) > 30


def test_names_are_changed_in_one_place_only() -> None:
    assert dict(renamed("i_ds_tilde_dot")) == {
        "axis": "i_qs_tilde_dot", "tilde": "i_ds_dot", "tilde to hat": "i_ds_hat_dot"}


@pytest.mark.parametrize("name", ["sympy", "flint", "coq"])
def test_each_kernel_rejects_every_unequal_mutant(name: str) -> None:
    report = try_mutants([CLAIM, SQUARES], [name])
    assert report.ok and report.tried > 30
    assert report.rejected == {name: report.tried - len(report.equivalent)}


def test_a_weak_kernel_misses_mutants() -> None:
    report = try_mutants([CLAIM], [Weak()])
    assert not report.ok and len(report.missed) == report.tried - len(report.equivalent)


def test_a_kernel_that_skips_a_case_misses_a_mutant() -> None:
    report = try_mutants([CLAIM], [FirstCaseOnly()])
    assert report.missed and all("in the case direction = -1 only" in one for one in report.missed)


def test_of_inequalities_those_that_may_still_be_true_are_counted() -> None:
    mutants = of_question(plan(SQUARES)[0][0].question)
    refuted = {one.what for one in mutants if one.refuted}
    assert "direction" in refuted and "sign before 3*i_qs_tilde**2" in refuted
    for one in mutants:
        if one.refuted:
            assert not true_at(one.question.relation, one.question.setting.values(one.point or {}))
    larger = next(one for one in mutants if one.what == "coefficient 3 to 4")
    assert larger.point is not None and not larger.refuted
    report = try_mutants([SQUARES, CLAIM], ["flint"])
    assert report.certificates == sum(not one.refuted for one in mutants) > 0
    assert f"  {report.certificates} of the rejected are inequalities not refuted" in report.text()


def test_equivalent_mutants_are_told_apart() -> None:
    claim = replace(CLAIM, printed="z_1_tilde_dot*(k_3 - k_3) = 0")
    report = try_mutants([claim], ["sympy", "flint"])
    assert report.equivalent and report.ok
    assert len(report.equivalent) + report.rejected["flint"] == report.tried


def test_every_definition_has_a_second_form_and_no_mutant_survives() -> None:
    report = try_definitions()
    assert report.unchecked == [] and report.survived == []
    assert report.tried > 1000 and report.killed + len(report.equivalent) == report.tried


def test_a_definition_without_a_second_form_or_with_a_lax_one_is_found_out() -> None:
    missing = try_definitions(tuple(form for form in FORMS if form.function != "torque"), only="plant")
    assert missing.unchecked == ["plant.torque"] and not missing.ok
    forms = tuple(Lax(**vars(form)) if form.function == "torque" else form for form in FORMS)
    report = try_definitions(forms, only="plant")
    assert report.survived and all("plant.torque" in one for one in report.survived) and not report.ok
