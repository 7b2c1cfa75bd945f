"""Waveforms of the flux modulation: in time for the simulation, and their Fourier lines for the closed forms.

Each has zero mean and peaks of 1 at most, as a function of the angle frequency times time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.study_tables import Drive

Array = NDArray[np.float64]


def _triangle(angle: Any) -> Any:
    return 2 / math.pi * np.arcsin(np.sin(angle))


def _square(angle: Any) -> Any:
    return np.where(np.mod(angle, 2 * math.pi) < math.pi, 1.0, -1.0)


def _two_tone(angle: Any) -> Any:
    return (np.sin(angle) + np.sin(3 * angle)) * (3 * math.sqrt(3) / 8)


WAVES: dict[str, Callable[[Any], Any]] = {"sine": np.sin, "triangle": _triangle, "square": _square, "two_tone": _two_tone}
TOP = 63  # the last line kept of triangle and square; the rest is below 1 % of the square's first, and the drive damps it


def swing(drive: Drive, time: NDArray[Any]) -> Array:
    """What the flux reference is modulated by at the given times, in units of ``drive.flux_modulation``."""
    if drive.flux_modulation_frequency == 0:
        return np.zeros(len(time))
    off, on = drive.flux_modulation_off
    values = np.asarray(WAVES[drive.flux_waveform](drive.flux_modulation_frequency * time), dtype=float)
    return np.where((time >= off) & (time < on), 0.0, values)


def lines(waveform: str, top: int = TOP) -> tuple[NDArray[np.int64], NDArray[np.complex128]]:
    """Orders n, up to ``top``, and amplitudes c_n of a waveform: the sum of c_n exp(j n angle) and of the conjugates."""
    odd = np.arange(1, top + 1, 2)
    of: dict[str, tuple[Any, Any]] = {
        "sine": ([1], [1.0]),
        "triangle": (odd, 8 / math.pi**2 * (-1.0) ** ((odd - 1) // 2) / odd**2),
        "square": (odd, 4 / math.pi / odd),
        "two_tone": ([1, 3], [3 * math.sqrt(3) / 8] * 2),
    }
    orders, sines = of[waveform]
    return np.asarray(orders, dtype=np.int64), np.asarray(sines) / 2j
