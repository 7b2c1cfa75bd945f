"""``imo excite --design``: the smallest flux modulation for a wanted accuracy, checked in closed loop."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import Any

from imo_analysis.errors import InputError

HOUR = 3600.0  # s


def design_modulation(args: argparse.Namespace) -> int:
    """Design, simulate the design with noise, print both; exit code 1 if the simulation misses the accuracy."""
    from imo_analysis.commands.output import emit_json, say
    from imo_analysis.excitation.design import Wanted, cheapest_by_waveform, design, verify
    from imo_analysis.study import Study

    if args.run:
        raise InputError(f"{args.run!r} and --design exclude each other: a design needs a study, not a run")
    study = Study.paper() if args.design == "paper" else Study.load(args.design)
    observer = _observer(study, args.observer)
    settings = study.observers[observer]
    start = abs(dict(settings.initial).get("alpha_hat", study.machine.alpha) - study.machine.alpha)
    alpha, omega = _positive("--accuracy", args.accuracy)
    within, noise = _positive("--within", [args.within])[0], _positive("--noise", [args.noise])[0]
    wanted = Wanted(
        alpha, omega, within, start, _numbers("--speeds", args.speeds), _numbers("--torques", args.torques), noise,
        current_limit=study.drive.current_limit, voltage_limit=study.drive.voltage_limit)
    squares = settings.kind == "repaired"
    found, tried = design(study.machine, settings.gains, study.drive.flux, wanted, squares_noise=squares,
                          drive=study.drive)
    waveforms = cheapest_by_waveform(tried, wanted)
    checks = verify(study, found, wanted, observer)
    say(args, f"flux modulated by {100 * found.depth:.3g} % at {found.frequency:.4g} rad/s, a {_words(found.waveform)} of the "
              f"reference, for observer {observer}:")
    say(args, f"  the error of alpha_hat decays as exp(-{found.rate:.3g} t), t in s; the noise leaves it "
              f"{found.bias:.3g} /s off")
    say(args, f"  no unbiased estimate can be closer, in {wanted.time:g} s: alpha +- {found.alpha_bound:.2g} /s, "
              f"omega +- {found.omega_bound:.2g} rad/s")
    say(args, f"  costs {found.loss:.3g} W of copper loss, peaks of {found.current:.3g} A and {found.voltage:.3g} V")
    for other in waveforms:
        if other is not found:
            say(args, f"  a {_words(other.waveform)} would cost {other.loss:.3g} W: {100 * other.depth:.3g} % at "
                      f"{other.frequency:.4g} rad/s, peaks of {other.current:.3g} A and {other.voltage:.3g} V")
    say(args, f"in closed loop with {wanted.noise:g} A of noise, after {wanted.time:g} s:")
    for one in checks:
        say(args, f"  {one.omega:4g} rad/s, {one.torque:3g} N m: alpha {one.alpha_error:+.3f} +- {one.alpha_deviation:.3f} /s, "
                  f"omega {one.omega_error:+.3f} +- {one.omega_deviation:.3f} rad/s, {one.loss:.2f} W, "
                  f"torque ripple {one.torque_ripple:.3f} N m ({one.torque_ripple_before:.3f} before)")
    reached = all(abs(one.alpha_error) <= wanted.alpha and abs(one.omega_error) <= wanted.omega for one in checks)
    say(args, "the wanted accuracy is reached" if reached else "the wanted accuracy is MISSED in closed loop")
    if args.duty:
        from imo_analysis.excitation.duty import mixed_duty
        from imo_analysis.files import write_text

        write_text(args.duty, mixed_duty(study, HOUR, noise=noise, depth=found.depth, frequency=found.frequency,
                                         off=(HOUR / 4, HOUR * 3 / 4)).to_toml())
        say(args, f"wrote {args.duty}; now: imo simulate {args.duty} --out duty.nc")
    emit_json(args, "imo-excitation-design/1", {
        "study": args.design, "observer": observer, "wanted": asdict(wanted), "design": asdict(found),
        "waveforms": [asdict(one) for one in waveforms], "closed_loop": [asdict(one) for one in checks], "reached": reached})
    return 0 if reached else 1


def _words(waveform: str) -> str:
    return waveform.replace("_", " ")


def _observer(study: Any, asked: list[str] | None) -> str:
    """The observer that is asked for, or the study's first one of a kind that a design is known for."""
    kinds = ("repaired", "quiet")
    able = [name for name, settings in study.observers.items() if settings.kind in kinds]
    if asked:
        if len(asked) != 1 or asked[0] not in able:
            raise InputError(f"--observer {', '.join(asked)} must be one observer of kind {' or '.join(kinds)}: "
                             f"{', '.join(able) or 'the study has none'}")
        return asked[0]
    if not able:
        raise InputError(f"the study has no observer of kind {' or '.join(kinds)}; the paper's own does not settle")
    return able[0]


def _numbers(option: str, text: str) -> tuple[float, ...]:
    import math

    try:
        values = tuple(float(word) for word in text.split(","))
    except ValueError:
        values = ()
    if not values or not all(math.isfinite(value) for value in values):
        raise InputError(f'{option} {text!r} must be numbers with commas, for example "20,50,100"')
    return values


def _positive(option: str, values: Any) -> tuple[float, ...]:
    if not all(value > 0 for value in values):
        raise InputError(f"{option} {' '.join(f'{v:g}' for v in values)} must be above 0")
    return tuple(values)
