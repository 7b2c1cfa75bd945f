"""What efficiency a motor of some power has: that of the lowest class of standard motors, IE1 of IEC 60034-30-1.

At 50 Hz and for four poles the standard gives it, in per cent, as a cubic of the decimal logarithm of the shaft power in kW,
made for 0.75 to 200 kW; above, its last value stands. Below, down to 0.12 kW, it is up to four points high. Smaller motors have
no class; there the cubic goes on, to 15 % at 10 W, as a measure that they do better than.
"""

from __future__ import annotations

import math

_CUBIC = (0.5234, -5.0499, 17.4180, 74.3171)  # from the third power down
LEAST_CLASSED = 120.0  # W
_SPAN = (0.01, 200.0)  # kW
UNUSUAL = 2.0  # times the losses of the class: those of old, slow or special motors
NEVER = 3.0  # times them: those of no motor at its rated point, eight poles and canned rotors among them


def efficiency_at(times: float, power: float) -> float:
    """Efficiency, of 1, with so many times the losses of class IE1.

    Parameters
    ----------
    times : float
        1 for the class itself; `UNUSUAL` or `NEVER`.
    power : float
        Of the shaft, in W.
    """
    x = math.log10(min(max(power / 1e3, _SPAN[0]), _SPAN[1]))
    a, b, c, d = _CUBIC
    class_efficiency = (((a * x + b) * x + c) * x + d) / 100
    return 1 / (1 + times * (1 / class_efficiency - 1))
