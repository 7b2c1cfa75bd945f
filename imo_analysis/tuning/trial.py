"""Gains tried in closed loop: many machines at once, with noise and with parameters that the observer does not know.

Three trials, all on `imo_analysis.sweeps.batch`: the same drive for all, field-oriented control on the measured speed.

- ``drive``: machines with errors drawn at random, speeds over the whole range, reversals and loads drawn too; and the corners:
  every combination of the largest errors, at the ends of the range, with the largest load either way, held for seconds, so
  that an estimate that only slowly leaves is seen.
- ``noise``: constant speeds, right parameters: the deviation that the linearisation predicts.
- ``settling``: an estimate that starts 1 rad/s off: the time that the linearisation predicts.
"""

from __future__ import annotations

import itertools
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
_HEAVY, _NO_TORQUE = 1e4, 1e-6
_CORNER, _ON = 4.0, 1.0  # s: how long a corner is held; from when on errors count there
_OFF, _SHARE = 1.0, 0.02  # rad/s; of it, what counts as settled


@dataclass(frozen=True)
class Driven:
    """What ``drive`` gives for each candidate.

    Attributes
    ----------
    lost : ndarray
        Share of all runs, random and corners, whose estimate was lost: it left all bounds, or its rms error is above the
        highest speed of the range.
    rms : ndarray
        Root mean square error of the speed over all runs together in rad/s; infinity where one was lost.
    rms_median, rms_95 : ndarray
        Median and 95th percentile over the random runs of the rms error of the speed in rad/s; infinity where it was lost.
    corner : ndarray
        The largest rms error of the speed in a corner in rad/s; infinity where it was lost.
    """

    lost: Array
    rms: Array
    rms_median: Array
    rms_95: Array
    corner: Array


def drive(
    study: Study, name: str, candidates: Sequence[Mapping[str, float]], wish: Wish, signs: tuple[float, ...], seed: int,
    runs: int, jobs: int | None = 1,
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
        Of noise, machines, speeds and loads.
    runs : int
        Machines drawn at random; the corners come on top of them.
    """
    free = _random(study, name, candidates, wish, signs, seed, runs, jobs)
    held = _corners(study, name, candidates, wish, signs, seed, jobs)
    every = np.concatenate([free, held], axis=1)
    return Driven(np.isinf(every).mean(axis=1), np.sqrt((every**2).mean(axis=1)), np.median(free, axis=1),
                  np.quantile(free, 0.95, axis=1, method="higher"), held.max(axis=1))


def _random(
    study: Study, name: str, candidates: Sequence[Mapping[str, float]], wish: Wish, signs: tuple[float, ...], seed: int,
    runs: int, jobs: int | None,
) -> Array:
    """Rms errors of the speed, shape (candidates, runs), each run with a machine, speeds and loads of its own."""
    rng = np.random.default_rng(seed)
    errors = {key: rng.uniform(-size, size, runs) for key, size in wish.uncertainty.items()}
    torque, steps = _torque(wish), _STEPS // 2
    ramp = max(_RAMP, wish.high * wish.machine.J / (wish.machine.n_p * torque)) if torque > 0 else _RAMP
    time = np.concatenate([[0.0], np.cumsum([_HELD, ramp] * steps)])[: 2 * steps]
    speeds = rng.uniform(wish.low, wish.high, (runs, steps)) * rng.choice(signs, (runs, steps))
    loads = rng.uniform(-torque, torque, (runs, steps))
    lanes = {f"reference.omega.{n}": speeds[:, n // 2] for n in range(len(time))}
    lanes |= {f"load.T_l.{n}": loads[:, n // 2] for n in range(1, len(time))}
    tables = {"reference": {"shape": "linear", "time": time.tolist(), "omega": [0.0] * len(time)},
              "load": {"shape": "linear", "time": (time + np.where(time > 0, 0.1, 0.0)).tolist(), "T_l": [0.0] * len(time)}}
    return _errors(study, name, candidates, wish, tables, lanes | _started(name, speeds[:, 0]) | _machines(wish, errors),
                   (_START, float(time[-1]) + _HELD), seed, jobs)


def _corners(
    study: Study, name: str, candidates: Sequence[Mapping[str, float]], wish: Wish, signs: tuple[float, ...], seed: int,
    jobs: int | None,
) -> Array:
    """Rms errors of the speed, shape (candidates, corners): right parameters too, each end of the range, each load."""
    loads = (-1.0, 1.0) if wish.slip > 0 else (0.0,)
    every = list(itertools.product([{}, *wish.corners()], signs, (wish.low, wish.high), loads))
    errors = {key: np.array([one.get(key, 0.0) for one, *_ in every]) for key in wish.uncertainty}
    omega = np.array([sign * speed for _, sign, speed, _ in every])
    machines = _machines(wish, errors)
    # the load that makes the largest slip of the wish in this machine
    alpha = machines.get("machine.R_r", wish.machine.R_r) / machines.get("machine.L_r", wish.machine.L_r)
    L_r = machines.get("machine.L_r", wish.machine.L_r)
    load = np.array([sign for *_, sign in every]) * _torque(wish) * wish.machine.alpha * wish.machine.L_r / (alpha * L_r)
    tables = {"reference": {"shape": "steps", "time": [0.0], "omega": [0.0]},
              "load": {"shape": "linear", "time": [0.0, 0.1, 0.3], "T_l": [0.0, 0.0, 0.0]}}
    lanes = {"reference.omega.0": omega, "load.T_l.2": load} | _started(name, omega) | machines
    return _errors(study, name, candidates, wish, tables, lanes, (_ON, _CORNER), seed, jobs)


def _machines(wish: Wish, errors: Mapping[str, Array]) -> dict[str, Array]:
    """The machines that turn: observers go on believing the study's, which then is wrong by these errors."""
    return {f"machine.{key}": getattr(wish.machine, key) / (1 + one) for key, one in errors.items()}


def _started(name: str, omega: Array) -> dict[str, Array]:
    return {"initial.omega": omega, f"observers.{name}.initial.omega_hat": omega}


def _errors(
    study: Study, name: str, candidates: Sequence[Mapping[str, float]], wish: Wish, tables: dict[str, Any],
    lanes: Mapping[str, Array], span: tuple[float, float], seed: int, jobs: int | None,
) -> Array:
    """Rms error of the speed of each candidate in each lane, from the first time of the span to the end."""
    count = len(next(iter(lanes.values())))
    values = {key: np.tile(one, len(candidates)) for key, one in lanes.items()} | _gain_fields(name, candidates, count)
    one = _prepared(study, name, candidates[0], wish, tables, span[1], seed, wish.current_noise)
    window = round(span[0] / one.simulation.sample_time), one.simulation.samples
    return _rms(run_batch(one, values, nominal=True, window=window, jobs=jobs), name, wish).reshape(len(candidates), count)


def noise(study: Study, name: str, gains: Mapping[str, float], wish: Wish, omega: Array, seed: int) -> Array:
    """Deviation of the speed estimate in rad/s at constant speeds, right parameters, no load; infinity where it is lost."""
    one = _prepared(study, name, gains, wish, _still(), 3.0, seed, wish.current_noise)
    T = one.simulation.sample_time
    return _rms(run_batch(one, _at(name, omega, omega), window=(round(1.0 / T), one.simulation.samples), jobs=1), name,
                wish)


def settling(study: Study, name: str, gains: Mapping[str, float], wish: Wish, omega: Array) -> Array:
    """Time in s until an estimate that starts `_OFF` too low stays within 2 % of that, no noise, no load; infinity if never.

    Inertia is made so large, and the drive's speed loop so slow, that the speed stays and no torque is asked for: an estimate
    lags a speed that moves, and a torque that follows the sampled speed would shake the flux. alpha_hat is held (g = 0).
    """
    gains = {**gains, "g": 0.0} if "g" in gains else gains
    duration = min(8.0, 3 * wish.limits["recovery"])
    one = _prepared(study, name, gains, wish, _still(), duration, 0, 0.0)
    values = _at(name, omega, omega - _OFF) | {"machine.J": np.full(len(omega), _HEAVY * wish.machine.J)}
    values["drive.speed_bandwidth"] = np.full(len(omega), _NO_TORQUE * one.drive.speed_bandwidth)
    found = run_batch(one, values, window=(0, one.simulation.samples), band=_SHARE * _OFF, jobs=1)
    last = found.tallies[f"{name}/outside"]
    well = (found.tallies[f"{name}/lost"] < 0) & (last < one.simulation.samples - 1)
    return np.where(well, (last + 1) * one.simulation.sample_time, np.inf)


def _torque(wish: Wish) -> float:
    """The load torque in N m that makes the wish's largest slip."""
    machine = wish.machine
    return 1.5 * machine.n_p * wish.flux**2 * wish.slip / (machine.alpha * machine.L_r)


def _gain_fields(name: str, candidates: Sequence[Mapping[str, float]], count: int) -> dict[str, Array]:
    return {f"observers.{name}.gains.{gain}": np.repeat([one[gain] for one in candidates], count) for gain in candidates[0]}


def _at(name: str, omega: Array, omega_hat: Array) -> dict[str, Array]:
    """Constant speeds, one a lane."""
    return {"initial.omega": omega, "reference.omega.0": omega, f"observers.{name}.initial.omega_hat": omega_hat}


def _still() -> dict[str, Any]:
    return {"reference": {"shape": "steps", "time": [0.0], "omega": [0.0]},
            "load": {"shape": "steps", "time": [0.0], "T_l": [0.0]}}


def _rms(found: Summary, name: str, wish: Wish) -> Array:
    """Rms error of the speed; infinity where bounds are left, or where it is above every speed of the range."""
    first, last = found.window
    rms = np.sqrt(found.tallies[f"{name}/speed_square"] / (last - first))
    lost = (found.tallies[f"{name}/lost"] >= 0) | (found.machine_lost >= 0) | ~(rms <= wish.high)
    return np.where(lost, np.inf, rms)


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
