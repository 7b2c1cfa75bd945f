"""Published statements beside ours: what is put as a condition is compared, and what is not read is said to be cited only."""

from dataclasses import replace

from imo_analysis.excitation.observability import Problem
from imo_analysis.excitation.published import CITED, PUBLISHED, compare
from imo_analysis.ledger.book import claims


def test_conditions_are_compared_and_the_comparison_can_fail():
    put = [one for one in PUBLISHED if one.problem]
    assert len(put) == 2 and all(compare(one) == "the same" for one in put)
    assert compare(replace(put[0], surface=("slip",))) == "different"
    assert compare(replace(put[0], problem=Problem(("alpha",)))) == "different"


def test_what_was_not_read_makes_no_statement_that_is_compared():
    assert all(one.problem is None for one in PUBLISHED if one.read == CITED)
    assert sum(one.read != CITED for one in PUBLISHED) == 4


def test_the_claims_that_are_named_are_in_the_ledger():
    import re

    known = {claim.id for claim in claims()}
    named = {name for one in PUBLISHED for name in re.findall(r"excitation\.\w+", one.ours)}
    assert named and named <= known
