"""The transcription is whole, readable, and every item of it has an entry in the ledger."""

from __future__ import annotations

import re

import pytest

from imo_analysis.ledger.book import claims
from imo_analysis.ledger.expression import free_names, parse_relation
from imo_analysis.notation import symbol
from imo_analysis.paper.contents import EQUATIONS, ITEMS, item, row
from imo_analysis.paper.tables import EIGENVALUES, PARAMETERS, TABLES

CLAIMS = {claim.id: claim for claim in claims()}
ROWS = {f"{one.id}.{line.name}": line for one in ITEMS for line in one.rows}
WANTED = [f"{one.id}.{line.name}" if one.rows else one.id for one in ITEMS for line in (one.rows or (None,))]


def test_numbered_equations_are_all_there():
    assert [one.number for one in EQUATIONS] == [f"({number})" for number in range(1, 24)]
    assert [one.id for one in EQUATIONS] == [f"eq{number}" for number in range(1, 24)]
    assert [one.number for one in TABLES] == ["Table I", "Table II", "Table III"]


def test_named_statements_are_all_there():
    numbers = {one.number for one in ITEMS}
    assert {"Lemma IV.1", "Remark III.1", "Proposition IV.2", "Proposition IV.3", "Proposition IV.4"} <= numbers


def test_ids_are_unique():
    assert len({one.id for one in ITEMS}) == len(ITEMS)
    assert len(set(WANTED)) == len(WANTED)


@pytest.mark.parametrize("identifier", WANTED)
def test_every_item_has_an_entry(identifier):
    assert identifier in CLAIMS


@pytest.mark.parametrize("identifier", ROWS)
def test_rows_are_formulas_or_typeset(identifier):
    line = row(identifier)
    assert line is ROWS[identifier]
    assert bool(line.text) != bool(line.latex)
    if line.text:
        relation = parse_relation(line.text)
        for name in [*free_names(relation.left), *free_names(relation.right)]:
            if name != "p" and not name.startswith("term_"):
                symbol(name)


# Printed rows that a claim may state differently: the scan lost an accent that decides what is meant.
RESTORED = {"sign-operator.inequality"}


@pytest.mark.parametrize("identifier", ROWS)
def test_the_claim_quotes_the_transcription(identifier):
    line = row(identifier)
    assert line is ROWS[identifier]
    if line.text and identifier not in RESTORED:
        claim = CLAIMS[identifier]
        quoted = set(claim.printed) | {text for check in claim.checks for text in getattr(check, "relations", ())}
        assert line.text in quoted


def test_consequences_are_entries():
    for claim in CLAIMS.values():
        assert set(claim.consequences) <= set(CLAIMS), claim.id


def test_slips_say_whose_they_are():
    for claim in CLAIMS.values():
        if str(claim.expected) in ("holds after correction", "fails"):
            assert claim.origin in ("scan", "paper"), claim.id
            assert claim.why, claim.id


def test_table_ii_has_its_24_numbers():
    assert len(EIGENVALUES) == 6
    for pair in EIGENVALUES:
        for text in (*pair.first, *pair.second):
            assert re.fullmatch(r"-?\d+\.\d\d", text)


def test_table_iii_has_its_rows():
    assert [one.name for one in PARAMETERS] == [
        "n_p", "J", "R_s", "R_r", "L_m", "L_s - L_m", "L_r - L_m", "alpha", "flux_reference", "omega_reference"]


def test_unknown_names_raise():
    with pytest.raises(KeyError):
        item("eq24")
    with pytest.raises(KeyError):
        row("eq12.nothing")


def test_order_is_the_papers():
    order = [one.id for one in ITEMS]
    assert order[0] == "guaranteed-stability"
    some = [order.index(one) for one in ("eq11", "lemma-IV.1", "eq12", "proposition-IV.3", "eq19", "table2")]
    assert some == sorted(some)
    ledger = [one for one in CLAIMS if one in WANTED]
    assert ledger == sorted(ledger, key=WANTED.index)
