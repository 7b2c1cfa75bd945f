"""The cheapest flux modulation that makes alpha and speed known to a wanted accuracy in a given time, and what it costs.

Two conditions. No estimator can do better than the Cramer-Rao bound (`imo_analysis.excitation.bounds`). The observer itself
needs its alpha_hat to settle: averaged over the modulation, its error decays at

    rate = g sum_nu |v_1(nu)|^2 Re H(nu),
    H(nu) = 1 / (k_1 + R_s/sigma + j (nu - omega) + (alpha k_3 + kappa |omega|) / (j nu)),

over the sidebands nu = omega_s +- n frequency of every line n of the flux's shape, |v_1| = beta psi depth |c_n| n frequency /
alpha (no load; a load does not change which part of v_1 is across v_2), and where the law squares the current's noise it rests
2 g (1 + beta L_m) noise^2 / rate too low (claim ``noise.bias``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.steady_state import current_of_flux
from imo_analysis.errors import InputError
from imo_analysis.excitation.bounds import Measurement, bounds_over_speed, held_torque_along, slip_at
from imo_analysis.machine import InductionMachine
from imo_analysis.simulation.waveforms import WAVES, lines

if TYPE_CHECKING:
    from imo_analysis.study import Study
    from imo_analysis.study_tables import Drive

_CONFIDENCE = 3.0  # standard deviations that the accuracy must hold
_DEEPEST_REFERENCE = 0.95  # of the mean flux: its reference must stay above 0
_MARGIN = 0.9  # the averaged rate and bias are good to a few per cent


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
        The operating range: all pairs of them, rad/s and N m.
    noise : float
        Standard deviation of each current sample, in A.
    depth_limit : float
        Largest depth (saturation).
    current_limit, voltage_limit : float
        Peak values, in A and V.
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


@dataclass(frozen=True)
class Design:
    """A flux modulation psi (1 + depth shape(frequency t)) and what it does at the worst point of the range.

    Attributes
    ----------
    depth, frequency : float
        Depth (1) and frequency (rad/s).
    rate : float
        Slowest decay of the alpha error in the observer, 1/s.
    bias : float
        Largest error of alpha_hat that the noise leaves, 1/s; 0 for a law without the square of the noise.
    alpha_bound, omega_bound : float
        Largest Cramer-Rao bounds, in 1/s and rad/s.
    current, voltage : float
        Largest peaks, in A and V.
    loss : float
        Most copper loss, stator and rotor, that the modulation adds, in W.
    waveform : str
        Of the reference; the flux follows as the drive lets it.
    """

    depth: float
    frequency: float
    rate: float
    bias: float
    alpha_bound: float
    omega_bound: float
    current: float
    voltage: float
    loss: float
    waveform: str = "sine"


@dataclass(frozen=True, eq=False)
class Shape:
    """A periodic swing of the flux with a peak of 1, as the sum of c_n exp(j n angle) and the conjugates.

    Attributes
    ----------
    orders, amplitudes : array of shape (lines,)
        n and c_n.
    reference : float
        Peak of the flux reference that makes it.
    """

    orders: NDArray[np.int64]
    amplitudes: NDArray[np.complex128]
    reference: float = 1.0

    @cached_property
    def swing(self) -> NDArray[np.float64]:
        """The swing at 256 points of a period."""
        return self.sampled(256)

    def sampled(self, points: int = 512, derivative: int = 0) -> NDArray[np.float64]:
        """The swing, or its derivative by the angle, evenly over a period."""
        angle = 2 * math.pi * np.arange(points) / points
        weights = self.amplitudes * (1j * self.orders) ** derivative
        values: NDArray[np.float64] = 2 * np.real(weights @ np.exp(1j * np.outer(self.orders, angle)))
        return values


COSINE = Shape(np.array([1]), np.array([0.5 + 0j]))


def shape_of(waveform: str, frequency: float, drive: Drive, alpha: float) -> Shape:
    """What the drive makes of a waveform of the flux reference: its flux loop acting through its current loop.

    Line n is passed with w / ((s + alpha) (1 + s / w_i) + w - alpha) at s = j n frequency, w and w_i the bandwidths of the
    flux and the current loop: as long as no limit is hit.
    """
    orders, amplitudes = lines(waveform)
    s = 1j * orders * frequency
    passed = drive.flux_bandwidth / ((s + alpha) * (1 + s / drive.current_bandwidth) + drive.flux_bandwidth - alpha)
    followed = Shape(orders, amplitudes * passed)
    peak = float(np.abs(followed.sampled()).max())
    return Shape(orders, followed.amplitudes / peak, 1 / peak)


def settling_rate(machine: InductionMachine, gains: Mapping[str, float], flux: float, depth: float, frequency: float,
                  omega: float, slip: float = 0.0, shape: Shape = COSINE) -> float:
    """Averaged decay rate of the alpha error in the repaired and quiet observers, in 1/s."""
    damping = gains["k_1"] + machine.R_s / machine.sigma
    nu = omega + slip + np.outer([1.0, -1.0], shape.orders * frequency)
    strength = machine.alpha * gains["k_3"] + gains["kappa"] * abs(omega)
    with np.errstate(divide="ignore", invalid="ignore"):
        lag = damping + 1j * (nu - omega) - 1j * strength / nu
        answer = np.where(nu == 0, 0.0, np.real(1 / lag))
    side = machine.beta * flux * depth * np.abs(shape.amplitudes) * shape.orders * frequency / machine.alpha
    return float(gains["g"] * (side * side * answer).sum())


def costs(
    machine: InductionMachine, flux: float, depth: float, frequency: float, omega: float, torque: float, shape: Shape = COSINE
) -> tuple[float, float, float]:
    """``(peak current, peak voltage, added copper loss)`` in A, V and W at held torque, over one period."""
    t = 2 * math.pi / frequency * np.arange(512) / 512
    psi = flux * (1 + depth * shape.sampled())
    rate = flux * depth * frequency * shape.sampled(derivative=1)
    slip = slip_at(machine, torque, flux) * (flux / psi) ** 2
    i_d, i_q = current_of_flux(psi, rate, slip, machine.alpha, machine.L_m)
    current = i_d + 1j * i_q
    turn = 1j * (omega + slip)
    change = np.gradient(current, t, edge_order=2) + turn * current + machine.beta * (rate + turn * psi)
    voltage = machine.sigma * change + machine.R_s * current
    rotor = (psi - machine.L_m * current) / machine.L_r
    steady = current_of_flux(flux, 0.0, slip_at(machine, torque, flux), machine.alpha, machine.L_m)
    still = steady[0] + 1j * steady[1]
    still_rotor = (flux - machine.L_m * still) / machine.L_r

    def loss(stator: Any, in_rotor: Any) -> float:
        return float(1.5 * np.mean(machine.R_s * np.abs(stator) ** 2 + machine.R_r * np.abs(in_rotor) ** 2))

    added = loss(current, rotor) - loss(still, still_rotor)
    return float(np.abs(current).max()), float(np.abs(voltage).max()), added


def assess(machine: InductionMachine, gains: Mapping[str, float], flux: float, depth: float, frequency: float, wanted: Wanted,
           squares_noise: bool, shape: Shape = COSINE, waveform: str = "sine") -> Design:
    """A modulation at the worst point of the range."""
    found = _accuracy(machine, gains, flux, depth, frequency, wanted, squares_noise, shape)
    price = [costs(machine, flux, depth, frequency, omega, torque, shape)
             for omega in wanted.speeds for torque in wanted.torques]
    current, voltage, loss = (max(one[k] for one in price) for k in range(3))
    return replace(found, current=current, voltage=voltage, loss=loss, waveform=waveform)


def _accuracy(machine: InductionMachine, gains: Mapping[str, float], flux: float, depth: float, frequency: float,
              wanted: Wanted, squares_noise: bool, shape: Shape) -> Design:
    """The same with the costs left out."""
    speeds = np.asarray(wanted.speeds, float)
    measurement = Measurement(wanted.noise, 10_000.0, wanted.time)
    slips = [slip_at(machine, torque, flux) for torque in wanted.torques]
    psi = 1 + depth * shape.swing
    bounds = [bounds_over_speed(machine, held_torque_along(psi, flux, 0.0, slip, frequency), speeds, measurement)
              for slip in slips]
    rate = min(settling_rate(machine, gains, flux, depth, frequency, omega, slip, shape)
               for omega in wanted.speeds for slip in slips)
    bias = 2 * gains["g"] * (1 + machine.beta * machine.L_m) * wanted.noise**2 / rate if squares_noise else 0.0
    worst = {name: max(float(b[name].max()) for b in bounds) for name in ("alpha_both", "omega_both")}
    return Design(depth, float(frequency), rate, bias, worst["alpha_both"], worst["omega_both"], math.nan, math.nan, math.nan)


def reaches(found: Design, wanted: Wanted) -> bool:
    """Whether a modulation reaches the accuracy in the time."""
    settled = wanted.start * math.exp(-found.rate * wanted.time) + found.bias
    return (settled <= _MARGIN * wanted.alpha and _CONFIDENCE * found.alpha_bound <= wanted.alpha
            and _CONFIDENCE * found.omega_bound <= wanted.omega)


def within(found: Design, wanted: Wanted) -> bool:
    """Whether a modulation keeps the limits."""
    return found.current <= wanted.current_limit and found.voltage <= wanted.voltage_limit and found.depth <= wanted.depth_limit


def design(machine: InductionMachine, gains: Mapping[str, float], flux: float, wanted: Wanted, *, squares_noise: bool,
           frequencies: Sequence[float] = tuple(np.geomspace(2, 200, 25)), drive: Drive | None = None,
           ) -> tuple[Design, list[Design]]:
    """The modulation with the least added loss that reaches the accuracy within the limits.

    Parameters
    ----------
    gains : mapping
        Of a repaired or quiet observer: k_1, kappa, k_3, g.
    flux : float
        Mean rotor flux in Wb.
    squares_noise : bool
        Whether the alpha law multiplies the noise with itself, as (9) does.
    frequencies : sequence of float
        Tried, in rad/s.
    drive : Drive, optional
        Makes every waveform of `simulation.waveforms` possible, as its loops let the flux follow; without it the flux itself
        is a cosine.

    Returns
    -------
    Design
        The one with the least loss.
    list of Design
        The smallest depth that reaches the accuracy for each waveform and frequency where one does.

    Raises
    ------
    InputError
        If nothing reaches the accuracy within the limits.
    """
    found = []
    for waveform in WAVES if drive else ("sine",):
        for frequency in frequencies:
            shape = shape_of(waveform, frequency, drive, machine.alpha) if drive else COSINE
            depth = _smallest_depth(machine, gains, flux, frequency, wanted, squares_noise, shape)
            if depth is not None:
                found.append(assess(machine, gains, flux, depth, frequency, wanted, squares_noise, shape, waveform))
    allowed = [one for one in found if within(one, wanted)]
    if not allowed:
        why = ("none keeps the limits of current and voltage" if found else
               f"no depth up to {wanted.depth_limit:g} with a reference above 0 does")
        raise InputError(f"no flux modulation reaches alpha within {wanted.alpha:g} /s in {wanted.time:g} s: {why}; "
                         "ask for less accuracy, more time or higher gain g")
    return min(allowed, key=lambda one: one.loss), found


def _smallest_depth(machine: InductionMachine, gains: Mapping[str, float], flux: float, frequency: float, wanted: Wanted,
                    squares_noise: bool, shape: Shape) -> float | None:
    """By bisection, to 1e-5 of the limit; None where the limit does not reach the accuracy.

    The limit is the wanted one, or where the flux follows so little that the reference would come down to zero.
    """
    def enough(depth: float) -> bool:
        return reaches(_accuracy(machine, gains, flux, depth, frequency, wanted, squares_noise, shape), wanted)

    limit = min(wanted.depth_limit, _DEEPEST_REFERENCE / shape.reference)
    low, high = 0.0, limit
    if not enough(high):
        return None
    while high - low > 1e-5 * limit:
        middle = (low + high) / 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high


def cheapest_by_waveform(found: Sequence[Design], wanted: Wanted) -> list[Design]:
    """The design of least loss within the limits for each waveform, the cheapest waveform first."""
    best: dict[str, Design] = {}
    for one in found:
        if within(one, wanted) and (one.waveform not in best or one.loss < best[one.waveform].loss):
            best[one.waveform] = one
    return sorted(best.values(), key=lambda one: one.loss)


def modulated_study(study: Study, found: Design) -> Study:
    """The study with the modulation in its drive, the reference as large as the drive's loops need it."""
    shape = shape_of(found.waveform, found.frequency, study.drive, study.machine.alpha)
    return study.changed({"drive.flux_modulation": found.depth * study.drive.flux * shape.reference,
                          "drive.flux_modulation_frequency": found.frequency, "drive.flux_waveform": found.waveform})


@dataclass(frozen=True)
class Check:
    """A design in closed loop at one speed and load, late on.

    Attributes
    ----------
    omega, torque : float
        The operating point, rad/s and N m.
    alpha_error, alpha_deviation, omega_error, omega_deviation : float
        Mean and deviation of the errors of alpha_hat (1/s) and omega_hat (rad/s).
    torque_ripple, torque_ripple_before : float
        Deviation of the torque in N m, with and without the modulation.
    loss : float
        Mean copper loss that the modulation added, in W.
    """

    omega: float
    torque: float
    alpha_error: float
    alpha_deviation: float
    omega_error: float
    omega_deviation: float
    torque_ripple: float
    torque_ripple_before: float
    loss: float


def verify(study: Study, found: Design, wanted: Wanted, observer: str) -> list[Check]:
    """Simulate the design with noise at each speed and load of the range, and look at the whole periods of the next second."""
    from imo_analysis.simulation.run import simulate

    period = 2 * math.pi / found.frequency
    late = slice(wanted.time, wanted.time + max(1, int(1.0 / period)) * period)
    rows = []
    for omega in wanted.speeds:
        for torque in wanted.torques:
            plain = study.only([observer]).changed({
                "sensors.current_noise": wanted.noise, "reference.shape": "steps", "reference.time": [0.0],
                "reference.omega": [omega], "load.shape": "steps", "load.time": [0.0], "load.T_l": [torque],
                "simulation.duration": late.stop + 1e-3})
            run = simulate(modulated_study(plain, found)).sel(observer=observer, time=late)
            before = simulate(plain).sel(time=late)
            alpha = (run["alpha_hat"] - study.machine.alpha).values
            speed = (run["omega_hat"] - run["omega"]).values
            rows.append(Check(omega, torque, float(alpha.mean()), float(alpha.std()), float(speed.mean()), float(speed.std()),
                              float(run["torque"].std()), float(before["torque"].std()),
                              _copper_loss(study.machine, run) - _copper_loss(study.machine, before)))
    return rows


def _copper_loss(machine: InductionMachine, run: Any) -> float:
    """Mean loss in stator and rotor, in W."""
    stator = run["i_ds"].values + 1j * run["i_qs"].values
    rotor = (run["phi_dr"].values + 1j * run["phi_qr"].values - machine.L_m * stator) / machine.L_r
    return float(1.5 * np.mean(machine.R_s * np.abs(stator) ** 2 + machine.R_r * np.abs(rotor) ** 2))
