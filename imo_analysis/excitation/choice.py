"""Which of the modulations that were found: the cheapest within the limits that leaves no part of the error standing.

`design.search` sizes by the averaged rate. Where a sideband nearly stands a part of the error settles far more slowly, so that
each candidate is judged by Floquet's multipliers before it is taken, the cheapest first.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.excitation.design import (
    DEEPEST,
    FREQUENCIES,
    LIMITS,
    Design,
    Limit,
    Plant,
    Wanted,
    points_looked_at,
    search,
    time_needed,
    torques_looked_at,
    within,
)
from imo_analysis.excitation.settling import floquet


@dataclass(frozen=True)
class Chosen:
    """A design that is taken.

    Attributes
    ----------
    design : Design
    slowest : Slowest
        Where its error settles the slowest, by Floquet's multipliers.
    passed : int
        How many cheaper ones within the limits leave too much of the error.
    """

    design: Design
    slowest: Slowest
    passed: int


@dataclass(frozen=True)
class Slowest:
    """How the error of alpha_hat settles where it settles the slowest.

    Attributes
    ----------
    rate : float
        Decay of the slowest error in which alpha_hat moves, 1/s.
    left : float
        Largest share that is left of an error of alpha_hat after the time that is wanted.
    where : tuple of 2
        Speed (rad/s) and torque (N m) at which that is.
    """

    rate: float
    left: float
    where: tuple[float, float]


def slowest(plant: Plant, found: Design, wanted: Wanted) -> Slowest:
    """Floquet's multipliers at every point that a design was made for.

    Where a sideband nearly stands, a part of the error settles far more slowly than on average. Where the flux itself stands an
    offset of its copies never settles; an error of alpha does, but for its share in that.
    """
    shape = plant.shape(found.waveform, found.frequency)
    slips, speeds = points_looked_at(plant, wanted, found.frequency, shape)
    omega, slip = (one.ravel() for one in np.meshgrid(speeds, slips, indexing="ij"))
    rates, left = floquet(plant.machine, plant.gains, plant.flux, found.depth, found.frequency, omega, slip, shape, plant.kind,
                          max(wanted.time - found.delay, 0.0))
    at = int(np.argmax(left))
    return Slowest(float(rates[at]), float(left[at]), (float(omega[at]), torques_looked_at(wanted)[at % len(slips)]))


def settling_ones(plant: Plant, candidates: Iterable[Design], wanted: Wanted) -> Iterator[Chosen]:
    """Of candidates in order, those of whose error little enough is left after the time, wherever it settles the slowest."""
    passed = 0
    for one in candidates:
        found = slowest(plant, one, wanted)
        if wanted.start * found.left + one.bias <= wanted.alpha:
            yield Chosen(one, found, passed)
        else:
            passed += 1


def by_loss(found: Iterable[Design], wanted: Wanted) -> list[Design]:
    """Those within the limits, the cheapest first."""
    return sorted((one for one in found if within(one, wanted)), key=lambda one: one.loss)


def design(plant: Plant, wanted: Wanted, *, frequencies: Sequence[float] = FREQUENCIES) -> tuple[Chosen, list[Design]]:
    """The modulation with the least added loss that reaches the accuracy within the limits.

    Parameters
    ----------
    plant : Plant
        With an observer of one of `settling.KINDS`. Its drive makes every waveform of `simulation.waveforms` possible, as its
        loops let the flux follow; without a drive the flux itself is a cosine.
    wanted : Wanted
        Accuracy, time, range and limits.
    frequencies : sequence of float
        Tried, in rad/s, and beyond as `search` says.

    Returns
    -------
    Chosen
        The one with the least loss of those that leave no part of the error too slow.
    list of Design
        The smallest depth that reaches the accuracy on average for each waveform and frequency where one does.

    Raises
    ------
    InputError
        If nothing reaches the accuracy within the limits; it says which limit, and what would be possible.
    """
    found, deepest = search(plant, wanted, frequencies)
    return choose(plant, found, deepest, wanted), found


def choose(plant: Plant, found: Sequence[Design], deepest: Sequence[Design], wanted: Wanted) -> Chosen:
    """The one of least loss within the limits whose error settles in all its parts; what `design` raises if there is none."""
    allowed = by_loss(found, wanted)
    for one in settling_ones(plant, allowed, wanted):
        return one
    asked = f"alpha within {wanted.alpha:g} /s and omega within {wanted.omega:g} rad/s in {wanted.time:g} s"
    raise InputError(f"no flux modulation reaches {asked}: {_what_is_possible(plant, found, deepest, wanted)}")


def _what_is_possible(plant: Plant, found: Sequence[Design], deepest: Sequence[Design], wanted: Wanted) -> str:
    """Which limit is in the way, its value, and the least that would do."""
    if not found:
        time = min((time_needed(one, wanted) for one in deepest), default=math.inf)
        if math.isfinite(time):
            return (f"the deepest ones, of {100 * DEEPEST:g} % or with a reference above 0, need {time:.3g} s; allow that, or "
                    "less accuracy")
        return "not even in a long time, for noise leaves alpha_hat further off; ask for less accuracy, or use a quiet observer"
    for limit in LIMITS:
        free: dict[str, Any] = {limit.wanted: math.inf}
        least = _least(plant, found, limit, replace(wanted, **free))
        if least is not None:
            among = " within the other limits" if sum(math.isfinite(one.value(wanted)) for one in LIMITS) > 1 else ""
            return (f"the limit of {limit.name} is {limit.said(limit.value(wanted))}, and{among} the least that does it needs "
                    f"{limit.said(least)}; raise it, or ask for less accuracy or more time")
    none: dict[str, Any] = {limit.wanted: math.inf for limit in LIMITS}
    free_of_all = replace(wanted, **none)
    needs = [(limit, _least(plant, found, limit, free_of_all)) for limit in LIMITS if math.isfinite(limit.value(wanted))]
    if any(least is None for _, least in needs) or not needs:
        return ("each leaves a part of the error standing at some speed, where a sideband of the modulation or the flux itself "
                "comes to zero frequency; narrow the range (--speeds), or ask for less accuracy or more time")
    return ("no limit stands in the way alone; each for itself, " + ", ".join(
        f"{limit.name} needs {limit.said(least)}" for limit, least in needs if least is not None)
        + "; raise several, or ask for less accuracy or more time")


def _least(plant: Plant, found: Sequence[Design], limit: Limit, wanted: Wanted) -> float | None:
    """The least that a design within limits uses of another one; None where no design is within them."""
    allowed = sorted((one for one in found if within(one, wanted)), key=limit.used)
    first = next(settling_ones(plant, allowed, wanted), None)
    return None if first is None else limit.used(first.design)


def cheapest_by_waveform(plant: Plant, found: Sequence[Design], wanted: Wanted) -> list[Design]:
    """The design that `choose` would take of each waveform, the cheapest waveform first."""
    best = []
    for waveform in dict.fromkeys(one.waveform for one in found):
        candidates = by_loss([one for one in found if one.waveform == waveform], wanted)
        best += [one.design for one in (next(settling_ones(plant, candidates, wanted), None),) if one]
    return sorted(best, key=lambda one: one.loss)


def passed_over(standing: int, failed: int) -> str:
    """Why cheaper ones were not taken."""
    parts = [f"{standing} cheaper {'one leaves' if standing == 1 else 'ones leave'} a part of the error standing, where a "
             "sideband comes near zero frequency"] if standing else []
    parts += [f"{failed} cheaper {'one misses' if failed == 1 else 'ones miss'} in closed loop"] if failed else []
    return "; ".join(parts)
