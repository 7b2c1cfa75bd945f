"""The supervisor's threshold: what noise makes of S, and that it bounds gate and drift, against runs without excitation."""

import math

import numpy as np
import pytest
from synthetic import MACHINE

from imo_analysis.errors import InputError
from imo_analysis.excitation.duty import REST, mixed_duty, supervisor_threshold
from imo_analysis.excitation.settling import seen_by_supervisor
from imo_analysis.excitation.supervision import OPEN, NoiseFloor, _error_filter, ceiling, noise_floor
from imo_analysis.study import Study

STUDY = Study.paper()
GAINS = STUDY.observers["repaired"].gains


def test_rule_and_bound_are_each_others_inverse():
    floor = NoiseFloor(0.2, 0.01)
    S_0 = floor.threshold(2.0, 1e-5)
    assert floor.drift(2.0, S_0) == pytest.approx(1e-5) and floor.gate(S_0) < 1e-4
    assert floor.drift(2.0, 1.01 * S_0) < 1e-5 < floor.drift(2.0, 0.99 * S_0)


def test_moments_of_a_normal_variable():
    """105 and 15!! by quadrature."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(20)
    from imo_analysis.excitation.supervision import EIGHTH, SIXTEENTH

    for power, moment in ((8, EIGHTH), (16, SIXTEENTH)):
        assert float(weights @ nodes**power) / math.sqrt(2 * math.pi) == pytest.approx(moment, rel=1e-9)


def test_the_bound_of_the_drift_is_schwarzs():
    """c = sqrt(E r^16 E r^4) for standard normal r, by quadrature; and the rule lets noise move alpha_hat by 0.03 /s a run."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(20)
    weights = weights / math.sqrt(2 * math.pi)
    moments = weights @ nodes**16, weights @ nodes**4
    assert NoiseFloor(1.0, 1.0).drift(1.0, 1.0) == pytest.approx(math.sqrt(moments[0] * moments[1]), rel=1e-9)
    found = supervisor_threshold(STUDY, GAINS, 0.1, 3600.0)
    floors = [noise_floor(MACHINE, GAINS, STUDY.drive, 0.1, omega, torque) for omega in (20.0, 150.0) for torque in (0.0, 8.0)]
    assert 3600.0 * max(one.drift(GAINS["g"], found.least) for one in floors) == pytest.approx(0.03, rel=1e-3)


def test_the_coordinates_are_complete_and_stable():
    """The offsets of xi_hat and z_hat drop out: what is kept obeys equations of its own, and they decay."""
    A, B, C = _error_filter(MACHINE, GAINS, 0.5307, 50.0, 3.6, 1.0)
    assert np.linalg.eigvals(A).real.max() < -0.9 and B.shape == (9, 2) and C.shape == (9,)


def test_the_ceiling_opens_the_gate():
    from imo_analysis.equations.supervised import gate

    assert gate(640.0, ceiling(640.0)) == pytest.approx(OPEN)


def test_noise_counts_by_its_square_and_a_threshold_needs_room():
    one, two = (noise_floor(MACHINE, GAINS, STUDY.drive, noise, 50.0, 5.0) for noise in (0.1, 0.2))
    assert two.across == pytest.approx(4 * one.across) and two.error == pytest.approx(4 * one.error)
    found = supervisor_threshold(STUDY, GAINS, 0.1, 3600.0, 0.0158, 136.3)
    assert found.floor < found.least < found.S_0 < found.most < seen_by_supervisor(MACHINE, 0.5307, 0.0158, 136.3)
    ends = [noise_floor(MACHINE, GAINS, STUDY.drive, 0.1, omega, torque, 1.0, 1e-4).threshold(GAINS["g"], REST / 3600.0)
            for omega in (20.0, 150.0) for torque in (0.0, 8.0)]
    assert found.least == pytest.approx(max(ends)) and max(ends) > 1.001 * min(ends)
    with pytest.raises(InputError, match="modulate deeper or faster"):
        supervisor_threshold(STUDY, GAINS, 2.0, 3600.0, 0.0158, 136.3)


@pytest.mark.slow
@pytest.mark.parametrize(("omega", "torque"), [(20.0, 0.0), (100.0, 5.0)])
def test_noise_alone_makes_s_what_the_equations_say(omega, torque):
    """The mean of S within 15 %; the mean gate and the drift within their bounds, at an S_0 near the noise."""
    from imo_analysis.equations.supervised import gate
    from imo_analysis.simulation.run import simulate

    floor = noise_floor(MACHINE, GAINS, STUDY.drive, 0.1, omega, torque)
    S_0 = 4 * floor.across
    study = mixed_duty(STUDY, 120.0).only(["supervised"]).changed({
        "reference.time": [0.0], "reference.omega": [omega], "load.time": [0.0], "load.T_l": [torque],
        "observers.supervised.gains.S_0": S_0, "simulation.record_every": 100})
    run = simulate(study).sel(observer="supervised", time=slice(20.0, None))
    S = run.S.values
    assert float(S.mean()) == pytest.approx(floor.across, rel=0.15)
    assert 0 < float(np.mean(gate(S, S_0))) < floor.gate(S_0)
    moved = float(run.alpha_hat[-1] - run.alpha_hat[0]) / 100.0
    assert abs(moved) < floor.drift(GAINS["g"], S_0)
    error = np.concatenate([run.i_ds_meas - run.i_ds_hat, run.i_qs_meas - run.i_qs_hat])
    assert float((error**2).mean()) == pytest.approx(floor.error, rel=0.1)


@pytest.mark.slow
def test_at_the_rules_threshold_noise_moves_nothing():
    """Two minutes without excitation at the rule's own S_0."""
    from imo_analysis.simulation.run import simulate

    study = mixed_duty(STUDY, 120.0).only(["supervised"]).changed({
        "reference.time": [0.0], "reference.omega": [50.0], "load.time": [0.0], "load.T_l": [5.0]})
    assert study.observers["supervised"].gains["S_0"] < 10
    run = simulate(study).sel(observer="supervised", time=slice(20.0, None))
    assert float(np.ptp(run.alpha_hat.values)) < REST * 100 / 120
