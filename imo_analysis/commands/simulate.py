"""``imo simulate``: run plant, drive and observers of a study."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from imo_analysis.errors import InputError

DESCRIPTION = "Run plant, field-oriented drive and all observers of a study, side by side on the same measurements."
EXAMPLE = "imo simulate --scenario fig1 --out run.nc --plot run.svg\n  imo simulate study.toml --out run.csv"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("study", nargs="?", metavar="STUDY.toml", help="study to run; the paper's where left out")
    parser.add_argument("--out", metavar="FILE", help="write the run: .nc (NetCDF), .csv or .parquet")
    parser.add_argument("--scenario", metavar="NAME", help="overlay [scenarios.NAME] of the study")
    parser.add_argument("--feedback", metavar="NAME", help="the observer that drives, or measured, in place of drive.feedback")
    parser.add_argument("--every", type=int, metavar="N", help="record one sample in N, instead of the study's record_every")
    parser.add_argument("--plot", metavar="FILE.svg", help="draw the speeds; each window of the study goes to FILE-1.svg, ...")


def run(args: argparse.Namespace) -> int:
    """Do it; 0 when done. A diverged run is written as far as it went, then raised."""
    from imo_analysis.commands.output import check_places
    from imo_analysis.simulation.runfile import check_name
    from imo_analysis.study import Study

    if args.out:
        check_name(args.out)
    if args.plot and Path(args.plot).suffix.lower() != ".svg":
        raise InputError(f"--plot {args.plot}: figures are SVG; end the name in .svg")
    check_places(args, "out", "plot")
    study = Study.load(args.study) if args.study else Study.paper()
    if args.scenario:
        study = study.scenario(args.scenario)
    given = {"drive.feedback": args.feedback, "simulation.record_every": args.every}
    study = study.changed({field: value for field, value in given.items() if value is not None})
    data, fault = _simulated(study)
    _write(args, study, data, None if fault is None else str(fault))
    if fault:
        raise fault
    return 0


def _simulated(study: Any) -> Any:
    import sys

    from imo_analysis.simulation.run import simulate_labelled

    if not sys.stderr.isatty():
        return simulate_labelled(study)
    from tqdm import tqdm

    simulation = study.simulation
    with tqdm(total=simulation.duration, desc="starting (the first run of its kind compiles)", leave=False,
              bar_format="{desc} {percentage:3.0f}% |{bar}| {n:.0f} of {total:.0f} s, {remaining} left") as bar:

        def advance(samples: int) -> None:
            bar.set_description(study.title[:32], refresh=False)
            bar.update(samples * simulation.sample_time)

        return simulate_labelled(study, advance)


def _write(args: argparse.Namespace, study: Any, data: Any, fault: str | None) -> None:
    from imo_analysis.commands.output import emit_json, say
    from imo_analysis.simulation.run import overload
    from imo_analysis.simulation.runfile import save_run
    from imo_analysis.simulation.summary import summary

    records = len(data["time"])
    end = records * study.simulation.record_every * study.simulation.sample_time
    say(args, f"{study.title}: {end:g} s of motor time, {records} records")
    if too_much := overload(study):
        say(args, f"  {too_much}")
    if args.out:
        save_run(data, args.out)
    plots = _plot(args, study, data) if args.plot and records > 1 else []
    found = summary(data) if records else {}
    width = max(map(len, [*found, "consistent_12"])) + 1
    for name, one in found.items():
        if one["lost_at"] is not None:
            say(args, f"  {name:<{width}} lost at {one['lost_at']:.4g} s")
        elif one["speed_error_rms"] is None:
            say(args, f"  {name:<{width}} no record after the start")
        else:
            alpha = "" if one["alpha_hat"] is None else f", alpha_hat {one['alpha_hat']:.4f} /s"
            say(args, f"  {name:<{width}} omega_hat {one['omega_hat']:.4f} rad/s{alpha}; second half: "
                      f"speed error rms {one['speed_error_rms']:.4g}, peak {one['speed_error_peak']:.4g} rad/s"
                      + (f"; it ends OFF the speed{_by(one, data, study)}" if one["off"] else ""))
    for path in [*([args.out] if args.out else []), *plots]:
        say(args, f"wrote {path}")
    emit_json(args, schema="imo-simulate/1", data={
        "title": study.title, "study_sha256": study.sha256, "versions": json.loads(data.attrs["versions"]),
        "seed": study.simulation.seed,
        "duration": end, "records": records, "diverged": fault, "observers": found,
        "out": args.out, "plots": plots,
    })


def _by(one: dict[str, Any], data: Any, study: Any) -> str:
    """By how much, in the mean over the last of the run."""
    import numpy as np

    from imo_analysis.simulation.judge import STRETCH, size

    time = np.asarray(data["time"])
    omega = float(np.mean(np.asarray(data["omega"])[time >= time[-1] - STRETCH]))
    error = one["speed_error_end"]
    return "" if error is None else f" by {size(error, omega, study.machine.n_p)}"


def _plot(args: argparse.Namespace, study: Any, data: Any) -> list[str]:
    from imo_analysis.commands.output import say
    from imo_analysis.drawing import save_svg
    from imo_analysis.report.run_figures import speed_figure

    run, name = data.dataset(), args.plot
    save_svg(speed_figure(run), name)
    names = [name]
    end = float(run["time"][-1])
    for n, window in enumerate(study.windows, 1):
        if run.sel(time=slice(window.start, window.stop)).sizes["time"] > 1:
            path = str(Path(name).with_name(f"{Path(name).stem}-{n}.svg"))
            save_svg(speed_figure(run, (window.start, window.stop)), path)
            names.append(path)
            if window.stop > end + study.simulation.record_every * study.simulation.sample_time:
                say(args, f"window {window.title!r} ({window.start:g} to {window.stop:g} s) is drawn to the end of the run")
        else:
            say(args, f"window {window.title!r} ({window.start:g} to {window.stop:g} s) holds no records and is not drawn")
    return names
