"""Entries as text for a terminal: the table, and one entry in full, what is printed above what is right."""

from __future__ import annotations

import shutil
import textwrap
from collections import Counter
from collections.abc import Sequence

from imo_analysis.ledger.claim import Entry, Finding, Verdict
from imo_analysis.ledger.difference import difference
from imo_analysis.ledger.expression import parse_relation

MARKS = {Verdict.HOLDS: "+", Verdict.CORRECTED: "~", Verdict.FAILS: "x", Verdict.OPEN: "?", None: "!"}


def counts(entries: Sequence[Entry]) -> dict[str, int]:
    """How many entries have each verdict.

    Parameters
    ----------
    entries : sequence of Entry
        Settled or not.
    """
    found = Counter(str(entry.verdict or "not settled") for entry in entries)
    return {str(verdict): found.pop(str(verdict), 0) for verdict in Verdict} | dict(found)


def table(entries: Sequence[Entry], width: int | None = None) -> str:
    """One line an entry: mark, id, item, verdict, title."""
    width = width or shutil.get_terminal_size((120, 20)).columns
    ids = max((len(entry.claim.id) for entry in entries), default=2)
    items = max((len(entry.claim.item) for entry in entries), default=4)
    lines = []
    for entry in entries:
        head = f"{MARKS[entry.verdict]} {entry.claim.id:<{ids}}  {entry.claim.item:<{items}}  {entry.label:<26} "
        room = max(20, width - len(head))
        lines.append(head + textwrap.shorten(entry.claim.title, room, placeholder=" ..."))
        lines += [f"    ! {error}" for error in entry.errors]
    return "\n".join(lines)


def summary(entries: Sequence[Entry]) -> str:
    """The count of each verdict, and of errors of the tool."""
    wrong = sum(not entry.ok for entry in entries)
    text = ", ".join(f"{count} {name}" for name, count in counts(entries).items() if count)
    return f"{len(entries)} {'entry' if len(entries) == 1 else 'entries'}: {text or 'none'}; errors of the tool: {wrong}"


def full(entry: Entry, width: int | None = None) -> str:
    """One entry with everything that a reader needs to check it by hand.

    Parameters
    ----------
    entry : Entry
        Settled.
    width : int, optional
        Signs a line; that of the terminal, at most 120, if left out.
    """
    width = width or min(120, shutil.get_terminal_size((100, 20)).columns)
    claim = entry.claim
    lines = [f"{MARKS[entry.verdict]} {claim.id}   {claim.item}   {claim.title}",
             f"  verdict     {entry.label}"]

    def put(label: str, text: str) -> None:
        if text:
            lines.extend(textwrap.wrap(text, width, initial_indent=f"  {label:<11} ", subsequent_indent=" " * 14))

    put("claim", claim.prose)
    if claim.printed and len(claim.printed) == len(claim.corrected):
        for printed, corrected in zip(claim.printed, claim.corrected, strict=True):
            lines += _aligned(printed, corrected, width)
    else:
        for text in claim.printed:
            put("printed", str(parse_relation(text)))
        for text in claim.corrected:
            put("corrected", str(parse_relation(text)))
    put("edit", claim.edit)
    put("setting", claim.setting.text)
    put("assuming", "; ".join([*map(str, claim.setting.hypotheses), *claim.assumptions]))
    put("rests on", claim.cited)
    put("slip of", f"the {claim.origin}: {claim.why}" if claim.origin else claim.why)
    for number, finding in enumerate(entry.findings):
        lines += _finding(finding, width, entry.findings[number - 1] if number else None)
    for run in claim.trajectories:
        put("trajectory", f"{run.scenario}: {run.text}" + (f" ({run.command})" if run.command else ""))
    put("units", "; ".join(entry.unit_faults) or ("agree" if claim.printed else ""))
    put("affects", ", ".join(claim.consequences))
    put("note", claim.note)
    put("kernels", ", ".join(entry.kernels))
    for error in entry.errors:
        put("ERROR", error)
    return "\n".join(lines)


def _aligned(printed: str, corrected: str, width: int) -> list[str]:
    """The two formulas one under the other, broken at the same places, with the difference underlined."""
    above, below, marks = "", "", ""
    for kind, piece in difference(printed, corrected):
        if kind == "=":
            size = max(len(above), len(below))
            above, below = above.ljust(size) + piece, below.ljust(size) + piece
            marks = marks.ljust(size) + " " * len(piece)
        elif kind == "-":
            start = max(len(above), len(below))
            above = above.ljust(start) + piece
            below, marks = below.ljust(start), marks.ljust(start) + "^" * len(piece)
        else:
            start = len(below)
            below += piece
            marks = marks[:start].ljust(start) + "^" * max(len(piece), len(marks) - start)
    room = max(30, width - 14)
    lines, start, end = [], 0, max(len(above), len(below))
    while start < end:
        stop = _break(above, below, start, room)
        for label, text in (("printed", above), ("corrected", below), ("", marks)):
            if text[start:stop].strip():
                lines.append(f"  {label if start == 0 else '':<11} {text[start:stop].rstrip()}")
        start = stop
    return lines


def _break(above: str, below: str, start: int, room: int) -> int:
    """Where to end a line: at the last blank that both texts have, else at the full width."""
    if start + room >= max(len(above), len(below)):
        return start + room
    for stop in range(start + room, start + room // 2, -1):
        if above[stop - 1:stop] in ("", " ") and below[stop - 1:stop] in ("", " "):
            return stop
    return start + room


_WORDS = {
    "identity": "residual 0, exactly",
    "squares": "sum of squares",
    "counterexample": "counterexample",
}


def _finding(finding: Finding, width: int, before: Finding | None = None) -> list[str]:
    """A finding; of several formulas under one text the text is shown once."""
    truth = {True: "true", False: "false", None: "NOT SETTLED"}[finding.true]
    head = f"{finding.role}: {finding.text}" if finding.text else finding.role
    lines = textwrap.wrap(f"{head}: {truth} ({_WORDS.get(finding.kind, finding.kind)})", width,
                          initial_indent=f"  {'finding':<11} ", subsequent_indent=" " * 14)
    same = ("role", "text", "kind", "true")
    if before and finding.text and finding.kind == "identity" and all(getattr(before, a) == getattr(finding, a) for a in same):
        lines = []
    detail = finding.detail
    wrapped: list[str] = []
    if finding.role not in ("printed", "corrected") and finding.statement:
        wrapped.append(finding.statement)
    if finding.kind == "counterexample":
        zeros = [name for name, value in detail["point"].items() if value == "0"]
        others = ", ".join(f"{name} = {value}" for name, value in detail["point"].items() if value != "0")
        wrapped.append(f"at {others}" + (f"; zero: {', '.join(zeros)}" if zeros else ""))
        if detail["values"]:
            wrapped.append("there " + ", ".join(f"{name} = {value}" for name, value in detail["values"].items()))
        wrapped.append(f"left = {detail['left']}, right = {detail['right']}")
    if finding.kind == "squares":
        terms = " + ".join(f"({one['weight']})*({one['base']})**2" for one in detail["squares"])
        wrapped.append(f"difference = {terms or '0'}")
    if detail.get("residual", "0") not in ("", "0"):  # an inequality has none
        wrapped.append(f"left - right = {detail['residual']}")
    if "found" in detail:
        wrapped.append(str(detail["found"]))
    for text in wrapped:
        lines += textwrap.wrap(text, width, initial_indent=" " * 14, subsequent_indent=" " * 16)
    return lines
