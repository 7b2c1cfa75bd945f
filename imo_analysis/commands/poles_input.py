"""What ``imo poles`` is asked for: which observers, at which speeds, over which ranges; every fault named with its bound."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from imo_analysis.errors import InputError

if TYPE_CHECKING:
    from imo_analysis.pencils.setup import Setup

# Faster than any machine turns, in rad/s; far above it the squares of a pencil overflow.
FASTEST = 1e6
# Beyond any gain or parameter, in SI units; far above it rounding is larger than the slow poles.
LARGEST = 1e9


def numbers(text: str) -> list[float]:
    """The speeds of ``--omega``, in rad/s."""
    try:
        values = [float(word) for word in text.split(",")] if text.strip() else []
    except ValueError:
        raise InputError(f"--omega {text} must be numbers with commas between, in rad/s: 30,60,100") from None
    if not values:
        raise InputError("--omega is empty; give at least one speed in rad/s")
    if not all(math.isfinite(value) for value in values):
        raise InputError(f"--omega {text} must be finite, in rad/s")
    if max(map(abs, values)) > FASTEST:
        raise InputError(f"--omega {text} must lie within +-{FASTEST:g} rad/s")
    return values


def chosen(study: Any, args: argparse.Namespace) -> tuple[dict[str, Setup], dict[str, str]]:
    """Every observer that is asked for, by label; and with ``all`` the reasons why others cannot be had."""
    from imo_analysis.equations.catalogue import OBSERVERS
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
    for label in dict.fromkeys([*study.observers, *OBSERVERS]) if every else args.observer or study.observers:
        if label in study.observers:
            settings = study.observers[label]
            setups[label] = Setup(settings.kind, other or study.observer_machine(label), settings.gains)
        elif label in OBSERVERS:
            gains = OBSERVERS[label].gains
            needed = jacobian(label).arguments  # what only the adaptation uses may be missing
            if missing := [gain for gain in gains if gain in needed and gain not in study.known_gains]:
                reason = (f"observer = {label!r} is not in the study, and no observer there has its gains "
                          f"{', '.join(missing)}; add [observers.{label}] to the study")
                if not every:
                    raise InputError(reason)
                refused[label] = reason
            else:
                setups[label] = Setup(label, other or study.machine, {gain: study.known_gains[gain] for gain in gains
                                                                 if gain in study.known_gains})
        else:
            known = ", ".join(dict.fromkeys([*study.observers, *OBSERVERS]))
            raise InputError(f"observer = {label!r} is not known; choose from: {known}")
    if not setups:
        raise InputError("the study has no observers; name one with --observer")
    return setups, refused


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
            raise InputError(f"--at {args.at:g} is the speed of a sweep over something else; for single speeds use --omega")
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


def _range(name: str, text: str, cloud: bool) -> tuple[float, float, int | None]:
    """Both ends, in SI units, and the count."""
    from imo_analysis.pencils.sweep import described
    from imo_analysis.quantity import si_value

    words = [word.strip() for word in text.split(":")]
    form = "START:STOP" if cloud else "START:STOP:COUNT"
    if len(words) != (2 if cloud else 3):
        raise InputError(f"--over {name}={text} must be NAME={form}" + (" with --cloud" if cloud else ""))
    unit = described(name)["units"]
    ends = []
    for word in words[:2]:
        try:
            ends.append(float(word))
        except ValueError:
            ends.append(si_value(word, unit, f"--over {name}"))
    bare = [_is_number(word) for word in words[:2]]
    if bare[0] != bare[1]:
        raise InputError(f"--over {name}={text}: {words[bare.index(True)]} has no unit and {words[bare.index(False)]} has one; "
                         f"give both ends one, or neither for {unit}")
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
