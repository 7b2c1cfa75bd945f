"""The chapter that reads like a referee's report: every statement of the paper, its verdict, and the evidence for it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby, zip_longest
from typing import Any

from imo_analysis.ledger.claim import Entry, Finding, Verdict
from imo_analysis.ledger.expression import parse_relation
from imo_analysis.ledger.latex import name_latex, relation_latex
from imo_analysis.report.math import difference
from imo_analysis.report.page import Chapter, Html, formula, inline, join, prose, tag
from imo_analysis.report.words import typeset

# verdict -> (class in the style sheet, word on the badge, what it means)
WORDS = {
    Verdict.HOLDS: ("holds", "holds", "true as printed"),
    Verdict.CORRECTED: ("corrected", "holds after correction", "true after the smallest edit, which is given"),
    Verdict.FAILS: ("fails", "fails", "false, with an exact counterexample"),
    Verdict.OPEN: ("open", "not determined", "the text does not say enough to tell"),
}
_KERNELS = {"sympy": "sympy", "flint": "FLINT", "coq": "Coq"}
_UNSETTLED = ("open", "not settled", "the checks do not settle it")


def words(verdict: Verdict | None) -> tuple[str, str, str]:
    """Class, badge and meaning of a verdict."""
    return WORDS[verdict] if verdict is not None else _UNSETTLED


def badge(verdict: Verdict | None) -> Html:
    """The verdict as a coloured word."""
    kind, word, _ = words(verdict)
    return tag("span", word, class_=f"badge {kind}")


def anchor(identifier: str) -> str:
    """The anchor of an entry."""
    return f"entry-{identifier}"


def link(identifier: str, entries: Sequence[Entry]) -> Html:
    """A link to an entry, or to the first of an item when the id names a whole item; plain text when it names neither."""
    for entry in entries:
        if entry.claim.id == identifier:
            return tag("a", typeset(label(entry)), href=f"#{anchor(identifier)}")
    for entry in entries:
        if entry.claim.id.startswith(f"{identifier}."):
            return tag("a", entry.claim.item or identifier, href=f"#{anchor(entry.claim.id)}")
    return tag("span", identifier)


def label(entry: Entry) -> str:
    """How the paper calls it: ``(12) i_qs`` for a row of a numbered equation or table, the place for a claim in the text."""
    number = entry.claim.item or entry.claim.id
    _, _, part = entry.claim.id.partition(".")
    return f"{number} {part}" if part and number.startswith(("(", "Table")) and part not in number else number


def ledger_chapter(entries: Sequence[Entry], checks: dict[str, Any]) -> Chapter:
    """All entries in the paper's order, each collapsed to a line.

    Parameters
    ----------
    entries : sequence of Entry
    checks : dict
        From `imo_analysis.report.checks.checks`.
    """
    counts = Counter(entry.verdict for entry in entries)
    own = sum(entry.claim.ours for entry in entries)
    ours = f", and {own} of our own, each marked so" if own else ""
    kernels = sorted({_KERNELS.get(kernel, kernel) for entry in entries for kernel in entry.kernels})
    faults = sum(not entry.ok for entry in entries)
    agreement = f"The kernels here are {' and '.join(kernels)}; " + (
        "they agree on every claim." if not faults else f"{faults} entries carry an error of the tool: do not trust them."
    )
    body = join(
        [
            prose(
                f"""
Every numbered equation row by row, the tables, the lemma, the propositions, the remark and the checkable claims of the text:
{len(entries) - own} entries{ours}. A line opens to what is printed and what is derived, one under the other with the
difference coloured, the correction, the assumptions, and the evidence. An identity is settled by exact rational algebra, a
false one by rational numbers that you can put in by hand, an inequality by a sum of squares. Where evidence is numerical it
says so. {agreement}
"""
            ),
            *_faults(checks),
            _tools(counts, len(entries)),
            *(entry_html(entry, entries) for entry in entries),
        ]
    )
    return Chapter("ledger", "Claims and findings", "What the paper claims, and what was found", body)


def _faults(checks: dict[str, Any]) -> list[Html]:
    """What became of seeded faults: a check that cannot fail shows nothing."""
    claims, code = checks["mutants"], checks["definition_mutants"]
    rejected = ", ".join(f"{count:,} rejected by {_KERNELS.get(name, name)}" for name, count in claims["rejected"].items())
    missed = [*claims["missed"], *code["survived"], *(f"no second form: {name}" for name in code["unchecked"])]
    parts = [
        prose(
            f"""
Every check was also given faults to find. Each sign, coefficient, exponent, index, hat and tilde of {claims["claims"]} true
formulas was changed in turn: {claims["tried"]:,} tried, {rejected}, {len(claims["equivalent"])} equal to the original (proved),
{len(claims["missed"])} missed. Each token of the {code["functions"]} definitions that are simulated was changed in turn
against a second, complex form: {code["tried"]:,} tried, {code["killed"]:,} found, {len(code["equivalent"])} equal,
{len(code["survived"])} missed. The command is `imo derive --mutants all`; `--kernel all` adds Coq.
"""
        )
    ]
    if missed:
        head = tag("summary", f"{len(missed)} that were not found")
        parts.append(tag("details", head, _list(map(inline, missed)), class_="more"))
    return parts


def _tools(counts: Counter[Verdict | None], total: int) -> Html:
    buttons = [tag("button", f"all {total}", type="button", data_verdict="", aria_pressed="true")]
    for verdict, (kind, word, _) in WORDS.items():
        buttons.append(tag("button", f"{word} {counts[verdict]}", type="button", data_verdict=kind, aria_pressed="false"))
    field = Html('<input type="search" placeholder="find, e.g. eq12 or alpha" aria-label="find entries">')
    more = tag("button", "open or close all", type="button", class_="expand")
    return tag("div", *buttons, field, more, tag("output", ""), class_="tools js-only", id="ledger-tools")


def entry_html(entry: Entry, entries: Sequence[Entry]) -> Html:
    """One entry: a line that opens."""
    claim = entry.claim
    kind, _, _ = words(entry.verdict)
    summary = tag("summary", tag("span", typeset(label(entry)), class_="ref"), tag("span", typeset(claim.title), class_="what"),
                  badge(entry.verdict))
    facts: list[tuple[str, Html]] = []

    def fact(name: str, *parts: object) -> None:
        content = join((part for part in parts if part), "")
        if content:
            facts.append((name, content))

    fact("statement", typeset(claim.prose))
    fact(*_forms(claim.printed, claim.corrected, side=0))
    fact(*_forms(claim.printed, claim.corrected, side=1))
    fact("correction", typeset(claim.edit))
    fact("units", inline("; ".join(entry.unit_faults)))
    if claim.origin:
        source = {"scan": "likely the scan", "paper": "likely the paper itself"}[claim.origin]
        fact("slip", typeset(f"{source}: {claim.why}" if claim.why else source))
    fact("setting", typeset(claim.setting.text))
    hypotheses = [inline(f"${relation_latex(one)}$") for one in claim.setting.hypotheses]
    fact("assumes", join(hypotheses, ", "), _list(map(typeset, claim.assumptions)))
    fact("evidence", *(_findings(list(group)) for _, group in groupby(entry.findings, key=_head)))
    fact("in motion", *(_trajectory(one.scenario, one.text, one.command) for one in claim.trajectories))
    fact("what falls or changes with it", join((link(one, entries) for one in claim.consequences), ", "))
    fact("note", typeset(claim.note))
    fact("errors of the tool", _list(map(inline, entry.errors)))
    fact("id", tag("code", claim.id), tag("span", f" (imo derive {claim.id})", class_="note"))
    inside = tag("dl", *(join([tag("dt", name), tag("dd", content)], "") for name, content in facts), class_="facts")
    return tag("details", summary, tag("div", inside, class_="inside"), class_=f"entry {kind}", id=anchor(claim.id),
               data_verdict=kind)


def _forms(printed: Sequence[str], corrected: Sequence[str], side: int) -> tuple[str, Html]:
    """The printed or the derived formulas, with what differs from the other side coloured."""
    name = ("printed", "derived")[side]
    formulas: list[Html] = []
    for one, other in zip_longest(map(_latex, printed), map(_latex, corrected)):
        if one is not None and other is not None:
            one, other = difference(one, other)
        wanted = (one, other)[side]
        if wanted is not None:
            formulas.append(formula(wanted))
    return name, join(formulas, "")


def _latex(text: str) -> str:
    return relation_latex(parse_relation(text))


def _list(parts: Iterable[Html]) -> Html:
    return join((tag("p", part) for part in parts), "")


_KINDS = {
    "identity": "exact: the two sides are the same rational function",
    "squares": "exact: the difference is a sum of squares with weights that are not negative",
    "counterexample": "exact counterexample",
    "computed": "computed in exact arithmetic",
    "numerical": "numerical evidence, not a proof",
}


def _head(finding: Finding) -> tuple[str, str, str, bool | None]:
    return finding.role, finding.text, finding.kind, finding.true


def _findings(alike: Sequence[Finding]) -> Html:
    """Findings with the same head: the head once, then what each adds."""
    role, text, kind, true = _head(alike[0])
    truth = {True: "true", False: "false", None: "not settled"}[true]
    head = tag("p", tag("b", f"{truth}: "), typeset(text), tag("span", f" ({_KINDS.get(kind, kind)})", class_="note"))
    shown = role not in ("printed", "corrected") or (len(alike) > 1 and kind == "counterexample")
    return tag("div", head, *(_detail(finding, shown) for finding in alike))


def _detail(finding: Finding, shown: bool) -> Html:
    """The formula where it is not above already, and what a reader needs to check it by hand."""
    parts = [formula(_latex(finding.statement))] if finding.statement and shown else []
    detail = finding.detail
    if "point" in detail:
        parts.append(tag("p", _point(detail["point"], detail.get("values", {}))))
        sides = f"${_number(detail['left'])}$ on the left, ${_number(detail['right'])}$ on the right"
        parts.append(tag("p", inline(sides)))
    for square in detail.get("squares", ()):
        parts.append(tag("p", inline(f"weight `{square['weight']}`, square of `{square['base']}`")))
    if detail.get("found"):
        parts.append(tag("p", typeset(detail["found"])))
    return join(parts, "")


def _point(point: dict[str, str], values: dict[str, str]) -> Html:
    """The free values, those that are zero last and together, then what follows from them."""
    def equations(names: Iterable[str], source: dict[str, str]) -> Html:
        return join((inline(f"${name_latex(name)} = {_number(source[name])}$") for name in names), ", ")

    zero = [name for name, value in point.items() if value == "0"]
    parts = [Html("at "), equations((name for name in point if name not in zero), point)]
    if zero:
        listed = ", ".join(f"${name_latex(name)}$" for name in zero)
        parts.append(inline(f", with {listed} zero" if len(zero) < 7 else ", and everything else zero"))
    if values:
        parts += [Html("; then "), equations(values, values)]
    return join(parts, "")


def _number(value: str) -> str:
    sign = "-" if value.startswith("-") else ""
    above, slash, below = value.removeprefix("-").partition("/")
    return f"{sign}\\frac{{{above}}}{{{below}}}" if slash else value


def _trajectory(scenario: str, words_: str, command: str) -> Html:
    shown = tag("code", command or f"imo simulate --scenario {scenario}")
    return tag("p", typeset(words_), Html(" "), shown)
