"""A run in a few numbers per observer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.simulation.labelled import Labelled

if TYPE_CHECKING:
    import xarray as xr

OFF = 0.02  # of the speed, above which an estimate is called off
STRETCH = 0.5  # s, over which it is judged


def summary(run: Labelled | xr.Dataset) -> dict[str, dict[str, Any]]:
    """For each observer its last estimates and the speed error (true - estimate, rad/s).

    Returns
    -------
    dict
        ``{observer: {...}}`` with ``omega_hat``, ``alpha_hat`` (None where it has none) at the last record,
        ``speed_error_rms`` and ``speed_error_peak`` over the second half of the run (None where the start is all that is on
        record), ``lost_at``: the time in s from which there is no estimate, or None, and ``off``: whether it ends off the
        speed, as in `follows`, over the last `STRETCH`.
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
            "off": not _follows_at_the_end(time, omega, omega_hat),
            "lost_at": None if finite.all() else float(time[np.argmin(finite)]),
        }
    return result


def follows(mean_error: float, rms: float, omega: float) -> bool:
    """Whether an estimate is the speed: the mean error below the share `OFF` of it, and the error's rms below five times that.

    Parameters
    ----------
    mean_error, rms : float
        Of the speed error, in rad/s; NaN where there is no estimate.
    omega : float
        The mean speed, in rad/s.
    """
    limit = OFF * max(abs(omega), 1.0)
    return bool(abs(mean_error) <= limit and rms <= 5 * limit)


def _follows_at_the_end(time: NDArray[np.float64], omega: NDArray[np.float64], omega_hat: NDArray[np.float64]) -> bool:
    last = time >= time[-1] - STRETCH
    error = (omega - omega_hat)[last]
    return follows(float(np.mean(error)), float(np.sqrt(np.mean(error**2))), float(np.mean(omega[last])))


def _last(values: NDArray[np.float64]) -> float | None:
    """The last value of a series that has ended well, else None."""
    return float(values[-1]) if values.size and np.isfinite(values[-1]) else None
