"""How fast the slowest error decays over two parameters at once: where an observer is stable, and by how much."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.pencils.error import Gains, OperatingPoint
from imo_analysis.pencils.jacobian import Kind
from imo_analysis.pencils.sweep import checked, described, evaluator

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Axis = tuple[str, Sequence[float] | np.ndarray]


def decay_map(
    machine: InductionMachine, observer: str, gains: Gains, x: Axis, y: Axis, point: OperatingPoint, kind: Kind = "frozen"
) -> xr.Dataset:
    """The slowest decay over a grid of two parameters.

    Parameters
    ----------
    machine, observer, gains, point, kind
        As in `imo_analysis.pencils.sweep.pole_sweep`.
    x, y : tuple of str and array of float
        Name and increasing values of each parameter: ``omega``, a machine field, a parameter, a gain, ``slip`` or ``flux``.

    Returns
    -------
    xarray.Dataset
        ``decay`` (1/s) over (y, x): minus the largest real part of the poles, negative where the observer is unstable; and
        ``damping`` (1), the least damping ratio. Poles that are neutral by structure are left out.

    Raises
    ------
    InputError
        For unknown names, the same name twice, or values that are not increasing numbers.
    """
    import xarray as xr

    (x_name, x_values), (y_name, y_values) = x, y
    if x_name == y_name:
        raise InputError(f"{x_name} is given for both axes of the map; choose two parameters")
    columns, rows = checked(x_values, x_name), checked(y_values, y_name)
    found = evaluator(machine, observer, gains, (x_name, y_name), point, kind)
    poles = found.moving((columns[None, :], rows[:, None]))
    size = np.abs(poles)
    ratio = np.divide(-poles.real, size, out=np.zeros_like(size), where=size > 0)
    dims = (y_name, x_name)
    return xr.Dataset(
        {
            "decay": (dims, -poles.real.max(axis=-1), {"units": "1/s", "long_name": "slowest decay", "latex": r"\delta"}),
            "damping": (dims, ratio.min(axis=-1), {"units": "1", "long_name": "least damping ratio", "latex": r"\zeta"}),
        },
        coords={x_name: (x_name, columns, described(x_name)), y_name: (y_name, rows, described(y_name))},
        attrs={"observer": observer, "kind": kind, "machine": machine.name},
    )


def plot_decay(data: xr.Dataset, title: str = "") -> Figure:
    """The map of `decay_map`: shades and labelled contours of the slowest decay, the stability boundary drawn heavy."""
    from matplotlib.colors import TwoSlopeNorm

    from imo_analysis.drawing import new_figure, style

    decay: Any = data["decay"]
    y_name, x_name = (str(name) for name in decay.dims)
    figure, ax = new_figure(width=5.6, height=3.9)
    with style():
        low, high = float(decay.min()), float(decay.max())
        norm = TwoSlopeNorm(0.0, min(low, -1e-3 * max(high, 1e-3)), max(high, 1e-3))
        mesh = ax.pcolormesh(data[x_name], data[y_name], decay, norm=norm, cmap="PuOr", shading="nearest", rasterized=True)
        levels = [level for level in (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0) if low < level < high]
        if levels:
            lines = ax.contour(data[x_name], data[y_name], decay, levels=levels, colors="#1a1a1a", linewidths=0.7)
            ax.clabel(lines, fontsize=7)
        if low < 0 < high:
            ax.contour(data[x_name], data[y_name], decay, levels=[0.0], colors="#1a1a1a", linewidths=2.2)
        for name, put in ((x_name, ax.set_xlabel), (y_name, ax.set_ylabel)):
            unit = data[name].attrs["units"]
            put(f"{data[name].attrs['long_name']} ${data[name].attrs['latex']}$" + ("" if unit == "1" else f" ({unit})"))
        ax.set_title(title or f"{data.attrs['observer']}: slowest decay; the heavy line is the limit of stability")
        ticks = np.unique([*np.linspace(min(low, 0.0), 0.0, 4), *np.linspace(0.0, max(high, 0.0), 4)])
        figure.colorbar(mesh, ax=ax, label="slowest decay (1/s), negative is unstable", ticks=ticks, format="%.3g")
    return figure
