"""README and manual, executed: every fenced block and every command in them, page by page, in a folder of its own.

What the fences mean:

- ``console``: lines ``$ imo ...`` with what they print below them, ``...`` standing for any lines; ``$ echo $?`` shows the exit
  code of the command before, which is 0 where it is not shown. A block without output is run all the same.
- ``toml``: a file, whose first line has its name, ``# motor.toml``; without a name, a part of a study, merged over the paper's.
  Both are read as the program reads them; a file that it refuses must be shown to be refused.
- ``python``: run, all blocks of a page in one namespace; a ``text`` block that follows is what it prints. One whose first line
  is a name, ``# mine.py``, is a file that the blocks below it read.
- ``sh``: lines to type, run without a look at what they print; what cannot be run in place is in `SETUP`, with where it is.
- ``math`` and directives in braces belong to Sphinx. Any other fence is a fault, so that no block goes unchecked.

A command in running text, in backticks, is not run, but read by its own parser; files that it reads are there by then, and
a program other than ``imo`` is in `SETUP`.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import re
import shlex
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from imo_analysis import cli
from imo_analysis.errors import InputError
from imo_analysis.ledger.book import claims
from imo_analysis.study import Study, merged
from imo_analysis.tuning.start import study_of

TOP = Path(__file__).resolve().parents[2]
MANUAL = TOP / "manual"
_FENCE = re.compile(r"^(?P<mark>`{3,}|~{3,}|:{3,})(?P<kind>\S*)[^\n]*\n(?P<body>.*?)^(?P=mark)[ ]*$", re.DOTALL | re.MULTILINE)
_NAMED = re.compile(r"#\s*([\w.-]+\.(?:toml|py))\b")


@dataclass(frozen=True)
class Block:
    """A fenced block: its kind, its text, the line on which it begins."""

    kind: str
    text: str
    line: int


def pages() -> list[Path]:
    """README and every page of the manual in Markdown."""
    return [TOP / "README.md", *sorted(path for path in MANUAL.rglob("*.md"))]


def blocks(text: str) -> list[Block]:
    """The fenced blocks in order."""
    return [Block(found["kind"], found["body"], text[: found.start()].count("\n") + 1) for found in _FENCE.finditer(text)]


def prose(text: str) -> str:
    """The text without its fenced blocks."""
    return _FENCE.sub("", text)


def matches(expected: list[str], printed: str) -> bool:
    """Whether the lines agree, ``...`` standing for any lines, or within a line for any text."""
    parts = [r"(?:.*\n)*?" if line == "..." else re.escape(line).replace(r"\.\.\.", ".*?") + r"\n" for line in expected]
    return re.fullmatch("".join(parts), printed) is not None


def consoles(block: str) -> list[tuple[str, list[str]]]:
    """Commands of a console block, each with the lines below it."""
    found: list[tuple[str, list[str]]] = []
    for line in block.splitlines():
        if line.startswith("$ "):
            found.append((line[2:], []))
        else:
            assert found, f"output without a command: {line}"
            found[-1][1].append(line)
    return found


def run(command: str) -> tuple[int, str]:
    """Exit code and output, both streams, of an ``imo`` command."""
    program, *words = shlex.split(command)
    assert program == "imo", command
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
        code = cli.main(words)
    # a line that a counter keeps writing over is seen as its last state
    return code, "".join(f"{line.split(chr(13))[-1]}\n" for line in output.getvalue().split("\n")[:-1])


def execute(text: str, check: Callable[[str, list[str], str], None]) -> int:
    """Run every block of a page in the current folder; ``check(command, expected, printed)`` judges. How many were run."""
    space: dict[str, Any] = {"__name__": "__page__"}
    printed, done, code = "", 0, 0
    for block in blocks(text):
        if block.kind == "console":
            for command, expected in consoles(block.text):
                if command == "echo $?":
                    check(command, expected, f"{code}\n")
                    code = 0
                    continue
                assert code == 0, f"line {block.line}: exit code {code} of the command before is not shown"
                code, printed = run(command)
                if expected:
                    check(command, expected, printed)
            assert code == 0, f"line {block.line}: the last command ends with exit code {code}"
        elif block.kind == "toml":
            shown = [line for line in text.splitlines() if line.startswith("imo: ")]
            if (fault := _toml(block)) and not any(matches([line], f"{fault}\n") for line in shown):
                raise InputError(f"line {block.line}: {fault}, and the page does not show that")
        elif block.kind == "python" and (named := _NAMED.match(block.text)):
            Path(named[1]).write_text(block.text, encoding="utf-8")
        elif block.kind == "python":
            output = io.StringIO()
            with contextlib.redirect_stdout(output):
                exec(compile(block.text, f"<line {block.line}>", "exec"), space)
            printed = output.getvalue()
        elif block.kind == "text":
            check("python", block.text.splitlines(), printed)
        elif block.kind == "sh":
            _set_up(block)
        elif not (block.kind.startswith("{") or block.kind == "math"):
            raise AssertionError(f"line {block.line}: what is a block of kind {block.kind!r}?")
        else:
            continue
        done += 1
    return done


def _toml(block: Block) -> str:
    """Write the file, if it has a name, and read what is in the block; what the program says against it, if anything."""
    named = _NAMED.match(block.text)
    data = tomllib.loads(block.text)
    place = Path(named[1] if named else "block.toml")
    if not named and "nameplate" not in data:
        Study.from_data(merged(Study.paper().data, data))
        return ""
    place.write_text(block.text, encoding="utf-8")
    try:
        if data.keys() & set(Study.model_fields) - {"machine", "replay"}:
            Study.load(str(place))
        else:  # a machine file
            study_of(str(place))
    except InputError as error:
        if not named:
            raise
        return f"imo: {error}"
    finally:
        if not named:
            place.unlink()
    return ""


def _set_up(block: Block) -> None:
    """Lines that install or build: each is a line of CI, or of a test that says so in `SETUP`."""
    for line in block.text.splitlines():
        for part in line.split("&&"):
            words = part.split("#")[0].strip()
            if words.startswith("imo ") and words not in SETUP:
                code, printed = run(words)
                assert code == 0, f"line {block.line}: {words} ends with exit code {code}\n{printed}"
            elif words:
                assert words in SETUP, f"line {block.line}: {words!r} is run by nothing"


# set-up line -> where it is run; `test_set_up_lines_are_run_somewhere` holds the two together
SETUP = {
    "pip install .": (".ci/run", "pip\" install -q --disable-pip-version-check ."),
    "pip install -e '.[test]'": (".ci/run", "pip install -q --disable-pip-version-check -e '.[test]'"),
    "pytest": (".ci/run", "pytest -n 2"),
    "imo report": (".ci/run", "imo\" report --out"),
    "imo report mine.toml --out dossier": ("manual/tutorial.md", "$ imo report study.toml --out dossier"),
    # an hour of duty takes half a minute; the test runs a minute of it
    "imo simulate hour.toml --out duty.nc": ("tests/excitation/test_duty.py", "run = simulate(mixed_duty(Study.paper(), 80.0"),
    "pip install '.[docs]'": ("tests/manual/test_manual_pages.py", "def test_the_extra_docs_has_what_the_manual_is_built_with"),
    "sphinx-build -W --keep-going -n manual manual-html": ("tests/manual/test_manual_build.py", '"-W", "--keep-going", "-n"'),
    "sphinx-build manual manual-html": ("tests/manual/test_manual_build.py", 'str(source),'),
    "python -m benchmarks": ("tests/sweeps/test_contenders.py", "from benchmarks.__main__ import"),
}

# file that a page takes from another -> the page that has it
ELSEWHERE = {"motor.toml": "manual/tutorial.md"}
_FILE = re.compile(r"[\w./-]+\.(?:py|toml|nc|csv|parquet|json|svg)")
_WRITTEN = ("out", "plot", "map", "json", "init", "duty")  # options whose files a command writes
_NO_COMMAND = ("is off", "is lost", 'with sized("slide")', "kg m^2", "kg cm^2")  # verdicts of a run, Python, units


def inline_commands(text: str) -> list[str]:
    """Commands in running text: two words and more in backticks, of which the first could be a program's name.

    A key with its value is none.
    """
    spans = re.finditer(r"``[^`]+``|(?P<role>\{[\w-]+\})?`(?P<said>[^`]+)`", prose(text))
    found = [" ".join(span["said"].split()) for span in spans if span["said"] and not span["role"]]
    return [one for one in found if re.match(r"[a-z][a-z0-9_-]* (?!= )", one) and one not in _NO_COMMAND]


def inline_faults(text: str) -> list[str]:
    """What is wrong with the commands in the running text of a page."""
    faults: list[str] = []
    there = {"imo-report", *ELSEWHERE}
    for line in _commands(text):
        command, inline = line
        program, *words = shlex.split(command)
        if program != "imo":
            faults += [f"{command}: no such program in SETUP"] if inline and command not in SETUP else []
            continue
        if not words or words[0] in ("COMMAND", "--help", "--version"):
            continue
        if words[0] not in cli.COMMANDS:
            faults.append(f"{command}: no such command")
            continue
        if not words[1:] or "--help" in words:
            continue
        try:
            args = _parsed(words)
        except InputError as error:
            faults += [f"{command}: {error}"] if inline else []
            continue
        reads, writes = _files(args)
        if inline:
            faults += [f"{command}: nothing before it makes {name}" for name in sorted(reads - there)]
            faults += _unknown(command, args)
        there |= writes
    return faults


def _commands(text: str) -> Iterator[tuple[str, bool]]:
    """All commands of a page in their order, and whether each stands in running text; a file in a block counts as written."""
    position = 0
    for block in [*_FENCE.finditer(text), None]:
        end = block.start() if block else len(text)
        yield from ((one, True) for one in inline_commands(text[position:end]))
        if block is None:
            return
        position, body = block.end(), block["body"]
        if block["kind"] in ("toml", "python") and (named := _NAMED.match(body)):
            yield f"imo study --init {named[1]}", False
        elif block["kind"] == "console":
            yield from ((one, False) for one, _ in consoles(body) if one.startswith("imo "))
        elif block["kind"] == "sh":
            parts = [part.split("#")[0].strip() for line in body.splitlines() for part in line.split("&&")]
            yield from ((one, False) for one in parts if one.startswith("imo "))


def _parsed(words: list[str]) -> argparse.Namespace:
    """The arguments of a command; an option that ends it may stand for itself, without its value."""
    parser = cli.parser_of(words[0])
    try:
        return parser.parse_args(cli._joined(words[1:]))
    except InputError as error:
        if words[-1].startswith("--") and "expected" in str(error):
            return parser.parse_args([*cli._joined(words[1:]), "VALUE"])
        raise


def _files(args: argparse.Namespace) -> tuple[set[str], set[str]]:
    """Files that a command reads, and those that it writes."""
    reads: set[str] = set()
    writes: set[str] = set()
    for name, value in vars(args).items():
        found = {one for one in (value if isinstance(value, list) else [value])
                 if isinstance(one, str) and (_FILE.fullmatch(one) and one[0].islower())}
        (writes if name in _WRITTEN else reads).update(found)
    return reads, writes


def _unknown(command: str, args: argparse.Namespace) -> list[str]:
    """Entries of the ledger and scenarios of the paper's study that a command names and that are not there."""
    faults = []
    for one in getattr(args, "ids", None) or []:
        if not one.isupper() and not any(claim.id.startswith(one) for claim in claims()):
            faults.append(f"{command}: the ledger has no {one}")
    scenario = getattr(args, "scenario", None)
    if scenario and not scenario.isupper() and scenario not in Study.paper().scenarios:
        faults.append(f"{command}: the study has no scenario {scenario}")
    return faults
