"""One closed loop, computed by everybody: the paper's machine and drive with the repaired observer.

Every contender takes a `Task` and returns the 13 states (machine, observer) at its end; `python-control` and `scipy` integrate
the same definitions, called as plain Python.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from benchmarks import c_code
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.simulation import drive
from imo_analysis.simulation.composition import loop_of
from imo_analysis.simulation.inputs import inputs
from imo_analysis.simulation.kernel import kernel
from imo_analysis.simulation.loaded_machine import direction_of, machine_rates
from imo_analysis.simulation.run import BOUND, drive_parameters, initial_state
from imo_analysis.study import Study
from imo_analysis.sweeps.batch import Summary, derived, run_batch
from imo_analysis.sweeps.lanes import MACHINE

KIND = "repaired"


@dataclass(frozen=True)
class Task:
    """A stretch of motor time: the study, the states at its start, and what comes from outside."""

    study: Study
    samples: int
    x: np.ndarray
    c: np.ndarray
    y: np.ndarray
    inputs: np.ndarray

    @property
    def seconds(self) -> float:
        return self.samples * self.study.simulation.sample_time


def task(samples: int, settled: float = 0.0) -> Task:
    """A task of so many samples, that starts ``settled`` seconds after standstill: 20 rad/s, then a step to 40."""
    before = round(settled / 1e-4)
    study = Study.paper().only([KIND]).changed({
        "simulation.duration": (before + samples) * 1e-4,
        "reference": {"time": [0.0, (before + samples // 5) * 1e-4], "omega": [20.0, 40.0]},
        "windows": [],
    })
    x, c = initial_state(study)
    y = np.array(study.observers[KIND].initial_values)
    start = Task(study, before, x, c, y, np.ascontiguousarray(inputs(study, 0, before)))
    if before:
        x, y, c = prepared(start)()
        start = Task(study, before, x, c, y, start.inputs)
    return Task(study, samples, start.x, start.c, start.y, np.ascontiguousarray(inputs(study, before, samples)))


def prepared(task: Task) -> Callable[[], tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """The kernel of `imo simulate` with its arguments made beforehand: what one call of the others costs beside it.

    Returns the states of machine, observer and drive at the end of the task.
    """
    study, machine = task.study, task.study.machine
    run, sensor, friction = kernel(loop_of(study)), (1.0, 1.0, 0.0, 0.0, 0.0), machine.B / machine.n_p
    p, d, believed = machine.plant_parameters, drive_parameters(study), machine.observer_parameters
    gains, substeps = study.observers[KIND].gain_values, study.simulation.substeps
    out, lost = np.empty((-(-task.samples // 10), 17)), np.full(2, -1)

    def call() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x, c, y = task.x.copy(), task.c.copy(), task.y.copy()
        run(0, task.samples, 10, 1e-4, substeps, BOUND, x, c, task.inputs, sensor, p, friction, d, out, lost, y, believed,
            gains)
        return x, y, c

    return call


def ours(task: Task) -> np.ndarray:
    """The kernel of `imo simulate`: the 13 states at the end."""
    return np.concatenate(prepared(task)()[:2])


@cache
def _single(flags: tuple[str, ...]) -> Any:
    return c_code.load("reference.c", flags)


def c_single(task: Task, flags: tuple[str, ...] = c_code.FLAGS) -> np.ndarray:
    """reference.c."""
    study, machine = task.study, task.study.machine
    states, c, out = np.concatenate([task.x, task.y]), task.c.copy(), np.empty((-(-task.samples // 10), 17))
    p = np.array([*machine.plant_parameters, machine.B / machine.n_p])
    arrays = [p, np.array(machine.observer_parameters), np.array(study.observers[KIND].gain_values),
              np.array(drive_parameters(study)), states, c, out]
    _single(flags).run(ctypes.c_long(task.samples), ctypes.c_long(10), ctypes.c_double(BOUND), c_code.pointer(task.inputs),
                       ctypes.c_long(task.samples), *map(c_code.pointer, arrays))
    return states


def _sampled(task: Task, integrate: Callable[[np.ndarray, Any, float, float], np.ndarray]) -> np.ndarray:
    """The drive in plain Python around any way to integrate a sample with held voltage, load and direction."""
    study = task.study
    T, p, d = study.simulation.sample_time, study.machine.plant_parameters, drive_parameters(study)
    states = np.concatenate([task.x, task.y])
    control, flux, flow = tuple(task.c[:3]), tuple(task.c[3:5]), tuple(task.c[5:7])
    for k in range(task.samples):
        i, omega = (float(states[0]), float(states[1])), float(states[4])
        u, control = drive.control(control, i, omega, flux, task.inputs[0, k], task.inputs[1, k], p, d)
        flux, flow = drive.flux_model(flux, flow, i, omega, T, p)
        states = integrate(states, u, task.inputs[2, k], direction_of(omega))
    return states


def _rates(task: Task) -> Callable[..., list[float]]:
    study, machine = task.study, task.study.machine
    p, friction, gains = machine.plant_parameters, machine.B / machine.n_p, study.observers[KIND].gain_values
    rates, believed = OBSERVERS[KIND].rates, machine.observer_parameters

    def all_rates(states: Any, u: Any, T_l: float, direction: float) -> list[float]:
        x = tuple(states[:5].tolist())
        return [*machine_rates(x, u, T_l, p, friction),
                *rates(tuple(states[5:].tolist()), x[:2], u, direction, believed, gains)]

    return all_rates


def scipy_per_sample(task: Task, rtol: float = 1e-6, method: str = "RK45") -> np.ndarray:
    """scipy's solve_ivp, called for each sample."""
    from scipy.integrate import solve_ivp

    rates, T = _rates(task), task.study.simulation.sample_time

    def integrate(states: np.ndarray, u: Any, T_l: float, direction: float) -> np.ndarray:
        found = solve_ivp(lambda t, y: rates(y, u, T_l, direction), (0.0, T), states, rtol=rtol, atol=rtol, method=method)
        return np.asarray(found.y[:, -1])

    return _sampled(task, integrate)


def exact(task: Task) -> np.ndarray:
    """The same loop to all digits that matter: DOP853 at a tolerance of 1e-12."""
    return scipy_per_sample(task, 1e-12, "DOP853")


def control_per_sample(task: Task, rtol: float = 1e-6) -> np.ndarray:
    """python-control: machine and observer as one nlsys, input_output_response over each sample."""
    import control as ct

    rates, T = _rates(task), task.study.simulation.sample_time
    system = ct.nlsys(lambda t, x, u, params: rates(x, (u[0], u[1]), u[2], u[3]), None, inputs=4, states=13, outputs=13)

    def integrate(states: np.ndarray, u: Any, T_l: float, direction: float) -> np.ndarray:
        held = np.array([[u[0]] * 2, [u[1]] * 2, [T_l] * 2, [direction] * 2])
        found = ct.input_output_response(system, [0.0, T], held, states, solve_ivp_kwargs={"rtol": rtol, "atol": rtol})
        return np.asarray(found.states[:, -1])

    return _sampled(task, integrate)


def control_in_one(task: Task, rtol: float = 1e-6) -> Callable[[], np.ndarray]:
    """python-control in one call, with steps of its own choice: the voltages of the run are found here, beforehand, so that
    what is returned, and timed, is the call alone; the system holds them from sample to sample."""
    import control as ct

    voltages: list[Any] = []
    T, rates = task.study.simulation.sample_time, _rates(task)
    step = _rk4(rates, T)
    _sampled(task, lambda states, u, T_l, direction: voltages.append((u, T_l, direction)) or step(states, u, T_l, direction))

    def update(t: float, x: np.ndarray, u: Any, params: Any) -> list[float]:
        return rates(x, *voltages[min(int(t / T * (1 + 1e-12)), task.samples - 1)])

    system = ct.nlsys(update, None, inputs=1, states=13, outputs=13)

    def call() -> np.ndarray:
        found = ct.input_output_response(system, [0.0, task.seconds], [0.0, 0.0], np.concatenate([task.x, task.y]),
                                         solve_ivp_kwargs={"rtol": rtol, "atol": rtol})
        return np.asarray(found.states[:, -1])

    return call


def _rk4(rates: Callable[..., list[float]], T: float) -> Callable[..., np.ndarray]:
    def step(states: np.ndarray, *held: Any) -> np.ndarray:
        a = np.array(rates(states, *held))
        b = np.array(rates(states + T / 2 * a, *held))
        c = np.array(rates(states + T / 2 * b, *held))
        d = np.array(rates(states + T * c, *held))
        return states + T / 6 * (a + 2 * (b + c) + d)

    return step


def plain_python(task: Task) -> np.ndarray:
    """The definitions called as they are, RK4, one step a sample: what the compiled kernel does, without compiling it."""
    return _sampled(task, _rk4(_rates(task), task.study.simulation.sample_time))


# Batches -------------------------------------------------------------------------------------------------------------------
def different(study: Study, machines: int) -> dict[str, np.ndarray]:
    """Machines and gains, each different from all others."""
    random = np.random.default_rng(1)

    def around(value: float, share: float) -> np.ndarray:
        return value * (1 + share * (2 * random.random(machines) - 1))

    machine = study.machine
    gains = study.observers[KIND].gains
    return {**{f"machine.{name}": around(getattr(machine, name), 0.3) for name in ("R_s", "R_r", "J")},
            **{f"machine.{name}": around(getattr(machine, name), 0.005) for name in ("L_s", "L_r", "L_m")},
            **{f"observers.{KIND}.gains.{name}": around(gains[name], 0.3) for name in ("k_1", "kappa", "k_3", "g", "K_p")}}


def batch(task: Task, values: dict[str, np.ndarray], jobs: int = 1) -> Summary:
    """Our lanes."""
    return run_batch(task.study, values, nominal=True, jobs=jobs)


@cache
def _lanes(width: int) -> Any:
    return c_code.load("reference_lanes.c", (*c_code.FLAGS, f"-DW={width}"))


@dataclass
class CLanes:
    """reference_lanes.c on the same machines, in blocks of ``width``."""

    task: Task
    values: dict[str, np.ndarray]
    width: int = 16

    def __post_init__(self) -> None:
        study, values = self.task.study, self.values
        machines = len(next(iter(values.values())))
        machine = {name: values.get(f"machine.{name}", np.full(machines, getattr(study.machine, name)))
                   for name in ("n_p", "R_s", "R_r", "L_m", "L_s", "L_r", "J", "B")}
        made = derived(machine)
        self.p = np.array([np.broadcast_to(made[name], machines) for name in (*MACHINE, "friction")], dtype=float)
        self.o = np.repeat(np.array(study.machine.observer_parameters)[:, None], machines, axis=1)
        gains = study.observers[KIND].gains
        self.g = np.array([values.get(f"observers.{KIND}.gains.{name}", np.full(machines, gains[name]))
                           for name in OBSERVERS[KIND].gains])
        self.d = np.array(drive_parameters(study))
        self.library = _lanes(self.width)

    def __call__(self) -> tuple[np.ndarray, np.ndarray]:
        """States at the end, shape (13, machines), and the four sums."""
        machines = self.p.shape[1]
        states = np.repeat(np.concatenate([self.task.x, self.task.y])[:, None], machines, axis=1)
        c, sums = np.zeros((7, machines)), np.zeros((4, machines))
        self.library.run(ctypes.c_long(machines), ctypes.c_long(self.task.samples), ctypes.c_long(10),
                         c_code.pointer(self.task.inputs), ctypes.c_long(self.task.samples),
                         *map(c_code.pointer, (self.p, self.o, self.g, self.d, states, c, sums)))
        return states, sums
