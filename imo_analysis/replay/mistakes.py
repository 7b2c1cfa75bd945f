"""What was mistaken in a record that does not fit its machine: units, rms for peak, line-to-line voltages, phases, speed, rate.

Each mistake is undone on the stretch of the record with the most in it; the one that makes the record fit is named.

Of the parameters only the inductances move the size of `Fit.factor` much: L_m, L_s and L_r 20 % too large or small give 0.85
and 1.22, R_r half as large again or 30 % too small 0.97 and 1.04, R_s 30 % off 0.98 and 1.02. So a factor further off than
`DOUBTFUL` makes scales such as rms for peak be tried even where the record could pass for that of a saturated machine; one that
brings it to within `SCALED` of 1, with as large a share of the voltages, is named. No scale does that to a machine whose
inductances are 20 % off. Voltages and currents that are off by the same scale cannot be told from right ones: the equations are
linear in them.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.replay.channels import check_channels
from imo_analysis.replay.check import Fit, fit, level, stator_frequency
from imo_analysis.replay.gains import LEAST_TURN, default_bandwidth, default_gains
from imo_analysis.replay.kernel import replay_kernel
from imo_analysis.replay.logs import Samples
from imo_analysis.replay.start import flying_start
from imo_analysis.replay.survey import Survey
from imo_analysis.simulation.run import BOUND

_NAMED_FACTOR, _NAMED_SHARE = 0.2, 0.9
DOUBTFUL, SCALED, _AS_GOOD = 0.15, 0.1, 1e-3
# a rate is sought this far about that without slip, on so many samples; nearer to the one said it is not named
_SLIP, _RATE_SAMPLES, _OTHER_RATE = 0.15, 10_000, 0.05
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
SCALES = (
    Mistake("the voltages are rms values taken for peak values (multiply them by sqrt(2) = 1.414), or the currents sqrt(2) "
            "times too large", math.sqrt(2)),
    Mistake("the currents are rms values taken for peak values (multiply them by sqrt(2) = 1.414), or the voltages sqrt(2) "
            "times too large", 1 / math.sqrt(2)),
    Mistake("the voltages are sqrt(3) times too small (phase for line to line), or the currents sqrt(3) times too large",
            math.sqrt(3)),
    Mistake("the voltages are sqrt(3) times too large (line to line for phase), or the currents sqrt(3) times too small",
            1 / math.sqrt(3)),
    Mistake("the currents are 3/2 times too large (a Clarke transformation without its 2/3), or the voltages 2/3 of what "
            "they are", 1.5),
    Mistake("the voltages are 3/2 times too large (a Clarke transformation without its 2/3), or the currents 2/3 of what "
            "they are", 1 / 1.5),
)
MISTAKES = (
    *SCALES,
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


def mistakes(n_p: int, has_speed: bool, rate: float) -> list[Mistake]:
    """What to try for a machine of ``n_p`` pole pairs and a record of ``rate`` samples a second."""
    known = [m for m in MISTAKES if has_speed or m.speed == 1.0]
    if has_speed and n_p > 1:
        known += [
            Mistake("an electrical speed was taken for a mechanical one (--column omega=NAME)", speed=1 / n_p),
            Mistake("a mechanical speed was taken for an electrical one (--column omega_m=NAME)", speed=float(n_p)),
        ]
    if not has_speed:  # without one, a wrong rate looks like a wrong scale
        known += [Mistake(f"{_rate(rate / factor)}, or the scale of voltages or currents is off by {max(factor, 1 / factor):g}",
                          time=factor) for factor in (0.1, 0.5, 2.0, 10.0)]
    return known


def _rate(rate: float) -> str:
    digits = f"{float(f'{rate:.3g}'):g}"
    return f"there were {digits} samples a second (--rate {digits})"


def check(
    stretch: Samples, survey: Survey, machine: InductionMachine, voltage: str = "linear", path: str = "the record"
) -> Fit | None:
    """Whether the record fits the machine; None where nothing turns and so nothing can be said.

    The speed is the measured one; where there is none, that of the repaired observer, which follows where the record fits.

    Parameters
    ----------
    stretch : Samples
        Of the record.
    survey : Survey
        Of the record.
    machine : InductionMachine
        As the observers believe it to be.
    voltage : str
        What a sample of the voltage stands for, see `imo_analysis.replay.estimate.Treatment`.
    path : str
        The file, for error texts.

    Raises
    ------
    InputError
        If it does not fit; with the mistake that would explain it, where one does.
    """
    u, i = stretch.u_ds + 1j * stretch.u_qs, stretch.i_ds + 1j * stretch.i_qs
    T = survey.sample_time
    if max(level(u, i, T, machine).turned, abs(stator_frequency(i, T)) * T * len(stretch)) < LEAST_TURN:
        return None
    check_channels(stretch, path)
    base = _undone(NONE, stretch, T, machine, voltage)
    size, angle = abs(base.factor), math.degrees(cmath.phase(base.factor))
    if base.good():
        tried = _tried(SCALES, stretch, T, machine, voltage) if abs(base.factor - 1) > DOUBTFUL else []
        named = [(abs(found.factor - 1), mistake.text) for found, mistake in tried if found.good(SCALED, base.share - _AS_GOOD)]
        if not named:
            return base
        raise InputError(
            f"the record is not that of the machine {machine.name!r}: by its equations the voltages are {size:.3g} times what "
            f"the currents account for. It would fit if {min(named)[1]}; or the inductances are as far off. "
            "--trust runs it all the same"
        )
    tried = _tried(mistakes(machine.n_p, stretch.omega is not None, 1 / T), stretch, T, machine, voltage)
    named = [(abs(found.factor - 1), mistake.text) for found, mistake in tried if found.good(_NAMED_FACTOR, _NAMED_SHARE)]
    if not named and stretch.omega is not None and (ratio := _rate_that_fits(stretch, T, machine, voltage)):
        named = [(0.0, _rate(ratio / T))]
    text = (
        f"the record does not fit the machine {machine.name!r}: by its equations the currents account for "
        f"{100 * max(base.share, 0):.0f} % of the voltages, which are {size:.3g} times what they should be and turned by "
        f"{angle:.0f} degrees"
    )
    why = f"It would fit if {min(named)[1]}" if named else (
        "Check columns, units, the rate, the machine's parameters and its pole pairs")
    raise InputError(f"{text}. {why}. --trust runs it all the same")


def _tried(
    known: Sequence[Mistake], stretch: Samples, T: float, machine: InductionMachine, voltage: str
) -> list[tuple[Fit, Mistake]]:
    # a wrong guess may overflow; its fit is then NaN and it is not named
    with np.errstate(all="ignore"):
        return [(_undone(mistake, stretch, T, machine, voltage), mistake) for mistake in known]


def _rate_that_fits(stretch: Samples, T: float, machine: InductionMachine, voltage: str) -> float | None:
    """By how much the samples come faster than they were said to, if that makes the record fit its measured speed."""
    arrays = {name: value for name, value in vars(stretch).items() if isinstance(value, np.ndarray)}
    cut: dict[str, Any] = {name: value[-_RATE_SAMPLES:] for name, value in arrays.items()}
    few = replace(stretch, **cut)
    assert few.omega is not None

    u = few.u_ds + 1j * few.u_qs
    power = np.abs(u) ** 2
    turning = float((power * few.omega).sum()) * T
    if turning == 0:
        return None
    without_slip = float(power.sum()) * stator_frequency(u, T) * T / turning  # the period that it takes, over T

    def tried(share: float) -> Fit:
        return _undone(Mistake("", time=without_slip * share), few, T, machine, voltage)

    def miss(share: float) -> float:
        found = tried(share)
        return float(np.nan_to_num(abs(found.factor - 1) + 1 - found.share, nan=math.inf))

    if not 1e-3 < without_slip < 1e3:
        return None
    with np.errstate(all="ignore"):
        best = 1.0
        for wide in (_SLIP, _SLIP / 25):
            best = float(min(best + np.linspace(-wide, wide, 51), key=miss))
        # a little off, the rate stands in for anything that turns the voltages
        off = abs(math.log(without_slip * best)) > _OTHER_RATE
        return 1 / (without_slip * best) if off and tried(best).good(_NAMED_FACTOR, _NAMED_SHARE) else None


def _undone(mistake: Mistake, stretch: Samples, T: float, machine: InductionMachine, voltage: str) -> Fit:
    u = stretch.u_ds + 1j * stretch.u_qs
    u = mistake.u * (u.conj() if mistake.swap else u)
    i = stretch.i_ds + 1j * stretch.i_qs
    T = T * mistake.time
    if stretch.omega is not None:
        omega = stretch.omega * mistake.speed
        return fit(u, i, omega, T, machine, voltage)
    omega = _estimated_speed(u, i, T, machine)
    return fit(u, i, omega, T, machine, voltage) if np.isfinite(omega).all() else Fit(complex(math.nan, math.nan), 0.0)


def _estimated_speed(u: np.ndarray, i: np.ndarray, T: float, machine: InductionMachine) -> np.ndarray:
    """The speed by the repaired observer with the gains of `replay.gains`; NaN where it diverges."""
    now = level(u, i, T, machine)
    if now.flux <= 0:
        return np.full(len(u), np.nan)
    gains = default_gains("repaired", machine, now, default_bandwidth(machine, now, T))
    here = Samples(0, T * np.arange(len(u)), u.real, u.imag, i.real, i.imag, None, None)
    begun = flying_start(here, T, machine).values
    states = {"z_1_hat": i[0].real, "z_2_hat": i[0].imag, "xi_1_hat": i[0].real, "xi_2_hat": i[0].imag, **begun,
              "i_ds_hat": i[0].real, "i_qs_hat": i[0].imag, "alpha_hat": machine.alpha}
    x = np.array([float(states.get(name, 0.0)) for name in OBSERVERS["repaired"].states])
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
