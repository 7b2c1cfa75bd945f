"""Closed forms against simulated Gram matrices, and the Cramer-Rao bound against integrated sensitivities."""

import math

import numpy as np
import pytest
from synthetic import MACHINE, motion

from imo_analysis.equations import steady_state
from imo_analysis.equations.plant import plant_z
from imo_analysis.excitation import bounds, signals
from imo_analysis.excitation.conditions import CONDITIONS


def mean_gram(run):
    """The mean 4x4 matrix of a run by direct sums."""
    source = signals.select(signals.of_dataset(run, MACHINE), "plant")
    rows = CONDITIONS["reduced"].of(source.block(slice(0, source.samples)), MACHINE)
    dense = np.array([[np.broadcast_to(v, (source.samples,)) for v in row] for row in rows], dtype=float)
    return np.einsum("rit,rjt->ij", dense, dense) / source.samples


@pytest.mark.parametrize(
    ("depth", "frequency", "slip"), [(0.0, 20.0, 3.0), (0.05, 20.0, 3.0), (0.2, 40.0, 0.0), (0.1, 8.0, -5.0)])
def test_modulated_flux_at_constant_slip(depth, frequency, slip):
    """2 pi seconds hold whole periods of every line, so that the rectangle rule is exact to rounding."""
    run = motion(duration=2 * math.pi, step=2 * math.pi / 40_000, modulation=depth, frequency=frequency, omega=90.0, slip=slip)
    closed = steady_state.gram_constant_slip(0.5307, depth, frequency, slip, MACHINE.alpha, MACHINE.beta)
    found = mean_gram(run)
    assert [found[2, 2], found[2, 3], found[3, 3]] == pytest.approx(closed, rel=1e-10, abs=1e-9 * closed[2])
    assert np.abs(found[:2, 2:]).max() < 1e-9 * math.sqrt(closed[2])


def test_held_torque():
    psi, depth, frequency, slip, beta, alpha = 0.5, 0.3, 15.0, 4.0, MACHINE.beta, MACHINE.alpha
    t = np.arange(4096) * 2 * math.pi / frequency / 4096
    magnitude, rate = psi * (1 + depth * np.cos(frequency * t)), -psi * depth * frequency * np.sin(frequency * t)
    v_1, v_2 = steady_state.regressors_of_flux(magnitude, rate, slip * psi**2 / magnitude**2, alpha, beta)
    direct = [np.mean(v_1[0] ** 2 + v_1[1] ** 2), np.mean(v_1[1] * v_2[1]), np.mean(v_2[1] ** 2)]
    closed = steady_state.gram_constant_torque(psi, depth, math.sqrt(1 - depth**2), frequency, slip, alpha, beta)
    assert direct == pytest.approx(closed, rel=1e-12)
    assert steady_state.determinant(closed) > 0
    still = steady_state.gram_constant_torque(psi, depth, math.sqrt(1 - depth**2), 0.0, slip, alpha, beta)
    assert steady_state.determinant(still) > 0  # the slip's own swing is enough, however slow


def integrated_information(depth, frequency, omega, slip, unknown, duration=4.0, step=2e-5):
    """Fisher information per second by running (6) at parameters to both sides of the true ones: no transfer function."""
    alpha, R_s, sigma, beta, L_m = MACHINE.alpha, MACHINE.R_s, MACHINE.sigma, MACHINE.beta, MACHINE.L_m
    n = round(duration / step)
    t = np.arange(2 * n + 1) * step / 2
    stator = omega + slip
    magnitude = 0.5307 * (1 + depth * np.cos(frequency * t))
    rate = -0.5307 * depth * frequency * np.sin(frequency * t)
    turn = np.exp(1j * stator * t)
    phi, dphi = magnitude * turn, (rate + 1j * stator * magnitude) * turn
    second = (-0.5307 * depth * frequency**2 * np.cos(frequency * t) + 2j * stator * rate - stator**2 * magnitude) * turn
    i = (dphi + (alpha - 1j * omega) * phi) / (alpha * L_m)
    di = (second + (alpha - 1j * omega) * dphi) / (alpha * L_m)
    u = sigma * (di + beta * dphi) + R_s * i  # from z' = -R_s/sigma i + u/sigma
    h = 1e-6

    def run(values):
        x = np.array([i[0].real, i[0].imag, i[0].real + beta * phi[0].real, i[0].imag + beta * phi[0].imag])
        p = (values.get("R_s", R_s), L_m, sigma, beta, values.get("alpha", alpha))
        w = values.get("omega", omega)
        out = np.empty((n, 2))

        def f(x, k):
            return np.array(plant_z(tuple(x), (u[k].real, u[k].imag), w, 0.0, p))

        for k in range(n):
            out[k] = x[:2]
            k1 = f(x, 2 * k)
            k2 = f(x + step / 2 * k1, 2 * k + 1)
            k3 = f(x + step / 2 * k2, 2 * k + 1)
            k4 = f(x + step * k3, 2 * k + 2)
            x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return out

    nominal = {"alpha": alpha, "omega": omega, "R_s": R_s}
    slopes = []
    for name in unknown:
        delta = h * max(1.0, abs(nominal[name]))
        slopes.append((run({name: nominal[name] + delta}) - run({name: nominal[name] - delta})) / (2 * delta))
    late = slice(n // 2, None)  # transients of the machine are gone
    flat = np.array([s[late].ravel() for s in slopes])
    return flat @ flat.T / (n - n // 2)


@pytest.mark.slow
@pytest.mark.parametrize(("depth", "frequency", "omega", "slip"), [(0.1, 4 * math.pi, 6 * math.pi, 2 * math.pi)])
def test_information_against_integrated_sensitivities(depth, frequency, omega, slip):
    unknown = ("alpha", "omega", "R_s")
    found = integrated_information(depth, frequency, omega, slip, unknown, duration=4.0, step=2e-4)
    closed = bounds.information(MACHINE, bounds.modulated(0.5307, omega, slip, depth, frequency),
                                bounds.Measurement(1.0, 1.0, 1.0), unknown)
    scale = np.sqrt(np.diag(closed))
    np.testing.assert_allclose(found / np.outer(scale, scale), closed / np.outer(scale, scale), atol=2e-3)


def test_what_is_identifiable_where():
    m = bounds.Measurement()
    constant = bounds.modulated(0.5307, 100.0, 3.0)
    assert bounds.deviations(MACHINE, constant, m) == {"alpha": math.inf, "omega": math.inf}
    assert bounds.deviations(MACHINE, constant, m, ["omega"])["omega"] < 0.1
    assert bounds.deviations(MACHINE, constant, m, ["alpha"])["alpha"] < 0.1
    idle = bounds.modulated(0.5307, 100.0, 0.0)
    both = bounds.deviations(MACHINE, idle, m)
    assert both["alpha"] == math.inf and both["omega"] < 0.1
    stopped = bounds.modulated(0.5307, -3.0, 3.0)
    assert bounds.deviations(MACHINE, stopped, m) == {"alpha": math.inf, "omega": math.inf}
    assert bounds.deviations(MACHINE, stopped, m, ["omega"])["omega"] == math.inf
    good = bounds.deviations(MACHINE, bounds.modulated(0.5307, 100.0, 3.0, 0.05, 20.0), m)
    assert max(good.values()) < 1.0
    slow = bounds.deviations(MACHINE, bounds.held_torque(0.5307, 100.0, 3.0, 0.05, 0.5), m)
    assert max(slow.values()) < 10.0


def test_held_torque_lines_have_the_torque_and_the_power_they_should():
    made = bounds.held_torque(0.5, 80.0, 4.0, 0.2, 20.0)
    t = np.linspace(0, 0.5, 4001)
    phi = (made.amplitudes[:, None] * np.exp(1j * made.frequencies[:, None] * t)).sum(axis=0)
    dphi = (1j * made.frequencies[:, None] * made.amplitudes[:, None] * np.exp(1j * made.frequencies[:, None] * t)).sum(axis=0)
    assert np.abs(phi) == pytest.approx(0.5 * (1 + 0.2 * np.cos(20 * t)), rel=1e-9)
    slip = (dphi / phi).imag - 80.0
    assert slip * np.abs(phi) ** 2 == pytest.approx(np.full(len(t), 4.0 * 0.25), rel=1e-8)


def test_twice_the_noise_is_twice_the_deviation_and_four_times_the_time_half():
    motion_ = bounds.modulated(0.5307, 60.0, 3.0, 0.05, 20.0)
    one = bounds.deviations(MACHINE, motion_, bounds.Measurement(0.1, 1e4, 1.0))
    loud = bounds.deviations(MACHINE, motion_, bounds.Measurement(0.2, 1e4, 1.0))
    long = bounds.deviations(MACHINE, motion_, bounds.Measurement(0.1, 1e4, 4.0))
    for name in one:
        assert loud[name] == pytest.approx(2 * one[name], rel=1e-9) and long[name] == pytest.approx(one[name] / 2, rel=1e-9)


def test_what_a_window_of_constant_flux_tells_of_the_speed():
    """Schur complement of the simulated 4x4 Gram integral against its closed form, down to slow stator frequencies."""
    for stator, duration in ((100.0, 0.05), (10.0, 0.2), (2.0, 0.1)):
        run = motion(duration=duration, step=duration / 20_000, omega=stator, slip=0.0)
        gram = mean_gram(run) * duration
        schur = gram[3, 3] - gram[3, :2] @ np.linalg.solve(gram[:2, :2], gram[:2, 3])
        closed = steady_state.speed_information(0.5307, MACHINE.beta, stator, duration, math.cos(stator * duration))
        assert schur == pytest.approx(closed, rel=1e-3)


def test_many_speeds_at_once_are_the_same_bounds():
    m = bounds.Measurement()
    speeds = np.array([-60.0, -3.0, 0.0, 40.0])
    for slip, depth in ((3.0, 0.05), (0.0, 0.05), (3.0, 0.0), (0.0, 0.0)):
        many = bounds.bounds_over_speed(MACHINE, bounds.held_torque(0.5307, 0.0, slip, depth, 20.0), speeds, m)
        for k, omega in enumerate(speeds):
            motion_ = bounds.held_torque(0.5307, omega, slip, depth, 20.0)
            one = bounds.deviations(MACHINE, motion_, m)
            assert [many["alpha_both"][k], many["omega_both"][k]] == pytest.approx([one["alpha"], one["omega"]], rel=1e-6)
            for name in ("alpha", "omega"):
                assert many[f"{name}_alone"][k] == pytest.approx(bounds.deviations(MACHINE, motion_, m, [name])[name], rel=1e-9)


def test_maps_name_what_can_be_identified():
    from imo_analysis.excitation.maps import CLASSES, modulation_map, speed_torque_map

    slip = bounds.slip_at(MACHINE, 5.0, 0.5307)
    plane = speed_torque_map(MACHINE, [-slip, 50.0], [0.0, 5.0])
    kinds = [[CLASSES[int(k)] for k in row] for row in plane.kind.values]
    assert kinds == [["omega only", "neither"], ["omega only", "either, not both"]]
    assert (speed_torque_map(MACHINE, [-slip, 50.0], [0.0, 5.0], depth=0.05, frequency=30.0).kind.values == 4).all()
    swing = modulation_map(MACHINE, [0.01, 0.1], [1.0, 30.0])
    assert swing.alpha_both.values[0, 1] == pytest.approx(10 * swing.alpha_both.values[1, 1], rel=0.05)


def test_the_line_of_zero_stator_frequency():
    """A motion with the torque that the line asks for: its flux stands, and a window of it tells nothing of omega or alpha."""
    omega = 10.0
    torque = steady_state.torque_at_zero_frequency(omega, 0.5307, MACHINE.n_p, MACHINE.R_r)
    slip = bounds.slip_at(MACHINE, torque, 0.5307)
    assert slip == pytest.approx(-omega, rel=1e-12)
    run = motion(duration=1.0, omega=omega, slip=slip)
    assert float(np.ptp(run.phi_dr.values)) < 1e-9
    assert np.linalg.matrix_rank(mean_gram(run), tol=1e-9 * mean_gram(run).max()) == 2
    pulling = 1.5 * MACHINE.n_p * MACHINE.L_m / MACHINE.L_r * (run.phi_dr * run.i_qs - run.phi_qr * run.i_ds)
    assert float(pulling.mean()) == pytest.approx(torque, rel=1e-9)


@pytest.mark.slow
def test_a_held_torque_in_closed_loop():
    """The Gram matrix of a simulated drive under load, its flux modulated, against the closed form, within 2 %."""
    from imo_analysis.excitation.swing import shape_of
    from imo_analysis.simulation.run import simulate
    from imo_analysis.study import Study

    depth, frequency = 0.05, 60.0
    study = Study.paper().only(["repaired"])
    reference = shape_of("sine", frequency, study.drive, MACHINE.alpha).reference
    run = simulate(study.changed({
        "drive.flux_modulation": depth * 0.5307 * reference, "drive.flux_modulation_frequency": frequency,
        "reference.time": [0.0], "reference.omega": [50.0], "load.T_l": [5.0], "simulation.duration": 4.0,
        "simulation.record_every": 1}))
    found = mean_gram(run.sel(time=slice(2.0, 2.0 + 10 * 2 * math.pi / frequency)))
    slip = bounds.slip_at(MACHINE, 5.0, 0.5307)
    root = math.sqrt(1 - depth**2)
    closed = steady_state.gram_constant_torque(0.5307, depth, root, frequency, slip, MACHINE.alpha, MACHINE.beta)
    assert [found[2, 2], found[2, 3], found[3, 3]] == pytest.approx(closed, rel=0.02)
