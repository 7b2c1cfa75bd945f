"""The map of `sweeps.sensorless_map` as a picture: speed error over speed and load torque, one panel an observer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imo_analysis.drawing import in_style, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# Errors in rad/s at the ends of the colours, logarithmic.
_LEAST, _MOST = 0.1, 100.0
ROW = 3  # panels beside each other; more stand in two rows


@in_style
def sensorless_figure(data: xr.Dataset) -> Figure:
    """Draw the map.

    Parameters
    ----------
    data : xarray.Dataset
        From `sweeps.sensorless_map.sensorless_map`, with at least two speeds and two torques.

    Returns
    -------
    matplotlib.figure.Figure
        Light where the error is small; hatched where the loop does not hold; the dashed line is zero stator frequency.
    """
    from matplotlib.colors import LogNorm

    names = [str(name) for name in data["observer"].values]
    rows = 1 if len(names) <= ROW else 2
    columns = -(-len(names) // rows)
    figure, axes = new_figure(rows, columns, width=2.0 + 2.6 * columns, height=0.3 + 2.8 * rows, sharex=True, sharey=True,
                              squeeze=False)
    omega, torque = data["omega"].values, data["T_l"].values
    picture = None
    for panel, name in zip(axes.flat, names, strict=False):
        one = data.sel(observer=name)
        error = np.clip(one["speed_error"].values, _LEAST, _MOST)
        picture = panel.pcolormesh(omega, torque, error, norm=LogNorm(_LEAST, _MOST), cmap="cividis_r", shading="nearest",
                                   rasterized=True)
        lost = 1.0 - one["holds"].values
        if lost.any():
            hatched = panel.contourf(omega, torque, lost, levels=[0.5, 1.5], colors="none", hatches=["////"])
            hatched.set_edgecolor("#ffffff")
            hatched.set_linewidth(0.0)
        if 0 < lost.sum() < lost.size:
            panel.contour(omega, torque, lost, levels=[0.5], colors="#d55e00", linewidths=1.0)
        panel.contour(omega, torque, data["stator_frequency"].values, levels=[0.0], colors="#1a1a1a", linestyles="--",
                      linewidths=1.1)
        panel.set_title(f"{name}: holds at {100 * one['holds'].values.mean():.0f} %")
        panel.grid(visible=False)
    for panel in axes.flat[len(names):]:
        panel.set_visible(False)
    for panel in axes[-1]:
        panel.set_xlabel("speed, electrical (rad/s)")
    for panel in axes[:, 0]:
        panel.set_ylabel("load torque (N m)")
    if picture is not None:
        bar = figure.colorbar(picture, ax=list(axes.flat), pad=0.01, extend="both")
        bar.set_label("error of the speed (rad/s)")
    return figure
