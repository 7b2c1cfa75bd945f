"""The first pass over a record: is every sample there, at the right time, and is there anything in it?

It keeps the stretch in which the most is going on, from which gains and plausibility are judged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.replay.logs import BLOCK, Log, Samples, too_short

UNEVEN = 0.05  # share of the sampling period by which a step may differ from it
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
    gaps : int
        Steps of time that are not one sampling period (0 unless they are to be bridged).
    peak_speed : float
        Largest measured speed in size, electrical rad/s; NaN without one.
    head, stretch : Samples
        The first block, and the block with the most apparent power.
    """

    rows: int
    start: float
    sample_time: float
    gaps: int
    peak_speed: float
    head: Samples
    stretch: Samples


def survey(log: Log, bridge: bool = False) -> Survey:
    """Read the record once.

    Parameters
    ----------
    log : Log
        The record.
    bridge : bool
        Let steps of time pass that are longer than a sampling period; they are integrated over their length.

    Raises
    ------
    InputError
        If a sample is broken, missing or out of step (with its line), the rate is impossible, or a signal is zero throughout.
    """
    rows = gaps = 0
    period = last = start = math.nan
    speed = most = -1.0
    head: Samples | None = None
    stretch: Samples | None = None
    current = voltage = zero = 0.0
    for block in log.blocks(BLOCK):
        if rows == 0:
            head, start = block, float(block.time[0])
            period = _period(log, block)
        time = block.time if rows == 0 else np.concatenate([[last], block.time])
        gaps += _check_steps(log, time, period, block.first + len(block) - len(time) + 1, bridge)
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
            most, stretch = power, block
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
    if not gaps and log.rate is None:
        period = (last - start) / (rows - 1)
    return Survey(rows, start, period, gaps, speed if speed >= 0 else math.nan, head, stretch)


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


def _check_steps(log: Log, time: np.ndarray, period: float, first: int, bridge: bool) -> int:
    """Number of steps that are to be bridged; ``first`` is the row of ``time[1]``."""
    if log.rate is not None:
        return 0
    steps = np.diff(time)
    backwards = np.flatnonzero(steps <= 0)
    odd = np.flatnonzero(~(np.abs(steps - period) <= UNEVEN * period))
    if not len(odd) and not len(backwards):
        return 0
    if len(backwards) or not bridge:
        at = int(backwards[0] if len(backwards) else odd[0])
        where = f"{log.place(first + at)} (t = {time[at + 1]:.9g} s)"
        if steps[at] <= 0:
            turn = "repeats" if steps[at] == 0 else f"goes back by {-steps[at]:.4g} s"
            raise InputError(f"{where}: time {turn}; it must increase. If time was rounded, give --rate in Hz instead")
        missing = round(steps[at] / period) - 1
        what = f"{missing} sample(s) missing" if missing > 0 else "samples are not evenly spaced"
        raise InputError(
            f"{where}: a step of {steps[at]:.4g} s in a record with {period:.4g} s between samples: {what}; cut or resample, "
            "or say --gaps bridge to integrate over the gap in a straight line"
        )
    return len(odd)


def steps_of(time: np.ndarray, period: float) -> np.ndarray:
    """Lengths of the steps to integrate over: the sampling period itself, but for gaps."""
    steps = np.diff(time)
    return np.where(np.abs(steps - period) <= UNEVEN * period, period, steps)
