"""What each thing that a drive has and the paper leaves out costs each observer: one at a time, and all at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.errors import Diverged, InputError
from imo_analysis.simulation.run import provenance, simulate
from imo_analysis.study import Study
from imo_analysis.study_realism import Inverter, Mechanics, Saturation
from imo_analysis.study_tables import Sensors

if TYPE_CHECKING:
    import xarray as xr

NONE, ALL = "none", "all"
_LINK = ("dc_link", "limit", "carriers")
# feature -> the keys of the study that make it
_FEATURES: dict[str, tuple[str, ...]] = {
    "sampled currents": ("sensors.sampling",),
    "current noise": ("sensors.current_noise",),
    "current offset": ("sensors.current_offset",),
    "current gain": ("sensors.current_gain",),
    "current resolution": ("sensors.current_resolution",),
    "delay": ("inverter.delay",),
    "switching": (*(f"inverter.{key}" for key in _LINK), "inverter.pwm"),
    "dead time": (*(f"inverter.{key}" for key in _LINK), "inverter.dead_time"),
    "dry friction": ("mechanics.coulomb", "mechanics.coulomb_speed"),
    "elastic shaft": ("mechanics.load_share", "mechanics.stiffness", "mechanics.damping"),
    "saturation": ("saturation.knee", "saturation.power", "saturation.flux", "saturation.current"),
    "drive's parameters": ("drive.errors",),
}
# What is one physical cause is one feature.
_ERRORS = {"stator resistance": ("R_s",), "rotor resistance": ("R_r",), "inductances": ("L_m", "L_s", "L_r")}


def feature_costs(study: Study, start: float, stop: float, progress: Callable[[str], None] | None = None) -> xr.Dataset:
    """Run a study with none of its features, with each alone, and with all.

    Parameters
    ----------
    study : Study
        With the features on, such as the scenario ``real`` of the paper's study. Features that it has not are left out.
    start, stop : float
        Stretch of the run in s over which errors are taken.
    progress : callable, optional
        Called with the name of each feature before its run.

    Returns
    -------
    xarray.Dataset
        Dimensions ``feature`` and ``observer``. ``speed_error``: mean of omega_hat - omega in rad/s; ``speed_ripple``: standard
        deviation of it; ``alpha_hat``: its mean in 1/s, NaN where there is none. All are NaN where the observer diverged.

    Raises
    ------
    InputError
        If the stretch holds no record, or the study has no observers.
    """
    step = study.simulation.sample_time * study.simulation.record_every
    if not 0 <= start < stop <= study.simulation.duration or stop - start < 2 * step:
        raise InputError(f"start = {start:g} s and stop = {stop:g} s must lie in the run of {study.simulation.duration:g} s, "
                         f"{2 * step:g} s or more apart")
    if not study.observers:
        raise InputError("the study has no observers to compare; add a table [observers.NAME]")
    ideal, alone = _ideal(study), _alone(study)
    names = [NONE, *alone, ALL]
    found = np.full((3, len(names), len(study.observers)), np.nan)
    for n, name in enumerate(names):
        if progress:
            progress(name)
        one = study if name == ALL else ideal.changed(alone.get(name, {}))
        try:
            run = simulate(one)
        except Diverged as fault:
            run = fault.data
        error = (run["omega_hat"] - run["omega"]).sel(time=slice(start, stop))
        if error.sizes["time"] > 1:
            found[0, n], found[1, n] = error.mean("time", skipna=False), error.std("time", skipna=False)
            found[2, n] = run["alpha_hat"].sel(time=slice(start, stop)).mean("time", skipna=False)
    return _labelled(study, names, found, (start, stop))


def features(study: Study) -> list[str]:
    """What a drive has and the paper leaves out that this study has, by name."""
    return list(_alone(study))


def _ideal(study: Study) -> Study:
    """The study with every feature off."""
    off: dict[str, Any] = {}
    tables = {"sensors": Sensors(), "inverter": Inverter(), "mechanics": Mechanics(), "saturation": Saturation()}
    for table, defaults in tables.items():
        off |= {f"{table}.{key}": list(value) if isinstance(value, tuple) else value for key, value in vars(defaults).items()}
    off["drive.errors"] = dict.fromkeys(study.drive.errors, 0.0)
    for name, settings in study.observers.items():
        off[f"observers.{name}.errors"] = dict.fromkeys(settings.errors, 0.0)
    return study.changed(off)


def _alone(study: Study) -> dict[str, dict[str, Any]]:
    """For each feature that the study has, the changes that bring it back."""
    ideal = _ideal(study)
    found = {}
    for name, keys in _FEATURES.items():
        changes = {key: _value(study, key) for key in keys}
        own = keys[-1:] if name in ("switching", "dead time") else keys
        if any(_value(study, key) != _value(ideal, key) for key in own):
            found[name] = changes
    for name, parameters in _ERRORS.items():
        changes = {f"observers.{one}.errors.{key}": settings.errors[key] for one, settings in study.observers.items()
                   for key in parameters if settings.errors.get(key)}
        if changes:
            found[name] = changes
    return found


def _value(study: Study, dotted: str) -> Any:
    table, key = dotted.split(".")
    value = getattr(getattr(study, table), key)
    return list(value) if isinstance(value, tuple) else value


def _labelled(study: Study, names: list[str], found: Any, stretch: tuple[float, float]) -> xr.Dataset:
    import xarray as xr

    axes = ("feature", "observer")
    return xr.Dataset(
        {
            "speed_error": (axes, found[0], {"units": "rad/s", "long_name": "mean error of the estimated speed"}),
            "speed_ripple": (axes, found[1], {"units": "rad/s", "long_name": "standard deviation of that error"}),
            "alpha_hat": (axes, found[2], {"units": "1/s", "long_name": "mean estimate of alpha"}),
        },
        {"feature": names, "observer": list(study.observers)},
        {**provenance(study), "schema": "imo-feature-costs/1", "start": stretch[0], "stop": stretch[1],
         "alpha": study.machine.alpha},
    )
