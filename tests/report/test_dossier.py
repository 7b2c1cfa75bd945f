"""The dossier whole: a short study through every room, and the folder that it leaves (`conftest.py` makes it)."""

import csv
import html.parser
import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from fontTools.ttLib import TTFont
from pdf_objects import pdf_objects
from short_dossier import short_dossier_study

import imo_analysis
from imo_analysis.cli import main
from imo_analysis.errors import InputError
from imo_analysis.ledger.book import claims
from imo_analysis.notation import SYMBOLS
from imo_analysis.report.dossier import write_dossier
from imo_analysis.study import Study

pytestmark = pytest.mark.slow


class Reader(html.parser.HTMLParser):
    """Collects tags, ids, references, and elements that are not closed in order."""

    VOID = ("meta", "img", "input", "br", "link")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[tuple[str, str]] = []
        self.faults: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value or "")
            if name in ("src", "href", "srcset", "data", "action", "poster", "xlink:href"):
                self.links.append((tag, value or ""))

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.faults.append(f"</{tag}> at {self.getpos()}")


def read(text: str) -> Reader:
    reader = Reader()
    reader.feed(text)
    reader.close()
    return reader


def test_every_figure_file_brings_its_letters(folder: Path) -> None:
    fonts = Path(imo_analysis.__file__).parent / "fonts"
    known = {style: {*TTFont(fonts / file).getBestCmap(), 0x0A}
             for style, file in (("normal", "figure.woff2"), ("italic", "figure-italic.woff2"))}
    files = list((folder / "figures").glob("*.svg"))
    assert len(files) > 10
    for file in files:
        svg = ET.parse(file).getroot()
        assert "@font-face" in (svg.findtext("{*}style") or ""), file.name
        for text in svg.iter():
            if text.tag.endswith(("}text", "}tspan")) and text.text:
                style = "italic" if "italic" in text.get("style", "") else "normal"
                assert {ord(letter) for letter in text.text} <= known[style], (file.name, text.text)


def test_the_page_is_well_formed(text: str) -> None:
    reader = read(text)
    assert not reader.faults and not reader.open
    assert len(set(reader.ids)) == len(reader.ids)
    for formula in re.findall(r"<math.*?</math>", text, re.DOTALL):
        ET.fromstring(formula)
    assert 'class="unread"' not in text


def test_nothing_is_loaded_from_anywhere(text: str, folder: Path) -> None:
    reader = read(text)
    for tag, link in reader.links:
        if tag != "a" and not link.startswith("#"):
            assert link.startswith("data:"), (tag, link[:80])
        elif link.startswith("#"):
            assert link[1:] in reader.ids, link
        else:
            assert (folder / link).is_file(), link
    assert not re.search(r"url\((?!data:|#)", text)
    assert not re.search(r"(?:fetch|XMLHttpRequest|import)\s*\(", text)


def test_every_entry_of_the_ledger_is_there(text: str, folder: Path) -> None:
    ledger = json.loads((folder / "ledger.json").read_text(encoding="utf-8"))
    assert ledger["schema"] == "imo-ledger/1"
    assert [entry["id"] for entry in ledger["entries"]] == [claim.id for claim in claims()]
    for claim in claims():
        assert f'id="entry-{claim.id}"' in text


def test_the_first_screen_counts_what_the_ledger_says(text: str, folder: Path) -> None:
    ledger = json.loads((folder / "ledger.json").read_text(encoding="utf-8"))
    for verdict, kind in (("holds", "holds"), ("holds after correction", "corrected"), ("fails", "fails"),
                          ("not determined by the text", "open")):
        number = sum(entry["verdict"] == verdict for entry in ledger["entries"] if not entry["item"].endswith("(ours)"))
        assert re.search(rf'class="tile {kind}"[^>]*><b>{number}</b>', text)
    ours = sum(entry["item"].endswith("(ours)") for entry in ledger["entries"])
    assert re.search(rf"of our own: {ours} \([^)]*\), all proved\.", text)
    summary = json.loads((folder.parent / "summary.json").read_text(encoding="utf-8"))
    assert summary["schema"] == "imo-report/1" and sum(summary["verdicts"].values()) == len(ledger["entries"])


def test_it_is_small(text: str) -> None:
    assert len(text.encode()) < 3_000_000


def test_files(text: str, folder: Path) -> None:
    summary = json.loads((folder.parent / "summary.json").read_text(encoding="utf-8"))
    listed = {one["name"] for one in summary["files"]}
    there = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    assert listed == there
    for name in ("lyapunov", "modulation", "identifiability-plane", "fig1-speed", "fig1-window1", "fig4-alpha", "fig4-flux",
                 "poles-plane", "poles-speed", "fig4-excitation-consistent_12"):
        figure = folder / "figures" / f"{name}.svg"
        ET.parse(figure)
        assert f'href="figures/{name}.svg"' in text
    assert not [path for path in folder.parent.iterdir() if path.name.startswith(".")]


def test_table2_csv_has_the_printed_numbers(folder: Path) -> None:
    with (folder / "table2.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    baseline = [row for row in rows if row["observer"] == "baseline"]
    assert {float(row["printed_re (1/s)"]) for row in baseline} == {-479.11, -16.28, -474.37, -21.03, -466.28, -29.11}
    assert {float(row["omega (rad/s)"]) for row in rows} == {30.0, 60.0, 100.0}


def test_runs_can_be_loaded(folder: Path) -> None:
    from imo_analysis.simulation.runfile import load_run

    whole = load_run(folder / "runs" / "fig1.nc")
    again = load_run(folder / "runs" / "fig1.csv")
    assert whole.sizes["time"] <= 7500 and again.sizes["time"] <= 3000
    assert set(whole["observer"].values) == set(again["observer"].values)


def test_what_overflows_is_not_the_observer(text: str) -> None:
    assert "loses the speed for good at" in text and "the overflow later is that of the integrator" in text


def test_as_markdown(text: str, folder: Path) -> None:
    written = (folder / "index.md").read_text(encoding="utf-8")
    without_code = re.sub(r"`[^`]*`|```.*?```", "", written, flags=re.DOTALL)
    assert not re.search(r"<(?!a id=|/a>)[a-z]", without_code), "HTML is left over"
    for level in (1, 2, 3):
        in_page = len(re.findall(rf"<h{level}[ >]", text))
        assert len(re.findall(rf"^{'#' * level} ", written, re.MULTILINE)) == in_page > 0
    assert written.count("\n![") == text.count("<figure")
    for file in re.findall(r"!\[[^\]]*\]\(([^)]*)\)", written):
        assert (folder / file).is_file()
    assert all(f'<a id="entry-{claim.id}"></a>' in written for claim in claims())
    assert set(re.findall(r"\]\(#([^)]*)\)", written)) <= set(re.findall(r'<a id="([^"]*)">', written))
    assert r"\hat{\alpha}" in written and "\\class" not in written
    for row in re.findall(r"^\|.*$", written, re.MULTILINE):
        assert row.endswith("|")


def test_a_printer_that_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from imo_analysis.report.pdf import browser, print_page

    page = tmp_path / "index.html"
    page.write_text('<p>A page. <a href="beside.csv">a file</a> <a href="#top">top</a></p><p id="top">the top</p>',
                    encoding="utf-8")
    if browser() is not None:
        assert print_page(page, tmp_path / "index.pdf") == ""
        printed = (tmp_path / "index.pdf").read_bytes()
        objects = pdf_objects(printed)
        assert printed.startswith(b"%PDF") and any(b"/Link" in one for one in objects)
        assert not any(b"file://" in one for one in objects)
    monkeypatch.setenv("PATH", str(tmp_path))
    said = print_page(page, tmp_path / "none.pdf")
    assert said.startswith("no PDF: none of chromium") and "\n" not in said and not (tmp_path / "none.pdf").exists()


def test_every_symbol_is_explained(text: str) -> None:
    chapter = text.split('id="notation"')[1].split("</section>")[0]
    for name in SYMBOLS:
        assert f"<code>{name}</code>" in chapter


# When things go wrong --------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("fault", [KeyboardInterrupt(), OSError(28, "No space left on device")])
def test_an_interrupt_or_a_full_disk_leaves_nothing(tmp_path: Path, fault: BaseException) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "index.html").write_text("the last dossier", encoding="utf-8")

    def note(line: str) -> None:
        if line.startswith("excitation: what"):  # the ledger is written by then
            raise fault

    with pytest.raises(KeyboardInterrupt if isinstance(fault, KeyboardInterrupt) else InputError):
        write_dossier(short_dossier_study(), out, note)
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "index.html"]
    assert (out / "index.html").read_text(encoding="utf-8") == "the last dossier"


def test_a_folder_that_cannot_be_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert main(["report", "--out", str(tmp_path / "file" / "out")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "choose another place" in said


def test_a_diverging_observer_is_shown_and_the_others_stay(tmp_path: Path) -> None:
    from imo_analysis.report.scenarios import run_scenario

    data = dict(Study.paper().data)
    gains = data["observers"]["consistent_12"]["gains"]
    data["observers"] = {"good": data["observers"]["repaired"], "lost": {"kind": "printed_L", "gains": gains}}
    data["observers"]["lost"]["initial"] = {"alpha_hat": 6.6}
    data |= {"scenarios": {}, "reference": {"time": [0.0], "omega": [100.0]}}
    data["simulation"] = {"duration": 4.0}
    data["windows"] = [{"title": "w", "start": 3.0, "stop": 4.0, "caption": "the end"}]
    scenario = run_scenario(Study.from_data(data), "", tmp_path, lambda line: None, runs=False)
    assert "observer lost diverged at t = " in scenario.fault
    good, lost = scenario.windows[0].responses
    assert good.peak < 1.0 and not lost.peak < 1.0
    assert scenario.resting[-2].observer == "good" and abs(scenario.resting[-2].omega_hat - 100.0) < 0.1


def test_a_study_without_observers(tmp_path: Path) -> None:
    data = dict(Study.paper().data) | {"observers": {}, "scenarios": {}}
    with pytest.raises(InputError, match="has no observers; add at least one table"):
        write_dossier(Study.from_data(data), tmp_path / "out", lambda line: None)
    assert not (tmp_path / "out").exists()
