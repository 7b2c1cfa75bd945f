"""The limits of the drive hold: the current that it asks for, read back from the voltage that its current loops compute."""

import math

import numpy as np
import pytest

from imo_analysis.simulation.drive import control
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study


def references(i, omega, phi, omega_ref, flux_ref, p, d):
    """``(i_d_ref, i_q_ref)`` of one sample, from its voltage with integrals at zero and a voltage limit out of reach."""
    _, L_m, sigma, beta, alpha, _, _, _ = p
    _, w_current, _, _, _, _, _ = d
    (u_ds, u_qs), _ = control((0.0, 0.0, 0.0), i, omega, phi, omega_ref, flux_ref, p, d)
    turn = complex(*phi).conjugate() / abs(complex(*phi))
    u, current = complex(u_ds, u_qs) * turn, complex(*i) * turn
    magnitude, gain = abs(complex(*phi)), w_current * sigma
    frequency = omega + alpha * L_m * current.imag / magnitude
    u_d = u.real + sigma * (frequency * current.imag + beta * alpha * magnitude)
    u_q = u.imag - sigma * (frequency * current.real + beta * omega * magnitude)
    return u_d / gain + current.real, u_q / gain + current.imag


@pytest.mark.parametrize("limit", [5.0, 12.0, 60.0])
def test_the_current_asked_for_is_within_the_limit_and_reaches_it(limit: float) -> None:
    study = Study.paper()
    drive = study.drive
    d = (1e-4, drive.current_bandwidth, drive.flux_bandwidth, drive.speed_bandwidth, 1e9, limit, 0.05 * drive.flux)
    random = np.random.default_rng(3)
    sizes = []
    for _ in range(2000):
        angle = random.uniform(0, 2 * math.pi)
        phi = tuple(random.uniform(0.1, 0.8) * np.array([math.cos(angle), math.sin(angle)]))
        i = tuple(random.normal(0, 20, 2))
        wanted = references(i, random.normal(0, 100), phi, random.normal(0, 100), random.uniform(0.2, 0.8),
                            study.machine.plant_parameters, d)
        sizes.append(math.hypot(*wanted))
    assert max(sizes) <= limit * (1 + 1e-6)
    assert np.mean(np.array(sizes) > 0.999 * limit) > 0.2


def test_the_currents_of_a_run_stay_about_the_limit() -> None:
    """A step of speed that takes all the current there is: the loop overshoots by no more than a tenth."""
    study = Study.paper().only(["baseline"]).changed({
        "simulation": {"duration": 0.6, "record_every": 1}, "windows": [],
        "reference": {"time": [0.0, 0.1], "omega": [20.0, 100.0]},
        "initial": {"i_ds": 8.83, "phi_dr": 0.5307, "omega": 20.0}, "drive.current_limit": 14.0,
    })
    run = simulate(study)
    size = np.hypot(run.i_ds, run.i_qs).values
    assert np.median(size[1050:1300]) > 13.9 and size.max() < 1.1 * 14.0
