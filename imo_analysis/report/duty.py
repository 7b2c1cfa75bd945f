"""Mixed duty with noise and a pause of the modulation: the paper's alpha law against one that a supervisor stops."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.drawing import LIMIT, in_style, legend_above, line, new_figure
from imo_analysis.errors import Diverged, InputError
from imo_analysis.report.numbers import number
from imo_analysis.report.scenarios import Drawn, keep
from imo_analysis.study import Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imo_analysis.excitation.design import Design

HOUR, LEAST, RUNS = 3600.0, 300.0, 60.0  # s; s; lengths of the study's own run, within these two
SETTLED, EDGE = 30.0, 5.0  # s: to converge at the start and after the pause, and for the supervisor to see the loss
SHOWN = ("consistent_12", "repaired", "quiet", "supervised")
_DRAWN = ("consistent_12", "repaired", "supervised")  # quiet goes too far in the pause for a common axis


@dataclass(frozen=True)
class DutyRow:
    """An observer: how far its alpha_hat is off at most with the modulation, at the end of the pause, and how far it went."""

    observer: str
    excited: float
    end_of_pause: float
    moved: float
    back: float


@dataclass(frozen=True)
class Duty:
    """The run's length, its pause, a row for each of `SHOWN`, and the figure; for the supervisor's threshold see `Threshold`.

    ``rest`` (1/s) is what noise may move alpha_hat by, ``opens`` the gate that the modulation must reach.
    """

    duration: float
    pause: tuple[float, float]
    noise: float
    rows: list[DutyRow]
    figure: Drawn
    S_0: float
    floor: float
    least: float
    most: float
    rest: float
    opens: float


def duty(study: Study, found: Design, folder: Path, noise: float) -> Duty | str:
    """Simulate up to an hour of mixed duty with a designed modulation that pauses; a sentence where that is not possible."""
    from imo_analysis.excitation.duty import REST, mixed_duty, supervisor_threshold
    from imo_analysis.excitation.supervision import OPEN
    from imo_analysis.simulation.run import simulate

    length = min(HOUR, max(LEAST, RUNS * study.simulation.duration))
    pause = (length / 3, length * 2 / 3)
    try:
        mixed = mixed_duty(study, length, noise=noise, depth=found.depth, frequency=found.frequency,
                           waveform=found.waveform, off=pause)
        run = simulate(mixed.only(list(SHOWN)))
    except InputError as fault:
        return f"There is no run of mixed duty: {fault}."
    except Diverged as fault:
        return f"The run of mixed duty is not shown: {fault}."
    error = run["alpha_hat"] - study.machine.alpha
    rows = []
    for name in SHOWN:
        one = error.sel(observer=name)
        lost = one.sel(time=slice(pause[0] + EDGE, pause[1])).values
        rows.append(DutyRow(
            name, float(np.abs(one.sel(time=slice(SETTLED, pause[0]))).max()), float(lost[-1]), float(np.ptp(lost)),
            float(np.abs(one.sel(time=slice(pause[1] + SETTLED, None))).max())))
    gains = mixed.observers["supervised"].gains
    found_at = supervisor_threshold(study, gains, noise, length, found.depth, found.frequency, found.waveform)
    S_0 = gains["S_0"]
    moved = ", ".join(f"{number(row.moved, 2)} /s (`{row.observer}`)" for row in rows)
    caption = (f"The estimate of alpha over {number(length, 4)} s of random speeds and loads with {noise:g} A of noise; the "
               f"flux is modulated, but not from {number(pause[0], 4)} to {number(pause[1], 4)} s. Below: what the supervisor "
               f"sees, and its threshold. In the pause, alpha_hat moves by {moved}; "
               "`quiet` is in the table only.")
    drawn = keep(folder, "duty", _drawn(run, study.machine.alpha, S_0, pause), caption)
    return Duty(length, pause, noise, rows, drawn, S_0, found_at.floor, found_at.least, found_at.most, REST, OPEN)


@in_style
def _drawn(run: Any, alpha: float, S_0: float, pause: tuple[float, float]) -> Figure:
    figure, (above, below) = new_figure(2, 1, height=4.3, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    thin = run.isel(time=slice(None, None, max(1, run.sizes["time"] // 1500)))
    for name in _DRAWN:
        above.plot(thin["time"], thin["alpha_hat"].sel(observer=name), label=name, **line(name).kwargs())
    above.axhline(alpha, color=LIMIT.color, linestyle=LIMIT.linestyle, linewidth=1.0, label="true value")
    above.set_ylabel(r"$\hat{\alpha}$ (1/s)")
    below.semilogy(thin["time"], np.maximum(thin["S"].sel(observer="supervised"), 1e-2), **line("supervised").kwargs())
    below.axhline(S_0, color=LIMIT.color, linestyle=LIMIT.linestyle, linewidth=1.0)
    below.set_ylabel(r"$S$ (A$^2$)")
    below.set_xlabel("time (s)")
    for axes in (above, below):
        axes.axvspan(*pause, color="0.9", zorder=0)
        axes.margins(x=0.01)
    legend_above(above, ncols=4)
    return figure
