"""Pictures of pole sweeps: against the swept parameter, paths or points in the s-plane. Data in, figure out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.drawing import LIMIT, Line, line, new_figure, points, style
from imo_analysis.errors import InputError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def swept_name(data: xr.Dataset) -> str:
    """The dimension that was swept."""
    names = [str(name) for name in data["re"].dims if name not in ("branch", "observer")]
    if len(names) != 1:
        raise InputError(f"a pole map needs one swept dimension, and the data set has {names}")
    return names[0]


def _observers(data: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    if "observer" not in data.dims:
        return [(str(data.attrs.get("observer", "observer")), data)]
    return [(str(label), data.sel(observer=label)) for label in data["observer"].values]


def _axis_label(variable: Any) -> str:
    """Words, symbol and unit of a swept quantity."""
    return with_words(variable.attrs.get("long_name", variable.name), variable)


def with_words(words: str, variable: Any) -> str:
    """Words, then symbol and unit; these alone of a gain of a user's own, of which no words are known but its name."""
    return symbol_and_unit(variable) if words == variable.name else f"{words} {symbol_and_unit(variable)}"


def symbol_and_unit(variable: Any) -> str:
    """What an axis carries at the least: the symbol of a variable with its unit in brackets."""
    unit = variable.attrs.get("units", "1")
    return f"${variable.attrs.get('latex', variable.name)}$" + ("" if unit == "1" else f" ({unit})")


def plot_against(data: xr.Dataset, title: str = "") -> Figure:
    """Real and imaginary parts of the poles against the swept parameter, one line style an observer.

    Parameters
    ----------
    data : xarray.Dataset
        From `imo_analysis.pencils.sweep.pole_sweep`, over one parameter.
    title : str
        Above the picture.
    """
    from matplotlib.ticker import StrMethodFormatter, SymmetricalLogLocator

    over = swept_name(data)
    styles = _styles(data)
    figure, axes = new_figure(1, 2, width=7.6, height=3.6)
    with style():
        for label, part in _observers(data):
            look = styles[label].kwargs()
            for n, branch in enumerate(part["branch"].values):
                one = part.sel(branch=branch)
                text = label if n == 0 else None
                still = bool(one["neutral"]) if "neutral" in part.coords else False
                re, im = one["re"].values, one["im"].values
                gaps = np.flatnonzero(_jumps(data[over].values, re, im)) + 1
                values, re, im = (np.insert(column.astype(float), gaps, np.nan) for column in (data[over].values, re, im))
                look["linewidth"] = 0.7 if still else 1.4
                look["marker"] = styles[label].marker if len(values) == 1 else ""
                axes[0].plot(values, re, label=text, **look)
                axes[1].plot(values, im, **look)
        axes[0].axhline(0.0, color=LIMIT.color, linewidth=0.8)
        axes[0].set_yscale("symlog", linthresh=10.0, linscale=0.6)  # slow and fast poles differ by two decades
        axes[0].yaxis.set_major_locator(SymmetricalLogLocator(base=10.0, linthresh=10.0, subs=[1.0, 3.0]))
        axes[0].yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        for ax, quantity in zip(axes, ("re", "im"), strict=True):
            ax.set_xlabel(_axis_label(data[over]))
            ax.set_ylabel(f"{'real' if quantity == 're' else 'imaginary'} part ({data[quantity].attrs['units']})")
        figure.legend(loc="outside upper left", ncols=4, frameon=False, title=title or None, alignment="left")
    return figure


def _styles(data: xr.Dataset) -> dict[str, Line]:
    """Each observer's own line; numbered lines where two of them would look alike."""
    labels = [label for label, _ in _observers(data)]
    kinds = [str(kind) for kind in data["observer_kind"].values] if "observer_kind" in data.coords else labels
    own = [line(kind) for kind in kinds]
    if len(set(own)) < len(own):
        own = [line(n) for n in range(len(own))]
    return dict(zip(labels, own, strict=True))


def _jumps(values: np.ndarray, re: np.ndarray, im: np.ndarray) -> np.ndarray:
    """Which steps are jumps: where the direction of rotation changes, poles move with the sign that the observer is told."""
    step = np.abs(np.diff(re + 1j * im))
    turns = np.signbit(values[1:]) != np.signbit(values[:-1])
    return turns & (step > 10 * np.median(step) + 1e-9) if len(step) else turns


def plot_plane(
    data: xr.Dataset, title: str = "", marks: Any = None, printed: xr.Dataset | None = None, contours: str = ""
) -> Figure:
    """Paths of the poles in the s-plane, a panel an observer, coloured by the swept parameter, arrows towards its rise.

    Where the slow poles would be one spot beside the fast ones, a window shows them larger.

    Parameters
    ----------
    data : xarray.Dataset
        From `pole_sweep`, over one parameter.
    title : str
        Above the picture.
    marks : sequence of float, optional
        Values of the swept parameter that get a marker where the data set has them. Where left out: 30, 60 and 100 rad/s
        for a sweep over the speed, and both ends and the middle for any other.
    printed : xarray.Dataset, optional
        From `imo_analysis.pencils.table2.table2`: the printed eigenvalues are drawn as crosses in the panel of their observer.
    contours : str
        ``damping`` for rays of constant damping ratio behind the paths, ``settling_time`` for lines of constant time to 2 %.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    over = swept_name(data)
    observers = _observers(data)
    columns = min(len(observers), 3)
    rows = -(-len(observers) // columns)
    figure, axes = new_figure(rows, columns, width=2.4 + 2.6 * columns, height=0.7 + 3.1 * rows, squeeze=False)
    values = data[over].values
    if marks is None:
        marks = (30.0, 60.0, 100.0) if over == "omega" else tuple(values[[0, len(values) // 2, -1]])
    colours = Normalize(float(values.min()), float(values.max()) if len(values) > 1 else float(values.min()) + 1.0)
    with style():
        mapping = ScalarMappable(colours, "cividis")
        for ax, (label, part) in zip(axes.flat, observers, strict=False):
            for branch in part["branch"].values:
                one = part.sel(branch=branch)
                if "neutral" in part.coords and bool(one["neutral"]):
                    ax.plot(one["re"].values[[0, -1]], one["im"].values[[0, -1]], "+", color="#1a1a1a", markersize=7, zorder=3)
                else:
                    _path(ax, one, values, mapping, marks)
            if printed is not None and label in printed["observer"].values:
                cells = printed.sel(observer=label)
                ax.plot(cells["printed_re"].values.ravel(), cells["printed_im"].values.ravel(), "x", color="#D55E00",
                        markersize=6, markeredgewidth=1.4, label="printed in Table II", zorder=4)
            ax.axvline(0.0, color=LIMIT.color, linewidth=0.8)
            ax.set_title(label)
            ax.set_xlabel("real part (1/s)")
            ax.margins(0.08)
            if contours:
                _contours(ax, contours)
            _window(ax, part, values, mapping, marks, contours)
        for ax in axes.flat[len(observers):]:
            ax.set_axis_off()
        for row in axes:
            row[0].set_ylabel("imaginary part (rad/s)")
        handles, labels = _key(marks, over, data)
        shown = [ax for ax in axes.flat if ax.get_legend_handles_labels()[1]]
        if shown:
            more, names = shown[0].get_legend_handles_labels()
            handles, labels = [*handles, *more[:1]], [*labels, *names[:1]]
        if handles:
            figure.legend(handles, labels, loc="outside upper left", ncols=2 * columns, frameon=False, title=title or None,
                          alignment="left", columnspacing=1.2)
        if len(values) > 1:
            figure.colorbar(mapping, ax=axes, label=symbol_and_unit(data[over]), shrink=0.85, pad=0.02)
    return figure


_SPOT = (0.12, 0.15)  # shares of a panel's width and height: poles within are one spot to the eye
_WINDOW = (0.44, 0.36)  # width and height of the window on them
_AROUND = (0.16, 0.11, 0.02, 0.03)  # what its labels need to the left and below, and air to the right and above


def _window(ax: Axes, part: xr.Dataset, values: np.ndarray, mapping: Any, marks: Any, contours: str) -> None:
    """A window on the poles next to the origin where they are one spot in the panel, in a place that no path touches."""
    whole = part.where(~part["neutral"], drop=True) if "neutral" in part.coords else part
    whole = whole.dropna("branch")
    size = np.abs(whole["re"].values + 1j * whole["im"].values).max(axis=0, initial=0.0)
    slow = whole.isel(branch=np.flatnonzero(size < 0.15 * size.max(initial=0.0)))
    limits = np.array([ax.get_xlim(), ax.get_ylim()])

    def shares(data: xr.Dataset) -> np.ndarray:
        places = np.stack([data["re"].values.ravel(), data["im"].values.ravel()])
        return (places - limits[:, :1]) / np.diff(limits)

    if slow.sizes["branch"] == 0 or np.any(np.ptp(shares(slow), axis=-1) > _SPOT):
        return
    there = shares(whole)
    for y in (0.58, 0.34, 0.14):
        for x in (0.3, 0.18, 0.5):
            inside = ((there[0] > x - _AROUND[0]) & (there[0] < x + _WINDOW[0] + _AROUND[2])
                      & (there[1] > y - _AROUND[1]) & (there[1] < y + _WINDOW[1] + _AROUND[3]))
            if not inside.any():
                break
        else:
            continue
        break
    else:
        return
    window = ax.inset_axes((x, y, *_WINDOW))
    for branch in slow["branch"].values:
        _path(window, slow.sel(branch=branch), values, mapping, marks)
    window.axvline(0.0, color=LIMIT.color, linewidth=0.8)
    window.margins(0.12)
    window.tick_params(labelsize=points(7))
    window.locator_params(nbins=4)
    for side in ("top", "right"):
        window.spines[side].set_visible(True)
    if contours == "settling_time":  # the rays of damping crowd here
        _contours(window, contours)
    ax.indicate_inset_zoom(window, edgecolor=LIMIT.color, linewidth=0.6)


def _contours(ax: Axes, quantity: str) -> None:
    """Rays of constant damping ratio or lines of constant settling time, labelled at the edge; the limits stay."""
    x, y = ax.get_xlim(), ax.get_ylim()
    look: dict[str, Any] = {"color": LIMIT.color, "linewidth": 0.6, "linestyle": (0, (1, 2)), "zorder": 1}
    words: dict[str, Any] = {"fontsize": points(6.5), "color": "#4a4a4a", "clip_on": True}
    if quantity == "damping":
        last = (np.inf, np.inf)  # in shares of the panel
        for ratio in (0.9, 0.7, 0.5, 0.3, 0.1):
            slope = np.sqrt(1 - ratio**2) / ratio
            edge = max(x[0], -y[1] / slope)
            for sign in (1.0, -1.0):
                ax.plot([0.0, 2 * edge], [0.0, -2 * sign * slope * edge], **look)
            at = (0.97 * edge, -0.97 * slope * edge)
            here = (at[0] / (x[1] - x[0]), at[1] / (y[1] - y[0]))
            if max(abs(here[0] - last[0]), abs(here[1] - last[1])) > 0.07:  # the steep ones crowd at the axis
                ax.text(*at, f"{ratio:g}", ha="left", va="top", **words)
                last = here
    else:
        for time in (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0):
            at = -np.log(50.0) / time
            if x[0] < at and abs(at) > 0.06 * (x[1] - x[0]):  # the slowest crowd at the axis
                ax.axvline(at, **look)
                ax.text(at, y[0] + 0.02 * (y[1] - y[0]), f" {time:g} s", rotation=90, ha="left", va="bottom", **words)
    ax.set_xlim(x)
    ax.set_ylim(y)


def plot_points(data: xr.Dataset, title: str = "") -> Figure:
    """The poles of a cloud, or of a grid over two parameters, as points in the s-plane, a panel an observer.

    The colour is the first swept parameter; a dark ring marks poles in the right half plane.

    Parameters
    ----------
    data : xarray.Dataset
        From `imo_analysis.pencils.sweep.pole_sweep`, over two parameters or a cloud.
    title : str
        Above the picture.
    """
    from matplotlib.lines import Line2D

    first = str(data.attrs["over"]).split(", ")[0]
    observers = _observers(data)
    columns = min(len(observers), 3)
    rows = -(-len(observers) // columns)
    figure, axes = new_figure(rows, columns, width=2.4 + 2.6 * columns, height=0.7 + 3.1 * rows, squeeze=False)
    unstable = False
    with style():
        for ax, (label, part) in zip(axes.flat, observers, strict=False):
            moving = part.where(~part["neutral"], drop=True) if "neutral" in part.coords else part
            colour, x, y = (values.values.ravel() for values in _broadcast(part[first], moving["re"], moving["im"]))
            points = ax.scatter(x, y, c=colour, s=5.0, cmap="cividis", linewidths=0.0, rasterized=len(x) > 2000,
                                zorder=2)
            bad = x > 1e-9 * np.nanmax(np.hypot(x, y))
            unstable |= bool(bad.any())
            ax.scatter(x[bad], y[bad], s=14.0, zorder=1, facecolors="none", edgecolors="#1a1a1a", linewidths=0.5,
                       rasterized=len(x) > 2000)
            ax.axvline(0.0, color=LIMIT.color, linewidth=0.8)
            ax.set_title(label)
            ax.set_xlabel("real part (1/s)")
        for ax in axes.flat[len(observers):]:
            ax.set_axis_off()
        for row in axes:
            row[0].set_ylabel("imaginary part (rad/s)")
        figure.colorbar(points, ax=axes, label=symbol_and_unit(data[first]), shrink=0.85, pad=0.02)
        ring = Line2D([], [], linestyle="none", marker="o", markersize=4, markerfacecolor="none", markeredgecolor="#1a1a1a")
        if title or unstable:
            figure.legend(*(([ring], ["in the right half plane"]) if unstable else ([], [])), loc="outside upper left",
                          frameon=False, title=title or None, alignment="left")
    return figure


def _broadcast(*arrays: Any) -> tuple[Any, ...]:
    import xarray as xr

    return xr.broadcast(*arrays)


def _path(ax: Axes, one: xr.Dataset, values: np.ndarray, mapping: Any, marks: Any) -> None:
    from matplotlib.collections import LineCollection

    x, y = one["re"].values, one["im"].values
    if not np.all(np.isfinite(x)):
        return
    points = np.column_stack([x, y])
    ax.update_datalim(points)
    if len(points) > 1:
        segments = np.stack([points[:-1], points[1:]], axis=1)
        middle = 0.5 * (values[:-1] + values[1:])
        # the poles at -omega are those at omega: the wide line below shows beside the thin one above
        whole = ~_jumps(values, x, y)
        for part, width in ((whole & (middle < 0), 4.0), (whole & (middle >= 0), 1.4)):
            ax.add_collection(LineCollection(list(segments[part]), colors=mapping.to_rgba(middle[part]), linewidths=width))
        _arrow(ax, points)
    at = np.flatnonzero(np.isin(np.round(values, 9), np.round(np.asarray(marks, dtype=float), 9)))
    shapes = "os^Dv"
    for k in at:
        shape = shapes[list(np.round(marks, 9)).index(round(float(values[k]), 9)) % len(shapes)]
        ax.plot(x[k], y[k], shape, markersize=4.5, color=mapping.to_rgba(values[k]), markeredgecolor="#1a1a1a",
                markeredgewidth=0.7, zorder=3)
    ax.autoscale_view()


def _arrow(ax: Axes, points: np.ndarray) -> None:
    """An arrow head seven eighths along the path, in the direction in which the swept parameter rises."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    if length[-1] <= 1e-6 * max(1.0, float(np.abs(points).max())):
        return
    tip, tail = (points[min(int(np.searchsorted(length, share * length[-1])), len(points) - 1)] for share in (0.875, 0.8))
    ax.annotate("", xy=(tip[0], tip[1]), xytext=(tail[0], tail[1]), zorder=2.5,
                arrowprops={"arrowstyle": "-|>", "color": "#1a1a1a", "mutation_scale": 9, "linewidth": 0.6,
                            "shrinkA": 0, "shrinkB": 0})


def _key(marks: Any, over: str, data: xr.Dataset) -> tuple[list[Any], list[str]]:
    """Handles and texts for the marked values that the sweep holds."""
    from matplotlib.lines import Line2D

    unit = data[over].attrs.get("units", "1")
    sign = f"${data[over].attrs.get('latex', over)}$"
    have = [m for m in marks if np.any(np.isclose(data[over].values, m, atol=1e-9))]
    handles = [
        Line2D([], [], linestyle="none", marker="os^Dv"[list(marks).index(m) % 5], color="#cccccc", markeredgecolor="#1a1a1a",
               markersize=5) for m in have
    ]
    texts = [f"{sign} = {m:g}" + ("" if unit == "1" else f" {unit}") for m in have]
    if "neutral" in data.coords and bool(data["neutral"].any()):
        handles.append(Line2D([], [], linestyle="none", marker="+", color="#1a1a1a", markersize=7))
        texts.append("on the axis by structure")
    return handles, texts
