"""The study: everything that a person can vary, in one TOML file, checked before anything is computed.

Tables: ``[machine]``, ``[simulation]``, ``[initial]``, ``[reference]``, ``[load]``, ``[drive]``, ``[sensors]``,
``[inverter]``, ``[mechanics]``, ``[saturation]``, ``[observers.NAME]``, ``[excitation]``, ``[poles]``, ``[replay]``,
``[sweep]``, ``[tuning]``, ``[[windows]]``, and overlays ``[scenarios.NAME]`` over all of them.
Their keys are in `imo_analysis.study_tables` and `imo_analysis.study_realism`; the built-in study of the paper is
``study_paper.toml`` beside this file.
"""

from __future__ import annotations

import copy
import hashlib
import re
import tomllib
from collections.abc import Iterable, Mapping
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any, Self

from pydantic import Field, ValidationError, model_validator

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.own import located
from imo_analysis.errors import InputError
from imo_analysis.files import read_toml
from imo_analysis.machine import InductionMachine, readable
from imo_analysis.study_realism import Inverter, Mechanics, Saturation, check_realism
from imo_analysis.study_replay import Replay
from imo_analysis.study_sweep import Sweep
from imo_analysis.study_tables import (
    Drive,
    Excitation,
    Initial,
    Load,
    ObserverSettings,
    Poles,
    Reference,
    Sensors,
    Simulation,
    Table,
    Window,
)
from imo_analysis.study_tuning import Tuning
from imo_analysis.toml_writer import toml_text

# Names that become part of file names and of the columns of tables.
_NAME = re.compile(r"\w[\w +.-]{0,59}")


class Study(Table):
    """A checked study. Build it with `load`, `from_toml`, `from_data` or `paper`, never by hand.

    Attributes
    ----------
    title : str
        What the study is called in figures, files and dossier.
    machine : InductionMachine
        The true machine.
    simulation, initial, reference, load_torque, drive, sensors, inverter, mechanics, saturation : Table
        The tables of the run, as in a file.
    observers : dict of str to ObserverSettings
        Name -> kind, gains, start, errors.
    excitation, poles, replay, windows, sweep, tuning : Table
        What is computed from the run and beside it.
    scenarios : dict of str to dict
        Name -> overlay.
    data : dict
        The study as plain data with the machine file resolved: what `to_toml` writes.
    """

    title: str = "study"
    machine: InductionMachine
    simulation: Simulation
    initial: Initial = Initial()
    reference: Reference
    load_torque: Load = Field(default=Load(), alias="load")
    drive: Drive
    sensors: Sensors = Sensors()
    inverter: Inverter = Inverter()
    mechanics: Mechanics = Mechanics()
    saturation: Saturation = Saturation()
    observers: dict[str, ObserverSettings] = Field(default={})
    excitation: Excitation = Excitation()
    poles: Poles = Poles()
    replay: Replay = Replay()
    windows: tuple[Window, ...] = ()
    sweep: Sweep = Sweep()
    tuning: Tuning = Tuning()
    scenarios: dict[str, dict[str, Any]] = Field(default={})
    data: dict[str, Any] = Field(default={}, repr=False, exclude=True)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        feedback = self.drive.feedback
        if feedback != "measured" and feedback not in self.observers:
            known = ", ".join(["measured", *self.observers])
            raise ValueError(f"drive.feedback = {feedback!r} must be one of: {known}")
        if feedback != "measured":
            _check_start(feedback, self.observers[feedback], self.machine)
        check_realism(self.machine, self.simulation.sample_time, self.simulation.substeps, self.inverter, self.mechanics,
                      self.saturation)
        believed = {f"observers.{name}": one.errors for name, one in self.observers.items()} | {"drive": self.drive.errors}
        for place, errors in believed.items():
            try:
                _believed(self.machine, errors)
            except InputError as error:
                raise ValueError(f"{place}.errors make a machine that cannot be: {error}") from None
        return self

    # Reading ---------------------------------------------------------------------------------------------------------
    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a study file; ``machine.file`` and observers of one's own in it are looked up beside it.

        Parameters
        ----------
        path : str or pathlib.Path
            The file.

        Raises
        ------
        InputError
            If the file cannot be read or anything in it cannot be used.
        """
        data = read_toml(path)
        if "nameplate" in data:
            raise InputError(f"{path} is a motor, not a study; make one of it: imo study --init study.toml --machine {path}")
        return cls.from_data(data, str(path), Path(path).parent)

    @classmethod
    def from_toml(cls, text: str, where: str = "study") -> Self:
        """Read a study from TOML text.

        Parameters
        ----------
        text : str
            The study.
        where : str
            Names the place in error texts.
        """
        try:
            data = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise InputError(f"{where} is not TOML: {error}") from None
        return cls.from_data(data, where)

    @classmethod
    def paper(cls) -> Self:
        """The built-in study of the paper."""
        return cls.from_toml(paper_text(), "study_paper.toml")

    @classmethod
    def from_data(cls, data: Mapping[str, Any], where: str = "study", folder: Path | None = None) -> Self:
        """Check plain data as TOML gives it, every scenario included. ``where`` names the place in error texts.

        Parameters
        ----------
        data : mapping
            Tables and keys as in a file.
        where : str
            Names the place in error texts.
        folder : pathlib.Path, optional
            Where ``machine.file`` and observers of one's own are looked up.
        """
        study = cls._checked(copy.deepcopy(dict(data)), where, folder)
        for name in study.scenarios:
            study._scenario(name, where)
        return study

    @classmethod
    def _checked(cls, data: dict[str, Any], where: str, folder: Path | None = None) -> Self:
        if "data" in data:
            raise InputError(f"{where}: data is not a known key")
        data["machine"] = _machine_values(data.get("machine"), where, folder)
        machine = InductionMachine.build(data["machine"], f"{where}: machine")
        _check_texts(data, where)
        if isinstance(data.get("observers"), Mapping):
            data["observers"] = {name: located_table({"kind": name, **one}, f"{where}: observers.{name}", folder)
                                 if isinstance(one, Mapping) else one for name, one in data["observers"].items()}
        if isinstance(data.get("scenarios"), Mapping):
            data["scenarios"] = {name: _overlay(one, f"{where}: scenarios.{name}", folder)
                                 for name, one in data["scenarios"].items()}
        try:
            return cls(**{**data, "machine": machine, "data": data})
        except ValidationError as error:
            text = readable(error, f"{where}:", cls).replace(":.", ": ").replace(":)", ")")
            if any(fault["type"] == "missing" and len(fault["loc"]) == 1 for fault in error.errors(include_url=False)):
                text += "; start from a whole study: imo study --init FILE"
            raise InputError(text) from None

    # Variants --------------------------------------------------------------------------------------------------------
    def scenario(self, name: str) -> Self:
        """The study with the overlay ``[scenarios.NAME]`` merged over it, key by key; lists are replaced whole.

        Parameters
        ----------
        name : str
            Of the scenario.

        Raises
        ------
        InputError
            If there is no scenario of that name.
        """
        if name not in self.scenarios:
            known = ", ".join(self.scenarios) or "none in this study"
            raise InputError(f"scenario = {name!r} is not in the study; choose one of: {known}")
        return self._scenario(name, "study")

    def _scenario(self, name: str, where: str) -> Self:
        base = {key: value for key, value in self.data.items() if key != "scenarios"}
        overlay = self.scenarios[name]
        if "scenarios" in overlay:
            raise InputError(f"{where}: scenarios.{name}.scenarios is not a known key; scenarios do not nest")
        return self._checked(merged(base, {"title": name, **overlay}), f"{where}: scenarios.{name}")

    def changed(self, values: Mapping[str, Any]) -> Self:
        """A copy with values replaced, each under its dotted name, such as ``machine.R_r`` or ``observers.repaired.gains.g``.

        Parameters
        ----------
        values : mapping of str to value
            Dotted name -> new value.

        Raises
        ------
        InputError
            If a name leads nowhere or a value cannot be used.
        """
        overlay: dict[str, Any] = {}
        for dotted, value in values.items():
            inner = overlay
            *tables, key = dotted.split(".")
            for table in tables:
                inner = inner.setdefault(table, {})
            inner[key] = value
        return self._checked(merged(self.data, overlay), "study")

    def only(self, observers: Iterable[str]) -> Self:
        """A copy with these observers alone.

        Parameters
        ----------
        observers : iterable of str
            Their names in the study.
        """
        wanted = list(observers)
        for name in wanted:
            if name not in self.observers:
                raise InputError(f"observer = {name!r} is not in the study; choose from: {', '.join(self.observers)}")
        return self._checked({**self.data, "observers": {name: self.data["observers"][name] for name in wanted}}, "study")

    def observer_machine(self, name: str) -> InductionMachine:
        """The machine as the observer of this name believes it to be, with its relative parameter errors.

        Parameters
        ----------
        name : str
            Of the observer in the study.
        """
        return _believed(self.machine, self.observers[name].errors)

    @property
    def drive_machine(self) -> InductionMachine:
        """The machine as the drive believes it to be: all of its inertia on a stiff shaft, no saturation."""
        return _believed(self.machine, self.drive.errors)

    @cached_property
    def known_gains(self) -> dict[str, float]:
        """Gains by name, of whichever observer has them: first those of the scenarios, over them the study's own.

        An observer of the catalogue that the study does not list takes its gains from here.
        """
        listed = [one for name in self.scenarios for one in self.scenario(name).observers.values()]
        return {gain: value for one in (*listed, *self.observers.values()) for gain, value in one.gains.items()}

    @property
    def largest_torque(self) -> float:
        """Load of either sign that gains and designs are made for, in N m: ``tuning.torque``, or what three quarters of the
        magnetising current make across the flux."""
        if self.tuning.torque is not None:
            return self.tuning.torque
        machine, flux = self.machine, self.drive.flux
        return 1.5 * machine.n_p * machine.L_m / machine.L_r * flux * 0.75 * flux / machine.L_m

    @property
    def torque_limit(self) -> float:
        """The most torque in N m that the machine gives with the drive's flux and current limit."""
        machine, flux, most = self.machine, self.drive.flux, self.drive.current_limit
        across = max(most**2 - (flux / machine.L_m) ** 2, 0.0) ** 0.5
        return 1.5 * machine.n_p * machine.L_m / machine.L_r * flux * across

    @property
    def noise(self) -> float:
        """Deviation of each current sample that they are made for, in A: ``tuning.current_noise``, or that of the sensors, or
        0.1."""
        return self.tuning.current_noise or self.sensors.current_noise or 0.1

    # Writing ---------------------------------------------------------------------------------------------------------
    def to_toml(self) -> str:
        """The study as TOML text, without comments; reading it back gives the same study."""
        return toml_text(self.data)

    @cached_property
    def sha256(self) -> str:
        """Hash of `to_toml`."""
        return hashlib.sha256(self.to_toml().encode()).hexdigest()


def paper_text() -> str:
    """The text of the paper's study, with its comments."""
    return resources.files("imo_analysis").joinpath("study_paper.toml").read_text(encoding="utf-8")


def merged(base: Mapping[str, Any], overlay: Mapping[str, Any]) -> dict[str, Any]:
    """``overlay`` over ``base``, table by table; neither is changed. Of ``[saturation]`` a knee takes the place of a table of
    flux and current, and the other way round."""
    result = dict(base)
    for key, value in overlay.items():
        have = result.get(key)
        if key == "saturation" and isinstance(have, Mapping) and isinstance(value, Mapping):
            table = bool({"flux", "current"} & value.keys())
            gone = {"flux", "current"} if "knee" in value else {"knee", "power"} if table else set()
            have = {name: one for name, one in have.items() if name not in gone}
        result[key] = merged(have, value) if isinstance(have, Mapping) and isinstance(value, Mapping) else value
    return result


def _check_texts(data: Mapping[str, Any], where: str) -> None:
    """Refuse a title that files cannot hold, and names of observers and scenarios that cannot be part of a file's name."""
    title = data.get("title")
    if isinstance(title, str) and not (title.isprintable() and 0 < len(title) <= 200):
        raise InputError(f"{where}: title = {title[:60]!r} must be 1 to 200 characters that can be printed, in one line")
    for table in ("observers", "scenarios"):
        for name in data.get(table) or {}:
            if not _NAME.fullmatch(name):
                raise InputError(f"{where}: {table}.{name[:60]!r} is not a name; use 1 to 60 letters, digits, spaces, _ + - . "
                                 "beginning with a letter or digit")


def _machine_values(values: Any, where: str, folder: Path | None) -> dict[str, Any]:
    """The table ``[machine]`` with ``file`` replaced by what the file holds."""
    if not isinstance(values, Mapping):
        raise InputError(f'{where}: the table [machine] is missing; write for example preset = "table-iii" in it, or start '
                         "from a whole study: imo study --init FILE")
    values = dict(values)
    if "file" in values:
        name = values.pop("file")
        if not isinstance(name, str):
            raise InputError(f"{where}: machine.file = {name!r} must be the name of a TOML file")
        loaded = InductionMachine.load(str((folder or Path()) / name))
        values = {**loaded.model_dump(), **values}
    return values


def _check_start(name: str, settings: ObserverSettings, machine: InductionMachine) -> None:
    """Refuse a loop closed on an observer whose flux estimate divides by alpha_hat - j omega_hat = 0 at the start."""
    start = dict(zip(OBSERVERS[settings.kind].states, settings.initial_values, strict=True))
    if start.get("alpha_hat") == 0 and start["omega_hat"] == 0:
        raise ValueError(f"observers.{name}.initial.alpha_hat = 0 1/s must be above 0 where drive.feedback = {name!r}: with "
                         f"omega_hat = 0 too there is no flux estimate to begin with; the machine has {machine.alpha:.4g} 1/s")


def _believed(machine: InductionMachine, errors: Mapping[str, float]) -> InductionMachine:
    """The machine with relative errors of its parameters."""
    if not errors:
        return machine
    return machine.with_values(**{key: getattr(machine, key) * (1 + error) for key, error in errors.items()})


def located_table(settings: Any, where: str, folder: Path | None) -> Any:
    """An observer's table; where its kind is a file of one's own, with the file's whole path and the hash of its text."""
    if not isinstance(settings, Mapping) or not isinstance(settings.get("kind"), str):
        return settings
    try:
        return {**settings, "kind": located(settings["kind"], folder)}
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _overlay(overlay: Any, where: str, folder: Path | None) -> Any:
    """A scenario's overlay with its observers' kinds treated likewise."""
    if not isinstance(overlay, Mapping) or not isinstance(overlay.get("observers"), Mapping):
        return overlay
    return {**overlay, "observers": {name: located_table(one, f"{where}.observers.{name}", folder)
                                     for name, one in overlay["observers"].items()}}
