"""``imo excite``: persistence of excitation along a run."""

from __future__ import annotations

import argparse
from typing import Any

from imo_analysis.errors import InputError

DESCRIPTION = """Gram matrices of the regressor of (19) over sliding windows of a run: eigenvalues, rank, the directions that
are lost and when, for the printed 6x6 condition, the same with the sign of (12), and the reduced 4x4 one."""
EXAMPLE = """  imo excite run.nc --window 0.5 --plot excitation.svg
  imo excite --design paper --accuracy 0.3 2 --within 5 --noise 0.1"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    parser.usage = "imo excite RUN [options], or imo excite --design STUDY [options]"
    add = parser.add_argument
    add("run", nargs="?", help="run file (.nc, .csv, .parquet); or --design STUDY")
    add("--observer", action="append", metavar="NAME", help="observer, or 'plant': the motion itself (all adaptive)")
    run = parser.add_argument_group("along a run")
    add = run.add_argument
    add("--window", type=float, metavar="S", help="length T of the window (the study's, or 0.1)")
    add("--every", type=float, metavar="S", help="step of the window (a fifth of it)")
    add("--values", choices=("true", "estimated"), metavar="WHICH", help="alpha, omega in B*: true or estimated (true)")
    add("--si", action="store_true", help="no scaling: errors in A, 1/s, rad/s")
    add("--scale", nargs=2, type=float, metavar=("A", "1/S"), help="units for currents and rates")
    add("--threshold", type=float, metavar="X", help="eigenvalues below X times the largest are lost (1e-4)")
    add("--machine", metavar="FILE", help="TOML or preset, for a run without a study")
    add("--plot", metavar="FILE", help="eigenvalues over time as SVG (first observer)")
    add("--out", metavar="FILE", help="all numbers as NetCDF, one file an observer")
    design = parser.add_argument_group("the smallest flux modulation that makes alpha and speed known")
    add = design.add_argument
    add("--design", metavar="STUDY", help="for this study, or 'paper'")
    add("--accuracy", nargs=2, type=float, metavar=("1/S", "RAD/S"), help="of alpha, omega (0.3 2)")
    add("--within", type=float, metavar="S", help="time to reach it (5)")
    add("--noise", type=float, metavar="A", help="noise of each current sample (the study's)")
    add("--limit", action="append", metavar="X", help="flux=5%%,torque=0.2 (N m),current=,voltage=")
    add("--duty", metavar="FILE", help="write a study: an hour of duty with this design")
    add("--speeds", metavar="W,..", help="range, electrical rad/s (tuning.omega)")
    add("--torques", metavar="T,..", help="range, N m (up to tuning.torque)")


_OF_A_RUN = ("window", "every", "values", "si", "scale", "threshold", "machine", "plot", "out")
_OF_A_DESIGN = ("accuracy", "within", "noise", "limit", "duty", "speeds", "torques")


def _one_or_the_other(args: argparse.Namespace) -> None:
    """Refuse options that the other use of the command has: nothing that is given is ignored."""
    others, use, fix = (_OF_A_RUN, "--design", "for a design drop it") if args.design else (
        _OF_A_DESIGN, "a run", "give --design STUDY in place of the run")
    wrong = [f"--{name}" for name in others if getattr(args, name) not in (None, False)]
    if wrong:
        raise InputError(f"{', '.join(wrong)} cannot go with {use}; {fix}")


def run(args: argparse.Namespace) -> int:
    """Compute, print the verdicts and write what was asked for."""
    from imo_analysis.commands.output import check_places, emit_json, say

    _one_or_the_other(args)
    check_places(args, "out", "plot", "duty")
    if args.design:
        from imo_analysis.commands.excite_design import design_modulation

        return design_modulation(args)
    if not args.run:
        raise InputError("a run file is needed, or --design STUDY (see imo excite --help)")
    from imo_analysis.excitation import signals, words
    from imo_analysis.excitation.conditions import NO_SCALE, Scale
    from imo_analysis.excitation.trajectory import THRESHOLD, excitation

    threshold = THRESHOLD if args.threshold is None else args.threshold
    if args.si and args.scale:
        raise InputError("--si and --scale exclude each other; drop one")
    scale = NO_SCALE if args.si else None
    if args.scale:
        if min(args.scale) <= 0:
            raise InputError(f"--scale {args.scale[0]:g} {args.scale[1]:g}: both must be above 0")
        scale = Scale(*args.scale)
    results = []
    with signals.open_file(args.run, _machine(args.machine)) as source:
        observers = args.observer or signals.adaptive_observers(source) or [signals.PLANT]
        window, every = _window(args, source.attributes)
        for name in observers:
            chosen = signals.select(source, name, args.values or "true")
            results.append(excitation(chosen, window, every=every, scale=scale, threshold=threshold))
    for result in results:
        say(args, words.verdict(result))
    scaling = results[0].attrs["scaling"]
    say(args, f"A direction is lost where its eigenvalue is below {threshold:g} of the largest; {scaling}.")
    _write(args, results, observers)
    emit_json(args, "imo-excitation/1", {"run": args.run, "observers": [words.summary(result) for result in results]})
    return 0


def _machine(name: str | None) -> Any:
    """The machine that a record without a study is of; None where none is given."""
    from imo_analysis.machine import PRESETS, InductionMachine

    if name is None or name in PRESETS:
        return PRESETS.get(name) if name else None
    return InductionMachine.load(name)


def _window(args: argparse.Namespace, attributes: Any) -> tuple[float, float | None]:
    """The window: the command's, else the one of the study in the run, else 0.1 s."""
    if args.window is not None:
        return args.window, args.every
    import tomllib

    try:
        table = tomllib.loads(attributes.get("study", "")).get("excitation", {})
        return float(table.get("window", 0.1)), table.get("every") if args.every is None else args.every
    except (tomllib.TOMLDecodeError, TypeError, ValueError, AttributeError):
        return 0.1, args.every


def _write(args: argparse.Namespace, results: list[Any], observers: list[str]) -> None:
    from imo_analysis.commands.output import say

    if args.plot:
        from imo_analysis.drawing import save_svg
        from imo_analysis.excitation.figures import plot_excitation

        save_svg(plot_excitation(results[0]), args.plot)
        say(args, f"wrote {args.plot}")
    if args.out:
        from imo_analysis.excitation.trajectory import save

        for path in save(dict(zip(observers, results, strict=True)), args.out):
            say(args, f"wrote {path}")
