"""Runs that every observer drives once: who holds, who is said to, and whose run is drawn.

The study is that of a name plate of 7.5 kW, of which the loop closed on `BEARS` bears a stator resistance believed 5 % too
high and the loop closed on the others does not.
"""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imo_analysis.nameplate import Nameplate, machine_of
from imo_analysis.report.chapters.own_machine import own_machine
from imo_analysis.report.driven import driven_by_each, is_sensorless
from imo_analysis.report.metrics import Resting
from imo_analysis.report.own import cures, standings, to_take, verdicts
from imo_analysis.report.scenarios import Scenario, judged, outcome, run_scenario
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study
from imo_analysis.tuning.start import study_text

PLATE = {"power": 7500.0, "voltage": 400.0, "current": 15.2, "frequency": 50.0, "speed": "1455 rpm", "power_factor": 0.84}
BEARS = {"baseline", "baseline_turned"}


@pytest.fixture(scope="module")
def study() -> Study:
    plate = Nameplate.build(PLATE)
    return Study.from_toml(study_text(machine_of(plate, {"J": 0.03}, "plate"), plate=plate))


@pytest.fixture(scope="module")
def off(study: Study) -> Scenario:
    return driven_by_each(study, "closed_off", lambda line: None)


def test_which_runs_an_estimate_drives(study: Study) -> None:
    assert [name for name in study.scenarios if is_sensorless(study, name)] == ["closed", "closed_off"]
    assert not is_sensorless(study, "") and is_sensorless(study.changed({"drive.feedback": "quiet"}), "")


def test_each_drives_as_in_a_run_in_which_the_others_watch(study: Study, off: Scenario) -> None:
    """Speed, estimate and judgement against the whole run of the simulator."""
    ends = {one.observer: one for one in judged(off)}
    assert list(ends) == list(study.observers)
    for name, end in ends.items():
        chosen = study.scenario("closed_off").changed({"drive.feedback": name})
        run = simulate(chosen).sel(observer=name)
        last = run.sel(time=slice(float(run["time"][-1]) - 0.5, None))
        omega, error = float(last["omega"].mean()), last["omega"] - last["omega_hat"]
        assert end.omega == pytest.approx(omega, rel=1e-12) and end.rms == pytest.approx(float((error**2).mean()) ** 0.5)
        assert end.omega_hat == pytest.approx(float(last["omega_hat"].mean()), rel=1e-12)
        wanted = chosen.reference.omega[-1]
        assert end.wanted == pytest.approx(wanted)
        near = abs(omega - wanted) <= 0.02 * wanted and abs(float(error.mean())) <= 0.02 * omega
        assert (outcome(end) == "tracks") == near
    assert {name for name, end in ends.items() if outcome(end) == "tracks"} == BEARS, "both outcomes are put to the test"


def test_an_estimate_that_tracks_a_machine_at_another_speed_does_not_hold() -> None:
    end = Resting("one", 1.0, 100.0, 100.5, 9.9, 0.0, 0.0, 0.0, rms=0.5, wanted=100.0)
    assert outcome(end) == "tracks" and end.error == -0.5
    away = replace(end, wanted=110.0)
    assert outcome(away) == "is off" and away.error == 10.0
    assert outcome(replace(end, wanted=math.nan)) == "tracks", "an observer that watches is asked for its estimate only"
    assert outcome(Resting("one", *[math.nan] * 9)) == "is lost"


def test_a_loop_that_diverges_is_lost(study: Study) -> None:
    wild = study.changed({"observers.repaired.gains.K_p": 1e9, "simulation.duration": 2.0})
    ends = {one.observer: outcome(one) for one in judged(driven_by_each(wild, "closed", lambda line: None))}
    assert ends == {name: "is lost" if name == "repaired" else "tracks" for name in study.observers}


def test_the_one_to_take_is_drawn_and_all_are_judged_by_their_own(study: Study, off: Scenario, tmp_path: Path) -> None:
    """The table, the verdicts, the title and the command under the figure."""
    found = standings(study, [off], None)
    assert {one.observer for one in found[:2]} == BEARS == {one.observer for one in found if one.off == []}
    assert to_take(found) is found[0]
    study = study.changed({"scenarios.closed_off.drive": {"feedback": "repaired"}})
    drawn = run_scenario(study, "closed_off", tmp_path, lambda line: None, False, "baseline")
    assert drawn.titled.endswith(", driven by `baseline`")
    assert drawn.command == "imo simulate study.toml --scenario closed_off --feedback baseline --out closed_off.nc"
    assert "--feedback" not in run_scenario(study, "closed_off", tmp_path, lambda line: None, False, "repaired").command
    both = replace(drawn, driven=off.driven)
    lines = verdicts(study, found, None)
    assert all("It tracks in all of 1 runs" in line for line in lines[:2])
    assert all(", driving itself" in line for line in lines[2:])
    block = own_machine(study, [both], found, ([], lines), [], None)
    row = re.search(r"driven by each</td>(.*?)</tr>", block)[1]  # type: ignore[index]
    cells = re.findall(r"<td>([^<]*)</td>", row)
    assert sorted(one.split(",")[0] for one in cells) == [*["does not hold"] * 3, *["holds"] * 2] and "watches" not in row
    assert "Drawn below is the one that <code>baseline</code> drives" in block


def test_a_cure_lets_the_same_observer_drive(study: Study, off: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a modulation that changes nothing every number stays what it was."""
    from imo_analysis.excitation import design, design_check

    monkeypatch.setattr(design_check, "modulated_study", lambda chosen, modulated: chosen)
    cured = cures(study, [off], "quiet", object.__new__(design.Design))
    assert len(cured) == 1 and cured[0].before.observer == "quiet"
    for value in ("omega", "omega_hat", "wanted"):
        assert np.isclose(getattr(cured[0].before, value), getattr(cured[0].after, value), rtol=1e-9)
