"""Published statements beside ours: each is compared, each comparison can fail, and what was not read states nothing."""

from dataclasses import replace

import pytest

from imo_analysis.excitation.observability import UNKNOWNS, Problem
from imo_analysis.excitation.published import ABSTRACT, CITED, DIFFERENT, IMPLIED, PUBLISHED, QUOTED, SAME, compare
from imo_analysis.ledger.book import claims


def by(author):
    return next(one for one in PUBLISHED if author in one.source)


def test_every_statement_agrees_and_those_that_say_less_are_known():
    found = {one.source: compare(one) for one in PUBLISHED}
    assert set(found.values()) == {SAME, IMPLIED}
    assert {one.source for one in PUBLISHED if compare(one) == IMPLIED} == {by("Ibarra").source, by("Comanescu").source}


@pytest.mark.parametrize("wrong", [
    replace(by("Combes"), surface=("slip",)),
    replace(by("Combes"), surface=()),
    replace(by("Combes"), problem=Problem(("omega",))),  # a known load torque gives the line away
    replace(by("Ibarra"), problem=Problem(("omega",))),
    replace(by("Verghese"), surface=("omega + slip",)),
    replace(by("Verghese"), problem=Problem(("omega", "alpha"), mechanical=False)),
    replace(by("Li"), motions=("steady state",)),
    replace(by("Montanari"), told=False),
    replace(by("Traoré"), motions=("general motion", "steady, no load")),
    replace(by("Comanescu"), surface=("slip", "omega")),
], ids=lambda one: one.source.split(",")[0])
def test_a_statement_that_is_wrong_is_found_out(wrong):
    assert compare(wrong) == DIFFERENT


def test_every_statement_says_what_it_was_checked_against():
    assert {one.read for one in PUBLISHED} == {ABSTRACT, QUOTED}
    assert all(set(one.problem.unknown) <= set(UNKNOWNS) for one in PUBLISHED)
    assert not {one.source for one in PUBLISHED} & set(CITED)


def test_the_claims_that_are_named_are_in_the_ledger():
    import re

    known = {claim.id for claim in claims()}
    named = {name for one in PUBLISHED for name in re.findall(r"excitation\.\w+", one.ours)}
    assert named and named <= known
