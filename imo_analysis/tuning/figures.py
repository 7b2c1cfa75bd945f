"""Pictures of a tuning: the front between noise and times, and before and after over the range of speeds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.drawing import in_style, line, new_figure
from imo_analysis.tuning.data import undominated

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# of the front: what lies along the axis, its label and scale
_ROLES = (("settling", "settling time of the speed estimate (ms)", 1e3),
          ("recovery", "recovery time of everything else (s)", 1.0))


_MARKERS = {"before": ("o", 13, "none"), "rule": ("x", 6, ""), "chosen": ("*", 10, "")}
_PALE = 1.0, 0.5  # width and opacity of the study's gains over the speed
_FAINT = 0.3  # opacity of what misses another wish


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
    axes[0, 0].set_title("least noise for a settling time, any lag")
    axes[0, 1].set_title("least noise for a recovery time")
    for column, (name, label, scale) in enumerate((("settling", "settling time (ms)", 1e3),
                                                   ("noise", "noise of the speed (rad/s)", 1.0))):
        axis = axes[1, column]
        for observer in speeds["observer"].values:
            style = line(str(observer))
            for gains, width, alpha in (("before", *_PALE), ("chosen", 1.8, 1.0)):
                values = scale * speeds[name].sel(observer=observer, gains=gains).values
                if np.isnan(values).all():
                    continue
                middle = len(values) // 2
                omega = np.insert(speeds["omega"].values, middle, 0.0)
                axis.plot(omega, np.insert(values, middle, np.nan), color=style.color, linestyle=style.linestyle,
                          linewidth=width, alpha=alpha)
        axis.set(yscale="log", xlabel="rotor speed, electrical (rad/s)", ylabel=label)
    axes[1, 0].set_title("settling time over speed")
    axes[1, 1].set_title("noise over speed")
    for axis in axes.flat:
        _plain_ticks(axis)
    _legend(figure, [str(name) for name in speeds["observer"].values])
    return figure


def _front(axis: Any, front: xr.Dataset, role: str, scale: float) -> None:
    roles, x, y = front["role"].values, scale * front[role].values, front["noise"].values
    for observer in dict.fromkeys(str(name) for name in front["observer"].values):
        style = line(observer)
        best, within = undominated(front, observer, role)
        axis.plot(x[best], y[best], color=style.color, linestyle=style.linestyle, marker=".", markersize=5)
        for k in np.flatnonzero((front["observer"].values == observer) & np.isfinite(x) & np.isfinite(y)):
            if roles[k] in _MARKERS:
                marker, size, face = _MARKERS[roles[k]]
                # hollow and larger than the star, so that both show where they are the same gains
                axis.plot(x[k], y[k], linestyle="none", marker=marker, color=style.color, markersize=size,
                          markerfacecolor=face or style.color, alpha=1.0 if k in within else _FAINT)


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
        Line2D([], [], color=grey, linestyle="none", marker="o", markersize=9, markerfacecolor="none",
               label="gains of the study"),
        Line2D([], [], color=grey, linestyle="none", marker="x", label="rule of thumb"),
        Line2D([], [], color=grey, linestyle="none", marker="*", markersize=10, label="chosen"),
        Line2D([], [], color=grey, linestyle="none", marker="o", markersize=9, markerfacecolor="none", alpha=_FAINT,
               label="misses another wish"),
        Line2D([], [], color=grey, linewidth=_PALE[0], alpha=_PALE[1], label="over speed: the study's"),
        Line2D([], [], color=grey, linewidth=1.8, label="over speed: chosen"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
