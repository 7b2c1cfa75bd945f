"""The signals that the regressors need, block by block, from a run file or any data set that has them.

A file is read through h5netcdf a slice at a time, so that a run of any length takes the same memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.transformation import to_z
from imo_analysis.errors import InputError
from imo_analysis.excitation.stretches import Stretches, stretches_of
from imo_analysis.machine import InductionMachine

Array = NDArray[np.float64]
PLANT = "plant"
_TIME_BLOCK = 1 << 16
_OF_OBSERVER = ("i_ds_hat", "i_qs_hat", "z_1_hat", "z_2_hat", "xi_1_hat", "xi_2_hat")
_OF_PLANT = ("i_ds", "i_qs", "phi_dr", "phi_qr")


@dataclass(frozen=True)
class Block:
    """Signals over some samples: pairs (d, q) in A, alpha in 1/s, omega in rad/s."""

    i: tuple[Array, Array]
    i_hat: tuple[Array, Array]
    z_hat: tuple[Array, Array]
    xi_hat: tuple[Array, Array]
    alpha: Any
    omega: Array


@dataclass(frozen=True)
class Signals:
    """One observer's signals (or the plant's own) with an even time step.

    Attributes
    ----------
    observer : str
        The observer's name, or ``plant``: then true values stand for the estimates.
    values : str
        ``true`` or ``estimated``: which alpha and omega stand in B*.
    samples : int
        Number of samples.
    stretches : Stretches
        Where the time step is even; one without gaps.
    step : float
        Time step in s.
    machine : InductionMachine
        Gives beta, L_m and the true alpha.
    """

    observer: str
    values: str
    samples: int
    stretches: Stretches
    step: float
    machine: InductionMachine
    _read: Callable[[str, slice], Array]
    _measured: tuple[str, str]

    def block(self, part: slice, pick: NDArray[np.int64] | None = None) -> Block:
        """The signals of a slice of samples.

        Parameters
        ----------
        part : slice
            Of samples.
        pick : ndarray of int, optional
            Which of these; all where left out.
        """

        def read(name: str) -> Array:
            values = self._read(name, part)
            return values if pick is None else values[pick]

        beta = self.machine.beta
        i_ds, i_qs = (read(name) for name in self._measured)
        if self.observer == PLANT:
            i_ds, i_qs, phi_dr, phi_qr = (read(name) for name in _OF_PLANT)
            z = to_z(i_ds, i_qs, phi_dr, phi_qr, beta)
            return Block((i_ds, i_qs), (i_ds, i_qs), z, z, self.machine.alpha, read("omega"))
        i_ds_hat, i_qs_hat, z_1, z_2, xi_1, xi_2 = (read(name) for name in _OF_OBSERVER)
        if self.values == "true":
            alpha: Any = self.machine.alpha
            omega = read("omega")
        else:
            alpha, omega = read("alpha_hat"), read("omega_hat")
        return Block((i_ds, i_qs), (i_ds_hat, i_qs_hat), (z_1, z_2), (xi_1, xi_2), alpha, omega)

    def blocks(self, samples: int) -> Iterator[Block]:
        """All signals, at most ``samples`` at a time.

        Parameters
        ----------
        samples : int
            In a block.
        """
        for begin in range(0, self.samples, samples):
            yield self.block(slice(begin, min(begin + samples, self.samples)))


@dataclass(frozen=True)
class Gaps:
    """Where samples are missing: the first sample of each stretch between gaps, rising from 0, and the time step in s."""

    first: NDArray[np.int64]
    step: float


@dataclass(frozen=True)
class Source:
    """What can be read: a data set in memory or an open file.

    Attributes
    ----------
    name : str
        What it is called in messages.
    has : callable
        Whether there is a signal: ``has(name)``.
    read : callable
        ``read(name, observer, part)`` gives a slice of samples.
    size : int
        Samples.
    observers : tuple of str
        Their names.
    attributes : mapping
        Those of the data set, with the study in them.
    """

    name: str
    has: Callable[[str], bool]
    read: Callable[[str, str, slice], Array]
    size: int
    observers: tuple[str, ...]
    attributes: Any
    _machine: InductionMachine | None

    @property
    def machine(self) -> InductionMachine:
        """The machine that was given, or else the one of the study that the run carries."""
        return self._machine or machine_of(self.attributes, self.name)


def machine_of(attributes: Any, where: str) -> InductionMachine:
    """The machine of the study that a run carries in its attributes."""
    import tomllib

    text = attributes.get("study")
    if not text:
        raise InputError(f"{where} carries no study (attribute 'study'); give the machine (--machine FILE)")
    try:
        table = tomllib.loads(text)["machine"]
    except (tomllib.TOMLDecodeError, KeyError, TypeError):
        raise InputError(f"{where}: its attribute 'study' has no [machine]; give the machine (--machine FILE)") from None
    return InductionMachine.build(table, f"{where}: machine")


def of_dataset(dataset: Any, machine: InductionMachine | None = None, name: str = "the data set") -> Source:
    """A source over an `xarray.Dataset` with dims ``time`` and, unless there is one observer, ``observer``."""
    if "time" not in dataset.dims:
        raise InputError(f"{name} has no dimension 'time'; rename its time axis")
    named = dataset["observer"].values if "observer" in dataset.coords else ["observer"]
    observers = tuple(str(n) for n in np.atleast_1d(named))

    def read(variable: str, observer: str, part: slice) -> Array:
        array = dataset[variable]
        if "observer" in array.dims:
            array = array.isel(observer=observers.index(observer))
        return np.asarray(array.isel(time=part).values, dtype=float)

    return Source(name, lambda v: v in dataset, read, dataset.sizes["time"], observers, dataset.attrs, machine)


@contextmanager
def open_file(path: str | Path, machine: InductionMachine | None = None) -> Iterator[Source]:
    """A source over a run file (.nc), read slice by slice.

    Parameters
    ----------
    path : str or Path
        A run as `imo simulate` writes it; .csv and .parquet are read whole.
    machine : InductionMachine, optional
        In place of that of the study in the file.

    Raises
    ------
    InputError
        If it cannot be read or is not a run.
    """
    import h5netcdf

    path = Path(path)
    if path.suffix in (".csv", ".parquet"):
        from imo_analysis.simulation.runfile import load_run

        yield of_dataset(load_run(path), machine, str(path))
        return
    if not path.is_file():
        reason = "it is not a file" if path.exists() else "there is no such file"
        raise InputError(f"cannot read {path}: {reason}; write runs with 'imo simulate --out run.nc'")
    try:
        file = h5netcdf.File(path, "r")
    except OSError as error:
        reason = error.strerror or "it is not NetCDF"
        raise InputError(f"cannot read {path}: {reason}; write runs with 'imo simulate --out run.nc'") from None
    with file:
        if "time" not in file.dimensions:
            raise InputError(f"{path} is not a run: it has no dimension 'time'")
        labels = file.variables["observer"][...] if "observer" in file.variables else ["observer"]
        observers = tuple(n.decode() if isinstance(n, bytes) else str(n) for n in np.atleast_1d(labels))

        def read(variable: str, observer: str, part: slice) -> Array:
            array = file.variables[variable]
            where = tuple(part if d == "time" else observers.index(observer) for d in array.dimensions)
            return np.asarray(array[where], dtype=float)

        size = file.dimensions["time"].size
        yield Source(str(path), lambda v: v in file.variables, read, size, observers, dict(file.attrs), machine)


def adaptive_observers(source: Source) -> list[str]:
    """The observers of a source that have both z_hat and xi_hat, at least in one sample of three."""
    if not all(source.has(name) for name in _OF_OBSERVER):
        return []
    probes = [slice(k, k + 1) for k in (0, source.size // 2, source.size - 1)]
    return [o for o in source.observers
            if any(all(np.isfinite(source.read(n, o, p)).all() for n in _OF_OBSERVER) for p in probes)]


def select(source: Source, observer: str, values: str = "true", gaps: Gaps | None = None) -> Signals:
    """The signals of one observer.

    Parameters
    ----------
    source : Source
        From `open_file` or `of_dataset`.
    observer : str
        Its name in the run, or ``plant`` for the motion itself.
    values : str
        Alpha and omega in B*: ``true`` or ``estimated``.
    gaps : Gaps, optional
        Where samples are missing; nowhere if left out.

    Raises
    ------
    InputError
        If the observer or a signal is missing, or time is not evenly spaced between the gaps.
    """
    if values not in ("true", "estimated"):
        raise InputError(f"values = {values!r} must be 'true' or 'estimated'")
    if observer != PLANT and observer not in source.observers:
        raise InputError(f"{source.name} has no observer {observer!r}; choose one of: {', '.join((*source.observers, PLANT))}")
    needed = [*_OF_PLANT, "omega"] if observer == PLANT else list(_OF_OBSERVER)
    if observer != PLANT:
        needed += ["omega"] if values == "true" else ["alpha_hat", "omega_hat"]
    measured = ("i_ds_meas", "i_qs_meas") if source.has("i_ds_meas") and source.has("i_qs_meas") else ("i_ds", "i_qs")
    missing = [name for name in (*needed, *measured, "time") if not source.has(name)]
    if missing:
        raise InputError(f"{source.name} lacks {', '.join(missing)}, which the regressor of {observer!r} needs")
    if observer != PLANT and observer not in adaptive_observers(source):
        raise InputError(f"observer {observer!r} of {source.name} has no z_hat and xi_hat (or they are NaN), so (19) says "
                         f"nothing about it; take another observer, or '{PLANT}' for the motion itself")
    stretches, step = _even_steps(source, gaps)
    return Signals(observer, "true" if observer == PLANT else values, source.size, stretches, step, source.machine,
                   lambda name, part: source.read(name, observer, part), measured)


def _even_steps(source: Source, gaps: Gaps | None) -> tuple[Stretches, float]:
    size = source.size
    if size < 2:
        raise InputError(f"{source.name} has {size} sample(s); an integral over a window needs at least 2")
    if gaps is None:
        first, last = (float(source.read("time", "", slice(k, k + 1))[0]) for k in (0, size - 1))
        gaps = Gaps(np.array([0]), (last - first) / (size - 1))
        if not gaps.step > 0:
            raise InputError(f"time of {source.name} goes from {first} to {last} s; it must increase, without NaN")
    start, step = np.full(len(gaps.first), np.nan), gaps.step
    for begin in range(0, size, _TIME_BLOCK):
        part = slice(begin, min(begin + _TIME_BLOCK, size))
        time, sample = source.read("time", "", part), np.arange(part.start, part.stop)
        here = slice(*np.searchsorted(gaps.first, [part.start, part.stop]))
        start[here] = time[gaps.first[here] - part.start]
        stretch = np.searchsorted(gaps.first, sample, side="right") - 1
        expected = start[stretch] + step * (sample - gaps.first[stretch])
        off = ~(np.abs(time - expected) <= 0.01 * step)
        if off.any():
            at = int(np.argmax(off))
            raise InputError(f"time of {source.name} is not evenly spaced: sample {part.start + at} is at {time[at]:.9g} s, "
                             f"a step of {step:.6g} s would give {expected[at]:.9g} s; resample the log. Where "
                             "samples are missing, imo replay --gaps bridge judges the stretches between")
    return stretches_of(gaps.first, size, start), step
