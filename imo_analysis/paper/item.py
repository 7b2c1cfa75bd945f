"""The shapes of the transcription: an item of the paper and the rows it prints."""

from __future__ import annotations

from dataclasses import dataclass

PAPER = "J. You, W. Wu, Y. Wang, An Adaptive Luenberger Observer for Speed-Sensorless Estimation, ACC 2018 (MERL TR2018-090)"


@dataclass(frozen=True)
class Row:
    """One printed row or term.

    Attributes
    ----------
    name : str
        Short name, unique within its item; the ledger calls the row ``<item>.<name>``.
    text : str
        The relation as printed, over the names of the notation table (`ledger.expression.parse_relation` reads it), with
        accents that the scan damaged put back only where ``scan`` says so. Empty where ``latex`` is needed instead.
    latex : str
        What is printed, typeset by us, where it is no relation between formulas (a matrix, an integral, a case).
    scan : str
        What the scan shows differently from ``text``, and why ``text`` reads it so.
    """

    name: str
    text: str = ""
    latex: str = ""
    scan: str = ""


@dataclass(frozen=True)
class Item:
    """One thing in the paper that can be true or false.

    Attributes
    ----------
    id : str
        ``eq1`` .. ``eq23``, ``table1`` .. ``table3``, or a name for a statement.
    number : str
        How the paper calls it, e.g. ``(12)`` or ``Proposition IV.2``; empty for a claim in the running text.
    place : str
        Section and, for claims in the text, where in it.
    says : str
        What it states, in our words.
    rows : tuple of Row
        Its printed rows; empty for a statement in words.
    """

    id: str
    number: str
    place: str
    says: str
    rows: tuple[Row, ...] = ()
