"""What each feature costs: the table's rows are the runs they say, and a feature that is off is no row."""

import numpy as np
import pytest

from imo_analysis.errors import InputError
from imo_analysis.simulation.run import simulate
from imo_analysis.sweeps.feature_costs import feature_costs


@pytest.fixture(scope="module")
def flawed(paper):
    return paper.only(["baseline", "repaired"]).changed({
        "simulation.duration": 1.2, "reference": {"time": [0.0], "omega": [30.0]}, "sensors.current_offset": [0.05, 0.0],
        "inverter": {"dc_link": 600.0, "dead_time": 1e-6}, "observers.repaired.errors.R_s": 0.1,
        "observers.repaired.initial.alpha_hat": 9.9354,
    })


@pytest.fixture(scope="module")
def table(flawed):
    return feature_costs(flawed, 0.8, 1.2)


def test_rows_are_what_the_study_has(table):
    assert list(table["feature"].values) == ["none", "current offset", "dead time", "stator resistance", "all"]


def test_rows_are_the_runs_they_say(flawed, table):
    alone = {"inverter": {"dc_link": 0.0, "dead_time": 0.0}, "observers.repaired.errors.R_s": 0.0}
    for name, study in (("all", flawed), ("current offset", flawed.changed(alone))):
        run = simulate(study)
        error = (run["omega_hat"] - run["omega"]).sel(time=slice(0.8, 1.2))
        np.testing.assert_allclose(table["speed_error"].sel(feature=name), error.mean("time"), rtol=1e-9)
        np.testing.assert_allclose(table["speed_ripple"].sel(feature=name), error.std("time"), rtol=1e-9)
    assert np.abs(table["speed_error"].sel(feature="none")).max() < 0.5


def test_an_error_of_one_observer_costs_no_other(table):
    column = table["speed_error"].sel(observer="baseline")
    assert float(column.sel(feature="stator resistance")) == float(column.sel(feature="none"))


def test_figure(table):
    from imo_analysis.drawing import svg_text
    from imo_analysis.report.feature_costs_figure import feature_costs_figure

    broken = table.copy(deep=True)
    broken["speed_error"][2, 1] = np.nan
    assert svg_text(feature_costs_figure(broken)) == svg_text(feature_costs_figure(broken))


def test_bad_input(flawed):
    with pytest.raises(InputError, match="start = 1 s and stop = 1 s must lie in the run"):
        feature_costs(flawed, 1.0, 1.0)
    with pytest.raises(InputError, match="no observers"):
        feature_costs(flawed.only([]), 0.8, 1.2)
