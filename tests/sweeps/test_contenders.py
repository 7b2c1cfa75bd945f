"""Everybody in the benchmark computes the same trajectory: C, kernel, lanes, scipy, python-control, motulator's machine.

Tolerances, relative to the largest state after 200 samples out of a turning start: 1e-12 where the steps are the same and
only rounding differs, 1e-7 against tight integrations (the error of one RK4 step a sample; measured 1e-8), 1e-9 between those.
"""

import json
import os
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import c_code, contenders, motulator_way

pytestmark = pytest.mark.slow
needs_c = pytest.mark.skipif(c_code.compiler() is None and os.environ.get("CI") != "true",
                             reason="no C compiler (CC, cc, gcc, clang)")


@pytest.fixture(scope="module")
def task():
    return contenders.task(200, settled=0.2)


@pytest.fixture(scope="module")
def exact(task):
    return contenders.exact(task)


def off(states, others):
    return float(np.max(np.abs(states - others)) / np.max(np.abs(others)))


@needs_c
def test_c_without_fused_products_is_the_kernel_to_the_bit(task):
    flags = (*c_code.FLAGS, "-ffp-contract=off")
    np.testing.assert_array_equal(contenders.c_single(task, flags), contenders.ours(task))


@needs_c
def test_c_as_it_is_timed(task):
    assert off(contenders.c_single(task), contenders.ours(task)) < 1e-12


@needs_c
def test_c_over_lanes():
    task = contenders.task(1000)
    values = contenders.different(task.study, 48)
    states, sums = contenders.CLanes(task, values)()
    ours = contenders.batch(task, values)
    for row, name in enumerate(ours.ends):
        assert off(ours.ends[name], states[row]) < 1e-12, name
    for row, name in enumerate(("speed_square", "speed_peak", "flux_square", "flux_peak")):
        assert off(ours.tallies[f"repaired/{name}"], sums[row]) < 1e-11, name


def test_kernel_and_plain_python(task):
    assert off(contenders.plain_python(task), contenders.ours(task)) < 1e-12


def test_one_step_a_sample_against_a_tight_integration(task, exact):
    assert 1e-10 < off(contenders.ours(task), exact) < 1e-7


def test_the_step_of_order_five_is_scipys(task):
    """Over one sample scipy's RK45 at a loose tolerance takes one step, of the method that ours is."""
    five = replace(task, study=task.study.changed({"simulation.order": 5}))
    assert off(contenders.ours(five), contenders.scipy_per_sample(task, 1e-3)) < 1e-14


def test_scipy(task, exact):
    assert off(contenders.scipy_per_sample(task), exact) < 1e-9


def test_python_control():
    task = contenders.task(20, settled=0.2)
    assert off(contenders.control_per_sample(task), contenders.exact(task)) < 1e-9


def test_python_control_in_one_call(task, exact):
    """It steps over the edges of the held voltage: three digits more for four of its tolerance, and never as good as ours."""
    coarse, fine = (off(contenders.control_in_one(task, rtol)(), exact) for rtol in (1e-3, 1e-7))
    assert off(contenders.ours(task), exact) < fine < 1e-4 < coarse < 1e-1


def test_motulator_has_the_same_machine(task):
    """Its own model, fed with the voltages of our loop, by the oracle that the tests of the machine use."""
    pytest.importorskip("motulator")
    import oracle_motulator

    from imo_analysis.simulation.run import simulate

    study = task.study.changed({"simulation.duration": 0.03, "simulation.record_every": 1, "windows": []})
    run = simulate(study)
    voltage = run["u_ds"].values + 1j * run["u_qs"].values
    current, omega, _ = oracle_motulator.run(study.machine, voltage, run["T_l"].values, 1e-4)
    assert off(run["i_ds"].values + 1j * run["i_qs"].values, current) < 1e-6
    assert off(run["omega"].values, omega) < 1e-6


def test_motulator_runs_its_own_drive():
    pytest.importorskip("motulator")
    assert np.isfinite(motulator_way.own_drive(0.01))


def test_motulator_runs_our_drive_and_observer_along_our_trajectory(task, exact):
    """Its machine, its loop and its solver, with our drive and observer put in: the same 13 states."""
    pytest.importorskip("motulator")
    assert off(motulator_way.same_task(task), exact) < 1e-9


def test_the_table_can_be_written_as_json():
    """Medians are numpy's numbers, which the json module refuses."""
    from benchmarks.__main__ import even, row

    value = np.float64(0.8)
    lines = [row("a", value, 1.1, False, ""), row("b", value, 500, True, ""), even("c", value, "")]
    assert [one["reached"] for one in json.loads(json.dumps(lines))] == [True, False, False]
