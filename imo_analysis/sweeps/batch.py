"""Many machines at once: one study, with some of its numbers different for each, run in `lanes` and summed up.

A *field* is the dotted name of a number in the study, such as ``machine.R_r``, ``observers.repaired.gains.g`` or
``reference.omega.1`` (second entry). `FIELDS` says which can differ from lane to lane.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations import parameters
from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS
from imo_analysis.simulation.composition import loop_of, observer_order, require_plain
from imo_analysis.simulation.drive import flux_rates
from imo_analysis.simulation.inputs import normals
from imo_analysis.simulation.kernel import PLANT_STATES
from imo_analysis.simulation.run import BOUND, FLUX_FLOOR
from imo_analysis.simulation.waveforms import swing
from imo_analysis.study import Study
from imo_analysis.study_tables import Load, Reference
from imo_analysis.sweeps.lanes import DRIVE, MACHINE, WIDTH, Lanes, lanes
from imo_analysis.sweeps.trace import evaluated

Array = NDArray[np.float64]
MACHINE_FIELDS = ("n_p", "R_s", "R_r", "L_m", "L_s", "L_r", "J", "B")
DRIVE_FIELDS = ("flux", *DRIVE[1:6], "flux_modulation")
_STRETCH = 5_000
_GROUPS = 32  # for each thread: the last one to end is then at most a thirtieth of its work behind


@dataclass(frozen=True)
class Summary:
    """What a batch keeps.

    Attributes
    ----------
    order : list of str
        Observers.
    window : tuple of 2
        First sample of the tally, and the one after its last.
    machine_lost : ndarray, shape (machines,)
        Sample at which the machine was found out of bound, or -1.
    tallies : dict of str to ndarray
        ``observer/name`` for the names in `tally.OBSERVER` and `tally.REGRESSOR`, shape (machines,).
    ends : dict of str to ndarray
        ``observer/state`` at the end of the run, and ``state`` of the machine.
    """

    order: list[str]
    window: tuple[int, int]
    machine_lost: Array
    tallies: dict[str, Array]
    ends: dict[str, Array]


def lane_fields(study: Study) -> set[str]:
    """Names of the fields of a study that can differ from machine to machine in a batch."""
    fields = {f"machine.{name}" for name in MACHINE_FIELDS} | {f"drive.{name}" for name in DRIVE_FIELDS}
    fields |= {f"initial.{name}" for name in PLANT_STATES}
    fields |= {f"reference.omega.{n}" for n in range(len(study.reference.omega))}
    fields |= {f"load.T_l.{n}" for n in range(len(study.load_torque.T_l))}
    fields |= {f"sensors.{name}.{n}" for name in ("current_gain", "current_offset") for n in (0, 1)}
    for name, settings in study.observers.items():
        kind = OBSERVERS[settings.kind]
        fields |= {f"observers.{name}.gains.{gain}" for gain in kind.gains}
        fields |= {f"observers.{name}.initial.{state}" for state in kind.states}
        fields |= {f"observers.{name}.errors.{parameter}" for parameter in ("R_s", "R_r", "L_m", "L_s", "L_r")}
    return fields


def run_batch(
    study: Study,
    values: Mapping[str, Array],
    *,
    nominal: bool = False,
    window: tuple[int, int] | None = None,
    band: float = 1.0,
    jobs: int | None = None,
    machines: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Summary:
    """Run a study once for each entry of the arrays.

    Parameters
    ----------
    study : Study
        Everything that is not in ``values``.
    values : mapping of str to ndarray of shape (machines,)
        Fields out of `lane_fields` with a value for each machine, checked by the caller (`sweep_values.impossible`).
    nominal : bool
        Whether the observers believe the machine of ``study`` whatever ``values`` says, instead of each machine's own.
    window : tuple of 2, optional
        Samples over which errors are summed up; the whole run where left out.
    band : float
        Largest speed error in rad/s that counts as settled.
    jobs : int, optional
        Threads; one for each processor where left out.
    machines : int, optional
        How many machines; needed only where ``values`` is empty.
    progress : callable, optional
        Called with the number of lane-samples done since the last call, those of lanes that fill up a block included.

    Returns
    -------
    Summary
    """
    require_plain(study, "a batch")
    order = observer_order(study)
    kernel = lanes(loop_of(study))
    machines = len(next(iter(values.values()))) if values else machines or 1
    blocks = -(-machines // WIDTH)
    field = _Fields(study, values, blocks * WIDTH)
    rows, tables = _start(study, kernel, order, field, nominal)
    simulation = study.simulation
    every, T = simulation.record_every, simulation.sample_time
    window = window or (0, simulation.samples)
    run = kernel.run
    sampled = 1.0 if study.sensors.sampling == "sampled" else 0.0
    entries = len(study.reference.time)

    jobs = min(jobs or processors(), blocks)
    # a stretch of inputs stays in the processor's cache while the blocks of a group pass by
    groups = np.array_split(np.arange(blocks), min(blocks, _GROUPS * jobs))

    def group(members: NDArray[Any], first: int, samples: int, given: tuple[Any, ...]) -> int:
        for n in members:
            run(first, samples, every, T / simulation.substeps, simulation.substeps, BOUND, window, band, sampled, *given,
                tables[n], rows[n])
        return samples * len(members) * WIDTH

    with ThreadPoolExecutor(jobs) as pool:
        for first in range(0, simulation.samples, _STRETCH):
            samples = min(_STRETCH, simulation.samples - first)
            work = partial(group, first=first, samples=samples, given=_outside(study, first, samples, entries))
            for done in map(work, groups) if jobs == 1 else pool.map(work, groups):
                if progress:
                    progress(done)
    return _summary(study, kernel, order, rows.reshape(blocks, kernel.rows, WIDTH), machines, window)


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Fields:
    """Numbers of a study by field, each as an array with an entry a lane; lanes beyond the last machine repeat it."""

    def __init__(self, study: Study, values: Mapping[str, Array], count: int) -> None:
        self._values = {name: np.concatenate([value, np.full(count - len(value), value[-1])]).astype(float)
                        for name, value in values.items()}
        self._count = count
        self.study = study

    def __call__(self, name: str, otherwise: float) -> Array:
        return self._values[name] if name in self._values else np.full(self._count, float(otherwise))


def derived(machine: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters that the equations take (`lanes.MACHINE` and friction), from those of the T form."""
    sigma = parameters.leakage(machine["L_s"], machine["L_m"], machine["L_r"])
    return {
        "R_s": machine["R_s"], "L_m": machine["L_m"], "sigma": sigma,
        "beta": parameters.coupling(machine["L_m"], sigma, machine["L_r"]),
        "alpha": parameters.rotor_rate(machine["R_r"], machine["L_r"]),
        "mu": parameters.torque_gain(machine["n_p"], machine["L_m"], machine["L_r"], machine["J"]),
        "n_p": machine["n_p"], "J": machine["J"], "friction": machine["B"] / machine["n_p"],
    }


def machine_fields(study: Study, field: Callable[[str, float], Array]) -> dict[str, Array]:
    """Parameters of the machines."""
    return {name: field(f"machine.{name}", getattr(study.machine, name)) for name in MACHINE_FIELDS}


def believed_fields(study: Study, name: str, field: Callable[[str, float], Array], nominal: bool) -> dict[str, Array]:
    """Parameters of the machines as an observer believes them to be."""
    machine = machine_fields(study, (lambda _, otherwise: field("", otherwise)) if nominal else field)
    errors = study.observers[name].errors
    return {key: value * (1.0 + field(f"observers.{name}.errors.{key}", errors.get(key, 0.0))) if key not in ("n_p", "J", "B")
            else value for key, value in machine.items()}


def _start(study: Study, kernel: Lanes, order: list[str], field: _Fields, nominal: bool) -> tuple[Array, Array]:
    """Rows and tables of every block at time 0, shapes (blocks, rows * WIDTH) and (blocks, entries * WIDTH)."""
    given: dict[str, Any] = derived(machine_fields(study, field))
    drive, sensors = study.drive, study.sensors
    drives = {name: field(f"drive.{name}", getattr(drive, name)) for name in DRIVE_FIELDS}
    given.update(drives, T=study.simulation.sample_time, flux_floor=FLUX_FLOOR * drives["flux"],
                 sampled=1.0 if sensors.sampling == "sampled" else 0.0)
    for n, axis in enumerate("dq"):
        given[f"gain_{axis}"] = field(f"sensors.current_gain.{n}", sensors.current_gain[n])
        given[f"offset_{axis}"] = field(f"sensors.current_offset.{n}", sensors.current_offset[n])
    x = [field(f"initial.{name}", getattr(study.initial, name)) for name in PLANT_STATES]
    states = list(x)
    for n, name in enumerate(order):
        settings = study.observers[name]
        kind = OBSERVERS[settings.kind]
        believed = derived(believed_fields(study, name, field, nominal))
        given.update({f"{key}@{n}": believed[key] for key in PARAMETERS})
        given.update({f"{gain}@{n}": field(f"observers.{name}.gains.{gain}", settings.gains[gain]) for gain in kind.gains})
        states += [field(f"observers.{name}.initial.{state}", settings.initial.get(state, 0.0)) for state in kind.states]
    count = len(x[0])
    rows = np.zeros((kernel.rows, count))
    for row, value in enumerate(evaluated(kernel.constants, given)):
        rows[row] = value
    flux = (x[2], x[3])
    rows[kernel.control + 3 : kernel.control + 7] = [
        *flux, *flux_rates(flux, (x[0], x[1]), x[4], tuple(given[name] for name in MACHINE))]
    rows[kernel.states : kernel.states + len(states)] = states
    for first, names in zip(kernel.tally, kernel.tally_names, strict=True):
        for name in ("lost", "outside"):
            if name in names:
                rows[first + names.index(name)] = -1.0
    omega = [field(f"reference.omega.{n}", value) for n, value in enumerate(study.reference.omega)]
    load = [field(f"load.T_l.{n}", value) for n, value in enumerate(study.load_torque.T_l)]
    tables = np.array([*omega, omega[-1], *load, load[-1]])
    return _blocks(rows), _blocks(tables)


def _blocks(rows: Array) -> Array:
    """Rows over all lanes as one row of numbers for each block, aligned to a cache line."""
    count, lane_count = rows.shape
    blocks = lane_count // WIDTH
    space = np.empty(rows.size + 8)
    first = -space.ctypes.data // 8 % 8
    result = space[first : first + rows.size].reshape(blocks, count * WIDTH)
    result.reshape(blocks, count, WIDTH)[:] = rows.reshape(count, blocks, WIDTH).transpose(1, 0, 2)
    return result


def _outside(study: Study, first: int, samples: int, entries: int) -> tuple[Any, ...]:
    """``piece, share, sine, noise`` of `lanes.Lanes` for a stretch of samples."""
    T = study.simulation.sample_time
    index = np.arange(first, first + samples)
    time = index * T
    omega, to_omega = place(study.reference, time, T)
    load, to_load = place(study.load_torque, time, T)
    wave = swing(study.drive, time)
    noise = np.zeros((2, samples))
    if study.sensors.current_noise > 0:
        noise[:] = study.sensors.current_noise * np.array(normals(study.simulation.seed, index))
    return np.array([omega, load + entries + 1]), np.array([to_omega, to_load]), wave, noise


def place(table: Reference | Load, time: NDArray[Any], sample_time: float) -> tuple[NDArray[np.int64], Array]:
    """Entry of a table in force at each time, and how far it is on its way to the next."""
    nodes = np.array(table.time)
    if table.shape == "steps":
        # a step at 32.5 s belongs to the sample at 32.5 s, however that product was rounded
        entry = np.searchsorted(nodes, time + 1e-6 * sample_time, side="right") - 1
        return entry, np.zeros(len(time))
    entry = np.searchsorted(nodes, time, side="right") - 1
    after = np.minimum(entry + 1, len(nodes) - 1)
    length = nodes[after] - nodes[entry]
    return entry, np.where(length > 0, (time - nodes[entry]) / np.where(length > 0, length, 1.0), 0.0)


def _summary(study: Study, kernel: Lanes, order: list[str], rows: Array, machines: int, window: tuple[int, int]) -> Summary:
    def row(number: int) -> Array:
        return rows[:, number].reshape(-1)[:machines].copy()

    tallies = {f"{name}/{entry}": row(first + j)
               for name, first, names in zip(order, kernel.tally[1:], kernel.tally_names[1:], strict=True)
               for j, entry in enumerate(names)}
    ends = {name: row(kernel.states + j) for j, name in enumerate(PLANT_STATES)}
    place = kernel.states + len(PLANT_STATES)
    for name in order:
        for state in OBSERVERS[study.observers[name].kind].states:
            ends[f"{name}/{state}"] = row(place)
            place += 1
    return Summary(order, window, row(kernel.tally[0]), tallies, ends)
