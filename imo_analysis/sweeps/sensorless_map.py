"""Where the loop closed on an estimate holds: speed against load torque, regenerating and near zero stator frequency included.

At every point of the map a drive starts magnetised at standstill with right estimates, goes to its speed along a line, is then
loaded along a line, and holds both. Nothing but the estimates of speed and flux, and the speed reference for the direction of
rotation, closes the loop. It holds where at the end of that the speed is still the wanted one and the estimate the true one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.steady_state import current_of_flux, slip_of_torque
from imo_analysis.errors import InputError
from imo_analysis.simulation.run import provenance
from imo_analysis.study import Study
from imo_analysis.sweeps.batch import run_batch

if TYPE_CHECKING:
    import xarray as xr

# Times in s: the speed goes from START to TURNED, the load from LOAD to LOADED.
START, TURNED, LOAD, LOADED = 0.2, 1.2, 1.5, 2.5


def sensorless_map(
    study: Study,
    omega: Sequence[float],
    T_l: Sequence[float],
    *,
    observers: Sequence[str] = (),
    direction: str = "reference",
    hold: float = 2.0,
    band: float = 2.0,
    jobs: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> xr.Dataset:
    """Close the loop on each observer in turn, at every pair of speed and load torque.

    Parameters
    ----------
    study : Study
        Machine, drive, gains, and alpha_hat at the start. Its reference, load and other initial values are not used.
    omega, T_l : sequence of float
        Electrical speeds in rad/s and load torques in N m.
    observers : sequence of str
        Which; all where left out.
    direction : str
        Whence the observers have the direction of rotation: ``reference``, ``estimate`` or ``true``.
    hold : float
        How long in s speed and load are held; errors are taken over the second half of that.
    band : float
        Largest error of the speed in rad/s with which the loop counts as holding.
    jobs : int, optional
        Threads; one for each processor where left out.
    progress : callable, optional
        Called with the number of machine-samples done since the last call.

    Returns
    -------
    xarray.Dataset
        Dimensions ``observer``, ``T_l`` (N m), ``omega`` (rad/s). ``speed_error`` is the larger of the peak of
        |omega_hat - omega| and the final |omega - reference|, in rad/s, infinite where something diverged; ``holds`` is 1 where
        that is within ``band``, else 0; ``stator_frequency`` (T_l, omega) is that of the wanted state in rad/s.

    Raises
    ------
    InputError
        For an empty axis, an unknown observer or direction, a hold that is too short, or a study with what a batch cannot have.
    """
    names = list(observers or study.observers)
    if not len(omega) or not len(T_l) or not names:
        raise InputError(
            f"the map has {len(omega)} speeds, {len(T_l)} torques and {len(names)} observers; there must be 1 or more of each")
    if not hold >= 0.1:
        raise InputError(f"hold = {hold:g} s must be at least 0.1 s")
    study = study.only(names)
    columns, rows = np.meshgrid(np.asarray(omega, float), np.asarray(T_l, float))
    values = {"reference.omega.2": columns.ravel(), "load.T_l.2": rows.ravel()}
    errors = []
    for name in names:
        one = _prepared(study, name, direction, hold)
        samples = one.simulation.samples
        found = run_batch(one, values, window=(samples - round(hold / 2 / one.simulation.sample_time), samples), band=band,
                          jobs=jobs, progress=progress)
        error = np.maximum(found.tallies[f"{name}/speed_peak"], np.abs(found.ends["omega"] - values["reference.omega.2"]))
        lost = (found.machine_lost >= 0) | (found.tallies[f"{name}/lost"] >= 0) | ~np.isfinite(error)
        errors.append(np.where(lost, np.inf, error).reshape(columns.shape))
    machine = study.machine
    slip = slip_of_torque(rows + machine.B * columns / machine.n_p, study.drive.flux, machine.n_p, machine.L_r, machine.alpha)
    return _labelled(study, names, omega, T_l, np.array(errors), columns + slip, band, direction)


def _prepared(study: Study, name: str, direction: str, hold: float) -> Study:
    """The study with the loop closed on one observer, its estimates right, and the lines that lead to a point."""
    machine, flux = study.observer_machine(name), study.drive.flux
    i_d = current_of_flux(flux, 0.0, 0.0, study.machine.alpha, study.machine.L_m)[0]
    right = {"i_ds_hat": i_d, "z_1_hat": i_d + machine.beta * flux, "xi_1_hat": i_d + machine.beta * flux, "phi_dr_hat": flux}
    states = OBSERVERS[study.observers[name].kind].states
    initial = {state: value for state, value in right.items() if state in states}
    return study.only([name]).changed({
        "drive.feedback": name, f"observers.{name}.direction": direction,
        **{f"observers.{name}.initial.{state}": value for state, value in initial.items()},
        "initial": {"i_ds": i_d, "i_qs": 0.0, "phi_dr": flux, "phi_qr": 0.0, "omega": 0.0},
        "reference": {"shape": "linear", "time": [0.0, START, TURNED], "omega": [0.0, 0.0, 0.0]},
        "load": {"shape": "linear", "time": [0.0, LOAD, LOADED], "T_l": [0.0, 0.0, 0.0]},
        "simulation.duration": LOADED + hold, "windows": [],
    })


def _labelled(
    study: Study, names: list[str], omega: Any, T_l: Any, errors: Any, frequency: Any, band: float, direction: str
) -> xr.Dataset:
    import xarray as xr

    axes = ("observer", "T_l", "omega")
    return xr.Dataset(
        {
            "speed_error": (axes, errors, {"units": "rad/s", "long_name": "error of the speed, loop closed on the estimate"}),
            "holds": (axes, (errors <= band).astype(np.int8), {"units": "1", "long_name": "whether the sensorless loop holds"}),
            "stator_frequency": (axes[1:], frequency, {"units": "rad/s", "long_name": "stator frequency of the wanted state"}),
        },
        {
            "observer": names,
            "T_l": ("T_l", np.asarray(T_l, float), {"units": "N m", "long_name": "load torque"}),
            "omega": ("omega", np.asarray(omega, float), {"units": "rad/s", "long_name": "speed, electrical"}),
        },
        {**provenance(study), "schema": "imo-sensorless/1", "band": band, "direction": direction},
    )
