"""Stability over two parameters: how fast the slowest error decays, how well it is damped, and where stability ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.own import shown
from imo_analysis.errors import InputError
from imo_analysis.pencils.branches import SAME
from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.pencils.setup import Setup, labelled
from imo_analysis.pencils.sweep import SweptKind, axes, described, evaluator

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

SETTLED = 0.02  # settling time: until the slowest error is down to this share
_HALVINGS = 52
_BLOCK = 65_536  # points at a time


@dataclass(frozen=True)
class StabilityMap:
    """A map over two parameters.

    Attributes
    ----------
    data : xarray.Dataset
        As `stability_map` says.
    """

    data: xr.Dataset

    def stable_share(self) -> dict[str, float]:
        """By observer, the share of the grid's points that are stable; those without a state at rest do not count as such."""
        stable = (self.data["decay"] > 0).mean(self.data["decay"].dims[1:])
        return {str(label): float(stable.sel(observer=label)) for label in stable["observer"].values}

    def plot(self, quantity: str = "decay", title: str = "") -> Figure:
        """Shades and labelled contours, with the limit of stability heavy.

        Parameters
        ----------
        quantity : str
            ``decay``, ``damping`` or ``settling_time``.
        title : str
            Above the picture.

        Raises
        ------
        InputError
            For another quantity.
        """
        from imo_analysis.pencils.stability_figure import plot_stability

        return plot_stability(self.data, quantity, title)


def stability_map(
    observer: Setup | Mapping[str, Setup], over: Mapping[str, Any], point: OperatingPoint | None = None,
    kind: SweptKind = "frozen",
) -> StabilityMap:
    """Decay, damping and settling time over a grid of two parameters, and the limit of stability between its points.

    Parameters
    ----------
    observer, over, point, kind
        As in `imo_analysis.pencils.sweep.pole_sweep`, with two names in ``over``: first the horizontal axis.

    Returns
    -------
    StabilityMap
        Its data, over (observer, second name, first name): ``decay`` (1/s), minus the largest real part of the poles, negative
        where the observer is unstable; ``damping`` (1), the least damping ratio; ``settling_time`` (s), ln(50) / decay, until
        the slowest error is down to 2 %, NaN where it grows. Over (observer, crossing): ``limit_NAME`` of either name,
        points at which a pole is on the imaginary axis, to 1e-9 of the value, found between horizontal neighbours. Poles that
        are neutral by structure are left out; NaN where the observer has no state at rest.

    Raises
    ------
    InputError
        For unknown names, one quantity twice, not two of them, or values that are not increasing numbers.
    """
    import xarray as xr

    swept = axes(over)
    if len(swept) != 2:
        raise InputError(f"a map needs two parameters, and {len(swept)} is given: {', '.join(swept)}; add another")
    (x_name, x), (y_name, y) = swept.items()
    observers = labelled(observer)
    decay, damping, limits = [], [], []
    for one in observers.values():
        found = evaluator(one.machine, one.observer, one.gains, (x_name, y_name), point, kind)
        slowest, least, largest = _over_the_grid(found.moving, x, y)
        decay.append(slowest)
        damping.append(least)
        limits.append(_limits(lambda at, found=found: found.moving(at).real.max(axis=-1), x, y, -slowest, largest))
    longest = max(len(limit) for limit in limits)
    padded = np.stack([np.pad(limit, ((0, longest - len(limit)), (0, 0)), constant_values=np.nan) for limit in limits])
    stable = np.where(np.array(decay) > 0, decay, np.nan)
    dims = ("observer", y_name, x_name)
    return StabilityMap(xr.Dataset(
        {
            "decay": (dims, np.array(decay), {"units": "1/s", "long_name": "slowest decay", "latex": r"\delta"}),
            "damping": (dims, np.array(damping), {"units": "1", "long_name": "least damping ratio", "latex": r"\zeta"}),
            "settling_time": (dims, np.log(1 / SETTLED) / stable, {"units": "s", "long_name": "settling time to 2 %",
                                                                   "latex": "t_s"}),
            **{f"limit_{name}": (("observer", "crossing"), padded[..., k], described(name))
               for k, name in enumerate((x_name, y_name))},
        },
        coords={"observer": list(observers), x_name: (x_name, x, described(x_name)), y_name: (y_name, y, described(y_name)),
                "observer_kind": ("observer", [shown(one.observer) for one in observers.values()])},
        attrs={"schema": "imo-stability-map/1", "kind": kind, "over": f"{x_name}, {y_name}"},
    ))


def _over_the_grid(moving: Any, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Slowest decay and least damping, shape (y, x), and the largest magnitude of a pole; some rows at a time, for memory."""
    decay, damping, largest = [], [], 0.0
    for rows in np.array_split(y, min(len(y), -(-len(x) * len(y) // _BLOCK))):
        found = moving((x[None, :], rows[:, None]))
        size = np.abs(found)
        ratio = np.divide(-found.real, size, out=np.where(np.isfinite(size), 0.0, np.nan), where=size > 0)
        decay.append(-found.real.max(axis=-1))
        damping.append(ratio.min(axis=-1))
        largest = float(np.nanmax(size, initial=largest))
    return np.concatenate(decay), np.concatenate(damping), largest


def _limits(rightmost: Any, x: np.ndarray, y: np.ndarray, there: np.ndarray, largest: float) -> np.ndarray:
    """Points (x, y) between horizontal neighbours where the rightmost pole crosses the axis, halved in all at once."""
    noise = SAME * largest  # a pole that rests on the axis has a sign by rounding alone
    clear = np.abs(there) > noise
    rows, columns = np.nonzero((there[:, :-1] * there[:, 1:] < 0) & (clear[:, :-1] | clear[:, 1:]))
    low, high, at = x[columns], x[columns + 1], y[rows]
    before = np.sign(there[rows, columns])
    for _ in range(_HALVINGS if len(rows) else 0):
        middle = 0.5 * (low + high)
        same = np.sign(rightmost((middle, at))) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.stack([0.5 * (low + high), at], axis=-1)
