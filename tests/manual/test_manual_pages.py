"""Every code block and every command of README and manual is run, page by page; and a page that lies is noticed."""

import re
import time
from pathlib import Path

import pytest
from documents import SETUP, TOP, blocks, consoles, execute, inline_commands, matches, pages

from imo_analysis import cli
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


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_commands_in_the_text_exist(page: Path) -> None:
    for command in inline_commands(page.read_text(encoding="utf-8")):
        _, *words = command.split()
        if not words or words[0].isupper():
            continue
        if words[0].startswith("-"):
            assert words[0] in ("--help", "--version"), command
            continue
        known = {option for action in cli.parser_of(words[0])._actions for option in action.option_strings}
        assert {word.split("=")[0] for word in words[1:] if word.startswith("--")} <= known, command


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


# A page that lies ------------------------------------------------------------------------------------------------------
TRUE = """
```toml
# small.toml
[machine]
preset = "table-iii"
```
```console
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
    assert _run(TRUE, tmp_path, monkeypatch) == 5
    assert (tmp_path / "small.toml").exists()


@pytest.mark.parametrize(("old", "new", "fault"), [
    ("\n3\n", "\n4\n", AssertionError),  # a wrong output
    ("observers  baseline", "observers  other", AssertionError),
    ("$ echo $?\n2", "$ echo $?\n0", AssertionError),
    ("$ echo $?\n2\n", "", AssertionError),  # a failure that is not shown
    ("imo study\n", "imo studio\n", AssertionError),
    ("x + 1", "y + 1", NameError),
    ('preset = "table-iii"', "preset = table-iii", ValueError),
    ("# small.toml\n[machine]\npreset", "[machine]\npresent", InputError),  # a part of a study with an unknown key
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
