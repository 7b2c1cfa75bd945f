"""``imo excite --design``: the smallest flux modulation for a wanted accuracy, checked in closed loop."""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict
from typing import Any

from imo_analysis.errors import InputError

HOUR = 3600.0  # s


def design_modulation(args: argparse.Namespace) -> int:
    """Design, simulate the design, print both; exit code 1 if the simulation misses the accuracy or a limit."""
    from imo_analysis.commands.output import emit_json, say
    from imo_analysis.excitation.choice import cheapest_by_waveform, passed_over
    from imo_analysis.excitation.design import LIMITS, search
    from imo_analysis.excitation.design_check import plant_of, verified, wanted_of
    from imo_analysis.study import Study

    if args.run:
        raise InputError(f"{args.run!r} and --design exclude each other: a design needs a study, not a run")
    study = Study.paper() if args.design == "paper" else Study.load(args.design)
    observer = _observer(study, args.observer)
    alpha, omega = _positive("--accuracy", args.accuracy or (0.3, 2.0))
    within = _positive("--within", [5.0 if args.within is None else args.within])[0]
    if within > HOUR:
        raise InputError(f"--within {within:g} s must be at most {HOUR:g} s")
    given: dict[str, Any] = {name: _numbers(f"--{name}", text) for name, text in
                             (("speeds", args.speeds), ("torques", args.torques)) if text is not None}
    if args.noise is not None:
        given["noise"] = _positive("--noise", [args.noise])[0]
    wanted = wanted_of(study, observer, alpha, omega, within, **given, **_limits(args.limit))
    plant = plant_of(study, observer)
    able, deepest = search(plant, wanted)
    taken = verified(study, observer, wanted, able, deepest)
    found, checks, chosen = taken.chosen.design, taken.checks, taken.chosen
    waveforms = cheapest_by_waveform(plant, able, wanted)
    tried = [one.frequency for one in (*able, *deepest)]
    say(args, f"flux modulated by {100 * found.depth:.3g} % at {found.frequency:.4g} rad/s, a {_words(found.waveform)} of the "
              f"reference, for observer {observer}: the cheapest from {min(tried):.4g} to {max(tried):.4g} rad/s")
    if chosen.passed or taken.failed:
        say(args, f"  {passed_over(chosen.passed, taken.failed)}")
    say(args, f"  over {_range(wanted.speeds)} rad/s and {_range(wanted.torques)} N m the error of alpha_hat, at first "
              f"{wanted.start:.3g} /s, decays at {found.rate:.3g} 1/s")
    exact = chosen.slowest
    say(args, f"  on average over the modulation (slowest at {found.slowest[0]:.4g} rad/s, {found.slowest[1]:.3g} N m); by "
              f"Floquet's multipliers at most {100 * exact.left:.2g} % of it is left")
    say(args, f"  after {wanted.time:g} s, at {exact.where[0]:.4g} rad/s, {exact.where[1]:.3g} N m, where its slowest part "
              f"decays at {exact.rate:.3g} 1/s; the noise leaves it {found.bias:.3g} /s off")
    say(args, f"  no unbiased estimate can be closer, in {wanted.time:g} s: alpha +- {found.alpha_bound:.2g} /s, "
              f"omega +- {found.omega_bound:.2g} rad/s")
    say(args, f"  costs {found.loss:.3g} W of copper loss; of the limits it uses "
              + ", ".join(limit.share(found, wanted) for limit in LIMITS))
    for other in waveforms:
        if other is not found:
            say(args, f"  a {_words(other.waveform)} would cost {other.loss:.3g} W: {100 * other.depth:.3g} % at "
                      f"{other.frequency:.4g} rad/s, {other.ripple:.2g} N m, peaks of {other.current:.3g} A, "
                      f"{other.voltage:.3g} V")
    say(args, f"in closed loop with {wanted.noise:g} A of noise, {wanted.time:g} s after alpha_hat was off by "
              f"{wanted.start:.3g} /s, to the worse side;")
    say(args, "torque: half the swing that the modulation makes without noise, in brackets the deviation that noise makes "
              "without modulation:")
    for one in checks:
        say(args, f"  {one.omega:4.4g} rad/s, {one.torque:3.3g} N m: alpha {one.alpha_error:+.3f} +- {one.alpha_deviation:.3f} "
                  f"/s, omega {one.omega_error:+.3f} +- {one.omega_deviation:.3f} rad/s, {one.loss:.2f} W, "
                  f"{one.ripple:.4f} N m ({one.noise_torque:.3f})")
    missed = taken.missed(wanted)
    reached = not missed
    say(args, "the wanted accuracy is reached within the limits, by rms errors" if reached else
        f"MISSED in closed loop: {', '.join(missed)}" + (
            "; the deviation of omega is noise that the gains let through, whatever the modulation (imo tune)"
            if "omega" in missed else ""))
    if args.duty:
        from imo_analysis.excitation.duty import mixed_duty
        from imo_analysis.files import write_text

        hour = mixed_duty(study, HOUR, noise=wanted.noise, depth=found.depth, frequency=found.frequency,
                          waveform=found.waveform, off=(HOUR / 4, HOUR * 3 / 4))
        write_text(args.duty, hour.to_toml())
        say(args, f"wrote {args.duty}, its supervisor with S_0 = {hour.observers['supervised'].gains['S_0']:g} A^2; now: "
                  f"imo simulate {args.duty} --out duty.nc")
    emit_json(args, "imo-excitation-design/2", {
        "study": args.design, "observer": observer, "wanted": _without_infinity(asdict(wanted)), "design": asdict(found),
        "floquet_rate": exact.rate, "floquet_left": exact.left, "passed_over": chosen.passed,
        "missed_in_closed_loop": taken.failed,
        "waveforms": [asdict(one) for one in waveforms], "closed_loop": [asdict(one) for one in checks],
        "reached": reached})
    return 0 if reached else 1


def _without_infinity(data: dict[str, Any]) -> dict[str, Any]:
    """None for a limit that is not there."""
    return {name: None if value == math.inf else value for name, value in data.items()}


def _range(values: tuple[float, ...]) -> str:
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _limits(asked: list[str] | None) -> dict[str, float]:
    """The fields of `Wanted` that ``--limit NAME=X`` sets."""
    from imo_analysis.excitation.design import LIMITS

    by_name = {limit.name: limit for limit in LIMITS}
    chosen = {}
    for text in (part for one in asked or () for part in one.split(",")):
        name, _, number = text.partition("=")
        try:
            value = float(number.removesuffix("%") if name in by_name and by_name[name].unit == "%" else number)
        except ValueError:
            value = 0.0
        if name not in by_name or not (math.isfinite(value) and value > 0):
            raise InputError(f"--limit {text!r} must be one of {', '.join(f'{one.name}=X ({one.unit})' for one in LIMITS)}, "
                             "X above 0")
        chosen[by_name[name].wanted] = value / by_name[name].factor
    return chosen


def _words(waveform: str) -> str:
    return waveform.replace("_", " ")


def _observer(study: Any, asked: list[str] | None) -> str:
    """The observer that is asked for, or the study's first one of a kind that a design is known for."""
    from imo_analysis.excitation.settling import KINDS

    able = [name for name, settings in study.observers.items() if settings.kind in KINDS]
    if asked:
        if len(asked) != 1 or asked[0] not in able:
            raise InputError(f"--observer {', '.join(asked)} must be one observer of kind {' or '.join(KINDS)}: "
                             f"{', '.join(able) or 'the study has none'}")
        return asked[0]
    if not able:
        raise InputError(f"the study has no observer of kind {' or '.join(KINDS)}; the paper's own settles at low speed only")
    return able[0]


def _numbers(option: str, text: str) -> tuple[float, ...]:
    try:
        values = tuple(float(word) for word in text.split(","))
    except ValueError:
        values = ()
    if not values or not all(math.isfinite(value) for value in values):
        raise InputError(f'{option} {text!r} must be numbers with commas, for example "20,50,100"')
    return values


def _positive(option: str, values: Any) -> tuple[float, ...]:
    if not all(0 < value < math.inf for value in values):
        raise InputError(f"{option} {' '.join(f'{v:g}' for v in values)} must be above 0 and finite")
    return tuple(values)
