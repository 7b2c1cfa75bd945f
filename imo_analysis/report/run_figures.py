"""Figures of runs: speed and its error over the whole run and in a window, alpha_hat, and the flux error.

Each takes the run as `imo_analysis.simulation.run.simulate` gives it and returns a matplotlib figure.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.drawing import LIMIT, TRUTH, in_style, legend_above, line, new_figure, points
from imo_analysis.report.numbers import tidied

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_COLUMNS = 800  # columns of pixels that a figure can show
_BLOCKS, _LEAST = 240, 20  # pieces of a noisy line, and samples in one at least
_NOISY = 4.0  # times as wide within a piece as from one to the next
_SEEN = 0.02  # of the line's range: a narrower band would not be seen
_BULK = (0.001, 0.999)  # quantiles between which the axes show everything
_MARKS = 10  # markers on a line, each line's beside the others', so that lines that coincide are all seen
_BARS = 28  # bars of a noisy line over a figure, beside the others' in the same way
LOST, FAR = 0.2, 8.0  # an error leaves the axes above so much of the speed, and so many times above the others' errors


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


def _plot(axes: Any, run: xr.Dataset, values: Any, place: tuple[int, int] = (0, 1), **kwargs: Any) -> None:
    """A line with its markers; ``place`` is its number among how many, which sets the markers and bars beside the others'."""
    time, values = run["time"].values, np.asarray(values)
    band = banded(time, values)
    shift = (place[0] + 0.5) / place[1]
    if band is None:
        time, values = thinned(time, values)
        wanted = time[0] + (np.arange(_MARKS) + shift) / _MARKS * (time[-1] - time[0])
        marks = np.unique(np.clip(np.searchsorted(time, wanted), 0, len(time) - 1)).tolist()
        axes.plot(time, values, markevery=marks, **_MARKER, **kwargs)
        return
    at, mean, low, high = band
    size = max(1, len(at) // _BARS)
    starts = range(0, len(at) - size + 1, size)
    middle = np.array([at[k] + shift * (at[k + size - 1] - at[k]) for k in starts])
    lowest, highest = (np.array([pick(one[k:k + size]) for k in starts]) for pick, one in ((np.min, low), (np.max, high)))
    marks = np.searchsorted(at, middle[:: -(-len(middle) // _MARKS)]).tolist()
    drawn, = axes.plot(at, mean, markevery=marks, **_MARKER, **kwargs)
    gap = np.full_like(middle, np.nan)  # one line with gaps: a tenth of so many lines in an SVG
    bars = np.stack([lowest, highest, gap], axis=1).ravel()
    axes.plot(np.repeat(middle, 3), bars, color=drawn.get_color(), linewidth=0.9)


_MARKER = {"markersize": 4.0, "markerfacecolor": "white", "markeredgewidth": 0.9}


def _look(name: str) -> dict[str, Any]:
    one = line(name)
    return {**one.kwargs(), "marker": one.marker}


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
    errors = {name: omega - part["omega_hat"].sel(observer=name).values for name in names}
    for k, name in enumerate(names):
        _plot(above, part, omega - errors[name], (k, len(names)), label=name, **_look(name))
        _plot(below, part, errors[name], (k, len(names)), **_look(name))
    below.axhline(0.0, color=TRUTH.color, linewidth=0.6)
    above.set_ylabel("speed (rad/s)")
    below.set_ylabel("true − estimate\n(rad/s)")
    below.set_xlabel("time (s)")
    _speed_limits(above, omega, [part["omega_hat"].sel(observer=name).values for name in names])
    gone = leaving(omega, errors)
    _robust_limits(below, [error for name, error in errors.items() if name not in gone], 0.15)
    for k, name in enumerate(gone):
        below.annotate(f"{name} leaves the axes, as far as {tidied(f'{_farthest(errors[name]):.3g}')}", (0.01, 0.04 + 0.13 * k),
                       xycoords="axes fraction", fontsize=points(8), color=line(name).color,
                       bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0})
    above.margins(x=0.01)
    legend_above(above)
    return figure


def leaving(omega: NDArray[np.float64], errors: dict[str, NDArray[np.float64]]) -> list[str]:
    """Observers whose error is large beside the speed and beside all others', at most half of them: they leave the axes."""
    spans = sorted((float(np.ptp(np.quantile(error[np.isfinite(error)], _BULK))) if np.isfinite(error).any() else 0.0, name)
                   for name, error in errors.items())
    speed = float(np.nanmax(np.abs(omega)))
    for k in range((len(spans) + 1) // 2, len(spans)):
        if spans[k][0] > FAR * spans[k - 1][0] and spans[k][0] > LOST * speed:
            return [name for name in errors if name in {one for _, one in spans[k:]}]
    return []


def _farthest(error: NDArray[np.float64]) -> float:
    finite = error[np.isfinite(error)]
    return float(finite[np.abs(finite).argmax()])


def _speed_limits(axes: Any, omega: NDArray[np.float64], estimates: Sequence[NDArray[np.float64]]) -> None:
    """Limits that show the true speed whole, and of the estimates what is within as much again, or three quarters of it."""
    low, high = float(np.nanmin(omega)), float(np.nanmax(omega))
    span = max(high - low, 0.75 * max(abs(low), abs(high)), 1e-6)
    _robust_limits(axes, [omega, *(np.clip(one, low - span, high + span) for one in estimates)], 0.12)


def _robust_limits(axes: Any, series: Sequence[NDArray[np.float64]], room: float) -> None:
    """Limits from the bulk of the data, so that the start-up transient does not flatten the rest; a peak may leave the axes."""
    finite = np.concatenate([one[np.isfinite(one)] for one in series])
    if finite.size == 0:
        return
    low, high = np.quantile(finite, _BULK)
    span = max(high - low, 1e-6 * max(abs(low), abs(high), 1.0))
    axes.set_ylim(low - room * span, high + room * span)


@in_style
def alpha_figure(run: xr.Dataset, true_alpha: float, marks: dict[str, float], observers: Sequence[str]) -> Figure:
    """alpha_hat over time, the speed below it, with the true value and other values (``marks``) as lines.

    Parameters
    ----------
    run : xarray.Dataset
        From `simulation.run.simulate`.
    true_alpha : float
        In 1/s.
    marks : dict of str to float
        Other values in 1/s, each with its label.
    observers : sequence of str
        Whose estimates are drawn.
    """
    figure, (above, below) = new_figure(2, 1, height=4.0, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    above.axhline(true_alpha, color=TRUTH.color, linewidth=1.0)
    end = float(run["time"].values[-1])
    above.annotate(f"true {true_alpha:.4g}", (end, true_alpha), ha="right", va="bottom", fontsize=points(8))
    for label, value in marks.items():
        above.axhline(value, color=LIMIT.color, linestyle=LIMIT.linestyle, linewidth=1.0)
        above.annotate(f"{label} {value:.4g}", (end, value), ha="right", va="bottom", fontsize=points(8), color="#555555")
    for k, name in enumerate(observers):
        _plot(above, run, run["alpha_hat"].sel(observer=name).values, (k, len(observers)), label=name, **_look(name))
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
    for k, name in enumerate(observers):
        one = run.sel(observer=name)
        error = np.hypot(
            (one["phi_dr"] - one["phi_dr_hat"]).values, (one["phi_qr"] - one["phi_qr_hat"]).values) / reference
        _plot(axes, run, 100 * error, (k, len(observers)), label=name, **_look(name))
    axes.set_yscale("log")
    axes.set_ylabel("flux error (% of flux)")
    axes.set_xlabel("time (s)")
    axes.margins(x=0.01)
    legend_above(axes)
    return figure
