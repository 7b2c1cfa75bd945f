"""The figure of a replay: estimated speeds beside the recorded one, and their errors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from imo_analysis.drawing import legend_above, line, new_figure, style

_POINTS = 4000
_FAR = 20.0
_GAP = 2.5


def thinned(path: str | Path) -> Any:
    """What the figure needs of a result file, one sample in so many that about 4000 are left.

    Returns
    -------
    xarray.Dataset
        ``omega_hat`` (observer, time), and ``omega`` where it was recorded.
    """
    import h5netcdf
    import xarray as xr

    with h5netcdf.File(path, "r") as file:
        step = max(1, file.dimensions["time"].size // _POINTS)
        names = [name.decode() if isinstance(name, bytes) else str(name) for name in file.variables["observer"][...]]
        data: dict[str, Any] = {"omega_hat": (("observer", "time"), file.variables["omega_hat"][:, ::step])}
        if "omega" in file.variables:
            data["omega"] = (("time",), file.variables["omega"][::step])
        return xr.Dataset(data, coords={"time": file.variables["time"][::step], "observer": names})


def broken(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A line that is not drawn over gaps of the record: steps of time of more than `_GAP` times the usual one."""
    steps = np.diff(time)
    usual = np.median(steps) if len(steps) else 0.0
    gaps = 1 + np.flatnonzero(steps > _GAP * usual)
    return np.insert(time, gaps, np.nan), np.insert(values, gaps, np.nan)


def replay_figure(data: Any) -> Any:
    """Electrical speeds, and below them the errors where a speed was recorded; in logarithms where one goes far away.

    Parameters
    ----------
    data : xarray.Dataset
        From `thinned`, or a whole result.

    Returns
    -------
    matplotlib.figure.Figure
    """
    measured = "omega" in data
    many = data.sizes["observer"] > 3
    rows = -(-(data.sizes["observer"] + 1) // 3) if many else 1  # of the legend
    height = (4.8 if measured else 3.2) + 0.17 * (rows - 1)
    figure, axes = new_figure(2 if measured else 1, 1, height=height, sharex=True, squeeze=False)
    time = data["time"].values
    with style():
        if measured:
            recorded = {**line("true").kwargs(), "linewidth": 2.2}
            axes[0, 0].plot(*broken(time, data["omega"].values), label="recorded", **recorded)
        largest = []
        for number, name in enumerate(data["observer"].values):
            look = line(str(name))
            # a Luenberger variant has the colour and dashes of its adaptive sibling, and markers
            marks: dict[str, Any] = {}
            if str(name).startswith("luenberger_"):
                marks = {"marker": look.marker, "markevery": (7 * number, max(1, len(time) // 12)), "markersize": 3.5}
            estimate = data["omega_hat"].sel(observer=name).values
            axes[0, 0].plot(*broken(time, estimate), label=str(name), **look.kwargs(), **marks)
            if measured:
                error = estimate - data["omega"].values
                axes[1, 0].plot(*broken(time, error), **{**look.kwargs(), "linewidth": 0.9}, **marks)
                settled = np.abs(error[len(error) // 4 :])
                if np.isfinite(settled).all():
                    largest.append(float(settled.max()))
        axes[0, 0].set_ylabel(r"$\hat\omega$ (rad/s)")
        if measured:
            axes[1, 0].set_ylabel(r"$\hat\omega - \omega$ (rad/s)")
            if largest and max(largest) > 0:
                if max(largest) > _FAR * min(largest) > 0:  # one that goes away would make a line of those that follow
                    straight = 10.0 ** np.ceil(np.log10(2 * np.median(largest)))
                    axes[1, 0].set_yscale("symlog", linthresh=straight)
                    axes[1, 0].yaxis.set_major_formatter("{x:g}")
                axes[1, 0].set_ylim(-1.3 * max(largest), 1.3 * max(largest))
        axes[-1, 0].set_xlabel("time (s)")
        legend_above(axes[0, 0], ncols=3 if many else 4, columnspacing=3.5 if many else 2.0)
    return figure
