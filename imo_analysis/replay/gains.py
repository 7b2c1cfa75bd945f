"""Gains for a record, from the machine, the sampling rate and the level of the record, by one rule for the whole family.

With the flux as it is, the errors of current and speed of every observer obey, to first order,

    i_tilde' = -(k_1 + R_s/sigma) i_tilde + beta |phi| omega_tilde,      omega_tilde' = -K_p beta |phi| i_tilde,

a second-order system of natural frequency ``bandwidth`` = beta |phi| sqrt(K_p) and damping 0.7. A speed that changes at a
constant rate is followed with the lag 1.4 / bandwidth. White noise of deviation n on the currents, sampled every T, makes

    sqrt(bandwidth^3 n^2 T / 2.8) / (beta |phi|)

of noise in the speed. So the bandwidth is taken as high as samples and noise allow: 0.4 rad a sample, at most 4000 rad/s
(above, currents tell more of slots than of the speed), and with no more noise in the speed than 0.2 % of the stator
frequency. The z and xi loops are a
tenth as fast as the current loop (z decays at 0.1 omega, xi at 0.1 alpha); alpha is adapted a thousand times more gently than
the speed, since one record seldom has the excitation that tells them apart.

The scheduled baseline is the exception: it is unstable while stator frequency over speed lies between 0 and k (R_s/sigma) /
(gamma + alpha), from some k on for an idle machine too (`imo derive scheduled`). Its k is the geometric mean of that k and
of 1, no feedback, and its bandwidth is what the poles' sum k (gamma + alpha) allows with the same damping.

The stator resistance is adapted at 0.1 alpha, too; P_0, of the law that turns round, is 0.3 of the power at a slip and a stator
frequency of alpha. These two are those of a study's own rule as well (`imo_analysis.tuning.rule`).
"""

from __future__ import annotations

import math
from typing import Any

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.own import is_file
from imo_analysis.equations.resistance import gain_of_rate, power_of_slip
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.replay.check import Level

RADIANS_A_SAMPLE = 0.4
LEAST_TURN = math.pi  # of a record, in rad
LOWEST_BANDWIDTH, HIGHEST_BANDWIDTH = 50.0, 4000.0
NOISE_SHARE = 2e-3
DAMPING = 0.7
FLUX_LOOPS = 0.1
ALPHA_SHARE = 1e-3
RESISTANCE_SHARE = 0.1  # of alpha: how fast R_s is adapted; the flux error, which the law does not cover, dies with alpha
RESISTANCE_POWER = 0.3  # of that across the air gap where stator frequency and slip are alpha, i_d = i_q
FORGETTING = 1.0  # 1/s, of a supervisor
EXCITED_SHARE = 4e-3  # of |v_2|^2 = (beta flux)^2: a supervisor is half open where psi' / alpha has an rms of 6 % of psi


def default_bandwidth(machine: InductionMachine, level: Level, sample_time: float) -> float:
    """The bandwidth of the rule in rad/s."""
    wide = min(RADIANS_A_SAMPLE / sample_time, HIGHEST_BANDWIDTH)
    if level.noise > 0:
        allowed = NOISE_SHARE * abs(level.stator_frequency) * machine.beta * level.flux
        wide = min(wide, math.cbrt(4 * DAMPING * (allowed / level.noise) ** 2 / sample_time))
    return max(wide, LOWEST_BANDWIDTH)


def speed_noise(machine: InductionMachine, level: Level, sample_time: float, bandwidth: float) -> float:
    """Deviation of the noise that the currents' makes in the speed, in rad/s."""
    return math.sqrt(bandwidth**3 * sample_time / (4 * DAMPING)) * level.noise / (machine.beta * level.flux)


def resistance_gain(alpha: Any, sigma: Any, decay: Any, L_m: Any, flux: Any) -> Any:
    """h_s, with which the error of R_s decays at `RESISTANCE_SHARE` of alpha, that of the current at ``decay``."""
    return gain_of_rate(RESISTANCE_SHARE * alpha, sigma, decay, L_m, flux)


def resistance_power(alpha: Any, L_m: Any, flux: Any) -> Any:
    """P_0 of the law that turns round, in Wb^3 A/s: `RESISTANCE_POWER` of what crosses the air gap at alpha and alpha."""
    return RESISTANCE_POWER * power_of_slip(alpha, alpha, alpha, L_m, flux)


def default_gains(kind: str, machine: InductionMachine, level: Level, bandwidth: float) -> dict[str, float]:
    """Gains of an observer by the rule of this module.

    Parameters
    ----------
    kind : str
        Name in the catalogue.
    machine : InductionMachine
        As the observer believes it to be.
    level : Level
        Of the record; its stator frequency turns kappa into the k_2 that is multiplied by omega_hat.
    bandwidth : float
        Natural frequency of the speed loop in rad/s, see `default_bandwidth`.

    Raises
    ------
    InputError
        If flux or bandwidth is not positive, or the observer is one of the user's own.
    """
    observer = OBSERVERS[kind]
    if is_file(kind):
        raise InputError(f"{observer.name}: the rule has no gains for an observer of your own; give all of them "
                         f"({', '.join(observer.gains)}) with --gain NAME=X, or a study with [observers.NAME.gains] as "
                         "--machine, without --rule and --bandwidth")
    if not (math.isfinite(bandwidth) and bandwidth > 0):
        raise InputError(f"bandwidth = {bandwidth:g} rad/s must be above 0 rad/s")
    if not (math.isfinite(level.flux) and level.flux > 0 and level.turned >= LEAST_TURN):
        raise InputError(f"no gains for {kind} follow from a record in which the voltages turn by about "
                         f"{math.degrees(level.turned):.0f} degrees; it takes 180: give all gains with --gain, or a study with "
                         f"[observers.{kind}.gains] as --machine")
    natural_decay = machine.R_s / machine.sigma
    k_1 = max(2 * DAMPING * bandwidth - natural_decay, 0.0)
    K_p = (bandwidth / (machine.beta * level.flux)) ** 2
    loop = FLUX_LOOPS * (k_1 + natural_decay)
    machine_decay = machine.gamma + machine.alpha
    k = math.sqrt(machine_decay / natural_decay)
    if kind == "baseline_scheduled":
        K_p = (min(bandwidth, k * machine_decay / (2 * DAMPING)) / (machine.beta * level.flux)) ** 2
    k_2 = loop / max(abs(level.stator_frequency), 1.0)
    values = {
        "k_1": k_1, "kappa": loop, "k_2": k_2, "k_3": loop, "K_p": K_p, "g": ALPHA_SHARE * K_p,
        "alpha_l": machine.alpha / 2, "delta": machine.alpha / 10, "l_1": k_1, "l_2": 0.0, "l_3": 0.0, "l_4": 0.0, "h": K_p,
        "h_s": resistance_gain(machine.alpha, machine.sigma, k_1 + machine_decay, machine.L_m, level.flux),
        "P_0": resistance_power(machine.alpha, machine.L_m, level.flux),
        "k": k, "eta": FORGETTING, "S_0": EXCITED_SHARE * (machine.beta * level.flux) ** 2,
    }
    return {name: values[name] for name in observer.gains}
