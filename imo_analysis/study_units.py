"""Units of the fields of a study: as their tables declare them, or those of the symbol that has the name."""

from __future__ import annotations

import inspect
import typing
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from imo_analysis.errors import InputError
from imo_analysis.notation import symbol
from imo_analysis.study import Study


def unit_of(name: str) -> str:
    """SI unit of a number in a study; ``1`` for what has none.

    Parameters
    ----------
    name : str
        Dotted, such as ``machine.R_r``, ``reference.time.1`` or ``observers.repaired.gains.g``.
    """
    model: type[BaseModel] | None = Study
    unit = ""
    for part in name.split("."):
        if model is None:
            unit = _of_symbol(part) or unit  # of a table of gains or states, or the number of an entry in a list
            continue
        fields = {info.alias or key: info for key, info in model.model_fields.items()}
        if part not in fields:
            continue  # the name of an observer
        unit = declared_unit(fields[part]) or _of_symbol(part)
        model = next(_models(fields[part].annotation), None)
        if part in ("errors", "uncertainty"):  # shares of the parameters that they name
            return "1"
    return unit or "1"


def declared_unit(info: Any) -> str:
    """The unit to which the validator of a field converts, in lists and optional values too; empty where there is none.

    Parameters
    ----------
    info : pydantic.fields.FieldInfo
        Of the field.
    """
    for one in (*info.metadata, *_marks(info.annotation)):
        function = getattr(one, "func", None)
        if function is not None and inspect.isfunction(function):
            found = inspect.getclosurevars(function).nonlocals.get("unit")
            if isinstance(found, str):
                return found
    return ""


def _of_symbol(name: str) -> str:
    try:
        return str(symbol(name).unit)
    except InputError:
        return ""


def _marks(annotation: Any) -> Iterator[Any]:
    yield from getattr(annotation, "__metadata__", ())
    for one in typing.get_args(annotation):
        if not isinstance(one, str):
            yield from _marks(one)


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for one in typing.get_args(annotation):
        yield from _models(one)
