"""Does a record fit the machine? The stator flux that the voltages add up to, against the one that the currents imply.

From (1): u - R_s i is the rate of the stator flux, which is sigma i + (L_m/L_r) phi; and phi follows from the currents and the
speed by the flux rows of (1). Both sides pass the same high-pass filter, so that the unknown start and offsets drop out. The
complex factor between them is 1 for a record in the right units: a size of 1000, a turn by 30 degrees and so on name the slip.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from imo_analysis import compile as compiler
from imo_analysis.equations.plant import plant
from imo_analysis.machine import InductionMachine

# The flux rows of (1) are linear at one speed; with a current along a line their exact solution over a sample has the functions
# (exp z - 1)/z and (exp z - 1 - z)/z^2 of z = (j omega - alpha) T, here as a series where the latter would cancel.
_ROTOR_FLUX = """
from cmath import exp


@njit(cache=True, error_model="numpy")
def run(i_d, i_q, omega, T, p, start, out_d, out_q):
    none = (0.0, 0.0)
    phi, i = complex(start, 0.0), complex(i_d[0], i_q[0])
    out_d[0], out_q[0] = start, 0.0
    for k in range(1, len(i_d)):
        w = (omega[k - 1] + omega[k]) / 2
        own = plant((0.0, 0.0, 1.0, 0.0, w), none, 0.0, 0.0, p)
        fed = plant((1.0, 0.0, 0.0, 0.0, w), none, 0.0, 0.0, p)
        z = T * complex(own[2], own[3])
        second = complex(1.0, 0.0)
        if abs(z.real) + abs(z.imag) < 0.5:
            for n in range(14, 2, -1):
                second = 1.0 + z / n * second
            second = second / 2.0
        else:
            second = (exp(z) - 1.0 - z) / (z * z)
        first = 1.0 + z * second
        before, i = i, complex(i_d[k], i_q[k])
        phi = (1.0 + z * first) * phi + T * complex(fed[2], fed[3]) * (first * before + second * (i - before))
        out_d[k], out_q[k] = phi.real, phi.imag
"""
LEAK = """
@njit(cache=True, error_model="numpy")
def run(rise, keep, out):
    y = 0j
    out[0] = y
    for k in range(len(rise)):
        y = keep * y + rise[k]
        out[k + 1] = y
"""
GOOD_FACTOR, GOOD_FIT = 0.35, 0.9
_FIRST, _NO_CURRENT = 0.2, 0.05
_CORNER = 0.3  # of the filter, in parts of the stator frequency


@dataclass(frozen=True)
class Fit:
    """How a record fits a machine.

    Attributes
    ----------
    factor : complex
        Voltage side over current side; 1 where all is right.
    share : float
        Part of the voltage side that the current side explains, at most 1.
    """

    factor: complex
    share: float

    def good(self, off: float = GOOD_FACTOR, share: float = GOOD_FIT) -> bool:
        """Whether the factor is within ``off`` of 1 and the share above ``share``."""
        return abs(self.factor - 1) <= off and self.share >= share


def stator_frequency(u: np.ndarray, T: float) -> float:
    """Frequency of the voltages in rad/s with its sign, the samples weighed by their power."""
    power = float((np.abs(u[:-1]) * np.abs(u[1:])).sum())
    turn = complex((np.conj(u[:-1]) * u[1:]).sum())
    return cmath.phase(turn) / T if power > 0 and abs(turn) > 0 else 0.0


def high_passed(increments: np.ndarray, corner: float, T: float) -> np.ndarray:
    """A signal given by its increments, through s/(s + corner); one entry more than increments."""
    out = np.empty(len(increments) + 1, dtype=complex)
    half = corner * T / 2
    compiler.entry(LEAK, {})(increments / (1 + half), (1 - half) / (1 + half), out)
    return out


LINE = 0.3  # rad; a straight line between two voltages that are turned by more is off by more than a hundredth


@dataclass(frozen=True)
class Level:
    """What a stretch of a record is like.

    Attributes
    ----------
    stator_frequency : float
        rad/s, with its sign.
    flux : float
        Rotor flux in Wb, from the voltages.
    noise : float
        Standard deviation of the noise of a current in A.
    turned : float
        Angle by which the voltages turn in it, in rad: with less than half a turn the flux is not one.
    """

    stator_frequency: float
    flux: float
    noise: float = 0.0
    turned: float = math.inf

    @property
    def longest_line(self) -> float:
        """How long in s voltages can be joined by a straight line: while they turn by `LINE`."""
        return LINE / abs(self.stator_frequency) if self.stator_frequency else math.inf


def level(u: np.ndarray, i: np.ndarray, T: float, machine: InductionMachine) -> Level:
    """Frequency, flux and noise of a stretch; the first two weighed towards where the flux is large."""
    rough = abs(stator_frequency(u, T)) or 1.0
    stator = _voltage_side(u, i, T, machine, _CORNER * rough)
    rotor = (stator - machine.sigma * high_passed(np.diff(i), _CORNER * rough, T)) * machine.L_r / machine.L_m
    square = np.abs(rotor) ** 2
    total = float(square.sum())
    flux = math.sqrt(float((square**2).sum()) / total) if total > 0 else 0.0
    frequency = stator_frequency(stator, T)
    return Level(frequency, flux, current_noise(i), abs(frequency) * T * len(u))


def current_noise(i: np.ndarray) -> float:
    """Standard deviation of white noise on each of the two currents, from third differences, which what is smooth has not."""
    if len(i) < 4:
        return 0.0
    rough = np.diff(i, 3)
    # the median size of a normal variable is 0.6745 of its deviation; a third difference has 20 times the variance
    return float(np.median(np.abs(np.concatenate([rough.real, rough.imag])))) / (0.6745 * math.sqrt(20))


def _voltage_side(u: np.ndarray, i: np.ndarray, T: float, machine: InductionMachine, corner: float) -> np.ndarray:
    back = u - machine.R_s * i
    return high_passed(T / 2 * (back[1:] + back[:-1]), corner, T)


def between(u: np.ndarray, voltage: str) -> np.ndarray:
    """Mean voltage from each sample to the next, by what a sample stands for (`imo_analysis.replay.estimate.Treatment`)."""
    return {"linear": (u[1:] + u[:-1]) / 2, "held": u[:-1], "averaged": u[1:]}[voltage]


def fit(
    u: np.ndarray, i: np.ndarray, omega: np.ndarray, T: float, machine: InductionMachine, voltage: str = "linear"
) -> Fit:
    """Compare the two sides over a stretch.

    Parameters
    ----------
    u, i : ndarray of complex
        d + j q, stationary frame, V and A.
    omega : ndarray
        Electrical speed in rad/s.
    T : float
        Sampling period in s.
    voltage : str
        What a sample of the voltage stands for.
    """
    corner = _CORNER * (abs(stator_frequency(u, T)) or 1.0)
    volts = high_passed(T * between(u, voltage), corner, T)
    drop = high_passed(T / 2 * machine.R_s * (i[1:] + i[:-1]), corner, T)
    with np.errstate(all="ignore"):
        phi = _rotor_flux(i, omega, T, machine, 0.0)
        free = _rotor_flux(np.zeros_like(i), omega, T, machine, 1.0)
        amps = drop + high_passed(np.diff(machine.sigma * i + machine.L_m / machine.L_r * phi), corner, T)
    start = np.exp(-corner * T * np.arange(len(u)))
    sides = np.column_stack([amps, high_passed(np.diff(free), corner, T), start])
    if not np.isfinite(sides).all():
        return Fit(complex(math.nan, math.nan), 0.0)
    used = slice(len(u) // 5, None)
    scale = np.linalg.norm(sides[used], axis=0)
    scale[scale == 0] = 1.0
    found, *_ = np.linalg.lstsq(sides[used] / scale, volts[used], rcond=1e-9)
    rest = volts[used] - (sides[used] / scale) @ found
    total = float((np.abs(volts[used]) ** 2).sum())
    return Fit(complex(found[0] / scale[0]), 1 - float((np.abs(rest) ** 2).sum()) / total if total > 0 else 0.0)


def _rotor_flux(i: np.ndarray, omega: np.ndarray, T: float, machine: InductionMachine, start: float) -> np.ndarray:
    out_d, out_q = np.empty(len(i)), np.empty(len(i))
    run = compiler.entry(_ROTOR_FLUX, {"plant": plant})
    run(np.ascontiguousarray(i.real), np.ascontiguousarray(i.imag), omega, T, machine.plant_parameters, start, out_d, out_q)
    return out_d + 1j * out_q
