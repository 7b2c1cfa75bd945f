"""The cheapest flux modulation that makes alpha and speed known to a wanted accuracy in a given time, and what it costs.

Two conditions. No estimator can do better than the Cramer-Rao bound (`imo_analysis.excitation.bounds`). The observer itself
needs its alpha_hat to settle (`imo_analysis.excitation.settling`), and where its law squares the current's noise it rests
2 g (1 + beta L_m) noise^2 / rate too low (claim ``noise.bias``). Both must hold all over the operating range: at every pair of
speed and torque between the smallest and the largest that are given, looked at on a grid and where a sideband of the modulation
comes to zero frequency.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.own import shown
from imo_analysis.errors import InputError
from imo_analysis.excitation.bounds import Measurement, bounds_over_speed, held_torque_along, slip_at
from imo_analysis.excitation.ripple import torque_ripple
from imo_analysis.excitation.settling import KINDS, QUIET, opening_time, settling_rate
from imo_analysis.excitation.swing import COSINE, Shape, costs, shape_of
from imo_analysis.machine import InductionMachine
from imo_analysis.simulation.waveforms import WAVES
from imo_analysis.study_tables import Drive

_CONFIDENCE = 3.0  # standard deviations that the accuracy must hold
DEEPEST = 0.5  # of the mean flux: beyond, the averaged rate is no guide
_DEEPEST_REFERENCE = 0.95  # of the mean flux: its reference must stay above 0
MARGIN = 0.9  # the averaged rate and bias, and the torque ripple, are good to a few per cent
FREQUENCIES = tuple(float(one) for one in np.geomspace(2, 200, 25))  # rad/s; `search` goes beyond where the best is at an end
_SAMPLES = 20  # of the drive in a period of the modulation, at least
_SPEEDS, _TORQUES = 9, 3  # points of the grid over the operating range
_ORDERS = 3  # of the lines whose sidebands are looked for at zero frequency


@dataclass(frozen=True)
class Wanted:
    """What the design must reach.

    Attributes
    ----------
    alpha, omega : float
        Accuracy, in 1/s and rad/s.
    time : float
        Within this time, in s.
    start : float
        Error of alpha_hat at the start, in 1/s.
    speeds, torques : tuple of float
        The operating range lies between the smallest and the largest, rad/s and N m; these points themselves are simulated.
    noise : float
        Standard deviation of each current sample, in A.
    depth_limit : float
        Largest depth of the flux, as a part of its mean (saturation).
    current_limit, voltage_limit : float
        Peak values, in A and V.
    torque_limit : float
        Half the swing of the torque that the modulation makes, in N m.
    step : float
        Time from sample to sample, in s.
    """

    alpha: float
    omega: float
    time: float
    start: float
    speeds: tuple[float, ...]
    torques: tuple[float, ...]
    noise: float
    depth_limit: float = 0.2
    current_limit: float = math.inf
    voltage_limit: float = math.inf
    torque_limit: float = math.inf
    step: float = 1e-4


@dataclass(frozen=True)
class Design:
    """A flux modulation psi (1 + depth shape(frequency t)) and what it does at the worst point of the range.

    Attributes
    ----------
    depth, frequency : float
        Depth (1) and frequency (rad/s).
    rate : float
        Slowest decay of the alpha error in the observer, averaged over the modulation, 1/s.
    bias : float
        Largest error of alpha_hat that the noise leaves, 1/s; 0 for a law without the square of the noise.
    alpha_bound, omega_bound : float
        Largest Cramer-Rao bounds, in 1/s and rad/s.
    current, voltage : float
        Largest peaks, in A and V.
    ripple : float
        Largest half swing of the torque, in N m; 0 where no drive says how it holds the torque.
    loss : float
        Most copper loss, stator and rotor, that the modulation adds, in W.
    slowest : tuple of 2
        Speed (rad/s) and torque (N m) at which the rate is the slowest.
    waveform : str
        Of the reference; the flux follows as the drive lets it.
    delay : float
        Time in s before the law begins to settle: until a supervisor's filters are full, else 0.
    """

    depth: float
    frequency: float
    rate: float
    bias: float
    alpha_bound: float
    omega_bound: float
    current: float
    voltage: float
    ripple: float
    loss: float
    slowest: tuple[float, float]
    waveform: str = "sine"
    delay: float = 0.0


@dataclass(frozen=True)
class Limit:
    """A limit: its name, the fields of `Wanted` and `Design` that it is about, unit and factor for print, and a margin."""

    name: str
    wanted: str
    found: str
    unit: str
    factor: float = 1.0
    margin: float = 1.0

    def value(self, wanted: Wanted) -> float:
        """Its value."""
        return float(getattr(wanted, self.wanted))

    def used(self, found: Design) -> float:
        """How much a design uses of it, with the margin."""
        return float(getattr(found, self.found)) / self.margin

    def share(self, found: Design, wanted: Wanted) -> str:
        """In words, how much a design uses of it."""
        value = self.value(wanted)
        of = f" of {value * self.factor:.3g}" if math.isfinite(value) else ""
        return f"{self.name} {self.used(found) * self.factor:.3g}{of} {self.unit}"

    def said(self, value: float) -> str:
        """A value with its unit, rounded up so that asking for what is said is enough."""
        scaled = value * self.factor
        unit = 10.0 ** (math.floor(math.log10(scaled)) - 2) if scaled > 0 else 1.0
        return f"{math.ceil(scaled / unit - 1e-9) * unit:.3g} {self.unit}"


LIMITS = (
    Limit("flux", "depth_limit", "depth", "%", 100.0),
    Limit("torque", "torque_limit", "ripple", "N m", margin=MARGIN),
    Limit("current", "current_limit", "current", "A"),
    Limit("voltage", "voltage_limit", "voltage", "V"),
)


@dataclass(frozen=True)
class Plant:
    """What a modulation acts on: machine, kind and gains of the observer, mean flux (Wb), and the drive where there is one.

    Attributes
    ----------
    machine : InductionMachine
        As it is.
    kind : str
        Of the observer, a name of the catalogue.
    gains : mapping of str to float
        The observer's.
    flux : float
        Mean rotor flux in Wb.
    drive : Drive, optional
        Its loops decide which flux follows; without one the flux is a cosine.
    """

    machine: InductionMachine
    kind: str
    gains: Mapping[str, float]
    flux: float
    drive: Drive | None = None

    def shape(self, waveform: str, frequency: float) -> Shape:
        """The swing of the flux that a reference makes.

        Parameters
        ----------
        waveform : str
            One of `simulation.waveforms`.
        frequency : float
            In rad/s.
        """
        return shape_of(waveform, frequency, self.drive, self.machine.alpha) if self.drive else COSINE


def assess(plant: Plant, wanted: Wanted, depth: float, frequency: float, waveform: str = "sine") -> Design:
    """A modulation at the worst points of the range."""
    shape = plant.shape(waveform, frequency)
    found = _accuracy(plant, wanted, depth, frequency, shape)
    machine, flux = plant.machine, plant.flux
    points = [(omega, torque) for omega in _ends(wanted.speeds) for torque in _ends(wanted.torques)]
    price = [costs(machine, flux, depth, frequency, omega, torque, shape) for omega, torque in points]
    ripple = (torque_ripple(machine, plant.drive, flux, shape, depth, frequency, points, wanted.step)
              if plant.drive else 0.0)
    current, voltage, loss = (max(one[k] for one in price) for k in range(3))
    return replace(found, current=current, voltage=voltage, ripple=ripple, loss=loss, waveform=waveform)


def _ends(values: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(sorted({min(values), *values, max(values)}))


def operating_range(wanted: Wanted, slips: NDArray[np.float64], frequency: float, shape: Shape) -> NDArray[np.float64]:
    """Speeds to look at, in rad/s: those given, a grid between them, and those at which the flux itself or a
    sideband stands still.
    """
    low, high = min(wanted.speeds), max(wanted.speeds)
    still = [line * frequency - slip for order in (0, *shape.orders[:_ORDERS]) for line in (order, -order) for slip in slips]
    return np.unique([*wanted.speeds, *np.linspace(low, high, _SPEEDS), *(one for one in still if low < one < high)])


def _accuracy(plant: Plant, wanted: Wanted, depth: float, frequency: float, shape: Shape) -> Design:
    """The same with the costs left out."""
    found = _settling(plant, wanted, depth, frequency, shape)
    measurement = Measurement(wanted.noise, 1 / wanted.step, wanted.time)
    slips, speeds = points_looked_at(plant, wanted, frequency, shape)
    psi = 1 + depth * shape.swing
    bounds = [bounds_over_speed(plant.machine, held_torque_along(psi, plant.flux, 0.0, slip, frequency), speeds, measurement)
              for slip in slips]
    worst = {name: max(float(b[name].max()) for b in bounds) for name in ("alpha_both", "omega_both")}
    return replace(found, alpha_bound=worst["alpha_both"], omega_bound=worst["omega_both"])


def points_looked_at(
    plant: Plant, wanted: Wanted, frequency: float, shape: Shape
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Slips and speeds."""
    slips = np.array([slip_at(plant.machine, torque, plant.flux) for torque in torques_looked_at(wanted)])
    return slips, operating_range(wanted, slips, frequency, shape)


def torques_looked_at(wanted: Wanted) -> list[float]:
    """Torques in N m, in the order of the slips of `points_looked_at`."""
    return sorted({*wanted.torques, *np.linspace(min(wanted.torques), max(wanted.torques), _TORQUES).tolist()})


def _settling(plant: Plant, wanted: Wanted, depth: float, frequency: float, shape: Shape) -> Design:
    """What the observer makes of a modulation, the Cramer-Rao bounds and the costs left out."""
    machine, gains = plant.machine, plant.gains
    slips, speeds = points_looked_at(plant, wanted, frequency, shape)
    rates = settling_rate(machine, gains, plant.flux, depth, frequency, speeds[:, None], slips, shape, plant.kind)
    at = np.unravel_index(np.argmin(rates), rates.shape)
    rate = float(rates[at])
    bias = 0.0
    if plant.kind not in QUIET:
        bias = 2 * gains["g"] * (1 + machine.beta * machine.L_m) * wanted.noise**2 / rate if rate > 0 else math.inf
    found = Design(depth, float(frequency), rate, bias, math.nan, math.nan, math.nan, math.nan, math.nan, math.nan,
                   (float(speeds[at[0]]), torques_looked_at(wanted)[int(at[1])]))
    if plant.kind == "supervised":
        found = replace(found, delay=opening_time(machine, gains, plant.flux, depth, frequency, shape))
    return found


def settles(found: Design, wanted: Wanted) -> bool:
    """Whether alpha_hat is close enough in the time, on average over the modulation."""
    return wanted.start * math.exp(-found.rate * max(wanted.time - found.delay, 0.0)) + found.bias <= MARGIN * wanted.alpha


def reaches(found: Design, wanted: Wanted) -> bool:
    """Whether a modulation reaches the accuracy in the time."""
    return (settles(found, wanted) and _CONFIDENCE * found.alpha_bound <= wanted.alpha
            and _CONFIDENCE * found.omega_bound <= wanted.omega)


def time_needed(found: Design, wanted: Wanted) -> float:
    """The time in s after which a modulation reaches the accuracy; infinite where it never does."""
    left = MARGIN * wanted.alpha - found.bias
    if left <= 0 or found.rate <= 0:
        return math.inf
    bound = max(found.alpha_bound / wanted.alpha, found.omega_bound / wanted.omega) * _CONFIDENCE
    return max(found.delay + math.log(max(wanted.start / left, 1.0)) / found.rate, wanted.time * bound * bound)


def within(found: Design, wanted: Wanted) -> bool:
    """Whether a modulation keeps the limits."""
    return all(limit.used(found) <= limit.value(wanted) for limit in LIMITS)


def search(plant: Plant, wanted: Wanted, frequencies: Sequence[float] = FREQUENCIES) -> tuple[list[Design], list[Design]]:
    """Whatever the limits: the smallest depth for each waveform and frequency, and the deepest where none does.

    While the cheapest of a waveform has the highest or lowest frequency tried, others beyond are tried too, as long as a period
    has `_SAMPLES` samples and fits into the time.
    """
    if plant.kind not in KINDS:
        raise InputError(f"observer kind {shown(plant.kind)!r} has no design; choose one of: {', '.join(KINDS)}")
    found: list[Design] = []
    deepest: list[Design] = []
    for waveform in WAVES if plant.drive else ("sine",):
        tried: dict[float, tuple[Design, bool]] = {}
        waiting = list(frequencies)
        while waiting:
            tried |= {frequency: _smallest(plant, wanted, frequency, waveform) for frequency in waiting}
            waiting = _beyond(tried, wanted)
        for one, reached in tried.values():
            (found if reached else deepest).append(one)
    return found, deepest


def _smallest(plant: Plant, wanted: Wanted, frequency: float, waveform: str) -> tuple[Design, bool]:
    """The smallest that reaches the accuracy, or the deepest, and whether it does."""
    shape = plant.shape(waveform, frequency)
    most = min(DEEPEST, _DEEPEST_REFERENCE / shape.reference)
    depth = _smallest_depth(plant, wanted, frequency, shape, most)
    if depth is not None:
        return assess(plant, wanted, depth, frequency, waveform), True
    return _accuracy(plant, wanted, most, frequency, shape), False


def _beyond(tried: Mapping[float, tuple[Design, bool]], wanted: Wanted) -> list[float]:
    """The next frequency, where the cheapest is at the end of those tried."""
    reached = [one for one, does in tried.values() if does]
    if len(tried) < 2 or not reached:
        return []
    best = min([one for one in reached if within(one, wanted)] or reached, key=lambda one: one.loss).frequency
    low, *_, high = sorted(tried)
    further = (high / low) ** (1 / (len(tried) - 1))
    if best == high and high * further <= 2 * math.pi / (_SAMPLES * wanted.step):
        return [high * further]
    return [low / further] if best == low and low / further >= 2 * math.pi / wanted.time else []


def _smallest_depth(plant: Plant, wanted: Wanted, frequency: float, shape: Shape, most: float) -> float | None:
    """By bisection, to 1e-5 of ``most``; None where that does not reach the accuracy."""
    def does(depth: float) -> bool:
        return settles(_settling(plant, wanted, depth, frequency, shape), wanted)

    def enough(depth: float) -> bool:
        return reaches(_accuracy(plant, wanted, depth, frequency, shape), wanted)

    if not does(most):
        return None
    depth = _bisected(does, most)
    if enough(depth):
        return depth
    return _bisected(enough, most) if enough(most) else None


def _bisected(enough: Callable[[float], bool], most: float) -> float:
    low, high = 0.0, most
    while high - low > 1e-5 * most:
        middle = (low + high) / 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high
