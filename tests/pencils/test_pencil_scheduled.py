"""Kubota's scheduled gain by a second route: matrices as the literature writes them, typed here, and 50-digit arithmetic."""

from __future__ import annotations

import json
from typing import Any

import mpmath
import numpy as np
import pytest

from imo_analysis.cli import main
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine, preset
from imo_analysis.pencils.error import OperatingPoint, frozen_matrix, full_matrix, poles, poles_at
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study, paper_text
from imo_analysis.sweeps.batch import run_batch

MACHINE = preset("table-iii-printed-alpha")
NAME = "baseline_scheduled"
FLUX = 0.5307


def textbook(m: InductionMachine, k: Any, omega: Any, number: Any = float) -> tuple[list[list[Any]], list[list[Any]]]:
    """A of Kubota's (1) and A + G C with the gain that multiplies i_hat - i, from resistances and inductances alone."""
    R_s, R_r, L_s, L_m, L_r = (number(value) for value in (m.R_s, m.R_r, m.L_s, m.L_m, m.L_r))
    leak, tau_r = 1 - L_m**2 / (L_s * L_r), L_r / R_r
    a_r11 = -(R_s / (leak * L_s) + (1 - leak) / (leak * tau_r))
    a_r12, a_i12 = L_m / (leak * L_s * L_r) / tau_r, -L_m / (leak * L_s * L_r) * omega
    a_r21, a_r22, a_i22 = L_m / tau_r, -1 / tau_r, omega
    c = leak * L_s * L_r / L_m
    g_1, g_2 = (k - 1) * (a_r11 + a_r22), (k - 1) * a_i22
    g_3, g_4 = (k**2 - 1) * (c * a_r11 + a_r21) - c * (k - 1) * (a_r11 + a_r22), -c * (k - 1) * a_i22
    A = [[a_r11, 0, a_r12, -a_i12], [0, a_r11, a_i12, a_r12], [a_r21, 0, a_r22, -a_i22], [0, a_r21, a_i22, a_r22]]
    G = [[g_1, -g_2], [g_2, g_1], [g_3, -g_4], [g_4, g_3]]
    return A, [[A[r][n] + (G[r][n] if n < 2 else 0) for n in range(4)] for r in range(4)]


def edge(m: InductionMachine, k: float) -> float:
    """Stator frequency over speed at the edge of the unstable region."""
    return k * (m.R_s / m.sigma) / (m.gamma + m.alpha)


def loop(k: float, h: float, omega: Any, slip: Any, m: InductionMachine = MACHINE) -> np.ndarray:
    return poles_at(m, NAME, {"k": k, "h": h}, OperatingPoint(omega, FLUX, slip), "full")


@pytest.mark.parametrize("omega", [-150.0, -7.0, 0.0, 20.0, 314.0])
@pytest.mark.parametrize("k", [1.0, 1.485, 4.0])
def test_the_matrix_is_that_of_the_literature(k: float, omega: float) -> None:
    m = preset("table-iii")
    A, closed = (np.array(one) for one in textbook(m, k, omega))
    found = frozen_matrix(m, NAME, {"k": k}, omega)
    assert np.abs(found - closed).max() < 1e-12 * np.abs(closed).max()
    assert np.abs(poles(found) - k * poles(A)).max() < 1e-9 * np.abs(found).max()


def test_the_poles_are_k_times_the_machines_to_fifty_digits() -> None:
    with mpmath.workdps(50):
        A, closed = textbook(MACHINE, mpmath.mpf("1.485"), mpmath.mpf(60), mpmath.mpf)
        own, found = (mpmath.eig(mpmath.matrix(one), left=False, right=False) for one in (A, closed))
        for pole in found:
            assert min(abs(pole - mpmath.mpf("1.485") * other) for other in own) < mpmath.mpf(10) ** -44
        # and the printed alpha is not R_r / L_r, so that the two machines must not be confused
        assert min(abs(complex(found[0]) - poles(frozen_matrix(preset("table-iii"), NAME, {"k": 1.485}, 60.0)))) > 1


def test_a_gain_of_one_is_no_gain() -> None:
    nothing = dict.fromkeys(("l_1", "l_2", "l_3", "l_4"), 0.0)
    assert (frozen_matrix(MACHINE, NAME, {"k": 1.0}, 60.0) == frozen_matrix(MACHINE, "baseline", nothing, 60.0)).all()


def test_the_speed_loop_is_that_of_complex_vectors() -> None:
    """The 5x5 matrix typed in complex numbers, in the frame of the flux, with its characteristic polynomial."""
    m, rng = MACHINE, np.random.default_rng(4)
    rho, total = m.R_s / m.sigma, m.gamma + m.alpha
    for k, h, omega, slip in zip(rng.uniform(1, 3, 12), rng.uniform(1, 300, 12), rng.uniform(-150, 150, 12),
                                 rng.uniform(-40, 40, 12), strict=True):
        frame, rotor = omega + slip, m.alpha - 1j * omega
        l_i = (k - 1) * (total - 1j * omega)
        l_phi = ((k * k - 1) * rho - l_i) / m.beta
        M = np.array([[-m.gamma - l_i, m.beta * rotor], [m.alpha * m.L_m - l_phi, -rotor]]) - 1j * frame * np.eye(2)
        A = np.zeros((5, 5))
        for r in range(2):
            for q in range(2):
                z = M[r, q]
                A[2 * r:2 * r + 2, 2 * q:2 * q + 2] = [[z.real, -z.imag], [z.imag, z.real]]
        A[1, 4], A[3, 4], A[4, 1] = -m.beta * FLUX, FLUX, h * m.beta * FLUX
        found = full_matrix(m, NAME, {"k": k, "h": h}, OperatingPoint(omega, FLUX, slip))
        assert np.abs(found - A).max() < 1e-12 * np.abs(A).max()
        D = np.poly1d([1, k * (total - 1j * omega), k * k * rho * rotor])(np.poly1d([1, 1j * frame]))
        size = np.poly1d(np.convolve(D.coeffs, D.coeffs.conj()).real)
        cubic = np.poly1d([1, k * total, frame**2 + k * k * rho * m.alpha, k * total * frame**2 - k * k * rho * omega * frame])
        printed = np.poly1d([1, 0]) * size + h * m.beta**2 * FLUX**2 * cubic
        assert np.poly(found) == pytest.approx(printed.coeffs, rel=1e-9)


@pytest.mark.parametrize("k", [1.0, 1.485, 2.2])
@pytest.mark.parametrize("omega", [-30.0, 8.0, 60.0])
def test_the_edge_of_the_unstable_region_is_where_the_ledger_says(k: float, omega: float) -> None:
    """Bisection on the pencil's own poles, without the formula, finds the formula to 1e-9."""
    def growing(share: float) -> bool:
        return bool(loop(k, 100.0, omega, (share - 1) * omega).real.max() > 0)

    low, high = 0.01, 1.0
    assert growing(low) and not growing(high)
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growing(middle) else (low, middle)
    assert low == pytest.approx(edge(MACHINE, k), rel=1e-9)


def test_inside_the_region_no_h_helps_and_outside_h_must_not_be_small() -> None:
    share = 0.5 * edge(MACHINE, 1.485)
    for h in np.geomspace(1e-3, 1e6, 10):
        found = loop(1.485, h, 20.0, (share - 1) * 20.0)
        assert ((found.real > 0) & (found.imag == 0)).sum() == 1
    outside = OperatingPoint(-145.0, FLUX, -24.0)  # motoring
    slow, fast = (poles_at(MACHINE, NAME, {"k": 1.0, "h": h}, outside, "full") for h in (1.0, 100.0))
    assert slow.real.max() > 0.01 and slow[slow.real.argmax()].imag != 0 and fast.real.max() < -0.1


def test_too_large_a_k_loses_an_idle_machine_at_every_speed() -> None:
    limit = 1 / edge(MACHINE, 1.0)
    assert limit == pytest.approx(2.39186, abs=1e-5) and 1 / edge(preset("table-iii"), 1.0) == pytest.approx(1.92791, abs=1e-5)
    speeds = np.array([-150.0, -20.0, 5.0, 60.0, 300.0])
    assert (loop(1.01 * limit, 100.0, speeds, 0.0).real.max(axis=-1) > 0).all()
    assert (loop(0.99 * limit, 100.0, speeds, 0.0).real.max(axis=-1) < 0).all()


def test_both_directions_are_alike() -> None:
    rng = np.random.default_rng(1)
    omega, slip = rng.uniform(-150, 150, 40), rng.uniform(-30, 30, 40)
    assert loop(1.485, 100.0, omega, slip) == pytest.approx(loop(1.485, 100.0, -omega, -slip), rel=1e-7, abs=1e-7)


# In the simulator ---------------------------------------------------------------------------------------------------
def shortened(**changes: Any) -> Study:
    """The step of Fig. 3, at 2.5 s in place of 59.1 s."""
    study = Study.paper().scenario("regenerating").only([NAME])
    return study.changed({"simulation.duration": 4.0, "reference.shape": "steps", "reference.time": [0.0, 2.5],
                          "reference.omega": [40.0, 100.0], "load.time": [0.0], "load.T_l": [0.0], **changes})


@pytest.mark.slow
def test_it_converges_on_the_step_of_fig_3_in_both_directions() -> None:
    runs = [simulate(shortened(**changes)).isel(observer=0) for changes in ({}, {"reference.omega": [-40.0, -100.0]})]
    for run, speed in zip(runs, (100.0, -100.0), strict=True):
        error = run.omega - run.omega_hat
        assert float(run.omega[-1]) == pytest.approx(speed, abs=0.1)
        assert float(abs(error.sel(time=slice(2.0, 2.4))).max()) < 1e-3  # before the step, and again after it
        assert float(abs(error.sel(time=slice(3.6, None))).max()) < 1e-3
        assert 0.01 < float(abs(error.sel(time=slice(2.5, 2.7))).max()) < 2.0
    # the mirror: d axes the same, q axes and speeds turned
    forwards, backwards = runs
    for name, sign in (("omega_hat", -1), ("phi_dr_hat", 1), ("phi_qr_hat", -1), ("i_qs_hat", -1)):
        assert np.abs(forwards[name].values - sign * backwards[name].values).max() < 1e-6


def test_with_too_small_an_alpha_it_keeps_the_speed_without_load() -> None:
    run = simulate(shortened(**{f"observers.{NAME}.errors": {"R_r": -0.33571}})).isel(observer=0)
    error = abs(run.omega - run.omega_hat)
    assert float(error.max()) > 1.0 and float(error.sel(time=slice(3.6, None)).max()) < 0.05


@pytest.mark.slow
def test_braking_at_low_speed_is_lost_at_the_rate_of_the_pencil() -> None:
    study = Study.paper().scenario("regenerating")
    run = simulate(study)
    error = (run.omega - run.omega_hat).sel(observer=NAME)
    assert float(abs(error.sel(time=slice(3.5, 3.9))).max()) < 1e-3  # 40 rad/s under -15 N m
    m = study.machine
    i_qs = -15.0 / (1.5 * m.n_p * m.L_m / m.L_r * FLUX)
    slip = m.alpha * m.L_m * i_qs / FLUX
    assert edge(m, 1.485) > (20 + slip) / 20 and edge(m, 1.485) < (40 + slip) / 40
    times = np.array([5.5, 5.9])
    rate = np.diff(np.log(np.abs(error.interp(time=times))))[0] / np.diff(times)[0]
    expected = loop(1.485, 100.0, 20.0, slip).real.max()
    assert expected == pytest.approx(3.2, abs=0.1) and rate == pytest.approx(expected, rel=0.05)
    end = abs(run.omega - run.omega_hat).isel(time=-1)
    assert float(end.sel(observer=NAME)) > 10 and float(end.sel(observer="baseline")) > 10
    assert float(end.sel(observer="repaired")) < 0.5 and float(end.sel(observer="consistent_12")) < 0.5


@pytest.mark.slow
def test_a_batch_over_k_is_the_single_runs() -> None:
    study = shortened(**{"simulation.duration": 0.3, "simulation.record_every": 1, "initial.omega": 35.0})
    gain = f"observers.{NAME}.gains.k"
    batch = run_batch(study, {gain: np.array([1.0, 1.485, 2.0])}, jobs=1).ends[f"{NAME}/omega_hat"]
    assert len(set(batch)) == 3
    for k, found in zip((1.0, 1.485, 2.0), batch, strict=True):
        run = simulate(study.changed({gain: k, "simulation.duration": 0.3001}))  # the record after the batch's last sample
        assert float(run.omega_hat[0, -1]) == pytest.approx(found, rel=1e-11)


# At the command line ------------------------------------------------------------------------------------------------
def test_imo_poles_finds_its_gains_in_the_papers_study(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["poles", "--observer", NAME, "--omega", "20", "--full", "-11", "--json", "-"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["observers"][NAME] == {"kind": NAME, "gains": {"k": 1.485, "h": 100.0}}
    worst = max(re for re, im in data["table"][0]["poles"])
    assert worst == pytest.approx(loop(1.485, 100.0, 20.0, -11.0).real.max(), rel=1e-9)


def test_the_studys_own_gains_come_before_those_of_its_scenarios() -> None:
    study = Study.paper()
    assert study.known_gains["alpha_l"] == 0.05  # the scenario real has 3
    assert study.known_gains["k"] == 1.485 and "eta" not in study.known_gains


@pytest.mark.parametrize(("gains", "message"), [
    ("{ k = 0.0, h = 100.0 }", "gains.k = 0 must be above 0"),
    ("{ k = -2, h = 100.0 }", "gains.k = -2 must be above 0"),
    ('{ k = "2 1/s", h = 100.0 }', "wrong unit"),
    ("{ k = 1.485 }", "gains of baseline_scheduled are missing: h"),
    ("{ k = 1.485, h = 100.0, l_1 = 1.0 }", "gains.l_1 is not known for baseline_scheduled; it has: k, h"),
])
def test_refusals_of_its_gains(gains: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Study.from_toml(paper_text().replace("{ k = 1.485, h = 100.0 }", gains, 1))
