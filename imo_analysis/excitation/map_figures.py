"""Figures of the identifiability maps, drawn from the data of `imo_analysis.excitation.maps`."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from imo_analysis import drawing as style
from imo_analysis.excitation.maps import CLASSES, classify

_LEVELS = (-4, -3.5, -3, -2.5, -2, -1.5, -1, -0.5, 0, 0.5, 1)
_LABELLED = (-4, -3, -2, -1, 0, 1)


def plot_speed_torque(constant: xr.Dataset, modulated: xr.Dataset) -> Any:
    """Four maps: omega and alpha, each with the other known at constant flux, and both unknown under modulation.

    Parameters
    ----------
    constant, modulated : xarray.Dataset
        From `speed_torque_map`, without and with flux modulation.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = style.new_figure(2, 2, width=7.4, height=6.2, sharex=True, sharey=True)
    depth, frequency = modulated.attrs["depth"], modulated.attrs["frequency"]
    swing = f"flux swings {100 * depth:g} %, {frequency:g} rad/s"
    panels = (
        (constant, "omega_alone", r"$\omega$, $\alpha$ known; constant flux"),
        (constant, "alpha_alone", r"$\alpha$, $\omega$ known; constant flux"),
        (modulated, "omega_both", rf"$\omega$, $\alpha$ unknown; {swing}"),
        (modulated, "alpha_both", rf"$\alpha$, $\omega$ unknown; {swing}"),
    )
    with style.style():
        for axis, (data, name, title) in zip(axes.flat, panels, strict=True):
            filled = _panel(axis, data, data[name])
            axis.set_title(title, fontsize=style.points(8.5))
        for axis in axes[1]:
            axis.set_xlabel(r"electrical speed $\omega$ (rad/s)")
        for axis in axes[:, 0]:
            axis.set_ylabel(r"torque $T_e$ (N m)")
        bar = figure.colorbar(filled, ax=axes, shrink=0.7, ticks=_LABELLED)
        bar.ax.set_yticklabels([f"$10^{{{k}}}$" for k in _LABELLED])
        bar.set_label(_measurement(constant))
        handles = [axes[0, 0].plot([], [], **_lost_line(kind))[0] for kind in _LOST_LINES]
        figure.legend(handles, ["zero stator frequency", "no load"], loc="outside upper left", ncols=2, frameon=False)
    return figure


_LOST_LINES = ("-", "--")


def _lost_line(linestyle: str) -> dict[str, Any]:
    """White with a dark edge: seen on light and on dark."""
    from matplotlib.patheffects import withStroke

    edge = withStroke(linewidth=3.0, foreground="black")
    return {"color": "white", "linestyle": linestyle, "lw": 1.4, "path_effects": [edge]}


def _measurement(data: xr.Dataset) -> str:
    return (f"smallest standard deviation (rad/s or 1/s)\ncurrent noise {data.attrs['noise']:g} A, "
            f"{data.attrs['rate'] / 1000:g} kHz, {data.attrs['duration']:g} s")


def _panel(axis: Any, data: xr.Dataset, values: xr.DataArray) -> Any:
    x, y = data["omega"].values, data["torque"].values
    logarithm = np.clip(np.log10(np.where(np.isfinite(values.values), values.values, 1e9)), _LEVELS[0], _LEVELS[-1]).T
    filled = axis.contourf(x, y, logarithm, levels=_LEVELS, cmap="YlGnBu")
    lines = axis.contour(x, y, logarithm, levels=_LABELLED[1:-1], colors="black", linewidths=0.6, linestyles="-")
    axis.clabel(lines, fmt=lambda level: f"$10^{{{round(level)}}}$", fontsize=style.points(7))
    for which, kind in zip(("stator_frequency", "slip"), _LOST_LINES, strict=True):
        zero = data[which].broadcast_like(data["slip"]).transpose("omega", "torque").values.T
        for path in _zero_lines(x, y, zero):
            axis.plot(path[:, 0], path[:, 1], **_lost_line(kind))
    axis.grid(False)
    return filled


def _zero_lines(x: Any, y: Any, values: Any) -> list[Any]:
    """Lines on which a quantity is zero, as arrays of points."""
    from contourpy import contour_generator

    return list(contour_generator(x, y, values).lines(0.0))


def plot_kinds(constant: xr.Dataset, modulated: xr.Dataset, within: tuple[float, float]) -> Any:
    """Which of omega and alpha can be known to an accuracy, at constant flux and under modulation.

    Parameters
    ----------
    constant, modulated : xarray.Dataset
        From `speed_torque_map`.
    within : tuple of 2
        Standard deviations of alpha (1/s) and omega (rad/s) that count as known.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap

    figure, axes = style.new_figure(1, 2, width=7.4, height=3.4, sharex=True, sharey=True)
    colours, count = ListedColormap(_KINDS), len(CLASSES)
    norm = BoundaryNorm(np.arange(count + 1) - 0.5, count)
    depth, frequency = modulated.attrs["depth"], modulated.attrs["frequency"]
    with style.style():
        for axis, data, title in ((axes[0], constant, "constant flux"),
                                  (axes[1], modulated, f"flux swings {100 * depth:g} %, {frequency:g} rad/s")):
            kind = classify(data["omega_alone"], data["alpha_alone"], data["omega_both"], data["alpha_both"], within)
            x, y = data["omega"].values, data["torque"].values
            drawn = axis.pcolormesh(x, y, kind.T, cmap=colours, norm=norm, shading="nearest")
            for which, look in zip(("stator_frequency", "slip"), _LOST_LINES, strict=True):
                zero = data[which].broadcast_like(data["slip"]).transpose("omega", "torque").values.T
                for path in _zero_lines(x, y, zero):
                    axis.plot(path[:, 0], path[:, 1], **_lost_line(look))
            axis.set(title=title, xlabel=r"electrical speed $\omega$ (rad/s)", xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
            axis.grid(False)
        axes[0].set_ylabel(r"torque $T_e$ (N m)")
        bar = figure.colorbar(drawn, ax=axes, ticks=range(count))
        bar.ax.set_yticklabels(CLASSES)
        handles = [axes[0].plot([], [], **_lost_line(look))[0] for look in _LOST_LINES]
        figure.legend(handles, ["zero stator frequency", "no load"], loc="outside upper left", ncols=2, frameon=False)
    return figure


_KINDS = ("#1d2d50", "#3b6fa0", "#c8553d", "#b9c6c9", "#f2e6b1")  # from dark to light; colour-blind readers tell them apart


def plot_modulation(data: xr.Dataset) -> Any:
    """Bounds of alpha and omega over depth and frequency of the flux modulation.

    Parameters
    ----------
    data : xarray.Dataset
        From `modulation_map`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = style.new_figure(1, 2, width=7.4, height=3.3, sharex=True, sharey=True)
    with style.style():
        x, y = data["frequency"].values, 100 * data["depth"].values
        for axis, name, symbol in zip(axes, ("alpha_both", "omega_both"), (r"$\alpha$", r"$\omega$"), strict=True):
            values = data[name].values
            logarithm = np.clip(np.log10(np.where(np.isfinite(values), values, 1e9)), _LEVELS[0], _LEVELS[-1])
            filled = axis.contourf(x, y, logarithm, levels=_LEVELS, cmap="YlGnBu")
            lines = axis.contour(x, y, logarithm, levels=_LEVELS, colors="black", linewidths=0.5, linestyles="-")
            axis.clabel(lines, levels=[k for k in _LABELLED if k in lines.levels],
                        fmt=lambda level: f"$10^{{{round(level)}}}$", fontsize=style.points(7))
            axis.set(xscale="log", yscale="log", xlabel="frequency of the modulation (rad/s)")
            axis.set_title(f"{symbol}, with the other unknown", fontsize=style.points(8.5))
            axis.grid(False)
        axes[0].set_ylabel("depth of the modulation (%)")
        figure.suptitle(rf"$\omega$ = {data.attrs['omega']:g} rad/s, torque {data.attrs['torque']:g} N m", x=0.02, ha="left",
                        fontsize=style.points(9))
        bar = figure.colorbar(filled, ax=axes, ticks=_LABELLED)
        bar.ax.set_yticklabels([f"$10^{{{k}}}$" for k in _LABELLED])
        bar.set_label(_measurement(data), fontsize=style.points(7.5))
    return figure
