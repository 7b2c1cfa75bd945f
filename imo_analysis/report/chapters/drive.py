"""The chapter on a drive as it is: what sampling, dead time, saturation and the rest cost, and where the loop holds."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from imo_analysis.report.drive import DriveResult
from imo_analysis.report.own import NEAR, per_cent, where_it_fails
from imo_analysis.report.page import Chapter, Html, answer, figure, join, number, prose, table, tag
from imo_analysis.report.words import typeset
from imo_analysis.simulation.judge import R_S_OFF, STRETCH, criterion
from imo_analysis.sweeps.feature_costs import NONE

if TYPE_CHECKING:
    import xarray as xr

BREAKS = 10.0  # rad/s of error that a feature adds to an observer for it to be named
LEAST = 1e-3  # rad/s, below which an error is not written out
FAR_LESS = 5.0  # times smaller: by far less


def drive_chapter(result: DriveResult) -> Chapter:
    """Both tables of `imo_analysis.report.drive` with their pictures."""
    body = join([
        prose(
            r"""
Most of what stands above is what the equations do: continuous measurements, the voltage that was asked for, a machine that
is the model. A drive samples, waits, switches with a dead time, saturates, and knows its resistances only roughly. And in the
end the estimate has to close the loop. Maps of ideal observers say little about either.
"""),
        *_features(result), *_map(result),
    ])
    return Chapter("drive", "A drive as it is", "A drive as it is", body)


def _features(result: DriveResult) -> list[Html]:
    data = result.features
    head = tag("h3", "What each part of a drive costs")
    if data is None or result.features_figure is None:
        return [head, tag("p", "The study has nothing of it: see the tables sensors, inverter, mechanics and saturation, and "
                               "the errors of drive and observers.", class_="note")]
    names = [str(name) for name in data["observer"].values]
    rows = []
    for name in data["feature"].values:
        one = data.sel(feature=name)
        rows.append((str(name), *(_error(one, observer) for observer in names),
                     *(number(float(one["alpha_hat"].sel(observer=observer)), 4) for observer in _adaptive(result))))
    columns = ("on", *(f"`{name}`" for name in names), *(rf"$\hat{{\alpha}}$ of `{name}`" for name in _adaptive(result)))
    about = (f"{result.scenario}: speed error, mean ± standard deviation, in rad/s, and mean alpha_hat in 1/s, from "
             f"{data.attrs['start']:g} to {data.attrs['stop']:g} s; alpha is {data.attrs['alpha']:.4g} /s")
    drawn = result.features_figure
    return [head, answer(*_costly(result)), figure(drawn.svg, drawn.caption, drawn.caption, drawn.file),
            table(columns, rows, typeset(about), range(1, len(columns))), *_dead_time(result), *_layer(result)]


def _dead_time(result: DriveResult) -> list[Html]:
    """Why dead time takes alpha_hat away, where it does: the speed is off by much, and by far less with switching alone."""
    data = result.features
    if data is None or "dead time" not in data["feature"].values:
        return []
    error = np.abs(data["speed_error"].sel(feature="dead time", observer=_adaptive(result)).values)
    if (error <= BREAKS).all():
        return []
    return [prose(
        r"""
Dead time takes a voltage off each phase that turns over with its current. Uncompensated, as here, its
ripple reaches the adaptation of alpha as if it were excitation: $\hat{\alpha}$ goes where the ripple pushes it and takes the
speed along. An observer that does not adapt alpha has only the voltage error itself.
""" + _switching(data, _adaptive(result), error))]


def _switching(data: xr.Dataset, observers: list[str], with_dead_time: NDArray[np.float64]) -> str:
    """That switching is not to blame, where the run without dead time says so."""
    if "switching" not in data["feature"].values:
        return ""
    alone = np.abs(data["speed_error"].sel(feature="switching", observer=observers).values)
    less = np.nan_to_num(alone, nan=np.inf).max() < np.nan_to_num(with_dead_time, nan=np.inf).max() / FAR_LESS
    return "Switching without dead time does far less.\n" if less else ""


def _layer(result: DriveResult) -> list[Html]:
    """How far alpha_hat moves in a sample, beside the layer of (10)."""
    data = result.features
    if data is None or "alpha_step" not in data:
        return []
    columns = ("alpha_step", "layer", "layer_of_study")
    rows = [(tag("code", name), *(number(float(data[column].sel(observer=name))) for column in columns))
            for name in _adaptive(result)]
    head = ("observer", r"largest move of $\hat{\alpha}$ in a sample (1/s)", r"layer $\delta$ in this run (1/s)",
            r"layer $\delta$ of the study (1/s)")
    return [prose(
        r"""
The layer $\delta$ of (10), in which the projection fades out, is a matter of the sampling as well. A layer that is thinner
than what $\hat{\alpha}$ moves in one sample is jumped across, and the bound with it; it has to be wider than that.
"""), table(head, rows, "With everything on", (1, 2, 3))]


def _adaptive(result: DriveResult) -> list[str]:
    data = result.features
    return [] if data is None else [str(name) for name in data["observer"].values
                                    if np.isfinite(data["alpha_hat"].sel(observer=name)).any()]


def _error(one: xr.Dataset, observer: str) -> str:
    mean, ripple = (float(one[name].sel(observer=observer)) for name in ("speed_error", "speed_ripple"))
    if max(abs(mean), ripple) < LEAST:
        return f"below {LEAST:g}"
    return "diverged" if math.isnan(mean) else f"{number(mean, 2, sign=True)} ± {number(ripple, 2)}"


def _costly(result: DriveResult) -> list[str]:
    """For each observer the single parts of a drive that put its speed off."""
    data = result.features
    if data is None:
        return []
    error = (data["speed_error"] ** 2 + data["speed_ripple"] ** 2) ** 0.5
    lines = []
    for name in data["observer"].values:
        one = error.sel(observer=name)
        bad = [f"{feature} ({'diverged' if math.isnan(value) else f'{value:.3g} rad/s'})"
               for feature, value in zip(data["feature"].values[:-1], one.values[:-1], strict=True)
               if not value <= float(one.sel(feature=NONE)) + BREAKS]
        lines.append(f"`{name}` is put off by more than {BREAKS:g} rad/s by "
                     + (f"{', '.join(bad)} alone" if bad else "no part of the drive alone")
                     + f"; with all at once its error is {number(float(one[-1]))} rad/s.")
    return lines


def _map(result: DriveResult) -> list[Html]:
    head = tag("h3", "Where the loop closed on an estimate holds")
    plane, drawn = result.map, result.map_figure
    if plane is None or drawn is None:
        return [head, tag("p", typeset(f"There is no map of this study: {result.refused}"), class_="note")]
    lines = []
    for name in plane["observer"].values:
        share = float(plane["holds"].sel(observer=name).mean())
        lines.append(f"`{name}` holds at {100 * share:.0f} % of the points. {where_it_fails(plane, name)}")
    wedge = any(_lost_near_and_far(plane, name)[0] > FAR_LESS * _lost_near_and_far(plane, name)[1]
                for name in plane["observer"].values)
    return [head, prose(
        rf"""
At every point the drive starts from standstill, goes to the speed, is loaded, and holds both, on nothing but the estimates of
speed and flux, and the reference for the direction of rotation. The points are denser at low speeds. The observers believe
{100 * R_S_OFF:g} % too much stator resistance. It holds where over the last {STRETCH:g} s the mean error of the estimate,
and at the end the distance of the speed from the wanted one, are within {criterion()}.
"""), answer(*lines), figure(drawn.svg, drawn.caption, drawn.caption, drawn.file), *_limits(plane), prose(
        r"""
The stator frequency is speed plus slip, and the slip has the sign of the torque: braking, it passes zero at a speed that is not
zero. There a rotor flux of constant magnitude stands still, the currents say nothing about the speed, and a small error of the
stator resistance decides.
""" + ("That makes a wedge of the plane, around the dashed line, in which holding is luck." if wedge else ""))]


def _limits(plane: xr.Dataset) -> list[Html]:
    """How far the stator resistance may be off, by observer and speed."""
    rows = []
    for name in plane["observer"].values:
        for omega in plane["limit_omega"].values:
            one = plane.sel(observer=name, limit_omega=omega)
            low, high = float(one["R_s_low"]), float(one["R_s_high"])
            held = not math.isnan(low)
            rows.append((tag("code", str(name)), number(float(omega)), *(
                (per_cent(low), per_cent(high)) if held else ("does not hold with the right one", "–"))))
    head = ("observer", "speed (rad/s)", "believed too low by", "believed too high by")
    about = f"Within which errors of $R_s$ the loop holds, at {plane.attrs['limit_torque']:.4g} N m"
    return [table(head, rows, about, (1, 2, 3))]


def _lost_near_and_far(plane: xr.Dataset, name: object) -> tuple[float, float]:
    """Share of the points that are lost near zero stator frequency, and elsewhere."""
    lost = 1.0 - plane.sel(observer=name)["holds"].values
    near = np.abs(plane["stator_frequency"].values) <= NEAR * np.abs(plane["stator_frequency"].values).max()
    return (float(lost[near].mean()) if near.any() else 0.0, float(lost[~near].mean()) if (~near).any() else 0.0)
