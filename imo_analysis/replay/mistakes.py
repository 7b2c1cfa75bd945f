"""What was mistaken in a record that does not fit its machine: units, line-to-line voltages, swapped phases, the speed.

Each mistake is undone on the stretch of the record with the most in it; the one that makes the record fit is named.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.replay.check import Fit, fit, level
from imo_analysis.replay.gains import LEAST_TURN, default_bandwidth, default_gains
from imo_analysis.replay.kernel import replay_kernel
from imo_analysis.replay.logs import Samples
from imo_analysis.replay.survey import Survey
from imo_analysis.simulation.run import BOUND

_NAMED_FACTOR, _NAMED_SHARE = 0.2, 0.9
_TURN = cmath.exp(2j * math.pi / 3)
_LINE = cmath.exp(1j * math.pi / 6) * math.sqrt(3)


@dataclass(frozen=True)
class Mistake:
    """A mistake, and what undoes it.

    Attributes
    ----------
    text : str
        In words, with the flag that puts it right.
    u : complex
        Factor of the voltages, relative to the currents.
    swap : bool
        Whether the q axis of the voltages is to be reversed.
    time, speed : float
        Factors of time and measured speed.
    """

    text: str
    u: complex = 1.0
    swap: bool = False
    time: float = 1.0
    speed: float = 1.0


NONE = Mistake("nothing")
MISTAKES = (
    Mistake("currents in mA were taken for A (--unit current=mA), or voltages in kV for V (--unit voltage=kV)", 1e3),
    Mistake("currents in A were taken for mA (--unit current=A), or voltages in mV for V (--unit voltage=mV)", 1e-3),
    Mistake("line-to-line voltages were taken for phase voltages (--column uab=NAME --column ubc=NAME)", 1 / _LINE),
    Mistake("phase voltages were taken for line-to-line voltages (--column ua=NAME --column ub=NAME --column uc=NAME)", _LINE),
    Mistake("line-to-line voltages ac, ba, cb were taken for phase voltages", 1 / _LINE.conjugate()),
    Mistake("the currents (or the voltages) have the wrong sign", -1.0),
    Mistake("the phases of the currents are shifted by one against those of the voltages", _TURN),
    Mistake("the phases of the currents are shifted by one against those of the voltages", 1 / _TURN),
    # the mirrored machine turns the other way: which of the two is swapped shows only in a recorded speed
    *(Mistake("two phases of the voltages are swapped (or, if no speed was read, of the currents)", turn, swap=True)
      for turn in (1.0, _TURN, 1 / _TURN)),
    *(Mistake("two phases of the currents are swapped", turn, swap=True, speed=-1.0) for turn in (1.0, _TURN, 1 / _TURN)),
    Mistake("the time is in ms but was taken for s (--unit time=ms)", time=1e-3),
    Mistake("the time is in us but was taken for s (--unit time=us)", time=1e-6),
    Mistake("the time is in s but was taken for ms (--unit time=s)", time=1e3),
    Mistake("the speed is in rpm but was taken for rad/s (--unit speed=rpm)", speed=math.pi / 30),
    Mistake("the speed is in rad/s but was taken for rpm (--unit speed=rad/s)", speed=30 / math.pi),
    Mistake("the speed is in Hz but was taken for rad/s (--unit speed=Hz)", speed=2 * math.pi),
    Mistake("the speed has the wrong sign, or two phases of both voltages and currents are swapped", speed=-1.0),
)


def mistakes(n_p: int, has_speed: bool) -> list[Mistake]:
    """What to try for a machine of ``n_p`` pole pairs."""
    known = [m for m in MISTAKES if has_speed or m.speed == 1.0]
    if has_speed and n_p > 1:
        known += [
            Mistake("an electrical speed was taken for a mechanical one (--column omega=NAME)", speed=1 / n_p),
            Mistake("a mechanical speed was taken for an electrical one (--column omega_m=NAME)", speed=float(n_p)),
        ]
    return known


def check(stretch: Samples, survey: Survey, machine: InductionMachine) -> Fit | None:
    """Whether the record fits the machine; None where nothing turns and so nothing can be said.

    The speed is the measured one; where there is none, that of the repaired observer, which follows where the record fits.

    Raises
    ------
    InputError
        If it does not fit; with the mistake that would explain it, where one does.
    """
    u, i = stretch.u_ds + 1j * stretch.u_qs, stretch.i_ds + 1j * stretch.i_qs
    T = survey.sample_time
    now = level(u, i, T, machine)
    if now.turned < LEAST_TURN:
        return None
    base = _undone(NONE, stretch, T, machine)
    if base.good():
        return base
    # a wrong guess may overflow; its fit is then NaN and it is not named
    with np.errstate(all="ignore"):
        tried = [(_undone(m, stretch, T, machine), m) for m in mistakes(machine.n_p, stretch.omega is not None)]
    named = [(abs(found.factor - 1), mistake.text) for found, mistake in tried if found.good(_NAMED_FACTOR, _NAMED_SHARE)]
    size, turn = abs(base.factor), math.degrees(cmath.phase(base.factor))
    text = (
        f"the record does not fit the machine {machine.name!r}: by its equations the currents account for "
        f"{100 * max(base.share, 0):.0f} % of the voltages, which are {size:.3g} times what they should be and turned by "
        f"{turn:.0f} degrees"
    )
    why = f"It would fit if {min(named)[1]}" if named else "Check columns, units, the machine's parameters and its pole pairs"
    raise InputError(f"{text}. {why}. --trust runs it all the same")


def _undone(mistake: Mistake, stretch: Samples, T: float, machine: InductionMachine) -> Fit:
    u = stretch.u_ds + 1j * stretch.u_qs
    u = mistake.u * (u.conj() if mistake.swap else u)
    i = stretch.i_ds + 1j * stretch.i_qs
    T = T * mistake.time
    if stretch.omega is not None:
        omega = stretch.omega * mistake.speed
        return fit(u, i, omega, T, machine)
    omega = _estimated_speed(u, i, T, machine)
    return fit(u, i, omega, T, machine) if np.isfinite(omega).all() else Fit(complex(math.nan, math.nan), 0.0)


def _estimated_speed(u: np.ndarray, i: np.ndarray, T: float, machine: InductionMachine) -> np.ndarray:
    """The speed by the repaired observer with the gains of `replay_gains`; NaN where it diverges."""
    now = level(u, i, T, machine)
    if now.flux <= 0:
        return np.full(len(u), np.nan)
    gains = default_gains("repaired", machine, now, default_bandwidth(machine, now, T))
    x = np.array([i[0].real, i[0].imag, i[0].real, i[0].imag, i[0].real, i[0].imag, machine.alpha, 0.0])
    steps = np.full(len(u) - 1, T)
    out = np.full((len(u), len(x)), np.nan)
    out[0] = x
    substeps = max(1, math.ceil((gains["k_1"] + machine.gamma) * T / 0.5))
    direction = np.full(len(steps), 1.0 if now.stator_frequency >= 0 else -1.0)
    replay_kernel("repaired")(
        x, *(np.ascontiguousarray(v) for v in (u.real, u.imag, i.real, i.imag)), steps, np.full(len(steps), substeps),
        direction, False, False, 1.0, 1.0, BOUND, machine.observer_parameters,
        tuple(gains[name] for name in OBSERVERS["repaired"].gains), out[1:],
    )
    return np.ascontiguousarray(out[:, -1])
