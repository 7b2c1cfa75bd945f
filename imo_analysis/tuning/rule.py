"""The rule of thumb: gains from wished times, flux and machine by formulas alone.

With b = beta |phi|, the wished settling time t_s of the speed estimate, the wished recovery time t_r of everything else (the
flux above all), a lag t_l behind accelerations that is still good (rad/s for 1 rad/s^2) and a damping zeta:

    omega_n = max(4.6 / (zeta t_s), 1000 zeta / t_r, 2 zeta / t_l, a_0 / (2 zeta))    of the speed loop, rad/s
    a       = 2 zeta omega_n    decay of the current error, 1/s; a_0 what it is without feedback, R_s/sigma or gamma + alpha
    K_p     = (omega_n / b)^2
    k_1     = a - R_s/sigma                              quiet, across, supervised: a - gamma - alpha
    k_3     = 8 a / (alpha t_r)
    kappa   = alpha k_3 / (20 omega_max)                 or 0; consistent_12: k_2 = kappa / omega_max
    g       = K_p alpha mu |phi|^2 / (20 L_m S)          S: integral of the squared acceleration of a usual speed step

Why. The speed error works on the current error along v_2 and back, a loop of second order: omega_n and a. The flux error w,
which turns with the stator frequency omega_s in the frame of the flux, is felt along v_2 too; the speed loop is fast and
takes that part for speed, so that only the other part drives a current, and w decays at half of D / a, D = alpha k_3 + kappa
|omega|. So D = 2 a (4 / t_r). A speed error leaves D / omega_n^2 of itself in w; that this stays below 2 %, with a quarter to
spare, is the second bound on omega_n. A constant D needs no direction of rotation; kappa buys a faster recovery at high speed
only, and is kept above zero for the Lyapunov function's sake. And g: alpha_hat moves with every change of speed
(`imo_analysis.equations.drift`), here by 5 % of alpha.

How far it is right (`imo_analysis.tuning.check`, 1200 machines, right parameters, damping 0.7): where the stator frequency
nowhere falls below 1.5 times 4 / t_r, load included, the repaired observer recovers in 0.96 to 1 times t_r and its speed
estimate settles within 1.02 t_s. Where besides it stays above 3 times 4 / t_r and the speed below a / 4, the noise is that
promised below to within a fifth, and the lag at most 1.5 t_l. Parameter errors are not in it: 20 % of R_r lengthen t_r by a
quarter.

Where it fails. w cannot decay faster than it turns: t_r >= 4 / min |omega_s|, load included. It takes a for much larger than
the speed, and a cannot be below a_0: where that decides, omega_n goes with it, and t_s comes out shorter than wished.

The baseline: a and h as k_1 and K_p there; its flux error decays with the rotor's own alpha, whatever is asked. With
X = a / 2 the frozen-speed poles of the flux turn at half the speed, as far from the axis as constant gains get them, and a
speed error leaves about |omega| X / omega_n^2 of itself, zeta / 18 here:

    omega_n = max(4.6 / (zeta t_s), 18 omega_max, 2 zeta / t_l, a_0 / (2 zeta)),
     l_1 = a - gamma - alpha,  l_3 = (a/2 - R_s/sigma - l_1) / beta,  h as K_p

and with Kubota's gain scheduled on the speed ``k = sqrt((gamma + alpha) sigma / R_s)``, omega_n what ``a = k (gamma + alpha)``
then allows (`imo_analysis.replay.gains`).

The noise of the speed estimate, for white noise of deviation n on the currents, sampled every T: what the speed loop lets
through, and at high speed what R_s/sigma times that noise has left in w (not in the baselines),

    n sqrt(T) / b  sqrt(omega_n^2 (omega_n^2 + (gamma + alpha)^2) / (2 a) + (omega R_s/sigma)^2 t_r / 8)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from imo_analysis.equations.drift import drift_of_acceleration
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.tuning.loops import TUNABLE, Loops, gains_of, least_current

DAMPING = 0.7
ALPHA_DRIFT = 0.05  # of alpha, for a step by 0.4 of the range of speeds: with it the paper's machine gets the paper's own share
_SETTLED = 4.6  # time constants: a second-order system is within 2 % after 4, and what w adds wants more
_RISING = 0.05  # of D at the largest speed: what kappa adds
_FAR = 18  # times the largest speed: how fast the baseline's speed loop must be for little to be left in the flux


@dataclass(frozen=True)
class Times:
    """What is asked of the rule.

    Attributes
    ----------
    settling, recovery : float
        t_s and t_r in s.
    omega_max : float
        Largest abs(speed) in rad/s.
    damping : float
        zeta.
    lag : float
        t_l in s; infinite for any.
    speed_bandwidth : float
        Of the drive's speed loop in rad/s, for the share of alpha.
    fastest : float
        The largest omega_n in rad/s, where samples bear no more; the other wishes then yield. Infinite for any.
    """

    settling: float
    recovery: float
    omega_max: float
    damping: float = DAMPING
    lag: float = math.inf
    speed_bandwidth: float = 45.0
    fastest: float = math.inf

    def __post_init__(self) -> None:
        for name, unit in (("lag", "s"), ("fastest", "rad/s")):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} = {getattr(self, name):g} {unit} must be above 0")
        for name, unit in (("settling", "s"), ("recovery", "s"), ("omega_max", "rad/s"), ("damping", ""),
                           ("speed_bandwidth", "rad/s")):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} = {value:g} {unit} must be above 0".replace("  ", " "))


def rule_loops(machine: InductionMachine, kind: str, times: Times) -> Loops:
    """The loops that the rule makes.

    Raises
    ------
    InputError
        If there is no rule for this kind.
    """
    if kind not in TUNABLE:
        raise InputError(f"observer kind {kind!r} has no tuning rule; choose one of: {', '.join(TUNABLE)}")
    zeta = times.damping
    if kind == "baseline_scheduled":
        current = math.sqrt((machine.gamma + machine.alpha) ** 3 * machine.sigma / machine.R_s)
        return Loops(min(_SETTLED / (zeta * times.settling), current / (2 * zeta), times.fastest), current, 0.0, 0.0)
    far = _FAR * times.omega_max if kind == "baseline" else 1000 * zeta / times.recovery
    least = least_current(machine, kind)
    omega_n = min(max(_SETTLED / (zeta * times.settling), far, 2 * zeta / times.lag, least / (2 * zeta)), times.fastest)
    current = max(2 * zeta * omega_n, least)
    if kind == "baseline":
        return Loops(omega_n, current, machine.alpha * current / 2, 0.0)
    constant = 8 * current / times.recovery
    return Loops(omega_n, current, constant, _RISING * constant / times.omega_max)


def rule_gains(machine: InductionMachine, kind: str, flux: float, times: Times) -> dict[str, float]:
    """Every gain of an observer by the rule; those that it says nothing of at their usual values.

    alpha_l and delta of the projection (10) are half and a tenth of the believed alpha; a supervisor forgets in 1 s and opens
    at a flux that swings by 6 % of itself within 1 / alpha.
    """
    if not (math.isfinite(flux) and flux > 0):
        raise InputError(f"flux = {flux:g} Wb must be above 0 Wb to choose gains")
    found = {name: float(value) for name, value in
             gains_of(machine, kind, flux, rule_loops(machine, kind, times), times.omega_max).items()}
    return found | alpha_gains(machine, kind, flux, found.get("K_p", 0.0), times)


def alpha_gains(machine: InductionMachine, kind: str, flux: float, K_p: float, times: Times) -> dict[str, float]:
    """The gains of the adaptation of alpha: g from the drift that a speed step may cause, the others at their usual values."""
    if kind.startswith("baseline"):
        return {}
    step = 0.4 * times.omega_max
    drift = drift_of_acceleration(step * step * times.speed_bandwidth / 2, 0.0, flux, machine.L_m, machine.mu, 1.0, 1.0)
    more = {"g": ALPHA_DRIFT * machine.alpha / drift * K_p, "alpha_l": machine.alpha / 2, "delta": machine.alpha / 10}
    if kind == "supervised":
        more |= {"eta": 1.0, "S_0": 4e-3 * (machine.beta * flux) ** 2}
    return more


def rule_noise(machine: InductionMachine, kind: str, flux: float, times: Times, omega: float) -> float:
    """What the rule says of the noise at a speed: deviation in rad/s for noise of density 1 A^2 s on the currents."""
    loops = rule_loops(machine, kind, times)
    square = loops.omega_n**2 * (loops.omega_n**2 + (machine.gamma + machine.alpha) ** 2) / (2 * loops.current)
    if not kind.startswith("baseline"):
        square += (omega * machine.R_s / machine.sigma) ** 2 * times.recovery / 8
    return float(math.sqrt(square) / (machine.beta * flux))
