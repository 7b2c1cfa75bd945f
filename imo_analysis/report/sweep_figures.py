"""The picture of a sweep: over which values of the swept fields does each observer hold?"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.drawing import line, new_figure, style
from imo_analysis.errors import InputError
from imo_analysis.notation import symbol

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

LINE = 0.5  # share of the runs at which the white line runs
BAND = (0.05, 0.95)  # shares of the runs below the lower and the upper edge of the band


def sweep_figure(data: xr.Dataset) -> Figure:
    """Draw a sweep.

    Parameters
    ----------
    data : xarray.Dataset
        As `sweeps.sweep.assembled` makes it.

    Returns
    -------
    matplotlib.figure.Figure
        With one swept number: the share of runs that hold, and the speed error, over it. With more: for each observer a map of
        that share over the first two, each cell shaded and, where it is neither all nor nothing, given in per cent.

    Raises
    ------
    InputError
        If no field of the sweep is a number.
    """
    fields = numeric_fields(data)
    if not fields:
        raise InputError("no field of the sweep is a number that varies; there is nothing to draw it over")
    with style():
        return _over_one(data, fields[0]) if len(fields) == 1 else _map(data, fields[0], fields[1])


def numeric_fields(data: xr.Dataset) -> list[str]:
    """Swept fields that are numbers and take more than one value."""
    return [str(name) for name, value in data.coords.items()
            if value.dims == ("run",) and name != "run" and value.dtype.kind in "fiu" and np.unique(value.values).size > 1]


def shares(data: xr.Dataset, observer: str, edges: list[Array], fields: list[str]) -> tuple[Array, Array]:
    """Share of the possible runs that hold in each cell between the edges, NaN in empty cells; and how many runs it has."""
    possible = data["possible"].values == 1
    points = [data[name].values[possible] for name in fields]
    count, _ = np.histogramdd(points, bins=edges)
    holds = data["holds"].sel(observer=observer).values[possible].astype(float)
    held, _ = np.histogramdd(points, bins=edges, weights=holds)
    with np.errstate(invalid="ignore", divide="ignore"):
        return held / count, count


def edges_of(values: Array, cells: int) -> Array:
    """Edges of cells: between the values of a grid, or equally wide."""
    distinct = np.unique(values)
    if distinct.size <= cells:
        middle = (distinct[1:] + distinct[:-1]) / 2
        return np.concatenate([[distinct[0] - (middle[0] - distinct[0])], middle, [distinct[-1] + (distinct[-1] - middle[-1])]])
    return np.linspace(distinct[0], distinct[-1], cells + 1)


def _scale(data: xr.Dataset, field: str) -> tuple[float, float, str]:
    """Factor, offset and label of an axis: in per cent off the study's value where it has one."""
    own = float(data[field].attrs.get("study_value", 0.0))
    unit, name = _unit(data, field), _name(field)
    if own and not field.startswith(("reference.", "load.", "initial.")) and ".errors." not in field:
        return 100.0 / own, -100.0, f"{name} off {own:.3g} {unit} by (%)"
    return 1.0, 0.0, f"{name} ({unit})" if unit else name


def _name(field: str) -> str:
    """The symbol of a parameter of the machine, else the dotted name, short enough for the side of a map."""
    table, _, key = field.rpartition(".")
    return f"${symbol(key).latex}$" if table == "machine" else field.removeprefix("observers.")


def _unit(data: xr.Dataset, field: str) -> str:
    unit = str(data[field].attrs.get("units", ""))
    return "" if unit == "1" else unit.replace("ohm", "Ω")


def _map(data: xr.Dataset, first: str, second: str) -> Figure:
    names = [str(name) for name in data["observer"].values]
    (x_factor, x_offset, x_label), (y_factor, y_offset, y_label) = _scale(data, first), _scale(data, second)
    cells = int(np.clip(np.sqrt(data.sizes["run"] / 20), 4, 20))
    edges = [edges_of(data[name].values[data["possible"].values == 1], cells) for name in (first, second)]
    figure, axes = new_figure(1, len(names), width=max(4.2, 2.5 * len(names) + 0.9), height=3.3, sharex=True, sharey=True,
                              squeeze=False)
    mesh: Any = None
    for axis, name in zip(axes[0], names, strict=True):
        share, _ = shares(data, name, edges, [first, second])
        x, y = edges[0] * x_factor + x_offset, edges[1] * y_factor + y_offset
        mesh = axis.pcolormesh(x, y, 100 * share.T, vmin=0, vmax=100, cmap="cividis", edgecolors="face", linewidth=0.2)
        if np.nanmax(share) > LINE > np.nanmin(share) and min(share.shape) > 3:
            axis.contour((x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2, np.nan_to_num(share.T), levels=[LINE], colors="white",
                         linewidths=1.2)
        possible = data["possible"].values == 1
        whole = float(data["holds"].sel(observer=name).values[possible].mean())
        axis.set_title(f"{name}: holds in {whole:.0%}")
        axis.grid(False)
        axis.set_xlabel(x_label if len(names) == 1 else "")
    if len(names) > 1:
        figure.supxlabel(x_label, fontsize="medium")
    axes[0][0].set_ylabel(y_label)
    bar = figure.colorbar(mesh, ax=list(axes[0]), shrink=0.95, pad=0.02)
    bar.set_label(f"runs in which it holds (%)\nwhite line: {100 * LINE:g} %")
    bar.outline.set_linewidth(0.5)
    return figure


def _over_one(data: xr.Dataset, field: str) -> Figure:
    names = [str(name) for name in data["observer"].values]
    factor, offset, label = _scale(data, field)
    possible = data["possible"].values == 1
    values = data[field].values[possible]
    edges = edges_of(values, int(np.clip(data.sizes["run"] / 50, 5, 40)))
    middle = (edges[1:] + edges[:-1]) / 2 * factor + offset
    cell = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    figure, (above, below) = new_figure(2, 1, height=4.6, sharex=True)
    for n, name in enumerate(names):
        look = line(name)
        share, _ = shares(data, name, [edges], [field])
        marks = {"marker": look.marker, "markevery": (n, max(1, len(middle) // 8))}
        above.plot(middle, 100 * share, label=name, **look.kwargs(), **marks)
        error = data["speed_rms"].sel(observer=name).values[possible]
        bands = np.array([_quantiles(error[cell == number]) for number in range(len(middle))])
        below.plot(middle, bands[:, 1], **look.kwargs(), **marks)
        below.fill_between(middle, bands[:, 0], bands[:, 2], color=look.color, alpha=0.15, linewidth=0)
    above.set_ylabel("runs in which it holds (%)")
    above.set_ylim(-4, 104)
    above.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, frameon=False, borderaxespad=0.2)
    below.set_yscale("log")
    below.set_ylabel(f"rms speed error (rad/s)\nmedian and {100 * BAND[0]:g} to {100 * BAND[1]:g} %")
    below.set_xlabel(label)
    return figure


def _quantiles(values: Array) -> Array:
    values = values[np.isfinite(values)]
    return np.quantile(values, [BAND[0], 0.5, BAND[1]]) if values.size else np.full(3, np.nan)
