"""Runs the scenarios of a study one by one, and keeps of each what the dossier shows: figures, numbers and thinned files."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import Diverged
from imo_analysis.report import captions
from imo_analysis.report.drift import DriftRow, LandingRow, drift_figure, drift_rows, explanations, landing_rows
from imo_analysis.report.metrics import Resting, StepResponse, resting, step_responses
from imo_analysis.simulation.judge import STRETCH, criterion, follows, holds, limit
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NETCDF_SAMPLES = 6000
CSV_SAMPLES = 3000


@dataclass(frozen=True)
class Drawn:
    """A figure as SVG text, its caption, and its file beside the page, if any."""

    svg: str
    caption: str
    file: str


@dataclass(frozen=True)
class WindowResult:
    """What a window of a run shows."""

    title: str
    start: float
    stop: float
    responses: list[StepResponse]


@dataclass(frozen=True)
class ExcitationResult:
    """Excitation along a run: `imo_analysis.excitation.words.summary`, its figure, and whether that is shown at once."""

    title: str
    summary: dict[str, Any]
    figure: Drawn
    open: bool = False


@dataclass(frozen=True)
class Scenario:
    """What the dossier keeps of a run.

    ``fault`` says what diverged, and when, or is empty; ``alpha`` is that of the machine in this run, in 1/s, which need not be
    the study's; ``driver`` is the observer whose estimate drives the machine, or empty; ``driven`` is what
    `imo_analysis.report.driven.driven_by_each` found, if it was asked.
    """

    name: str
    title: str
    command: str
    figures: list[Drawn]
    windows: list[WindowResult]
    resting: list[Resting]
    excitation: list[ExcitationResult]
    drift: list[DriftRow]
    drift_figure: Drawn | None
    fault: str
    files: list[tuple[str, str]] = field(default_factory=list)
    alpha: float = math.nan
    driver: str = ""
    landings: list[LandingRow] = field(default_factory=list)
    driven: tuple[Resting, ...] = ()

    @property
    def titled(self) -> str:
        """The title, with the observer whose estimate drives."""
        return self.title + (f", driven by `{self.driver}`" if self.driver else "")


@dataclass(frozen=True)
class Divergence:
    """What became of an observer: ``diverged`` when it overflowed, at ``time`` (s); ``off`` when it ends off the speed."""

    observer: str
    source: str
    diverged: bool
    time: float
    outcome: str
    off: bool = False


def main_scenario(scenarios: Sequence[Scenario]) -> Scenario:
    """The run that the first screen speaks of: the paper's Fig. 4 where the study has it, else the last."""
    return next((one for one in scenarios if one.name == "fig4"), scenarios[-1])


_SPECIAL = ("divergence", "lyapunov")  # shown in a way of their own


def scenario_names(study: Study) -> list[str]:
    """The scenarios that are drawn: those with ``[[windows]]``, which say where to look; all of them if none has any.

    Of a study without scenarios it is the study itself, under the empty name.
    """
    names = [name for name in study.scenarios if name not in _SPECIAL]
    return [name for name in names if study.scenario(name).windows] or names or [""]


def not_drawn(study: Study) -> list[str]:
    """The other scenarios, which ``imo simulate`` runs."""
    drawn = scenario_names(study)
    return [name for name in study.scenarios if name not in drawn and name not in _SPECIAL]


def run_scenario(
    study: Study, name: str, folder: Path, note: Callable[[str], None], runs: bool = True, driver: str = ""
) -> Scenario:
    """Simulate one scenario, draw it, judge its excitation and, with ``runs``, write it, thinned, to ``folder``/runs.

    An observer that diverges is shown as far as it went; the others are not touched by it. ``driver`` is the observer that
    drives, in place of the study's.

    Raises
    ------
    Diverged
        If nothing is left of the run.
    """
    from imo_analysis.simulation.run import simulate

    chosen = study.scenario(name) if name else study
    other = driver not in ("", chosen.drive.feedback)
    if other:
        chosen = chosen.changed({"drive.feedback": driver})
    label = name or "run"
    note(f"{label}: simulating {chosen.simulation.duration:g} s")
    fault = ""
    try:
        run = simulate(chosen)
    except Diverged as error:
        if error.data is None or error.data.sizes["time"] < 2:
            raise
        run, fault = error.data, str(error)
    note(f"{label}: drawing")
    files = _write(run, label, chosen, folder) if runs else []
    observers = [str(one) for one in run["observer"].values]
    states = resting_of(run, chosen)
    figures = [keep(folder, f"{label}-speed", _figures().speed_figure(run),
                    captions.whole_speed(states, _gone(run), _figures().noisy(run)))]
    windows = []
    end = float(run["time"].values[-1])
    shown = [window for window in chosen.windows if window.start < end]
    for place, window in enumerate(shown, start=1):
        span = (window.start, window.stop)
        responses = step_responses(run, span)
        caption = captions.part_speed(window, responses, _gone(run.sel(time=slice(*span))))
        if window.start <= 0.0 and window.stop >= end:  # that figure is there already
            figures[0] = replace(figures[0], caption=caption)
        else:
            figures.append(keep(folder, f"{label}-window{place}", _figures().speed_figure(run, span), caption))
        windows.append(WindowResult(window.title, window.start, window.stop, responses))
    adaptive = [one for one in observers if "alpha_hat" in OBSERVERS[chosen.observers[one].kind].states]
    explained = explanations(run, chosen, adaptive)
    rows = drift_rows(explained, chosen)
    drawn = None
    if explained:
        drawn = keep(folder, f"{label}-alpha", drift_figure(explained), captions.drift(chosen.title, rows))
        figures.append(drawn)
    elif adaptive:
        figures.append(keep(folder, f"{label}-alpha", _figures().alpha_figure(run, chosen.machine.alpha, {}, adaptive),
                            captions.alpha(states, chosen.machine.alpha)))
    figures.append(keep(folder, f"{label}-flux", _figures().flux_error_figure(run, observers), captions.flux(states)))
    note(f"{label}: excitation")
    fits = study.excitation.window <= end
    judged = list(_excitation(run, chosen, label, folder, adaptive[:1] or ["plant"])) if fits else []
    command = f"imo simulate study.toml{f' --scenario {name}' if name else ''}{f' --feedback {driver}' if other else ''}"
    command += f" --out {label}.nc"
    return Scenario(label, chosen.title, command, figures, windows, states, judged, rows, drawn, fault, files,
                    chosen.machine.alpha,
                    "" if chosen.drive.feedback == "measured" else chosen.drive.feedback, landing_rows(explained, chosen))


def _gone(run: xr.Dataset) -> list[str]:
    """The observers whose error leaves the axes of the figure."""
    omega = run["omega"].values
    return _figures().leaving(omega, {str(one): omega - run["omega_hat"].sel(observer=one).values
                                      for one in run["observer"].values})


def _figures() -> Any:
    from imo_analysis.report import run_figures

    return run_figures


def keep(folder: Path, name: str, figure: Figure, caption: str) -> Drawn:
    """Write a figure to ``folder``/figures, where there is that folder, and keep its text for the page."""
    from imo_analysis.drawing import svg_text
    from imo_analysis.svg import standalone

    text = svg_text(figure)
    if not (folder / "figures").is_dir():
        return Drawn(text, caption, "")
    place = f"figures/{name}.svg"
    (folder / place).write_text(standalone(text), encoding="utf-8")
    return Drawn(text, caption, place)


def _write(run: xr.Dataset, label: str, study: Study, folder: Path) -> list[tuple[str, str]]:
    """The run and its windows, thinned where they are long."""
    from imo_analysis.simulation.runfile import save_run

    size = run.sizes["time"]
    step, coarse = -(-size // NETCDF_SAMPLES), -(-size // CSV_SAMPLES)
    files = [(f"runs/{label}.nc", f"the whole run, {_share(step)}"), (f"runs/{label}.csv", f"the whole run, {_share(coarse)}")]
    save_run(run.isel(time=slice(None, None, step)), folder / files[0][0])
    save_run(run.isel(time=slice(None, None, coarse)), folder / files[1][0])
    for number, window in enumerate(study.windows, start=1):
        part = run.sel(time=slice(window.start, window.stop))
        if not part.sizes["time"]:
            continue
        step = -(-part.sizes["time"] // NETCDF_SAMPLES)
        place = f"runs/{label}-window{number}.nc"
        save_run(part.isel(time=slice(None, None, step)), folder / place)
        files.append((place, f"{window.start:g} to {window.stop:g} s, {_share(step)}"))
    return files


def _share(step: int) -> str:
    return "every recorded sample" if step == 1 else f"one recorded sample in {step}"


def resting_of(run: xr.Dataset, study: Study, drives: bool = False) -> list[Resting]:
    """The state just before every change of the reference, and at the end: the mean of `STRETCH`, or of a quarter of the time
    since the change before where that is less. ``drives`` as in `resting`."""
    end = float(run["time"].values[-1])
    changes = [time for time in study.reference.time if time - study.simulation.sample_time < end]
    instants = [*(time - study.simulation.sample_time for time in changes[1:]), end]
    return [one for before, instant in zip(changes, instants, strict=True)
            for one in resting(run, study.machine.beta, instant, min(STRETCH, (instant - before) / 4), drives)]


def at_end(scenario: Scenario) -> list[Resting]:
    """Where every observer stands at the end of the run that is drawn."""
    end = scenario.resting[-1].time
    return [one for one in scenario.resting if one.time == end]


def judged(scenario: Scenario) -> list[Resting]:
    """By what every observer is judged: the end of the run, of the one that it drove itself if each had one."""
    return list({one.observer: one for one in scenario.driven}.values()) or at_end(scenario)


def outcome(one: Resting) -> str:
    """Whether an estimate is the speed there, by `imo_analysis.simulation.judge`: tracks, is off, or is lost.

    One that drives must besides bring the machine to the wanted speed.
    """
    if math.isnan(one.omega_hat):
        return "is lost"
    if not math.isnan(one.wanted):
        return "tracks" if holds(one.omega - one.omega_hat, one.rms, one.omega, one.wanted) else "is off"
    return "tracks" if follows(one.omega - one.omega_hat, one.rms, one.omega) else "is off"


def _excitation(run: xr.Dataset, study: Study, label: str, folder: Path, subjects: list[str]) -> Iterator[ExcitationResult]:
    from imo_analysis.excitation.figures import plot_excitation
    from imo_analysis.excitation.signals import of_dataset, select
    from imo_analysis.excitation.trajectory import excitation
    from imo_analysis.excitation.words import summary

    source = of_dataset(run, name=label)
    for subject in subjects:
        result = excitation(select(source, subject), study.excitation.window, every=study.excitation.every,
                            conditions=("printed_19", "reduced"))
        found = summary(result)
        title = f"{study.title} ({'the motion itself' if subject == 'plant' else subject})"
        drawn = keep(folder, f"{label}-excitation-{subject}", plot_excitation(result),
                     captions.excitation(study.title, subject, found))
        yield ExcitationResult(title, found, drawn)


def divergences(study: Study, note: Callable[[str], None]) -> list[Divergence]:
    """What becomes of each observer of the scenario ``divergence``, in the order of the study; none without that scenario.

    The observers do not act on each other, so the run goes on for the others when one is lost.
    """
    from imo_analysis.simulation.run import simulate

    if "divergence" not in study.scenarios:
        return []
    chosen = study.scenario("divergence")
    note(f"divergence: simulating {chosen.simulation.duration:g} s")
    try:
        run = simulate(chosen)
    except Diverged as error:
        if error.data is None:
            raise
        run = error.data
    return [_outcome(run, name, OBSERVERS[settings.kind].meaning) for name, settings in chosen.observers.items()]


def _outcome(run: xr.Dataset, name: str, source: str) -> Divergence:
    """When the speed is lost for good, and apart from that when the integration overflows, which its step decides."""
    time, omega = run["time"].values, run["omega"].values
    error = np.abs(omega - run["omega_hat"].sel(observer=name).values)
    finite = np.isfinite(error)
    near = np.flatnonzero(error <= limit(omega))
    if not finite.all():
        after = f"{time[near[-1]]:.3g} s" if near.size else "the start"
        over = float(time[finite.argmin()])
        return Divergence(name, source, True, over, f"loses the speed for good at {after}: from then on it is "
                          f"off by more than {criterion()}. The integration with its fixed step overflows at {over:.3f} s")
    off = bool(error[-1] > limit(omega[-1]))
    stays = "stays finite and ends off the speed" if off else "stays"
    outcome = f"{stays}; its speed error is {error[-1]:.2g} rad/s after {time[-1]:.3g} s"
    return Divergence(name, source, False, math.nan, outcome, off)
