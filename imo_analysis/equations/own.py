"""An observer from a file of the user: loaded, checked, and known from then on as ``PATH#HASH`` in place of a name.

The file is a Python module with plain functions and ``OBSERVER = Observer(...)``. The hash is that of its text, so that a study
that was written out, into a run for example, says which text it was; a file that has changed since is refused by it. Loaded
modules are called by the hash alone: the kernels that they are compiled into do not depend on where the file lies.
"""

from __future__ import annotations

import ast
import hashlib
import re
import sys
import types
import warnings
from collections.abc import Container
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any

from imo_analysis.equations import plain
from imo_analysis.equations.observer import PARAMETERS, Observer
from imo_analysis.equations.plant import plant
from imo_analysis.equations.transformation import to_z
from imo_analysis.errors import InputError
from imo_analysis.notation import declare, in_table, symbol

# Names that a run, a pencil or a sweep has already, with another meaning than a state or a gain.
TAKEN = frozenset((
    "i_ds", "i_qs", "u_ds", "u_qs", "phi_dr", "phi_qr", "psi_ds", "psi_qs", "z_1", "z_2", "xi_1", "xi_2", "omega", "omega_m",
    "omega_1", "omega_ref", "omega_load", "direction", "slip", "stator_frequency", "flux", "torque", "T_l", "shaft_torque",
    "time", "t", "observer", "i_ds_meas", "i_qs_meas", "u_ds_told", "u_qs_told", "J", "B", "n_p", "L_s", "L_r", "R_r", "gamma",
    "mu", *PARAMETERS))
# Quantities of the machine that a state NAME_hat estimates.
ESTIMATED = ("i_ds", "i_qs", "phi_dr", "phi_qr", "z_1", "z_2", "xi_1", "xi_2", "omega", *PARAMETERS)
_KIND = re.compile(r"(?P<path>.+\.py)(?:#(?P<mark>[0-9a-f]{12}))?")
_NAME = re.compile(r"\w[\w +.-]{0,59}")
_SIGNATURES = {"rates": ("x", "i", "u", "direction", "p", "gains"), "flux": ("x", "i", "beta")}
_loaded: dict[str, Observer] = {}


def is_file(kind: str) -> bool:
    """Whether an observer's kind is a file, and not a name of the catalogue."""
    return _KIND.fullmatch(kind) is not None


def located(kind: str, folder: Path | None = None) -> str:
    """The kind with its file's whole path and the hash of its text; a name of the catalogue as it is.

    Parameters
    ----------
    kind : str
        ``mine.py``, or ``/whole/path/mine.py#hash``.
    folder : pathlib.Path, optional
        Whence a path is relative; the working directory where left out.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    found = _KIND.fullmatch(kind)
    if found is None:
        return kind
    path = ((folder or Path()) / Path(found["path"]).expanduser()).resolve()
    return f"{path}#{found['mark'] or _mark(_text(path))}"


def shown(kind: str) -> str:
    """A kind as people call it: the file's own name, without folder and hash; a name of the catalogue as it is."""
    return Path(kind.rpartition("#")[0] or kind).name if is_file(kind) else kind


def load(kind: str, known: Container[str] = ()) -> Observer:
    """The observer of a file, checked at the first call.

    Parameters
    ----------
    kind : str
        As `located` gives it.
    known : container of str
        Names that it must not have.

    Raises
    ------
    InputError
        If it cannot be had: the text names the file, where possible the line, and the fix.
    """
    if kind not in _loaded:
        place, _, mark = kind.rpartition("#")
        if not place:
            raise InputError(f"observer = {kind!r} is a file, which may change; give located({kind!r}) of "
                             "imo_analysis.equations.own, which says which text of it is meant")
        text = _text(Path(place))
        if _mark(text) != mark:
            raise InputError(f"{place} has changed: the hash of its text now begins with {_mark(text)}, and what was computed "
                             f"with it has {mark}; compute that again from the study that names the file, or bring the old "
                             "text back")
        _loaded[kind] = _checked(_observer(text, place, mark), text, place, known)
    return _loaded[kind]


def astray(observer: Observer) -> list[str]:
    """The rows in which an observer leaves a machine whose state and parameters it has right, at constant speed.

    Found exactly, at random rational points for both directions of rotation; ``flux_d`` and ``flux_q`` are the estimated flux.
    States that estimate nothing count as zero where the rates of the estimates see them.

    Parameters
    ----------
    observer : Observer
        Any.
    """
    rates, flux = plain.exact(observer.rates), plain.exact(observer.flux)
    random = Random(5)
    found: dict[str, None] = {}
    for direction in (1, -1):
        p, gains, i, phi, u, further = (tuple(_fraction(random) for _ in names) for names in (
            PARAMETERS, observer.gains, "dq", "dq", "dq", observer.states))
        omega = direction * _fraction(random)
        true, moving = _machine(i, phi, u, omega, p)
        bases = [state.removesuffix("_hat") if state.endswith("_hat") else "" for state in observer.states]
        for corrections in (further, (0,) * len(bases)):
            x = tuple(true.get(base, other) for base, other in zip(bases, corrections, strict=True))
            try:
                now = dict(zip(observer.states, rates(x, i, u, direction, p, gains), strict=True))
                estimated = flux(x, i, p[3])
            except ZeroDivisionError:
                raise InputError(f"the rates or the flux of {observer.name} divide by zero where its estimates are right; an "
                                 "error must not stand below a fraction line") from None
            off = [state for state, base in zip(observer.states, bases, strict=True)
                   if (base in true or not any(corrections)) and now[state] != moving.get(base, 0)]
            off += [f"flux_{axis}" for axis, a, b in zip("dq", estimated, phi, strict=True) if a != b]
            if not off:
                break
        found |= dict.fromkeys(off)
    return list(found)


def _machine(i: Any, phi: Any, u: Any, omega: Any, p: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Quantities of the machine that a state may estimate, and the rates of those that move at constant speed."""
    rates = plant((*i, *phi, omega), u, 0, 0, (*p, 0, 0, 1))[:4]

    def every(i_ds: Any, i_qs: Any, phi_dr: Any, phi_qr: Any) -> dict[str, Any]:
        z_1, z_2 = to_z(i_ds, i_qs, phi_dr, phi_qr, p[3])
        return {"i_ds": i_ds, "i_qs": i_qs, "phi_dr": phi_dr, "phi_qr": phi_qr, "z_1": z_1, "z_2": z_2, "xi_1": z_1,
                "xi_2": z_2}

    return {**every(*i, *phi), "omega": omega, **dict(zip(PARAMETERS, p, strict=True))}, every(*rates)


def _text(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read the observer {path}: {error.strerror or error}; an observer of your own is a Python "
                         "file, in its place on every computer that computes with it") from None


def _mark(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()[:12]


def _observer(text: bytes, place: str, mark: str) -> Observer:
    """Run the file and take its OBSERVER."""
    name = f"imo_own_{mark}"
    if name not in sys.modules:
        module = types.ModuleType(name)
        module.__file__ = place
        sys.modules[name] = module  # where generated kernels look for it
        try:
            exec(compile(text, place, "exec", dont_inherit=True), vars(module))
        except (Exception, SystemExit) as error:
            del sys.modules[name]
            raise InputError(f"{place}{_line(error, place)}: {type(error).__name__}: {_flat(error)}") from None
    found = getattr(sys.modules[name], "OBSERVER", None)
    if not isinstance(found, Observer):
        what = "has no OBSERVER" if found is None else f"has OBSERVER = {str(found)[:40]!r}"
        raise InputError(f"{place} {what}; end it with OBSERVER = Observer(name=..., rates=..., states=..., gains=..., "
                         "flux=..., source=..., meaning=...), Observer from imo_analysis.equations.catalogue")
    return found


def _line(error: BaseException, place: str) -> str:
    """Where in the file it happened, as far as that is known."""
    if isinstance(error, SyntaxError) and error.filename == place:
        return f", line {error.lineno}"
    line, trace = None, error.__traceback__
    while trace is not None:
        line = trace.tb_lineno if trace.tb_frame.f_code.co_filename == place else line
        trace = trace.tb_next
    return "" if line is None else f", line {line}"


def _flat(error: BaseException) -> str:
    """The error's text in one line."""
    return " ".join((error.msg if isinstance(error, SyntaxError) else str(error)).split()) or "no more is said"


def _checked(observer: Observer, source: bytes, place: str, known: Container[str]) -> Observer:
    """The observer, if everything about it can be used."""
    if not isinstance(observer.name, str) or not _NAME.fullmatch(observer.name):
        raise InputError(f"{place}: name = {observer.name!r} must be 1 to 60 letters, digits, spaces, _ + - . beginning with a "
                         "letter or digit")
    if observer.name in known:
        raise InputError(f"{place}: name = {observer.name!r} is an observer of the catalogue; choose another")
    for field in ("source", "meaning"):
        text = getattr(observer, field)
        if not (isinstance(text, str) and text.isprintable() and 0 < len(text) <= 200) or {"$", "`"} & {*text}:
            raise InputError(f"{place}: {field} = {str(text)[:60]!r} must be one line of 1 to 200 characters, without $ and `")
    _check_names(observer, place)
    _check_units(observer, place)
    tree = ast.parse(source, place)
    for field, wanted in _SIGNATURES.items():
        function = getattr(observer, field)
        if not isinstance(function, types.FunctionType):
            raise InputError(f"{place}: {field} = {function!r} must be a function of this file")
        if function.__code__.co_argcount != len(wanted):
            raise InputError(f"{place}, line {function.__code__.co_firstlineno}: {function.__name__} takes "
                             f"{function.__code__.co_argcount} arguments; {field} takes {len(wanted)}: ({', '.join(wanted)})")
        plain.check(function, tree, place)
    _check_numbers(observer, place)
    try:
        off = astray(observer)
    except InputError as error:
        raise InputError(f"{place}: {error}") from None
    if off:
        verb = "leaves" if len(off) == 1 else "leave"
        warnings.warn(f"{place}: with right parameters and right estimates {', '.join(off)} {verb} the machine; imo study "
                      "STUDY.toml says by how much", stacklevel=2)
    return observer


def _check_names(observer: Observer, place: str) -> None:
    for field in ("states", "gains"):
        names = getattr(observer, field)
        if not isinstance(names, tuple) or not all(isinstance(name, str) and name.isidentifier() for name in names):
            raise InputError(f"{place}: {field} = {names!r} must be a tuple of names, such as ('omega_hat',)")
        for name in names:
            if name in TAKEN:
                estimate = f"; its estimate is {name}_hat" if field == "states" else ""
                raise InputError(f"{place}: {field[:-1]} {name} is a name of the machine or of a run{estimate}; choose another")
    if {"psi_ds_hat", "psi_qs_hat"} & {*observer.states}:
        raise InputError(f"{place}: states psi_ds_hat, psi_qs_hat: write z_1_hat, z_2_hat, the stator flux over sigma, from "
                         "which flux(x, i, beta) has the rotor flux as (z - i)/beta")
    both = [*observer.states, *observer.gains]
    if twice := [name for name in both if both.count(name) > 1]:
        raise InputError(f"{place}: {twice[0]} is there twice among states and gains; give each a name of its own")
    if "omega_hat" not in observer.states:
        raise InputError(f"{place}: states = {', '.join(observer.states) or 'none'} lack omega_hat, the estimate of the "
                         "electrical speed")


def _check_units(observer: Observer, place: str) -> None:
    """Every state and gain has a unit: the notation's, or the file's."""
    for name in observer.units:
        if name not in (*observer.states, *observer.gains):
            raise InputError(f"{place}: units has {name!r}, which is neither a state nor a gain")
    for name in (*observer.states, *observer.gains):
        given = observer.units.get(name)
        if given is None:
            if not in_table(name):
                raise InputError(f"{place}: {name} is not in the notation; say its unit, units={{{name!r}: '1/s'}}, or '1' for "
                                 "a pure number")
            continue
        if not isinstance(given, str):
            raise InputError(f"{place}: units has {name} in {given!r}, which is not text")
        if not in_table(name):
            try:
                declare(name, given, place)
            except InputError as error:
                raise InputError(f"{place}: {error}") from None
        elif given != symbol(name).unit:
            raise InputError(f"{place}: units has {name} in {given!r}; it is in {symbol(name).unit!r} everywhere")


def _check_numbers(observer: Observer, place: str) -> None:
    """Call both functions once with ordinary numbers."""
    random = Random(3)
    x, i, u, p, gains = (tuple(float(_fraction(random)) for _ in names) for names in (
        observer.states, "dq", "dq", PARAMETERS, observer.gains))
    for field, given, names in (("rates", (x, i, u, 1.0, p, gains), observer.states),
                                ("flux", (x, i, p[3]), ("phi_dr_hat", "phi_qr_hat"))):
        try:
            result = getattr(observer, field)(*given)
        except Exception as error:
            raise InputError(f"{place}{_line(error, place)}: {field} cannot be called with ordinary numbers: "
                             f"{type(error).__name__}: {_flat(error)}") from None
        if not isinstance(result, tuple) or len(result) != len(names):
            what = f"{len(result)} values" if isinstance(result, tuple) else f"a {type(result).__name__}"
            raise InputError(f"{place}: {field} returns {what}; it must return a tuple of {len(names)}: {', '.join(names)}")
        for name, value in zip(names, result, strict=True):
            if not isinstance(value, (int, float)) or not abs(value) < float("inf"):
                raise InputError(f"{place}: {field} gives {str(value)[:40]} for {name} at ordinary numbers; it must be finite")
    if not observer.needs_direction and observer.rates(x, i, u, 1.0, p, gains) != observer.rates(x, i, u, -1.0, p, gains):
        raise InputError(f"{place}: rates depend on direction; say so with needs_direction=True")


def _fraction(random: Random) -> Fraction:
    """A rational number between 1/13 and 97."""
    return Fraction(random.randint(1, 97), random.randint(1, 13))
