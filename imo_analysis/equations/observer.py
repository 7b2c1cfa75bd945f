"""What an observer is: its rates, its states, its gains and its flux, under a name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

PARAMETERS = ("R_s", "L_m", "sigma", "beta", "alpha")


@dataclass(frozen=True)
class Observer:
    """An observer, of the catalogue or of a file (`imo_analysis.equations.own`).

    Attributes
    ----------
    name : str
        The name used in studies and data sets.
    rates : callable
        ``rates(x, i, u, direction, p, gains)``; ``p`` in the order of `PARAMETERS`.
    states, gains : tuple of str
        Names, in the order of ``x`` and ``gains``. A state ``NAME_hat`` estimates that quantity of the machine; any other is a
        correction, which is zero while the estimates are right.
    flux : callable
        ``flux(x, i, beta)``, the estimated rotor flux.
    source : str
        Where it is printed.
    meaning : str
        In a line.
    needs_direction : bool
        Whether it must be told the direction of rotation.
    units : mapping of str to str
        Units of those states and gains that `imo_analysis.notation` does not know.
    """

    name: str
    rates: Callable[..., Any]
    states: tuple[str, ...]
    gains: tuple[str, ...]
    flux: Callable[..., Any]
    source: str
    meaning: str
    needs_direction: bool = False
    units: Mapping[str, str] = field(default_factory=dict, compare=False)
