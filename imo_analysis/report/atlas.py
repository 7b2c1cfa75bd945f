"""Maps of stability for the dossier: over speed and slip with the adaptation at work, over a wrong resistance, over a gain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.report.scenarios import Drawn, keep
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr

    from imo_analysis.pencils.setup import Setup

SPEEDS, SLIPS, ERRORS, GAINS = 61, 41, 31, 31  # points of the maps
NEAR = 2.0  # times alpha: the slips reach to alpha, so that a stator frequency of zero lies within, and speeds are taken finely
SLOWEST = 0.1  # of the widest speed: where the map over errors begins
WRONG = 0.5  # relative error of the rotor resistance at the ends of that map
LOADED = 0.5  # of alpha: the slip there
DAMPED = 0.95  # a map of nothing less says nothing
GAIN_SPAN = (0.1, 3.0)  # times the study's gain


@dataclass(frozen=True)
class Unstable:
    """Shares of the area of an observer's map of speed and slip that is unstable: forward, backward, where slip brakes."""

    observer: str
    forward: float
    backward: float
    braking: float


@dataclass(frozen=True)
class Atlas:
    """The maps with their figures; ``slip`` is the end of the slips, ``gain`` the name of the gain that is varied."""

    figures: list[Drawn]
    unstable: list[Unstable]
    slip: float
    gain: str


def atlas(study: Study, folder: Path) -> Atlas:
    """Compute and draw the maps of the study's observers."""
    from imo_analysis.drawing import rasterized
    from imo_analysis.pencils.error import OperatingPoint
    from imo_analysis.pencils.setup import Setup
    from imo_analysis.pencils.stability import stability_map

    setups = {name: Setup.of_study(study, name) for name in study.observers}
    right = {name: Setup(one.observer, study.machine, one.gains) for name, one in setups.items()}
    machine, span = study.machine, study.poles.sweep
    widest = max(abs(span.start), abs(span.stop))
    point = OperatingPoint(omega=0.0, flux=study.drive.flux, slip=LOADED * machine.alpha)
    slips = np.linspace(-machine.alpha, machine.alpha, SLIPS)
    plane = stability_map(right, {"omega": _speeds(span.start, span.stop, machine.alpha, slips[1] - slips[0]), "slip": slips},
                          point, "full")
    figures = [keep(
        folder, "stability-slip", rasterized(plane.plot("decay")),
        f"How fast the slowest error decays with the adaptation of the speed at work, over speed and slip; at a slip of "
        f"{machine.alpha:.3g} rad/s the torque current is as large as the magnetising one. Hatched: unstable.")]
    errors = {"omega": np.linspace(SLOWEST * widest, widest, SPEEDS), "R_r_error": np.linspace(-WRONG, WRONG, ERRORS)}
    wrong = _or_nothing(lambda: stability_map(right, errors, point, "settled"))
    if wrong is not None:
        figures.append(keep(
            folder, "stability-resistance", rasterized(wrong.plot("decay")),
            "The same over speed and the relative error of the rotor resistance that an observer believes, about the state "
            f"where it then settles, at a slip of {LOADED * machine.alpha:.3g} rad/s; an estimate of alpha is held at what is "
            "believed. Grey: it has no state at rest."))
    varied = _gain(setups)
    if varied:
        name, label = varied
        gain = setups[label].gains[name]
        damped = stability_map({label: right[label]}, {"omega": np.linspace(span.start, span.stop, SPEEDS),
                                                       name: np.linspace(GAIN_SPAN[0] * gain, GAIN_SPAN[1] * gain, GAINS)})
        if float(damped.data["damping"].min()) < DAMPED:
            figures.append(keep(folder, "damping", rasterized(damped.plot("damping")),
                                f"The least damping ratio of the poles of `{label}` at frozen speed, over speed and the gain "
                                f"of its z loop, which is {gain:g} in the study."))
    return Atlas(figures, [_unstable(plane.data, name) for name in setups], machine.alpha, varied[0] if varied else "")


def _speeds(start: float, stop: float, alpha: float, step: float) -> np.ndarray:
    """Speeds of the map over slip: where slip and speed cancel, a point lies half a step of the slips beside that line, in
    every row alike, so that what ends there ends in a line and not in islands.
    """
    count = round(NEAR * alpha / step)
    near = step * (np.arange(-count, count) + 0.5)
    whole = np.linspace(start, stop, SPEEDS)
    return np.sort(np.concatenate([whole[np.abs(whole) > near[-1] + step], near[(near > start) & (near < stop)]]))


def _or_nothing(make: Any) -> Any:
    try:
        return make()
    except InputError:  # an observer that has no such linearisation
        return None


def _gain(setups: Mapping[str, Setup]) -> tuple[str, str] | None:
    """The gain of the z loop, and the first observer that has one that is not zero."""
    found = ((name, label) for name in ("k_2", "kappa") for label, one in setups.items() if one.gains.get(name, 0.0) > 0)
    return next(found, None)


def _unstable(data: xr.Dataset, name: str) -> Unstable:
    """Shares of the area of each kind with a pole that grows; points without a linearisation count as neither."""
    decay = data["decay"].sel(observer=name)
    bad = (decay < 0) & np.isfinite(decay)
    omega, slip = data["omega"], data["slip"]
    width = omega.copy(data=np.gradient(omega.values))

    def share(chosen: Any) -> float:
        inside = chosen.broadcast_like(decay) & np.isfinite(decay)
        area = width.where(inside)
        return float(area.where(bad).sum() / area.sum()) if bool(inside.any()) else 0.0

    return Unstable(name, share(omega > 0), share(omega < 0), share(omega * slip < 0))
