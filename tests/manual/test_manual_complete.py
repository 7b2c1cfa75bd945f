"""Everything public is documented: names, arguments, symbols, fields of a study, options; and each check can fail."""

import ast
import copy
import re
from functools import cache

import pytest
from documents import MANUAL, blocks, pages
from imo_manual import facts
from imo_manual.docstrings import target
from imo_manual.names import Module, Public, documented, modules, read_module, sections

from imo_analysis import notation
from imo_analysis.errors import InputError
from imo_analysis.notebooks import sources
from imo_analysis.study_tables import Seconds, Table

MODULES = modules()


def _every(module: Module) -> list[Public]:
    return [one for public in module.public for one in (public, *public.members)]


# Names ----------------------------------------------------------------------------------------------------------------
def bare(module: Module) -> list[str]:
    """Public names without a docstring."""
    return [one.full for one in _every(module) if not one.doc.strip()]


def test_every_public_name_has_a_docstring() -> None:
    assert len(MODULES) > 150 and all(module.doc for module in MODULES)
    assert not [fault for module in MODULES for fault in bare(module)]


def test_every_public_name_is_in_the_reference() -> None:
    rooms = set(re.findall(r"\.\. room:: (\w+)", "".join(page.read_text() for page in MANUAL.rglob("*.rst"))))
    whole = {module.name.split(".")[1] for module in MODULES if module.name.count(".") > 1}
    assert whole | {"top"} == rooms, "each room has a page in manual/reference/names/"


# Arguments ------------------------------------------------------------------------------------------------------------
def chosen() -> list[str]:
    """The names that the manual offers to people who write Python."""
    text = (MANUAL / "reference" / "python.md").read_text(encoding="utf-8")
    listed = [line.strip() for block in re.findall(r"```\{chosen\}\n(.*?)```", text, re.DOTALL) for line in block.splitlines()]
    return [f"imo_analysis.{line}" for line in listed if line]


def unexplained(one: Public) -> list[str]:
    """Arguments that the docstring's Parameters or Attributes leave out, with a type or without."""
    known = documented(one.doc)
    return [f"{one.full}({argument.name})" for argument in one.arguments if argument.name not in known]


def unnamed(module: Module, typed: bool = True) -> list[str]:
    """Arguments that are no symbols and no docstring (own, of class, module, room) names; nor, if ``typed``, have a type."""
    found = []
    for public in module.public:
        for one in (public, *public.members):
            words = set(re.findall(r"\w+", f"{_room_doc(module)} {module.doc} {public.doc} {one.doc}"))
            found += [f"{one.full}({argument.name})" for argument in one.arguments
                      if not (typed and argument.annotation) and argument.name not in words and not _symbol(argument.name)]
    return found


def definitions() -> list[Module]:
    """The modules of `imo_analysis.equations`, which are public as a whole."""
    return [module for module in MODULES if module.name.startswith("imo_analysis.equations")]


def imported(source: str) -> set[str]:
    """Full names that a script takes out of modules of this package."""
    return {f"{node.module}.{one.name}" for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom)
            and (node.module or "").partition(".")[0] == "imo_analysis" for one in node.names}


def inner(source: str) -> list[str]:
    """Functions and classes that a script for readers uses, and that the manual does not offer."""
    known = {one.full for module in MODULES for one in module.public if ".exercises." not in module.name}
    public = {*chosen(), *(one.full for module in definitions() for one in module.public)}
    return sorted(imported(source) & known - public)


def _room_doc(module: Module) -> str:
    """What the package of the module says: conventions of its whole room."""
    return next((one.doc for one in MODULES if one.name == module.name.rpartition(".")[0] and one.name != "imo_analysis"), "")


def _symbol(name: str) -> bool:
    """Whether the table of notation has it, or its second table of shorthands."""
    while True:
        if name in notation.SHORTHANDS:
            return True
        try:
            notation.symbol(name)
            return True
        except InputError:
            base, _, suffix = name.rpartition("_")
            if suffix not in ("hat", "tilde", "dot") or not base:
                return False
            name = base


def offered() -> list[Public]:
    names = {one.full: one for module in MODULES for one in module.public}
    return [one for name in chosen() for one in (names[name], *names[name].members)]


def test_every_argument_of_what_is_offered_is_explained() -> None:
    assert len(chosen()) > 100 and len(set(chosen())) == len(chosen())
    assert not [fault for one in offered() for fault in unexplained(one)]


def test_every_argument_of_a_definition_is_explained() -> None:
    assert len(definitions()) > 15
    assert not [fault for module in definitions() for fault in unnamed(module, typed=False)]


def test_a_new_argument_of_a_definition_is_found() -> None:
    module = planted("x, name: str", "x, wish: float, name: str")
    assert unnamed(module, typed=False) == ["imo_analysis.planted.gain(wish)"] and not unnamed(module)


def test_every_other_argument_has_a_meaning_or_a_type() -> None:
    assert not [fault for module in MODULES for fault in unnamed(module)]


def test_what_readers_are_shown_is_offered() -> None:
    """README, manual and lessons use public names only."""
    scripts = [block.text for page in pages() for block in blocks(page.read_text(encoding="utf-8")) if block.kind == "python"]
    scripts += [path.read_text(encoding="utf-8") for path in sources("course")]
    assert len(scripts) > 20 and len(set().union(*map(imported, scripts))) > 60
    assert not [fault for script in scripts for fault in inner(script)]


def test_a_new_argument_of_what_is_offered_is_found() -> None:
    """Written into the very source of each: a name without a word about it, with a type and a default."""
    for name in chosen():
        module, _, short = name.rpartition(".")
        tree = next(one.tree for one in MODULES if one.name == module)
        node = copy.deepcopy(next(one for one in tree.body if getattr(one, "name", "") == short))
        wish = ast.parse("def f(*, wish: float = 0.0): ...").body[0].args  # type: ignore[attr-defined]
        if isinstance(node, ast.FunctionDef):
            node.args.kwonlyargs += wish.kwonlyargs
            node.args.kw_defaults += wish.kw_defaults
        elif made := [one for one in node.body if getattr(one, "name", "") == "__init__"]:  # type: ignore[attr-defined]
            made[0].args.kwonlyargs += wish.kwonlyargs
            made[0].args.kw_defaults += wish.kw_defaults
        else:
            node.body.append(ast.parse("wish: float = 0.0").body[0])  # type: ignore[attr-defined]
        changed = read_module(ast.unparse(node), module).public[0]
        assert unexplained(changed) == [f"{name}(wish)"]


def test_an_inner_name_in_an_example_is_found() -> None:
    assert inner("from imo_analysis.report.metrics import resting") == ["imo_analysis.report.metrics.resting"]
    assert not inner("from imo_analysis.study import Study\nfrom imo_analysis.equations.plant import plant\nimport numpy")


# Symbols --------------------------------------------------------------------------------------------------------------
_HEADS = {name.partition("_")[0] for name in (*notation.SYMBOLS, *notation.SHORTHANDS)}
_TOKEN = re.compile(r"(?<![\w.`/])`{0,2}([A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)+)(?![\w(])(?!\.\w)")
_DEFINED = re.compile(r"``\(([^)`]*)\)``|((?:[A-Za-z]\w*, )*[A-Za-z]\w*) =")

# what a docstring defines in words, beside a formula: place -> symbols
LOCAL = {
    "imo_analysis.equations": "z_feedback",
    "imo_analysis.excitation.ripple": "w_i w_s",
    "imo_analysis.excitation.swing.shape_of": "w_i",
    "imo_analysis.ledger.claims.simulation.table_iii_alpha": "sigma_r",
    "imo_analysis.ledger.claims.supervisor.window": "m_2",
    "imo_analysis.pencils.reduced": "w_s",
    "imo_analysis.pencils.settling": "i_ds_noise i_qs_noise",
    "imo_analysis.pencils.sweep.pole_sweep": "R_r_error",
    "imo_analysis.replay.columns.role_of": "i_alpha",
    "imo_analysis.simulation.kernel.kernel": "g_0 g_n",
}


@cache
def _known() -> set[str]:
    """Names of modules, functions and fields of studies."""
    public = {one.name.rpartition(".")[2] for other in MODULES for one in (other, *_every(other))}
    return public | {part for table in facts.study_tables() for field in table.fields for part in field.name.split(".")}


def strange(module: Module) -> list[str]:
    """Words in docstrings that look like a symbol of the paper and are none.

    A word looks like one if it has an underscore and its first part is the letter of a symbol: ``omega_hat``, ``L_m``, ``k_1``.
    It is one if the notation has it, with any suffixes; or if it is a name of the module's own code; or if the docstring, or
    that of the module, says what it is: by ``name =`` or in a tuple in backticks, ``(g_11, g_12)``.
    """
    own = {node.id for node in ast.walk(module.tree) if isinstance(node, ast.Name)}
    own |= {node.arg for node in ast.walk(module.tree) if isinstance(node, ast.arg)}
    own |= {node.attr for node in ast.walk(module.tree) if isinstance(node, ast.Attribute)}
    own |= {node.name for node in ast.walk(module.tree) if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    own |= {node.arg for node in ast.walk(module.tree) if isinstance(node, ast.keyword) and node.arg}
    own |= {word for node in ast.walk(module.tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)
            and " " not in node.value for word in [node.value]}
    found = []
    for full, doc in [(module.name, module.doc), *((one.full, one.doc) for one in _every(module))]:
        said = {word for pair in _DEFINED.findall(f"{module.doc}\n{doc}") for word in re.findall(r"\w+", " ".join(pair))}
        for word in _TOKEN.findall(doc):
            if word.partition("_")[0] in _HEADS and not _symbol(word) and word not in own | said | _known():
                found.append(f"{full}: {word}")
    return found


def test_every_symbol_in_a_docstring_is_in_the_notation() -> None:
    found = {fault for module in MODULES for fault in strange(module)}
    local = {f"{place}: {word}" for place, words in LOCAL.items() for word in words.split()}
    assert not found - local, "a slip; or a symbol for notation.SHORTHANDS; or one that the docstring defines, for LOCAL"
    assert not local - found, "no longer needed"


def dead(module: Module) -> list[str]:
    """Dotted names in single backticks, or names of functions of this package, that lead nowhere."""
    found = []
    for full, doc in [(module.name, module.doc), *((one.full, one.doc) for one in _every(module))]:
        for text in re.findall(r"(?<![`\w])`([A-Za-z_][\w.]*\.[\w.]+)`(?!`)", doc):
            first = text.partition(".")[0]
            ours = first == "imo_analysis" or any(first == one.name.split(".")[1] for one in MODULES if "." in one.name)
            if ours and not target(text, module.name) and not _constant(text):
                found.append(f"{full}: {text}")
    return found


def _constant(text: str) -> bool:
    name, _, last = text.rpartition(".")
    return any(last in one.constants for one in MODULES if one.name.endswith(name))


def test_names_in_docstrings_lead_somewhere() -> None:
    assert not [fault for module in MODULES for fault in dead(module)]


# Study fields and options ---------------------------------------------------------------------------------------------
def silent(tables: list[facts.StudyTable]) -> list[str]:
    """Fields without a meaning, and quantities without a unit."""
    fields = [field for table in tables for field in table.fields]
    return [f"{field.table} {field.name}" for field in fields
            if not field.meaning or not field.default or (field.kind in ("number", "list of numbers") and not field.unit)]


def test_every_field_of_a_study_has_unit_default_and_meaning() -> None:
    tables = facts.study_tables()
    assert sum(len(one.fields) for one in tables) > 80
    assert not silent(tables)


def alike(tables: list[facts.StudyTable]) -> list[str]:
    """Fields of a table that share a text, so that no reader knows which of them it is about."""
    texts = [(field.table, field.meaning) for table in tables for field in table.fields]
    return [f"{table}: {meaning}" for table, meaning in sorted(set(texts)) if texts.count((table, meaning)) > 1]


def test_every_field_has_a_text_of_its_own() -> None:
    assert alike(facts.study_tables()) == []


def test_the_two_keys_that_are_no_parameters_work(tmp_path) -> None:
    from imo_analysis.study import Study

    (tmp_path / "machine.toml").write_text('[machine]\npreset = "table-iii"\n')
    data = Study.paper().data
    for given in ({"file": "machine.toml"}, {"preset": "table-iii"}):
        study = Study.from_data({**data, "machine": {**given, "R_s": 0.5}}, "test", tmp_path)
        assert study.machine.R_s == 0.5 and study.machine.R_r == 0.41


def test_every_option_has_help() -> None:
    commands = facts.commands()
    assert sum(len(one.options) for one in commands) > 60
    assert not [f"imo {one.name} {option.written}" for one in commands for option in one.options if not option.meaning.strip()]
    assert not [one.name for one in commands if not (one.description.strip() and one.example)]


# Mutants: each check above must be able to fail -----------------------------------------------------------------------
SOURCE = '''"""A module. The rate is alpha_hat_dot, from ``L_m`` and `machine.InductionMachine`; chi_2 = 3."""


def gain(k_1, x, name: str):
    """The gain k_1 on x, with `chi_2` and v_1_hat.

    Parameters
    ----------
    k_1, x : float
        In 1/s.
    name : str
        Whose.
    """


class Law:
    """A law.

    Attributes
    ----------
    g : float
        In 1/s.
    """

    g: float

    def rate(self, i_tilde):
        """The rate."""
'''


def planted(old: str, new: str) -> Module:
    assert SOURCE.count(old) >= 1
    return read_module(SOURCE.replace(old, new), "imo_analysis.planted")


def test_the_planted_module_is_clean() -> None:
    module = read_module(SOURCE, "imo_analysis.planted")
    assert not bare(module) and not unnamed(module) and not strange(module) and not dead(module)
    assert not [fault for one in module.public for fault in unexplained(one)]


@pytest.mark.parametrize(("check", "old", "new", "fault"), [
    (bare, '        """The rate."""', "        return 0", "imo_analysis.planted.Law.rate"),
    (bare, '"""A law.', '""""""\n    """', "imo_analysis.planted.Law"),
    (unnamed, "i_tilde", "wish", "imo_analysis.planted.Law.rate(wish)"),
    (unnamed, "x, name: str", "x, other, name: str", "imo_analysis.planted.gain(other)"),
    (strange, "alpha_hat_dot", "alpha_hta_dot", "imo_analysis.planted: alpha_hta_dot"),
    (strange, "``L_m``", "``L_M``", "imo_analysis.planted: L_M"),
    (strange, "gain k_1 on", "gain k_4 on", "imo_analysis.planted.gain: k_4"),
    (strange, "v_1_hat", "v_3_hat", "imo_analysis.planted.gain: v_3_hat"),
    (dead, "machine.InductionMachine", "machine.InductionMotor", "imo_analysis.planted: machine.InductionMotor"),
])
def test_a_planted_fault_is_found(check, old: str, new: str, fault: str) -> None:
    assert check(planted(old, new)) == [fault]


@pytest.mark.parametrize(("old", "new", "fault"), [
    ("k_1, x : float", "k_1 : float", "imo_analysis.planted.gain(x)"),
    ("name: str)", "name: str, wish: float = 0.0)", "imo_analysis.planted.gain(wish)"),
    ("name : str\n        Whose.", "whose : str\n        Whose.", "imo_analysis.planted.gain(name)"),
    ("    g : float", "    h : float", "imo_analysis.planted.Law(g)"),
])
def test_a_planted_argument_is_found(old: str, new: str, fault: str) -> None:
    assert [one for public in planted(old, new).public for one in unexplained(public)] == [fault]


def test_a_planted_field_is_found() -> None:
    class Inner(Table):
        """``[inner]``: a table.

        Attributes
        ----------
        length : float
            In s.
        """

        length: Seconds = 1.0
        width: float = 2.0

    class Planted(Table):
        """A study."""

        inner: Inner = Inner()

    tables = [one for one in facts.study_tables(Planted) if one.heading == "[inner]"]
    assert [field.unit for field in tables[0].fields] == ["s", ""]
    assert silent(tables) == ["[inner] width"]


def test_a_planted_text_for_two_fields_is_found() -> None:
    class Planted(Table):
        """A study.

        Attributes
        ----------
        length, width : float
            In s.
        """

        length: Seconds = 1.0
        width: Seconds = 2.0

    assert alike(facts.study_tables(Planted)) == [": In s."]


def test_a_planted_option_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    from imo_analysis.commands import study

    declare = study.add_arguments
    monkeypatch.setattr(study, "add_arguments", lambda parser: (declare(parser), parser.add_argument("--wish", metavar="X")))
    found = [option for one in facts.commands() if one.name == "study" for option in one.options if not option.meaning]
    assert [option.written for option in found] == ["--wish X"]


def test_sections_of_a_docstring() -> None:
    doc = "Text.\n\nParameters\n----------\na, b : float\n    In s.\n**more\n    Others.\n\nReturns\n-------\nfloat\n    c."
    assert list(sections(doc)) == ["", "Parameters", "Returns"]
    assert documented(doc) == {"a": ("float", "In s."), "b": ("float", "In s."), "more": ("", "Others.")}
