"""What the README shows is what the commands print, and its Python runs."""

import re
from pathlib import Path

import pytest

from imo_analysis import cli

README = (Path(__file__).resolve().parents[1] / "README.md").read_text(encoding="utf-8")


def _consoles() -> list[tuple[str, list[str]]]:
    """Command and expected lines, over all console blocks in order."""
    found: list[tuple[str, list[str]]] = []
    for block in re.findall(r"```console\n(.*?)```", README, flags=re.DOTALL):
        for line in block.splitlines():
            if line.startswith("$ "):
                found.append((line[2:], []))
            else:
                found[-1][1].append(line)
    return found


def _matches(expected: list[str], printed: str) -> bool:
    """Whether the lines agree, ``...`` standing for any lines."""
    parts = [r"(?:.*\n)*?" if line == "..." else re.escape(line) + r"\n" for line in expected]
    return re.fullmatch("".join(parts), printed) is not None


@pytest.mark.slow
def test_the_consoles_show_what_is_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    consoles = _consoles()
    assert len(consoles) >= 4
    for command, expected in consoles:
        program, *words = command.split()
        assert program == "imo" and cli.main(words) == 0, command
        printed = capsys.readouterr().out
        assert _matches(expected, printed), f"{command}\n{printed}"


def test_a_wrong_line_is_noticed() -> None:
    assert _matches(["a", "...", "d"], "a\nb\nc\nd\n")
    assert not _matches(["a", "...", "e"], "a\nb\nc\nd\n")
    assert not _matches(["a"], "a\nb\n")


@pytest.mark.slow
def test_the_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out.strip()
