"""``imo derive``: the table, one entry, JSON, the Coq script, mutants, and what makes it fail."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from imo_analysis import cli
from imo_analysis.ledger import book
from imo_analysis.ledger.claim import Claim, Verdict
from imo_analysis.ledger.settings import machine


def test_the_ledger_of_the_paper_is_settled(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["derive"]) == 0
    out = capsys.readouterr().out
    assert "errors of the tool: 0" in out and "not settled" not in out
    assert all(item in out for item in ("(1)", "(12)", "(14)", "(19)", "(23)", "Table II", "Proposition IV.3"))


def test_an_entry_in_full(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["derive", "eq12.i_qs"]) == 0
    out = capsys.readouterr().out
    assert "\n1 entry: " in out
    for word in ("printed", "corrected", "^", "edit", "assuming", "left - right = ", "residual 0", "kernels     sympy, flint"):
        assert word in out


def test_json_lists_5_6_12_and_14_row_by_row(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["derive", "--kernel", "flint", "--json", "-"]) == 0
    captured = capsys.readouterr()
    data = json.loads(captured.out)
    assert data["schema"] == "imo-ledger/1" and data["disagreements"] == 0
    rows = {entry["id"]: entry["verdict"] for entry in data["entries"]}
    for item, least in (("eq5.", 2), ("eq6.", 4), ("eq12.", 6), ("eq14.", 6)):
        assert sum(name.startswith(item) for name in rows) >= least
    assert sum(data["counts"].values()) == len(rows) and set(rows.values()) <= {str(v) for v in Verdict}
    assert "errors of the tool: 0" in captured.err


def test_an_unknown_id_or_subject_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    for words, says in ((["eq99"], "no entry begins with 'eq99'"), (["--subject", "x"], "there are paper, kubota")):
        assert cli.main(["derive", *words]) == 2
        assert says in capsys.readouterr().err


def test_a_verdict_that_is_not_expected_is_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:
    wrong = Claim("wrong", "(6)", "a slip", Verdict.HOLDS, machine(), printed="z_1_dot = R_s/sigma*i_ds + u_ds/sigma")
    monkeypatch.setattr(book, "claims", lambda: (wrong,))
    assert cli.main(["derive"]) == 1
    assert "expected was holds" in capsys.readouterr().out


def test_mutants_of_some_entries(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["derive", "eq12", "--mutants", "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)["mutants"]
    assert report["tried"] > 200 and report["missed"] == []
    assert report["rejected"] == dict.fromkeys(("sympy", "flint"), report["tried"] - len(report["equivalent"]))


def test_the_exported_script_is_accepted_by_coq(tmp_path: Path) -> None:
    assert cli.main(["derive", "eq12", "--kernel", "flint", "--export-coq", str(tmp_path / "coq")]) == 0
    assert shutil.which("coqc"), "CI installs Debian's coq"
    done = subprocess.run(["coqc", "-q", "ledger.v"], cwd=tmp_path / "coq", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_another_subject(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["derive", "--subject", "kubota", "--mutants"]) == 0
    assert "kubota.negative" in capsys.readouterr().out


@pytest.mark.slow
def test_three_kernels_agree_on_everything(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["derive", "--kernel", "all", "--mutants", "all", "--json", "-"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["disagreements"] == 0 and data["mutants"]["missed"] == [] and data["definition_mutants"]["survived"] == []
    assert set(data["mutants"]["rejected"]) == {"sympy", "flint", "coq"}
    assert all(entry["errors"] == [] and entry["kernels"] == ["sympy", "flint", "coq"] for entry in data["entries"])
