"""The drive as it is, for the dossier: what each feature of it costs an observer, and where the loop closed on one holds.

Both are computed in the process of `imo_analysis.report.checks` and left as NetCDF beside its JSON; `drawn` reads and draws.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from imo_analysis.equations.own import is_file
from imo_analysis.errors import InputError
from imo_analysis.report.scenarios import Drawn, keep
from imo_analysis.simulation.judge import R_S_OFF
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr

FEATURES, MAP = "features.nc", "sensorless.nc"
LONGEST, LATE = 6.0, 0.25  # s of the run for each feature, and the last share of it over which errors are taken
MOST = 5  # observers of the catalogue in the map: the first of the study; those of the user's own are all in it


@dataclass(frozen=True)
class DriveResult:
    """Both tables with their figures; None where the study gives nothing to compute one from, with the reason for the map."""

    features: xr.Dataset | None
    features_figure: Drawn | None
    map: xr.Dataset | None
    map_figure: Drawn | None
    refused: str
    scenario: str
    files: list[tuple[str, str]]


def featured(study: Study) -> str | None:
    """The scenario (empty: the study itself) with most of what a drive has and the paper leaves out; None without any."""
    from imo_analysis.sweeps.feature_costs import features

    counts = {name: len(features(study.scenario(name) if name else study)) for name in ("", *study.scenarios)}
    most = max(counts, key=lambda name: counts[name])
    return most if counts[most] else None


def mapped(study: Study) -> list[str]:
    """The observers that stand in the map, in the order of the study."""
    first = [name for name, one in study.observers.items() if not is_file(one.kind)][:MOST]
    return [name for name, one in study.observers.items() if name in first or is_file(one.kind)]


def compute(study: Study, folder: Path) -> str:
    """Run both and write them to ``folder``; the text says why there is no map, or is empty."""
    from imo_analysis.simulation.runfile import write_netcdf
    from imo_analysis.sweeps.feature_costs import feature_costs
    from imo_analysis.sweeps.sensorless_map import study_map

    name = featured(study)
    if name is not None:
        chosen = study.scenario(name) if name else study
        stop = min(LONGEST, chosen.simulation.duration)
        short = chosen.changed({"simulation.duration": stop, "windows": []})
        write_netcdf(_with_layers(feature_costs(short, (1 - LATE) * stop, stop), short, study), folder / FEATURES)
    try:
        write_netcdf(study_map(study, mapped(study), jobs=1), folder / MAP)
    except InputError as error:
        return str(error)
    return ""


def _with_layers(costs: xr.Dataset, short: Study, study: Study) -> xr.Dataset:
    """With how far each alpha_hat moves in a sample with everything on, and the layer of (10) in that run and in the study."""
    from imo_analysis.errors import Diverged
    from imo_analysis.simulation.run import simulate

    try:
        run = simulate(short.changed({"simulation.record_every": 1}))
    except Diverged:
        return costs
    step = abs(run["alpha_hat"].diff("time")).max("time")
    layers = [[one.observers[name].gains.get("delta", np.nan) if name in one.observers else np.nan
               for name in short.observers] for one in (short, study)]
    return costs.assign(
        alpha_step=("observer", step.values, {"units": "1/s", "long_name": "largest move of alpha_hat in a sample"}),
        layer=("observer", layers[0], {"units": "1/s", "long_name": "layer of (10)"}),
        layer_of_study=("observer", layers[1], {"units": "1/s", "long_name": "layer of (10) in the study's own observers"}))


def drawn(study: Study, folder: Path, refused: str, keep_files: bool) -> DriveResult:
    """Read what `compute` left in ``folder`` and draw it; without ``keep_files`` the files go."""
    from imo_analysis.report.feature_costs_figure import feature_costs_figure
    from imo_analysis.report.sensorless_figure import sensorless_figure

    features, plane = _read(folder / FEATURES), _read(folder / MAP)
    files = [(FEATURES, "errors with each feature of a drive"), (MAP, "where the loop closed on an estimate holds")]
    files = [one for one in files if (folder / one[0]).is_file()]
    if not keep_files:
        for name, _ in files:
            (folder / name).unlink()
        files = []
    first = keep(folder, "features", feature_costs_figure(features),
                 "Error of the estimated speed with nothing of a real drive, with each part alone, and with all; a cross at "
                 "the right end: the observer diverged.") if features is not None else None
    second = keep(folder, "sensorless", sensorless_figure(plane),
                  f"Error of the speed with the loop closed on each estimate, the observers believing {100 * R_S_OFF:g} % too "
                  "much stator resistance. Hatched: it does not hold. Dashed: zero stator frequency. Made by "
                  "`imo sweep study.toml --sensorless --plot map.svg`.") if plane is not None else None
    name = featured(study) or ""
    title = (study.scenario(name) if name else study).title  # without features nothing shows it
    return DriveResult(features, first, plane, second, refused, title, files)


def _read(path: Path) -> xr.Dataset | None:
    import xarray as xr

    return xr.load_dataset(path, engine="h5netcdf") if path.is_file() else None
