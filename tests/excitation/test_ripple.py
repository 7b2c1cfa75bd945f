"""Torque ripple of a flux modulation: closed form against the small-signal formula and against runs without noise."""

import math

import numpy as np
import pytest
from synthetic import MACHINE

from imo_analysis.excitation.ripple import held_voltage, loaded_torque, torque_ripple
from imo_analysis.excitation.swing import shape_of
from imo_analysis.study import Study

DRIVE = Study.paper().drive


def test_a_small_swing_is_the_small_signal_formula():
    """The textbook transfer, and a second harmonic that grows with the square of the depth."""
    shape, w = shape_of("sine", 60.0, DRIVE, MACHINE.alpha), 60.0
    C = DRIVE.current_bandwidth / (1j * w + DRIVE.current_bandwidth)
    A = -DRIVE.speed_bandwidth * (2j * w + DRIVE.speed_bandwidth) / (1j * w) ** 2
    small, deep = (np.abs(np.fft.rfft(loaded_torque(DRIVE, shape, depth, w)))[[1, 2]] / 16 for depth in (0.001, 0.1))
    assert small[0] / 0.001 == pytest.approx(abs((1 - C) / (1 - C * A)), rel=1e-3)
    assert deep[1] / small[1] == pytest.approx(1e4, rel=0.05)


def test_the_mean_is_the_load_and_a_fast_current_loop_leaves_no_ripple():
    shape = shape_of("square", 60.0, DRIVE, MACHINE.alpha)
    torque = loaded_torque(DRIVE, shape, 0.05, 60.0)
    assert torque.mean() == pytest.approx(1.0, abs=1e-12) and np.ptp(torque) > 1e-3
    fast = DRIVE.model_copy(update={"current_bandwidth": 1e9})
    assert np.ptp(loaded_torque(fast, shape, 0.05, 60.0)) < 1e-5 * np.ptp(torque)


def test_no_load_no_turning_no_ripple():
    shape = shape_of("sine", 60.0, DRIVE, MACHINE.alpha)
    assert torque_ripple(MACHINE, DRIVE, 0.5307, shape, 0.05, 60.0, [(0.0, 0.0)]) == 0
    one, two = (np.ptp(held_voltage(MACHINE, DRIVE, 0.5307, shape, 0.05, 60.0, 50.0, step)) for step in (1e-4, 2e-4))
    assert two == pytest.approx(2 * one)


@pytest.mark.slow
@pytest.mark.parametrize(("waveform", "frequency", "depth", "omega", "torque", "low", "high"), [
    ("sine", 136.3, 0.0158, 50.0, 0.0, 0.9, 1.05), ("sine", 136.3, 0.0158, 100.0, 0.0, 0.9, 1.15),
    ("sine", 136.3, 0.0158, 50.0, 5.0, 0.85, 1.0), ("sine", 30.0, 0.1, 50.0, 5.0, 0.85, 1.0),
    ("square", 60.0, 0.05, 20.0, 5.0, 0.7, 1.0)])
def test_against_a_run_without_noise(waveform, frequency, depth, omega, torque, low, high):
    """Simulated over predicted: the prediction adds its two parts as if in phase, so that it lies above where both are."""
    from imo_analysis.simulation.run import simulate

    shape = shape_of(waveform, frequency, DRIVE, MACHINE.alpha)
    run = simulate(Study.paper().only(["repaired"]).changed({
        "drive.flux_modulation": depth * DRIVE.flux * shape.reference, "drive.flux_modulation_frequency": frequency,
        "drive.flux_waveform": waveform, "reference.time": [0.0], "reference.omega": [omega], "load.T_l": [torque],
        "simulation.duration": 4.0}))
    late = run.torque.sel(time=slice(4 - 2 * math.pi / frequency, None))
    predicted = torque_ripple(MACHINE, DRIVE, DRIVE.flux, shape, depth, frequency, [(omega, torque)])
    assert low < float(np.ptp(late.values)) / 2 / predicted < high
