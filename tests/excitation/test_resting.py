"""The end values of alpha_hat: predicted from the study, from the motion and from conserved quantities, against runs."""

import math

import numpy as np
import pytest
from synthetic import MACHINE

from imo_analysis.equations.drift import square_integral_of_step
from imo_analysis.equations.repaired import repaired
from imo_analysis.errors import InputError
from imo_analysis.excitation import resting
from imo_analysis.study import Study

GAINS = (300.0, 50.0, 100.0, 1.0, 100.0, 0.05, 0.01)


@pytest.fixture(scope="module")
def paper_run():
    from imo_analysis.simulation.run import simulate

    study = Study.paper().changed({"simulation.record_every": 1})
    return study, simulate(study)


@pytest.mark.slow
def test_the_steps_of_fig_4_are_predicted_before_simulating(paper_run):
    """20 to 40, 40 to 100, 100 to 50 rad/s: each drift within 8 % for the paper's observer, 3 % for the repaired one."""
    study, run = paper_run
    for observer, tolerance in (("consistent_12", 0.08), ("repaired", 0.03)):
        hat = run.alpha_hat.sel(observer=observer)
        steps = resting.predict_steps(study, observer)
        assert [s.drift > 0 for s in steps] == [True] * 3  # the last one is a braking step
        for step, end in zip(steps, (29.9, 44.9, 59.9), strict=True):
            change = float(hat.sel(time=end, method="nearest") - hat.sel(time=step.time - 0.01, method="nearest"))
            assert step.drift == pytest.approx(change, rel=tolerance)


@pytest.mark.slow
def test_the_motion_predicts_the_repaired_observer_to_a_percent(paper_run):
    study, run = paper_run
    data = resting.explain(run, study, "repaired", 10.0)
    late = data.alpha_hat.sel(time=slice(10.0, None)).values
    assert np.abs(late[-1] - data.predicted.values[-1]) < 0.01 * (late[-1] - late[0])
    assert float(data.flux_error[-1]) < 1e-6 < abs(float(data.alpha_hat[-1]) - MACHINE.alpha)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "factor"), [({"observers.repaired.gains.g": 2.0}, 2.0), ({"observers.repaired.gains.K_p": 200.0}, 0.5)])
def test_the_drift_goes_with_g_over_K_p(change, factor):
    from imo_analysis.simulation.run import simulate

    base = {"simulation.duration": 8.0, "reference.time": [0.0, 4.0], "reference.omega": [40.0, 100.0]}
    study = Study.paper().only(["repaired"]).changed({**base, **change})
    hat = simulate(study).alpha_hat.sel(observer="repaired")
    found = float(hat[-1] - hat.sel(time=3.99, method="nearest"))
    predicted = resting.predict_steps(study, "repaired")[0].drift
    plain = resting.predict_steps(Study.paper().only(["repaired"]).changed(base), "repaired")[0].drift
    assert predicted == pytest.approx(factor * plain, rel=1e-12)
    assert found == pytest.approx(predicted, rel=0.05)


@pytest.mark.slow
def test_load_adds_a_term_that_a_way_back_takes_again():
    from imo_analysis.simulation.run import simulate

    study = Study.paper().only(["repaired"]).changed({
        "simulation.duration": 12.0, "reference.time": [0.0, 4.0, 8.0], "reference.omega": [40.0, 70.0, 40.0],
        "load.time": [0.0], "load.T_l": [5.0]})
    hat = simulate(study).alpha_hat.sel(observer="repaired")
    marks = [float(hat.sel(time=t, method="nearest")) for t in (3.99, 7.99, 11.99)]
    up, down = resting.predict_steps(study, "repaired")
    assert marks[1] - marks[0] == pytest.approx(up.drift, rel=0.05)
    assert marks[2] - marks[1] == pytest.approx(down.drift, abs=0.02 * up.drift)  # the small difference of two large terms
    assert 0 < down.drift < 0.1 * up.drift


def integrate(state, omega, slip, duration, step=2e-5):
    """The repaired observer over an exact steady motion, RK4; no other code of the project."""
    beta, alpha, L_m, sigma, R_s = MACHINE.beta, MACHINE.alpha, MACHINE.L_m, MACHINE.sigma, MACHINE.R_s
    p = MACHINE.observer_parameters

    def signals(t):
        phi = 0.5307 * np.exp(1j * (omega + slip) * t)
        i = (1 + 1j * slip / alpha) * phi / L_m
        z = i + beta * phi
        return i, z, sigma * (1j * (omega + slip) * z) + R_s * i

    def rates(t, x):
        i, _, u = signals(t)
        return np.array(repaired(x, (i.real, i.imag), (u.real, u.imag), 1.0, p, GAINS))

    i, z, _ = signals(0.0)
    alpha_hat, omega_hat, xi, zt = state
    x = np.array([i.real, i.imag, z.real - zt[0], z.imag - zt[1], z.real - xi[0], z.imag - xi[1], alpha_hat, omega_hat])
    for k in range(round(duration / step)):
        t = k * step
        a = rates(t, x)
        b = rates(t + step / 2, x + step / 2 * a)
        c = rates(t + step / 2, x + step / 2 * b)
        x = x + step / 6 * (a + 2 * b + 2 * c + rates(t + step, x + step * c))
    _, z, _ = signals(round(duration / step) * step)
    return x[6], x[7], (z.real - x[4], z.imag - x[5]), (z.real - x[2], z.imag - x[3])


@pytest.mark.slow
@pytest.mark.parametrize("slip", [0.0, 3.0])
def test_conserved_quantities_and_the_family_fix_the_end(slip):
    """Disturb the copies and alpha_hat at constant flux and speed: the end is predicted to six digits before integrating."""
    omega, alpha = 40.0, MACHINE.alpha
    start = (8.0, 40.5, (3.0, -2.0), (-1.0, 4.0))
    gains = (GAINS[3], GAINS[4], GAINS[2], GAINS[1])
    rest = resting.predict_rest(*start, omega=omega, slip=slip, alpha=alpha, gains=gains)
    alpha_hat, omega_hat, xi, z = integrate(start, omega, slip, 4.0, step=1e-4)
    assert rest.alpha_hat == pytest.approx(alpha_hat, abs=2e-5)
    assert abs(rest.alpha_hat - start[0]) > 0.01
    assert rest.omega_hat == pytest.approx(omega_hat, abs=1e-4)
    assert [*rest.xi_tilde, *rest.z_tilde] == pytest.approx([*xi, *z], abs=1e-4)


def test_square_integral_of_a_limited_first_order_step():
    bandwidth, step, limit = 45.0, 60.0, 900.0
    t = np.linspace(0, 1, 200_001)
    linear = (step - limit / bandwidth) / limit
    rate = np.where(t < linear, limit, limit * np.exp(-bandwidth * np.clip(t - linear, 0, None)))
    assert np.trapezoid(rate, t) == pytest.approx(step, rel=1e-6)
    assert square_integral_of_step(step, bandwidth, limit) == pytest.approx(np.trapezoid(rate**2, t), rel=1e-6)


@pytest.mark.parametrize(
    ("change", "text"),
    [({"reference.shape": "linear"}, "for speed steps"),
     ({"drive.flux_modulation": 0.02, "drive.flux_modulation_frequency": 20.0}, "constant flux")],
)
def test_where_the_prediction_does_not_apply_it_says_so(change, text):
    with pytest.raises(InputError, match=text):
        resting.predict_steps(Study.paper().changed(change), "repaired")
    with pytest.raises(InputError, match="no gains g and K_p"):
        resting.predict_steps(Study.paper(), "baseline")
    assert math.isfinite(resting.predict_steps(Study.paper(), "repaired")[-1].alpha_hat)


def test_the_drift_moves_with_gains_steps_load_and_drive_as_predicted():
    from imo_analysis.excitation.variations import variations

    found = {one.what: one for one in variations(Study.paper(), "repaired")}
    base = found["40 to 100 rad/s, no load"]
    for one in found.values():
        assert one.simulated == pytest.approx(one.predicted, rel=0.03), one.what
    assert found["g doubled"].simulated == pytest.approx(2 * base.simulated, rel=0.02)
    assert found["K_p doubled"].simulated == pytest.approx(base.simulated / 2, rel=0.02)
    assert found["load of 5 N m"].simulated > base.simulated > found["load of 5 N m, back"].simulated
