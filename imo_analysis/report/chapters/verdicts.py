"""The first screen: how much of the paper holds, what falls, and what to do about it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from imo_analysis.ledger.claim import Entry, Verdict
from imo_analysis.paper.item import PAPER
from imo_analysis.report.chapters.ledger import WORDS, anchor, badge, label
from imo_analysis.report.page import Html, inline, join, tag
from imo_analysis.report.words import typeset
from imo_analysis.study import Study

SHOWN = 7


def counts(entries: Sequence[Entry]) -> dict[str, int]:
    """Entries by verdict, in the order of the tiles; those that nothing settled count as ``not settled``."""
    found = Counter(entry.verdict for entry in entries)
    result = {str(verdict): found[verdict] for verdict in WORDS}
    return result | ({"not settled": found[None]} if found[None] else {})


def reach(entries: Sequence[Entry]) -> dict[str, int]:
    """For each entry, how many others fall or change with it, at any distance along the links."""
    direct = {entry.claim.id: _expanded(entry.claim.consequences, entries) for entry in entries}
    result = {}
    for start in direct:
        seen: set[str] = set()
        waiting = list(direct[start])
        while waiting:
            one = waiting.pop()
            if one not in seen and one != start:
                seen.add(one)
                waiting.extend(direct.get(one, ()))
        result[start] = len(seen)
    return result


def _expanded(links: Sequence[str], entries: Sequence[Entry]) -> list[str]:
    """Ids of entries; a link to a whole item stands for all of its rows."""
    return [entry.claim.id for link in links for entry in entries
            if entry.claim.id == link or entry.claim.id.startswith(f"{link}.")]


def headline(entries: Sequence[Entry], shown: int = SHOWN) -> list[Entry]:
    """The entries that a reader must know first: those that do not hold, ordered by how much falls with them."""
    weight = reach(entries)
    wrong = [entry for entry in entries if entry.verdict in (Verdict.FAILS, Verdict.CORRECTED)]
    wrong.sort(key=lambda entry: (-weight[entry.claim.id], entry.verdict is not Verdict.FAILS))
    return wrong[:shown]


def first_screen(study: Study, entries: Sequence[Entry], found: Sequence[str]) -> Html:
    """The title, the verdicts as numbers, what falls, and what the runs show.

    Parameters
    ----------
    study : Study
    entries : sequence of Entry
    found : sequence of str
        Findings of the other chapters, a sentence each.
    """
    numbers = counts(entries)
    tiles = [
        tag("li", tag("a", tag("b", numbers[str(verdict)]), tag("span", f"{word}: {meaning}"), class_=f"tile {kind}",
                      href="#ledger", data_verdict=kind))
        for verdict, (kind, word, meaning) in WORDS.items()
    ]
    weight = reach(entries)
    wrong = [tag("li", badge(entry.verdict), _finding(entry, weight[entry.claim.id])) for entry in headline(entries)]
    return join(
        [
            tag("p", "An audit by machine", class_="soft"),
            tag("h1", "What holds in an adaptive Luenberger observer for speed-sensorless induction machines"),
            tag("p", f"The paper: {PAPER} (MERL TR2018-090).", class_="soft"),
            tag("p", inline(
                f"Every equation, table and claim of the paper was transcribed, derived again and judged by exact arithmetic: "
                f"{len(entries)} entries. The same definitions were then linearised and simulated."), class_="lead"),
            tag("ul", *tiles, class_="tiles"),
            tag("h3", "What falls, and what to do about it"),
            tag("ul", *wrong, class_="findings"),
            tag("h3", "What the numbers show"),
            tag("ul", *(tag("li", typeset(line)) for line in found)),
            tag("p", f"Study: {study.title}, SHA-256 {study.sha256[:12]}…", class_="note"),
        ]
    )


def _finding(entry: Entry, reached: int) -> Html:
    claim = entry.claim
    head = tag("a", label(entry), href=f"#{anchor(claim.id)}")
    others = f" {reached} other entries fall or change with it." if reached > 1 else " One other entry falls or changes with it." if reached else ""
    todo = tag("p", Html("To do: "), typeset(claim.edit), class_="todo") if claim.edit else ""
    return tag("div", tag("p", head, Html(": "), typeset(claim.title), Html("."), others), todo)
