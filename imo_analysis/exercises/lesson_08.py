"""Exercises of lesson 8: errors measured in Fig. 3, the drift of alpha_hat over a step, a modulation against it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from imo_analysis.equations import drift
from imo_analysis.exercises.exercise import Choice, Exercise, Judged, Number
from imo_analysis.exercises.lesson_01 import FLUX, MACHINE
from imo_analysis.quantity import si_value
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study

WINDOW = (59.1, 59.5)  # s, of Fig. 3(b)
KEYS = ("drive.flux_modulation", "drive.flux_modulation_frequency")
LARGEST, FASTEST, NEAR = 0.15, 60.0, 0.1  # Wb, rad/s, 1/s


@cache
def _run(scenario: str) -> Any:
    return simulate(Study.paper().scenario(scenario))


def _errors(observer: str) -> Any:
    window = _run("fig3").sel(time=slice(*WINDOW))
    return (window.omega - window.omega_hat.sel(observer=observer)).values


def _rms(observer: str) -> float:
    return float(np.sqrt(np.mean(_errors(observer) ** 2)))


def _peak(observer: str) -> float:
    return float(np.abs(_errors(observer)).max())


def _largest_rms() -> str:
    return max(("baseline", "consistent_12", "repaired"), key=_rms)


def _drift(K_p: float = 100.0, load: float = 0.0) -> float:
    step = _run("fig4").sel(time=slice(59.0, 60.0))
    time = step.time.values
    square = float(np.trapezoid(np.gradient(step.omega.values, time) ** 2, time))
    return float(drift.drift_of_acceleration(square, load, FLUX, MACHINE.L_m, MACHINE.mu, 1.0, K_p))


def _modulation(answer: Any) -> str:
    if not isinstance(answer, Mapping) or set(answer) != set(KEYS):
        return f"A dictionary with the keys {' and '.join(KEYS)} is asked for."
    depth, frequency = (si_value(answer[key], unit, key) for key, unit in zip(KEYS, ("Wb", "rad/s"), strict=True))
    if not (0 <= depth <= LARGEST and 0 <= frequency <= FASTEST):
        return f"The modulation must be 0 .. {LARGEST} Wb, its frequency 0 .. {FASTEST:g} rad/s."
    run = simulate(Study.paper().scenario("fig4").changed(dict(zip(KEYS, (depth, frequency), strict=True))))
    alpha_hat = run.alpha_hat.sel(observer="repaired", time=slice(59.5, 60.0)).values
    off = float(np.abs(alpha_hat - MACHINE.alpha).max())
    if off <= NEAR:
        return ""
    if depth * frequency == 0:
        return f"Without modulation alpha_hat is off by {off:.2f} 1/s: nothing pulls it back."
    return f"alpha_hat is still off by up to {off:.2f} 1/s: it comes back too slowly after the last step, or ripples."


EXERCISES: tuple[Exercise, ...] = (
    Number(
        "8.1", lambda: _peak("baseline"), "rad/s",
        ((lambda _: _peak("consistent_12"), "That is the observer of (12)."),
         (lambda _: _peak("repaired"), "That is the repaired observer."),
         (lambda _: _rms("baseline"), "That is the root mean square; the largest value is asked for."),
         (lambda _: float(_errors("baseline").max()), "That is the largest error upwards; take absolute values first.")),
        "", "Absolute value of the difference, then the largest, in the window.", tolerance=0.005),
    Choice(
        "8.2", _largest_rms,
        {"baseline": "That has the largest peak; its error lasts as long as the acceleration and is gone.",
         "consistent_12": "",
         "repaired": "That one is the smallest by either metric."},
        "Smaller at its worst, but it lasts: one picture, two stories."),
    Number(
        "8.3", _drift, "1/s",
        ((lambda d: d * 100, "Divide by K_p = 100."),
         (lambda d: d * FLUX, "The flux comes squared: once in the torque, once in the slip."),
         (lambda _: _drift() * MACHINE.mu, "mu is missing: the torque per acceleration goes with J."),
         (lambda d: d / MACHINE.n_p**2, "omega is electrical throughout; no pole pairs are to be divided out.")),
        "Upwards, whether the step goes up or down.", "g / K_p times L_m / (mu psi^2) times the integral.", tolerance=0.02),
    Judged(
        "8.4", _modulation,
        (({KEYS[0]: 0.0, KEYS[1]: 20.0}, "nothing pulls it back"), ({KEYS[0]: 0.01, KEYS[1]: 10.0}, "still off"),
         ({KEYS[0]: 0.4, KEYS[1]: 20.0}, "The modulation must be"), ({KEYS[0]: 0.1, KEYS[1]: 300.0}, "its frequency"),
         ({"observers.repaired.initial.alpha_hat": 9.9354},
          "A dictionary with")),
        "The same observer, the same gains: only the signals changed."),
)
