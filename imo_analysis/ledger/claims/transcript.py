"""Claims from the transcription: the printed text and its place come from `paper`, never typed in a second time."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from imo_analysis.ledger.claim import Claim, Computed, Verdict
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.paper.contents import item, row
from imo_analysis.paper.item import Row

# For statements without formulas of their own.
WORDS: Setting = setting("words", "no formulas of its own")


def printed(identifier: str) -> str:
    """The printed relation of a row, e.g. ``eq12.i_qs``."""
    return row(identifier).text


def claim(identifier: str, title: str, expected: Verdict, where: Setting = WORDS, **more: Any) -> Claim:
    """A claim about a row ``item.row`` or a whole item of the transcription.

    Parameters
    ----------
    identifier : str
        Id in `paper.contents`, or ``item.aspect`` for something that an item says besides its rows; also the claim's id.
    title : str
    expected : Verdict
    where : Setting
    **more
        Further fields of `Claim`. ``printed`` and the remark on the scan come from the transcription.
    """
    names = identifier.split(".")
    try:
        found = item(identifier)
        text, scan = "", ""
    except KeyError:
        found = item(names[0])
        line = next((one for one in found.rows if one.name == ".".join(names[1:])), Row(""))
        text, scan = line.text, line.scan
    fields: dict[str, Any] = {"printed": text or (), "prose": found.says, **more}
    if scan:
        fields["note"] = f"Scan: {scan} {fields.get('note', '')}".strip()
    return Claim(id=identifier, item=found.number or found.place, title=title, expected=expected, setting=where, **fields)


def same(identifier: str, old: str, new: str, count: int = 1) -> str:
    """The printed row with one edit, so that the correction shows as the smallest one.

    Raises
    ------
    ValueError
        If ``old`` does not appear ``count`` times.
    """
    text = printed(identifier)
    if text.count(old) != count:
        raise ValueError(f"{identifier}: {old!r} appears {text.count(old)} times, not {count}")
    return text.replace(old, new)


Shape = tuple[int, int]


def fits(result: Shape, *products: tuple[Shape, ...]) -> tuple[bool, str]:
    """Whether every product of matrices exists and has the shape of the result; the second value says what was found."""
    for factors in products:
        words = " times ".join(f"{rows}x{columns}" for rows, columns in factors)
        for left, right in pairwise(factors):
            if left[1] != right[0]:
                return False, f"{words}: {left[1]} columns meet {right[0]} rows"
        shape = (factors[0][0], factors[-1][1])
        if shape != result:
            return False, f"{words} is {shape[0]}x{shape[1]}, not {result[0]}x{result[1]}"
    return True, f"all terms are {result[0]}x{result[1]}"


def shapes(role: str, text: str, result: Shape, *products: tuple[Shape, ...]) -> Computed:
    """A check of matrix shapes; it must reject a result with a row less, and pass one matrix of the shape of the result."""
    return Computed(
        role, text, fits, exact=True, arguments=(result, *products), failing=((result[0] - 1, result[1]), *products),
        passing=(result, (result,)),
    )
