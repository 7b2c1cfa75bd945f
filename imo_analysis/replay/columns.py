"""Which column of a recorded log is what, and in which unit: by flags, or by the names that people commonly give.

A column has a role: ``time``; ``u_a u_b u_c`` (phase voltages), ``u_ab u_bc u_ca`` (line to line), ``u_d u_q`` (stationary
frame); ``i_a i_b i_c`` or ``i_d i_q``; ``omega_m`` (shaft speed) or ``omega`` (electrical speed, pole pairs times the shaft's).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from imo_analysis.errors import InputError
from imo_analysis.quantity import RPM

UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9},
    "voltage": {"V": 1.0, "mV": 1e-3, "kV": 1e3},
    "current": {"A": 1.0, "mA": 1e-3, "kA": 1e3},
    "speed": {"rad/s": 1.0, **dict.fromkeys(RPM, math.pi / 30), "Hz": 2 * math.pi, "rev/s": 2 * math.pi,
              "deg/s": math.pi / 180},
}
_QUANTITY = {"time": "time", "u": "voltage", "i": "current", "omega": "speed", "omega_m": "speed"}
ROLES = ("time", "u_a", "u_b", "u_c", "u_ab", "u_bc", "u_ca", "u_d", "u_q", "i_a", "i_b", "i_c", "i_d", "i_q",
         "omega", "omega_m")

# What a name may look like once its unit is taken off, in lower case with the separators out. Phases are a b c, 1 2 3, L1 L2 L3
# or U V W.
_PHASE = r"(a|b|c|l?[123]|u|v|w)"
_LINE = r"(ab|bc|ca|12|23|31|l1l2|l2l3|l3l1|uv|vw|wu)"
_NAMES = (
    (re.compile(r"t|time|timestamp|sec|seconds|zeit|ms"), "time"),
    (re.compile(rf"[uv]s?{_LINE}"), "u_{0}"),
    (re.compile(rf"[uv]s?{_PHASE}n?"), "u_{0}"),
    (re.compile(rf"is?{_PHASE}"), "i_{0}"),
    (re.compile(r"[uv]s?(alpha|beta|al|be|ds|qs|d|q)s?"), "u_{0}"),
    (re.compile(r"is?(alpha|beta|al|be|ds|qs|d|q)s?(meas)?"), "i_{0}"),
    (re.compile(r"omega|omegae|omegael|we|wel|electricalspeed"), "omega"),
    (re.compile(r"omegam|omegamech|wm|wmech|speed|speedm|shaftspeed|rotorspeed|mechanicalspeed|n|nmech|rpm|drehzahl"),
     "omega_m"),
)
# "UV" may be the voltage between two phases or that of phase V; "vV", "U_V" and "iV" are not in doubt
_DOUBT = re.compile(r"[uv]{2}|[uv]w|UVN?|[UV]W|VU")
_AXES = {
    "alpha": "d", "al": "d", "ds": "d", "beta": "q", "be": "q", "qs": "q",
    "1": "a", "2": "b", "3": "c", "l1": "a", "l2": "b", "l3": "c", "u": "a", "v": "b", "w": "c",
    "12": "ab", "23": "bc", "31": "ca", "l1l2": "ab", "l2l3": "bc", "l3l1": "ca", "uv": "ab", "vw": "bc", "wu": "ca",
}
_SUFFIXES = {
    "s": "s", "ms": "ms", "us": "us", "ns": "ns", "sec": "s", "V": "V", "mV": "mV", "kV": "kV", "A": "A", "mA": "mA",
    "kA": "kA", "rad_per_s": "rad/s", "rad_s": "rad/s", "radps": "rad/s", "rads": "rad/s", "rpm": "rpm", "Hz": "Hz",
    "deg_per_s": "deg/s",
}
_SPELT = {"sec": "s", "seconds": "s", "Volt": "V", "volt": "V", "Amp": "A", "Ampere": "A", "RPM": "rpm", "min⁻¹": "min^-1"}
_WRITTEN = sorted({*(unit for units in UNITS.values() for unit in units), *_SPELT}, key=len, reverse=True)
_BRACKET = re.compile(r"^(.*?)[\s_]*[\[(]\s*([^\])]*?)\s*[\])]$")


@dataclass(frozen=True)
class Column:
    """A column that is used: its name in the file, its role, its unit there, and what turns it into SI."""

    name: str
    role: str
    unit: str

    @property
    def factor(self) -> float:
        """Multiplies what is in the file to give SI."""
        return UNITS[quantity(self.role)][self.unit]

    @property
    def text(self) -> str:
        """In words, for people."""
        return f"{self.role} = column {self.name!r} in {self.unit}"


def quantity(role: str) -> str:
    """``time``, ``voltage``, ``current`` or ``speed``."""
    return _QUANTITY.get(role) or _QUANTITY[role[0]]


def recognise(name: str) -> tuple[str, str | None] | None:
    """Role of a column by its name, and its unit where the name says one; None for a name that is not known."""
    bare, unit = _unit_apart(name.strip())
    flat = re.sub(r"[\s_.\-]+", "", bare).lower()
    if flat in ("rpm", "ms"):
        unit = unit or flat
    if _DOUBT.fullmatch(bare):
        return None
    for pattern, role in _NAMES:
        match = pattern.fullmatch(flat)
        if match:
            found = role.format(*(_AXES.get(part, part) for part in match.groups() if part)) if match.groups() else role
            if unit is None or unit in UNITS[quantity(found)]:
                return found, unit
    return None


def _unit_apart(name: str) -> tuple[str, str | None]:
    match = _BRACKET.match(name)
    if match:
        return match[1].removesuffix("/").rstrip(), _SUFFIXES.get(match[2], _SPELT.get(match[2], match[2]))
    for written in _WRITTEN:
        head = name.removesuffix(written).rstrip()
        if name.endswith(written) and head.endswith("/"):
            return head.removesuffix("/").rstrip(), _SPELT.get(written, written)
    for suffix, unit in sorted(_SUFFIXES.items(), key=lambda pair: -len(pair[0])):
        if name.endswith("_" + suffix) and name[:-2].lower() not in ("u", "v", "i"):  # "U_V" is a phase
            return name.removesuffix("_" + suffix), unit
    return name, None


def role_of(written: str) -> str:
    """The role that a flag or a study names, such as ``ia``, ``i_alpha`` or ``speed``.

    Raises
    ------
    InputError
        If it is none.
    """
    found = recognise(written)
    if found is None or found[1] is not None:
        raise InputError(f"column {written!r} is not something that a log can have; choose from: {', '.join(ROLES)}")
    return found[0]


def choose(
    header: Sequence[str], columns: Mapping[str, str], units: Mapping[str, str], where: str, timed: bool = True
) -> list[Column]:
    """The columns to read.

    Parameters
    ----------
    header : sequence of str
        Names in the file.
    columns : mapping
        Role (or a common name of it) to column name: what the user said. A name ``none`` leaves that role out.
    units : mapping
        Role, column, or ``time``, ``voltage``, ``current``, ``speed``, to the unit in the file.
    where : str
        The file, for error texts.
    timed : bool
        Whether a time column is wanted.

    Raises
    ------
    InputError
        If something needed is missing, is there twice, or has a unit of another quantity.
    """
    said = {role_of(role): name for role, name in columns.items()}
    for role, name in said.items():
        if name != "none" and name not in header:
            raise InputError(f"{where}: there is no column {name!r} for {role}; it has: {', '.join(header)}")
    found: dict[str, list[Column]] = {}
    for name in header:
        roles = [role for role, wanted in said.items() if wanted == name]
        known = recognise(name)
        if not roles and known and known[0] not in said:
            roles = [known[0]]
        for role in roles:
            unit = known[1] if known else _unit_apart(name.strip())[1]
            unit = unit if unit in UNITS[quantity(role)] else None
            found.setdefault(role, []).append(Column(name, role, _unit(role, name, header, units) or unit or _si(role)))
    for role, several in found.items():
        measured = [column for column in several if "meas" in column.name]
        if len(several) > 1 and len(measured) == 1:
            found[role] = several = measured
        if len(several) > 1:
            names = ", ".join(repr(column.name) for column in several)
            raise InputError(f"{where}: {names} all look like {role}; say which with --column {role}=NAME")
    chosen = {role: several[0] for role, several in found.items()}
    if timed and "time" not in chosen:
        raise InputError(
            f"{where}: no time column among {', '.join(header)}; say which with --column time=NAME, or give --rate in Hz"
        )
    return [*([chosen["time"]] if timed else []), *_pick(chosen, "u", where), *_pick(chosen, "i", where), *_speed(chosen)]


def _si(role: str) -> str:
    return next(iter(UNITS[quantity(role)]))


def _unit(role: str, name: str, header: Sequence[str], units: Mapping[str, str]) -> str | None:
    """The unit that the user said for a column: by its name, its role or its quantity."""
    for written, unit in units.items():
        a_role = written not in header and written not in UNITS
        meant = written in (name, quantity(role)) or (a_role and role_of(written) == role)
        if meant and unit not in UNITS[quantity(role)]:
            raise InputError(f"unit {written}={unit} is not known; choose one of: {', '.join(UNITS[quantity(role)])}")
        if meant:
            return unit
    return None


def _pick(chosen: Mapping[str, Column], letter: str, where: str) -> list[Column]:
    """The smallest complete set: stationary frame, else phases (two or three), else two line-to-line voltages."""
    word = {"u": "voltages", "i": "currents"}[letter]
    has = {role[2:]: column for role, column in chosen.items() if role.startswith(letter + "_")}
    if "d" in has and "q" in has:
        return [has["d"], has["q"]]
    phases = [has[name] for name in "abc" if name in has]
    if len(phases) >= 2:
        return phases
    lines = [has[name] for name in ("ab", "bc", "ca") if name in has]
    if len(lines) >= 2:
        return lines
    have = ", ".join(column.name for column in has.values()) or "none"
    raise InputError(
        f"{where}: not enough {word} (found: {have}); it takes {letter}_a, {letter}_b and {letter}_c, or two of them, or "
        f"{letter}_alpha and {letter}_beta: name them with --column {letter}_a=NAME"
    )


def _speed(chosen: Mapping[str, Column]) -> list[Column]:
    return [chosen[role] for role in ("omega_m", "omega") if role in chosen][:1]
