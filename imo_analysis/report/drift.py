"""Where alpha_hat ends, predicted and simulated: data, table rows and figure of one run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from imo_analysis.drawing import LIMIT, TRUTH, in_style, legend_above, line, new_figure
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from imo_analysis.excitation.variations import Variation


@dataclass(frozen=True)
class DriftRow:
    """alpha_hat over one change of the speed reference, in 1/s.

    Attributes
    ----------
    observer : str
    time, before, after : float
        When (s), from and to which electrical speed (rad/s).
    start : float
        In the run, just before the step; before the first step that is where the start of the drive left it.
    step_from_study, step_from_motion, step : float
        What the step adds: predicted from the study alone, before any simulation; predicted from the motion of the machine,
        without looking at the observer; and in the run.
    from_study, end : float
        After the step: predicted from the study alone, the start included; and in the run, just before the next change or at
        its end.
    flux_error : float
        Of the reconstructed flux then, over the flux.
    """

    observer: str
    time: float
    before: float
    after: float
    start: float
    step_from_study: float
    step_from_motion: float
    step: float
    from_study: float
    end: float
    flux_error: float


@dataclass(frozen=True)
class LandingRow:
    """Where the start leaves alpha_hat, in 1/s.

    Attributes
    ----------
    observer : str
    initial : float
        At time 0.
    from_error, from_motion : float
        Predicted from the study alone: what is left of the initial error, and what the acceleration adds.
    predicted, simulated : float
        From the study alone, and in the run just before the first step.
    predicted_xi, simulated_xi : float
        Magnitude of the error of xi_hat there, in A.
    left_alone : float
        Predicted, were both copies left alone (`imo_analysis.excitation.landing.left_alone`); NaN if it then does not land.
    share, share_of_exact : float
        Of a small initial error, that a build-up at standstill leaves (`imo_analysis.excitation.landing.share_left`), and that
        it would leave were xi_hat exact.
    """

    observer: str
    initial: float
    from_error: float
    from_motion: float
    predicted: float
    simulated: float
    predicted_xi: float
    simulated_xi: float
    left_alone: float
    share: float
    share_of_exact: float


def explanations(run: xr.Dataset, study: Study, observers: list[str]) -> dict[str, xr.Dataset]:
    """`imo_analysis.excitation.resting.explain` for each adaptive observer; empty where the study is of another kind."""
    from imo_analysis.excitation.resting import explain

    if len(study.reference.time) < 2:
        return {}
    start = 0.5 * study.reference.time[1]
    found = {}
    for name in observers:
        try:
            found[name] = explain(run, study, name, start)
        except InputError:  # ramps, a load that changes, a modulated flux, or errors that grow: there is nothing to predict
            continue
    return found


def drift_rows(explained: dict[str, xr.Dataset], study: Study) -> list[DriftRow]:
    """One row an observer and change of speed."""
    times, speeds = study.reference.time, study.reference.omega
    rows = []
    for name, data in explained.items():
        end = float(data["time"].values[-1])
        for number, time in enumerate(times[1:], start=1):
            if time >= end:
                continue
            last = min(end, times[number + 1]) if number + 1 < len(times) else end
            ends = (time - study.simulation.sample_time, last - study.simulation.sample_time)
            moved, seen = ([float(data[one].sel({axis: at}, method="nearest")) for at in ends]
                           for one, axis in (("predicted", "late"), ("alpha_hat", "time")))
            steps = data["step_alpha_hat"].values
            off = float(data["flux_error"].sel(time=ends[1], method="nearest")) / study.drive.flux
            own = float(steps[number] - steps[number - 1])
            rows.append(DriftRow(name, time, speeds[number - 1], speeds[number], seen[0], own, moved[1] - moved[0],
                                 seen[1] - seen[0], float(steps[number]), seen[1], off))
    return rows


def landing_rows(explained: dict[str, xr.Dataset], study: Study) -> list[LandingRow]:
    """One row an observer."""
    from imo_analysis.excitation.landing import landing, left_alone, share_left

    def bare(name: str) -> float:
        try:
            return landing(left_alone(study, name), name).alpha_hat
        except InputError:  # without their correction it does not land
            return math.nan

    rows = []
    for name, data in explained.items():
        before = data.sel(time=study.reference.time[1] - study.simulation.sample_time, method="nearest")
        settings = study.observers[name]
        initial = dict(zip(OBSERVERS[settings.kind].states, settings.initial_values, strict=True))["alpha_hat"]
        shares = (share_left(study.machine, {**settings.gains, "k_3": k_3}, study.drive.flux, study.drive.flux_bandwidth)
                  for k_3 in (settings.gains["k_3"], 0.0))
        rows.append(LandingRow(
            name, initial, data.attrs["from_error"], data.attrs["from_motion"], float(data["step_alpha_hat"][0]),
            float(before["alpha_hat"]), data.attrs["landing_xi_error"], float(before["xi_error"]),
            bare(name), *shares))
    return rows


@in_style
def drift_figure(explained: dict[str, xr.Dataset]) -> Figure:
    """alpha_hat of each observer, what the motion predicts for it, and what the study alone, after the start and each step."""
    figure, all_axes = new_figure(len(explained), 1, height=0.6 + 2.3 * len(explained), sharex=True, squeeze=False)
    for axes, (name, data) in zip(all_axes[:, 0], explained.items(), strict=True):
        step = max(1, data.sizes["time"] // 1400)
        thin = data.isel(time=slice(None, None, step), late=slice(None, None, step))
        start = data.attrs["start"]
        whole = thin.sel(time=slice(0.1 * start, None))
        axes.plot(whole["time"], whole["alpha_hat"], label=name, **line(name).kwargs())
        axes.plot(thin["late"], thin["predicted"], color=TRUTH.color, linestyle=(0, (1, 2)), linewidth=1.8,
                  label="from the motion")
        axes.plot(data["step_time"], data["step_alpha_hat"], "kx", markersize=7, label="from the study alone")
        axes.axhline(data.attrs["alpha"], color=LIMIT.color, linestyle=LIMIT.linestyle, linewidth=1.0, label="true")
        axes.set_ylabel(r"$\hat{\alpha}$ (1/s)")
        axes.margins(x=0.01, y=0.08)
        legend_above(axes, ncols=4, columnspacing=1.2)
    all_axes[-1, 0].set_xlabel("time (s)")
    return figure


def varied(study: Study) -> list[Variation]:
    """`imo_analysis.excitation.variations` at the largest step of the study; empty where nothing can be predicted for it."""
    from imo_analysis.errors import Diverged
    from imo_analysis.excitation.variations import variations

    names = [name for name, settings in study.observers.items() if settings.kind == "repaired"]
    steps = sorted(pairwise(study.reference.omega), key=lambda step: abs(step[1] - step[0]))
    if not names or not steps or steps[-1][0] == steps[-1][1]:
        return []
    try:
        return variations(study, names[0], *steps[-1])
    except (InputError, Diverged):
        return []


def varied_landings(study: Study) -> dict[str, list[Variation]]:
    """`imo_analysis.excitation.variations.landings` of the paper's observer and the repaired one, where they land."""
    from imo_analysis.errors import Diverged
    from imo_analysis.excitation.variations import landings

    found = {}
    for name, settings in study.observers.items():
        if settings.kind not in ("consistent_12", "repaired"):
            continue
        try:
            found[name] = landings(study, name)
        except (InputError, Diverged):
            continue
    return found
