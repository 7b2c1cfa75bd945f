"""Figures of runs: speed and its error over the whole run and in a window, alpha_hat, and the flux error.

Each takes the run as `imo_analysis.simulation.run.simulate` gives it and returns a matplotlib figure.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.drawing import LIMIT, TRUTH, in_style, legend_above, line, new_figure, points

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_COLUMNS = 800  # columns of pixels that a figure can show
_BLOCKS, _LEAST = 240, 20  # pieces of a noisy line, and samples in one at least
_NOISY = 4.0  # times as wide within a piece as from one to the next
_SEEN = 0.02  # of the line's range: a narrower band would not be seen


def thinned(time: NDArray[np.float64], values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The lowest and highest sample of each column of pixels, in their order in time, so that no peak is lost."""
    size = len(time)
    step = size // _COLUMNS
    if step < 3:
        return time, values
    columns = size // step
    blocks = values[: columns * step].reshape(columns, step)
    filled = np.where(np.isfinite(blocks), blocks, 0.0)
    picks = np.stack([filled.argmin(axis=1), filled.argmax(axis=1)], axis=1)
    picks.sort(axis=1)
    index = np.unique(np.concatenate([(picks + step * np.arange(columns)[:, None]).ravel(), [0, size - 1]]))
    return time[index], values[index]


def banded(time: NDArray[np.float64], values: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...] | None:
    """Time, mean, lowest and highest value of pieces of a noisy line; None for a line that is smooth enough to be drawn."""
    blocks = min(_BLOCKS, len(time) // _LEAST)
    if blocks < _LEAST or not np.isfinite(values).all():
        return None
    step = len(time) // blocks
    pieces = values[: blocks * step].reshape(blocks, step)
    mean, low, high = pieces.mean(axis=1), pieces.min(axis=1), pieces.max(axis=1)
    width = float(np.median(high - low))
    if width <= _NOISY * float(np.median(np.abs(np.diff(mean)))) or width <= _SEEN * float(np.ptp(mean)):
        return None
    return time[: blocks * step].reshape(blocks, step).mean(axis=1), mean, low, high


def noisy(run: xr.Dataset) -> bool:
    """Whether a figure of the run's speed errors has bands."""
    error = (run["omega"] - run["omega_hat"]).transpose("observer", "time").values
    return any(banded(run["time"].values, one) is not None for one in error)


def _part(run: xr.Dataset, window: tuple[float, float] | None) -> xr.Dataset:
    return run if window is None else run.sel(time=slice(*window))


def _plot(axes: Any, run: xr.Dataset, values: Any, **kwargs: Any) -> None:
    time, values = run["time"].values, np.asarray(values)
    band = banded(time, values)
    if band is None:
        axes.plot(*thinned(time, values), **kwargs)
        return
    at, mean, low, high = band
    drawn, = axes.plot(at, mean, **kwargs)
    axes.fill_between(at, low, high, color=drawn.get_color(), alpha=0.18, linewidth=0)


@in_style
def speed_figure(run: xr.Dataset, window: tuple[float, float] | None = None, observers: Sequence[str] = ()) -> Figure:
    """True and estimated speed above, the error of each estimate below.

    Parameters
    ----------
    run : xarray.Dataset
    window : (float, float), optional
        First and last time in s; the whole run without it.
    observers : sequence of str, optional
        Which observers; all of the run without it.
    """
    part = _part(run, window)
    names = list(observers) or [str(name) for name in run["observer"].values]
    figure, (above, below) = new_figure(2, 1, height=4.0, sharex=True, gridspec_kw={"height_ratios": [1.35, 1]})
    omega = part["omega"].values
    _plot(above, part, omega, label="true", zorder=1.5, linewidth=2.4, color="#b5b5b5")
    for name in names:
        estimate = part["omega_hat"].sel(observer=name).values
        _plot(above, part, estimate, label=name, **line(name).kwargs())
        _plot(below, part, omega - estimate, **line(name).kwargs())
    below.axhline(0.0, color=TRUTH.color, linewidth=0.6)
    above.set_ylabel("speed (rad/s)")
    below.set_ylabel("true − estimate (rad/s)")
    below.set_xlabel("time (s)")
    _speed_limits(above, omega, [part["omega_hat"].sel(observer=name).values for name in names])
    _robust_limits(below, [omega - part["omega_hat"].sel(observer=name).values for name in names], 0.15)
    above.margins(x=0.01)
    legend_above(above)
    return figure


def _speed_limits(axes: Any, omega: NDArray[np.float64], estimates: Sequence[NDArray[np.float64]]) -> None:
    """Limits that show the true speed whole, and of the estimates what is within so much of it again."""
    low, high = float(np.nanmin(omega)), float(np.nanmax(omega))
    span = max(high - low, 0.02 * max(abs(low), abs(high)), 1e-6)
    _robust_limits(axes, [omega, *(np.clip(one, low - span, high + span) for one in estimates)], 0.12)


def _robust_limits(axes: Any, series: Sequence[NDArray[np.float64]], room: float) -> None:
    """Limits from the bulk of the data, so that the start-up transient does not flatten the rest; a peak may leave the axes."""
    finite = np.concatenate([one[np.isfinite(one)] for one in series])
    if finite.size == 0:
        return
    low, high = np.quantile(finite, [0.001, 0.999])
    span = max(high - low, 1e-6 * max(abs(low), abs(high), 1.0))
    axes.set_ylim(low - room * span, high + room * span)


@in_style
def alpha_figure(run: xr.Dataset, true_alpha: float, marks: dict[str, float], observers: Sequence[str]) -> Figure:
    """alpha_hat over time, the speed below it, with the true value and other values (``marks``) as lines."""
    figure, (above, below) = new_figure(2, 1, height=4.0, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    above.axhline(true_alpha, color=TRUTH.color, linewidth=1.0)
    end = float(run["time"].values[-1])
    above.annotate(f"true {true_alpha:.4g}", (end, true_alpha), ha="right", va="bottom", fontsize=points(8))
    for label, value in marks.items():
        above.axhline(value, color=LIMIT.color, linestyle=LIMIT.linestyle, linewidth=1.0)
        above.annotate(f"{label} {value:.4g}", (end, value), ha="right", va="bottom", fontsize=points(8), color="#555555")
    for name in observers:
        _plot(above, run, run["alpha_hat"].sel(observer=name).values, label=name, **line(name).kwargs())
    _plot(below, run, run["omega"].values, color=TRUTH.color)
    above.set_ylabel(r"$\hat{\alpha}$ (1/s)")
    below.set_ylabel("speed (rad/s)")
    below.set_xlabel("time (s)")
    above.margins(x=0.01, y=0.12)
    legend_above(above)
    return figure


@in_style
def flux_error_figure(run: xr.Dataset, observers: Sequence[str]) -> Figure:
    """Length of the error of the reconstructed rotor flux, of z and of xi over time, relative to the flux (z: to z)."""
    figure, axes = new_figure(height=2.9)
    size = np.hypot(run["phi_dr"].values, run["phi_qr"].values)
    reference = float(np.nanmedian(size)) or 1.0
    for name in observers:
        one = run.sel(observer=name)
        error = np.hypot(
            (one["phi_dr"] - one["phi_dr_hat"]).values, (one["phi_qr"] - one["phi_qr_hat"]).values) / reference
        _plot(axes, run, 100 * error, label=name, **line(name).kwargs())
    axes.set_yscale("log")
    axes.set_ylabel("flux error (% of flux)")
    axes.set_xlabel("time (s)")
    axes.margins(x=0.01)
    legend_above(axes)
    return figure
