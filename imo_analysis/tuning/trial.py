"""Gains tried in closed loop: many machines at once, with noise and with parameters that the observer does not know.

Three trials, all on `imo_analysis.sweeps.batch`: the same drive for all, field-oriented control on the measured speed.

- ``drive``: speeds over the whole range, reversals and loads, each machine with errors of its own. For the choice the machines
  are the right one and the corners of the uncertainty; for the verification machines, speeds, loads and noise are drawn anew.
- ``noise``: constant speeds, right parameters: the deviation that the linearisation predicts.
- ``settling``: an estimate that starts 1 rad/s off: the time that the linearisation predicts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.steady_state import current_of_flux
from imo_analysis.study import Study
from imo_analysis.sweeps.batch import Summary, run_batch
from imo_analysis.tuning.wish import Wish

Array = NDArray[np.float64]
_STEPS = 8  # of the speed in a trial
_HELD, _RAMP, _START = 0.5, 0.5, 0.5  # s: how long each speed is held, the way to the next; from when on errors count
_HEAVY, _NO_TORQUE = 1e4, 1.001
_OFF, _SHARE = 1.0, 0.02  # rad/s; of it, what counts as settled


@dataclass(frozen=True)
class Driven:
    """What ``drive`` gives for each candidate.

    Attributes
    ----------
    lost : ndarray
        Share of the machines whose estimate was lost.
    rms_median, rms_95 : ndarray
        Median and 95th percentile over the machines of the rms error of the speed in rad/s; infinity where it was lost.
    """

    lost: Array
    rms_median: Array
    rms_95: Array


def drive(
    study: Study, name: str, candidates: Sequence[Mapping[str, float]], wish: Wish, signs: tuple[float, ...], seed: int,
    runs: int = 0, jobs: int | None = 1,
) -> Driven:
    """Drive machines with errors over the range of speeds; each candidate on the same machines.

    Parameters
    ----------
    study : Study
        Its drive, limits and sampling.
    name : str
        Observer of the study.
    candidates : sequence of mapping
        Gains.
    wish : Wish
        Range, load, noise, uncertainty.
    signs : tuple of float
        Directions.
    seed : int
        Of noise and, with ``runs``, of machines, speeds and loads.
    runs : int
        Machines drawn at random; 0 for the right one and the corners.
    """
    rng = np.random.default_rng(seed)
    errors = [{}, *wish.corners()] if runs == 0 else [
        {key: float(rng.uniform(-size, size)) for key, size in wish.uncertainty.items()} for _ in range(runs)]
    count = len(errors)
    torque = _torque(wish)
    ramp = max(_RAMP, wish.high * wish.machine.J / (wish.machine.n_p * torque)) if torque > 0 else _RAMP
    time = np.concatenate([[0.0], np.cumsum([_HELD, ramp] * (_STEPS // 2))])[: 2 * (_STEPS // 2)]
    speeds, loads = _profile(wish, signs, torque, count, rng if runs else None)
    values = {f"reference.omega.{n}": np.tile(speeds[:, n // 2], len(candidates)) for n in range(len(time))}
    values |= {f"load.T_l.{n}": np.tile(loads[:, n // 2], len(candidates)) for n in range(1, len(time))}
    values |= {"initial.omega": np.tile(speeds[:, 0], len(candidates)),
               f"observers.{name}.initial.omega_hat": np.tile(speeds[:, 0], len(candidates))}
    for key in wish.uncertainty:
        # observers believe the study's machine; the one that turns differs from it
        real = [getattr(wish.machine, key) * (1 + one.get(key, 0.0)) for one in errors]
        values[f"machine.{key}"] = np.tile(real, len(candidates))
    values |= _gain_fields(name, candidates, count)
    tables = {"reference": {"shape": "linear", "time": time.tolist(), "omega": [0.0] * len(time)},
              "load": {"shape": "linear", "time": (time + np.where(time > 0, 0.1, 0.0)).tolist(), "T_l": [0.0] * len(time)}}
    one = _prepared(study, name, candidates[0], wish, tables, float(time[-1]) + _HELD, seed, wish.current_noise)
    T = one.simulation.sample_time
    found = run_batch(one, values, nominal=True, window=(round(_START / T), one.simulation.samples), jobs=jobs)
    rms = _rms(found, name).reshape(len(candidates), count)
    return Driven(np.isinf(rms).mean(axis=1), np.median(rms, axis=1), np.quantile(rms, 0.95, axis=1, method="higher"))


def noise(study: Study, name: str, gains: Mapping[str, float], wish: Wish, omega: Array, seed: int) -> Array:
    """Deviation of the speed estimate in rad/s at constant speeds, right parameters, no load."""
    one = _prepared(study, name, gains, wish, _still(), 3.0, seed, wish.current_noise)
    T = one.simulation.sample_time
    return _rms(run_batch(one, _at(name, omega, omega), window=(round(1.0 / T), one.simulation.samples), jobs=1), name)


def settling(study: Study, name: str, gains: Mapping[str, float], wish: Wish, omega: Array) -> Array:
    """Time in s until an estimate that starts `_OFF` too low stays within 2 % of that, no noise, no load; infinity if never.

    The inertia is made so large that the speed stays, for an estimate lags a speed that moves; and alpha_hat is held (g = 0),
    for the drive starts with a jerk of torque, of which alpha_hat would take its share. The current is limited to the flux's.
    """
    gains = {**gains, "g": 0.0} if "g" in gains else gains
    duration = min(8.0, 3 * wish.limits["recovery"])
    one = _prepared(study, name, gains, wish, _still(), duration, 0, 0.0)
    values = _at(name, omega, omega - _OFF) | {"machine.J": np.full(len(omega), _HEAVY * wish.machine.J)}
    values["drive.current_limit"] = np.full(len(omega), _NO_TORQUE * one.initial.i_ds)
    found = run_batch(one, values, window=(0, one.simulation.samples), band=_SHARE * _OFF, jobs=1)
    last = found.tallies[f"{name}/outside"]
    well = (found.tallies[f"{name}/lost"] < 0) & (last < one.simulation.samples - 1)
    return np.where(well, (last + 1) * one.simulation.sample_time, np.inf)


def _torque(wish: Wish) -> float:
    """The load torque in N m that makes the wish's largest slip."""
    machine = wish.machine
    return 1.5 * machine.n_p * wish.flux**2 * wish.slip / (machine.alpha * machine.L_r)


def _profile(wish: Wish, signs: tuple[float, ...], torque: float, count: int, rng: Any) -> tuple[Array, Array]:
    """Speeds and loads of each machine at each step, shape (machines, steps)."""
    steps = _STEPS // 2
    if rng is None:
        omega = np.array([wish.low, wish.high, -wish.high, -wish.low])
        if len(signs) == 1:
            omega = np.array([wish.low, wish.high, wish.middle, wish.low])
        return np.tile(omega, (count, 1)), np.tile(np.array([0.0, torque, torque, -torque]) * np.sign(omega), (count, 1))
    return (rng.uniform(wish.low, wish.high, (count, steps)) * rng.choice(signs, (count, steps)),
            rng.uniform(-torque, torque, (count, steps)))


def _gain_fields(name: str, candidates: Sequence[Mapping[str, float]], count: int) -> dict[str, Array]:
    return {f"observers.{name}.gains.{gain}": np.repeat([one[gain] for one in candidates], count) for gain in candidates[0]}


def _at(name: str, omega: Array, omega_hat: Array) -> dict[str, Array]:
    """Constant speeds, one a lane."""
    return {"initial.omega": omega, "reference.omega.0": omega, f"observers.{name}.initial.omega_hat": omega_hat}


def _still() -> dict[str, Any]:
    return {"reference": {"shape": "steps", "time": [0.0], "omega": [0.0]},
            "load": {"shape": "steps", "time": [0.0], "T_l": [0.0]}}


def _rms(found: Summary, name: str) -> Array:
    first, last = found.window
    lost = (found.tallies[f"{name}/lost"] >= 0) | (found.machine_lost >= 0)
    return np.where(lost, np.inf, np.sqrt(found.tallies[f"{name}/speed_square"] / (last - first)))


def _prepared(
    study: Study, name: str, gains: Mapping[str, float], wish: Wish, tables: dict[str, Any], duration: float, seed: int,
    noise: float,
) -> Study:
    """The study with this observer alone, started right, magnetised, and with what the trial needs."""
    machine, flux = wish.machine, wish.flux
    i_d = current_of_flux(flux, 0.0, 0.0, machine.alpha, machine.L_m)[0]
    z = i_d + machine.beta * flux
    kind = study.observers[name].kind
    right = {"i_ds_hat": i_d, "z_1_hat": z, "xi_1_hat": z, "phi_dr_hat": flux, "alpha_hat": machine.alpha}
    initial = {state: value for state, value in right.items() if state in OBSERVERS[kind].states}
    data = {key: value for key, value in study.data.items() if key not in ("scenarios", "windows", "sweep", "tuning", "replay")}
    data |= tables | {
        "observers": {name: {"kind": kind, "gains": dict(gains), "initial": initial}},
        "initial": {"i_ds": i_d, "phi_dr": flux},
        "drive": {**data["drive"], "feedback": "measured"},
        "sensors": {"sampling": study.sensors.sampling, "current_noise": noise},
        "simulation": {"duration": duration, "sample_time": study.simulation.sample_time, "substeps": study.simulation.substeps,
                       "seed": seed, "record_every": 1}}
    return Study.from_data(data, "trial")
