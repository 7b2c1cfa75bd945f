"""Numbers with units as people write them in files: ``0.0601`` (SI) or ``"60.1 mH"``."""

from __future__ import annotations

import math
import re

from imo_analysis.errors import InputError
from imo_analysis.notation import dimension

RPM = ("rpm", "r/min", "1/min", "min^-1", "min-1", "U/min", "rev/min")  # one unit, as plates and logs write it
_PREFIX = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "n": 1e-9}
# a number is not cut short to make its tail a unit: "15,2 A", "0.035"
_WRITTEN = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?![\d.,])\s*(\S.*?)\s*$")
_PLAIN = re.compile(r"^\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?\s*$")
_SPELLINGS = {"Ω": "ohm", "Ohm": "ohm", "·": " ", "²": "^2", "⁻¹": "^-1", "*": " ", "RPM": "rpm", "kgm": "kg m",
              "kgcm": "kg cm", "m2": "m^2", "Nm": "N m"}
_SCALED = {
    **dict.fromkeys(RPM, (math.pi / 30, "rad/s")),
    "%": (0.01, "1"),
    "hp": (745.699872, "W"), "HP": (745.699872, "W"), "PS": (735.49875, "W"),
    "kg cm^2": (1e-4, "kg m^2"), **dict.fromkeys(("g m^2", "gm^2"), (1e-3, "kg m^2")),
}
# what a message offers, where it is more than the unit itself
_ACCEPTED = {
    "rad/s": f"rad/s, or {' or '.join(RPM[:2])} (also {', '.join(RPM[2:])})",
    "W": "W, kW or hp", "1": 'a plain number, or text in %, as in "84 %"', "kg m^2": "kg m^2, kg cm^2 or g m^2",
}


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
        raise InputError(f"{where} = {value!r} is not a number; write it in {accepted(unit)}")
    if not isinstance(value, str) or (unit == "1" and _PLAIN.match(value)):
        number = float(value)
    else:
        match = _WRITTEN.match(value)
        if not match:
            example = "0.84" if unit == "1" else f'"1.5 {unit}"'
            raise InputError(f'{where} = "{value}" is not a number with a unit; write it with a point, for example {example} '
                             f"(accepted: {accepted(unit)})")
        number = float(match[1]) * _factor(match[2], unit, value, where)
    if not math.isfinite(number):
        raise InputError(f"{where} = {value} is not finite; write a number in {unit}")
    return number


def accepted(unit: str) -> str:
    """The units in which a quantity may be written, in words.

    Parameters
    ----------
    unit : str
        Its SI unit.
    """
    return _ACCEPTED.get(unit, f"{unit}, with or without a prefix such as m or k")


def with_unit(value: float, unit: str) -> str:
    """A value with its unit, as messages have it; a pure number has none.

    Parameters
    ----------
    value : float
    unit : str
    """
    return f"{value:g}" if unit in ("", "1") else f"{value:g} {unit}"


def _factor(written: str, unit: str, value: str, where: str) -> float:
    for old, new in _SPELLINGS.items():
        written = written.replace(old, new)
    written = " ".join(written.split())
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
    raise InputError(f'{where} = "{value}" has the wrong unit; it must be in {accepted(unit)}')


def _same_dimension(written: str, unit: str) -> bool:
    try:
        return dimension(written) == dimension(unit)
    except InputError:
        return False
