"""The first screen: how much of the paper holds, what falls, and what to do about it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from imo_analysis.ledger.claim import Entry, Verdict
from imo_analysis.ledger.show import counts
from imo_analysis.paper.item import PAPER
from imo_analysis.report.chapters.ledger import WORDS, anchor, badge, label
from imo_analysis.report.page import Html, inline, join, tag
from imo_analysis.report.words import typeset
from imo_analysis.study import Study

SHOWN = 6
_NUMBER = re.compile(r" \d+$")  # Repair 1, Repair 2: repairs


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


_RESULTS = ("Proposition", "Lemma")


def _is_result(entry: Entry) -> bool:
    return entry.claim.item.startswith(_RESULTS) or entry.claim.item == "Table II"


@dataclass(frozen=True)
class Headline:
    """Entries that one line of the first screen speaks of: parts of one item that need the same edit."""

    entries: tuple[Entry, ...]
    reached: int


def results(entries: Sequence[Entry]) -> list[Headline]:
    """The paper's results, lemma, propositions and Table II, that do not hold as printed."""
    return _grouped([entry for entry in _wrong(entries) if _is_result(entry)], reach(entries))


def causes(entries: Sequence[Entry], shown: int = SHOWN) -> list[Headline]:
    """The other entries that do not hold, those first with which most falls."""
    weight = reach(entries)
    others = [entry for entry in _wrong(entries) if not _is_result(entry)]
    grouped = _grouped(others, weight)
    grouped.sort(key=lambda one: (-one.reached, one.entries[0].verdict is not Verdict.FAILS))
    return grouped[:shown]


def _wrong(entries: Sequence[Entry]) -> list[Entry]:
    return [entry for entry in entries if entry.verdict in (Verdict.FAILS, Verdict.CORRECTED)]


def _grouped(entries: Sequence[Entry], weight: dict[str, int]) -> list[Headline]:
    groups: dict[tuple[str, str, object], list[Entry]] = {}
    for entry in entries:
        groups.setdefault((entry.claim.item, entry.claim.edit or entry.claim.id, entry.verdict), []).append(entry)
    return [Headline(tuple(group), max(weight[entry.claim.id] for entry in group)) for group in groups.values()]


def first_screen(study: Study, entries: Sequence[Entry], found: Sequence[str], own: Html | None = None) -> Html:
    """The title, the verdicts as numbers, what falls, and what the runs show.

    Parameters
    ----------
    study : Study
    entries : sequence of Entry
    found : sequence of str
        Findings of the other chapters, a sentence each.
    own : Html, optional
        What stands above the paper's verdicts: the findings on a machine that is not the paper's.
    """
    papers = [entry for entry in entries if not entry.claim.ours]
    numbers = counts(papers)
    tiles = [
        tag("li", tag("a", tag("b", numbers[str(verdict)]), " ", tag("span", f"{word}: {meaning}"), class_=f"tile {kind}",
                      href="#ledger", data_verdict=kind))
        for verdict, (kind, word, meaning) in WORDS.items()
    ]
    topic = "an adaptive Luenberger observer for speed-sensorless induction machines"
    audit = tag("p", inline(
        "Every equation, table and claim of the paper was transcribed, derived again and judged by exact arithmetic: "
        f"{len(papers)} entries. The same definitions were then linearised and simulated."), class_="lead")
    cited = tag("p", f"The paper: {PAPER}.", class_="soft")
    listed = tag("ul", *(tag("li", typeset(line)) for line in found))
    shown: tuple[Html, ...] = (tag("h2", "What the numbers show", class_="sub"), listed)
    title: tuple[Html, ...]
    if own:
        title = (tag("p", study.title, class_="soft"), tag("h1", "Which observers of speed work on this machine"), own,
                 tag("details", tag("summary", "What else the numbers show"), listed, class_="more"),
                 tag("h2", f"About the paper, not this machine: what holds in {topic}", class_="sub"), cited, audit)
        shown = ()
    else:
        title = (tag("p", "An audit by machine", class_="soft"), tag("h1", f"What holds in {topic}"), cited, audit)
    return join(
        [
            *title,
            tag("ul", *tiles, class_="tiles"),
            _ours([entry for entry in entries if entry.claim.ours]),
            tag("h2", "What changes or falls", class_="sub"),
            _list(results(entries)),
            tag("h2", "Why, and what to do about it", class_="sub"),
            _list(causes(entries)),
            *shown,
            tag("p", f"Study: {study.title}, SHA-256 {study.sha256[:12]}…", class_="note"),
        ]
    )


def _ours(entries: Sequence[Entry]) -> Html:
    """The entries that the paper does not have, counted apart: by topic, and by how they stand."""
    if not entries:
        return Html("")
    topics = Counter(_NUMBER.sub("s", entry.claim.item.removesuffix(" (ours)").lower()) for entry in entries)
    listed = ", ".join(f"{topic} {count}" for topic, count in topics.items())
    cited = sum(bool(entry.claim.cited) for entry in entries)
    proved = sum(_proved(entry) for entry in entries)
    words = [f"Besides, of our own: {len(entries)} ({listed}), {'all' if proved == len(entries) else proved} proved"]
    words += [f"{cited} of them with a theorem that is cited"] if cited else []
    return tag("p", ", ".join(words), ".", class_="note ours")


def _proved(entry: Entry) -> bool:
    """Whether it holds by exact evidence alone."""
    return entry.ok and entry.verdict is Verdict.HOLDS and all(one.kind != "numerical" for one in entry.findings)


def _list(lines: Sequence[Headline]) -> Html:
    return tag("ul", *(tag("li", badge(one.entries[0].verdict), _line(one)) for one in lines), class_="findings")


def _line(one: Headline) -> Html:
    claim = one.entries[0].claim
    heads = join((tag("a", typeset(label(entry)), href=f"#{anchor(entry.claim.id)}") for entry in one.entries), ", ")
    others = "" if not one.reached else f" {one.reached} other entries fall or change with it." if one.reached > 1 else (
        " One other entry falls or changes with it.")
    todo = tag("p", Html("To do: "), typeset(claim.edit), class_="todo") if claim.edit else ""
    return tag("div", tag("p", heads, Html(": "), typeset(claim.title), Html("."), others), todo)
