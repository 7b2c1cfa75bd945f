"""How a speed step looks to the adaptation of alpha: the current loop rounds it, and the estimate of the speed follows late.

At constant flux alpha_hat moves with omega_hat, not with omega (claim ``resting.drift``), and slip goes with omega'. So what
a step adds is the integral of omega' omega_hat', and by Parseval

    int omega' omega_hat' dt = (1 / pi) int_0^inf |a(j nu)|^2 Re G(j nu) d nu,

with a the acceleration that the drive makes of the step through its speed and current loops, and G from omega to omega_hat,
linearised with alpha_hat held. The paper's observer feeds z back by k_2 omega_hat: the faster it turns, the later it follows.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError

if TYPE_CHECKING:
    from imo_analysis.study import Study

_ROUNDING = 1e-9  # of a matrix: what counts as zero
_FREQUENCIES = np.concatenate([[1e-6], np.geomspace(1e-2, 1e5, 3000)])  # over the speed loop's bandwidth


def seen_share(study: Study, observer: str, before: float, after: float) -> float:
    """int omega' omega_hat' dt of an unlimited step, over int omega'^2 dt of a first-order one without a current loop.

    Parameters
    ----------
    study : Study
        Gives machine, drive and the gains of ``observer``.
    before, after : float
        The step, electrical rad/s. G is taken at the mean speed with the weight omega'^2, which is a third of the way.

    Returns
    -------
    float
        1 where the observer has no linearisation in the frame of the flux, or an unstable one: nothing is known of it then.
    """
    drive = study.drive
    nu = _FREQUENCIES * drive.speed_bandwidth
    follows = _following(study, observer, after - (after - before) * 2 / 3, nu)
    if follows is None:
        return 1.0
    s, w = 1j * nu, drive.speed_bandwidth
    current = drive.current_bandwidth / (s + drive.current_bandwidth)
    acceleration = current * (w * s + w * w) / (s * s + current * (2 * w * s + w * w))
    seen = np.trapezoid(np.abs(acceleration) ** 2 * follows.real, nu) / math.pi
    return float(seen / (w / 2))


def _following(study: Study, observer: str, omega: float, nu: np.ndarray) -> np.ndarray | None:
    """G(j nu) at a speed without load; None where there is none that is stable."""
    from imo_analysis.pencils.error import OperatingPoint, arguments
    from imo_analysis.pencils.jacobian import jacobian

    settings = study.observers[observer]
    if not {"alpha_hat", "omega_hat"} <= set(OBSERVERS[settings.kind].states):
        return None
    try:
        derived = jacobian(settings.kind, "full")
    except InputError:  # its feedback changes when the axes turn
        return None
    point = OperatingPoint(omega, study.drive.flux, 0.0)
    whole = derived.evaluate(arguments(derived, study.machine, settings.gains, point))
    n = len(derived.states)
    kept = [k for k, state in enumerate(derived.states) if state != "alpha_tilde"]
    A, b = whole[np.ix_(kept, kept)], whole[kept, n + derived.inputs.index("omega_dot")]
    if np.linalg.eigvals(A).real.max() > _ROUNDING * np.abs(A).max():
        return None
    s = 1j * nu + _ROUNDING * np.abs(A).max()  # off the offsets that turn with the frame and that no current shows
    errors = np.linalg.solve(s[:, None, None] * np.eye(len(kept)) - A, np.broadcast_to(b[:, None], (len(nu), len(kept), 1)))
    answer: np.ndarray = 1 - s * errors[:, [derived.states[k] for k in kept].index("omega_tilde"), 0]
    return answer

