"""Baseline and proposed observers with gains chosen by one rule: the comparison that Table II set out to make.

The rule is the same for all and favours none: over a whole range of speeds, in both directions, the slowest error shall decay
as fast as it can, while no pole is faster than a limit that sampling and noise set. The gains that the frozen-speed poles
depend on are searched for by differential evolution with a fixed seed; a larger decay than the one found is not excluded, but
the search finds no less than the exact rule of `imo_analysis.pencils.pole_rule` where that applies (a test).

For the baseline l_2 and l_4 are zero: constant ones make the two directions of rotation different.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.pencils.sweep import described, evaluator

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# what is searched for, and what is held
SEARCHED: dict[str, tuple[tuple[str, ...], dict[str, float]]] = {
    "baseline": (("l_1", "l_3"), {"l_2": 0.0, "l_4": 0.0}),
    "baseline_scheduled": (("k",), {}),
    "consistent_12": (("k_1", "k_2", "k_3"), {}),
    "repaired": (("k_1", "kappa", "k_3"), {}),
}
_SEED = 1
_SPEEDS = 31
_POPULATION, _GENERATIONS = 24, 160


@dataclass(frozen=True)
class Comparison:
    """Observers side by side.

    Attributes
    ----------
    data : xarray.Dataset
        As `compare` says.
    """

    data: xr.Dataset

    def plot(self, title: str = "") -> Figure:
        """Slowest decay and least damping over the speed, a line an observer, for the last of the limits.

        Parameters
        ----------
        title : str
            Above the picture, in place of the rule.
        """
        return _plot(self.data, title)


def compare(
    machine: InductionMachine,
    omega_max: float,
    fastest: float | Sequence[float],
    omega_min: float = 0.0,
    observers: Sequence[str] = tuple(SEARCHED),
    points: int = 121,
) -> Comparison:
    """Gains by the same rule for every observer, and what they give over the speed.

    Parameters
    ----------
    machine : InductionMachine
        As the observers believe it to be.
    omega_max, omega_min : float
        The range of abs(omega) in rad/s.
    fastest : float or sequence of float
        Limits of the magnitude of the fastest pole, in rad/s.
    observers : sequence of str
        Of `SEARCHED`.
    points : int
        Speeds of the result, from -omega_max to omega_max.

    Returns
    -------
    Comparison
        Its data, over (observer, fastest): ``slowest_decay`` (1/s), ``least_damping`` (1) and ``reached`` (rad/s), the
        largest magnitude of a pole over the range, and over (observer, fastest, gain) the gains, NaN where an observer has no
        such gain; over (observer, fastest, omega) ``decay`` (1/s) and ``damping`` (1) at each speed, NaN below omega_min.

    Raises
    ------
    InputError
        For an unknown observer, a range or a limit that is none.
    """
    import xarray as xr

    limits = np.atleast_1d(np.asarray(fastest, dtype=float))
    if not (np.all(np.isfinite(limits)) and np.all(limits > 0) and limits.size):
        raise InputError(f"fastest = {fastest} must be above 0 rad/s")
    if not 0 <= omega_min < omega_max < np.inf:
        raise InputError(f"the range of speeds {omega_min} .. {omega_max} rad/s must be 0 <= omega_min < omega_max")
    if unknown := [name for name in observers if name not in SEARCHED]:
        raise InputError(f"observer = {unknown[0]!r} has no gains to search for; choose from: {', '.join(SEARCHED)}")
    omega = np.linspace(-omega_max, omega_max, points)
    names = list(dict.fromkeys(gain for name in observers for gain in (*SEARCHED[name][0], *SEARCHED[name][1])))
    gains = np.full((len(observers), len(limits), len(names)), np.nan)
    decay = np.full((len(observers), len(limits), points), np.nan)
    damping, size = decay.copy(), decay.copy()
    for n, name in enumerate(observers):
        for m, limit in enumerate(limits):
            chosen = best_gains(machine, name, omega_max, float(limit), omega_min)
            gains[n, m] = [chosen.get(gain, np.nan) for gain in names]
            found = evaluator(machine, name, chosen, "omega", OperatingPoint(0.0, None), "frozen").moving(omega)
            decay[n, m], size[n, m] = -found.real.max(axis=-1), np.abs(found).max(axis=-1)
            damping[n, m] = (-found.real / np.abs(found)).min(axis=-1)
    inside = np.abs(omega) >= omega_min
    over = ("observer", "fastest")
    slowest, least = decay[..., inside].min(axis=-1), damping[..., inside].min(axis=-1)
    return Comparison(xr.Dataset(
        {
            "slowest_decay": (over, slowest, {"units": "1/s", "long_name": "slowest decay of the range"}),
            "least_damping": (over, least, {"units": "1", "long_name": "least damping of the range"}),
            "reached": (over, size[..., inside].max(axis=-1), {"units": "rad/s", "long_name": "fastest pole of the range"}),
            "gains": ((*over, "gain"), gains, {"long_name": "gains found"}),
            "decay": ((*over, "omega"), np.where(inside, decay, np.nan),
                      {"units": "1/s", "long_name": "slowest decay", "latex": r"\delta"}),
            "damping": ((*over, "omega"), np.where(inside, damping, np.nan),
                        {"units": "1", "long_name": "least damping ratio", "latex": r"\zeta"}),
        },
        coords={"observer": list(observers), "gain": names, "omega": ("omega", omega, described("omega")),
                "fastest": ("fastest", limits, {"units": "rad/s", "long_name": "limit of the fastest pole"})},
        attrs={"schema": "imo-comparison/1", "machine": machine.name, "omega_min": omega_min, "omega_max": omega_max},
    ))


def best_gains(
    machine: InductionMachine, observer: str, omega_max: float, fastest: float, omega_min: float = 0.0
) -> dict[str, float]:
    """The gains with which the slowest error decays fastest over a range of speeds, no pole being faster than a limit.

    Parameters
    ----------
    machine : InductionMachine
    observer : str
        Of `SEARCHED`.
    omega_max, omega_min : float
        The range of abs(omega) in rad/s, both directions; the poles of these observers mirror with the speed.
    fastest : float
        Limit of the magnitude of a pole in rad/s. Where no gains keep it, those that come nearest.
    """
    from scipy.optimize import differential_evolution

    searched, held = SEARCHED[observer]
    speeds = np.linspace(omega_min, omega_max, _SPEEDS)
    moving = evaluator(machine, observer, held, (*searched, "omega"), OperatingPoint(0.0, None), "frozen").moving

    def worse(scaled: np.ndarray) -> Any:
        found = moving((*(gain[:, None] for gain in _gains(machine, observer, fastest, scaled)), speeds))
        decay, size = -found.real.max(axis=(1, 2)), np.abs(found).max(axis=(1, 2))
        return -decay / fastest + 1e3 * np.maximum(size / fastest - 1, 0)

    best = differential_evolution(
        worse, [(0.0, 1.0)] * len(searched), rng=np.random.default_rng(_SEED), popsize=_POPULATION // len(searched),
        maxiter=_GENERATIONS, tol=1e-10, atol=1e-12, polish=False, vectorized=True, updating="deferred")
    chosen = _gains(machine, observer, fastest, best.x[:, None])
    return dict(zip(searched, (float(gain[0]) for gain in chosen), strict=True)) | held


def _gains(machine: InductionMachine, observer: str, fastest: float, scaled: np.ndarray) -> tuple[np.ndarray, ...]:
    """Gains from numbers between 0 and 1: the sum of the decays up to twice the limit, the product up to its square."""
    own = machine.gamma + machine.alpha
    if observer == "baseline_scheduled":
        return (20.0 * fastest / own * scaled[0],)
    total = 2 * fastest * scaled[0]
    product = fastest**2 * scaled[1] ** 3  # slow poles need a product that is small beside the square
    if observer == "baseline":
        l_1 = total - own
        return l_1, (product / machine.alpha - machine.R_s / machine.sigma - l_1) / machine.beta
    growth = scaled[2] ** 3 * (fastest if observer == "repaired" else 1.0) * 4
    return total - machine.R_s / machine.sigma, growth, product / machine.alpha


def _plot(data: xr.Dataset, title: str) -> Figure:
    from imo_analysis.drawing import line, new_figure, style

    figure, axes = new_figure(1, 2, width=7.6, height=3.4)
    with style():
        at = data.isel(fastest=-1)
        for name in data["observer"].values:
            look = line(str(name))
            for ax, quantity in zip(axes, ("decay", "damping"), strict=True):
                ax.plot(at["omega"], at[quantity].sel(observer=name), label=str(name) if quantity == "decay" else None,
                        **look.kwargs())
                ax.set_xlabel(f"electrical speed ${at['omega'].attrs['latex']}$ (rad/s)")
        axes[0].set_yscale("log")
        axes[0].set_ylabel(r"slowest decay $\delta$ (1/s)")
        axes[1].set_ylabel(r"least damping ratio $\zeta$")
        axes[1].set_ylim(0.0, 1.05)
        limit = float(at["fastest"])
        figure.legend(loc="outside upper left", ncols=4, frameon=False, alignment="left",
                      title=title or f"Gains by one rule: no pole faster than {limit:g} rad/s, the slowest as fast as can be")
    return figure
