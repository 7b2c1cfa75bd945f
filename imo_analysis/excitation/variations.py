"""How the end value of alpha_hat moves with gains, steps, load and drive: predicted from the study, and simulated.

`variations` is of one step of the speed: the prediction is that of `resting.predict_steps`, started from the simulated value
before the step, so that it tells of the step alone. `landings` is of the start: the prediction is `landing.landing`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from imo_analysis.equations.catalogue import OBSERVERS

if TYPE_CHECKING:
    from imo_analysis.study import Study

SETTLED, END = 6.0, 10.0  # s: the step, and the end of each run
RESTED = 2.0  # s after a start, in which the copies of z come to rest


@dataclass(frozen=True)
class Variation:
    """What was changed, and what the step then adds to alpha_hat, or how far off the truth the start leaves it, in 1/s."""

    what: str
    predicted: float
    simulated: float


def variations(study: Study, observer: str, before: float = 40.0, after: float = 100.0) -> list[Variation]:
    """The drift of alpha_hat in one speed step, for the study and for one thing changed at a time.

    Parameters
    ----------
    study : Study
        With an adaptive observer of the name ``observer`` whose gains are g and K_p.
    before, after : float
        The step, in electrical rad/s.

    Raises
    ------
    InputError
        As `resting.predict_steps`.
    """
    gains = study.observers[observer].gains
    steps = {"reference.time": [0.0, SETTLED], "reference.omega": [before, after], "reference.shape": "steps"}
    base: dict[str, Any] = {
        "simulation.duration": END, "simulation.record_every": 100, "load.time": [0.0], "load.T_l": [0.0], **steps}
    w = study.drive.speed_bandwidth
    half, load = (before + after) / 2, study.largest_torque / 2
    changes: dict[str, Mapping[str, Any]] = {
        f"{before:g} to {after:g} rad/s, no load": {},
        "g doubled": {f"observers.{observer}.gains.g": 2 * gains["g"]},
        "K_p doubled": {f"observers.{observer}.gains.K_p": 2 * gains["K_p"]},
        f"half the step, {before:g} to {half:g} rad/s": {"reference.omega": [before, half]},
        f"back, {after:g} to {before:g} rad/s": {"reference.omega": [after, before]},
        "speed loop twice as fast": {"drive.speed_bandwidth": 2 * w},
        f"load of {load:.3g} N m": {"load.T_l": [load]},
        f"load of {load:.3g} N m, back": {"load.T_l": [load], "reference.omega": [after, before]},
    }
    bare = study.only([observer])
    return [_one(what, bare.changed({**base, **change}), observer) for what, change in changes.items()]


def _one(what: str, study: Study, observer: str) -> Variation:
    from imo_analysis.excitation.resting import predict_steps
    from imo_analysis.simulation.run import simulate

    alpha_hat = simulate(study)["alpha_hat"].sel(observer=observer)
    start = float(alpha_hat.sel(time=SETTLED - 0.1, method="nearest"))
    (step,) = predict_steps(study, observer, start)
    return Variation(what, step.drift, float(alpha_hat[-1]) - start)


def landings(study: Study, observer: str) -> list[Variation]:
    """alpha_hat less the true alpha after the start, for the study's first reference and for one thing changed at a time.

    Parameters
    ----------
    study : Study
        With an adaptive observer of the name ``observer`` whose gains are k_1, k_3, g and K_p.

    Raises
    ------
    InputError
        As `landing.landing`.
    Diverged
        If a run does.
    """
    from imo_analysis.excitation.landing import landing
    from imo_analysis.simulation.run import simulate

    drive, gains, speed = study.drive, study.observers[observer].gains, study.reference.omega[0]
    own, load = f"observers.{observer}", study.largest_torque / 2
    first = dict(zip(OBSERVERS[study.observers[observer].kind].states, study.observers[observer].initial_values, strict=True))
    true, believed = study.machine.alpha, first["alpha_hat"]
    limit = (drive.current_limit + drive.flux / study.machine.L_m) / 2
    base: dict[str, Any] = {
        "simulation.record_every": 100, "reference.shape": "steps", "reference.time": [0.0], "reference.omega": [speed],
        "load.shape": "steps", "load.time": [0.0], "load.T_l": [0.0]}
    changes: dict[str, Mapping[str, Any]] = {
        f"start to {speed:g} rad/s from alpha_hat = {believed:.4g} /s": {},
        **({"from the true alpha": {f"{own}.initial.alpha_hat": true},
            f"from {2 * true - believed:.4g} /s": {f"{own}.initial.alpha_hat": 2 * true - believed}}
           if believed != true else {}),
        **({"to standstill": {"reference.omega": [0.0]},
            f"to {2.5 * speed:g} rad/s": {"reference.omega": [2.5 * speed]}} if speed else {}),
        **{f"{gain} {word}": {f"{own}.gains.{gain}": factor * gains[gain]}
           for gain in ("g", "k_1", "k_3", "K_p") for word, factor in (("doubled", 2.0), ("halved", 0.5))},
        **{f"flux loop {word}": {"drive.flux_bandwidth": factor * drive.flux_bandwidth}
           for word, factor in (("twice as fast", 2.0), ("half as fast", 0.5))},
        "speed loop twice as fast": {"drive.speed_bandwidth": 2 * drive.speed_bandwidth},
        f"current limit of {limit:.3g} A": {"drive.current_limit": limit},
        f"load of {load:.3g} N m": {"load.T_l": [load]},
    }
    found = []
    for what, change in changes.items():
        changed = study.only([observer]).changed({**base, **change})
        predicted = landing(changed, observer)
        run = simulate(changed.changed({"simulation.duration": predicted.time + RESTED}))
        found.append(Variation(what, predicted.alpha_hat - true, float(run["alpha_hat"].sel(observer=observer)[-1]) - true))
    return found
