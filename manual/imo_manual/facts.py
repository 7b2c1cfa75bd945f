"""What the reference pages list besides names: fields of a study, options of the commands, arguments with house-wide names.

Everything is read from the program: the pydantic models of `imo_analysis.study`, the parsers of `imo_analysis.cli`.
"""

from __future__ import annotations

import argparse
import inspect
import types
import typing
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from imo_analysis.cli import COMMANDS, parser_of
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.notation import symbol
from imo_analysis.study import Study
from imo_analysis.study_tables import Table
from imo_analysis.study_units import declared_unit
from imo_manual.names import documented

_NOT_WRITTEN = ("data", "machine", "scenarios")  # data is the study itself; the others have sections of their own


@dataclass(frozen=True)
class Field:
    """A field of a study file.

    Attributes
    ----------
    table, name : str
        The table as it is written, ``[simulation]``, and the key.
    unit : str
        SI unit; empty for what is no quantity.
    kind : str
        ``number``, ``integer``, ``text``, ``true or false``, or a list or table of them.
    bounds : str
        What is allowed.
    default : str
        As it would be written in TOML; ``required`` where there is none.
    meaning : str
        From the docstring of the table, or of the symbol of that name; empty if nobody wrote any.
    """

    table: str
    name: str
    unit: str
    kind: str
    bounds: str
    default: str
    meaning: str


@dataclass(frozen=True)
class StudyTable:
    """A table of a study file: its heading, what it is for, and its fields."""

    heading: str
    meaning: str
    fields: tuple[Field, ...]


def study_tables(study: type[Table] = Study) -> list[StudyTable]:
    """Every table of a study file with every field, in the order of the models."""
    machine = _table("[machine]", InductionMachine)
    top: list[Field] = []
    tables: list[StudyTable] = []
    for name, info in study.model_fields.items():
        if name in _NOT_WRITTEN:
            continue
        key = info.alias or name
        inner = [one for one in _models(info.annotation) if issubclass(one, Table)]
        if not inner:
            top.append(_field("", key, info, documented(inspect.getdoc(study) or "")))
            continue
        origin = typing.get_origin(info.annotation)
        heading = f"[{key}.NAME]" if origin is dict else f"[[{key}]]" if origin is tuple else f"[{key}]"
        tables.append(_table(heading, inner[0]))
    return [StudyTable("top of the file", "", tuple(top)), machine, *tables]


def _table(heading: str, model: Any) -> StudyTable:
    doc = inspect.getdoc(model) or ""
    known = documented(doc)
    fields: list[Field] = []
    for name, info in model.model_fields.items():
        inner = [one for one in _models(info.annotation) if issubclass(one, Table)]
        if inner:
            within = documented(inspect.getdoc(inner[0]) or "")
            fields += [_field(heading, f"{name}.{key}", one, within) for key, one in inner[0].model_fields.items()]
        else:
            fields.append(_field(heading, info.alias or name, info, known, name))
    first = doc.split("\n\n")[0].replace("\n", " ")
    if model is InductionMachine:
        fields += [Field(heading, *row) for row in _MACHINE]
    return StudyTable(heading, first, tuple(fields))


# keys of [machine] that are no parameters: `Study` resolves the first, `InductionMachine.build` the second
_MACHINE = (
    ("file", "", "text", "", "none", "a machine file beside the study; single parameters can still be given"),
    ("preset", "", "text", "", "none", "a built-in machine; single parameters can still be given"),
)


def _field(table: str, key: str, info: Any, known: dict[str, tuple[str, str]], name: str = "") -> Field:
    label = name or key.rpartition(".")[2]
    unit = declared_unit(info) or _unit_of_symbol(label, info.annotation)
    kind, bounds = _kind(info.annotation), _bounds(info)
    default = "required" if info.is_required() else _toml(info.default)
    return Field(table, key, unit, kind, bounds, default, _meaning(label, known))


def _meaning(name: str, known: dict[str, tuple[str, str]]) -> str:
    for label in (name, name.rstrip("_")):
        if label in known:
            return " ".join(known[label][1].split())
    try:
        return symbol(name).meaning
    except InputError:
        return ""


def _unit_of_symbol(name: str, annotation: Any) -> str:
    if float not in (annotation, *typing.get_args(annotation)) or typing.get_origin(annotation) is dict:
        return ""
    try:
        return symbol(name).unit
    except InputError:
        return ""


def _models(annotation: Any) -> Iterator[type]:
    if isinstance(annotation, type) and issubclass(annotation, (Table, InductionMachine)):
        yield annotation
    for one in typing.get_args(annotation):
        yield from _models(one)


_WORDS = {float: "number", int: "integer", str: "text", bool: "true or false"}


def _kind(annotation: Any) -> str:
    origin, inner = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        return _kind(inner[0])
    if origin is typing.Literal:
        return "text"
    if origin is dict:
        return f"table of {_kind(inner[1])}s" if inner[1] in _WORDS and inner[1] is not str else "table"
    if origin is tuple:
        word = _kind(inner[0])
        several = "texts" if word == "text" else f"{word}s"
        return f"list of {several}" if Ellipsis in inner else f"list of {len(inner)} {several}"
    if origin in (typing.Union, types.UnionType):
        return _kind(next(one for one in inner if one is not type(None)))
    return _WORDS.get(annotation, "table")


_SIGNS = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most", "min_length": "entries: at least"}


def _bounds(info: Any) -> str:
    annotation = info.annotation
    choices = [one for part in (annotation, *typing.get_args(annotation)) if typing.get_origin(part) is typing.Literal
               for one in typing.get_args(part)]
    if choices:
        return ", ".join(f"`{one}`" for one in choices)
    found = [f"{word} {getattr(mark, name):g}" for mark in info.metadata for name, word in _SIGNS.items()
             if getattr(mark, name, None) is not None]
    return ", ".join(found)


def _toml(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, dict):
        return "{ }" if not value else "{ " + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    return f"{value:g}" if isinstance(value, float) else str(value)


# Commands -----------------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Option:
    """An argument or option of a command: as it is written, its help, its default and its choices."""

    written: str
    meaning: str
    default: str
    required: bool


@dataclass(frozen=True)
class Command:
    """A command: name, line in the overview, description, example, options."""

    name: str
    line: str
    description: str
    example: tuple[str, ...]
    options: tuple[Option, ...]


def commands() -> list[Command]:
    """Every command of ``imo`` with every option, from the parsers themselves."""
    found = []
    for name, line in COMMANDS.items():
        parser = parser_of(name)
        example = tuple((parser.epilog or "").splitlines()[1:])
        options = tuple(_option(one) for one in parser._actions if not isinstance(one, argparse._HelpAction))
        found.append(Command(name, line, parser.description or "", tuple(one.strip() for one in example), options))
    return found


def _option(action: argparse.Action) -> Option:
    metavar = action.metavar
    if isinstance(metavar, tuple):
        value = " ".join(metavar)
    elif action.choices is not None:
        value = "|".join(str(one) for one in action.choices)
    else:
        value = metavar or (action.dest if not action.option_strings else action.dest.upper())
    takes = action.nargs != 0
    if action.nargs in ("+", "*"):
        value = f"{value} ..."
    if action.nargs == "?" and action.option_strings:
        value = f"[{value}]"
    written = ", ".join(f"{one} {value}" if takes else one for one in action.option_strings) or value
    meaning = "" if action.help in (None, argparse.SUPPRESS) else str(action.help)
    default = "" if action.default in (None, False, argparse.SUPPRESS) or action.default == [] else str(action.default)
    return Option(written, meaning, default, action.required)
