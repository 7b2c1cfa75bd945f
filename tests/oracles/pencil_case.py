"""What the tests of the pencils share: the paper's machine, gains for every observer, and a steady state."""

from __future__ import annotations

from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS
from imo_analysis.machine import preset
from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.pencils.jacobian import commutes_with_rotation

MACHINE = preset("table-iii-printed-alpha")
TRUE = dict(zip(PARAMETERS, MACHINE.observer_parameters, strict=True))
GAINS: dict[str, float] = {
    "k_1": 300.0, "k_2": 50.0, "kappa": 70.0, "k_3": 100.0, "g": 1.0, "K_p": 100.0, "alpha_l": 0.05, "delta": 0.01,
    "l_1": 160.0, "l_2": 12.0, "l_3": -0.08, "l_4": 0.35, "h": 100.0, "h_s": 0.03, "P_0": 4.0, "k": 1.5, "eta": 1.0,
    "S_0": 100.0,
}
POINT = OperatingPoint(60.0, 0.5307, 3.0)
EQUIVARIANT = [name for name in OBSERVERS if commutes_with_rotation(name)]


def gains(name: str) -> dict[str, float]:
    """The gains of one observer, by name."""
    return {gain: GAINS[gain] for gain in OBSERVERS[name].gains}
