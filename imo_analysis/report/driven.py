"""A run in which an estimate drives the machine, once with each observer as the one that drives.

In the study one observer drives; which of them is worth it is what the dossier asks. So the run is made with each of them,
alone, since those that only watch change nothing in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from imo_analysis.errors import Diverged
from imo_analysis.report.metrics import Resting
from imo_analysis.report.scenarios import Scenario, resting_of
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study


def is_sensorless(study: Study, name: str) -> bool:
    """Whether an estimate drives the machine in a scenario (empty: in the study itself)."""
    return (study.scenario(name) if name else study).drive.feedback != "measured"


def driven_by_each(study: Study, name: str, note: Callable[[str], None]) -> Scenario:
    """A scenario (empty: the study itself) of which nothing is drawn yet, with where each observer ends that drives in it."""
    chosen = study.scenario(name) if name else study
    note(f"{name or 'run'}: simulating {chosen.simulation.duration:g} s, driven by each observer")
    driven = tuple(one for observer in chosen.observers for one in _alone(chosen, observer))
    return Scenario(name or "run", chosen.title, "", [], [], [], [], [], None, "", alpha=chosen.machine.alpha, driven=driven)


def _alone(study: Study, observer: str) -> list[Resting]:
    """What `resting_of` gives of the run that an observer drives; nothing but NaN where it diverges, or the machine does."""
    alone = study.changed({"drive.feedback": observer}).only([observer])
    try:
        return resting_of(simulate(alone), alone, drives=True)
    except Diverged:
        return [Resting(observer, *[math.nan] * 9)]
