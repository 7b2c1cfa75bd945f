"""An observer ready to be linearised: which one, the machine that its model holds, and its gains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from imo_analysis.machine import InductionMachine

if TYPE_CHECKING:
    from imo_analysis.study import Study


@dataclass(frozen=True)
class Setup:
    """What all functions of the atlas take.

    Attributes
    ----------
    observer : str
        Its name in the catalogue.
    machine : InductionMachine
        As the observer believes it to be.
    gains : mapping of str to float
        By name. Those that the poles do not depend on may be left out.
    """

    observer: str
    machine: InductionMachine
    gains: Mapping[str, float]

    @classmethod
    def of_study(cls, study: Study, label: str) -> Setup:
        """An observer of a study.

        Parameters
        ----------
        study : Study
        label : str
            The observer's name in the study.
        """
        settings = study.observers[label]
        return cls(settings.kind, study.observer_machine(label), settings.gains)


def labelled(observer: Setup | Mapping[str, Setup]) -> dict[str, Setup]:
    """One observer or several, by label; a single one is labelled with its name."""
    return {observer.observer: observer} if isinstance(observer, Setup) else dict(observer)
