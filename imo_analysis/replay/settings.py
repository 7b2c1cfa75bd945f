"""What the file of ``imo replay --machine`` says: the machine, the table ``[replay]``, and a study's own observers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.files import read_toml
from imo_analysis.machine import PRESETS, InductionMachine, readable
from imo_analysis.study import located_table
from imo_analysis.study_replay import Replay, read_replay
from imo_analysis.study_tables import ObserverSettings


@dataclass(frozen=True)
class Settings:
    """The contents of a file, or of a preset, which has a machine only.

    Attributes
    ----------
    place : str
        The name that was given.
    machine : InductionMachine
    replay : Replay
        The table ``[replay]``.
    observers : mapping of str to tuple
        By kind: the name in the study, and its settings.
    """

    place: str
    machine: InductionMachine
    replay: Replay
    observers: Mapping[str, tuple[str, ObserverSettings]]

    @property
    def gains(self) -> dict[str, dict[str, float]]:
        """Gains of the study's observers, by kind."""
        return {kind: dict(one.gains) for kind, (_, one) in self.observers.items()}

    @property
    def initial(self) -> dict[str, dict[str, float]]:
        """How the study's observers begin, by kind: a study's estimates are zero where it does not give them."""
        return {kind: dict(zip(OBSERVERS[kind].states, one.initial_values, strict=True))
                for kind, (_, one) in self.observers.items()}


def load_settings(name: str) -> Settings:
    """Read a file with ``[machine]``, or take a preset.

    Parameters
    ----------
    name : str
        Of the file or preset. Where a study has several observers of a kind, the one of that name counts, else the first.

    Raises
    ------
    InputError
        If anything in it cannot be used.
    """
    if name in PRESETS:
        return Settings(name, PRESETS[name], read_replay({}, name), {})
    data = read_toml(name)
    tables = data.get("observers", {})
    if not isinstance(tables, dict):
        raise InputError(f"{name}: observers must be tables, [observers.NAME]")
    found: dict[str, tuple[str, ObserverSettings]] = {}
    for own, table in tables.items():
        where = f"{name}: observers.{own}"
        if isinstance(table, dict):
            table = located_table({"kind": own, **table}, where, Path(name).parent)
        one = _settings(table, where)
        if one.kind not in found or own == one.kind:
            found[one.kind] = (own, one)
    return Settings(name, InductionMachine.load(name), read_replay(data.get("replay", {}), name), found)


def _settings(table: Any, where: str) -> ObserverSettings:
    try:
        return ObserverSettings.model_validate(table)
    except ValidationError as error:
        raise InputError(readable(error, where, ObserverSettings)) from None
