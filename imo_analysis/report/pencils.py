"""Poles for the dossier: Table II beside what is computed, the sweep over the speed, and their files."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.machine import InductionMachine
from imo_analysis.report.paper_machine import is_paper
from imo_analysis.report.scenarios import Drawn
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr

TABLE2_FIELDS = ("observer", "kind", "column", "omega", "pole", "computed_re", "computed_im", "printed_re", "printed_im",
                 "difference", "quadratic_re", "quadratic_im")


@dataclass(frozen=True)
class PoleResult:
    """What the dossier shows of the poles.

    Attributes
    ----------
    table : xarray.Dataset
        From `imo_analysis.pencils.table2.table2`.
    sweep : xarray.Dataset
        From `imo_analysis.pencils.sweep.pole_sweep`, over the speed.
    figures : list of Drawn
    files : list of (str, str)
    found : list of str
        Findings in sentences.
    unstable : dict of str to list of (float, float)
        By observer, the speeds (first and last of each run of them, rad/s) with a pole in the right half plane.
    """

    table: xr.Dataset
    sweep: xr.Dataset
    figures: list[Drawn]
    files: list[tuple[str, str]]
    found: list[str]
    unstable: dict[str, list[tuple[float, float]]]


def observers_of(study: Study) -> tuple[dict[str, InductionMachine], dict[str, tuple[str, Mapping[str, float]]]]:
    """Machines and (kind, gains) by label: the study's observers, and those that its scenarios add."""
    machines: dict[str, InductionMachine] = {}
    observers: dict[str, tuple[str, Mapping[str, float]]] = {}
    for one in (study, *(study.scenario(name) for name in study.scenarios)):
        for label, settings in one.observers.items():
            if label not in observers:
                machines[label] = one.observer_machine(label)
                observers[label] = (settings.kind, settings.gains)
    return machines, observers


def pencils(study: Study, folder: Path, sweeps: bool = True) -> PoleResult:
    """Compute the poles and write ``table2.csv``, the figures and, with ``sweeps``, ``poles.nc`` and ``poles.csv``."""
    from imo_analysis.drawing import rasterized
    from imo_analysis.pencils.maps import plot_against, plot_plane
    from imo_analysis.pencils.setup import Setup
    from imo_analysis.pencils.sweep import grid, pole_sweep
    from imo_analysis.pencils.table2 import table2
    from imo_analysis.report.scenarios import keep
    from imo_analysis.simulation.runfile import write_netcdf

    machines, observers = observers_of(study)
    table = table2(study.machine, observers, study.poles.omega)
    span = study.poles.sweep
    setups = {label: Setup(kind, machines[label], gains) for label, (kind, gains) in observers.items()}
    sweep = pole_sweep(setups, {"omega": grid(span.start, span.stop, span.count, "poles.sweep")}).data
    write_table2(table, folder / "table2.csv")
    files = [("table2.csv", "Table II beside the computed poles")]
    if sweeps:
        write_netcdf(sweep.assign_coords(neutral=sweep["neutral"].astype("int8")), folder / "poles.nc")
        write_sweep(sweep, folder / "poles.csv")
        files += [("poles.nc", "poles over the speed sweep"), ("poles.csv", "the same as text")]
    figures = [
        keep(folder, "poles-plane", rasterized(plot_plane(sweep, marks=study.poles.omega)),
             f"Paths of the poles from {span.start:g} to {span.stop:g} rad/s, a panel an observer, each with axes of its own."
             + _mirrored(sweep)),
        keep(folder, "poles-speed", plot_against(sweep),
             "Real and imaginary parts over the speed. A real part above zero means that the observer, held at that speed, is "
             "unstable."),
    ]
    unstable = {str(name): unstable_speeds(sweep.sel(observer=name)) for name in sweep["observer"].values}
    return PoleResult(table, sweep, figures, files, _found(table, unstable, is_paper(study.machine)), unstable)


def _mirrored(sweep: xr.Dataset) -> str:
    """Whose poles at a negative speed are the mirror images of those at the positive one; about none if the sweep is uneven."""
    omega = sweep["omega"].values
    if not np.allclose(omega, -omega[::-1]):
        return ""
    odd = []
    for name in sweep["observer"].values:
        one = sweep.sel(observer=name)
        roots = one["re"].values + 1j * one["im"].values  # (omega, branch), where the order of the branches says nothing
        here, there = (np.sort_complex(np.round(part, 6)) for part in (roots, roots.conj()[::-1]))
        if not np.allclose(here, there, atol=1e-4 * float(np.nanmax(np.abs(roots))), equal_nan=True):
            odd.append(f"`{name}`")
    if len(odd) == sweep.sizes["observer"]:
        return " The two directions of rotation differ."
    return " Negative speeds mirror positive ones at the real axis" + (f", but not for {', '.join(odd)}." if odd else ".")


def rightmost(sweep: xr.Dataset) -> Any:
    """The largest real part among the poles of one observer that are not zero at every speed, over the speed (1/s)."""
    return sweep["re"].where(moving(sweep)).max("branch")


def moving(sweep: xr.Dataset) -> Any:
    """Which branches of one observer are not zero at every speed."""
    size: Any = np.hypot(sweep["re"], sweep["im"])
    return size.max("omega") > 1e-9 * float(size.max())


def unstable_speeds(sweep: xr.Dataset) -> list[tuple[float, float]]:
    """Runs of neighbouring speeds of a sweep at which a pole lies to the right of zero, beyond rounding."""
    omega = sweep["omega"].values
    bad = rightmost(sweep).values > 1e-9 * float(np.nanmax(np.hypot(sweep["re"].values, sweep["im"].values)))
    runs: list[tuple[float, float]] = []
    for speed, is_bad, before in zip(omega, bad, [False, *bad[:-1]], strict=True):
        if is_bad:
            runs.append((runs.pop()[0] if before else float(speed), float(speed)))
    return runs


def _found(table: xr.Dataset, unstable: dict[str, list[tuple[float, float]]], papers: bool) -> list[str]:
    largest = {str(name): float(table["difference"].sel(observer=name).max()) for name in table["observer"].values}
    known = {name: value for name, value in largest.items() if np.isfinite(value)}
    found = []
    if known and papers:
        name = min(known, key=lambda one: known[one])
        found.append(f"Table II: no observer of the study has the printed eigenvalues; the nearest, `{name}`, is off by up to "
                     f"{known[name]:.3g} /s." if known[name] > 0.01 else f"Table II: `{name}` has the printed eigenvalues.")
    bad = [f"`{name}`" for name, runs in unstable.items() if runs]
    if bad:
        have = "has" if len(bad) == 1 else "have"
        found.append(f"Frozen at a speed of the sweep, {', '.join(bad)} {have} a pole in the right half plane.")
    return found


def write_table2(table: xr.Dataset, path: Path) -> None:
    """Table II as CSV, one line a pole; empty where the paper prints nothing."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([name + _unit(name) for name in TABLE2_FIELDS])
        for name in table["observer"].values:
            for omega in table["omega"].values:
                for pole in table["pole"].values:
                    one = table.sel(observer=name, omega=omega, pole=pole)
                    writer.writerow([str(one[field].values) if field in ("observer", "kind", "column") else _text(one[field])
                                     for field in TABLE2_FIELDS])


def _unit(name: str) -> str:
    if name == "omega" or name.endswith("_im"):
        return " (rad/s)"
    return " (1/s)" if name.endswith("_re") or name == "difference" else ""


def _text(value: Any) -> str:
    number = float(value)
    return "" if np.isnan(number) else f"{number:.10g}"


def write_sweep(sweep: xr.Dataset, path: Path) -> None:
    """The sweep as CSV, one line a speed and observer, real and imaginary part of each branch in turn."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        branches = [int(branch) for branch in sweep["branch"].values]
        writer.writerow(["observer", "omega (rad/s)", *(f"{part}_{b} ({unit})" for b in branches
                                                        for part, unit in (("re", "1/s"), ("im", "rad/s")))])
        for name in sweep["observer"].values:
            one = sweep.sel(observer=name)
            columns = np.stack([one["re"].values, one["im"].values], axis=-1).reshape(len(one["omega"]), -1)
            for omega, row in zip(one["omega"].values, columns, strict=True):
                writer.writerow([name, f"{omega:.6g}", *("" if np.isnan(v) else f"{v:.8g}" for v in row)])
