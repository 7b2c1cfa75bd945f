"""``imo sweep``: Monte Carlo and grids over any field of a study."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from imo_analysis.errors import InputError

DESCRIPTION = """Run a study many times, as its table [sweep] says, and judge every observer in every run.
The result is one labelled data set (NetCDF). Finished chunks are kept beside it while the sweep runs: after a crash or Ctrl-C,
--resume goes on where it was, with the same result to the bit. With --sensorless in place of [sweep]: the loop closed on each
observer in turn, over speed and load up to the rated ones, and how far off the stator resistance may be."""
EXAMPLE = """imo study --init study.toml
  imo sweep study.toml --out sweep.nc --plot sweep.svg
  imo sweep study.toml --sensorless --out map.nc --plot map.svg
  imo sweep study.toml --out sweep.nc --resume --scheduler tcp://host:8786"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("study", nargs="?", metavar="STUDY.toml", help="study with a table [sweep]; the paper's where left out")
    parser.add_argument("--scenario", metavar="NAME", help="scenario to sweep, instead of the one in [sweep]")
    parser.add_argument("--runs", type=int, metavar="N", help="random draws, instead of those in [sweep]")
    parser.add_argument("--out", metavar="FILE.nc", default="sweep.nc", help="the data set (default sweep.nc)")
    parser.add_argument("--plot", metavar="FILE.svg", help="draw where each observer holds")
    parser.add_argument("--sensorless", action="store_true", help="where the loop closed on each estimate holds")
    parser.add_argument("--resume", action="store_true", help="go on with a sweep that was not finished")
    parser.add_argument("--jobs", type=int, metavar="N", help="threads; one for each processor where left out")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="compute on the dask cluster there; needs imo-analysis[sweep]")


def run(args: argparse.Namespace) -> int:
    """Do it; 0 when done, 1 when some runs could not be made."""
    from imo_analysis.commands.output import check_places, emit_json, say
    from imo_analysis.study import Study

    out = Path(args.out)
    if out.suffix != ".nc":
        raise InputError(f"--out = {args.out} must end in .nc (NetCDF)")
    if args.plot and Path(args.plot).suffix != ".svg":
        raise InputError(f"--plot = {args.plot} must end in .svg")
    if args.jobs is not None and args.jobs < 1:
        raise InputError(f"--jobs = {args.jobs} must be 1 or more")
    if args.runs is not None and args.runs < 1:
        raise InputError(f"--runs = {args.runs} must be 1 or more")
    check_places(args, "out", "plot")
    study = Study.load(args.study) if args.study else Study.paper()
    if args.sensorless:
        return _sensorless(args, study, out)
    changed: dict[str, Any] = {}
    if args.scenario is not None:
        study.scenario(args.scenario)
        changed["sweep.scenario"] = args.scenario
    if args.runs is not None:
        changed["sweep.runs"] = args.runs
    if changed:
        study = study.changed(changed)
    data = _computed(args, study, out)
    possible = int(data["possible"].sum())
    sweep = study.sweep
    lines = [f"{data.sizes['run']} runs of {data.attrs['title']}, {possible} of them possible; written to {out}",
             f"  holds: within {sweep.band:g} rad/s for the last {sweep.hold:g} s"]
    refused = _refused(data)
    lines += [f"  {count} not made: {text}" for text, count in refused.items()]
    summary = _table(data)
    lines += [f"  {name:<16} holds in {line['holds']:6.1%} of the possible runs, diverged in {line['diverged']:.1%}; "
              f"rms speed error: median {line['speed_rms_median']:.3g}, 95 % below {line['speed_rms_95']:.3g} rad/s"
              for name, line in summary.items()]
    if args.plot:
        from imo_analysis.drawing import save_svg
        from imo_analysis.report.sweep_figures import sweep_figure

        save_svg(sweep_figure(data), args.plot)
        lines.append(f"  drawn in {args.plot}")
    say(args, "\n".join(lines))
    emit_json(args, schema="imo-sweep/1", data={
        "study_sha256": data.attrs["study_sha256"], "out": str(out), "plot": args.plot, "runs": data.sizes["run"],
        "possible": possible, "refused": refused, "observers": summary,
    })
    return 1 if refused else 0


def _sensorless(args: argparse.Namespace, study: Any, out: Path) -> int:
    """The map of speed and load: `imo_analysis.sweeps.sensorless_map.study_map`."""
    from imo_analysis.commands.output import emit_json, say
    from imo_analysis.files import replacing
    from imo_analysis.report.own import limits_of, within
    from imo_analysis.simulation.judge import criterion
    from imo_analysis.simulation.runfile import write_netcdf
    from imo_analysis.sweeps.sensorless_map import study_map

    given = [name for name in ("scenario", "runs", "resume", "scheduler") if getattr(args, name)]
    if given:
        raise InputError(f"--{given[0]} does not go with --sensorless, which has its own runs; leave it out")
    if not study.observers:
        raise InputError("the study has no observers; add at least one table [observers.NAME]")
    plane = study_map(study, jobs=args.jobs)
    with replacing(out) as beside:
        write_netcdf(plane, beside)
    high = 100 * plane.attrs["R_s_error"]
    lines = [f"{plane.sizes['omega']} speeds up to {float(plane['omega'].max()):g} rad/s by {plane.sizes['T_l']} loads up to "
             f"{float(plane['T_l'].max()):g} N m, sensorless, R_s believed {high:g} % too high; written to {out}",
             f"  holds: estimate and speed are the wanted one within {criterion()}"]
    found = {}
    for name in plane["observer"].values:
        one = plane.sel(observer=name)
        limits = limits_of(one)
        share = float(one["holds"].mean())
        found[str(name)] = {"holds": share, "limits": [
            {"omega": limit.omega, "R_s_low": _finite(limit.low), "R_s_high": _finite(limit.high)} for limit in limits]}
        lines.append(f"  {name:<16} holds at {share:.0%} of the points; at {plane.attrs['limit_torque']:.4g} N m "
                     + "; ".join(f"and {limit.omega:.4g} rad/s {within(limit)}" for limit in limits))
    if args.plot:
        from imo_analysis.drawing import save_svg
        from imo_analysis.report.sensorless_figure import sensorless_figure

        save_svg(sensorless_figure(plane), args.plot)
        lines.append(f"  drawn in {args.plot}")
    say(args, "\n".join(lines))
    emit_json(args, schema="imo-sensorless/1", data={
        "study_sha256": study.sha256, "out": str(out), "plot": args.plot, "torque": plane.attrs["limit_torque"],
        "observers": found})
    return 0


def _finite(value: float) -> float | None:
    return value if value == value else None


def _computed(args: argparse.Namespace, study: Any, out: Path) -> Any:
    """The data set, computed chunk by chunk with what was there before."""
    from tqdm import tqdm

    from imo_analysis.files import replacing
    from imo_analysis.simulation.runfile import write_netcdf
    from imo_analysis.sweeps.parts import Parts
    from imo_analysis.sweeps.sweep import Plan, assembled, check_possible, connected, locally, on_cluster

    plan = Plan(study)
    client = connected(args.scheduler) if args.scheduler is not None else None
    kept = Parts(plan, out, args.resume)
    parts = kept.done()
    wanted = [chunk.number for chunk in plan.chunks if chunk.number not in parts]
    before = sum(len(part["possible"]) for part in parts.values())
    with tqdm(total=plan.runs, initial=before, unit="run", desc="sweep", file=sys.stderr, disable=None, smoothing=0.1) as bar:
        try:
            for number, part in on_cluster(plan, wanted, client) if client else locally(plan, wanted, args.jobs):
                kept.keep(number, part)
                parts[number] = part
                bar.update(len(part["possible"]))
        except KeyboardInterrupt:
            bar.close()
            raise KeyboardInterrupt(f"interrupted; {len(parts)} of {len(plan.chunks)} chunks are kept in {kept.path}: the same "
                                    "command with --resume goes on with them, or remove the folder") from None
    check_possible(plan, parts)
    data = assembled(plan, parts)
    with replacing(out) as beside:
        # the convention by which a reader knows the swept fields for coordinates
        write_netcdf(data.assign_attrs(coordinates=" ".join(plan.fields)), beside)
    kept.remove()
    return data


def _refused(data: Any) -> dict[str, int]:
    import json

    return {str(text): int(count) for text, count in json.loads(data.attrs["refused"]).items()}


def _table(data: Any) -> dict[str, dict[str, float]]:
    """Shares and quantiles over the possible runs, for each observer."""
    import numpy as np

    possible = data["possible"].values == 1
    table = {}
    for name in data["observer"].values:
        one = data.sel(observer=name)
        rms = one["speed_rms"].values[possible]
        table[str(name)] = {
            "holds": float(one["holds"].values[possible].mean()),
            "diverged": float(np.isfinite(one["diverged_at"].values[possible]).mean()),
            "speed_rms_median": float(np.nanmedian(rms)),
            "speed_rms_95": float(np.nanquantile(rms, 0.95)),
        }
    return table
