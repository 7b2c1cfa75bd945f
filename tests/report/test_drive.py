"""The drive as it is, and a machine that is not the paper's: chapter and first screen from studies that differ."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from imo_analysis.errors import Diverged
from imo_analysis.ledger.book import entries
from imo_analysis.nameplate import guess, guessed_range
from imo_analysis.report import drive
from imo_analysis.report.chapters.drive import drive_chapter
from imo_analysis.report.chapters.machine import machine_chapter
from imo_analysis.report.chapters.own_machine import own_machine, tried_on
from imo_analysis.report.chapters.verdicts import first_screen
from imo_analysis.report.metrics import Resting
from imo_analysis.report.own import GENERATING, Cured, advice, cures, overloads, standings, verdicts
from imo_analysis.report.page import Html
from imo_analysis.report.paper_machine import is_paper
from imo_analysis.report.scenarios import ExcitationResult, Scenario, outcome, resting_of
from imo_analysis.simulation.judge import spared
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study
from imo_analysis.tuning.start import study_of


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
    block = own_machine(study, [scenario], standings(study, [scenario], None), (["take one"], ["one is good"]), judged, None)
    for word in ("take one", "one is good", "tracks", "off, 30 rad/s (30 %, 143 r/min)", "is lost", "cannot be told apart",
                 "0 of 9 windows", "was not designed"):
        assert word in block
    assert block.index("take one") < block.index("one is good") < block.index("off, 30 rad/s")
    screen = first_screen(study, entries(("flint",)), ["a number"], Html(block))
    assert (screen.index("Which observers of speed work") < screen.index("take one") < screen.index("a number")
            < screen.index("About the paper, not this machine") < screen.index('class="tiles"'))
    papers = first_screen(paper, entries(("flint",)), ["a number"])
    assert papers.index('class="tiles"') < papers.index("a number") and "About the paper" not in papers


def rest(name: str, omega: float, error: float, rms: float) -> Resting:
    return Resting(name, 1.0, omega, omega - error, 9.9, 0.0, 0.0, 0.0, rms)


@pytest.mark.parametrize(("error", "omega", "rms", "said"), [
    (0.1, 100.0, 0.2, "tracks"), (2.1, 100.0, 2.1, "is off"), (math.nan, 1.0, math.nan, "is lost"),
    (1.01, 0.0, 1.01, "is off"), (0.9, 10.0, 1.0, "tracks"),
    (0.0, 100.0, 9.9, "tracks"), (0.0, 100.0, 10.1, "is off")])
def test_an_outcome_is_of_the_mean_and_of_the_noise(error: float, omega: float, rms: float, said: str) -> None:
    assert outcome(rest("one", omega, error, rms)) == said


def plane_of(holds: dict[str, float], limits: dict[str, list[tuple[float, float]]]) -> xr.Dataset:
    """A map with one point of speed and load in ten, and these limits of R_s at 100 and 20 rad/s."""
    names, speeds = list(holds), np.linspace(10.0, 100.0, 10)
    well = np.array([[np.arange(10) < 10 * share] for share in holds.values()])
    error = np.where(well, 0.5, 30.0)
    both = np.array([limits[name] for name in names])
    return xr.Dataset(
        {"holds": (("observer", "T_l", "omega"), well.astype(np.int8)), "speed_error": (("observer", "T_l", "omega"), error),
         "R_s_low": (("observer", "limit_omega"), both[..., 0]), "R_s_high": (("observer", "limit_omega"), both[..., 1])},
        {"observer": names, "T_l": [8.0], "omega": speeds, "limit_omega": [100.0, 20.0],
         "stator_frequency": (("T_l", "omega"), speeds[None, :] - 10.0)},
        {"R_s_error": 0.05, "limit_torque": 8.0})


@pytest.fixture
def two_runs() -> list[Scenario]:
    """Idle, where both track; and braking, where `repaired` is 50 rad/s off and `baseline` drives."""
    return [Scenario(title, title, "", [], [],
                     [rest("baseline", 100.0, 0.0, 0.1), rest("repaired", 100.0, error, error + 0.1)],
                     [], [], None, "", driver=driver)
            for title, error, driver in (("idle", 0.0, ""), ("braking", 50.0, "baseline"))]


PLATE = ('[nameplate]\npower = "7.5 kW"\nvoltage = "400 V"\ncurrent = "15.2 A"\nfrequency = "50 Hz"\nspeed = "1455 rpm"\n'
         'power_factor = 0.84\n[machine]\nJ = 0.03\n')
WIDE, NARROW, NEVER = [(-0.5, 0.13), (-0.07, 0.06)], [(-0.2, 0.007), (-0.04, 0.01)], [(math.nan, math.nan)] * 2


def test_verdicts_on_the_observers(paper: Study, two_runs: list[Scenario]) -> None:
    """Best first by the map, whatever the runs say; sizes in rad/s, per cent and r/min (two pole pairs)."""
    study = other(paper)
    plane = plane_of({"baseline": 0.2, "repaired": 1.0}, {"baseline": NARROW, "repaired": WIDE})
    found = standings(study, two_runs, plane)
    assert [one.observer for one in found] == ["repaired", "baseline"]
    first, second = verdicts(study, found, plane)
    assert "with R_s believed 5 % too high, the machine holds at 100 % of the points" in first
    assert "at 20 % of the points" in second
    assert "off by 0.5 rad/s (0.5 %, 2.39 r/min)" in first and "off by 30 rad/s (30 %, 143 r/min)" in second
    assert "from 50 % or more too low to 13 % too high" in first and "from 20 % too low to 0.7 % too high" in second
    assert first.endswith("It tracks in 1 of 2 runs, worst in “braking”, where it is off by 50 rad/s (50 %, 239 r/min) "
                          "(`baseline` drives).")
    assert second.endswith("It tracks in all of 2 runs.")
    never = plane_of({"baseline": 0.9, "repaired": 0.1}, {"baseline": WIDE, "repaired": NEVER})
    turned = standings(study, two_runs, never)
    assert [one.observer for one in turned] == ["baseline", "repaired"]
    assert "not even with the right R_s" in verdicts(study, turned, never)[1]
    assert [one.observer for one in standings(study, two_runs, None)] == ["baseline", "repaired"], "without a map by the runs"


def test_an_observer_that_alone_has_the_right_parameters_is_said_to(paper: Study, two_runs: list[Scenario]) -> None:
    """As one that was added to a study has them where a scenario gives `errors` to the others by name."""
    study = other(paper).only(["baseline", "repaired"]).changed(
        {"observers.baseline.errors": {}, "observers.repaired.initial.alpha_hat": paper.machine.alpha})
    off = {"scenarios": {"braking": {"title": "braking", "observers": {"repaired": {"errors": {"R_s": 0.05}}}}}}
    uneven = Study.from_data({**study.data, **off})
    found = standings(uneven, two_runs, None)
    easier, asked = verdicts(uneven, found, None)
    assert easier.endswith("all of 2 runs, in 1 of which it has the right parameters and others have not.")
    assert "right parameters" not in asked
    block = own_machine(uneven, two_runs, found, ([], []), [], None)
    cells = re.findall("<td[^>]*>(.*?)</td>", block.split("<details")[0])
    assert ["with the right parameters" in cell for cell in cells] == [False, False, False, False, True, False]
    even = uneven.changed({"scenarios.braking.observers.baseline.errors": {"R_s": 0.05}})
    assert not any("right parameters" in line for line in verdicts(even, found, None))
    assert spared(paper.scenario("fig4")) == ([], []), "beside the baseline's wrong alpha they begin with a wrong alpha_hat"


def test_which_to_take_or_that_none_works(paper: Study, two_runs: list[Scenario]) -> None:
    study = other(paper)

    def said(limits: dict[str, list[tuple[float, float]]]) -> str:
        plane = plane_of({"baseline": 0.2, "repaired": 0.6}, limits)
        return advice(study, standings(study, two_runs, plane), plane, "")[0]

    one = said({"baseline": NARROW, "repaired": WIDE})
    assert one.startswith("Take `repaired`:") and "at 100 rad/s (477.5 r/min) and 8 N m" in one
    assert one.endswith("It does not hold so with `baseline`.")
    other_way = said({"baseline": WIDE, "repaired": NARROW})
    assert other_way.startswith("Take `baseline`:"), "the best that works, not the best of the map"
    both = said({"baseline": WIDE, "repaired": WIDE})
    assert "does not hold so with" not in both
    assert "It fails at 0 of the 1 points within 10 % of the largest stator frequency around zero" in one
    assert "and at 4 of the other 9." in one
    none = said({"baseline": NARROW, "repaired": NARROW})
    assert none.startswith("None of these observers works") and "The best of them is `repaired`" in none
    assert "was not computed: no batch." in advice(study, standings(study, two_runs, None), None, "no batch")[0]


def test_of_the_one_that_adapts_R_s_it_says_that_it_drifts_generating(paper: Study, two_runs: list[Scenario]) -> None:
    study = other(paper)
    plane = plane_of({"baseline": 1.0, "repaired": 0.6}, {"baseline": WIDE, "repaired": WIDE})
    found = standings(study, two_runs, plane)
    assert GENERATING not in advice(study, found, plane, "")[0]
    assert advice(study, [replace(found[0], kind="baseline_resistance"), found[1]], plane, "")[0].endswith(GENERATING)
    assert GENERATING not in advice(study, [replace(found[0], kind="baseline_turned"), found[1]], plane, "")[0]


def test_what_the_stator_resistance_is_worth(paper: Study, two_runs: list[Scenario], tmp_path: Path) -> None:
    """A plate without R_s: it is a guess, whose range stands beside what the loop bears; with a measured one it does not."""
    file = tmp_path / "motor.toml"

    def decides(more: str, limits: list[tuple[float, float]], other: list[tuple[float, float]] | None = None,
                **source: str) -> tuple[Study, str]:
        file.write_text(PLATE + more, encoding="utf-8")
        study = Study.from_toml(study_of(str(file)))
        study = study.changed({f"machine.{name}": value for name, value in source.items()})
        plane = plane_of({"baseline": 1.0, "repaired": 0.6}, {"baseline": limits, "repaired": other or limits})
        return study, advice(study, standings(study, two_runs, plane), plane, "")[1]

    study, said = decides("", WIDE)
    low, high = guessed_range(study.machine.source)
    assert low < study.machine.R_s < high and f"between {low:.3g} and {high:.3g} Ω" in said
    assert f"{study.machine.R_s:.4g} Ω" in said and "which is more than the loop above holds for" in said
    assert "to 50 % or more too high" in said, "the plate leaves half of it open"
    close = guess(0.96 * study.machine.R_s, 1.05 * study.machine.R_s)
    borne = decides("", WIDE, source=close)[1]
    assert re.search(r"from 4\.\d % too low to 4\.\d % too high, for all of which the loop above holds\.", borne)
    assert "which is more than the loop above holds for" in decides("", NARROW, source=close)[1]
    all_tried = decides("", [(-0.5, 0.5)] * len(WIDE))[1]
    assert "to 50 % or more too high, and as far as that was tried, 50 %, the loop above holds." in all_tried
    assert ("which is more than the loop above holds for; with `repaired` it holds for all that was tried at those two points."
            in decides("", WIDE, [(-0.5, 0.5)] * 2)[1])
    assert "only an estimate" not in decides('R_s = "1.2 ohm"\n', WIDE)[1]
    unmapped = advice(study, standings(study, two_runs, None), None, "no batch")[-1]
    assert "is only an estimate" in unmapped and "to 50 % or more too high. Measure it" in unmapped
    assert "loop above" not in unmapped


def test_a_load_that_no_machine_carries(paper: Study, two_runs: list[Scenario]) -> None:
    limit = paper.torque_limit
    i = np.sqrt(paper.drive.current_limit**2 - (paper.drive.flux / paper.machine.L_m) ** 2)
    assert limit == pytest.approx(1.5 * 2 * paper.machine.L_m / paper.machine.L_r * paper.drive.flux * i)
    for share, carried in ((0.97, True), (1.03, False)):
        run = simulate(paper.changed({
            "reference": {"shape": "steps", "time": [0.0], "omega": [0.0]}, "simulation.duration": 2.0, "windows": [],
            "load": {"shape": "linear", "time": [0.0, 1.0], "T_l": [0.0, share * limit]}}))
        assert (abs(float(run["omega"][-1])) < 10.0) == carried, share
    assert overloads(paper, two_runs) == []
    too_much, = overloads(paper.changed({"load.T_l": [2 * limit] * len(paper.load_torque.T_l)}), two_runs[:1])
    assert f"the load reaches {2 * limit:.4g} N m" in too_much and f"at most {limit:.4g} N m" in too_much
    with pytest.raises(Diverged, match=f"at most {limit:.4g} N m"):
        simulate(paper.changed({"load.T_l": [20 * limit] * len(paper.load_torque.T_l), "simulation.duration": 3.0}))


@pytest.mark.slow
def test_a_cure_is_tried_on_the_runs_that_need_it(tmp_path: Path) -> None:
    """A modulation cures a wrong alpha; it does not cure a wrong stator resistance."""
    from imo_analysis.excitation.design import assess
    from imo_analysis.excitation.design_check import plant_of, wanted_of

    file = tmp_path / "motor.toml"
    file.write_text(PLATE, encoding="utf-8")
    study = Study.from_toml(study_of(str(file)))
    found = assess(plant_of(study, "repaired"), wanted_of(study, "repaired"), depth=0.02, frequency=200.0)
    runs = []
    for name in ("load", "alpha", "warm"):
        chosen = study.scenario(name)
        runs.append(Scenario(name, name, "", [], [], resting_of(simulate(chosen), chosen), [], [], None, ""))
    tried = {one.title: one for one in cures(study, runs, "repaired", found)}
    assert set(tried) == {"alpha", "warm"}, "the run in which it tracks needs none"
    text = tried_on("repaired", list(tried.values()), 2)
    assert "With it `repaired` tracks in “alpha”" in text and "It does not cure “warm”" in text
    assert "tracks in every run" in tried_on("repaired", [], 2)
    well = Cured("x", rest("r", 100.0, 9.0, 9.0), rest("r", 100.0, 0.1, 0.1))
    assert "does not cure" not in tried_on("r", [well], 2) and "(9 rad/s to 0.1 rad/s)" in tried_on("r", [well], 2)
