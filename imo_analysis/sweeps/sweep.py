"""Monte Carlo and grids over any field of a study: planned, cut into chunks, computed anywhere, resumed, put together.

A chunk is a function of the study's text and the chunk's number alone. It is computed by threads here or by a dask cluster;
the result is the same to the bit on processors of the same kind.
"""

from __future__ import annotations

import itertools
import json
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.errors import InputError
from imo_analysis.simulation.composition import loop_of
from imo_analysis.simulation.kernel import plain
from imo_analysis.simulation.run import provenance, simulate_labelled
from imo_analysis.study import Study
from imo_analysis.study_units import unit_of
from imo_analysis.sweeps import distributions
from imo_analysis.sweeps.batch import lane_fields, processors, run_batch
from imo_analysis.sweeps.metrics import METRICS, metrics, summed, window_of
from imo_analysis.sweeps.values import impossible, own_value, with_values

if TYPE_CHECKING:
    import xarray as xr

SCHEMA = "imo-sweep/1"
CHUNK = 512
WORKERS_WITHIN = 30.0  # s, that a cluster has to show its first worker
Array = NDArray[np.float64]
# name -> array of shape (observers, runs of the chunk); and "possible", shape (runs of the chunk,)
Part = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Chunk:
    """Runs ``first .. last - 1``, all at the same values of the fields that are not lanes."""

    number: int
    first: int
    last: int
    variant: int


class Plan:
    """What a study's table ``[sweep]`` asks for.

    Attributes
    ----------
    source : Study
        The study as it was given.
    study : Study
        The same with the scenario of the sweep merged and no other left.
    text : str
        ``study`` as TOML text.
    fields : dict
        Distribution of each field.
    chunks : list of Chunk
    runs : int
        Runs in all.
    one_by_one : bool
        Whether a field is drawn that cannot differ from lane to lane, so that every run is one of its own.
    """

    def __init__(self, study: Study) -> None:
        self.source = study
        merged = study.scenario(study.sweep.scenario).data if study.sweep.scenario else study.data
        alone = {key: value for key, value in merged.items() if key != "scenarios"}
        alone["sweep"] = {key: value for key, value in alone.get("sweep", {}).items() if key != "scenario"}
        self.study = Study.from_data(alone)
        self.text = self.study.to_toml()
        self.settings = self.study.sweep
        self.fields = distributions.flattened(self.settings.fields_)
        if not self.fields:
            raise InputError("sweep.fields is empty; say which field varies, for example "
                             '"machine.R_r" = { relative = 0.5 } in [sweep.fields]')
        own = {name: own_value(self.study, name) for name in self.fields}
        in_lanes = lane_fields(self.study)
        outer = {}
        self.one_by_one = False
        for name, spec in self.fields.items():
            if name in in_lanes:
                self._check_numbers(name, spec)
                continue
            if distributions.is_grid(spec):
                outer[name] = distributions.grid(spec)
            elif isinstance(own[name], float):
                self.one_by_one = True
            else:
                raise InputError(f"sweep.fields.{name}: {own[name]!r} is no number with decimals; it can be swept over a grid "
                                 "only: values, linspace or geomspace")
        self._own = own
        self._outer = list(itertools.product(*outer.values()))
        self._outer_names = list(outer)
        inner = {name: distributions.grid(spec) for name, spec in self.fields.items()
                 if name not in outer and distributions.is_grid(spec)}
        self._inner = list(itertools.product(*inner.values()))
        self._inner_names = list(inner)
        self._drawn = [name for name in self.fields if name not in outer and name not in inner]
        draws = self.settings.runs
        if not self._drawn and draws > 1:
            warnings.warn(f"sweep.runs = {draws} draws nothing, since every field has a grid; each point of it is run once",
                          stacklevel=2)
            self.study = self.study.changed({"sweep.runs": 1})
            self.text = self.study.to_toml()
            self.settings = self.study.sweep
            draws = 1
        self._draws = draws
        each = len(self._inner) * draws
        self.runs = len(self._outer) * each
        self.chunks: list[Chunk] = []
        for variant in range(len(self._outer)):
            for first in range(0, each, CHUNK):
                last = min(first + CHUNK, each)
                self.chunks.append(Chunk(len(self.chunks), variant * each + first, variant * each + last, variant))
        for variant in range(len(self._outer)):
            self.check_window(self.variant(variant))

    @staticmethod
    def _check_numbers(name: str, spec: Mapping[str, Any]) -> None:
        for value in distributions.grid(spec) if distributions.is_grid(spec) else []:
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise InputError(f"sweep.fields.{name}: {value!r} must be a number in {unit_of(name)}, without its unit")

    def check_window(self, study: Study) -> None:
        """Refuse a window that is not in the run of a study.

        Raises
        ------
        InputError
            With the time that is wrong.
        """
        first, last = window_of(study)
        T, length = study.simulation.sample_time, study.simulation.duration
        if first + study.simulation.record_every >= last:
            raise InputError(f"sweep.start = {self.settings.start:g} s must be before the end of the run at {length:g} s")
        if study.sweep.hold > (last - first) * T:
            raise InputError(f"sweep.hold = {self.settings.hold:g} s must be at most the window, {(last - first) * T:g} s")

    def variant(self, number: int) -> Study:
        """The study at a point of the grid over fields that are not lanes."""
        study = with_values(self.study, dict(zip(self._outer_names, self._outer[number], strict=True)))
        if not study.observers:
            raise InputError("the study has no observers; a sweep judges observers")
        return study

    def values(self, first: int, last: int) -> dict[str, NDArray[Any]]:
        """The values of all fields at runs ``first .. last - 1``."""
        run = np.arange(first, last)
        each = len(self._inner) * self._draws
        found: dict[str, NDArray[Any]] = {}
        for column, name in enumerate(self._outer_names):
            found[name] = np.array([point[column] for point in self._outer])[run // each]
        for column, name in enumerate(self._inner_names):
            found[name] = np.array([float(point[column]) for point in self._inner])[run % each // self._draws]
        for name in self._drawn:
            spec, own = self.fields[name], float(self._own[name])
            found[name] = distributions.draw(name, spec, own, self.settings.seed, run % self._draws)
        return {name: found[name] for name in self.fields}

    def study_of(self, run: int) -> Study:
        """The study that makes one run alone, to look at it closely."""
        values = self.values(run, run + 1)
        plain = {name: value[0].item() for name, value in values.items()}
        study = with_values(self.study, plain)
        if self.settings.believe == "own":
            return study
        nominal: dict[str, Any] = {}
        for name, settings in self.study.observers.items():
            for parameter in ("R_s", "R_r", "L_m", "L_s", "L_r"):
                if f"machine.{parameter}" in values:
                    share = float(values.get(f"observers.{name}.errors.{parameter}", [settings.errors.get(parameter, 0.0)])[0])
                    nominal[f"observers.{name}.errors.{parameter}"] = (
                        getattr(self.study.machine, parameter) / plain[f"machine.{parameter}"] * (1.0 + share) - 1.0)
        return with_values(study, nominal) if nominal else study

    @cached_property
    def observers(self) -> list[str]:
        """Observers that are judged."""
        return list(self.study.observers)


@lru_cache(maxsize=4)
def plan_of(text: str) -> Plan:
    """The plan of a study's text."""
    return Plan(Study.from_toml(text))


def compute(text: str, number: int, jobs: int = 1) -> Part:
    """One chunk of the sweep of a study, from its text: what a worker anywhere does."""
    plan = plan_of(text)
    chunk = plan.chunks[number]
    study = plan.variant(chunk.variant)
    values = {name: value for name, value in plan.values(chunk.first, chunk.last).items() if name not in plan._outer_names}
    count = chunk.last - chunk.first
    nominal = plan.settings.believe == "nominal"
    wrong, reasons = impossible(study, values, nominal)
    found: Part = {name: np.full((len(study.observers), count), np.nan) for name in METRICS}
    found["holds"][:] = 0.0
    found["possible"] = ~wrong
    found["reasons"] = np.array(json.dumps(reasons))
    good = np.flatnonzero(~wrong)
    if not good.size:
        return found
    if plain(loop_of(study)) and not plan.one_by_one:
        summary = run_batch(study, {name: value[good] for name, value in values.items()}, nominal=nominal,
                            window=window_of(study), band=plan.settings.band, jobs=jobs, machines=len(good))
        for name, value in metrics(study, summary).items():
            found[name][:, good] = value
        return found

    def single(run: int) -> dict[str, Array] | str:
        try:
            one = plan.study_of(chunk.first + run)
            plan.check_window(one)
        except InputError as error:  # what was drawn makes no study; with its values out, the same reasons count together
            text = str(error)
            for name, value in values.items():
                for written in (repr(float(value[run])), f"{value[run]:g}"):
                    text = text.replace(f"{name.rpartition('.')[2]} = {written}", f"{name.rpartition('.')[2]} = ...")
            return text
        data, _ = simulate_labelled(one)
        return metrics(one, summed(one, data, window_of(one)))

    with ThreadPoolExecutor(jobs) as pool:
        for run, one in zip(good, pool.map(single, good), strict=True):
            if isinstance(one, str):
                found["possible"][run] = False
                reasons.append(f"1 with {one}")
                continue
            for name, value in one.items():
                found[name][:, run] = value[:, 0]
    found["reasons"] = np.array(json.dumps(reasons))
    return found


def locally(plan: Plan, wanted: list[int], jobs: int | None = None) -> Iterator[tuple[int, Part]]:
    """Chunks one after the other, each by all threads."""
    for number in wanted:
        yield number, compute(plan.text, number, jobs or processors())


def connected(scheduler: Any) -> Any:
    """A dask client of the cluster; ``scheduler`` is its address or a cluster object.

    Raises
    ------
    InputError
        If dask is not installed, the scheduler does not answer, or it has no workers.
    """
    try:
        from distributed import Client
    except ImportError:
        raise InputError("--scheduler needs dask.distributed; pip install 'imo-analysis[sweep]'") from None
    try:
        # never the default: a client that got no answer would stay it, and fail every later use of dask in this process
        client = Client(scheduler, timeout=10, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"--scheduler = {scheduler} does not answer ({str(error).splitlines()[0]}); "
                         "start one with: dask scheduler") from None
    try:
        client.wait_for_workers(1, timeout=WORKERS_WITHIN)
    except TimeoutError:
        address = client.scheduler.address
        client.close()
        raise InputError(f"--scheduler = {scheduler} has no workers after {WORKERS_WITHIN:g} s; start some with: dask worker "
                         f"{address}") from None
    return client


def on_cluster(plan: Plan, wanted: list[int], client: Any) -> Iterator[tuple[int, Part]]:
    """Chunks by the workers of a dask cluster, as they come; the client, from `connected`, is closed at the end."""
    from distributed import as_completed

    with client:
        numbers = {client.submit(compute, plan.text, number, pure=False): number for number in wanted}
        for future in as_completed(list(numbers), loop=client.loop):
            yield numbers[future], future.result()
            future.release()


def assembled(plan: Plan, parts: Mapping[int, Part]) -> xr.Dataset:
    """The data set of a sweep from all its chunks.

    Returns
    -------
    xarray.Dataset
        Dimensions ``run`` and ``observer``; each swept field is a coordinate along ``run`` under its dotted name, ``possible``
        says which runs were made, and the rest is `METRICS`.
    """
    import xarray as xr

    values = plan.values(0, plan.runs)
    ordered = [parts[chunk.number] for chunk in plan.chunks]
    data: dict[str, Any] = {}
    for name, (unit, meaning) in METRICS.items():
        whole = np.concatenate([part[name] for part in ordered], axis=1)
        attrs = {"units": unit, "long_name": meaning}
        data[name] = (("observer", "run"), whole.astype(np.int8) if name == "holds" else whole, attrs)
    data["possible"] = ("run", np.concatenate([part["possible"] for part in ordered]).astype(np.int8),
                        {"units": "1", "long_name": "1 where the machine, drive and observers can exist and the run was made"})
    coordinates: dict[str, Any] = {"run": ("run", np.arange(plan.runs), {"units": "1", "long_name": "number of the run"}),
                                   "observer": ("observer", np.array(plan.observers, dtype=str))}
    for name, value in values.items():
        about: dict[str, Any] = {"units": unit_of(name), "long_name": name}
        if isinstance(plan._own[name], (int, float)):
            about["study_value"] = float(plan._own[name])
        coordinates[name] = ("run", value, about)
    whole_attrs = {**provenance(plan.source), "title": plan.study.title, "schema": SCHEMA, "seed": plan.settings.seed,
             "refused": json.dumps(refused(ordered))}
    return xr.Dataset(data, coordinates, whole_attrs)


def refused(parts: list[Part]) -> dict[str, int]:
    """Why runs were not made, and how many each time."""
    counts: dict[str, int] = {}
    for part in parts:
        for reason in json.loads(str(part["reasons"])):
            count, _, text = reason.partition(" with ")
            counts[text] = counts.get(text, 0) + int(count)
    return counts


def sweep(
    study: Study, progress: Callable[[int], None] | None = None, jobs: int | None = None, scheduler: Any = None
) -> xr.Dataset:
    """Run the sweep of a study.

    Parameters
    ----------
    study : Study
        With a table ``[sweep]``.
    progress : callable, optional
        Called with the number of runs done since the last call.
    jobs : int, optional
        Threads.
    scheduler : str or dask cluster, optional
        Compute there instead of here.

    Returns
    -------
    xarray.Dataset
        As `assembled`.
    """
    plan = Plan(study)
    wanted = [chunk.number for chunk in plan.chunks]
    parts: dict[int, Part] = {}
    for number, part in on_cluster(plan, wanted, connected(scheduler)) if scheduler else locally(plan, wanted, jobs):
        parts[number] = part
        if progress:
            progress(len(part["possible"]))
    check_possible(plan, parts)
    return assembled(plan, parts)


def check_possible(plan: Plan, parts: Mapping[int, Part]) -> None:
    """Refuse a sweep of which no run could be made."""
    if not any(part["possible"].any() for part in parts.values()):
        reasons = "; ".join(f"{count} with {text}" for text, count in refused(list(parts.values())).items())
        raise InputError(f"none of the {plan.runs} runs of the sweep is possible: {reasons}; change sweep.fields")
