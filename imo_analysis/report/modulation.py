"""The flux modulation that makes alpha identifiable for the study's drive: designed, checked in closed loop, drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from imo_analysis.drawing import LIMIT, TRUTH, in_style, legend_above, line, new_figure
from imo_analysis.errors import Diverged, InputError
from imo_analysis.report.duty import Duty, duty
from imo_analysis.report.numbers import number
from imo_analysis.report.scenarios import Drawn, keep
from imo_analysis.simulation.summary import STRETCH
from imo_analysis.study import Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imo_analysis.excitation.choice import Chosen
    from imo_analysis.excitation.design import Design, Plant, Wanted
    from imo_analysis.excitation.design_check import Check

TORQUE_LIMIT = 0.01  # of the largest load: half the swing of the torque


@dataclass(frozen=True)
class Modulation:
    """A design for one observer with its check in closed loop; ``refused`` says why there is none.

    ``chosen`` has the slowest decay of the range too, and how many cheaper ones were passed over; ``failed`` is how many missed
    in closed loop. ``frequencies`` (rad/s) were tried. ``others`` are the designs that other laws with the same gains would
    need, or why there is none. ``duty`` is the mixed duty, or why it is not shown.
    """

    observer: str
    wanted: Wanted
    chosen: Chosen | None = None
    checks: Sequence[Check] = ()
    failed: int = 0
    frequencies: tuple[float, float] = (0.0, 0.0)
    figure: Drawn | None = None
    waveforms: Sequence[Design] = ()
    duty: Duty | str = ""
    refused: str = ""
    others: Sequence[tuple[str, Design | str]] = ()

    @property
    def design(self) -> Design | None:
        """The design itself."""
        return self.chosen.design if self.chosen else None


def modulation(study: Study, folder: Path) -> Modulation | None:
    """Design, simulate with noise and draw; None where the study has no observer that a design is known for."""
    from imo_analysis.excitation.choice import cheapest_by_waveform
    from imo_analysis.excitation.design import search
    from imo_analysis.excitation.design_check import plant_of, verified, wanted_of
    from imo_analysis.excitation.settling import KINDS

    names = [name for name, settings in study.observers.items() if settings.kind in KINDS]
    if not names or study.drive.flux_modulation > 0:
        return None
    name = names[0]
    wanted = wanted_of(study, name, torque_limit=TORQUE_LIMIT * study.largest_torque)
    plant = plant_of(study, name)
    try:
        able, deepest = search(plant, wanted)
        taken = verified(study, name, wanted, able, deepest)
        found = taken.chosen.design
        picture, ends = _drawn(study, found, name, wanted)
        caption = (f"The estimate of alpha of `{name}` with {wanted.noise:g} A of noise and steps of the speed. It ends "
                   f"{number(ends[0], sign=True)} /s off with constant flux, {number(ends[1], sign=True)} /s with the designed "
                   "modulation.")
        drawn = keep(folder, "modulation", picture, caption)
    except InputError as error:
        return Modulation(name, wanted, refused=str(error))
    except Diverged as error:
        return Modulation(name, wanted, refused=f"no modulation is shown, for in closed loop with the designed one {error}")
    tried = [one.frequency for one in (*able, *deepest)]
    return Modulation(name, wanted, taken.chosen, taken.checks, taken.failed, (min(tried), max(tried)), drawn,
                      cheapest_by_waveform(plant, able, wanted), duty(study, found, folder, wanted.noise),
                      others=_others(plant, wanted))


def _others(plant: Plant, wanted: Wanted) -> list[tuple[str, Design | str]]:
    """Designs for the other laws that take the same gains, or why there is none."""
    from imo_analysis.excitation.choice import design

    rows: list[tuple[str, Design | str]] = []
    for kind in ("repaired", "quiet", "across"):
        if kind != plant.kind:
            try:
                rows.append((kind, design(replace(plant, kind=kind), wanted)[0].design))
            except InputError as error:
                rows.append((kind, str(error)))
    return rows


def _drawn(study: Study, found: Any, name: str, wanted: Wanted) -> tuple[Figure, tuple[float, ...]]:
    """Simulate steps between the speeds of the range, without and with the modulation, and draw alpha_hat.

    Beside the figure: how far alpha_hat is off in the mean of the last `STRETCH`, without and with it, in 1/s.
    """
    from imo_analysis.excitation.design_check import modulated_study
    from imo_analysis.simulation.run import simulate

    speeds = [*wanted.speeds, wanted.speeds[0]]
    plain = study.only([name]).changed({
        "sensors.current_noise": wanted.noise, "reference.shape": "steps", "reference.omega": speeds,
        "reference.time": [wanted.time * step for step in range(len(speeds))],
        "simulation.duration": wanted.time * len(speeds)})
    alpha, runs = study.machine.alpha, (simulate(plain), simulate(modulated_study(plain, found)))
    ends = (run["alpha_hat"].sel(observer=name, time=slice(float(run["time"][-1]) - STRETCH, None)) for run in runs)
    return _figure(*runs, name, alpha), tuple(float(end.mean()) - alpha for end in ends)


@in_style
def _figure(plain: Any, modulated: Any, name: str, alpha: float) -> Figure:
    figure, (above, below) = new_figure(2, 1, height=3.9, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    grey = {"color": "#6f6f6f", "linestyle": (0, (5, 2))}
    for run, label, look in ((plain, "constant flux", grey), (modulated, "modulated flux", line(name).kwargs())):
        thin = run.sel(observer=name).isel(time=slice(None, None, max(1, run.sizes["time"] // 1500)))
        above.plot(thin["time"], thin["alpha_hat"], label=label, **look)
    above.axhline(alpha, color=LIMIT.color, linestyle=LIMIT.linestyle, linewidth=1.0, label="true value")
    below.plot(thin["time"], thin["omega"], color=TRUTH.color)
    above.set_ylabel(r"$\hat{\alpha}$ (1/s)")
    below.set_ylabel("speed (rad/s)")
    below.set_xlabel("time (s)")
    above.margins(x=0.01)
    legend_above(above)
    return figure
