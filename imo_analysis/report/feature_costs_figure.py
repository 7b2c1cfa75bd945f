"""The table of `sweeps.feature_costs` as a picture: error of the estimated speed, a row a feature, a mark an observer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imo_analysis.drawing import in_style, legend_above, line, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# Errors in rad/s at the ends of the axis; smaller ones stand at its start.
_LEAST, _MOST = 1e-3, 1e3


@in_style
def feature_costs_figure(data: xr.Dataset) -> Figure:
    """Draw the table.

    Parameters
    ----------
    data : xarray.Dataset
        From `sweeps.feature_costs.feature_costs`.

    Returns
    -------
    matplotlib.figure.Figure
        Root mean square error of each estimated speed, logarithmic; a cross at the right end where the observer diverged.
    """
    features = [str(name) for name in data["feature"].values]
    figure, axes = new_figure(1, 1, width=7.2, height=1.0 + 0.24 * len(features))
    names = [str(name) for name in data["observer"].values]
    place = np.arange(len(features))
    error = (data["speed_error"] ** 2 + data["speed_ripple"] ** 2) ** 0.5
    for n, name in enumerate(names):
        style, shift = line(name), 0.5 * ((n + 0.5) / len(names) - 0.5)
        values = error.sel(observer=name).values
        lost = ~np.isfinite(values)
        axes.plot(np.clip(values[~lost], _LEAST, _MOST), place[~lost] + shift, style.marker, color=style.color, label=name)
        axes.plot(np.full(lost.sum(), _MOST), place[lost] + shift, "x", color=style.color)
    axes.set_xscale("log")
    axes.set_xlim(_LEAST / 1.3, _MOST * 1.3)
    axes.set_yticks(place, features)
    axes.set_ylim(len(features) - 0.5, -0.5)
    axes.set_xlabel("error of the estimated speed, rms (rad/s)")
    legend_above(axes)
    return figure
