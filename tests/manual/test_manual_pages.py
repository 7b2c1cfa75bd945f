"""Every code block and every command of README and manual is run, page by page; and a page that lies is noticed."""

import re
import runpy
import time
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from documents import ELSEWHERE, MANUAL, SETUP, TOP, blocks, consoles, execute, inline_faults, matches, pages

from imo_analysis.errors import InputError

PAGES = [page for page in pages() if blocks(page.read_text(encoding="utf-8")) or "`imo " in page.read_text(encoding="utf-8")]
NAMES = [str(page.relative_to(TOP)) for page in PAGES]


def _check(command: str, expected: list[str], printed: str) -> None:
    assert matches(expected, printed), f"{command} prints\n{printed}"


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_every_block_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    text = page.read_text(encoding="utf-8")
    start = time.process_time()
    assert execute(text, _check) == sum(not block.kind.startswith("{") for block in blocks(text))
    assert time.process_time() - start < 150, "shorten the commands of this page"


@pytest.mark.parametrize("page", pages(), ids=[str(page.relative_to(TOP)) for page in pages()])
def test_commands_in_the_text_would_run(page: Path) -> None:
    assert inline_faults(page.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(("page", "old", "new", "fault"), [
    ("README.md", "`sphinx-build manual manual-html`", "`sphinx-build manul manual-htlm`", "no such program in SETUP"),
    ("README.md", "`python -m benchmarks`", "`python -m benchmark`", "no such program in SETUP"),
    ("README.md", "`pip install '.[docs]'`", "`pip install '.[manual]'`", "no such program in SETUP"),
    ("README.md", "`imo derive scheduled`", "`imo derive unscheduled`", "the ledger has no unscheduled"),
    ("README.md", "`imo simulate --scenario real`", "`imo simulate --scenario unreal`", "no scenario unreal"),
    ("README.md", "`imo notebook --course --out lessons`", "`imo notebook --course --derivations --out x`", "not allowed"),
    ("README.md", "`imo study --init mine.toml --machine motor.toml`", "`imo study --init mine.toml --machine moter.toml`",
     "nothing before it makes moter.toml"),
    ("manual/tutorial.md", "`imo tune study.toml --out tuned.toml`", "`imo tune nostudy.toml --out tuned.toml`",
     "nothing before it makes nostudy.toml"),
    ("manual/tutorial.md", "`imo tune study.toml --out tuned.toml`", "`imo tune nothing.toml`",
     "nothing before it makes nothing.toml"),
    ("manual/choose.md", "`imo poles --tune`", "`imo poles --tun`", "unrecognized arguments"),
    ("manual/choose.md", "`imo study --init`", "`imo studies --init`", "no such command"),
    ("manual/theory/lyapunov.md", "`imo simulate --scenario lyapunov`", "`imo simulate here there`", "unrecognized arguments"),
])
def test_a_command_in_the_text_that_would_not_run_is_noticed(page: str, old: str, new: str, fault: str) -> None:
    text = (TOP / page).read_text(encoding="utf-8")
    assert old in text
    found = inline_faults(text.replace(old, new))
    assert found and all(fault in one for one in found)


def test_a_file_must_be_made_before_the_command_that_reads_it() -> None:
    made, used = "```toml\n# mine.toml\n[machine]\n```\n", "`imo replay log.csv --machine mine.toml`\n"
    assert len(inline_faults(made + used)) == 1  # the log
    assert len(inline_faults(used + made)) == 2
    assert not inline_faults(f"```sh\nimo simulate --out log.csv\n```\n{made}{used}")


def test_files_from_other_pages_are_there() -> None:
    for name, page in ELSEWHERE.items():
        assert f"```toml\n# {name}\n" in (TOP / page).read_text(encoding="utf-8")


def test_no_block_goes_unseen() -> None:
    """Markdown has a second kind of code block, by indentation, which nothing here runs: there is none but in manual/README."""
    for page in pages():
        text = re.sub(r"^(`{3,}).*?^\1$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
        found = re.findall(r"(?:^|\n)\n    \S.*", text)
        if page.relative_to(TOP) == Path("manual/README.md"):
            assert {line.strip() for line in "\n".join(found).splitlines() if line.strip()} <= set(SETUP)
        else:
            assert not found, page


def test_set_up_lines_are_run_somewhere() -> None:
    for command, (place, line) in SETUP.items():
        assert line in (TOP / place).read_text(encoding="utf-8"), f"{command}: {place} no longer has {line}"


def extras() -> dict[str, list[str]]:
    """Extra -> names of the distributions that it asks for."""
    table = tomllib.loads((TOP / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    return {name: [named(one) for one in wanted] for name, wanted in table.items()}


def named(requirement: str) -> str:
    match = re.match(r"[\w.-]+", requirement)
    assert match
    return match[0].lower().replace("_", "-")


def missing_for_the_manual(extra: list[str]) -> set[str]:
    """What conf.py names and the extra lacks: extensions, theme, and styles, which a member of the extra may bring."""
    settings = runpy.run_path(str(MANUAL / "conf.py"))
    packages = metadata.packages_distributions()
    modules = {"sphinx", settings["html_theme"], *(one for one in settings["extensions"] if not (MANUAL / one).exists())}
    wanted = {named(packages[one.partition(".")[0]][0]) for one in modules}
    brought = {named(one) for member in extra for one in metadata.requires(member) or () if "extra ==" not in one}
    for style in (settings["pygments_style"], settings["pygments_dark_style"]):
        makers = metadata.entry_points(group="pygments.styles", name=style)
        wanted |= {named(one.dist.name) for one in makers if one.dist} - brought
    return wanted - set(extra)


def test_the_extra_docs_has_what_the_manual_is_built_with() -> None:
    docs = extras()["docs"]
    assert not missing_for_the_manual(docs)
    for one in docs:
        assert one in missing_for_the_manual([other for other in docs if other != one]), one
    assert "accessible-pygments" in missing_for_the_manual(["sphinx", "myst-parser"]), "furo brings the style of the code"


def test_extras_that_are_named_exist() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in pages())
    found = {name for part in re.findall(r"(?:\.|imo-analysis)\[([\w,]+)\]", text) for name in part.split(",")}
    assert {"docs", "test", "notebooks", "parquet"} <= found <= set(extras())


# A page that lies ------------------------------------------------------------------------------------------------------
TRUE = """
```toml
# small.toml
[machine]
preset = "table-iii"
```
```toml
[nameplate]
power = "2.2 kW"
voltage = "400 V"
current = "5 A"
frequency = "50 Hz"
speed = "1430 rpm"
power_factor = 0.8
[machine]
J = 0.015
```
```toml
# wrong.toml
[machine]
preset = "table-IV"
```
```console
$ imo study --init s.toml --machine wrong.toml
imo: wrong.toml: machine.preset = 'table-IV' is not known; ... modelica-50-hp
$ echo $?
2
$ imo study --init s.toml --machine nothing.toml
imo: cannot read nothing.toml: ...
$ echo $?
2
$ imo study
...
observers  baseline, ...
...
```
```python
x = 2
```
```python
print(x + 1)
```
```text
3
```
"""


def _run(text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    monkeypatch.chdir(folder)
    return execute(text, _check)


def test_a_true_page_passes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert _run(TRUE, tmp_path, monkeypatch) == 7
    assert (tmp_path / "small.toml").exists()


@pytest.mark.parametrize(("old", "new", "fault"), [
    ("\n3\n", "\n4\n", AssertionError),  # a wrong output
    ("observers  baseline", "observers  other", AssertionError),
    ("...\n$ echo $?\n2", "...\n$ echo $?\n0", AssertionError),
    ("...\n$ echo $?\n2\n", "...\n", AssertionError),  # a failure that is not shown
    ("imo study\n", "imo studio\n", AssertionError),
    ("x + 1", "y + 1", NameError),
    ('preset = "table-iii"', "preset = table-iii", ValueError),
    ("# small.toml\n[machine]\npreset", "[machine]\npresent", InputError),  # a part of a study with an unknown key
    ("# small.toml\n[machine]\npreset", "# small.toml\n[machine]\npresent", InputError),  # a file that the program refuses
    ('current = "5 A"', 'curent = "5 A"', InputError),  # a name plate without a name
    ('speed = "1430 rpm"', 'speed = "1530 rpm"', InputError),
    ("```python\nx", "```pythn\nx", AssertionError),
])
def test_a_page_that_lies_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, old: str, new: str, fault: type) -> None:
    assert TRUE.count(old) == 1
    with pytest.raises(fault):
        _run(TRUE.replace(old, new), tmp_path, monkeypatch)


def test_matching_lines() -> None:
    assert matches(["a", "...", "d"], "a\nb\nc\nd\n") and matches(["a ... d"], "a b c d\n")
    assert not matches(["a", "...", "e"], "a\nb\nc\nd\n") and not matches(["a"], "a\nb\n")
    assert not matches(["a ... d"], "a b\nc d\n")
    assert consoles("$ one\nx\n$ two\n") == [("one", ["x"]), ("two", [])]
