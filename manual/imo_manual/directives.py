"""The directives of the manual: what a page names, and the program itself fills in."""

from __future__ import annotations

import io
import json
import re
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives as options
from docutils.statemachine import StringList
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective, SphinxRole
from sphinx.util.parsing import nested_parse_to_nodes

from imo_analysis.drawing import svg_text
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import parse_relation
from imo_analysis.ledger.latex import relation_latex
from imo_analysis.machine import PRESETS
from imo_analysis.notation import SYMBOLS
from imo_analysis.svg import inside_page
from imo_analysis.tuning.formulas import written
from imo_analysis.tuning.rule import REGION
from imo_manual import facts, formulas
from imo_manual.docstrings import room_page, target
from imo_manual.names import modules, sections
from imo_manual.words import console, inline, paragraph, section, table, unit


class _Page(SphinxDirective):
    """A directive that fills the page from the program; a fault of the input becomes a Sphinx warning, so an error."""

    def run(self) -> list[nodes.Node]:
        """Fill in; the page is made anew at each build, since the program may have changed."""
        self.env.note_reread()
        try:
            return self.fill()
        except (InputError, KeyError, ImportError) as error:
            raise self.error(f"{self.name}: {error}") from error

    def fill(self) -> list[nodes.Node]:
        """The nodes."""
        raise NotImplementedError


def _formula(latex: str, number: str = "") -> nodes.math_block:
    node = nodes.math_block(latex, latex, nowrap=True, docname="", number=None)
    node["number_text"] = number
    return node


class Definition(_Page):
    """``definition``: the equations that a function of `imo_analysis.equations` stands for.

    The body has a line for each argument that is not a symbol of its own name: ``x = i_ds i_qs``. Left sides are the names that
    ``gives`` lists, or the sign of what is returned as a whole: a value, or a matrix with so many ``columns``.
    """

    required_arguments = 1
    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {
        "number": options.unchanged, "gives": options.unchanged, "rows": options.unchanged, "short": options.unchanged,
        "sign": options.unchanged, "columns": options.positive_int}

    def fill(self) -> list[nodes.Node]:
        """The rows as formulas; the number of the equation stands at the last."""
        given = dict(tuple(part.strip() for part in line.split("=", 1)) for line in self.content if line.strip())
        rows = formulas.equations(formulas.find(self.arguments[0]), given, self.options.get("gives", "").split(),
                                  self.options.get("short", "").split())
        if "rows" in self.options:
            first, _, last = self.options["rows"].partition("-")
            rows = rows[int(first) - 1 : int(last or first)]
        if "sign" in self.options:
            rows = [formulas.with_sign(rows, self.options["sign"], self.options.get("columns", 1))]
        source = f"{self.arguments[0]}".removeprefix("imo_analysis.equations.").replace(":", ".")
        said = nodes.paragraph(classes=["source"])
        said += [nodes.Text("from "), *_reference(self.env, f"imo_analysis.equations.{source}")]
        return [*(_formula(row, self.options.get("number", "") if row is rows[-1] else "") for row in rows), said]


class Observer(_Page):
    """``observer``: one observer of the catalogue with states, gains and equations."""

    required_arguments = 1

    def fill(self) -> list[nodes.Node]:
        """Its lines and formulas."""
        return _observer(self.env, self.arguments[0])


class Catalogue(_Page):
    """``catalogue``: all observers, first as a table, then each with its equations."""

    def fill(self) -> list[nodes.Node]:
        """A table and a section an observer."""
        rows = [(f"`{one.name}`", one.source, one.meaning, "yes" if one.needs_direction else "no")
                for one in OBSERVERS.values()]
        listed = table(("observer", "printed in", "what it is", "must be told the direction"), rows, (3, 3, 8, 3))
        return [listed, *(section(f"`{name}`", f"observer-{name}".replace("_", "-"), *_observer(self.env, name))
                          for name in OBSERVERS)]


def _observer(env: Any, name: str) -> list[nodes.Node]:
    one = OBSERVERS[name]
    base, rows = formulas.observer_equations(name)
    said = [paragraph(f"{one.meaning[0].upper()}{one.meaning[1:]}; source: {one.source}.")]
    states = nodes.paragraph()
    states += inline(f"States: {', '.join(f'`{state}`' for state in one.states)}. "
                     f"Gains: {', '.join(f'`{gain}`' for gain in one.gains)}. Definition: ")
    states += [*_reference(env, f"{one.rates.__module__}.{one.rates.__name__}"), nodes.Text(".")]
    said.append(states)
    if base:
        said.append(paragraph(f"As `{base}`, but for these rates (brackets: the rate of `{base}`):"))
    return [*said, *(_formula(row, number) for row, number in rows)]


def _reference(env: Any, full: str) -> list[nodes.Node]:
    node = addnodes.pending_xref("", refdomain="py", reftype="obj", reftarget=full, refexplicit=True, refwarn=True,
                                 refdoc=env.current_document.docname)
    node += nodes.literal(text=full.removeprefix("imo_analysis."))
    return [node]


class Notation(_Page):
    """``notation``: Table I and what is added to it."""

    def fill(self) -> list[nodes.Node]:
        """A table."""
        rows = [(f"${one.latex}$", f"`{one.name}`", unit(one.unit), one.meaning, one.source) for one in SYMBOLS.values()]
        return [table(("symbol", "name", "unit", "meaning", "source"), rows, (2, 3, 3, 8, 3))]


class StudyFields(_Page):
    """``study-fields``: every table of a study file with every field."""

    def fill(self) -> list[nodes.Node]:
        """A section a table."""
        found: list[nodes.Node] = []
        for one in facts.study_tables():
            rows = [(f"`{field.name}`", field.kind, unit(field.unit), field.bounds, f"`{field.default}`"
                     if field.default not in ("required", "none") else field.default, field.meaning) for field in one.fields]
            body = table(("key", "kind", "unit", "allowed", "default", "meaning"), rows, (3, 2, 2, 3, 3, 8))
            title = one.heading if one.heading[0] != "[" else f"`{one.heading}`"
            meaning = re.sub(r"^``\[+[\w.]+\]+``: ", "", one.meaning)
            found.append(section(title, "table-" + re.sub(r"\W+", "-", one.heading).strip("-").lower(),
                                 *([paragraph(meaning[:1].upper() + meaning[1:])] if meaning else []), body))
        return found


class Commands(_Page):
    """``commands``: every command with every option."""

    def fill(self) -> list[nodes.Node]:
        """A section a command."""
        found: list[nodes.Node] = []
        for one in facts.commands():
            rows = [(f"`{option.written}`", f"`{option.default}`" if option.default else "", option.meaning)
                    for option in one.options]
            body = table(("argument or option", "default", "meaning"), rows, (4, 2, 8))
            found.append(section(f"`imo {one.name}`", f"imo-{one.name}", paragraph(one.description.replace("\n", " ")), body,
                                 paragraph("For example:"), console(one.example)))
        return found


class Ledger(_Page):
    """``ledger-entries``: every entry of the paper's ledger with its verdict, settled while the manual is built."""

    def fill(self) -> list[nodes.Node]:
        """A table."""
        rows = [(f"`{one.claim.id}`", one.claim.item, one.claim.title, str(one.verdict), one.claim.edit) for one in _settled()]
        return [table(("entry", "the paper's number", "what it says", "verdict", "what puts it right"), rows, (3, 3, 6, 3, 6))]


class Entries(_Page):
    """``entry``: entries of the ledger in full: printed and corrected formulas, verdict, what puts it right."""

    required_arguments = 1

    def fill(self) -> list[nodes.Node]:
        """All entries whose id is the argument or begins with it and a dot."""
        wanted = self.arguments[0]
        chosen = [one for one in _settled() if one.claim.id == wanted or one.claim.id.startswith(f"{wanted}.")]
        if not chosen:
            raise InputError(f"there is no entry {wanted!r} in the ledger")
        found: list[nodes.Node] = []
        for one in chosen:
            claim = one.claim
            head = nodes.paragraph(classes=["entry"])
            head += [nodes.strong(text=f"{claim.item}, {claim.title}: {one.verdict}"), nodes.Text(" ("),
                     nodes.literal(text=f"imo derive {claim.id}"), nodes.Text(")")]
            found.append(head)
            for word, texts in (("printed", claim.printed), ("corrected", claim.corrected)):
                rows = [texts] if isinstance(texts, str) else list(texts or ())
                found += [_formula(relation_latex(parse_relation(row)), word if claim.corrected else "") for row in rows if row]
            if claim.edit:
                found.append(paragraph(f"What puts it right: {claim.edit}."))
        return found


@cache
def _settled() -> list[Any]:
    from imo_analysis.ledger.book import entries

    return entries()


class Presets(_Page):
    """``presets``: the built-in machines with their sources."""

    def fill(self) -> list[nodes.Node]:
        """A table."""
        rows = [(f"`{name}`", f"{one.alpha:.4f} /s", one.source) for name, one in PRESETS.items()]
        return [table(("preset", r"$\alpha$", "source"), rows, (3, 2, 8))]


class Room(_Page):
    """``room``: the modules of a room with all public names."""

    required_arguments = 1

    def fill(self) -> list[nodes.Node]:
        """Sections made from the docstrings."""
        lines = room_page(self.arguments[0])
        if not lines:
            raise InputError(f"there is no room {self.arguments[0]!r}")
        place = f"<docstrings of {self.arguments[0]}>"
        return nested_parse_to_nodes(self.state, StringList(lines, source=place), source=place, allow_section_headings=True)


class Chosen(_Page):
    """``chosen``: names with the first sentence of their docstrings, one a line of the body."""

    has_content = True

    def fill(self) -> list[nodes.Node]:
        """A table of links."""
        docs = {one.full: one.doc for module in modules() for one in module.public}
        rows: list[tuple[Any, ...]] = []
        for line in self.content:
            name = f"imo_analysis.{line.strip()}"
            if name not in docs:
                raise InputError(f"{name} is not a public name")
            link = nodes.paragraph()
            link += _reference(self.env, name)
            rows.append((link, sections(docs[name])[""].split("\n\n")[0].replace("\n", " ")))
        return [table(("name", "what it is"), rows, (4, 6))]


class GainRule(_Page):
    """``gain-rule``: the formulas of the rule of thumb for gains, and where they hold."""

    def fill(self) -> list[nodes.Node]:
        """A paragraph and its formulas, by what they are for; then the region of validity."""
        found: list[nodes.Node] = []
        for heading, lines in written():
            said = nodes.paragraph()
            said += inline(f"For {heading}:")
            found += [said, *(_formula(line) for line in lines)]
        for text in REGION:
            found.append(paragraph(text))
        return found


class Replayed(_Page):
    """``replayed``: the errors of every observer in a file of ``imo replay --json``, whose place is the argument."""

    required_arguments = 1

    def fill(self) -> list[nodes.Node]:
        """A table."""
        _, place = self.env.relfn2path(self.arguments[0])
        self.env.note_dependency(place)
        data = json.loads(Path(place).read_text(encoding="utf-8"))
        keys = ("std", "smoothed", "mean", "peak")
        rows = [(f"`{name}`", *(f"{one[f'speed_error_{key}']:.2g}" for key in keys), f"{100 * one['current_error_share']:.2g}")
                for name, one in data["observers"].items()]
        over = 1e3 * data["rows"] * data["sample_time"] / 1000
        head = ("observer", "deviation (rad/s)", f"over {over:.2g} ms", "mean", "largest", "current error (%)")
        return [table(head, rows, (4, 2, 2, 2, 2, 2))]


class Drawn(_Page):
    """``drawn``: the figure that the Python block before it leaves in ``figure``; its argument says what it shows."""

    required_arguments = 1
    final_argument_whitespace = True

    def fill(self) -> list[nodes.Node]:
        """The figure, its text as text, and the caption."""
        source = Path(self.env.doc2path(self.env.current_document.docname)).read_text(encoding="utf-8").splitlines()
        blocks = re.findall(r"^```python\n(.*?)^```$", "\n".join(source[:self.lineno]), re.DOTALL | re.MULTILINE)
        names: dict[str, Any] = {}
        with redirect_stdout(io.StringIO()):
            exec(compile(blocks[-1], self.env.current_document.docname, "exec"), names)
        svg = inside_page(svg_text(names["figure"]), f"drawn{self.lineno}", self.arguments[0])
        whole = nodes.figure()
        whole += nodes.raw("", f'<div class="drawn">{svg}</div>', format="html")
        whole += nodes.caption("", self.arguments[0])
        return [whole]


class PyName(SphinxRole):
    """A name in single backticks in a docstring: a link where it is a name of the package, else code."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """The nodes."""
        context = self.env.current_document.get("ref_context", None) or self.env.ref_context
        full = target(self.text, context.get("py:module", ""), context.get("py:class") or "")
        if not full:
            return [nodes.literal(text=self.text)], []
        node = addnodes.pending_xref("", refdomain="py", reftype="mod" if full in _modules() else "obj", reftarget=full,
                                     refexplicit=True, refwarn=True, refdoc=self.env.current_document.docname)
        node += nodes.literal(text=self.text)
        return [node], []


def _modules() -> set[str]:
    return {module.name for module in modules()}


def setup(app: Sphinx) -> None:
    """Register the directives and the default role."""
    for name, directive in (
        ("definition", Definition), ("observer", Observer), ("catalogue", Catalogue), ("notation", Notation),
        ("study-fields", StudyFields), ("commands", Commands), ("ledger-entries", Ledger), ("presets", Presets),
        ("room", Room), ("chosen", Chosen), ("entry", Entries), ("gain-rule", GainRule),
        ("replayed", Replayed), ("drawn", Drawn),
    ):
        app.add_directive(name, directive)
    app.add_role("pyname", PyName())
