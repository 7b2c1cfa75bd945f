"""Records for the tests of replay, made without the simulator: by scipy on the plain definition, and by matrix exponentials."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from imo_analysis.equations.plant import plant
from imo_analysis.machine import PRESETS, InductionMachine

TABLE = PRESETS["table-iii"]
_IMMEC = Path(__file__).resolve().parents[3] / "shared" / "data" / "immec" / "default_linear.csv"
IMMEC_MACHINE = InductionMachine.build(
    {"n_p": 1, "R_s": 6.21, "R_r": 6.70, "L_m": 0.4993, "L_s": 0.5123, "L_r": 0.5123, "J": 0.0022, "name": "IMMEC"}
)
HEADER = "time,u_alpha,u_beta,i_alpha,i_beta,omega"


def immec() -> Path:
    """The third-party record beside the checkout. In CI it must be there; elsewhere its tests are skipped without it."""
    if not _IMMEC.is_file():
        if os.environ.get("CI"):
            pytest.fail(f"{_IMMEC} is missing")
        pytest.skip("the third-party record is not beside this checkout")
    return _IMMEC


def write(path: Path, rows: np.ndarray, header: str = HEADER) -> Path:
    """A CSV of rows with all their digits."""
    lines = [header, *(",".join(repr(float(value)) for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def start_up(duration: float = 0.5, rate: float = 1e4) -> np.ndarray:
    """A V/f start from standstill without load: DOP853 on the plain plant. Columns as `HEADER`."""
    from scipy.integrate import solve_ivp

    last = 200.0 / 0.4  # rad/s^2 of the stator frequency
    machine = TABLE

    def voltage(t: float) -> complex:
        frequency = last * t
        return (2.0 + 0.55 * frequency) * np.exp(0.5j * last * t * t)

    def rates(t: float, x: np.ndarray) -> tuple[float, ...]:
        u = voltage(t)
        return plant(tuple(x), (u.real, u.imag), 0.0, 0.0, machine.plant_parameters)

    time = np.arange(round(duration * rate)) / rate
    done = solve_ivp(rates, (0, time[-1]), np.zeros(5), method="DOP853", t_eval=time, rtol=1e-9, atol=1e-9)
    u = voltage(time)
    return np.column_stack([time, u.real, u.imag, done.y[0], done.y[1], done.y[4]])


def steady(duration: float = 0.5, rate: float = 1e4, omega: float = 200.0, slip: float = 5.0) -> np.ndarray:
    """A steady state of the table's machine by phasors, flux of about 0.5 Wb. Columns as `HEADER`."""
    m = TABLE
    frequency = omega + slip
    current = 10.0
    phi = m.alpha * m.L_m * current / (m.alpha + 1j * slip)
    voltage = m.R_s * current + 1j * frequency * (m.sigma * current + m.L_m / m.L_r * phi)
    time = np.arange(round(duration * rate)) / rate
    turn = np.exp(1j * frequency * time)
    u, i = voltage * turn, current * turn
    return np.column_stack([time, u.real, u.imag, i.real, i.imag, np.full(len(time), omega)])


def held_voltage(duration: float = 0.5, rate: float = 2e3, omega: float = 280.0, frequency: float = 285.0) -> np.ndarray:
    """The currents of a voltage that is held between samples, at constant speed, by matrix exponentials. As `HEADER`."""
    from scipy.linalg import expm

    m = TABLE

    def row(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.array(plant((*x, omega), tuple(u), 0.0, 0.0, m.plant_parameters)[:4])

    zero = np.zeros(2)
    A = np.column_stack([row(unit, zero) for unit in np.eye(4)])
    B = np.column_stack([row(np.zeros(4), unit) for unit in np.eye(2)])
    step = expm(np.block([[A, B], [np.zeros((2, 6))]]) / rate)
    time = np.arange(round(duration * rate)) / rate
    u = 150 * np.exp(1j * frequency * time)
    x = np.zeros((len(time), 4))
    for k in range(len(time) - 1):
        x[k + 1] = step[:4, :4] @ x[k] + step[:4, 4:] @ (u[k].real, u[k].imag)
    return np.column_stack([time, u.real, u.imag, x[:, 0], x[:, 1], np.full(len(time), omega)])
