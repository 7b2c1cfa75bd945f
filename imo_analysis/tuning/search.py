"""The search for gains: the least noise on the speed estimate that a wish leaves, and the front between noise and times.

Differential evolution (scipy) over the logarithms of the loops of `imo_analysis.tuning.loops`, judged on the exact
linearisation at a few operating points, with right parameters and in the corners of the uncertainty. What is judged counts
below its limit as good; the sum of what exceeds it, on a logarithmic scale, comes first, and then the noise. Gains found so
are judged over the whole range and in every corner of the uncertainty. What they exceed a limit by there is taken off that
limit and the search is made again, three times at most.

Observers whose speed law treats both directions alike are searched forward only; the whole judgement is over both.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.tuning.loops import Loops, gains_of, least_current
from imo_analysis.tuning.response import BAND, response
from imo_analysis.tuning.rule import alpha_gains, rule_gains, rule_loops
from imo_analysis.tuning.wish import QUANTITIES, Wish, excess, judge, judged, missed

Array = NDArray[np.float64]
_TIMES = np.geomspace(5e-4, 8.0, 150)  # s
_POPULATION, _FIRST, _NEXT = 28, 36, 18  # members, generations of the first search and of those that start from its results
_ROUNDS = 3
_BAND = 0.9 * BAND
_MARGIN = 0.97  # of every limit: what the few points and times of the search may miss
_HARD = ((0.0, -1.0), (0.0, 1.0), (1.0, -1.0))  # where errors tell most: from lowest speed to highest; slip
_NEAR = 0.4  # how far from the rule of thumb the first members lie, in logarithms
_STEP = 1.1  # a limit is brought nearer by this factor at most in one round
_FAIL = 100.0  # above every logarithm of a noise


@dataclass(frozen=True)
class Found:
    """Gains and what they are judged to give over the whole range.

    Attributes
    ----------
    gains : dict of str to float
        Every gain of the observer.
    values : dict of str to float
        By name of `wish.QUANTITIES`, worst over speeds, loads, directions and corners.
    limits : dict of str to float
        What was wished.
    role : str
        ``before``, ``rule``, ``wish``, or what of the front it belongs to: ``settling``, ``recovery``.
    """

    gains: dict[str, float]
    values: dict[str, float]
    limits: dict[str, float]
    role: str

    @property
    def missed(self) -> list[str]:
        """Names of what misses its limit."""
        return missed(self.limits, self.values)


@dataclass
class Search:
    """The search for one observer.

    Attributes
    ----------
    wish : Wish
        What for.
    kind : str
        Of observer.
    signs : tuple of float
        Directions that the gains are judged in.
    seed : int
        Of the search.
    kept : dict of str to float
        Gains that are not searched for and stay what they are: alpha_l, delta, eta, S_0, where the observer has them.
    tick : callable
        Called once a generation.
    rising : bool
        Look only where the feedback of the flux errors grows with the speed: kappa or k_2 without k_3.
    """

    wish: Wish
    kind: str
    signs: tuple[float, ...]
    seed: int
    kept: dict[str, float] = field(default_factory=dict)
    tick: Callable[[], None] = lambda: None
    rising: bool = False
    _seen: list[tuple[Array, dict[str, Array]]] = field(default_factory=list)

    # Gains -------------------------------------------------------------------------------------------------------------
    @property
    def bounds(self) -> Array:
        """Of the logarithms of omega_n, a / omega_n, and where the observer has them D_0 / a^2 (X / a), D_1 / a."""
        fastest = self.wish.limits["fastest"]
        rows = [(fastest / 200, fastest), (0.3, 12.0)]
        if self.kind == "baseline":
            rows += [(1e-2, 2.0)]
        elif self.kind != "baseline_scheduled":
            rows += [(1e-5, 1e-4), (0.03, 4.0)] if self.rising else [(1e-5, 1.0), (1e-5, 4.0)]
        return np.log(np.array(rows))

    def gains(self, x: Array) -> dict[str, Any]:
        """Gains of points ``x`` of shape (variables, ...)."""
        machine, wish = self.wish.machine, self.wish
        omega_n = np.exp(x[0])
        current = np.maximum(omega_n * np.exp(x[1]), least_current(machine, self.kind))
        constant = rising = np.zeros_like(current)
        if self.kind == "baseline":
            constant = machine.alpha * current * np.exp(x[2])
        elif len(x) > 2:
            constant, rising = current**2 * np.exp(x[2]), current * np.exp(x[3])
        found = gains_of(machine, self.kind, wish.flux, Loops(omega_n, current, constant, rising), wish.middle)
        more = alpha_gains(machine, self.kind, wish.flux, found.get("K_p", 0.0), wish.times)
        return found | more | {name: value for name, value in self.kept.items() if name in more and name != "g"}

    def rule(self) -> Found:
        """What the rule of thumb gives, judged."""
        gains = rule_gains(self.wish.machine, self.kind, self.wish.flux, self.wish.times)
        return self.judged(gains | {k: v for k, v in self.kept.items() if k in gains and k != "g"}, self.wish.limits, "rule")

    def judged(self, gains: dict[str, float], limits: dict[str, float], role: str) -> Found:
        """Gains judged over the whole range."""
        return Found(gains, judge(self.wish, self.kind, gains, self.signs), limits, role)

    # Search ------------------------------------------------------------------------------------------------------------
    def best(self, limits: dict[str, float], role: str, rounds: int = _ROUNDS) -> Found:
        """Gains with the least noise within limits; where no gains are, those that come nearest."""
        found: Found | None = None
        nearer = dict(limits)
        for _ in range(rounds):
            x = self._evolved(nearer)
            gains = {name: float(value) for name, value in self.gains(x).items()}
            tried = self.judged(gains, limits, role)
            if found is None or self.rank(tried) < self.rank(found):
                found = tried
            over = {name: tried.values[name] / limits[name] for name in tried.missed if name != "bias"}
            if not over or not all(map(math.isfinite, over.values())):
                break
            nearer |= {name: nearer[name] / min(share, _STEP) for name, share in over.items()}
        assert found is not None
        return found

    @staticmethod
    def rank(found: Found) -> tuple[float, float]:
        """How gains are compared: by what they miss, then by their noise; less is better."""
        return float(excess(found.limits, found.values)) if found.missed else 0.0, found.values["noise"]

    def _evolved(self, limits: dict[str, float]) -> Array:
        from scipy.optimize import differential_evolution

        bounds = self.bounds
        start, generations = self._start(limits)

        def score(x: Array) -> Array:
            values = self._values(x)
            self._seen.append((x.copy(), values))
            return self._score(limits, values)

        with np.errstate(all="ignore"):
            result = differential_evolution(
                score, bounds, vectorized=True, updating="deferred", init=start, maxiter=generations, tol=0.0, polish=False,
                rng=np.random.default_rng(self.seed), callback=lambda *_, **__: self.tick())
        return np.asarray(result.x)

    def _start(self, limits: dict[str, float]) -> tuple[Array, int]:
        """First members, shape (members, variables): the rule of thumb, some near it, a Sobol sample; later the best seen."""
        from scipy.stats import qmc

        bounds = self.bounds
        fresh = bounds[:, 0] + qmc.Sobol(len(bounds), rng=np.random.default_rng(self.seed)).random(32) * np.ptp(bounds, axis=1)
        if not self._seen:
            loops = rule_loops(self.wish.machine, self.kind, self.wish.times)
            rule = np.array([loops.omega_n, loops.current / loops.omega_n, loops.constant / loops.current**2,
                             loops.rising / loops.current])[: len(bounds)]
            if self.kind == "baseline":
                rule[2] = loops.constant / self.wish.machine.alpha / loops.current
            rule = np.log(np.maximum(rule, 1e-12))
            near = rule + _NEAR * np.random.default_rng(self.seed).uniform(-1, 1, (12, len(bounds)))
            near[0] = rule
            return np.vstack([np.clip(near, bounds[:, 0], bounds[:, 1]), fresh[: _POPULATION - len(near)]]), _FIRST
        everything = np.concatenate([x for x, _ in self._seen], axis=1)
        values = {name: np.concatenate([one[name] for _, one in self._seen]) for name in self._seen[0][1]}
        order = np.argsort(self._score(limits, values), kind="stable")
        members = everything[:, order[: 3 * _POPULATION : 4]].T
        return np.vstack([members, fresh])[:_POPULATION], _NEXT

    def _score(self, limits: dict[str, float], values: dict[str, Array]) -> Array:
        over = np.asarray(excess({name: _MARGIN * limit for name, limit in limits.items()}, values))
        return np.where(over > 0, _FAIL + 10 * over, np.log(np.minimum(values["noise"], 1e9)))

    def _values(self, x: Array) -> dict[str, Array]:
        """What is judged, at the few points of the search, each of shape (members,)."""
        gains: Any = {name: np.broadcast_to(np.asarray(value, dtype=float), x.shape[1:])[:, None]
                      for name, value in self.gains(x).items()}
        wish = self.wish
        parts = [judged(wish, response(wish.machine, self.kind, gains, wish.points(3, 3, (1.0,)), None, _TIMES, _BAND))]
        if corners := wish.corners():
            count = len(_HARD) * len(corners)
            speeds, slips = (np.resize(one, count) for one in zip(*_HARD, strict=True))
            point = OperatingPoint(np.where(speeds > 0, wish.high, wish.low), wish.flux, slips * wish.slip)
            errors = {name: np.repeat([corner[name] for corner in corners], len(_HARD)) for name in wish.uncertainty}
            parts.append(judged(wish, response(wish.machine, self.kind, gains, point, errors, _TIMES, _BAND, quick=True)))
        return {name: np.max([part[name] for part in parts], axis=0) for name in QUANTITIES}


def front(search: Search, wished: Found, shares: tuple[float, ...] = (0.5, 2.0, 4.0)) -> list[Found]:
    """The front about a wish: the least noise for other times of the speed estimate (settling and lag together), and for other
    recovery times, all else as wished.
    """
    found = []
    for role in ("settling", "recovery"):
        for share in shares:
            limits = {name: limit for name, limit in wished.limits.items() if name != "noise"}
            for name in ("settling", "lag") if role == "settling" else ("recovery",):
                limits[name] = wished.limits[name] * share
            # where the wish itself is out of reach, one look at what lies about it is enough
            found.append(search.best(limits, role, 1 if wished.missed else _ROUNDS))
    return found
