"""README and manual, executed: every fenced block and every command in them, page by page, in a folder of its own.

What the fences mean:

- ``console``: lines ``$ imo ...`` with what they print below them, ``...`` standing for any lines; ``$ echo $?`` shows the exit
  code of the command before, which is 0 where it is not shown. A block without output is run all the same.
- ``toml``: a file, whose first line has its name, ``# motor.toml``; without a name, a part of a study, merged over the paper's.
- ``python``: run, all blocks of a page in one namespace; a ``text`` block that follows is what it prints.
- ``sh``: lines to type, run without a look at what they print; what cannot be run in place is in `SETUP`, with where it is.
- ``math`` and directives in braces belong to Sphinx. Any other fence is a fault, so that no block goes unchecked.
"""

from __future__ import annotations

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
from imo_analysis.study import Study, merged

TOP = Path(__file__).resolve().parents[2]
MANUAL = TOP / "manual"
_FENCE = re.compile(r"^(?P<mark>`{3,}|~{3,}|:{3,})(?P<kind>\S*)[^\n]*\n(?P<body>.*?)^(?P=mark)[ ]*$", re.DOTALL | re.MULTILINE)
_NAMED = re.compile(r"#\s*([\w.-]+\.toml)\b")


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
            _toml(block)
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


def _toml(block: Block) -> None:
    named = _NAMED.match(block.text)
    data = tomllib.loads(block.text)
    if named:
        Path(named[1]).write_text(block.text, encoding="utf-8")
    elif "nameplate" not in data:
        Study.from_data(merged(Study.paper().data, data))


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
    "pip install '.[docs]'": ("pyproject.toml", "[notebooks,sweep,parquet,docs]"),
    "sphinx-build -W --keep-going -n manual manual-html": ("tests/manual/test_manual_build.py", '"-W", "--keep-going", "-n"'),
}


def inline_commands(text: str) -> Iterator[str]:
    """Commands in running text: `imo ...` in backticks."""
    yield from re.findall(r"(?<!`)`(imo [^`]+)`", prose(text))
