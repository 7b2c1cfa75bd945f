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
    axis.set_title(f"{CONDITIONS[name].title}: {result.attrs['observer']}, T = {result.attrs['window']:g} s", pad=18)
    style.legend_above(axis, ncols=count + 2, handlelength=1.6, columnspacing=0.9)


def plot_resting(data: xr.Dataset) -> Any:
    """alpha_hat beside its prediction, and the error of the reconstructed flux.

    Parameters
    ----------
    data : xarray.Dataset
        From `imo_analysis.excitation.resting.explain`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, (top, bottom) = style.new_figure(2, 1, width=7.2, height=4.6, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    with style.style():
        simulated, predicted, truth = style.line(data.attrs["observer"]), style.Line("#1a1a1a", (0, (1, 2)), "x"), style.TRUTH
        name = data.attrs["observer"]
        top.plot(data["time"], data["alpha_hat"], **simulated.kwargs(), label=rf"$\hat\alpha$ simulated, {name}")
        top.plot(data["late"], data["predicted"], **predicted.kwargs(), label=r"$\hat\alpha$ predicted from the motion")
        top.plot(data["step_time"], data["step_alpha_hat"], "D", ms=5, mfc="white", mec="black", zorder=5,
                 label="predicted from the study alone")
        top.axhline(data.attrs["alpha"], color=truth.color, lw=0.9, linestyle=(0, (1, 1.5)), label=r"true $\alpha$")
        top.set_ylabel(r"$\hat\alpha$ (1/s)")
        style.legend_above(top, ncols=2)
        bottom.semilogy(data["time"], np.maximum(data["flux_error"], 1e-9), **simulated.kwargs())
        bottom.set(xlabel="time (s)", ylabel="flux error (Wb)")
    return figure


def plot_duty(run: xr.Dataset, alpha: float) -> Any:
    """alpha_hat of several observers over a long run.

    Parameters
    ----------
    run : xarray.Dataset
        With ``alpha_hat`` on (observer, time).
    alpha : float
        The true value, in 1/s.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, (whole, near) = style.new_figure(2, 1, width=7.2, height=4.6, sharex=True)
    with style.style():
        for number, name in enumerate(run["observer"].values):
            values = run["alpha_hat"].sel(observer=name).values
            if np.isfinite(values).any():
                for axis in (whole, near):
                    axis.plot(run["time"], values, **style.line(number).kwargs(), lw=0.9, label=str(name))
        for axis in (whole, near):
            axis.axhline(alpha, color=style.TRUTH.color, lw=0.9, linestyle=(0, (1, 1.5)), label=r"true $\alpha$")
            axis.set_ylabel(r"$\hat\alpha$ (1/s)")
        whole.set_ylim(0, 1.5 * alpha)
        near.set(xlabel="time (s)", ylim=(0.94 * alpha, 1.06 * alpha))
        near.set_title("the same, within 6 % of the true value")
        style.legend_above(whole, ncols=5)
    return figure
