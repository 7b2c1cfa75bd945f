"""Mixed duty: random speed steps and loads with current noise, to see which alpha_hat survives an hour of it."""

from __future__ import annotations

from random import Random
from typing import TYPE_CHECKING

from imo_analysis.errors import InputError

if TYPE_CHECKING:
    from imo_analysis.study import Study

KINDS = ("consistent_12", "repaired", "quiet", "across", "supervised")
SUPERVISOR = {"eta": 1.0, "S_0": 100.0}  # 0.1 A of noise leaves S at 0.2 A^2, a modulation of 1.6 % at 136 rad/s makes 640


def mixed_duty(study: Study, duration: float, *, noise: float = 0.1, dwell: float = 20.0, seed: int = 1, depth: float = 0.0,
               frequency: float = 0.0, off: tuple[float, float] = (0.0, 0.0)) -> Study:
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
    off : tuple of 2
        The modulation pauses from the first time to the second, in s.

    Returns
    -------
    Study
        Speeds 20 to 100 rad/s, load 0 to 8 N m, five observers, recorded every 0.1 s.

    Raises
    ------
    InputError
        If the study has no observer of kind ``repaired`` and ``consistent_12``.
    """
    from imo_analysis.study import Study

    by_kind = {settings["kind"]: settings for settings in study.data["observers"].values()}
    if not {"repaired", "consistent_12"} <= set(by_kind):
        raise InputError("mixed duty needs an observer of kind repaired and one of kind consistent_12 in the study")
    draw = Random(seed)
    times = [round(k * dwell, 6) for k in range(max(1, int(duration / dwell)))]
    observers = {kind: {**by_kind.get(kind, by_kind["repaired"]), "kind": kind} for kind in KINDS}
    observers["supervised"]["gains"] = observers["supervised"]["gains"] | SUPERVISOR
    flux = study.drive.flux
    lag = (1 + (frequency / study.drive.flux_bandwidth) ** 2) ** 0.5
    data = {
        **{key: value for key, value in study.data.items() if key != "scenarios"},
        "title": f"mixed duty, {duration:g} s", "observers": observers,
        "reference": {"shape": "steps", "time": times, "omega": [draw.choice((20.0, 40.0, 60.0, 80.0, 100.0)) for _ in times]},
        "load": {"shape": "steps", "time": times, "T_l": [draw.choice((0.0, 2.0, 5.0, 8.0)) for _ in times]},
    }
    return Study.from_data(data).changed({
        "simulation.duration": duration, "simulation.record_every": 1000, "simulation.seed": seed,
        "sensors.current_noise": noise, "drive.flux_modulation": depth * flux * lag,
        "drive.flux_modulation_frequency": frequency, "drive.flux_modulation_off": list(off)})
