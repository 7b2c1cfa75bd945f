"""The drive as it is, and a machine that is not the paper's: chapter and first screen from studies that differ."""

import math
import re
from pathlib import Path

import pytest

from imo_analysis.ledger.book import entries
from imo_analysis.report import drive
from imo_analysis.report.chapters.drive import drive_chapter
from imo_analysis.report.chapters.machine import machine_chapter
from imo_analysis.report.chapters.own_machine import own_machine, verdicts
from imo_analysis.report.chapters.verdicts import first_screen
from imo_analysis.report.metrics import Resting
from imo_analysis.report.page import Html
from imo_analysis.report.paper_machine import is_paper
from imo_analysis.report.scenarios import ExcitationResult, Scenario, outcome
from imo_analysis.study import Study


@pytest.fixture(scope="module")
def paper() -> Study:
    return Study.paper()


def other(study: Study, **names: str) -> Study:
    machine = {key: getattr(study.machine, key) for key in ("n_p", "R_s", "R_r", "L_m", "L_s", "L_r", "J")}
    return Study.from_data({**study.data, "scenarios": {}, "machine": {**machine, "R_r": 1.1 * machine["R_r"], **names}})


@pytest.mark.slow
def test_the_chapter_says_what_the_numbers_say(paper: Study, tmp_path: Path) -> None:
    refused = drive.compute(paper, tmp_path)
    result = drive.drawn(paper, tmp_path, refused, keep_files=False)
    assert refused == "" and not list(tmp_path.iterdir()) and result.features is not None and result.map is not None
    chapter = drive_chapter(result)
    plain = re.sub(r"<[^>]+>", "", chapter.body)
    error = result.features["speed_error"]
    dead_time, switching = (abs(float(error.sel(feature=name, observer="repaired"))) for name in ("dead time", "switching"))
    assert dead_time > 10 > switching
    assert "repaired is put off by more than 10 rad/s by dead time" in plain and "Uncompensated" in plain
    assert "baseline is put off by more than 10 rad/s by no part of the drive alone" in plain
    # the layer of the study is thinner than a sample's move, that of the scenario is not
    one = result.features.sel(observer="repaired")
    assert float(one["layer_of_study"]) < float(one["alpha_step"]) < float(one["layer"])
    # lost on zero stator frequency, away from it not
    plane = result.map.sel(observer="baseline")
    frequency = abs(plane["stator_frequency"])
    assert plane["holds"].where(frequency > 0.3 * frequency.max()).min() == 1 and plane["holds"].min() == 0


def test_a_study_without_any_of_it(paper: Study, tmp_path: Path) -> None:
    plain = other(paper)
    assert drive.featured(plain) is None and drive.featured(paper) == "real"
    body = drive_chapter(drive.drawn(plain, tmp_path, "no batch", keep_files=True)).body
    assert "The study has nothing of it" in body and "no map of this study: no batch" in body and "<img" not in body


def test_what_is_the_papers_machine(paper: Study) -> None:
    assert is_paper(paper.machine) and is_paper(paper.machine.model_copy(update={"name": "mine"}))
    assert not is_paper(other(paper).machine)


@pytest.mark.parametrize(("names", "said"), [
    ({}, "neither names its machine nor says where the parameters are from."),
    ({"source": "a data sheet"}, "The study does not name its machine. Source: a data sheet."),
    ({"name": "m1"}, "machine is <code>m1</code>; where its parameters are from it does not say."),
])
def test_another_machine_is_introduced_and_table_iii_left_out(paper: Study, names: dict[str, str], said: str) -> None:
    body = machine_chapter(other(paper, **names).machine).body
    assert said in body.replace("&#x27;", "'") and "two readings" not in body and "table-iii" not in body
    assert "two readings" in machine_chapter(paper.machine).body


def test_this_machine_stands_above_the_paper(paper: Study) -> None:
    study = other(paper)
    states = [Resting(name, 1.0, 100.0, 100.0 - error, study.machine.alpha + 0.5, 0.0, 0.0, 0.0)
              for name, error in (("good", 0.1), ("bad", 30.0), ("gone", math.nan))]
    scenario = Scenario("run", "the run", "", [], [], states, [], [], None, "")
    lost = {"conditions": {"reduced": {"holding": 0, "windows": 9, "lost": [{"text": "alpha_hat against omega_hat"}]}}}
    judged = [ExcitationResult("the run", lost, None)]  # type: ignore[arg-type]
    block = own_machine(study, [scenario], judged, None)
    for word in ("tracks", "is off", "is lost", "cannot be told apart", "0 of 9 windows", "What would cure it"):
        assert word in block
    screen = first_screen(study, entries(("flint",)), [], Html(block))
    assert screen.index("This machine") < screen.index('class="tiles"')


def rest(name: str, omega: float, error: float, rms: float) -> Resting:
    return Resting(name, 1.0, omega, omega - error, 9.9, 0.0, 0.0, 0.0, rms)


@pytest.mark.parametrize(("error", "omega", "rms", "said"), [
    (0.1, 100.0, 0.2, "tracks"), (2.1, 100.0, 2.1, "is off"), (math.nan, 1.0, math.nan, "is lost"), (0.03, 0.0, 0.03, "is off"),
    (0.0, 100.0, 9.9, "tracks"), (0.0, 100.0, 10.1, "is off")])
def test_an_outcome_is_of_the_mean_and_of_the_noise(error: float, omega: float, rms: float, said: str) -> None:
    assert outcome(rest("one", omega, error, rms)) == said


def test_verdicts_on_the_observers() -> None:
    runs = [Scenario(title, title, "", [], [], [rest("a", 100.0, 0.0, 0.1), rest("b", 100.0, error, 0.1)], [], [], None, "",
                     driver=driver) for title, error, driver in (("idle", 0.0, ""), ("braking", 50.0, "a"))]
    assert verdicts(runs) == ["`a` tracks in all of 2 runs. It drives the machine in: braking.",
                              "`b` tracks in 1 of 2 runs; it is off in: braking."]
