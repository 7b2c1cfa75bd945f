"""Figures of the excitation along a run, drawn from the data that `imo_analysis.excitation.trajectory` computes."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from imo_analysis import drawing as style
from imo_analysis.excitation.conditions import CONDITIONS
from imo_analysis.excitation.words import conditions_in

_FLOOR = 1e-10  # below it is rounding


def plot_excitation(result: xr.Dataset) -> Any:
    """Eigenvalues over time of each condition, with the threshold and the windows in which it holds.

    Parameters
    ----------
    result : xarray.Dataset
        From `imo_analysis.excitation.trajectory.excitation`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    names = conditions_in(result)
    figure, axes = style.new_figure(len(names), 1, width=7.2, height=0.4 + 2.2 * len(names), sharex=True, squeeze=False)
    with style.style():
        for axis, name in zip(axes[:, 0], names, strict=True):
            _draw(axis, result, name)
        axes[-1, 0].set_xlabel("end of the window, $t+T$ (s)")
    return figure


def _draw(axis: Any, result: xr.Dataset, name: str) -> None:
    time = result["time"].values
    values = np.maximum(result[f"{name}_eigenvalue"].values, _FLOOR)
    count = values.shape[1]
    for k in range(count):
        line = style.line(k)
        axis.semilogy(time, values[:, k], color=line.color, linestyle=line.linestyle, lw=1.1, label=rf"$\lambda_{k + 1}$")
    limit = style.LIMIT
    axis.semilogy(time, result.attrs["threshold"] * values[:, -1], color=limit.color, linestyle=limit.linestyle, lw=1.0,
                  label="threshold")
    holds = result[f"{name}_holds"].values.astype(bool)
    axis.fill_between(time, 0, 1, where=holds, transform=axis.get_xaxis_transform(), color="#bbbbbb", alpha=0.45, lw=0,
                      step="post", label="holds")
    axis.set_ylim(_FLOOR / 2, 30)
    axis.set_ylabel("eigenvalue (1)")
    axis.set_title(f"{CONDITIONS[name].title}: {result.attrs['observer']}, T = {result.attrs['window']:g} s",
                   pad=style.points(18))
    style.legend_above(axis, ncols=count + 2, handlelength=1.6, columnspacing=0.9)
