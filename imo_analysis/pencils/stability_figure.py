"""The picture of a map over two parameters: shades, labelled contours, the limit of stability. Data in, figure out."""

from __future__ import annotations

from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.drawing import new_figure, points, style
from imo_analysis.errors import InputError
from imo_analysis.pencils.maps import with_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_INK = "#1a1a1a"
_UNSTABLE = "\\\\\\"  # dots would be a hundred kilobytes of circles
_NOWHERE: dict[str, Any] = {"facecolor": "#e6e6e6", "edgecolor": "#8a8a8a", "hatch": "////", "linewidth": 0.0}
_LEVELS = {
    "decay": (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0),
    "damping": (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9),
    "settling_time": (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
}


def plot_stability(data: xr.Dataset, quantity: str = "decay", title: str = "") -> Figure:
    """Shades and labelled contours over two parameters, a panel an observer, all with one scale.

    Heavy line: the limit of stability. Hatched: unstable. Hatched grey: no state at rest there.

    Parameters
    ----------
    data : xarray.Dataset
        Of `imo_analysis.pencils.stability.stability_map`.
    quantity : str
        ``decay``, ``damping`` or ``settling_time``.
    title : str
        Above the picture.

    Raises
    ------
    InputError
        For another quantity, or where the grid has only one value of a parameter.
    """
    from matplotlib.ticker import NullFormatter

    if quantity not in _LEVELS:
        raise InputError(f"quantity = {quantity!r} is not in the map; choose one of: {', '.join(_LEVELS)}")
    _, y_name, x_name = (str(name) for name in data["decay"].dims)
    for name in (x_name, y_name):
        if data.sizes[name] < 2:
            raise InputError(f"the map has one value of {name}; a picture needs two or more")
    labels = [str(label) for label in data["observer"].values]
    columns = min(len(labels), 3)
    rows = -(-len(labels) // columns)
    figure, axes = new_figure(rows, columns, width=2.6 + 2.4 * columns, height=0.9 + 2.5 * rows, squeeze=False, sharex=True,
                              sharey=True)
    with style():
        look = _look(data, quantity)
        for ax, label in zip(axes.flat, labels, strict=False):
            mesh = _panel(ax, data.sel(observer=label), quantity, x_name, y_name, look)
            ax.set_title(label)
        for ax in axes.flat[len(labels):]:
            ax.set_axis_off()
        for k in range(columns):
            axes[(len(labels) - 1 - k) // columns, k].set_xlabel(_label(data[x_name]))
            axes[(len(labels) - 1 - k) // columns, k].tick_params(labelbottom=True)
        for row in axes:
            row[0].set_ylabel(_label(data[y_name], 26))
        bar = figure.colorbar(mesh, ax=axes, label=_label(data[quantity]), extend="both" if quantity == "decay" else "neither")
        if quantity == "settling_time":
            low, high = look["norm"].vmin, look["norm"].vmax
            bar.set_ticks([level for level in _LEVELS[quantity] if low <= level <= high])
            bar.ax.yaxis.set_minor_formatter(NullFormatter())
        bar.ax.yaxis.set_major_formatter("{x:g}")
        figure.legend(*_key(data), loc="outside upper left", ncols=3, frameon=False, alignment="left", title=title or None)
    return figure


def _look(data: xr.Dataset, quantity: str) -> dict[str, Any]:
    from matplotlib.colors import LogNorm, Normalize

    values = data[quantity].values
    if quantity == "decay":
        largest = max(float(np.nanmax(values, initial=0.0)), 1e-3)
        return {"norm": Normalize(-largest, largest), "cmap": "PuOr"}
    if quantity == "damping":
        return {"norm": Normalize(0.0, 1.0), "cmap": "cividis"}
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.1, 1.0)
    return {"norm": LogNorm(low, max(high, 1.001 * low)), "cmap": "cividis_r"}


def _panel(ax: Axes, part: xr.Dataset, quantity: str, x_name: str, y_name: str, look: dict[str, Any]) -> Any:
    x, y, decay = part[x_name].values, part[y_name].values, part["decay"].values
    values = part[quantity].where(part["decay"] > 0).values if quantity != "decay" else decay
    ax.grid(False)
    if not np.all(np.isfinite(decay)):
        ax.fill_between(x[[0, -1]], y[0], y[-1], zorder=0, **_NOWHERE)
    mesh = ax.pcolormesh(x, y, np.ma.masked_invalid(values), shading="nearest", rasterized=True, **look)
    low, high = np.nanmin(values, initial=np.inf), np.nanmax(values, initial=0.0)
    inside = [level for level in _LEVELS[quantity] if low < level < high]
    if inside:
        lines = ax.contour(x, y, np.ma.masked_invalid(values), levels=inside, colors=_INK, linewidths=0.7)
        ax.clabel(lines, fontsize=points(7), fmt="%g")
    if np.nanmin(decay) < 0:
        ax.contourf(x, y, decay, levels=[np.nanmin(decay) - 1.0, 0.0], colors="none", hatches=[_UNSTABLE])
        if np.nanmax(decay) > 0:
            ax.contour(x, y, decay, levels=[0.0], colors=_INK, linewidths=2.2)
    return mesh


def _key(data: xr.Dataset) -> tuple[list[Any], list[str]]:
    """Handles and texts for what the map shows besides shades."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    decay = data["decay"].values
    shown = [
        (np.nanmin(decay) < 0 < np.nanmax(decay), Line2D([], [], color=_INK, linewidth=2.2), "limit of stability"),
        (np.nanmin(decay) < 0, Patch(facecolor="none", edgecolor=_INK, hatch=_UNSTABLE, linewidth=0.4), "unstable"),
        (bool(np.isnan(decay).any()), Patch(**_NOWHERE),
         "no state at rest"),
    ]
    return [handle for is_there, handle, _ in shown if is_there], [text for is_there, _, text in shown if is_there]


def _label(variable: Any, width: int = 60) -> str:
    """Words up to the first comma, in lines of this width, then symbol and unit."""
    return with_words("\n".join(wrap(variable.attrs["long_name"].partition(",")[0], width)), variable)
