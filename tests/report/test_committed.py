"""The dossier in ``reports/`` is what the code makes today: ledger entry by entry, Table II number by number, one study."""

import csv
import json
from pathlib import Path

import pytest
from replay_records import immec

from imo_analysis import cli
from imo_analysis.ledger.book import entries
from imo_analysis.report.pencils import observers_of, write_table2
from imo_analysis.study import Study

PAPER = Path(__file__).parents[2] / "reports" / "paper"
AGAIN = "run 'imo report --small --out reports/paper' and read the difference"


@pytest.mark.slow
def test_ledger() -> None:
    committed = json.loads((PAPER / "ledger.json").read_text(encoding="utf-8"))["entries"]
    kept = ("id", "verdict", "printed", "corrected", "edit", "title", "consequences")
    today = [entry.to_dict() for entry in entries(("flint",))]
    plain = json.loads(json.dumps(today))
    assert [[one[key] for key in kept] for one in committed] == [[one[key] for key in kept] for one in plain], AGAIN


def test_table2(tmp_path: Path) -> None:
    from imo_analysis.pencils.table2 import table2

    study = Study.paper()
    _, observers = observers_of(study)
    write_table2(table2(study.machine, observers, study.poles.omega), tmp_path / "table2.csv")

    def rows(path: Path) -> list[list[str]]:
        with path.open(encoding="utf-8") as file:
            return list(csv.reader(file))

    committed, today = rows(PAPER / "table2.csv"), rows(tmp_path / "table2.csv")
    assert [row[:5] for row in committed] == [row[:5] for row in today], AGAIN
    for old, new in zip(committed[1:], today[1:], strict=True):
        assert [bool(cell) for cell in old] == [bool(cell) for cell in new], AGAIN
        numbers = [(float(a), float(b)) for a, b in zip(old[5:], new[5:], strict=True) if a]
        for a, b in numbers:
            assert a == pytest.approx(b, rel=1e-6, abs=1e-6), AGAIN


def test_study_and_page() -> None:
    study = Study.paper()
    assert (PAPER / "study.toml").read_text(encoding="utf-8") == study.to_toml(), AGAIN
    page = (PAPER / "index.html").read_text(encoding="utf-8")
    assert study.sha256 in page, AGAIN
    ledger = json.loads((PAPER / "ledger.json").read_text(encoding="utf-8"))
    assert all(f'id="entry-{entry["id"]}"' in page for entry in ledger["entries"]), AGAIN


def test_third_party_record(tmp_path: Path) -> None:
    folder = PAPER.parent / "immec"
    again = "run the command of reports/README.md for immec/ and read the difference"
    words = ["replay", str(immec()), "--machine", str(folder / "machine.toml"), "--observer", "all", "--after", "0.15"]
    assert cli.main([*words, "--plot", str(tmp_path / "replay.svg"), "--json", str(tmp_path / "replay.json")]) == 0
    old, new = (json.loads((place / "replay.json").read_text(encoding="utf-8")) for place in (folder, tmp_path))
    assert list(old["observers"]) == list(new["observers"]), again
    for name, one in new["observers"].items():
        assert one.keys() == old["observers"][name].keys(), again
        for key, value in one.items():
            if isinstance(value, float):
                assert old["observers"][name][key] == pytest.approx(value, rel=1e-4, abs=1e-6), (name, key, again)
        assert old["observers"][name]["gains"] == pytest.approx(one["gains"], rel=1e-6), again
    assert (folder / "replay.svg").read_text(encoding="utf-8").startswith("<svg")


def test_size() -> None:
    assert (PAPER / "index.html").stat().st_size < 3_000_000
    total = sum(path.stat().st_size for path in PAPER.parent.rglob("*") if path.is_file())
    assert total < 4_500_000
