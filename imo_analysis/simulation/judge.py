"""When an estimate is the speed: the one criterion, and the words for what else it may be.

- *tracks*: over the last `STRETCH` of a run the mean error is within `limit`, and the error's rms within `NOISY` times that;
- *is off*: its numbers are finite, but it does not track;
- *is lost*, or has diverged: its numbers left all bounds;
- *holds*, of a loop closed on an estimate: the estimate tracks, and the machine's speed ends within `limit` of the wanted one.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.observer import PARAMETERS

if TYPE_CHECKING:
    from imo_analysis.study import Study

OFF = 0.02  # of the speed: the largest mean error of an estimate that tracks
LEAST = 1.0  # rad/s: the limit at low speeds, where a share of the speed would be less than a share of the slip
NOISY = 5.0  # times the limit: the largest rms error
STRETCH = 0.5  # s, over which an estimate is judged
ROUNDED = 1e-3  # relative: as close as a study writes the true value of a parameter
R_S_OFF = 0.05  # relative error of the stator resistance that a loop closed on an estimate is asked to bear


def limit(omega: Any) -> Any:
    """The largest mean error in rad/s of an estimate that tracks, at a speed in rad/s; of any shape."""
    return np.maximum(OFF * np.abs(omega), LEAST)


def follows(mean_error: Any, rms: Any, omega: Any) -> Any:
    """Whether an estimate tracks.

    Parameters
    ----------
    mean_error, rms : float or ndarray
        Of the speed error, in rad/s; NaN where there is no estimate.
    omega : float or ndarray
        The speed, in rad/s.

    Returns
    -------
    bool or ndarray of bool
    """
    most = limit(omega)
    return (np.abs(mean_error) <= most) & (rms <= NOISY * most)


def holds(mean_error: Any, rms: Any, omega: Any, wanted: Any) -> Any:
    """Whether a loop closed on an estimate holds: it tracks, and the speed ``omega`` is the one that is ``wanted`` (rad/s)."""
    return follows(mean_error, rms, wanted) & (np.abs(omega - wanted) <= limit(wanted))


def spared(study: Study) -> tuple[list[str], list[str]]:
    """The observers that have the right parameters in a run in which others have wrong ones, and those others.

    What they end at does not compare: an observer that was added to a study has none of the ``errors`` that a scenario gives
    the others. One whose estimate of a parameter starts from a wrong value does not have the right ones.

    Parameters
    ----------
    study : Study
        Of the run, as `Study.scenario` gives it.

    Returns
    -------
    tuple of 2 list of str
        Both empty where there is none of either.
    """
    wrong = [name for name, one in study.observers.items() if any(one.errors.values())]
    true = {f"{name}_hat": value for name, value in zip(PARAMETERS, study.machine.observer_parameters, strict=True)}
    right = [name for name, one in study.observers.items() if name not in wrong and all(
        math.isclose(value, true.get(state, value), rel_tol=ROUNDED)
        for state, value in zip(OBSERVERS[one.kind].states, one.initial_values, strict=True))]
    return (right, wrong) if right and wrong else ([], [])


def rpm(omega: float, n_p: int) -> float:
    """An electrical speed in rad/s as revolutions of the shaft in a minute."""
    return omega / n_p * 30 / math.pi


def size(error: float, omega: float, n_p: int) -> str:
    """An error of an electrical speed, rad/s, for people: with its share of the speed and in r/min of the shaft."""
    if not math.isfinite(error):
        return "lost"
    share = f"{_short(100 * error / omega)} %, " if abs(omega) >= LEAST else ""
    return f"{_short(error)} rad/s ({share}{_short(rpm(error, n_p))} r/min)"


def _short(value: float) -> str:
    return f"{abs(value):.3g}" if abs(value) >= 1e-3 else "below 0.001"


def criterion() -> str:
    """The limit, for people."""
    return f"{100 * OFF:g} % of the speed, {LEAST:g} rad/s below {LEAST / OFF:g} rad/s"
