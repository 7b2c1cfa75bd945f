"""Fields of a study by dotted name: their own values, and which values no machine or drive can have, for thousands at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.errors import InputError
from imo_analysis.machine import _BOUNDS as MACHINE_BOUNDS
from imo_analysis.notation import symbol
from imo_analysis.study import Study
from imo_analysis.study_tables import Drive
from imo_analysis.sweeps.batch import DRIVE_FIELDS, believed_fields, machine_fields

Array = NDArray[np.float64]
# what stands for a table or a list in the dotted names, and the attribute of the study that holds it
_TABLES = {"load": "load_torque"}


def own_value(study: Study, name: str) -> Any:
    """The study's value of a field.

    Raises
    ------
    InputError
        If there is no such field.
    """
    value: Any = study
    parts = name.split(".")
    for n, part in enumerate(parts):
        if isinstance(value, (tuple, list)):
            if not part.isdigit() or int(part) >= len(value):
                raise InputError(f"sweep.fields.{name}: {'.'.join(parts[:n])} has entries 0 to {len(value) - 1}, not {part!r}")
            value = value[int(part)]
        elif isinstance(value, Mapping):
            # estimates that start at zero and parameters without error need not stand in the study
            value = value.get(part, 0.0 if n == 3 and parts[2] in ("initial", "errors") else None)
        else:
            value = getattr(value, _TABLES.get(part, part), None)
        if value is None:
            raise InputError(f"sweep.fields.{name}: {name!r} is not a field of the study; it has no {part!r}"
                             f"{' in ' + '.'.join(parts[:n]) if n else ''}")
    return value


def with_values(study: Study, values: Mapping[str, Any]) -> Study:
    """The study with fields replaced, entries of lists included.

    Raises
    ------
    InputError
        If a value cannot be used.
    """
    changed: dict[str, Any] = {}
    for name, value in values.items():
        before, _, last = name.rpartition(".")
        if last.isdigit():
            entries = changed.get(before) or list(own_value(study, before))
            entries[int(last)] = value
            changed[before] = entries
        else:
            changed[name] = value
    return study.changed(changed)


def impossible(study: Study, values: Mapping[str, Array], nominal: bool) -> tuple[NDArray[np.bool_], list[str]]:
    """Which of many machines, drives and observers cannot be, and why, a line for each reason with its count.

    The same bounds as `InductionMachine` and the tables of the study have, asked for all at once.
    """
    count = len(next(iter(values.values()))) if values else 1
    wrong: NDArray[np.bool_] = np.zeros(count, dtype=bool)
    reasons: list[str] = []

    def refuse(which: NDArray[Any], text: str) -> None:
        fresh = which & ~wrong
        if fresh.any():
            reasons.append(f"{int(fresh.sum())} with {text}")
            wrong[fresh] = True

    def field(name: str, otherwise: float) -> Array:
        return np.asarray(values[name], dtype=float) if name in values else np.full(count, float(otherwise))

    for name, value in values.items():
        refuse(~np.isfinite(value), f"{name} not a finite number")
    _machines(machine_fields(study, field), "machine", refuse)
    for name in study.observers:
        _machines(believed_fields(study, name, field, nominal), f"the machine that {name} believes", refuse)
    drive = {name: field(f"drive.{name}", getattr(study.drive, name)) for name in DRIVE_FIELDS}
    for name, value in drive.items():
        for bound in Drive.model_fields[name].metadata:
            if getattr(bound, "gt", None) is not None:
                refuse(~(value > bound.gt), f"drive.{name} not above {bound.gt:g}")
            if getattr(bound, "ge", None) is not None:
                refuse(~(value >= bound.ge), f"drive.{name} below {bound.ge:g}")
    refuse(drive["flux_modulation"] >= drive["flux"], "drive.flux_modulation not below drive.flux")
    return wrong, reasons


def _machines(machine: Mapping[str, Array], whose: str, refuse: Callable[[NDArray[Any], str], None]) -> None:
    for name, (lowest, highest) in MACHINE_BOUNDS.items():
        value = machine[name]
        refuse(~((value >= lowest) & (value <= highest)),
               f"{name} of {whose} outside {lowest:g} .. {highest:g} {symbol(name).unit}")
    refuse(~(machine["B"] >= 0), f"B of {whose} below 0")
    pairs = machine["n_p"]
    refuse(~((pairs >= 1) & (pairs <= 200) & (pairs == np.floor(pairs))), f"n_p of {whose} not a whole number from 1 to 200")
    refuse(~(machine["L_m"] * machine["L_m"] < machine["L_s"] * machine["L_r"]), f"L_m of {whose} not below sqrt(L_s L_r)")
