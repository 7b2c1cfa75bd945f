"""The smallest sine of the flux that makes alpha and speed known to a wanted accuracy in a given time, and what it costs.

Two conditions. No estimator can do better than the Cramer-Rao bound (`imo_analysis.excitation.bounds`). The observer itself
needs its alpha_hat to settle: averaged over the modulation, its error decays at

    rate = g sum_nu |v_1(nu)|^2 Re H(nu),
    H(nu) = 1 / (k_1 + R_s/sigma + j (nu - omega) + (alpha k_3 + kappa |omega|) / (j nu)),

over the two sidebands nu = omega_s +- frequency with |v_1| = beta psi depth frequency / (2 alpha) (no load; a load does not
change which part of v_1 is across v_2), and where the law squares the current's noise it rests
2 g (1 + beta L_m) noise^2 / rate too low (claim ``noise.bias``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.steady_state import current_of_flux
from imo_analysis.errors import InputError
from imo_analysis.excitation.bounds import Measurement, bounds_over_speed, held_torque, slip_at
from imo_analysis.machine import InductionMachine

if TYPE_CHECKING:
    from imo_analysis.study import Study

_CONFIDENCE = 3.0  # standard deviations that the accuracy must hold
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
    """A flux modulation psi (1 + depth cos(frequency t)) and what it does at the worst point of the range.

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


def settling_rate(machine: InductionMachine, gains: Mapping[str, float], flux: float, depth: float, frequency: float,
                  omega: float, slip: float = 0.0) -> float:
    """Averaged decay rate of the alpha error in the repaired and quiet observers, in 1/s."""
    damping = gains["k_1"] + machine.R_s / machine.sigma
    nu = omega + slip + np.array([frequency, -frequency])
    strength = machine.alpha * gains["k_3"] + gains["kappa"] * abs(omega)
    with np.errstate(divide="ignore", invalid="ignore"):
        lag = damping + 1j * (nu - omega) - 1j * strength / nu
        answer = np.where(nu == 0, 0.0, np.real(1 / lag))
    side = machine.beta * flux * depth * frequency / (2 * machine.alpha)
    return float(gains["g"] * side * side * answer.sum())


def costs(
    machine: InductionMachine, flux: float, depth: float, frequency: float, omega: float, torque: float
) -> tuple[float, float, float]:
    """``(peak current, peak voltage, added copper loss)`` in A, V and W at held torque, over one period."""
    t = 2 * math.pi / frequency * np.arange(512) / 512
    psi = flux * (1 + depth * np.cos(frequency * t))
    rate = -flux * depth * frequency * np.sin(frequency * t)
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
           squares_noise: bool) -> Design:
    """A modulation at the worst point of the range."""
    speeds = np.asarray(wanted.speeds, float)
    measurement = Measurement(wanted.noise, 10_000.0, wanted.time)
    slips = {torque: slip_at(machine, torque, flux) for torque in wanted.torques}
    bounds = [bounds_over_speed(machine, held_torque(flux, 0.0, slip, depth, frequency), speeds, measurement)
              for slip in slips.values()]
    rate = min(settling_rate(machine, gains, flux, depth, frequency, omega, slip)
               for omega in wanted.speeds for slip in slips.values())
    bias = 2 * gains["g"] * (1 + machine.beta * machine.L_m) * wanted.noise**2 / rate if squares_noise else 0.0
    price = [costs(machine, flux, depth, frequency, omega, torque) for omega in wanted.speeds for torque in wanted.torques]
    worst = {name: max(float(b[name].max()) for b in bounds) for name in ("alpha_both", "omega_both")}
    current, voltage, loss = (max(one[k] for one in price) for k in range(3))
    return Design(depth, float(frequency), rate, bias, worst["alpha_both"], worst["omega_both"], current, voltage, loss)


def reaches(found: Design, wanted: Wanted) -> bool:
    """Whether a modulation reaches the accuracy in the time."""
    settled = wanted.start * math.exp(-found.rate * wanted.time) + found.bias
    return (settled <= _MARGIN * wanted.alpha and _CONFIDENCE * found.alpha_bound <= wanted.alpha
            and _CONFIDENCE * found.omega_bound <= wanted.omega)


def within(found: Design, wanted: Wanted) -> bool:
    """Whether a modulation keeps the limits."""
    return found.current <= wanted.current_limit and found.voltage <= wanted.voltage_limit and found.depth <= wanted.depth_limit


def design(machine: InductionMachine, gains: Mapping[str, float], flux: float, wanted: Wanted, *, squares_noise: bool,
           frequencies: Sequence[float] = tuple(np.geomspace(2, 200, 25))) -> tuple[Design, list[Design]]:
    """The sine with the least added loss that reaches the accuracy within the limits.

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

    Returns
    -------
    Design
        The one with the least loss.
    list of Design
        The smallest depth that reaches the accuracy at each frequency where one does.

    Raises
    ------
    InputError
        If no frequency reaches the accuracy within the limits.
    """
    found = []
    for frequency in frequencies:
        low, high = 0.0, wanted.depth_limit
        if not reaches(assess(machine, gains, flux, high, frequency, wanted, squares_noise), wanted):
            continue
        for _ in range(18):
            middle = (low + high) / 2
            if reaches(assess(machine, gains, flux, middle, frequency, wanted, squares_noise), wanted):
                high = middle
            else:
                low = middle
        found.append(assess(machine, gains, flux, high, frequency, wanted, squares_noise))
    allowed = [one for one in found if within(one, wanted)]
    if not allowed:
        why = "none keeps the limits of current and voltage" if found else f"no depth up to {wanted.depth_limit:g} does"
        raise InputError(f"no flux modulation reaches alpha within {wanted.alpha:g} /s in {wanted.time:g} s: {why}; "
                         "ask for less accuracy, more time or higher gain g")
    return min(allowed, key=lambda one: one.loss), found


def modulated_study(study: Study, found: Design) -> Study:
    """The study with the modulation in its drive; the flux loop's own lag is made up for in the amplitude of the reference."""
    lag = math.hypot(1.0, found.frequency / study.drive.flux_bandwidth)
    return study.changed({"drive.flux_modulation": found.depth * study.drive.flux * lag,
                          "drive.flux_modulation_frequency": found.frequency})


@dataclass(frozen=True)
class Check:
    """A design in closed loop at one speed: errors of alpha_hat (1/s) and of omega_hat (rad/s), mean and deviation, late on.

    ``torque_ripple`` is the deviation of the torque in N m, ``torque_ripple_before`` the one without modulation.
    """

    omega: float
    alpha_error: float
    alpha_deviation: float
    omega_error: float
    omega_deviation: float
    torque_ripple: float
    torque_ripple_before: float


def verify(study: Study, found: Design, wanted: Wanted, observer: str) -> list[Check]:
    """Simulate the design with noise at each speed of the range, without load, and look at the second after ``wanted.time``."""
    from imo_analysis.simulation.run import simulate

    rows = []
    for omega in wanted.speeds:
        plain = study.only([observer]).changed({
            "sensors.current_noise": wanted.noise, "reference.shape": "steps", "reference.time": [0.0],
            "reference.omega": [omega], "simulation.duration": wanted.time + 1.0})
        late = slice(wanted.time, None)
        run = simulate(modulated_study(plain, found)).sel(observer=observer, time=late)
        before = simulate(plain).sel(time=late)
        alpha = (run["alpha_hat"] - study.machine.alpha).values
        speed = (run["omega_hat"] - run["omega"]).values
        rows.append(Check(omega, float(alpha.mean()), float(alpha.std()), float(speed.mean()), float(speed.std()),
                          float(run["torque"].std()), float(before["torque"].std())))
    return rows
