"""Numbers for a sweep: grids, and random draws that are a function of seed, field and draw number alone.

So any part of a sweep can be drawn anywhere, in any order, again and again, with the same result.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.errors import InputError
from imo_analysis.simulation.inputs import normals, uniforms

Array = NDArray[np.float64]
GRIDS = {"values": "a list", "linspace": "[first, last, count]", "geomspace": "[first, last, count]"}
DRAWS = {"uniform": "[low, high]", "log_uniform": "[low, high], both above 0", "normal": "[mean, deviation]",
         "relative": "a share of the study's own value, 0.5 for +-50 %"}


def flattened(fields: Mapping[str, Any], before: str = "") -> dict[str, dict[str, Any]]:
    """The tables of ``[sweep.fields]`` by dotted name, whether the names were quoted or not.

    Raises
    ------
    InputError
        If something in it is not a distribution.
    """
    found: dict[str, dict[str, Any]] = {}
    for key, value in fields.items():
        name = f"{before}{key}"
        if not isinstance(value, Mapping) or not value:
            raise InputError(f"sweep.fields.{name} = {value!r} must be a table such as {{ relative = 0.5 }}")
        if set(value) & {*GRIDS, *DRAWS}:
            _check(name, dict(value))
            found[name] = dict(value)
        else:
            found.update(flattened(value, f"{name}."))
    return found


def _check(name: str, spec: dict[str, Any]) -> None:
    where = f"sweep.fields.{name}"
    if len(spec) != 1:
        raise InputError(f"{where} has the keys {', '.join(spec)}; give one of {', '.join([*GRIDS, *DRAWS])}")
    (kind, value), = spec.items()
    if kind == "values":
        if not isinstance(value, list) or not value:
            raise InputError(f"{where}.values = {value!r} must be a list with at least one entry")
        return
    numbers = value if isinstance(value, list) else [value]
    count = 1 if kind == "relative" else 3 if kind in GRIDS else 2
    well = len(numbers) == count and isinstance(value, list) == (kind != "relative") and all(
        isinstance(number, (int, float)) and not isinstance(number, bool) and math.isfinite(number) for number in numbers)
    if not well:
        raise InputError(f"{where}.{kind} = {value!r} must be {({**GRIDS, **DRAWS})[kind]}")
    if kind in GRIDS and (numbers[2] != int(numbers[2]) or numbers[2] < 1):
        raise InputError(f"{where}.{kind}: count = {numbers[2]!r} must be a whole number of 1 or more")
    if kind in ("uniform", "log_uniform") and not numbers[1] > numbers[0]:
        raise InputError(f"{where}.{kind} = {value!r}: the second number must be above the first")
    if kind in ("log_uniform", "geomspace") and not min(numbers[:2]) > 0:
        raise InputError(f"{where}.{kind} = {value!r}: both ends must be above 0")
    if kind == "relative" and not numbers[0] > 0:
        raise InputError(f"{where}.relative = {value!r} must be above 0; 0.5 means +-50 %")
    if kind == "normal" and not numbers[1] > 0:
        raise InputError(f"{where}.normal = {value!r}: the deviation must be above 0")


def is_grid(spec: Mapping[str, Any]) -> bool:
    """Whether a table of ``[sweep.fields]`` lists its values, rather than drawing them."""
    return next(iter(spec)) in GRIDS


def grid(spec: Mapping[str, Any]) -> list[Any]:
    """The values of a grid."""
    (kind, value), = spec.items()
    if kind == "values":
        return list(value)
    first, last, count = value
    return [float(number) for number in (np.linspace if kind == "linspace" else np.geomspace)(first, last, int(count))]


def draw(name: str, spec: Mapping[str, Any], own: float, seed: int, index: NDArray[np.int64]) -> Array:
    """The draws with these numbers; ``own`` is the study's value of the field."""
    (kind, value), = spec.items()
    key = int.from_bytes(hashlib.sha256(f"{seed}:{name}".encode()).digest()[:8], "little")
    if kind == "normal":
        return np.asarray(value[0] + value[1] * normals(key, index)[0])
    share = uniforms(key, index)[0]
    if kind == "relative":
        return np.asarray(own * (1.0 + value * (2.0 * share - 1.0)))
    low, high = value
    if kind == "log_uniform":
        return np.asarray(low * np.exp(share * math.log(high / low)))
    return np.asarray(low + (high - low) * share)
