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
    parser.add_argument("run", nargs="?", help="run file (.nc, .csv, .parquet)")
    parser.add_argument("--window", type=float, metavar="S", help="length T of the window (the study's, or 0.1)")
    parser.add_argument("--every", type=float, metavar="S", help="step of the window (a fifth of it)")
    parser.add_argument("--observer", action="append", metavar="NAME",
                        help="observer, or 'plant': the motion itself (all adaptive)")
    parser.add_argument("--values", choices=("true", "estimated"), default="true", help="alpha and omega in B*")
    parser.add_argument("--si", action="store_true", help="no scaling: errors in A, 1/s, rad/s")
    parser.add_argument("--scale", nargs=2, type=float, metavar=("A", "1/S"), help="units for currents and rates")
    parser.add_argument("--threshold", type=float, default=1e-4, metavar="X",
                        help="eigenvalues below X times the largest are lost (1e-4)")
    parser.add_argument("--plot", metavar="FILE", help="eigenvalues over time as SVG (first observer)")
    parser.add_argument("--out", metavar="FILE", help="all numbers as NetCDF, one file an observer")
    parser.add_argument("--design", metavar="STUDY", help="smallest flux modulation for a study, or 'paper'; with")
    parser.add_argument("--accuracy", nargs=2, type=float, default=(0.3, 2.0), metavar=("1/S", "RAD/S"), help="of alpha, omega")
    parser.add_argument("--within", type=float, default=5.0, metavar="S", help="time to reach it")
    parser.add_argument("--noise", type=float, metavar="A", help="noise of each current sample (the study's)")
    parser.add_argument("--limit", nargs="+", action="extend", metavar="X", help="flux=5%% torque=0.2 (N m) current= voltage=")
    parser.add_argument("--duty", metavar="FILE", help="write a study: an hour of duty with this design")
    parser.add_argument("--speeds", metavar="W,..", help="range, electrical rad/s (tuning.omega)")
    parser.add_argument("--torques", metavar="T,..", help="range, N m (up to tuning.torque)")


def run(args: argparse.Namespace) -> int:
    """Compute, print the verdicts and write what was asked for."""
    from imo_analysis.commands.output import check_places, emit_json, say

    check_places(args, "out", "plot", "duty")
    if args.duty and not args.design:
        raise InputError("--duty needs --design STUDY, whose modulation it runs")
    if args.design:
        from imo_analysis.commands.excite_design import design_modulation

        return design_modulation(args)
    if not args.run:
        raise InputError("a run file is needed, or --design STUDY (see imo excite --help)")
    from imo_analysis.excitation import signals, words
    from imo_analysis.excitation.conditions import NO_SCALE, Scale
    from imo_analysis.excitation.trajectory import excitation

    if args.si and args.scale:
        raise InputError("--si and --scale exclude each other; drop one")
    scale = NO_SCALE if args.si else None
    if args.scale:
        if min(args.scale) <= 0:
            raise InputError(f"--scale {args.scale[0]:g} {args.scale[1]:g}: both must be above 0")
        scale = Scale(*args.scale)
    results = []
    with signals.open_file(args.run) as source:
        observers = args.observer or signals.adaptive_observers(source) or [signals.PLANT]
        window, every = _window(args, source.attributes)
        for name in observers:
            chosen = signals.select(source, name, args.values)
            results.append(excitation(chosen, window, every=every, scale=scale, threshold=args.threshold))
    for result in results:
        say(args, words.verdict(result))
    scaling = results[0].attrs["scaling"]
    say(args, f"A direction is lost where its eigenvalue is below {args.threshold:g} of the largest; {scaling}.")
    _write(args, results, observers)
    emit_json(args, "imo-excitation/1", {"run": args.run, "observers": [words.summary(result) for result in results]})
    return 0


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
