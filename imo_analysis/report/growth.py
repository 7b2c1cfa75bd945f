"""V along a run, by the definitions that the ledger proves: (13) for the paper's observer, its own for the repaired one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.drawing import in_style, legend_above, line, new_figure, points
from imo_analysis.equations import lyapunov, transformation
from imo_analysis.report.numbers import number
from imo_analysis.report.scenarios import Drawn, keep
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

SCENARIO = "lyapunov"
RISES = 1 + 1e-9  # above it V has grown, and not by rounding


@dataclass(frozen=True)
class Growth:
    """V of one observer along the scenario ``lyapunov``.

    Attributes
    ----------
    observer : str
    time : array
        In s; up to where V stops being defined.
    V : array
        In A^2.
    rise : float
        Largest V over V at an earlier time; 1 if it never rises.
    crossing : float
        When omega_hat passes zero, in s, where (13) divides by zero and V changes sign; NaN if it does not, or if V does not
        contain omega_hat.
    """

    observer: str
    time: NDArray[np.float64]
    V: NDArray[np.float64]
    rise: float
    crossing: float


def lyapunov_along(run: xr.Dataset, study: Study, name: str) -> NDArray[np.float64]:
    """V of an adaptive observer along a run, in A^2: (13) with its slip put right, or the repaired observer's."""
    machine, settings = study.machine, study.observers[name]
    one, gains = run.sel(observer=name), settings.gains

    def of(variable: str) -> Any:
        return (one if variable in ("alpha_hat", "omega_hat") or variable.endswith("_hat") else run)[variable].values

    z = transformation.to_z(of("i_ds"), of("i_qs"), of("phi_dr"), of("phi_qr"), machine.beta)
    errors = (
        of("i_ds") - of("i_ds_hat"), of("i_qs") - of("i_qs_hat"), z[0] - of("z_1_hat"), z[1] - of("z_2_hat"),
        z[0] - of("xi_1_hat"), z[1] - of("xi_2_hat"), machine.alpha - of("alpha_hat"), of("omega") - of("omega_hat"),
    )
    omega = of("omega")
    function: Callable[..., Any]
    if settings.kind == "repaired":
        function, special = lyapunov.with_direction, (np.sign(omega), gains["kappa"])
    else:
        function, special = lyapunov.corrected_13, (of("omega_hat"), gains["k_2"])
    values: NDArray[np.float64] = function(*errors, machine.alpha, omega, *special, gains["k_3"], gains["g"], gains["K_p"])
    return values


def growth(study: Study, folder: Path) -> tuple[list[Growth], Drawn | None]:
    """V along the scenario ``lyapunov`` for every adaptive observer, with its figure; nothing without that scenario."""
    from imo_analysis.simulation.run import simulate

    if SCENARIO not in study.scenarios:
        return [], None
    chosen = study.scenario(SCENARIO)
    run = simulate(chosen)
    found = []
    for name, settings in chosen.observers.items():
        if "K_p" in settings.gains and "k_3" in settings.gains:
            values, time = lyapunov_along(run, chosen, name), run["time"].values
            crossing = float("nan")
            if settings.kind != "repaired":
                wrong = run["omega"].values * run["omega_hat"].sel(observer=name).values <= 0
                if wrong.any():
                    first = int(wrong.argmax())
                    crossing, values, time = float(time[first]), values[:first], time[:first]
            rise = float(np.max(values / np.minimum.accumulate(values)))
            found.append(Growth(name, time, values, rise, crossing))
    said = "; ".join(f"`{one.observer}`: V " + (f"rises to {number(one.rise)} times an earlier value" if one.rise > RISES
                                                else "never rises") for one in found)
    caption = f"V over time, relative to its start, while the speed is constant. {said}."
    return found, keep(folder, "lyapunov", growth_figure(found), caption)


@in_style
def growth_figure(found: list[Growth]) -> Figure:
    """V over its value at the start, a line an observer."""
    figure, axes = new_figure(height=2.9)
    for one in found:
        axes.plot(1e3 * one.time, one.V / one.V[0], label=one.observer, **line(one.observer).kwargs())
        if not np.isnan(one.crossing):
            axes.axvline(1e3 * one.crossing, color=line(one.observer).color, linewidth=0.8, linestyle=":")
            axes.annotate(r"$\hat{\omega}$ passes zero: V has a pole", (1e3 * one.crossing, 1.0), xytext=(5, 12),
                          textcoords="offset points", fontsize=points(8))
    axes.axhline(1.0, color="#7a7a7a", linewidth=0.7)
    axes.set_xlabel("time (ms)")
    axes.set_yscale("log")
    axes.set_ylabel("V(t) / V(0)  (1)")
    axes.margins(x=0.01)
    legend_above(axes)
    return figure
