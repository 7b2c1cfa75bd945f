"""The designed flux modulation: its predictions against closed-loop runs, and what it refuses."""

import json
import math

import numpy as np
import pytest
from synthetic import MACHINE

from imo_analysis.cli import main
from imo_analysis.errors import InputError
from imo_analysis.excitation import design as d
from imo_analysis.study import Study

GAINS = {"k_1": 300.0, "kappa": 50.0, "k_3": 100.0, "g": 1.0, "K_p": 100.0}
WANTED = d.Wanted(0.3, 2.0, 5.0, 3.3, (20.0, 100.0), (0.0, 5.0), 0.1)


def test_the_design_is_the_smallest_that_reaches():
    best, every = d.design(MACHINE, GAINS, 0.5307, WANTED, squares_noise=True)
    assert d.reaches(best, WANTED) and best.loss == min(one.loss for one in every)
    smaller = d.assess(MACHINE, GAINS, 0.5307, 0.99 * best.depth, best.frequency, WANTED, True)
    assert not d.reaches(smaller, WANTED)


def test_a_law_without_the_square_of_the_noise_needs_less():
    with_square, _ = d.design(MACHINE, GAINS, 0.5307, WANTED, squares_noise=True)
    without, _ = d.design(MACHINE, GAINS, 0.5307, WANTED, squares_noise=False)
    assert without.depth < with_square.depth and without.loss < with_square.loss and without.bias == 0


def test_impossible_wishes_are_said():
    with pytest.raises(InputError, match="no depth up to"):
        d.design(MACHINE, GAINS, 0.5307, d.Wanted(1e-6, 2, 0.1, 3.3, (20.0,), (0.0,), 0.1), squares_noise=False)
    with pytest.raises(InputError, match="limits of current and voltage"):
        tight = d.Wanted(0.3, 2, 5.0, 3.3, (20.0,), (0.0,), 0.1, current_limit=8.9)
        d.design(MACHINE, GAINS, 0.5307, tight, squares_noise=False)


def test_costs_by_hand_at_standstill_of_the_modulation():
    """No modulation costs nothing, and the peaks are those of the steady state."""
    current, voltage, loss = d.costs(MACHINE, 0.5307, 0.0, 30.0, 50.0, 0.0)
    i = 0.5307 / MACHINE.L_m
    u = abs(MACHINE.R_s * i + 1j * 50.0 * MACHINE.sigma * (i + MACHINE.beta * 0.5307))
    assert (current, voltage, loss) == pytest.approx((i, u, 0.0), rel=1e-9, abs=1e-9)


def test_modulation_loss_grows_with_the_square_of_the_depth():
    one, two = (d.costs(MACHINE, 0.5307, depth, 30.0, 50.0, 0.0)[2] for depth in (0.01, 0.02))
    assert two == pytest.approx(4 * one, rel=1e-3)


@pytest.mark.slow
def test_the_settling_rate_and_the_rest_of_the_noise_in_closed_loop():
    """Averaged rate within 15 %, the offset that the noise leaves within 10 %."""
    from imo_analysis.simulation.run import simulate

    study = Study.paper().only(["repaired"])
    found = d.assess(MACHINE, GAINS, 0.5307, 0.0158, 136.3, WANTED, True)
    quietly = d.modulated_study(study, found).changed({
        "reference.time": [0.0], "reference.omega": [50.0], "simulation.duration": 6.0, "drive.speed_bandwidth": 20.0})
    error = simulate(quietly).alpha_hat.sel(observer="repaired") - MACHINE.alpha
    early, late = (float(error.sel(time=slice(t, t + 0.5)).mean()) for t in (1.0, 2.5))
    rate = d.settling_rate(MACHINE, GAINS, 0.5307, 0.0158, 136.3, 50.0)
    assert math.log(early / late) / 1.5 == pytest.approx(rate, rel=0.15)
    noisy = simulate(quietly.changed({"sensors.current_noise": 0.1, "simulation.duration": 24.0}))  # 20 s: 26 time constants
    rest = float((noisy.alpha_hat.sel(observer="repaired", time=slice(4, None)) - MACHINE.alpha).mean())
    bias = -2 * (1 + MACHINE.beta * MACHINE.L_m) * 0.01 / rate
    assert rest == pytest.approx(bias, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.05, 0.1])
def test_noise_drives_alpha_hat_down_as_the_claim_says(noise):
    """Constant flux: -2 g (1 + beta L_m) sigma^2 within 5 %; the quiet observer drifts at most a fifth of that."""
    from imo_analysis.simulation.run import simulate

    base = Study.paper().only(["repaired"])
    settings = base.data["observers"]["repaired"]
    data = {k: v for k, v in base.data.items() if k != "scenarios"} | {
        "observers": {"repaired": settings, "quiet": {**settings, "kind": "quiet"}}}
    study = Study.from_data(data).changed({"sensors.current_noise": noise, "simulation.duration": 13.0})
    hat = simulate(study).alpha_hat
    slope = {name: float(np.polyfit(late.time, late, 1)[0])
             for name in ("repaired", "quiet") for late in [hat.sel(observer=name, time=slice(3, None))]}
    claimed = -2 * (1 + MACHINE.beta * MACHINE.L_m) * noise**2
    assert slope["repaired"] == pytest.approx(claimed, rel=0.05)
    assert abs(slope["quiet"]) < 0.2 * abs(claimed)


def test_waveforms_are_their_lines():
    """The Fourier lines against a discrete transform of the waveform, the way the simulation samples it."""
    from imo_analysis.simulation.waveforms import WAVES, lines

    points = 1 << 14
    angle = 2 * np.pi * (np.arange(points) + 0.5) / points  # between the square's edges
    for name, wave in WAVES.items():
        values = np.asarray(wave(angle), dtype=float)
        assert np.abs(values).max() == pytest.approx(1, abs=1e-3) and abs(values.mean()) < 1e-12
        orders, amplitudes = lines(name)
        found = np.fft.fft(values)[orders] / points * np.exp(-1j * np.pi * orders / points)
        assert np.allclose(found, amplitudes, rtol=0, atol=2e-4), name


def test_a_sine_by_the_drive_costs_what_a_cosine_does():
    """The phase of the flux cannot matter, and the reference is larger than the flux by the lag of the loops."""
    drive = Study.paper().drive
    shape = d.shape_of("sine", 136.3, drive, MACHINE.alpha)
    by_drive = d.assess(MACHINE, GAINS, 0.5307, 0.0158, 136.3, WANTED, True, shape)
    alone = d.assess(MACHINE, GAINS, 0.5307, 0.0158, 136.3, WANTED, True)
    for name in ("rate", "bias", "alpha_bound", "omega_bound", "current", "voltage", "loss"):
        assert getattr(by_drive, name) == pytest.approx(getattr(alone, name), rel=2e-3), name
    assert shape.reference == pytest.approx(math.hypot(1, 136.3 / drive.flux_bandwidth), rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("waveform", ["triangle", "square", "two_tone"])
def test_the_flux_follows_a_waveform_as_predicted(waveform):
    """Peak of the flux swing, loss and rate of a waveform in closed loop, under load."""
    study = Study.paper().only(["repaired"])
    found = d.assess(MACHINE, GAINS, 0.5307, 0.02, 60.0, WANTED, True,
                     d.shape_of(waveform, 60.0, study.drive, MACHINE.alpha), waveform)
    from imo_analysis.simulation.run import simulate

    run = simulate(d.modulated_study(study, found).changed({
        "reference.time": [0.0], "reference.omega": [50.0], "load.T_l": [5.0], "simulation.duration": 4.0}))
    late = run.sel(time=slice(3, 3 + 9 * 2 * math.pi / 60))
    psi = np.hypot(late.phi_dr, late.phi_qr)
    assert float(psi.max() - psi.min()) / 2 == pytest.approx(0.02 * 0.5307, rel=0.03)
    quiet_wanted = d.Wanted(0.3, 2.0, 5.0, 3.3, (50.0,), (5.0,), 1e-9)
    check = d.verify(study, found, quiet_wanted, "repaired")[0]
    assert check.loss == pytest.approx(found.loss, rel=0.03)


@pytest.mark.slow
def test_a_reference_that_would_pass_zero_is_no_design():
    """Gains for the paper's machine, on one with seven times the inductance: only a reference below zero would do."""
    own = {"n_p": 2, "R_s": 7.5, "R_r": 5.6, "L_m": 0.42, "L_s": 0.445, "L_r": 0.445, "J": 0.003}
    study = Study.from_data({**Study.paper().data, "machine": own})
    gains = study.observers["repaired"].gains
    wanted = d.Wanted(0.3, 2.0, 5.0, abs(6.6 - study.machine.alpha), (30.0, 60.0, 100.0), (0.0, 5.0), 0.1)
    fast = d.shape_of("sine", 200.0, study.drive, study.machine.alpha)
    alone = d._accuracy(study.machine, gains, study.drive.flux, wanted.depth_limit, 200.0, wanted, True, fast)
    assert d.reaches(alone, wanted) and wanted.depth_limit * fast.reference > 1
    with pytest.raises(InputError, match="with a reference above 0 does"):
        d.design(study.machine, gains, study.drive.flux, wanted, squares_noise=True, frequencies=(60.0, 200.0),
                 drive=study.drive)


def test_command(capsys):
    assert main(["excite", "--design", "paper", "--json", "-"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["schema"] == "imo-excitation-design/1" and data["reached"] and data["observer"] == "repaired"
    assert 0.005 < data["design"]["depth"] < 0.05
    assert {one["waveform"] for one in data["waveforms"]} == {"sine", "triangle", "square", "two_tone"}
    assert data["design"]["loss"] == min(one["loss"] for one in data["waveforms"])
    for one in data["closed_loop"]:
        assert one["loss"] == pytest.approx(data["design"]["loss"], rel=0.05) and abs(one["alpha_error"]) < 0.3


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["x.nc", "--design", "paper"], "exclude each other"),
        (["--design", "paper", "--speeds", "a"], "must be numbers"),
        (["--design", "paper", "--within", "0"], "must be above 0"),
        (["--design", "paper", "--observer", "baseline"], "must be one observer"),
        (["--design", "none.toml"], "cannot read"),
        ([], "a run file is needed"),
    ],
)
def test_bad_input(words, text, capsys):
    assert main(["excite", *words]) == 2
    error = capsys.readouterr().err
    assert text in error and error.count("\n") == 1
