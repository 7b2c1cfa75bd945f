"""The first pass over a record: is every sample there, at the right time, and is there anything in it?

It keeps the stretch in which the most is going on, from which gains and plausibility are judged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.replay.logs import BLOCK, Log, Samples, too_short

UNEVEN = 0.05  # share of the sampling period by which a step may differ from it
ALONE = 0.2  # s; a part without gaps that lasts as long tells frequency and flux alone
_SHORTEST, _LONGEST = 5e-8, 5e-3
_ZERO_SEQUENCE = 0.2


@dataclass(frozen=True)
class Survey:
    """What the first pass found.

    Attributes
    ----------
    rows : int
        Samples in the record.
    start, sample_time : float
        Time of the first sample and sampling period, in s.
    first : ndarray of int
        First samples of the stretches between gaps, which are steps of time that are not one sampling period; 0 alone unless
        gaps are to be bridged.
    since : ndarray
        Times of these samples since ``start``, in s.
    steps : ndarray
        Lengths of the gaps in s, from sample to sample.
    peak_speed : float
        Largest measured speed in size, electrical rad/s; NaN without one.
    head, stretch : Samples
        The first block, and the block with the most apparent power; of either a part without gaps, or its parts joined.
    """

    rows: int
    start: float
    sample_time: float
    first: np.ndarray
    since: np.ndarray
    steps: np.ndarray
    peak_speed: float
    head: Samples
    stretch: Samples

    @property
    def gaps(self) -> int:
        """How many."""
        return len(self.first) - 1

    @property
    def most(self) -> int:
        """Samples in the longest stretch between gaps."""
        return int(np.diff(np.append(self.first, self.rows)).max())

    def time_of(self, row: Any) -> Any:
        """Time of a sample since ``start``, in s, by its row (of any shape); that of the row after the last, too."""
        stretch = np.searchsorted(self.first, row, side="right") - 1
        return self.since[stretch] + (row - self.first[stretch]) * self.sample_time


def survey(log: Log, bridge: bool = False) -> Survey:
    """Read the record once.

    Parameters
    ----------
    log : Log
        The record.
    bridge : bool
        Let steps of time pass that are longer than a sampling period.

    Raises
    ------
    InputError
        If a sample is broken, missing or out of step (with its line), the rate is impossible, or a signal is zero throughout.
    """
    rows = least = 0
    period = last = start = math.nan
    first, since, gaps = [np.zeros(1, dtype=np.int64)], [np.zeros(1)], [np.empty(0)]
    speed = most = -1.0
    head: Samples | None = None
    stretch: Samples | None = None
    current = voltage = zero = 0.0
    for block in log.blocks(BLOCK):
        if rows == 0:
            start, period = float(block.time[0]), _period(log, block)
            least = round(ALONE / period) if period > 0 else 0
        time = block.time if rows == 0 else np.concatenate([[last], block.time])
        steps, before = np.diff(time), block.first + len(block) - len(time) + 1
        odd = _check_steps(log, time, steps, period, before, bridge)
        if len(odd):
            first.append(before + odd)
            since.append(time[odd + 1] - start)
            gaps.append(steps[odd])
        cuts = before + odd - block.first
        cuts = cuts[cuts > 0]
        if rows == 0:
            head = block.part(slice(0, int(cuts[0]))) if len(cuts) and cuts[0] >= least else _joined(block, cuts)
        last = float(block.time[-1])
        rows += len(block)
        current += float((block.i_ds**2 + block.i_qs**2).sum())
        voltage += float((block.u_ds**2 + block.u_qs**2).sum())
        if block.i_zero is not None:
            zero += float((block.i_zero**2).sum())
        if block.omega is not None:
            speed = max(speed, float(np.abs(block.omega).max()))
        power = float(np.hypot(block.u_ds, block.u_qs) @ np.hypot(block.i_ds, block.i_qs))
        if power > most:
            most, stretch = power, _even(block, cuts, least)
    assert head is not None and stretch is not None
    for what, size in (("voltage", voltage), ("current", current)):
        if size == 0:
            raise InputError(f"{log.path}: the {what} is zero in every sample; nothing can be estimated from it")
        if not math.isfinite(size):
            raise InputError(f"{log.path}: the {what} is too large to square; is its column the right one?")
    sequence = math.sqrt(zero / (current / 2))  # zero, too, where not all three currents were recorded
    if sequence > _ZERO_SEQUENCE:
        raise InputError(
            f"{log.path}: the three phase currents do not add up to zero (RMS of the sum: {sequence:.2g} of a phase's); "
            "one is reversed, scaled otherwise or another column. To use two of them: --column i_c=none"
        )
    missing = np.concatenate(gaps)
    if log.rate is None and rows > 1 + len(missing):
        period = (last - start - float(missing.sum())) / (rows - 1 - len(missing))
    return Survey(rows, start, period, np.concatenate(first), np.concatenate(since), missing, speed if speed >= 0 else math.nan,
                  head, stretch)


def _even(block: Samples, cuts: np.ndarray, least: int) -> Samples:
    """The longest of the parts between ``cuts`` of a block, or all of them joined if that has less than ``least`` samples."""
    edges = np.concatenate([[0], cuts, [len(block)]])
    longest = int(np.argmax(np.diff(edges)))
    begin, end = int(edges[longest]), int(edges[longest + 1])
    return block.part(slice(begin, end)) if end - begin >= least else _joined(block, cuts)


def _joined(block: Samples, cuts: np.ndarray) -> Samples:
    """The parts between ``cuts`` as one without gaps: the record as it is in a steady state.

    Behind each gap everything is turned back as far as the current has turned over it, and the first sample, which has become
    the last one before the gap, is left out.
    """
    if not len(cuts):
        return block
    i, u = block.i_ds + 1j * block.i_qs, block.u_ds + 1j * block.u_qs
    over = i[cuts - 1] * i[cuts].conj()
    turn = np.ones(len(block), dtype=complex)
    turn[cuts] = np.where(over == 0, 1.0, over) / np.where(over == 0, 1.0, np.abs(over))
    turn = np.cumprod(turn)
    i, u = i * turn, u * turn
    joined = replace(block, i_ds=i.real, i_qs=i.imag, u_ds=u.real, u_qs=u.imag)
    return joined.part(np.delete(np.arange(len(block)), cuts))


def _period(log: Log, block: Samples) -> float:
    if log.rate is not None:
        period = 1 / log.rate
    elif len(block) < 2:
        raise InputError(too_short(log.path, 1))
    else:
        period = float(np.median(np.diff(block.time)))
    if period > 0 and not _SHORTEST <= period <= _LONGEST:
        unit = "" if log.rate is not None else " Is the unit of time right? Say --unit time=ms (or us)."
        raise InputError(
            f"{log.path}: a sample every {period:.4g} s; replay takes {_SHORTEST:g} s to {_LONGEST:g} s between samples "
            f"(200 Hz to 20 MHz).{unit}"
        )
    return period


def _check_steps(log: Log, time: np.ndarray, steps: np.ndarray, period: float, first: int, bridge: bool) -> np.ndarray:
    """Which of the steps of ``time`` are to be bridged; ``first`` is the row of ``time[1]``."""
    if log.rate is not None:
        return np.empty(0, dtype=np.int64)
    backwards = np.flatnonzero(steps <= 0)
    odd = np.flatnonzero(~(np.abs(steps - period) <= UNEVEN * period))
    if not len(odd) and not len(backwards):
        return odd
    if len(backwards) or not bridge:
        at = int(backwards[0] if len(backwards) else odd[0])
        where = f"{log.place(first + at)} (t = {time[at + 1]:.9g} s)"
        if steps[at] <= 0:
            turn = "repeats" if steps[at] == 0 else f"goes back by {-steps[at]:.4g} s"
            raise InputError(f"{where}: time {turn}; it must increase. Take out a line that is there twice; "
                             "if time was rounded, give --rate in Hz instead")
        missing = round(steps[at] / period) - 1
        what = f"{missing} sample(s) missing" if missing > 0 else "samples are not evenly spaced"
        raise InputError(
            f"{where}: a step of {steps[at]:.4g} s in a record with {period:.4g} s between samples: {what}; cut or resample, "
            "or say --gaps bridge to go on behind the gap"
        )
    return odd


def steps_of(time: np.ndarray, period: float) -> np.ndarray:
    """Lengths of the steps to integrate over: the sampling period itself, but for gaps."""
    steps = np.diff(time)
    return np.where(np.abs(steps - period) <= UNEVEN * period, period, steps)
