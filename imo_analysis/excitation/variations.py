"""How the end value of alpha_hat moves with gains, steps, load and drive: predicted from the study, and simulated.

The prediction is that of `resting.predict_steps`, started from the simulated value before the step, so that it tells of the
step alone and not of how well the start identified alpha.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from imo_analysis.study import Study

SETTLED, END = 6.0, 10.0  # s: the step, and the end of each run


@dataclass(frozen=True)
class Variation:
    """What was changed, and what the step then adds to alpha_hat in 1/s: predicted and simulated."""

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
