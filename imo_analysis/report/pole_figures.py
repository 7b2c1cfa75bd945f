"""Figures of a pole sweep: the map in the complex plane, and the slowest pole over the speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from imo_analysis.report.pencils import rightmost
from imo_analysis.report.style import TRUTH, legend_above, line, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def pole_map(sweep: xr.Dataset, marked: Sequence[float]) -> Figure:
    """Branches of every observer, one panel each, with markers at some speeds (rad/s).

    Both signs of speed are drawn: a branch of negative speed mirrors one of positive speed at the real axis.
    """
    names = [str(name) for name in sweep["observer"].values]
    columns = min(3, len(names))
    rows = -(-len(names) // columns)
    figure, axes = new_figure(rows, columns, width=7.2, height=0.5 + 2.6 * rows, squeeze=False, sharex=True, sharey=True)
    inside = sweep.where(np.isfinite(sweep["re"]))
    low, high = float(inside["re"].quantile(0.002)), float(inside["re"].quantile(0.998))
    for number, axis in enumerate(axes.flat):
        if number >= len(names):
            axis.set_visible(False)
            continue
        name = names[number]
        one, style = sweep.sel(observer=name), line(name)
        for branch in one["branch"].values:
            path = one.sel(branch=branch)
            axis.plot(path["re"], path["im"], color=style.color, linewidth=1.1)
        for k, omega in enumerate(marked):
            at = one.sel(omega=omega, method="nearest")
            axis.plot(at["re"], at["im"], linestyle="none", marker="os^D"[k % 4], color=style.color, markerfacecolor="white",
                      markersize=4, label=f"{float(at['omega']):g} rad/s")
        axis.axvline(0.0, color=TRUTH.color, linewidth=0.8)
        axis.set_title(name)
        if number == 0:
            axis.legend(loc="upper left", fontsize=6.5, handletextpad=0.2, borderpad=0.3)
    room = 0.06 * (high - low)
    axes[0, 0].set_xlim(low - room, max(high, 0.0) + room)
    for axis in axes[:, 0]:
        axis.set_ylabel("imaginary part (rad/s)")
    for number in range(columns):
        below = [row for row in range(rows) if row * columns + number < len(names)]
        axes[below[-1], number].set_xlabel("real part (1/s)")
        axes[below[-1], number].tick_params(labelbottom=True)
    return figure


def rightmost_figure(sweep: xr.Dataset) -> Figure:
    """The largest real part among the poles that move with speed, over the speed, on an axis that is linear near zero."""
    figure, axis = new_figure(height=3.0)
    for name in sweep["observer"].values:
        axis.plot(sweep["omega"], rightmost(sweep.sel(observer=name)), label=str(name), **line(str(name)).kwargs())
    axis.axhline(0.0, color=TRUTH.color, linewidth=0.8)
    axis.set_yscale("symlog", linthresh=1.0)
    axis.set_xlabel(r"speed $\hat{\omega}$ (rad/s)")
    axis.set_ylabel("slowest pole, real part (1/s)")
    axis.margins(x=0.01)
    legend_above(axis, ncols=5)
    return figure
