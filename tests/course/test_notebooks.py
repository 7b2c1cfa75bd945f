"""Derivations and lessons as notebooks: listed, chosen, written the same twice, executed, compared."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import pytest

from imo_analysis.cli import main
from imo_analysis.notebooks import KINDS, converted, differences, sources, written

pytest.importorskip("jupytext")
RENDERED = Path(__file__).parents[2] / "reports" / "course"


def test_listed_and_chosen(capsys):
    one = (["--only", "lesson_03"], 1)
    for arguments, count in (([], 18), (["--course"], 10), (["--derivations"], 8), (["--only", "0"], 8), one):
        assert main(["notebook", *arguments, "--json", "-"]) == 0
        data = json.loads(capsys.readouterr().out)
        assert data["schema"] == "imo-notebooks/1" and len(data["notebooks"]) == count
    assert {row["kind"] for row in data["notebooks"]} <= set(KINDS)


@pytest.mark.parametrize("arguments", [
    ["--only", "77"], ["--execute"], ["--clean"], ["--course", "--only", "06"], ["--out", "/proc/none"], ["--against", "."],
    ["--out", "here", "--against", "nowhere"]])
def test_bad_input_is_one_line(arguments, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["notebook", *arguments]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_lessons_are_written_the_same_twice_with_an_index(tmp_path, capsys):
    for name in ("a", "b"):
        assert main(["notebook", "--course", "--clean", "--out", str(tmp_path / name)]) == 0
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert names == ["START_HERE.md", *(f"{path.stem}.ipynb" for path in sources("course"))]
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    index = (tmp_path / "a" / "START_HERE.md").read_text(encoding="utf-8")
    assert all(f"({path.stem}.ipynb)" in index for path in sources("course"))
    cells = json.loads((tmp_path / "a" / names[-1]).read_text(encoding="utf-8"))["cells"]
    assert not any(cell.get("outputs") for cell in cells)
    assert any(cell["metadata"].get("jupyter", {}).get("source_hidden") for cell in cells)


@pytest.mark.slow
def test_executed_from_a_fresh_kernel_and_compared(tmp_path, capsys):
    pytest.importorskip("nbclient")
    arguments = ["notebook", "--only", "lesson_05", "--execute", "--out"]
    assert main([*arguments, str(tmp_path / "a")]) == 0
    path = tmp_path / "a" / "lesson_05_machine_proof.ipynb"
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert notebook["metadata"]["language_info"] == {"name": "python"}
    printed = "".join("".join(one.get("text", ())) for cell in notebook["cells"] for one in cell.get("outputs", ()))
    assert "5.1: not answered yet." in printed and "holds after correction" in printed
    assert main([*arguments, str(tmp_path / "b"), "--against", str(tmp_path / "a")]) == 0
    path.write_text(path.read_text(encoding="utf-8").replace("not answered yet", "answered"), encoding="utf-8")
    capsys.readouterr()
    assert main([*arguments[:3], "--out", str(tmp_path / "c"), "--against", str(tmp_path / "a")]) == 1
    assert "its output differs" in capsys.readouterr().out


def test_differences_between_notebooks():
    cell = {"cell_type": "code", "source": "print(1)", "metadata": {},
            "outputs": [{"output_type": "stream", "name": "stdout", "text": ["pole -236.01 1/s\n", "missed 0\n"]}]}
    old = {"cells": [cell, {"cell_type": "markdown", "source": ["one\n", "two"], "metadata": {}}]}

    def changed(place, text):
        new = copy.deepcopy(old)
        new["cells"][0]["outputs"][0]["text"] = text if place == "output" else new["cells"][0]["outputs"][0]["text"]
        if place == "source":
            new["cells"][1]["source"] = text
        return differences(old, new)

    assert changed("output", "pole -236.02 1/s\nmissed 0\n") == []  # the last digit is the machine's
    assert changed("source", "one\ntwo") == []
    assert changed("output", "pole -263.01 1/s\nmissed 0\n") == ["cell 0: its output differs"]
    assert changed("output", "pole -236.01 1/s\nmissed 1\n") == ["cell 0: its output differs"]
    assert changed("output", "zero -236.01 1/s\nmissed 0\n") == ["cell 0: its output differs"]
    assert changed("source", "one\nthree") == ["cell 1: its text differs"]
    assert differences(old, {"cells": []}) == ["2 cells, now 0"]


@pytest.mark.parametrize("path", sources("course"), ids=[path.stem for path in sources("course")])
def test_the_rendered_lessons_are_today_s(path):
    """Their text; that the results are today's too is compared where all notebooks are executed (.ci/run)."""
    if not RENDERED.is_dir():
        pytest.skip("no rendered set in reports/")
    old = json.loads((RENDERED / f"{path.stem}.ipynb").read_text(encoding="utf-8"))
    new = json.loads(written(converted(path)))
    assert not [one for one in differences(old, new) if "text" in one or "cells" in one], (
        "run 'imo notebook --course --execute --out reports/course'")
    assert any(cell.get("outputs") for cell in old["cells"])
