"""Each derivation runs as a script, in this process, and keeps its promises; as notebooks they are the same files."""

from __future__ import annotations

import json
import runpy

import pytest

from imo_analysis.cli import main
from imo_analysis.notebooks import sources, title

FILES = sources("derivations")


def test_all_topics_are_there():
    assert [path.name[:2] for path in FILES] == [f"{number:02d}" for number in range(1, 9)]
    assert [title(path)[0] for path in FILES] == [str(number) for number in range(1, 9)]


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_derivation_holds(path, capsys):
    runpy.run_path(str(path), run_name="__main__")
    printed = capsys.readouterr().out
    assert "holds" in printed or "not determined" in printed


def test_notebooks_are_written_the_same_twice(tmp_path, capsys):
    pytest.importorskip("jupytext")
    assert main(["notebook", "--derivations", "--out", str(tmp_path / "a")]) == 0
    assert main(["notebook", "--derivations", "--out", str(tmp_path / "b")]) == 0
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert names == [f"{path.stem}.ipynb" for path in FILES]
    for name in names:
        first = (tmp_path / "a" / name).read_text(encoding="utf-8")
        assert first == (tmp_path / "b" / name).read_text(encoding="utf-8")
        cells = json.loads(first)["cells"]
        assert {"markdown", "code"} <= {cell["cell_type"] for cell in cells}


@pytest.mark.slow
def test_a_notebook_executes(tmp_path):
    pytest.importorskip("nbclient")
    assert main(["notebook", "--out", str(tmp_path), "--only", "02", "--execute"]) == 0
    cells = json.loads((tmp_path / "02_the_transformation.ipynb").read_text(encoding="utf-8"))["cells"]
    outputs = [one for cell in cells for one in cell.get("outputs", ())]
    assert any("text/latex" in one.get("data", {}) for one in outputs)


@pytest.mark.parametrize("arguments", [["--only", "77"], ["--execute"], ["--out", "/proc/none"]])
def test_bad_input_is_one_line(arguments, capsys):
    assert main(["notebook", *arguments]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
