"""Everything that is transcribed, in the paper's order."""

from __future__ import annotations

from imo_analysis.paper.equations import EQUATIONS_MODEL
from imo_analysis.paper.equations_observer import EQUATIONS_OBSERVER
from imo_analysis.paper.equations_stability import EQUATIONS_STABILITY
from imo_analysis.paper.item import Item, Row
from imo_analysis.paper.statements import STATEMENTS
from imo_analysis.paper.tables import TABLES

EQUATIONS: tuple[Item, ...] = (*EQUATIONS_MODEL, *EQUATIONS_OBSERVER, *EQUATIONS_STABILITY)

# What stands before what on paper, told by the equation after which a table or statement appears.
_AFTER = {
    "table1": "eq1",
    "baseline-not-convergent": "eq4",
    "z-needs-measurements-only": "eq7",
    "projection-keeps-bound": "eq10",
    "remark-III.1": "eq11",
    "lemma-IV.1": "eq11",
    "proposition-IV.2": "eq11",
    "projection-inequality": "eq15",
    "sign-operator": "eq15",
    "bounded-from-16": "eq16",
    "barbalat-step": "eq18",
    "proposition-IV.3": "eq18",
    "proposition-IV.4": "eq21",
}


FIRST = "guaranteed-stability"  # of the abstract


def _ordered() -> tuple[Item, ...]:
    others = (*TABLES, *STATEMENTS)
    found: list[Item] = [one for one in others if one.id == FIRST]
    for equation in EQUATIONS:
        found.append(equation)
        found.extend(one for one in others if _AFTER.get(one.id) == equation.id)
    return (*found, *(one for one in others if one.id not in _AFTER and one.id != FIRST))


ITEMS: tuple[Item, ...] = _ordered()


def item(identifier: str) -> Item:
    """The item of that id.

    Raises
    ------
    KeyError
        If there is none.
    """
    for one in ITEMS:
        if one.id == identifier:
            return one
    raise KeyError(identifier)


def row(identifier: str) -> Row:
    """The row ``item.row`` of that id, e.g. ``eq12.i_qs``.

    Parameters
    ----------
    identifier : str
        Item and row, with a dot between.

    Raises
    ------
    KeyError
        If there is none.
    """
    for one in ITEMS:
        for printed in one.rows:
            if f"{one.id}.{printed.name}" == identifier:
                return printed
    raise KeyError(identifier)
