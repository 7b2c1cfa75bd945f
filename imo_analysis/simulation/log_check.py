"""Does a record fit the machine? The stator flux that the voltages add up to, against the one that the currents imply.

From (1): u - R_s i is the rate of the stator flux, which is sigma i + (L_m/L_r) phi; and phi follows from the currents and the
speed by the flux rows of (1). Both sides pass the same high-pass filter, so that the unknown start and offsets drop out. The
complex factor between them is 1 for a record in the right units: a size of 1000, a turn by 30 degrees and so on name the slip.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.simulation import compile as compiler
from imo_analysis.simulation.drive import flux_model

_ROTOR_FLUX = """
@njit(cache=True, error_model="numpy")
def run(i_d, i_q, omega, T, p, start, out_d, out_q):
    phi = (start, 0.0)
    out_d[0], out_q[0] = phi
    for k in range(1, len(i_d)):
        phi = flux_model(phi, (i_d[k - 1], i_q[k - 1]), (i_d[k], i_q[k]), 0.5 * (omega[k - 1] + omega[k]), T, p)
        out_d[k], out_q[k] = phi
"""
_HIGH_PASS = """
@njit(cache=True, error_model="numpy")
def run(rise, keep, out):
    y = 0j
    out[0] = y
    for k in range(len(rise)):
        y = keep * y + 2.0 / (1.0 + 1.0 / keep) * 0.0 + rise[k]
        out[k + 1] = y
"""
GOOD_FACTOR, GOOD_FIT = 0.35, 0.8
_NAMED_FACTOR, _NAMED_FIT = 0.2, 0.9
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
