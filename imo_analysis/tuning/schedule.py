"""Whether gains that change with the speed would pay: the best constant ones against the best for one speed alone.

The same search under the same wish, but for the range of speeds, which shrinks to one speed: what it finds there is as good as
any schedule over the speed can be at that speed. What changing gains do on the way is not in it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from imo_analysis.tuning.search import Found, Search
from imo_analysis.tuning.wish import Wish, judge, missed

PAYS = 0.25  # less noise at one speed at least: the search itself leaves up to 0.15


@dataclass(frozen=True)
class Alone:
    """One speed.

    Attributes
    ----------
    omega : float
        In rad/s.
    constant : float
        Noise of the best constant gains there in rad/s.
    noise, settling : float
        Of the best gains for that speed alone, in rad/s and s.
    gains : dict of str to float
    missed : list of str
        What of the wish no gains found meet even at that speed alone.
    """

    omega: float
    constant: float
    noise: float
    settling: float
    gains: dict[str, float]
    missed: list[str]

    @property
    def saved(self) -> float:
        """By what share the noise is lower than with constant gains."""
        return 1 - self.noise / self.constant


def alone(
    wish: Wish, kind: str, signs: tuple[float, ...], seed: int, kept: dict[str, float], constant: Found,
    tick: Callable[[], None] = lambda: None,
) -> list[Alone]:
    """The lowest, the middle and the highest speed of the range.

    Parameters
    ----------
    wish, kind, signs, seed, kept, tick
        As for `imo_analysis.tuning.search.Search`.
    constant : Found
        The best constant gains.
    """
    found = []
    limits = {name: limit for name, limit in wish.limits.items() if name != "noise"}
    for omega in (wish.low, wish.middle, wish.high):
        there = replace(wish, low=omega, high=omega, times=replace(wish.times, omega_min=omega, omega_max=omega))
        search = Search(there, kind, signs, seed, kept, tick)
        same = Found(constant.gains, judge(there, kind, constant.gains, signs), limits, "schedule")
        best = min((same, search.best(limits, "schedule", 1), replace(search.rule(), limits=limits)), key=Search.rank)
        found.append(Alone(omega, same.values["noise"], best.values["noise"], best.values["settling"], best.gains,
                           missed(limits, best.values)))
    return found


def pays(found: list[Alone], wanted: list[str]) -> bool:
    """Whether a schedule would do better than constant gains that miss ``wanted``."""
    if any(one.missed for one in found):
        return False
    return bool(wanted) or max(one.saved for one in found) >= PAYS


def sentence(found: list[Alone], wanted: list[str]) -> str:
    """Whether a schedule pays, with its numbers.

    Parameters
    ----------
    found : list of Alone
        From `alone`.
    wanted : list of str
        What of the wish the constant gains miss.
    """
    most = max(found, key=lambda one: one.saved)
    if any(one.missed for one in found):
        where = ", ".join(f"{one.omega:.3g}" for one in found if one.missed)
        said = f"a schedule over speed does not meet the wish either: gains for {where} rad/s alone miss it"
    elif wanted:
        said = "a schedule over speed pays: gains for one speed alone meet the wish that constant gains miss"
    elif most.saved >= PAYS:
        said = f"a schedule over speed pays: up to {most.saved:.0%} less noise, at {most.omega:.3g} rad/s"
    else:
        said = f"a schedule over speed does not pay: at most {max(most.saved, 0.0):.0%} less noise"
    alone, same = (" / ".join(f"{getattr(one, name):.3g}" for one in found) for name in ("noise", "constant"))
    return (f"{said}; least noise at {' / '.join(f'{one.omega:.3g}' for one in found)} rad/s of gains for that speed alone: "
            f"{alone} rad/s, of the quietest constant gains: {same} rad/s")
