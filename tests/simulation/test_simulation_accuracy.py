"""RK4 is of order 4, against another integrator on the plain definitions, and exact enough at one step a sample."""

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


def test_order_four(turning, oracle):
    steps = np.array([1, 2, 4])
    errors = [scaled_error(states(simulate(turning.changed({"simulation.substeps": int(n)})), turning), oracle) for n in steps]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[0] < 1e-5
    assert np.all((orders > 3.8) & (orders < 4.2)), (errors, orders)


def test_many_steps_reach_the_oracle(turning, oracle):
    fine = states(simulate(turning.changed({"simulation.substeps": 24})), turning)
    assert scaled_error(fine, oracle) < 1e-10


def test_one_step_a_sample_is_enough_for_the_paper(paper):
    """Below 1e-6 of full scale over the 60 s; the finer run stands for the truth by the two tests above."""
    coarse, fine = states(simulate(paper), paper), states(simulate(paper.changed({"simulation.substeps": 8})), paper)
    assert scaled_error(coarse, fine) < 1e-6
