"""What can be told apart in principle: ranks for every combination of unknowns, and bounds over operating points."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from imo_analysis.equations.steady_state import slip_of_torque
from imo_analysis.notation import symbol
from imo_analysis.report.gram_table import GramRow, gram_rows
from imo_analysis.report.numbers import number
from imo_analysis.report.scenarios import Drawn, keep
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr

KNOWN = (0.1, 0.7)  # 1/s, rad/s: a third of the accuracy that a modulation is designed for, as three deviations must fit
REACH = 1.5  # the torques go to so many times that at which the torque current is as large as the magnetising one
DEPTH, FREQUENCY = 0.05, 30.0  # of the flux modulation in the map: 5 %, 30 rad/s


@dataclass(frozen=True)
class RankRow:
    """Which quantities are unknown, the rank that tells all apart, and the rank on each family of motions.

    ``steady`` is the rank in steady state, decided exactly, and ``drops`` what is zero where it is lower still.
    """

    unknown: tuple[str, ...]
    needed: int
    ranks: dict[str, int]
    steady: int
    drops: tuple[str, ...]


@dataclass(frozen=True)
class Identifiability:
    """Ranks with the speed as a constant parameter and with the speed row of (1), figures of the maps, and Gram matrices.

    ``instant`` is `observability.instant_determinant` in LaTeX.
    """

    constant_speed: list[RankRow]
    mechanical: list[RankRow]
    instant: str
    figures: list[Drawn]
    grams: list[GramRow]


def identifiability(study: Study, folder: Path) -> Identifiability:
    """Compute ranks and maps for the study's machine and flux, and write the figures to ``folder``."""
    from imo_analysis.drawing import rasterized
    from imo_analysis.excitation.bounds import Measurement
    from imo_analysis.excitation.map_figures import plot_kinds, plot_modulation, plot_speed_torque
    from imo_analysis.excitation.maps import modulation_map, speed_torque_map

    flux, span = study.drive.flux, study.poles.sweep
    machine = study.machine
    torque = REACH * machine.alpha / slip_of_torque(1.0, flux, machine.n_p, machine.L_r, machine.alpha)
    speeds, torques = _even(span.start, span.stop, 61), _even(-torque, torque, 41)
    constant = speed_torque_map(study.machine, speeds, torques, flux=flux)
    modulated = speed_torque_map(study.machine, speeds, torques, flux=flux, depth=DEPTH, frequency=FREQUENCY)
    omega, seen = max(study.poles.omega), Measurement().duration
    depths, frequencies = np.geomspace(0.001, 0.3, 25).tolist(), np.geomspace(2 * np.pi / seen, 300.0, 25).tolist()
    swing = modulation_map(study.machine, depths, frequencies, omega=omega, flux=flux)
    figures = [
        keep(folder, "identifiability-plane", rasterized(plot_speed_torque(constant, modulated)),
             "Smallest standard deviation that an unbiased estimate of speed or alpha can have (the Cramér-Rao bound), over "
             "speed and torque: dark is poor. Above: one unknown at a time, constant flux; at zero stator frequency it is "
             "lost, alpha without load as well. Below: both unknown, with the flux in motion; the median over the plane is "
             f"{_median(modulated['alpha_both'])} /s for alpha and {_median(modulated['omega_both'])} rad/s for the speed. The "
             "bounds are those of a long time; nearer to zero stator frequency than a period in the time of the record they "
             "promise too much."),
        keep(folder, "identifiability-modulation", rasterized(plot_modulation(swing)),
             f"The same bounds at {omega:g} rad/s without load, over depth and frequency of a flux modulation: that of alpha "
             f"{_range(swing['alpha_both'])} /s, that of the speed {_range(swing['omega_both'])} rad/s. They are those "
             f"of a long time; the figure begins where {seen:g} s hold a whole period, for with less they promise too much."),
        keep(folder, "identifiability-kinds", rasterized(plot_kinds(constant, modulated, KNOWN)),
             f"What can be known in {seen:g} s: a quantity counts as known where its bound is at most {KNOWN[0]:.2g} /s "
             f"(alpha) or {KNOWN[1]:.2g} rad/s (omega). “Either, not both”: each is, but only while the other is given. "
             "On the line of zero stator frequency, which is thinner than the grid, constant flux shows neither."),
    ]
    return Identifiability(_ranks(False), _ranks(True), _instant(), figures, gram_rows(study, DEPTH, FREQUENCY))


def _median(bound: xr.DataArray) -> str:
    return number(float(np.median(np.nan_to_num(bound.values, nan=np.inf))), 2)


def _range(bound: xr.DataArray) -> str:
    """From the worst to the best."""
    values = bound.values[np.isfinite(bound.values)]
    worst, best = number(float(values.max()), 2), number(float(values.min()), 2)
    return f"stays at {worst}" if worst == best else f"falls from {worst} to {best}"


def _even(start: float, stop: float, count: int) -> list[float]:
    values: list[float] = np.linspace(start, stop, count).tolist()
    return values


def _instant() -> str:
    from sympy import latex

    from imo_analysis.excitation.observability import instant_determinant

    found = instant_determinant()
    special = {"omega_dot": r"\dot{\omega}", "slip": symbol("slip").latex}
    written: str = latex(found, symbol_names={one: special[one.name] for one in found.free_symbols if one.name in special})
    return written


def _ranks(mechanical: bool) -> list[RankRow]:
    from imo_analysis.excitation.observability import rank_table, steady_conditions

    rows = []
    for row in rank_table(mechanical):
        steady, factors = steady_conditions(row.problem)
        rows.append(RankRow(row.problem.unknown, row.size, row.ranks, steady, tuple(str(factor) for factor in factors)))
    return rows
