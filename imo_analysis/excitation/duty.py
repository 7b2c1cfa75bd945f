"""Mixed duty: random speed steps and loads with current noise, to see which alpha_hat survives an hour of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING

from imo_analysis.errors import InputError
from imo_analysis.excitation.settling import seen_by_supervisor
from imo_analysis.excitation.supervision import between, ceiling, noise_floor
from imo_analysis.excitation.swing import shape_of

if TYPE_CHECKING:
    from imo_analysis.study import Study

KINDS = ("consistent_12", "repaired", "quiet", "across", "supervised")
LOADS = (0.0, 0.2, 0.5, 0.8)  # of the largest torque of the study; the rest is left for accelerating
_SPEEDS = 5  # evenly over the study's range
ETA = 1.0  # of the supervisor's filters, 1/s
REST = 0.03  # 1/s: what noise alone may move the supervised alpha_hat by over the whole run, on average
LEAST = 1.0  # A^2: S_0 without noise


def speeds_of(study: Study) -> list[float]:
    """The duty's electrical speeds in rad/s: over the range of ``tuning.omega``, for which a modulation is designed."""
    low, high = study.tuning.omega
    return [round(low + (high - low) * k / (_SPEEDS - 1), 3) for k in range(_SPEEDS)]


def loads_of(study: Study) -> list[float]:
    """The duty's loads in N m: `LOADS` of the study's largest."""
    return [float(f"{share * study.largest_torque:.6g}") for share in LOADS]


def mixed_duty(study: Study, duration: float, *, noise: float = 0.1, dwell: float = 20.0, seed: int = 1, depth: float = 0.0,
               frequency: float = 0.0, waveform: str = "sine", off: tuple[float, float] = (0.0, 0.0)) -> Study:
    """A study of random duty for the paper's observer and ours, side by side on the same noisy measurements.

    Parameters
    ----------
    study : Study
        Gives machine, drive and the gains of its observer of kind ``repaired``; all our observers take these.
    duration, dwell : float
        Length, and time between changes of speed and load, in s.
    noise : float
        Standard deviation of each current sample, in A.
    seed : int
        Of the duty and of the noise.
    depth, frequency : float
        Flux modulation: depth (1) and frequency (rad/s); none by default.
    waveform : str
        Of the flux reference that makes it.
    off : tuple of 2
        The modulation pauses from the first time to the second, in s.

    Returns
    -------
    Study
        Speeds of `speeds_of`, loads of `loads_of`, five observers, recorded every 0.1 s.

    Raises
    ------
    InputError
        If the study has no observer of kind ``repaired`` and ``consistent_12``, or the noise hides the modulation from the
        supervisor.
    """
    from imo_analysis.study import Study

    by_kind = {settings["kind"]: settings for settings in study.data["observers"].values()}
    if not {"repaired", "consistent_12"} <= set(by_kind):
        raise InputError("mixed duty needs an observer of kind repaired and one of kind consistent_12 in the study")
    draw, speeds, loads = Random(seed), speeds_of(study), loads_of(study)
    times = [round(k * dwell, 6) for k in range(max(1, int(duration / dwell)))]
    observers = {kind: {**by_kind.get(kind, by_kind["repaired"]), "kind": kind} for kind in KINDS}
    threshold = supervisor_threshold(study, by_kind["repaired"]["gains"], noise, duration, depth, frequency, waveform)
    observers["supervised"]["gains"] = observers["supervised"]["gains"] | {"eta": ETA, "S_0": threshold.S_0}
    reference = shape_of(waveform, frequency, study.drive, study.machine.alpha).reference if depth and frequency else 0.0
    data = {
        **{key: value for key, value in study.data.items() if key != "scenarios"},
        "title": f"mixed duty, {duration:g} s", "observers": observers,
        "reference": {"shape": "steps", "time": times, "omega": [draw.choice(speeds) for _ in times]},
        "load": {"shape": "steps", "time": times, "T_l": [draw.choice(loads) for _ in times]},
    }
    return Study.from_data(data).changed({
        "simulation.duration": duration, "simulation.record_every": 1000, "simulation.seed": seed,
        "sensors.current_noise": noise, "drive.flux_modulation": depth * study.drive.flux * reference,
        "drive.flux_modulation_frequency": frequency, "drive.flux_waveform": waveform, "drive.flux_modulation_off": list(off)})


@dataclass(frozen=True)
class Threshold:
    """Where S_0 lies, in A^2.

    Attributes
    ----------
    floor : float
        What noise alone makes of S, at the worst of the duty's speeds and loads.
    least : float
        From here on noise alone moves alpha_hat by at most `REST` over the run, on average.
    most : float
        Up to here the modulation opens the gate by `supervision.OPEN`; infinite without modulation.
    """

    floor: float
    least: float
    most: float

    @property
    def S_0(self) -> float:
        """As many times above the least as below the most, to three digits; the least without modulation."""
        return float(f"{between(self.least, self.most) if math.isfinite(self.most) else self.least:.3g}")


def supervisor_threshold(study: Study, gains: Mapping[str, float], noise: float, duration: float, depth: float = 0.0,
                         frequency: float = 0.0, waveform: str = "sine") -> Threshold:
    """What noise and a modulation ask of the supervisor's threshold over the speeds and loads of `mixed_duty`.

    Raises
    ------
    InputError
        If the least is above the most.
    """
    floor, least, most = 0.0, LEAST, math.inf
    if noise > 0:
        floors = [noise_floor(study.machine, gains, study.drive, noise, omega, torque, ETA, study.simulation.sample_time)
                  for omega in study.tuning.omega for torque in (0.0, max(loads_of(study)))]
        floor = max(one.across for one in floors)
        least = max(one.threshold(gains["g"], REST / duration) for one in floors)
    if depth and frequency:
        shape = shape_of(waveform, frequency, study.drive, study.machine.alpha)
        most = ceiling(seen_by_supervisor(study.machine, study.drive.flux, depth, frequency, shape))
    if least > most:
        raise InputError(f"noise = {noise:g} A asks for S_0 above {least:.3g} A^2, and the modulation of {100 * depth:.3g} % "
                         f"at {frequency:.4g} rad/s allows {most:.3g} A^2 at most; modulate deeper or faster")
    return Threshold(floor, least, most)
