"""The trajectory that the entry for (16) names: `imo simulate --scenario lyapunov`."""

from __future__ import annotations

import numpy as np
import pytest

from imo_analysis.equations import lyapunov
from imo_analysis.machine import PRESETS
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study


@pytest.fixture(scope="module")
def run():
    return simulate(Study.paper().scenario("lyapunov"))


def levels(run, observer, function, **more):
    """A Lyapunov function along the run."""
    machine = PRESETS["table-iii-printed-alpha"]
    hat = run.sel(observer=observer)
    z = (run.i_ds + machine.beta * run.phi_dr, run.i_qs + machine.beta * run.phi_qr)
    true = {
        "i_ds": run.i_ds,
        "i_qs": run.i_qs,
        "z_1": z[0],
        "z_2": z[1],
        "xi_1": z[0],
        "xi_2": z[1],
        "alpha": machine.alpha,
        "omega": run.omega,
    }
    errors = {f"{name}_tilde": value - hat[f"{name}_hat"] for name, value in true.items()}
    if "omega_hat" in more:
        more["omega_hat"] = hat.omega_hat
    return function(**errors, alpha=machine.alpha, omega=run.omega, k_3=100.0, g=1.0, K_p=100.0, **more).values


def test_everything_that_the_proof_asks_for_is_given(run):
    assert np.ptp(run.omega.values) < 0.005
    before = run.sel(observer="consistent_12").omega_hat.values[:140]
    assert before.min() > 0


def test_v_of_13_grows(run):
    V = levels(run, "consistent_12", lyapunov.corrected_13, k_2=50.0, omega_hat=None)
    assert V[:10].max() > V[0] + 20
    assert V[:150].max() > 20 * V[0]


def test_v_of_the_repaired_observer_falls(run):
    V = levels(run, "repaired", lyapunov.with_direction, kappa=50.0, direction=1)
    assert np.all(np.diff(V) < 0)
