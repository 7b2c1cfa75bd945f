"""What comes from outside, sample by sample: references, load torque, sensor noise. Any stretch of it can be asked for."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.simulation.waveforms import swing
from imo_analysis.study import Study
from imo_analysis.study_tables import Load, Reference

Array = NDArray[np.float64]


def inputs(study: Study, first: int, count: int) -> Array:
    """The rows of `kernel.INPUTS` for the samples ``first .. first + count - 1``, shape (5, count)."""
    index = np.arange(first, first + count)
    time = index * study.simulation.sample_time
    result = np.zeros((5, count))
    result[0] = profile(study.reference, study.reference.omega, time, study.simulation.sample_time)
    result[1] = study.drive.flux
    if study.drive.flux_modulation > 0:
        result[1] += study.drive.flux_modulation * swing(study.drive, time)
    result[2] = profile(study.load_torque, study.load_torque.T_l, time, study.simulation.sample_time)
    if study.sensors.current_noise > 0:
        result[3:] = study.sensors.current_noise * np.array(normals(study.simulation.seed, index))
    return result


def profile(table: Reference | Load, values: tuple[float, ...], time: NDArray[Any], sample_time: float) -> Array:
    """A table of the study at the given times; the last value holds after its end."""
    if table.shape == "linear":
        return np.interp(time, table.time, values)
    # a step at 32.5 s belongs to the sample at 32.5 s, however that product was rounded
    place = np.searchsorted(table.time, time + 1e-6 * sample_time, side="right") - 1
    return np.asarray(values)[place]


def normals(seed: int, index: NDArray[np.int64]) -> tuple[Array, Array]:
    """Two independent standard normal numbers for each sample, a function of seed and sample number alone.

    The Box-Muller transform of `uniforms`.
    """
    one, two = uniforms(seed, index)
    radius = np.sqrt(-2.0 * np.log(one))
    angle = 2.0 * math.pi * (two - 2.0**-54)
    return radius * np.cos(angle), radius * np.sin(angle)


def uniforms(seed: int, index: NDArray[np.int64]) -> tuple[Array, Array]:
    """Two independent numbers between 0 and 1, both excluded, for each index, a function of seed and index alone.

    Counter-based: SplitMix64 (Steele, Lea and Flood 2014) of the counter.
    """
    with np.errstate(over="ignore"):
        key = _mixed(np.uint64(seed) + np.uint64(0x9E3779B97F4A7C15))
        counter = index.astype(np.uint64) * np.uint64(2)
        one, two = (_mixed(key + (counter + np.uint64(j)) * np.uint64(0x9E3779B97F4A7C15)) for j in (1, 2))
    return tuple(((bits >> np.uint64(11)).astype(float) + 0.5) * 2.0**-53 for bits in (one, two))


def _mixed(value: Any) -> Any:
    value = (value ^ (value >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    value = (value ^ (value >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return value ^ (value >> np.uint64(31))
