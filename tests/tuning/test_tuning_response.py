"""What the modes say of the speed estimate against routes without modes: Lyapunov's equation, stepping in time, simulation."""

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov

from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.study import Study
from imo_analysis.tuning import trial
from imo_analysis.tuning.response import linearisation, response
from imo_analysis.tuning.rule import rule_gains
from imo_analysis.tuning.wish import Wish, judge

STUDY = Study.paper()
MACHINE, FLUX = STUDY.machine, STUDY.drive.flux
WISH = Wish.of(STUDY)
CASES = [("repaired", 60.0, 5.0), ("repaired", -140.0, 7.0), ("consistent_12", 35.0, -4.0), ("quiet", 90.0, 0.0),
         ("baseline", 50.0, 5.0), ("baseline", -120.0, 0.0), ("supervised", 30.0, 6.0)]


def _gains(kind):
    return rule_gains(MACHINE, kind, FLUX, WISH.times)


def _gramian(A, B):
    """Integral of exp(A t) B B^T exp(A^T t) up to 5.2 s: Van Loan's exponential for 10 us, then doubled 19 times."""
    n, step = len(A), 1e-5
    whole = expm(np.block([[-A, B @ B.T], [np.zeros((n, n)), A.T]]) * step)
    forward = whole[n:, n:].T
    square = forward @ whole[:n, n:]
    for _ in range(19):
        square, forward = square + forward @ square @ forward.T, forward @ forward
    return square


@pytest.mark.parametrize(("kind", "omega", "slip"), CASES)
@pytest.mark.parametrize("errors", [None, {"R_s": 0.05, "R_r": -0.2}])
def test_against_stepping_in_time(kind, omega, slip, errors):
    """The answer to an error of the speed by steps of 40 us, to noise by doubling Gramians up to 5 s: no modes anywhere."""
    point = OperatingPoint(np.array(omega), FLUX, np.array(slip))
    found = response(MACHINE, kind, _gains(kind), point, errors)
    A, B, bias = linearisation(MACHINE, kind, _gains(kind), point, errors)
    step, count = 4e-5, 100_000
    one = expm(A * step)
    x = np.eye(len(A))[-1]
    answer = np.empty(count)
    for k in range(count):
        answer[k] = x[-1]
        x = one @ x
    # the offsets of z_hat and xi_hat never decay; with wrong parameters the currents show them faintly: see the module
    tolerance = 0.02 if errors and kind != "baseline" else 2e-3
    outside = np.flatnonzero(np.abs(answer) > 0.02)
    assert found.settling == pytest.approx((outside[-1] + 1) * step, rel=0.04)
    assert found.overshoot == pytest.approx(max(-answer.min(), 0.0), abs=2e-3)
    assert found.lag == pytest.approx(answer.sum() * step - answer[0] * step / 2, rel=tolerance, abs=2e-5)
    assert found.noise == pytest.approx(np.sqrt(_gramian(A, B)[-1, -1]), rel=tolerance)
    assert found.bias == pytest.approx(float(bias))


@pytest.mark.parametrize("omega", [25.0, -90.0, 150.0])
def test_noise_of_the_baseline_by_lyapunovs_equation(omega):
    gains = _gains("baseline")
    point = OperatingPoint(np.array(omega), FLUX, np.array(3.0))
    A, B, _ = linearisation(MACHINE, "baseline", gains, point)
    variance = solve_continuous_lyapunov(A, -B @ B.T)[-1, -1]
    assert response(MACHINE, "baseline", gains, point).noise == pytest.approx(np.sqrt(variance), rel=1e-9)
    poles = np.linalg.eigvals(A)
    assert response(MACHINE, "baseline", gains, point).recovery == pytest.approx(4 / -poles.real.max(), rel=1e-9)


@pytest.mark.parametrize("name", ["repaired", "baseline"])
def test_noise_and_settling_in_simulation(name):
    """The whole nonlinear loop: variance over two seconds, and the time until an estimate 1 rad/s off is within 2 %."""
    omega = np.array([-140.0, -25.0, 30.0, 77.0, 130.0])
    for gains in (STUDY.observers[name].gains, _gains(name)):
        found = response(MACHINE, name, gains, OperatingPoint(omega, FLUX, 0.0 * omega))
        assert trial.noise(STUDY, name, gains, WISH, omega, 5) == pytest.approx(found.noise * WISH.noise_scale, rel=0.12)
        measured, predicted = trial.settling(STUDY, name, gains, WISH, omega), found.settling
        # a tail of just 2 % is in or out: compare where it is not
        clear = np.abs(np.log(measured / predicted)) < 1
        assert clear.sum() >= 3
        assert measured[clear] == pytest.approx(predicted[clear], rel=0.06)


def test_what_is_driven(monkeypatch):
    """The choice: the right machine and the corners. The verification: machines, speeds and loads drawn anew, with noise."""
    seen = {}

    def recorded(study, values, **words):
        seen.update(values, seed=study.simulation.seed, noise=study.sensors.current_noise)
        raise InterruptedError

    monkeypatch.setattr(trial, "run_batch", recorded)
    gains, right = [_gains("repaired")], {"R_s": MACHINE.R_s, "R_r": MACHINE.R_r}
    for runs, seed in ((0, 1), (40, 5), (40, 6)):
        with pytest.raises(InterruptedError):
            trial.drive(STUDY, "repaired", gains, WISH, (1.0, -1.0), seed, runs)
        assert seen["noise"] == WISH.current_noise > 0 and seen["seed"] == seed
        off = np.array([[seen[f"machine.{key}"][k] / right[key] - 1 for k in range(runs or 5)] for key in right])
        speeds = np.concatenate([seen[f"reference.omega.{k}"] for k in range(8)])
        assert speeds.min() < -100 and speeds.max() > 100 and np.abs(speeds).min() >= 20 and np.abs(speeds).max() <= 150
        if runs:
            assert (np.abs(off) <= [[0.05], [0.2]]).all() and np.ptp(off, axis=1) == pytest.approx([0.1, 0.4], rel=0.2)
            seen.setdefault("drawn", []).append(off)
        else:
            assert np.allclose(np.abs(off[:, 1:]), [[0.05] * 4, [0.2] * 4]) and np.allclose(off[:, 0], 0)
    assert not np.isclose(*seen["drawn"]).any()


def test_quick_states_at_rest_are_the_followed_ones():
    point, errors = WISH.points(3, 3, (1.0, -1.0)), {"R_s": 0.05, "R_r": 0.2}
    for kind in ("repaired", "consistent_12", "supervised"):
        slow, quick = (response(MACHINE, kind, _gains(kind), point, errors, quick=q) for q in (False, True))
        there = np.isfinite(slow.noise)
        assert there.sum() >= len(there) / 2
        for name in ("bias", "noise", "recovery", "lag"):
            assert getattr(quick, name)[there] == pytest.approx(getattr(slow, name)[there], rel=1e-6)


def test_unstable_is_infinite():
    """The paper's (11) with its Sign at negative speed, and the baseline braking at low speed."""
    assert np.isinf(judge(WISH, "consistent_12", STUDY.observers["consistent_12"].gains, (-1.0,))["noise"])
    assert np.isinf(judge(WISH, "baseline", STUDY.observers["baseline"].gains)["settling"])
    values = judge(WISH, "repaired", STUDY.observers["repaired"].gains)
    assert all(np.isfinite(value) for value in values.values())


def test_judgement_covers_both_directions_and_the_corners():
    """Both directions alike for the repaired observer; corners can only make it worse."""
    gains = STUDY.observers["repaired"].gains
    forward, backward = (judge(WISH, "repaired", gains, (sign,)) for sign in (1.0, -1.0))
    one_way = _gains("consistent_12")  # stable forward alone
    assert np.isfinite(judge(WISH, "consistent_12", one_way, (1.0,))["noise"])
    assert np.isinf(judge(WISH, "consistent_12", one_way)["noise"])
    assert forward == pytest.approx(backward, rel=1e-6)
    alone = Wish.of(STUDY.changed({"tuning.uncertainty": {"R_s": 0.0, "R_r": 0.0}}))
    assert alone.corners() == []
    plain = judge(alone, "repaired", gains)
    assert all(plain[name] <= forward[name] * (1 + 1e-12) for name in plain)
    assert plain["bias"] == 0.0 < forward["bias"]
