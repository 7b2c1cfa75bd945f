"""Pictures of a tuning: the front between noise and times, and before and after over the range of speeds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.drawing import in_style, line, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# of the front: what lies along the axis, its label and scale
_ROLES = (("settling", "settling time of the speed estimate (ms)", 1e3),
          ("recovery", "recovery time of everything else (s)", 1.0))


@in_style
def tuning_figure(front: xr.Dataset, speeds: xr.Dataset) -> Figure:
    """Four panels.

    Parameters
    ----------
    front : xarray.Dataset
        From `imo_analysis.tuning.data.front_data`.
    speeds : xarray.Dataset
        From `imo_analysis.tuning.tune.over_speed`.
    """
    figure, axes = new_figure(2, 2, width=7.6, height=7.0)
    for column, (role, label, scale) in enumerate(_ROLES):
        _front(axes[0, column], front, role, scale)
        axes[0, column].set(xscale="log", yscale="log", xlabel=label, ylabel="noise of the speed (rad/s)")
    axes[0, 0].set_title("least noise for wished speed times")
    axes[0, 1].set_title("least noise for a wished recovery time")
    for column, (name, label, scale) in enumerate((("settling", "settling time (ms)", 1e3),
                                                   ("noise", "noise of the speed (rad/s)", 1.0))):
        axis = axes[1, column]
        for observer in speeds["observer"].values:
            style = line(str(observer))
            for gains, dashes, width in (("before", (0, (1, 1.5)), 1.3), ("chosen", style.linestyle, 1.8)):
                values = scale * speeds[name].sel(observer=observer, gains=gains).values
                if np.isnan(values).all():
                    continue
                middle = len(values) // 2
                omega = np.insert(speeds["omega"].values, middle, 0.0)
                axis.plot(omega, np.insert(values, middle, np.nan), color=style.color, linestyle=dashes, linewidth=width)
        axis.set(yscale="log", xlabel="rotor speed, electrical (rad/s)", ylabel=label)
    axes[1, 0].set_title("settling time over speed")
    axes[1, 1].set_title("noise over speed")
    for axis in axes.flat:
        _plain_ticks(axis)
    _legend(figure, [str(name) for name in speeds["observer"].values])
    return figure


def _front(axis: Any, front: xr.Dataset, role: str, scale: float) -> None:
    for observer in np.unique(front["observer"].values):
        style = line(str(observer))
        one = front.isel(point=np.flatnonzero(front["observer"].values == observer))
        finite = np.isfinite(one["noise"].values) & np.isfinite(one[role].values)
        roles = one["role"].values
        on = finite & np.isin(roles, (role, "wish"))
        x, y = scale * one[role].values[on], one["noise"].values[on]
        order = np.argsort(x)
        order = order[[k for k in range(len(order)) if y[order[k]] <= y[order[: k + 1]].min()]]  # what nothing beats in both
        axis.plot(x[order], y[order], color=style.color, linestyle=style.linestyle, marker=".", markersize=5)
        for which, marker, face in (("before", "o", "none"), ("rule", "x", style.color), ("chosen", "*", style.color)):
            at = finite & (roles == which)
            axis.plot(scale * one[role].values[at], one["noise"].values[at], linestyle="none", marker=marker, color=style.color,
                      markerfacecolor=face, markersize=11 if which == "chosen" else 6)


def _plain_ticks(axis: Any) -> None:
    """Numbers as people write them at 1, 2 and 5 of every decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for one in (axis.xaxis, axis.yaxis):
        if one.get_scale() == "log":
            one.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            one.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            one.set_minor_formatter(NullFormatter())


def _legend(figure: Figure, observers: Sequence[str]) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], **line(name).kwargs(), label=name) for name in observers]
    grey = "#555555"
    handles += [
        Line2D([], [], color=grey, linestyle="none", marker="o", markerfacecolor="none", label="gains of the study"),
        Line2D([], [], color=grey, linestyle="none", marker="x", label="rule of thumb"),
        Line2D([], [], color=grey, linestyle="none", marker="*", markersize=11, label="chosen; thick over speed"),
        Line2D([], [], color=grey, linestyle=(0, (1, 1.5)), label="gains of the study, over speed"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
