"""What is wished, resolved for one study: operating points, limits, noise; and how far gains are from it."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.steady_state import slip_of_torque
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.study import Study
from imo_analysis.study_tuning import Tuning
from imo_analysis.tuning.response import Response, response
from imo_analysis.tuning.rule import DAMPING, Times

Array = NDArray[np.float64]
SAMPLING = 0.5  # rad a sample: the fastest mode stays below, so that a sampled observer still is what the pencil says
_RESERVE = 0.75  # of the wished times: what the rule of thumb, which knows of no errors and no load, is asked for
# what is judged, in the order of `Judged`: unit and meaning
QUANTITIES = {
    "settling": ("s", "time until the speed estimate is within 2 % of a step of the speed"),
    "recovery": ("s", "four time constants of the slowest error"),
    "overshoot": ("1", "overshoot of the speed estimate as a share of the step"),
    "noise": ("rad/s", "standard deviation of the speed estimate"),
    "bias": ("rad/s", "largest error of the speed at rest within the uncertainty"),
    "lag": ("s", "how far the estimate stays behind an even acceleration, for 1 rad/s^2"),
    "fastest": ("rad/s", "largest magnitude of a mode"),
}


@dataclass(frozen=True)
class Wish:
    """All that a search needs to know of a study.

    Attributes
    ----------
    machine : InductionMachine
        As the observers believe it to be.
    flux, slip : float
        Magnitude of the rotor flux in Wb; largest slip in rad/s.
    low, high : float
        The range of abs(speed) in rad/s.
    signs : tuple of float
        Directions of rotation.
    limits : dict of str to float
        Largest values by name of `QUANTITIES`.
    sample_time, current_noise : float
        In s; in A.
    uncertainty : dict of str to float
        Relative, either sign.
    times : Times
        What the rule of thumb is asked for: the wish with a reserve.
    """

    machine: InductionMachine
    flux: float
    slip: float
    low: float
    high: float
    signs: tuple[float, ...]
    limits: dict[str, float]
    sample_time: float
    current_noise: float
    uncertainty: dict[str, float]
    times: Times

    @classmethod
    def of(cls, study: Study) -> Wish:
        """From a study and its table ``[tuning]``.

        Raises
        ------
        InputError
            If the slip of the torque reaches the lowest speed: the stator frequency then is zero.
        """
        table, machine, flux = study.tuning, study.machine, study.drive.flux
        torque = study.largest_torque
        slip = float(slip_of_torque(torque, flux, machine.n_p, machine.L_r, machine.alpha))
        low, high = table.omega
        if slip >= low:
            raise InputError(
                f"tuning.torque = {torque:.4g} N m needs a slip of {slip:.4g} rad/s, which must be below tuning.omega[0] = "
                f"{low:g} rad/s: braking there the stator frequency is zero and nothing determines the speed; raise the "
                "speed or lower the torque")
        overshoot = math.exp(-math.pi * table.damping / math.sqrt(1 - table.damping**2))
        limits = {"settling": table.settling_time, "recovery": table.recovery_time, "overshoot": overshoot,
                  "fastest": SAMPLING / study.simulation.sample_time}
        more = (("noise", table.speed_noise), ("bias", table.speed_error), ("lag", table.lag))
        limits |= {key: value for key, value in more if value is not None}
        times = times_of(table, study.drive.speed_bandwidth, study.simulation.sample_time)
        return cls(machine, flux, slip, low, high, (1.0, -1.0) if table.directions == "both" else (1.0,), limits,
                   study.simulation.sample_time, study.noise, {k: v for k, v in table.uncertainty.items() if v > 0}, times)

    @property
    def middle(self) -> float:
        """The speed between the ends, in rad/s."""
        return math.sqrt(self.low * self.high)

    @property
    def noise_scale(self) -> float:
        """From noise of density 1 A^2 s to that of the sampled currents."""
        return self.current_noise * math.sqrt(self.sample_time)

    def points(self, speeds: int, slips: int, signs: tuple[float, ...]) -> OperatingPoint:
        """A grid of operating points over the range."""
        omega = np.geomspace(self.low, self.high, speeds if self.high > self.low else 1)
        slip = np.linspace(-self.slip, self.slip, slips) if self.slip > 0 else np.zeros(1)
        both = np.array(list(itertools.product(signs, omega, slip)))
        return OperatingPoint(both[:, 0] * both[:, 1], self.flux, both[:, 2])

    def corners(self) -> list[dict[str, float]]:
        """Every combination of the largest errors."""
        names = list(self.uncertainty)
        signs = itertools.product((-1.0, 1.0), repeat=len(names)) if names else []
        return [{name: sign * self.uncertainty[name] for name, sign in zip(names, one, strict=True)} for one in signs]


def times_of(table: Tuning, speed_bandwidth: float, sample_time: float) -> Times:
    """What the rule of thumb is asked for where this is wished: less time, since it knows of no errors and no load.

    Parameters
    ----------
    table : Tuning
        The wish.
    speed_bandwidth : float
        Of the drive's speed loop in rad/s.
    sample_time : float
        In s.
    """
    return Times(table.settling_time, _RESERVE * table.recovery_time, *table.omega, max(table.damping, DAMPING),
                 _RESERVE * table.lag, speed_bandwidth, _RESERVE * SAMPLING / sample_time)


def judged(wish: Wish, found: Response) -> dict[str, Array]:
    """The worst over the last axis, by name of `QUANTITIES`; infinity where it is unstable or there is no state at rest."""
    size = np.abs(found.bias)
    return {"settling": found.settling.max(axis=-1), "recovery": found.recovery.max(axis=-1),
            "overshoot": found.overshoot.max(axis=-1), "noise": found.noise.max(axis=-1) * wish.noise_scale,
            "bias": np.where(np.isnan(size), np.inf, size).max(axis=-1),
            "lag": np.abs(found.lag).max(axis=-1), "fastest": found.fastest.max(axis=-1)}


def judge(wish: Wish, kind: str, gains: dict[str, float], signs: tuple[float, ...] | None = None) -> dict[str, float]:
    """One set of gains over the whole range, both directions, all loads and all corners of the uncertainty.

    Noise and times count at right parameters and at every corner.
    """
    signs = signs or wish.signs
    parts = [judged(wish, response(wish.machine, kind, gains, wish.points(7, 5, signs)))]
    parts += [judged(wish, response(wish.machine, kind, gains, wish.points(3, 3, signs), errors)) for errors in wish.corners()]
    return {name: float(max(part[name] for part in parts)) for name in QUANTITIES}


def excess(limits: dict[str, float], values: dict[str, Any]) -> Any:
    """How far values are above their limits, summed on a logarithmic scale; 0 where every one is met."""
    total: Any = 0.0
    for name, limit in limits.items():
        total = total + np.maximum(np.log(np.clip(values[name], 1e-9, 1e9) / limit), 0.0)
    return total


def missed(limits: dict[str, float], values: dict[str, float]) -> list[str]:
    """Names of what is above its limit, by more than a thousandth of it."""
    return [name for name, limit in limits.items() if not values[name] <= limit * 1.001]
