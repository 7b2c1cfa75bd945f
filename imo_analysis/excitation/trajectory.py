"""The condition (19) and the reduced one along a run: eigenvalues over time, rank, lost directions, level and instants.

The mean Gram matrix (1/T) int B^T B dt over a window [t, t + T] is taken by the rectangle rule on the samples. Columns are
scaled so that every error is a pure number of like size (`Scale`): a window's eigenvalues are then fractions of the strongest
excitation, and a direction counts as lost when its eigenvalue is below ``threshold`` times the largest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from imo_analysis.errors import InputError
from imo_analysis.excitation.conditions import BLOCK_SAMPLES, CONDITIONS, Condition, Scale, survey
from imo_analysis.excitation.gram import SlidingSum, cell_grams, full
from imo_analysis.excitation.signals import Signals
from imo_analysis.excitation.stretches import Stretches

Array = NDArray[np.float64]
CELLS_PER_WINDOW = 5
MAX_ROWS = 4000
MAX_INSTANTS = 1000
THRESHOLD = 1e-4


@dataclass
class _Track:
    """What is kept of one condition while its windows pass by, in memory that does not grow with the run."""

    condition: Condition
    factor: Array
    samples: int
    keep: int
    threshold: float
    rows: list[tuple[Array, Array, Array]] = field(default_factory=list)
    instants: list[tuple[float, bool]] = field(default_factory=list)
    transitions: int = 0
    windows: int = 0
    holding: int = 0
    undefined: int = 0
    lowest: float = math.inf
    stretches: int = 1
    _state: bool | None = None
    _stretch: int = -1

    def __post_init__(self) -> None:
        self.judged_in, self.holding_in = np.zeros((2, self.stretches), dtype=np.int64)

    def mean_grams(self, packed: Array, samples: int) -> Array:
        return full(packed, len(self.factor)) * np.outer(self.factor, self.factor) / samples

    def take(self, packed: Array, end: NDArray[Any], stretch: NDArray[np.int64]) -> None:
        """Take windows in order; ``end`` has their last instants in s, ``stretch`` the numbers of their stretches."""
        values, vectors = eigen(self.mean_grams(packed, self.samples))
        lowest, largest = values[:, 0], values[:, -1]
        defined: NDArray[np.bool_] = np.isfinite(lowest)
        holds: NDArray[np.bool_] = np.logical_and(defined, lowest > self.threshold * largest)
        self.windows += len(end)
        self.holding += int(holds.sum())
        self.undefined += int((~defined).sum())
        self.judged_in += np.bincount(stretch[defined], minlength=self.stretches)
        self.holding_in += np.bincount(stretch[holds], minlength=self.stretches)
        if defined.any():
            self.lowest = min(self.lowest, float(lowest[defined].min()))
        self._mark(holds, end, stretch)
        self._thin(values, vectors, end)

    def _mark(self, holds: NDArray[np.bool_], end: Array, stretch: NDArray[np.int64]) -> None:
        """Count the changes from a window to the next of the same stretch."""
        same = stretch == np.concatenate([[self._stretch], stretch[:-1]])
        self._stretch = int(stretch[-1])
        for at in np.flatnonzero(_changes(holds, self._state) & same):
            self.transitions += 1
            if len(self.instants) < MAX_INSTANTS:
                self.instants.append((float(end[at]), bool(holds[at])))
        self._state = bool(holds[-1])

    def _thin(self, values: Array, vectors: Array, end: Array) -> None:
        """Keep the worst of every ``keep`` windows, a window without a value being the worst of all."""
        if self.keep == 1:
            self.rows.append((end, values, vectors))
            return
        for begin in range(0, len(end), self.keep):
            part = slice(begin, begin + self.keep)
            worst = begin + int(np.argmin(np.nan_to_num(values[part, 0], nan=-np.inf)))
            one = slice(worst, worst + 1)  # copied, for a view would keep the whole block alive
            self.rows.append((end[part][-1:].copy(), values[one].copy(), vectors[one].copy()))


@dataclass
class _Level:
    """The level of the condition over windows of another length, all of them or those at steps of ``join`` cells."""

    sliding: SlidingSum
    cells: int
    shorter: bool
    lowest: float = math.inf
    holds: bool = True
    windows: int = 0

    def take(self, cells: Array, stretch: NDArray[np.int64], track: _Track, cell: int) -> None:
        """Take cells in order, with their stretches. A shorter window that has failed once is of no interest."""
        if self.shorter and not self.holds:
            return
        sums = self.sliding.within(cells, stretch)[0] if self.shorter else self.sliding.push(cells)
        if not len(sums):
            return
        values = eigen(track.mean_grams(sums, self.cells * cell))[0]
        values = values[np.isfinite(values[:, 0])]
        self.windows += len(values)
        self.lowest = min([self.lowest, *values[:, 0]])
        self.holds = self.holds and bool((values[:, 0] > track.threshold * values[:, -1]).all())

    @property
    def found(self) -> tuple[float, bool]:
        """The smallest eigenvalue and whether every window holds; NaN where that was not followed to the end."""
        if self.shorter and not self.holds:
            return math.nan, False
        return self.lowest, self.holds and self.windows > 0


def _levels(shape: Grid, least: int, samples: int, width: int) -> list[_Level]:
    """Lengths by doubling: from the shortest whole number of cells that can hold up to the window, and on to ``samples``."""
    found, cells = [], max(1, -(-least // shape.cell))
    while cells < shape.cells_per_window:
        found.append(_Level(SlidingSum(cells, width), cells, True))
        cells *= 2
    join = 2
    while join * shape.window < samples:
        found.append(_Level(SlidingSum(shape.cells_per_window, width, join), join * shape.cells_per_window, False))
        join *= 2
    return found


def _changes(holds: NDArray[np.bool_], before: bool | None) -> NDArray[np.bool_]:
    first = holds[:1] if before is None else np.array([before])
    return holds != np.concatenate([first, holds[:-1]])


def eigen(grams: Array) -> tuple[Array, Array]:
    """Eigenvalues, ascending, never below 0, and eigenvectors of a stack of Gram matrices; NaN where a matrix has NaN."""
    defined = np.asarray(np.isfinite(grams).all(axis=(-2, -1)))
    values, vectors = np.linalg.eigh(np.where(defined[:, None, None], grams, 0.0))
    values = np.where(defined[:, None], np.maximum(values, 0.0), np.nan)
    return values, np.where(defined[:, None, None], vectors, np.nan)


@dataclass(frozen=True)
class Grid:
    """Cells and windows in samples."""

    cell: int
    cells_per_window: int

    @property
    def window(self) -> int:
        """Samples in a window."""
        return self.cell * self.cells_per_window


def grid(signals: Signals, window: float, every: float | None, columns: int) -> Grid:
    """The window and its step in whole samples.

    Raises
    ------
    InputError
        If the window is not positive or is longer than the run, the step is longer than the window, or the window holds too few
        samples for ``columns``: each sample adds two rows, so that n of them leave a rank of 2 n at most.
    """
    if not (math.isfinite(window) and window > 0):
        raise InputError(f"window = {window} s must be above 0 s")
    if every is not None and not (math.isfinite(every) and 0 < every <= window):
        raise InputError(f"every = {every} s must be above 0 s and at most the window, {window:g} s, or samples are skipped")
    wanted = window / signals.step
    cell = max(1, round(wanted / CELLS_PER_WINDOW if every is None else every / signals.step))
    result = Grid(cell, max(1, round(wanted / cell)))
    least = least_samples(columns)
    if result.window < least:
        raise InputError(f"window = {window:g} s holds {result.window} sample(s) of {signals.step:g} s, each of which shows 2 "
                         f"directions, and there are {columns}; take {least} samples, {least * signals.step:g} s, or more")
    longest = int(signals.stretches.length.max())
    if result.window > longest:
        stretches = len(signals.stretches)
        most = "the run's" if stretches == 1 else f"that of the longest of {stretches} stretches between gaps,"
        raise InputError(f"window = {window:g} s must be at most {most} {longest * signals.step:g} s; "
                         "take a shorter window (--window) or a longer run")
    return result


def least_samples(columns: int) -> int:
    """The fewest samples whose Gram matrix can have full rank: each adds two rows."""
    return -(-columns // 2)


def excitation(
    signals: Signals,
    window: float = 0.1,
    *,
    every: float | None = None,
    conditions: Sequence[str] = tuple(CONDITIONS),
    scale: Scale | None = None,
    threshold: float = THRESHOLD,
    max_rows: int = MAX_ROWS,
) -> xr.Dataset:
    """Gram matrices over sliding windows of one observer's signals.

    Parameters
    ----------
    signals : Signals
        From `imo_analysis.excitation.signals.select`.
    window : float
        Length T of the window in s; rounded to whole cells of samples.
    every : float, optional
        Step of the window in s; a fifth of the window if not given.
    conditions : sequence of str
        Names in `CONDITIONS`.
    scale : Scale, optional
        Units of the errors; those of `conditions.survey` if not given, `NO_SCALE` for plain SI.
    threshold : float
        An eigenvalue below this fraction of the largest counts as lost.
    max_rows : int
        About how many windows are kept; of neighbours the worst. Counts, levels and instants use all of them.

    Returns
    -------
    xarray.Dataset
        Per condition C: ``C_eigenvalue`` (time, C_mode), ascending; ``C_vector`` (time, C_state, C_mode); ``C_rank``,
        ``C_condition``, ``C_holds`` (time); ``C_level`` and ``C_level_holds`` over ``C_level_window``: the smallest eigenvalue
        over all windows of that length, and whether it holds in each; ``C_instant``, ``C_appears``. ``time`` is the end of the
        window, in s. No window spans a gap. Where there are gaps, no longer windows than ``window`` are looked at, and there
        are ``C_judged`` and ``C_holding``, windows by ``stretch``, with ``stretch_start``, ``stretch_time`` and
        ``stretch_judged`` (s).

    Raises
    ------
    InputError
        See `grid` and `conditions.survey`.
    """
    unknown = [name for name in conditions if name not in CONDITIONS]
    if unknown or not conditions:
        raise InputError(f"condition {', '.join(unknown) or '(none)'} is not known; choose of: {', '.join(CONDITIONS)}")
    if not 0 < threshold < 1:
        raise InputError(f"threshold = {threshold} must lie between 0 and 1")
    shape = grid(signals, window, every, max(len(CONDITIONS[name].states) for name in conditions))
    seen = survey(signals)
    scale = scale or seen.scale
    stretches = signals.stretches
    count = stretches.cells(shape.cell, shape.cells_per_window)
    windows = int(np.maximum(count - shape.cells_per_window + 1, 0).sum())
    unbroken = signals.samples if len(stretches) == 1 else 0
    keep = max(1, -(-windows // max_rows))
    tracks: dict[str, tuple[SlidingSum, _Track]] = {}
    levels: dict[str, list[_Level]] = {}
    totals: dict[str, list[Any]] = {}
    for name in conditions:
        condition = CONDITIONS[name]
        width = len(condition.states) * (len(condition.states) + 1) // 2
        tracks[name] = (SlidingSum(shape.cells_per_window, width),
                        _Track(condition, scale.of(condition), shape.window, keep, threshold, stretches=len(stretches)))
        levels[name] = _levels(shape, least_samples(len(condition.states)), unbroken, width)
        totals[name] = [np.zeros(width), 0]
    for batch in stretches.batches(shape.cell, shape.cells_per_window, BLOCK_SAMPLES):
        block = signals.block(batch.part, batch.pick)
        end = stretches.start[batch.stretch] + signals.step * shape.cell * (batch.place + 1)
        for name, (sliding, track) in tracks.items():
            rows = track.condition.of(block, signals.machine)
            cells = cell_grams(rows, shape.cell, len(block.omega))
            _add_total(totals[name], cells)
            sums, last = sliding.within(cells, batch.stretch)
            if len(sums):
                track.take(sums, end[last], batch.stretch[last])
            for entry in levels[name]:
                entry.take(cells, batch.stretch, track, shape.cell)
    result = xr.Dataset(attrs={
        "schema": "imo-excitation/1", "observer": signals.observer, "values": signals.values,
        "window": shape.window * signals.step, "every": shape.cell * signals.step, "threshold": threshold,
        "scale_current": scale.current, "scale_rate": scale.rate, "scaling": scale.describe(),
        "samples": signals.samples, "kept_of": keep, "still": int(seen.still), "flux_current": seen.current,
        "alpha_direction": seen.alpha_direction, "nan": int(seen.nan), "infinite": int(seen.infinite),
    })
    for name, (_, track) in tracks.items():
        total, cells_used = totals[name]
        whole = eigen(track.mean_grams(total[None], max(1, cells_used * shape.cell)))[0][0]
        judged = track.windows - track.undefined
        level = {entry.cells * shape.cell * signals.step: entry.found for entry in levels[name]}
        level[shape.window * signals.step] = track.lowest, judged > 0 and track.holding == judged
        if unbroken:
            level[signals.samples * signals.step] = float(whole[0]), bool(whole[0] > threshold * whole[-1])
        else:
            found = _by_stretch(track, stretches, count * shape.cell, signals.step)
            result = result.merge(found, compat="no_conflicts", combine_attrs="override")
        result = result.merge(_labelled(track, level), combine_attrs="override")
    return result


def _by_stretch(track: _Track, stretches: Stretches, judged: NDArray[np.int64], step: float) -> xr.Dataset:
    """Windows with a value and those that hold, stretch by stretch; ``judged`` samples of each are in a window."""
    name = track.condition.name
    return xr.Dataset(
        {f"{name}_judged": ("stretch", track.judged_in, {"units": "1", "long_name": "windows with a value in a stretch"}),
         f"{name}_holding": ("stretch", track.holding_in, {"units": "1", "long_name": "windows in which it holds"})},
        {"stretch_start": ("stretch", stretches.start, {"units": "s", "long_name": "first sample of a stretch"}),
         "stretch_time": ("stretch", stretches.length * step, {"units": "s", "long_name": "length of a stretch"}),
         "stretch_judged": ("stretch", judged * step, {"units": "s", "long_name": "length of what is in a window"})})


def _add_total(total: list[Any], cells: Array) -> None:
    """Add the cells without NaN."""
    good = np.isfinite(cells).all(axis=1)
    total[0] = total[0] + cells[good].sum(axis=0)
    total[1] += int(good.sum())


def _labelled(track: _Track, level: dict[float, tuple[float, bool]]) -> xr.Dataset:
    level = dict(sorted(level.items()))
    name = track.condition.name
    end, values, vectors = (np.concatenate(part) for part in zip(*track.rows, strict=True))
    largest = values[:, -1]
    seen = values > track.threshold * largest[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        condition_number = np.where(largest > 0, largest / values[:, 0], np.inf)
    time, mode = "time", f"{name}_mode"
    data = xr.Dataset(
        {
            f"{name}_eigenvalue": ((time, mode), values),
            f"{name}_vector": ((time, f"{name}_state", mode), vectors),
            f"{name}_rank": (time, np.where(np.isfinite(largest), seen.sum(axis=1), -1)),
            f"{name}_condition": (time, np.where(np.isfinite(largest), condition_number, np.nan)),
            f"{name}_holds": (time, seen.all(axis=1)),
            f"{name}_level": (f"{name}_level_window", np.array([v if math.isfinite(v) else np.nan for v, _ in level.values()])),
            f"{name}_level_holds": (f"{name}_level_window", np.array([holds for _, holds in level.values()], dtype=bool)),
            f"{name}_appears": (f"{name}_instant", np.array([a for _, a in track.instants], dtype=bool)),
        },
        coords={
            time: end, mode: np.arange(1, values.shape[1] + 1), f"{name}_state": list(track.condition.states),
            f"{name}_level_window": list(level), f"{name}_instant": np.array([t for t, _ in track.instants], dtype=float),
            f"{name}_factor": (f"{name}_state", track.factor),
        },
    )
    notes = {
        f"{name}_eigenvalue": ("1", "eigenvalues of the scaled mean Gram matrix, ascending"),
        f"{name}_vector": ("1", "eigenvectors in scaled errors"),
        f"{name}_rank": ("1", "effective rank; -1 where a window holds NaN"),
        f"{name}_condition": ("1", "largest over smallest eigenvalue"),
        f"{name}_holds": ("1", "whether no direction is lost"),
        f"{name}_level": ("1", "smallest eigenvalue over all windows of a length: m of the condition, divided by T"),
        f"{name}_level_holds": ("1", "whether the condition holds in every window of a length"),
        f"{name}_appears": ("1", "whether excitation appears (or disappears) at the instant"),
        "time": ("s", "end of the window, of the last one where several are represented by their worst"),
        f"{name}_level_window": ("s", "length of the window"),
        f"{name}_instant": ("s", "end of the first window in which the condition holds, or no longer holds"),
        f"{name}_factor": ("1/A or s/1", "factor of each column"),
    }
    for variable, (unit, meaning) in notes.items():
        data[variable].attrs.update(units=unit, long_name=meaning)
    data[f"{name}_holds"].attrs.update(windows=track.windows, holding=track.holding, undefined=track.undefined,
                                       lowest=track.lowest if math.isfinite(track.lowest) else math.nan,
                                       transitions=track.transitions)
    return data


def save(results: dict[str, xr.Dataset], path: str) -> list[str]:
    """Write results as NetCDF, one file an observer: ``path``, or ``stem-OBSERVER.nc`` for several. Returns the names."""
    from imo_analysis.files import replacing
    from imo_analysis.simulation.runfile import write_netcdf

    place = Path(path)
    written = []
    for name, result in results.items():
        target = place if len(results) == 1 else place.with_name(f"{place.stem}-{name}{place.suffix}")
        flags = {v: result[v].astype("int8").assign_attrs(result[v].attrs) for v in result if result[v].dtype == bool}
        with replacing(target) as beside:
            write_netcdf(result.assign(flags), beside)  # NetCDF has no truth values
        written.append(str(target))
    return written
