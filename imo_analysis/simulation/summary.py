"""A run in a few numbers per observer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr


def summary(run: xr.Dataset) -> dict[str, dict[str, Any]]:
    """For each observer its last estimates and the speed error (true - estimate, rad/s).

    Returns
    -------
    dict
        ``{observer: {...}}`` with ``omega_hat``, ``alpha_hat`` (None where it has none) at the last record,
        ``speed_error_rms`` and ``speed_error_peak`` over the second half of the run, and ``lost_at``: the time in s from
        which there is no estimate, or None.
    """
    half = run.isel(time=slice(run.sizes["time"] // 2, None))
    result: dict[str, dict[str, Any]] = {}
    for name in run["observer"].values:
        one = run.sel(observer=name)
        error = (half["omega"] - half["omega_hat"].sel(observer=name)).values
        finite = np.isfinite(one["omega_hat"].values)
        whole = bool(finite.all())
        usable = np.isfinite(error).any()
        result[str(name)] = {
            "omega_hat": _last(one["omega_hat"]),
            "alpha_hat": _last(one["alpha_hat"]),
            "speed_error_rms": float(np.sqrt(np.nanmean(error**2))) if usable else None,
            "speed_error_peak": float(np.nanmax(np.abs(error))) if usable else None,
            "lost_at": None if whole else float(run["time"].values[np.argmin(finite)]),
        }
    return result


def _last(values: xr.DataArray) -> float | None:
    """The last value of a series that has ended well, else None."""
    last = float(values[-1]) if values.size else float("nan")
    return last if np.isfinite(last) else None
