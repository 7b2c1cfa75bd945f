"""python-control's integration of the same systems gives the same trajectory."""

import control as ct
import numpy as np
import pytest

from imo_analysis.errors import InputError
from imo_analysis.simulation.nonlinear import machine_system, observer_system
from imo_analysis.simulation.run import simulate


@pytest.mark.parametrize("name", ["baseline", "repaired"])
def test_same_trajectory(turning, name):
    study = turning.only([name]).changed({"simulation.substeps": 8})
    run, T, samples = simulate(study), study.simulation.sample_time, 40
    settings = study.observers[name]
    machine = machine_system(study.machine)
    observer = observer_system(settings.kind, study.observer_machine(name), settings.gains)
    # an observer sees currents between samples, so the two are joined
    joined = ct.interconnect([machine, observer], inputs=["u_ds", "u_qs", "T_l"],
                             outputs=[*machine.output_labels, *observer.output_labels])
    x = np.array([float(run[state][0]) for state in machine.state_labels]
                 + [float(run[state].sel(observer=name)[0]) for state in observer.state_labels])
    for k in range(samples):
        u = np.array([[float(run[key][k])] * 2 for key in ("u_ds", "u_qs", "T_l")])
        tight = {"rtol": 1e-10, "atol": 1e-10}
        x = ct.input_output_response(joined, np.array([0.0, T]), u, x, solve_ivp_kwargs=tight).states[:, -1]
    expected = [float(run[state][samples]) for state in machine.state_labels]
    expected += [float(run[state].sel(observer=name)[samples]) for state in observer.state_labels]
    np.testing.assert_allclose(x, expected, rtol=1e-6, atol=1e-7)


def test_flux_is_an_output(turning):
    system = observer_system("repaired", turning.machine, turning.observers["repaired"].gains)
    assert system.output_labels[-2:] == ["phi_dr_hat", "phi_qr_hat"]


def test_wrong_gains_are_named(turning):
    with pytest.raises(InputError, match="gains of baseline must be l_1, l_2"):
        observer_system("baseline", turning.machine, {"k_1": 1.0})
    with pytest.raises(InputError, match="choose one of"):
        observer_system("kalman", turning.machine, {})
