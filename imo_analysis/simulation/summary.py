"""A run in a few numbers per observer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.simulation.judge import STRETCH, follows
from imo_analysis.simulation.labelled import Labelled

if TYPE_CHECKING:
    import xarray as xr


def summary(run: Labelled | xr.Dataset) -> dict[str, dict[str, Any]]:
    """For each observer its last estimates and the speed error (true - estimate, rad/s).

    Returns
    -------
    dict
        ``{observer: {...}}`` with ``omega_hat``, ``alpha_hat`` (None where it has none) at the last record,
        ``speed_error_rms`` and ``speed_error_peak`` over the second half of the run (None where the start is all that is on
        record), ``lost_at``: the time in s from which there is no estimate, or None, and over the last `STRETCH`
        ``speed_error_end``: the mean (rad/s; None where there is none), and ``off``: whether it does not track, by
        `imo_analysis.simulation.judge`.
    """
    time, omega = np.asarray(run["time"]), np.asarray(run["omega"])
    half = len(time) // 2
    result: dict[str, dict[str, Any]] = {}
    for n, name in enumerate(np.asarray(run["observer"])):
        omega_hat, alpha_hat = np.asarray(run["omega_hat"])[n], np.asarray(run["alpha_hat"])[n]
        error = (omega - omega_hat)[half:]
        finite = np.isfinite(omega_hat)
        usable = len(time) > 1 and np.isfinite(error).any()
        result[str(name)] = {
            "omega_hat": _last(omega_hat),
            "alpha_hat": _last(alpha_hat),
            "speed_error_rms": float(np.sqrt(np.nanmean(error**2))) if usable else None,
            "speed_error_peak": float(np.nanmax(np.abs(error))) if usable else None,
            **_at_the_end(time, omega, omega_hat),
            "lost_at": None if finite.all() else float(time[np.argmin(finite)]),
        }
    return result


def _at_the_end(
    time: NDArray[np.float64], omega: NDArray[np.float64], omega_hat: NDArray[np.float64]
) -> dict[str, float | bool | None]:
    last = time >= time[-1] - STRETCH
    error = (omega - omega_hat)[last]
    mean = float(np.mean(error))
    return {"speed_error_end": mean if np.isfinite(mean) else None,
            "off": not bool(follows(mean, np.sqrt(np.mean(error**2)), np.mean(omega[last])))}


def _last(values: NDArray[np.float64]) -> float | None:
    """The last value of a series that has ended well, else None."""
    return float(values[-1]) if values.size and np.isfinite(values[-1]) else None
