"""Where the loop closed on an estimate holds: speed against load torque, regenerating and near zero stator frequency included.

At every point of the map a drive starts magnetised at standstill with right estimates, goes to its speed along a line, is then
loaded along a line, and holds both. Nothing but the estimates of speed and flux, and the speed reference for the direction of
rotation, closes the loop. Whether it holds is judged as `imo_analysis.simulation.judge` says. `study_map` is the map of a study
up to its rated speed and torque, its observers wrong in the stator resistance; `resistance_limits` asks how wrong they may be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.steady_state import current_of_flux, slip_of_torque
from imo_analysis.errors import InputError
from imo_analysis.simulation.judge import R_S_OFF, STRETCH, holds
from imo_analysis.simulation.run import provenance
from imo_analysis.study import Study
from imo_analysis.sweeps.batch import run_batch

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

# Times in s, those of the runs that `imo study --init` writes: the speed goes from START to TURNED, the load from LOAD to
# LOADED.
# Where alpha cannot be told from the speed, the way to a point decides where the estimates come to rest.
START, TURNED, LOAD, LOADED = 0.3, 1.5, 2.0, 2.2
# Speeds of a study's map as shares of the widest of the poles' sweep, dense where the stator frequency is near zero.
SHARES = (0.0, 0.03, 0.06, 0.1, 0.15, 0.25, 0.5, 0.75, 1.0)
TORQUES = 9  # from braking to driving
LIMIT_SHARES = (0.5, 0.1)  # of the widest speed, points of the map: where `resistance_limits` looks
SETTLED = 25.0  # rotor time constants: how long a study's map holds a point, what the slowest errors take to settle
WIDEST = 0.5  # relative: as far as the stator resistance is taken off
_COARSE, _FINER = 15, 8  # sizes on each side: two blocks of lanes and one


def sensorless_map(
    study: Study,
    omega: Sequence[float],
    T_l: Sequence[float],
    *,
    observers: Sequence[str] = (),
    direction: str = "reference",
    hold: float = 2.0,
    jobs: int | None = None,
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
        How long in s speed and load are held; it is judged by the last `STRETCH` of that.
    jobs : int, optional
        Threads; one for each processor where left out.

    Returns
    -------
    xarray.Dataset
        Dimensions ``observer``, ``T_l`` (N m), ``omega`` (rad/s). ``speed_error`` is the larger of the mean of
        |omega_hat - omega| and the final |omega - reference|, in rad/s, infinite where something diverged; ``holds`` is 1
        where it holds, by `imo_analysis.simulation.judge.holds`; ``stator_frequency`` (T_l, omega) is that of the wanted state
        in rad/s.

    Raises
    ------
    InputError
        For an empty axis, an unknown observer or direction, a hold that is too short, or a study with what a batch cannot have.
    """
    names = list(observers or study.observers)
    if not len(omega) or not len(T_l) or not names:
        raise InputError(
            f"the map has {len(omega)} speeds, {len(T_l)} torques and {len(names)} observers; there must be 1 or more of each")
    if not hold >= STRETCH:
        raise InputError(f"hold = {hold:g} s must be at least the {STRETCH:g} s over which it is judged")
    study = study.only(names)
    columns, rows = np.meshgrid(np.asarray(omega, float), np.asarray(T_l, float))
    values = {"reference.omega.2": columns.ravel(), "load.T_l.2": rows.ravel()}
    judged = [_judged(_prepared(study, name, direction, hold), name, values, jobs) for name in names]
    error, well = (np.reshape([one[k] for one in judged], (len(names), *columns.shape)) for k in (0, 1))
    machine = study.machine
    slip = slip_of_torque(rows + machine.B * columns / machine.n_p, study.drive.flux, machine.n_p, machine.L_r, machine.alpha)
    return _labelled(study, names, omega, T_l, error, well, columns + slip, direction)


def study_map(study: Study, observers: Sequence[str] = (), jobs: int | None = None) -> xr.Dataset:
    """The map of a study up to its rated speed and torque, and how far the stator resistance may be off.

    Parameters
    ----------
    study : Study
        The widest speed is that of its poles' sweep, the largest torque ``tuning.torque``, or that at a slip of alpha.
    observers : sequence of str
        Which; all of the study where left out.
    jobs : int, optional
        Threads.

    Returns
    -------
    xarray.Dataset
        That of `sensorless_map` with steps of order 4, the observers right but for a stator resistance that they believe
        `R_S_OFF` too large; with ``R_s_low`` and ``R_s_high`` over observer and ``limit_omega`` (rad/s), as
        `resistance_limits` at the largest torque.

    Raises
    ------
    InputError
        As `sensorless_map`.
    """
    machine = study.machine
    names = list(observers or study.observers)
    right = {f"observers.{name}.initial.alpha_hat": machine.alpha for name in names
             if "alpha_hat" in OBSERVERS[study.observers[name].kind].states}
    believed = {f"observers.{name}.errors.R_s": R_S_OFF for name in names}
    plain = study.changed({"drive.feedback": "measured", "windows": [], "simulation.order": 4}).only(names)
    plain = plain.changed(right | believed)
    widest = max(abs(study.poles.sweep.start), abs(study.poles.sweep.stop))
    omega = widest * np.array([-share for share in SHARES[:0:-1]] + list(SHARES))
    reach = study.tuning.torque
    if reach is None:
        reach = machine.alpha / float(slip_of_torque(1.0, study.drive.flux, machine.n_p, machine.L_r, machine.alpha))
    hold = max(2.0, SETTLED / machine.alpha)
    plane = sensorless_map(plain, omega.tolist(), np.linspace(-reach, reach, TORQUES).tolist(), hold=hold, jobs=jobs)
    at = [share * widest for share in LIMIT_SHARES]
    limits = np.array([[resistance_limits(plain, name, speed, reach, hold=hold, jobs=jobs) for speed in at] for name in names])
    about = "largest relative error of the believed R_s with which the loop holds"
    return plane.assign_coords(limit_omega=("limit_omega", at, {"units": "rad/s", "long_name": "speed, electrical"})).assign(
        R_s_low=(("observer", "limit_omega"), limits[..., 0], {"units": "1", "long_name": f"{about}, too low"}),
        R_s_high=(("observer", "limit_omega"), limits[..., 1], {"units": "1", "long_name": f"{about}, too high"}),
    ).assign_attrs(R_s_error=R_S_OFF, limit_torque=reach)


def resistance_limits(
    study: Study, name: str, omega: float, T_l: float, *, hold: float = 2.0, jobs: int | None = None
) -> tuple[float, float]:
    """How far the stator resistance that an observer believes may be off, too low and too high, at one speed and torque.

    Parameters
    ----------
    study : Study
    name : str
        Of the observer that closes the loop.
    omega, T_l : float
        Electrical speed in rad/s, load torque in N m.
    hold, jobs
        As in `sensorless_map`.

    Returns
    -------
    tuple of 2 float
        Relative errors, at most 0 and at least 0, between which the loop holds without a gap, to a tenth of their size and
        at most `WIDEST`; NaN where it does not hold with the right one.
    """
    one = _prepared(study.only([name]), name, "reference", hold).changed(
        {"reference.omega": [0.0, 0.0, omega], "load.T_l": [0.0, 0.0, T_l]})
    sizes = np.geomspace(0.002, WIDEST, _COARSE)

    def held(errors: Array) -> NDArray[Any]:
        return _judged(one, name, {f"observers.{name}.errors.R_s": errors}, jobs, omega)[1]

    found = held(np.concatenate([[0.0], -sizes, sizes]))
    if not found[0]:
        return np.nan, np.nan
    sides = {-1.0: found[1 : 1 + len(sizes)], 1.0: found[1 + len(sizes) :]}
    ends = {sign: _first_gap(np.append(0.0, sizes), np.append(True, well)) for sign, well in sides.items()}
    finer = {sign: np.linspace(*end, _FINER) for sign, end in ends.items()}
    well = np.split(held(np.concatenate([sign * size for sign, size in finer.items()])), 2)
    low, high = (sign * _first_gap(size, one)[0] for (sign, size), one in zip(finer.items(), well, strict=True))
    return low, high


def _first_gap(sizes: Array, well: NDArray[Any]) -> tuple[float, float]:
    """The last size up to which all hold, and the first that does not; twice the last size where all hold."""
    first = int(np.argmin(well)) if not well.all() else len(sizes)
    return float(sizes[max(first - 1, 0)]), float(sizes[min(first, len(sizes) - 1)])


def _judged(
    one: Study, name: str, values: Mapping[str, Array], jobs: int | None, wanted: float | None = None
) -> tuple[Array, NDArray[Any]]:
    """The error of each run in rad/s, infinite where something diverged, and whether it holds."""
    samples = one.simulation.samples
    window = (samples - round(STRETCH / one.simulation.sample_time), samples)
    found = run_batch(one, values, window=window, jobs=jobs)
    every = one.simulation.record_every
    records = -(-window[1] // every) - -(-window[0] // every)
    omega = found.ends["omega"]
    reference = values["reference.omega.2"] if wanted is None else np.full(len(omega), wanted)
    mean = found.tallies[f"{name}/speed_sum"] / records
    rms = np.sqrt(found.tallies[f"{name}/speed_square"] / records)
    lost = (found.machine_lost >= 0) | (found.tallies[f"{name}/lost"] >= 0) | ~np.isfinite(mean + rms + omega)
    error = np.where(lost, np.inf, np.maximum(np.abs(mean), np.abs(omega - reference)))
    return error, holds(mean, rms, omega, reference) & ~lost


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
    study: Study, names: list[str], omega: Any, T_l: Any, errors: Any, well: Any, frequency: Any, direction: str
) -> xr.Dataset:
    import xarray as xr

    axes = ("observer", "T_l", "omega")
    return xr.Dataset(
        {
            "speed_error": (axes, errors, {"units": "rad/s", "long_name": "error of the speed, loop closed on the estimate"}),
            "holds": (axes, well.astype(np.int8), {"units": "1", "long_name": "whether the sensorless loop holds"}),
            "stator_frequency": (axes[1:], frequency, {"units": "rad/s", "long_name": "stator frequency of the wanted state"}),
        },
        {
            "observer": names,
            "T_l": ("T_l", np.asarray(T_l, float), {"units": "N m", "long_name": "load torque"}),
            "omega": ("omega", np.asarray(omega, float), {"units": "rad/s", "long_name": "speed, electrical"}),
        },
        {**provenance(study), "schema": "imo-sensorless/1", "direction": direction},
    )
