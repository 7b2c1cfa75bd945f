"""Numbers with units as people write them in files: ``0.0601`` (SI) or ``"60.1 mH"``."""

from __future__ import annotations

import math
import re

from imo_analysis.errors import InputError
from imo_analysis.notation import dimension

_PREFIX = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "n": 1e-9}
# a number is not cut short to make its tail a unit: "15,2 A", "0.035"
_WRITTEN = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?![\d.,])\s*(\S.*?)\s*$")
_SPELLINGS = {"Ω": "ohm", "Ohm": "ohm", "·": " ", "²": "^2", "*": " "}
_SCALED = {"rpm": (math.pi / 30, "rad/s"), "1/min": (math.pi / 30, "rad/s")}


def si_value(value: object, unit: str, where: str) -> float:
    """The value in SI units.

    Parameters
    ----------
    value : float or str
        A number in SI units, or text of a number and a unit, with or without an SI prefix.
    unit : str
        The unit that is wanted.
    where : str
        Where it was read, for the error text.

    Raises
    ------
    InputError
        If it is not a finite number or its unit has another dimension.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise InputError(f"{where} = {value!r} is not a number; write it in {unit}")
    if not isinstance(value, str):
        number = float(value)
    else:
        match = _WRITTEN.match(value)
        if not match:
            raise InputError(f'{where} = "{value}" is not a number with a unit; write it with a point, for example '
                             f'"1.5 {unit}"')
        number = float(match[1]) * _factor(match[2], unit, value, where)
    if not math.isfinite(number):
        raise InputError(f"{where} = {value} is not finite; write a number in {unit}")
    return number


def _factor(written: str, unit: str, value: str, where: str) -> float:
    for old, new in _SPELLINGS.items():
        written = written.replace(old, new)
    if written in _SCALED:
        factor, written = _SCALED[written]
        if dimension(written) == dimension(unit):
            return factor
    else:
        try:
            if dimension(written) == dimension(unit):
                return 1.0
        except InputError:
            for prefix, factor in _PREFIX.items():
                bare = written.removeprefix(prefix)
                if prefix and bare != written and _same_dimension(bare, unit):
                    return factor
    raise InputError(f'{where} = "{value}" has the wrong unit; it must be in {unit}')


def _same_dimension(written: str, unit: str) -> bool:
    try:
        return dimension(written) == dimension(unit)
    except InputError:
        return False
