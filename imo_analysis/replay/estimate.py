"""Observers of the catalogue run over a recorded log: estimates block by block, or all of them as a data set.

What a sample means is said by `Treatment`. A record without a speed is estimated from voltages and currents alone; a speed
that was recorded is used for errors, for plausibility, and for the direction of rotation that some observers must be told.
"""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS, Observer
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.notation import symbol
from imo_analysis.replay.check import Level
from imo_analysis.replay.gains import default_bandwidth, default_gains
from imo_analysis.replay.kernel import replay_kernel
from imo_analysis.replay.logs import BLOCK, Log, Samples
from imo_analysis.replay.start import Start, flying_start
from imo_analysis.replay.survey import Survey, steps_of
from imo_analysis.simulation.run import BOUND, ESTIMATES, SCHEMA

if TYPE_CHECKING:
    import xarray as xr

VOLTAGE = ("linear", "held", "averaged")
CURRENT = ("linear", "held")
DIRECTION = ("measured", "estimated", "forward", "reverse")
_RADIANS_A_STEP = 0.5


@dataclass(frozen=True)
class Treatment:
    """What a sample stands for between the instants of sampling.

    Attributes
    ----------
    voltage : str
        ``linear``: an instantaneous sample of a smooth voltage, joined to the next by a straight line; ``held``: the value
        that the drive applies from this sample to the next; ``averaged``: the mean over the interval that ends at it.
    current : str
        ``linear``: an instantaneous sample, joined to the next; ``held``: what an observer in the drive sees until the next.
    direction : str
        Where the direction of rotation comes from: ``measured`` speed, the observer's own estimate, or a constant.
    """

    voltage: str = "linear"
    current: str = "linear"
    direction: str = "estimated"

    def __post_init__(self) -> None:
        for name, known in (("voltage", VOLTAGE), ("current", CURRENT), ("direction", DIRECTION)):
            if getattr(self, name) not in known:
                raise InputError(f"{name} = {getattr(self, name)!r} is not known; choose one of: {', '.join(known)}")

    @property
    def text(self) -> str:
        """In words, for people."""
        voltage = {"linear": "instantaneous samples joined by straight lines", "held": "held from each sample to the next",
                   "averaged": "means over the interval that ends at each sample"}[self.voltage]
        current = {"linear": "instantaneous samples joined by straight lines", "held": "held from each sample to the next"}
        direction = {"measured": "the sign of the recorded speed", "estimated": "the sign of the observer's own estimate",
                     "forward": "+1 throughout", "reverse": "-1 throughout"}[self.direction]
        return f"voltages: {voltage}; currents: {current[self.current]}; direction of rotation: {direction}"


@dataclass
class Runner:
    """One observer on its way through a record.

    Attributes
    ----------
    kind : str
        In the catalogue, or the file of an own one.
    gains : dict of str to float
        All gains by name.
    x : ndarray
        State at the last sample that was taken.
    longest : float
        The longest gap in s that is integrated over along straight lines.
    lost : int
        Row of the first sample at which it had diverged, or -1.
    begun : Start
        What the record says of the first sample; ``initial`` has it, and over it what the user said.
    by_rule : bool
        Whether gains were chosen from the record, but for those that the user gave.
    """

    kind: str
    machine: InductionMachine
    treatment: Treatment
    gains: dict[str, float]
    initial: Mapping[str, float]
    sample_time: float
    longest: float = math.inf
    x: np.ndarray = field(default_factory=lambda: np.empty(0))
    lost: int = -1
    begun: Start = field(default_factory=lambda: Start({}, "", guessed=False))
    by_rule: bool = True

    @property
    def observer(self) -> Observer:
        """Its definition."""
        return OBSERVERS[self.kind]

    @property
    def name(self) -> str:
        """What it is called in results."""
        return self.observer.name

    @property
    def guessed(self) -> bool:
        """Whether it begins with a flux that was estimated from the record, and so may be wrong."""
        flux = [state for state in self.begun.values if state in self.observer.states and state != "omega_hat"]
        return self.begun.guessed and any(self.initial[state] == self.begun.values[state] for state in flux)

    def __post_init__(self) -> None:
        for table, known in ((self.gains, self.observer.gains), (self.initial, self.observer.states)):
            for key in table:
                if key not in known:
                    raise InputError(f"{key} is not known for {self.name}; it has: {', '.join(known)}")
        quick = ("k_1", "l_1", "l_2", *(name for name, unit in self.observer.units.items() if unit == "1/s"))
        fastest = sum(abs(self.gains.get(name, 0.0)) for name in quick) + self.machine.gamma
        self.substeps = max(1, math.ceil(fastest * self.sample_time / _RADIANS_A_STEP))
        if self.substeps > 10_000:
            raise InputError(
                f"gains of {self.name} are {fastest * self.sample_time:.3g} times faster than the record's samples; lower them"
            )

    def _start(self, i_ds: float, i_qs: float) -> None:
        """Currents as recorded, alpha as the machine's, and, unless ``initial`` knows better, no flux (z = i) at standstill."""
        known = {"i_ds_hat": i_ds, "i_qs_hat": i_qs, "z_1_hat": i_ds, "z_2_hat": i_qs, "xi_1_hat": i_ds, "xi_2_hat": i_qs,
                 "alpha_hat": self.machine.alpha, **self.initial}
        self.x = np.array([float(known.get(state, 0.0)) for state in self.observer.states])

    def take(self, before: Samples | None, block: Samples) -> np.ndarray:
        """States at the samples of the next block, shape (states, samples); ``before`` is the block that precedes it."""
        out = np.full((len(block), len(self.observer.states)), np.nan)
        first = 0
        if before is None:
            self._start(float(block.i_ds[0]), float(block.i_qs[0]))
            out[0] = self.x
            first = 1
        if self.lost >= 0 or first == len(block):
            return out.T
        u_d, u_q, i_d, i_q, time = (
            getattr(block, name) if before is None else np.concatenate([getattr(before, name)[-1:], getattr(block, name)])
            for name in ("u_ds", "u_qs", "i_ds", "i_qs", "time")
        )
        steps = steps_of(time, self.sample_time)
        substeps = self.substeps * np.ceil(steps / self.sample_time * (1 - 1e-9)).astype(np.int64)
        substeps[(steps != self.sample_time) & (steps > self.longest)] = 0  # passed over
        direction = np.full(len(steps), -1.0 if self.treatment.direction == "reverse" else 1.0)
        if self.treatment.direction == "measured":
            assert block.omega is not None
            omega = block.omega if before is None or before.omega is None else np.append(before.omega[-1:], block.omega)
            direction = np.where(omega[:-1] >= 0, 1.0, -1.0)
        done = replay_kernel(self.kind)(
            self.x, *(np.ascontiguousarray(v) for v in (u_d, u_q, i_d, i_q)), steps, substeps, direction,
            self.treatment.direction == "estimated", self.treatment.voltage == "averaged",
            float(self.treatment.voltage == "linear"), float(self.treatment.current == "linear"), BOUND,
            self.machine.observer_parameters, tuple(self.gains[name] for name in self.observer.gains), out[first:],
        )
        if done < len(steps):
            self.lost = block.first + first + done
            out[first + done :] = np.nan
        return out.T


def runners(
    names: Sequence[str],
    machine: InductionMachine,
    treatment: Treatment,
    survey: Survey,
    level: Level,
    *,
    bandwidth: float | None = None,
    gains: Mapping[str, float] | None = None,
    initial: Mapping[str, float] | None = None,
    study_gains: Mapping[str, Mapping[str, float]] | None = None,
    study_initial: Mapping[str, Mapping[str, float]] | None = None,
) -> list[Runner]:
    """The observers, with gains by the rule of `replay.gains` and starts by `flying_start` but for what is given.

    Parameters
    ----------
    names : sequence of str
        Observers of the catalogue, or files of own ones.
    machine : InductionMachine
        As the observers believe it to be.
    treatment : Treatment
        What samples stand for.
    survey : Survey
        What the first pass found in the record.
    level : Level
        Frequency, flux and noise of the record, from which gains follow.
    bandwidth : float, optional
        Of the speed loop in rad/s; by the rule where left out.
    gains, initial : mapping of str to float, optional
        In place of what the rule gives, SI units.
    study_gains, study_initial : mapping of str to mapping, optional
        The same by observer, as a study has them; ``gains`` and ``initial`` go before them.

    Raises
    ------
    InputError
        If an observer, a gain or a state is not known.
    """
    made = []
    begin = flying_start(survey.head, survey.sample_time, machine, treatment.voltage)
    for name in names:
        observer = OBSERVERS[name]
        wide = default_bandwidth(machine, level, survey.sample_time) if bandwidth is None else bandwidth
        mine = {key: value for key, value in (gains or {}).items() if len(names) == 1 or key in observer.gains}
        chosen = dict((study_gains or {}).get(name, {}))
        by_rule = not {*mine, *chosen} >= set(observer.gains)
        if by_rule:
            chosen = default_gains(name, machine, level, wide)
        start = {key: value for key, value in begin.values.items() if key in observer.states}
        start |= (study_initial or {}).get(name, {})
        start |= {key: value for key, value in (initial or {}).items() if len(names) == 1 or key in observer.states}
        made.append(Runner(name, machine, treatment, {**chosen, **mine}, start, survey.sample_time, level.longest_line,
                           begun=begin, by_rule=by_rule))
    for given, kind in ((gains or {}, "gain"), (initial or {}, "state")):
        for key in given:
            if not any(key in (r.gains if kind == "gain" else r.observer.states) for r in made):
                raise InputError(f"{key} is not a {kind} of {', '.join(r.name for r in made)}")
    labels = [one.name for one in made]
    if twice := [label for label in labels if labels.count(label) > 1]:
        raise InputError(f"two observers are called {twice[0]}; give one of the files another name= in its OBSERVER")
    return made


@dataclass(frozen=True)
class Estimates:
    """A block of results: ``values`` maps each name of a run's variables to an array, (observer, time) or (time,)."""

    first: int
    values: dict[str, np.ndarray]


def estimate(
    log: Log, observers: Sequence[Runner], rows: int = BLOCK, progress: Callable[[int], None] | None = None
) -> Iterator[Estimates]:
    """Run the observers through the record, block by block.

    The numbers do not depend on ``rows``, to the bit.

    Parameters
    ----------
    log : Log
        The record.
    observers : mapping of str to Runner
        From `runners`.
    rows : int
        Samples in a block.
    progress : callable, optional
        Called with the number of samples done.
    """
    before: Samples | None = None
    for block in log.blocks(rows):
        values = {"time": block.time, "u_ds": block.u_ds, "u_qs": block.u_qs, "i_ds_meas": block.i_ds, "i_qs_meas": block.i_qs}
        if block.omega is not None:
            values["omega"] = block.omega
        shape = (len(observers), len(block))
        further = (state for runner in observers for state in runner.observer.states)
        values |= {name: np.full(shape, np.nan) for name in dict.fromkeys((*ESTIMATES, *further))}
        for n, runner in enumerate(observers):
            observer = runner.observer
            x = runner.take(before, block)
            for name, column in zip(observer.states, x, strict=True):
                values[name][n] = column
            with np.errstate(divide="ignore", invalid="ignore"):
                flux = observer.flux(tuple(x), (block.i_ds, block.i_qs), runner.machine.beta)
            values["phi_dr_hat"][n], values["phi_qr_hat"][n] = flux
        yield Estimates(block.first, values)
        before = block
        if progress:
            progress(len(block))


def attributes(name: str) -> dict[str, str]:
    """Unit, meaning and LaTeX of a variable of the result."""
    known = {
        "time": ("s", "time", "t"), "omega": ("rad/s", "rotor speed, electrical, as recorded", r"\omega"),
        "i_ds_meas": ("A", "stator current, d axis, as recorded", "i_{ds}"),
        "i_qs_meas": ("A", "stator current, q axis, as recorded", "i_{qs}"),
    }
    if name not in known:
        entry = symbol(name)
        known[name] = (entry.unit, entry.meaning, entry.latex)
    return dict(zip(("units", "long_name", "latex"), known[name], strict=True))


def provenance(log: Log, machine: InductionMachine, observers: Sequence[Runner], treatment: Treatment) -> dict[str, Any]:
    """Attributes of the result: what was read, by which machine and gains, with which versions."""
    versions = {name: version(name) for name in ("imo-analysis", "numpy", "numba", "llvmlite")}
    versions["python"] = platform.python_version()
    return {
        "schema": SCHEMA, "title": f"replay of {log.path.name}", "study": machine.to_toml(), "versions": json.dumps(versions),
        "columns": "; ".join(log.mapping()), "treatment": treatment.text,
        "gains": json.dumps({runner.name: runner.gains for runner in observers}),
    }


def collect(log: Log, observers: Sequence[Runner], attrs: Mapping[str, Any], every: int = 1, rows: int = BLOCK) -> xr.Dataset:
    """The whole result in memory, laid out as a run (FORMATS.md, imo-run/1); what is not known is absent.

    Parameters
    ----------
    attrs : mapping
        From `provenance`.
    every : int
        Keep one sample in so many.
    """
    import xarray as xr

    parts: dict[str, list[np.ndarray]] = {}
    for block in estimate(log, observers, rows):
        for name, values in block.values.items():
            parts.setdefault(name, []).append(values[..., -block.first % every :: every])
    whole = {name: np.concatenate(arrays, axis=-1) for name, arrays in parts.items()}
    time = whole.pop("time")
    return xr.Dataset(
        {name: (("observer", "time") if values.ndim == 2 else ("time",), values, attributes(name))
         for name, values in whole.items()},
        coords={"time": ("time", time, attributes("time")), "observer": [runner.name for runner in observers]},
        attrs=dict(attrs),
    )
