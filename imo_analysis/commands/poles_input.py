"""What ``imo poles`` is asked for: which observers, at which speeds, over which ranges; every fault named with its bound."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from imo_analysis.errors import InputError

if TYPE_CHECKING:
    from imo_analysis.machine import InductionMachine
    from imo_analysis.pencils.setup import Setup

# Faster than any machine turns, in rad/s; far above it the squares of a pencil overflow.
FASTEST = 1e6
# Times the machine's own value, or a part of it: so far off, a number without a unit was meant in another one.
FAR = 20.0
# Beyond any gain or parameter, in SI units; far above it rounding is larger than the slow poles.
LARGEST = 1e9


def numbers(text: str) -> list[float]:
    """The speeds of ``--omega``, in rad/s."""
    words = [word.strip() for word in text.split(",")] if text.strip() else []
    if not words:
        raise InputError("--omega is empty; give at least one speed in rad/s")
    if not all(words):
        raise InputError(f"--omega {text} must be numbers with commas between, in rad/s: 30,60,100")
    _alike(words, "rad/s", f"--omega {text}")
    values = [quantity(word, "rad/s", "--omega") for word in words]
    if not all(math.isfinite(value) for value in values):
        raise InputError(f"--omega {text} must be finite, in rad/s")
    if max(map(abs, values)) > FASTEST:
        raise InputError(f"--omega {text} must lie within +-{FASTEST:g} rad/s")
    return values


def turning(text: str, option: str, what: str) -> float:
    """A speed or slip in rad/s, also written as ``30 rpm``."""
    value = quantity(text, "rad/s", option)
    if not abs(value) <= FASTEST:
        raise InputError(f"{option} {text} must be a {what} within +-{FASTEST:g} rad/s")
    return value


def quantity(word: str, unit: str, where: str) -> float:
    """A bare number, which is in SI, or one with a unit."""
    from imo_analysis.quantity import si_value

    try:
        return float(word)
    except ValueError:
        return si_value(word, unit, where)


def _alike(words: list[str], unit: str, where: str) -> None:
    """All of the words have a unit, or none."""
    bare = [word for word in words if _is_number(word)]
    if bare and len(bare) < len(words):
        other = next(word for word in words if word not in bare)
        raise InputError(f"{where}: {bare[0]} has no unit and {other} has one; give each one, or none for {unit}")


def chosen(study: Any, args: argparse.Namespace) -> tuple[dict[str, Setup], dict[str, str], dict[str, dict[str, float]]]:
    """Every observer that is asked for, by label; with ``all`` the reasons why others cannot be had; gains that are assumed."""
    from imo_analysis.equations.catalogue import OBSERVERS
    from imo_analysis.equations.own import is_file, located
    from imo_analysis.machine import PRESETS, InductionMachine
    from imo_analysis.pencils.jacobian import jacobian
    from imo_analysis.pencils.setup import Setup

    other = None
    if args.machine:
        other = PRESETS[args.machine] if args.machine in PRESETS else InductionMachine.load(args.machine)
    every = args.observer == ["all"]
    if args.observer and "all" in args.observer and not every:
        raise InputError("--observer all stands alone; leave the other names out")
    setups: dict[str, Setup] = {}
    refused: dict[str, str] = {}
    assumed: dict[str, dict[str, float]] = {}
    for label in dict.fromkeys([*study.observers, *OBSERVERS]) if every else args.observer or study.observers:
        kind = located(label) if label not in study.observers else study.observers[label].kind
        if label in study.observers:
            settings = study.observers[label]
            setups[label] = Setup(settings.kind, other or study.observer_machine(label), settings.gains)
        elif label in OBSERVERS or is_file(label):
            gains = OBSERVERS[kind].gains
            needed = jacobian(kind).arguments  # what only the adaptation uses may be missing
            if missing := [gain for gain in gains if gain in needed and gain not in study.known_gains]:
                reason = (f"observer = {label!r} is not in the study, and no observer there has its gains "
                          f"{', '.join(missing)}; " + (f"add [observers.{label}] to the study" if label in OBSERVERS else
                          f'add [observers.NAME] with kind = "{label}" and its gains to the study'))
                if not every:
                    raise InputError(reason)
                refused[label] = reason
                continue
            own = {gain: study.known_gains[gain] for gain in gains if gain in study.known_gains}
            machine = other or study.machine
            if args.full is not None and (more := {**_supervisor(gains, own), **_resistance(gains, own, machine, study.drive)}):
                assumed[label] = more
            setups[label] = Setup(kind, machine, {**own, **assumed.get(label, {})})
        else:
            known = ", ".join(dict.fromkeys([*study.observers, *OBSERVERS]))
            raise InputError(f"observer = {label!r} is not known; choose from: {known}; or a file of your own, mine.py")
    if not setups:
        raise InputError("the study has no observers; name one with --observer")
    return setups, refused, assumed


def _supervisor(gains: Any, own: dict[str, float]) -> dict[str, float]:
    """Gains of the supervisor that no observer of the study has: what ``imo excite --design`` takes where there is no noise."""
    if "eta" not in gains:
        return {}
    from imo_analysis.excitation.duty import ETA, LEAST

    return {gain: value for gain, value in (("eta", ETA), ("S_0", LEAST)) if gain in gains and gain not in own}


def _resistance(gains: Any, own: dict[str, float], machine: InductionMachine, drive: Any) -> dict[str, float]:
    """The gains of the resistance adaptation by the rule of thumb, for the l_1 that an observer of the study has."""
    if "h_s" not in gains or "l_1" not in own or drive is None:
        return {}
    from imo_analysis.replay.gains import resistance_gain, resistance_power

    decay = machine.gamma + machine.alpha + own["l_1"]
    found = {"h_s": float(resistance_gain(machine.alpha, machine.sigma, decay, machine.L_m, drive.flux)),
             "P_0": float(resistance_power(machine.alpha, machine.L_m, drive.flux))}
    return {gain: value for gain, value in found.items() if gain in gains and gain not in own}


def left(setups: dict[str, Setup], refused: dict[str, str], check: Any) -> dict[str, Setup]:
    """The observers for which ``check`` raises no `InputError`; the others are noted with its text, or all refused with it."""
    kept = {}
    for label, setup in setups.items():
        try:
            check(label, setup)
        except InputError as error:
            refused[label] = str(error)
        else:
            kept[label] = setup
    if not kept:
        raise InputError(next(iter(refused.values())))
    return kept


def wanted(args: argparse.Namespace) -> dict[str, tuple[float, float, int | None]] | None:
    """What ``--over`` asks for, by name: both ends, and how many points; None where nothing is swept."""
    if args.show != "decay" and not args.map:
        raise InputError(f"--show {args.show} says what --map draws; add --map FILE.svg")
    if args.over is None:
        if args.cloud is not None:
            raise InputError(f"--cloud {args.cloud} needs ranges: --over NAME=A:B")
        if args.at is not None:
            raise InputError(f"--at {args.at} is the speed of a sweep over something else; for single speeds use --omega")
        return {} if any((args.plot, args.map, args.out)) else None
    over: dict[str, tuple[float, float, int | None]] = {}
    for text in args.over:
        name, sign, range_ = text.rpartition("=")
        if not sign:
            raise InputError(f"--over {text} must be NAME=START:STOP:COUNT, such as omega=-150:150:301")
        name = name.strip()
        if name in over:
            raise InputError(f"--over {name} is given twice; choose two parameters that differ")
        over[name] = _range(name, range_, args.cloud is not None)
    return over


def doubtful(texts: list[str], setups: dict[str, Setup]) -> None:
    """Refuse a range without a unit that is nowhere near the machine's own value: it was meant in another unit.

    Raises
    ------
    InputError
        With the value, the machine's own, and both ways to say what is meant.
    """
    from imo_analysis.pencils.error import MACHINE_FIELDS, machine_parameters
    from imo_analysis.pencils.sweep import described

    machine = next(iter(setups.values())).machine
    own = {name: float(value) for name, value in machine_parameters(machine, {}).items()}
    own |= {name: getattr(machine, name) for name in MACHINE_FIELDS}
    for text in texts:
        name, _, range_ = text.partition("=")
        words = [word.strip() for word in range_.split(":")[:2]]
        if name.strip() not in own or not all(map(_is_number, words)):
            continue
        low, high = sorted(map(float, words))
        there, unit = own[name.strip()], described(name.strip())["units"]
        if low > FAR * there or 0 < high < there / FAR:
            end = low if low > there else high
            raise InputError(
                f"--over {text} has no unit, and {end:g} {unit} is {end / there:.3g} times the machine's {there:.4g} {unit}; "
                f'if it is meant, write the unit: --over "{name.strip()}={words[0]} {unit}:{words[1]} {unit}'
                + "".join(f":{word}" for word in range_.split(":")[2:]) + '"')


def _range(name: str, text: str, cloud: bool) -> tuple[float, float, int | None]:
    """Both ends, in SI units, and the count."""
    from imo_analysis.pencils.sweep import described

    words = [word.strip() for word in text.split(":")]
    form = "START:STOP" if cloud else "START:STOP:COUNT"
    if len(words) != (2 if cloud else 3):
        raise InputError(f"--over {name}={text} must be NAME={form}" + (" with --cloud" if cloud else ""))
    unit = described(name)["units"]
    ends = [quantity(word, unit, f"--over {name}") for word in words[:2]]
    _alike(words[:2], unit, f"--over {name}={text}")
    if not all(map(math.isfinite, ends)):
        raise InputError(f"--over {name}={text} must have finite ends")
    limit = FASTEST if unit == "rad/s" else LARGEST
    if max(map(abs, ends)) > limit:
        raise InputError(f"--over {name}={text} must lie within +-{limit:g}" + ("" if unit == "1" else f" {unit}"))
    if cloud:
        return ends[0], ends[1], None
    try:
        return ends[0], ends[1], int(words[2])
    except ValueError:
        raise InputError(f"--over {name}={text} must be NAME={form} with a whole number of points") from None


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
