"""The loops that an observer's gains make, and the gains that make given loops: the same four numbers for the whole family.

With b = beta |phi|, ``omega_n`` is the natural frequency of the speed loop, K_p b^2 = omega_n^2; ``current`` is the decay a of
the current error that it works through; and the flux errors are fed back with the strength D, in 1/s^2, of which one part is
constant and one grows with the speed (`imo_analysis.pencils.pole_rule`):

    repaired        k_1 = a - R_s/sigma                 alpha k_3 = D_0     kappa = D_1             K_p = (omega_n / b)^2
    consistent_12   the same, with k_2 omega^2 in place of kappa |omega|: k_2 = D_1 / (middle of the range of speeds)
    quiet, across,  k_1 = a - gamma - alpha, since alpha_hat (1 + beta L_m) i_hat adds to the decay; the rest alike
      supervised
    baseline        l_1 = a - gamma - alpha,  l_3 = (X - R_s/sigma - l_1) / beta with alpha X = D_0,  h = (omega_n / b)^2
    baseline_       as baseline; h_s from a (`imo_analysis.replay.gains.resistance_gain`)
      resistance
    baseline_       as that; P_0 from alpha and the flux alone (`imo_analysis.replay.gains.resistance_power`)
      turned
    scheduled       k = a / (gamma + alpha),  h = (omega_n / b)^2
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from imo_analysis.machine import InductionMachine
from imo_analysis.replay.gains import resistance_gain, resistance_power

QUIET = ("quiet", "across", "supervised")
ADAPTIVE = ("consistent_12", "repaired", *QUIET)
TUNABLE = ("baseline", "baseline_scheduled", *ADAPTIVE)
ADAPTS_R_S = ("baseline_resistance", "baseline_turned")
RULED = (*TUNABLE, *ADAPTS_R_S)  # kinds that the rule of thumb has gains for


@dataclass(frozen=True)
class Loops:
    """The four numbers; floats, or arrays of one shape.

    Attributes
    ----------
    omega_n : float or ndarray
        Natural frequency of the speed loop in rad/s.
    current : float or ndarray
        Decay of the current error in 1/s.
    constant, rising : float or ndarray
        Feedback of the flux errors: in 1/s^2, and in 1/s^2 per rad/s of speed.
    """

    omega_n: Any
    current: Any
    constant: Any
    rising: Any


def least_current(machine: InductionMachine, kind: str) -> float:
    """The decay a that no current feedback at all leaves, in 1/s: gains below zero are not used."""
    if kind.startswith("baseline") or kind in QUIET:
        return machine.gamma + machine.alpha
    return machine.R_s / machine.sigma


def gains_of(machine: InductionMachine, kind: str, flux: float, loops: Loops, middle: float) -> dict[str, Any]:
    """The gains that make the loops, without those of the adaptation of alpha.

    Parameters
    ----------
    machine : InductionMachine
        As the observer believes it to be.
    kind : str
        One of `RULED`.
    flux : float
        Magnitude of the rotor flux in Wb.
    loops : Loops
        What to make.
    middle : float
        Speed in rad/s at which k_2 omega^2 is what kappa |omega| would be.
    """
    speed = (loops.omega_n / (machine.beta * flux)) ** 2
    feedback = loops.current - least_current(machine, kind)
    if kind in ("baseline", *ADAPTS_R_S):
        strength = loops.constant / machine.alpha
        l_3 = (strength - machine.R_s / machine.sigma - feedback) / machine.beta
        found = {"l_1": feedback, "l_2": 0.0 * feedback, "l_3": l_3, "l_4": 0.0 * feedback, "h": speed}
        if kind in ADAPTS_R_S:
            found["h_s"] = resistance_gain(machine.alpha, machine.sigma, loops.current, machine.L_m, flux)
        if kind == "baseline_turned":
            found["P_0"] = resistance_power(machine.alpha, machine.L_m, flux)
        return found
    if kind == "baseline_scheduled":
        return {"k": loops.current / (machine.gamma + machine.alpha), "h": speed}
    z = {"k_2": loops.rising / middle} if kind == "consistent_12" else {"kappa": loops.rising}
    return {"k_1": feedback, **z, "k_3": loops.constant / machine.alpha, "K_p": speed}
