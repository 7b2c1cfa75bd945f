"""The steps are of their order, against another integrator on the plain definitions, and exact enough at one a sample."""

import numpy as np
import pytest
from oracle_closed_loop import closed_loop

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.simulation.kernel import PLANT_STATES
from imo_analysis.simulation.run import simulate


def states(run, study):
    result = {"machine": np.array([run[name].values for name in PLANT_STATES]).T}
    for name, settings in study.observers.items():
        result[name] = np.array([run[state].sel(observer=name).values for state in OBSERVERS[settings.kind].states]).T
    return result


def scaled_error(found, true):
    """Largest error of any state, each relative to the largest size of its own kind in the run."""
    return max(np.max(np.abs(found[name] - true[name]) / np.max(np.abs(true[name]), axis=0)) for name in true)


@pytest.fixture(scope="module")
def oracle(turning):
    return closed_loop(turning, turning.simulation.samples)


@pytest.mark.parametrize("order", [4, 5])
def test_order(turning, oracle, order):
    steps = [turning.changed({"simulation.substeps": n, "simulation.order": order}) for n in (1, 2, 4)]
    errors = [scaled_error(states(simulate(study), turning), oracle) for study in steps]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[0] < {4: 1e-5, 5: 1e-7}[order]
    assert np.all(np.abs(orders - order) < 0.2), (errors, orders)


@pytest.mark.parametrize("changes", [
    {"mechanics": {"load_share": 0.3, "stiffness": 500.0, "damping": 0.5, "coulomb": 0.2},
     "saturation": {"knee": 0.6, "power": 3}},
    {"inverter": {"dc_link": 600.0, "dead_time": 1e-6, "pwm": "switched", "delay": 1}, "sensors.current_resolution": 0.01},
])
def test_both_orders_with_what_a_drive_has(turning, changes):
    """The same motion to the error of the coarser, which is not none: what each feature adds to the loop is in both."""
    alone = turning.only(["repaired"]).changed(changes)
    four, five = (states(simulate(alone.changed({"simulation.order": order})), alone) for order in (4, 5))
    assert 0 < scaled_error(four, five) < 1e-5


@pytest.mark.parametrize(("scenario", "least", "most"),
                         [("sensorless", 25, 40), ("fig4", 150, 400), ("regenerating", 700, 1200)])
def test_how_much_more_exact_order_five_is_in_the_scenarios(paper, scenario, least, most):
    """The 30 to 900 times that the manual names, at one step a sample, against sixteen."""
    study = paper.scenario(scenario).changed({"simulation.duration": 8.0, "simulation.record_every": 10, "windows": []})
    if scenario == "fig4":
        study = study.changed({"reference.time": [0.0, 2.0, 4.0]})
    four, five, fine = (states(simulate(study.changed(more)), study) for more in (
        {}, {"simulation.order": 5}, {"simulation.order": 5, "simulation.substeps": 16}))
    assert least < scaled_error(four, fine) / scaled_error(five, fine) < most


def test_many_steps_reach_the_oracle(turning, oracle):
    fine = states(simulate(turning.changed({"simulation.substeps": 24})), turning)
    assert scaled_error(fine, oracle) < 1e-10


def test_one_step_a_sample_is_enough_for_the_paper(paper):
    """Below 1e-6 of full scale over the 60 s; the finer run stands for the truth by the two tests above."""
    coarse, fine = states(simulate(paper), paper), states(simulate(paper.changed({"simulation.substeps": 8})), paper)
    assert scaled_error(coarse, fine) < 1e-6
