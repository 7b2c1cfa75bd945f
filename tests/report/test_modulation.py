"""The dossier's section on what cures, for a small motor from its plate, and when a run of it fails."""

import re
from pathlib import Path

import numpy as np
import pytest

from imo_analysis.errors import Diverged
from imo_analysis.excitation.duty import loads_of, mixed_duty, speeds_of
from imo_analysis.report import duty as duty_section
from imo_analysis.report.chapters.cure import cure_section
from imo_analysis.report.modulation import Modulation, modulation
from imo_analysis.study import Study

PLATE = {"power": 250.0, "voltage": 400.0, "current": 0.8, "power_factor": 0.70, "frequency": 50.0, "speed": "1380 rpm"}


@pytest.fixture(scope="module")
def small() -> Study:
    """A motor of 250 W: rated for 1.73 N m and 93 to 145 rad/s, where 20 to 100 rad/s and 8 N m are out of reach."""
    from imo_analysis.nameplate import Nameplate, machine_of
    from imo_analysis.tuning.start import study_text

    machine = machine_of(Nameplate.build(PLATE), {"name": "m250", "J": 0.0006}, "small")
    return Study.from_toml(study_text(machine), "small")


@pytest.fixture(scope="module")
def cured(small: Study, tmp_path_factory: pytest.TempPathFactory) -> Modulation:
    found = modulation(small, tmp_path_factory.mktemp("small"))
    assert found is not None
    return found


def test_the_duty_lies_in_the_range_of_the_study(small: Study) -> None:
    hour = mixed_duty(small, 400.0, noise=small.noise)
    (low, high), load = small.tuning.omega, small.largest_torque
    assert set(hour.reference.omega) <= set(speeds_of(small)) and set(hour.load_torque.T_l) <= set(loads_of(small))
    assert (min(speeds_of(small)), max(speeds_of(small))) == pytest.approx((low, high), abs=1e-3)
    assert 0.7 * load < max(loads_of(small)) < load and min(loads_of(small)) == 0
    assert loads_of(Study.paper()) == [0.0, 2.0, 5.0, 8.0]


@pytest.mark.slow
def test_a_small_motor_gets_its_whole_section(cured: Modulation) -> None:
    assert cured.chosen and not cured.refused and cured.checks
    assert all(one.keeps(cured.wanted) for one in cured.checks)
    assert isinstance(cured.duty, duty_section.Duty)
    rows = {row.observer: row for row in cured.duty.rows}
    assert set(rows) == {"consistent_12", "repaired", "quiet", "supervised"}
    assert rows["supervised"].moved < 0.05 < min(row.moved for name, row in rows.items() if name != "supervised")
    text = re.sub(r"<[^>]+>", " ", "".join(cure_section(cured)))
    assert "the accuracy is reached within the limits" in text and "quiet" in text and "or faster" not in text


@pytest.mark.slow
def test_a_run_that_diverges_costs_its_paragraph_and_no_more(
        cured: Modulation, small: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(study: Study) -> None:
        raise Diverged("the machine diverged at t = 0.7853 s", 0.7853, {})

    monkeypatch.setattr("imo_analysis.simulation.run.simulate", lost)
    assert cured.design
    told = duty_section.duty(small, cured.design, tmp_path, small.noise)
    assert told == "The run of mixed duty is not shown: the machine diverged at t = 0.7853 s."
    whole = modulation(small, tmp_path)
    assert whole and whole.refused.endswith("the machine diverged at t = 0.7853 s") and whole.chosen is None
    assert "the machine diverged" in "".join(cure_section(whole))
    without = small.only(["repaired"])
    assert "needs an observer of kind repaired" in str(duty_section.duty(without, cured.design, tmp_path, small.noise))


@pytest.mark.slow
def test_closed_gram_matrices_are_the_simulated_ones(small: Study) -> None:
    """The machine under its drive against the closed form at held torque; the one at constant slip is another."""
    from imo_analysis.report.gram_table import gram_rows

    rows = gram_rows(small, 0.05, 30.0)
    assert [(row.torque > 0, row.depth > 0) for row in rows] == [(False, False), (True, False), (False, True), (True, True)]
    for row in rows:
        size = np.sqrt(np.outer([row.held[0], row.held[2]], [row.held[0], row.held[2]]))[np.triu_indices(2)]
        assert np.abs(np.subtract(row.simulated, row.held)) == pytest.approx(0.0, abs=1e-3 * max(size))
    last = rows[-1]
    assert abs(last.simulated[0] - last.held[0]) < 0.3 * abs(last.simulated[0] - last.even[0])
    assert gram_rows(small.only(["baseline"]), 0.05, 30.0) == []
