"""``imo replay``: run observers over a recorded log."""

from __future__ import annotations

import argparse
import math
import warnings
from pathlib import Path
from typing import Any

from imo_analysis.errors import InputError

DESCRIPTION = """Run observers over a recorded log (CSV or Parquet) of phase or two-phase voltages and currents, with or without
a measured speed. Columns and units are made out by their names and printed; a record that does not fit is named, not run."""
EXAMPLE = """  imo replay log.csv --machine machine.toml --observer repaired --out est.nc
  imo replay log.csv --machine machine.toml --column time=t --column ia=Ch1 --unit current=mA --voltage held"""

_VOLTAGE = ("linear", "held", "averaged")
_CURRENT = ("linear", "held")
_DIRECTION = ("measured", "estimated", "forward", "reverse")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.usage = "imo replay LOG --machine FILE [options]"
    add = parser.add_argument
    add("log", metavar="LOG", help="CSV with a header line, or .parquet")
    add("--machine", metavar="FILE", required=True, help="TOML with [machine] and perhaps [replay], or a preset")
    add("--observer", action="append", metavar="NAME", help="or mine.py, more by commas, or all (default: repaired)")
    add("--out", metavar="EST.nc", help="write the estimates")
    add("--every", type=int, default=1, metavar="N", help="write one sample in N")
    add("--plot", metavar="FILE.svg", help="draw the speeds and their errors")
    add("--column", action="append", default=[], metavar="WHAT=NAME",
        help="time; ua ub uc, uab ubc uca, u_alpha u_beta; ia ib ic, i_alpha i_beta; omega (electrical), omega_m (shaft)")
    add("--unit", action="append", default=[], metavar="WHAT=UNIT", help="of a column, or of time, voltage, current, speed")
    add("--rate", metavar="HZ", help="samples a second, in place of the time column: 10000, 10kHz")
    add("--voltage", choices=_VOLTAGE, metavar="HOW", help="between samples: linear (default), held, averaged")
    add("--current", choices=_CURRENT, metavar="HOW", help="between samples: linear (default) or held")
    add("--direction", choices=_DIRECTION, metavar="HOW", help="measured (default if it is), estimated, forward, reverse")
    add("--gaps", choices=("stop", "bridge"), metavar="HOW", help="where samples are missing: stop (default), or bridge")
    add("--rule", action="store_true", help="choose gains by the rule, even if the machine's file has [observers.NAME.gains]")
    add("--bandwidth", type=float, metavar="RAD/S", help="the rule's, of the speed loop (default: as samples and noise allow)")
    add("--gain", action="append", default=[], metavar="NAME=X", help="a gain, in place of the study's or the rule's")
    add("--initial", action="append", default=[], metavar="NAME=X",
        help="an estimate at the start, omega_hat=100; or 'study': as [observers.NAME.initial] of the machine's file")
    add("--after", type=float, metavar="S", help="errors count from here on (default: where they settled)")
    add("--window", type=float, metavar="S", help="of the excitation verdict (default: 0.1 s at most)")
    add("--trust", action="store_true", help="run even if the record does not fit the machine")


def run(args: argparse.Namespace) -> int:
    """Do it; 1 when an observer diverged."""
    import tempfile

    from imo_analysis.replay import check as log_check
    from imo_analysis.replay import estimate as replay
    from imo_analysis.replay import logs
    from imo_analysis.replay import mistakes as log_mistakes
    from imo_analysis.replay import survey as log_survey
    from imo_analysis.replay.settings import load_settings

    rate = _check_numbers_and_places(args)
    source = load_settings(args.machine)
    machine, settings = source.machine, source.replay
    columns = {**settings.columns, **_pairs(args.column, "--column")}
    units = {**settings.units, **_pairs(args.unit, "--unit")}
    log = logs.Log.open(args.log, machine.n_p, columns, units, settings.rate if rate is None else rate)
    treatment = replay.Treatment(
        args.voltage or settings.voltage, args.current or settings.current,
        args.direction or settings.direction or ("measured" if log.has_speed else "estimated"),
    )
    if treatment.direction == "measured" and not log.has_speed:
        raise InputError("direction = 'measured' takes a recorded speed; name it with --column omega_m=NAME, or say "
                         "--direction estimated, forward or reverse")
    found = log_survey.survey(log, (args.gaps or settings.gaps) == "bridge")
    stretch = found.stretch
    if log.origin is not None and log.origin.thinned:
        warnings.warn(f"{log.path}: {log.origin.thinned}", stacklevel=2)
    fit = None if args.trust else log_mistakes.check(stretch, found, machine, treatment.voltage, str(log.path))
    u, i = stretch.u_ds + 1j * stretch.u_qs, stretch.i_ds + 1j * stretch.i_qs
    level = log_check.level(u, i, found.sample_time, machine)
    bandwidth = settings.bandwidth if args.bandwidth is None else args.bandwidth
    by_rule = args.rule or bandwidth is not None
    kinds = _observers(args.observer or list(settings.observers), source)
    gains = {**settings.gains, **_numbers(args.gain, "--gain")}
    as_study = "study" in args.initial
    observers = replay.runners(
        kinds, machine, treatment, found, level, bandwidth=bandwidth,
        gains=gains,
        initial={**settings.initial, **_numbers([text for text in args.initial if text != "study"], "--initial")},
        study_gains={} if by_rule else source.gains, study_initial=source.initial if as_study else {},
    )
    if as_study:
        for runner in observers:
            if runner.kind not in source.observers:
                raise InputError(f"--initial study: {args.machine} has no [observers.{runner.name}] to take the start from; "
                                 "leave it out, or give a study that has it as --machine")
    _tell(args, log, found, treatment, fit, level, observers, machine, bandwidth)
    if not as_study:
        _tell_start(args, log, observers, source)
    with tempfile.TemporaryDirectory(prefix="imo_replay_") as folder:
        place = args.out or str(Path(folder) / "est.nc")
        results = _run(args, log, observers, found, machine, treatment, place)
        verdicts = _excitation(args, place, machine, found, log.has_speed, results)
        sources = {runner.name: _source(runner, source, bandwidth, gains) for runner in observers}
        _report(args, results, verdicts, sources)
        if args.plot:
            from imo_analysis.commands.output import say
            from imo_analysis.drawing import save_svg
            from imo_analysis.report.replay_figure import replay_figure, thinned

            save_svg(replay_figure(thinned(place)), args.plot)
            say(args, f"wrote {args.plot}")
    for name, one in results.items():
        one["gains_from"] = sources[name]
    _emit(args, log, found, treatment, fit, level, results, verdicts)
    return 1 if any(one["lost_at"] is not None for one in results.values()) else 0


def _check_numbers_and_places(args: argparse.Namespace) -> float | None:
    """Check what needs no file, and give the rate in Hz."""
    from imo_analysis.commands.output import check_places
    from imo_analysis.quantity import si_value

    for name, ending in ((args.out, ".nc"), (args.plot, ".svg")):
        if name and Path(name).suffix.lower() != ending:
            raise InputError(f"{name}: the name must end in {ending}")
    check_places(args, "out", "plot")
    if args.every < 1:
        raise InputError(f"--every {args.every} must be 1 or more")
    rate = None
    if args.rate is not None:
        try:
            rate = float(args.rate)
        except ValueError:
            rate = si_value(args.rate, "Hz", "--rate")
    for flag, value, unit in (("--rate", rate, "Hz"), ("--window", args.window, "s")):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise InputError(f"{flag} {value:g} must be above 0 {unit}")
    return rate


def _pairs(written: list[str], flag: str) -> dict[str, str]:
    pairs = {}
    for text in written:
        name, equals, value = text.partition("=")
        if not (equals and name.strip() and value.strip()):
            raise InputError(f"{flag} {text}: write {flag} NAME=VALUE")
        pairs[name.strip()] = value.strip()
    return pairs


def _numbers(written: list[str], flag: str) -> dict[str, float]:
    from imo_analysis.notation import symbol
    from imo_analysis.quantity import si_value

    pairs = _pairs(written, flag)
    out = {}
    for name, text in pairs.items():
        try:
            out[name] = float(text)
        except ValueError:
            out[name] = si_value(text, symbol(name).unit, f"{flag} {name}")
        if not math.isfinite(out[name]):
            raise InputError(f"{flag} {name}={text} must be finite")
    return out


def _observers(written: list[str], source: Any) -> list[str]:
    """Kinds of the observers that are asked for: by name, by file, or by the name of an own one in the machine's file."""
    from imo_analysis.equations.catalogue import OBSERVERS
    from imo_analysis.equations.own import is_file, located

    names = [name.strip() for text in written for name in text.split(",") if name.strip()]
    own = {name: kind for kind, (name, _) in source.observers.items() if is_file(kind)}
    if "all" in names:
        return [*OBSERVERS, *own.values()]
    kinds = list(dict.fromkeys(own.get(name) or located(name) for name in names)) or ["repaired"]
    for kind in kinds:
        OBSERVERS[kind]  # is there, and its names have units from here on
    return kinds


def _tell(
    args: argparse.Namespace, log: Any, found: Any, treatment: Any, fit: Any, level: Any, observers: list[Any],
    machine: Any, bandwidth: float | None,
) -> None:
    from imo_analysis.commands.output import say
    from imo_analysis.replay.check import LINE
    from imo_analysis.replay.gains import default_bandwidth, speed_noise

    end = found.start + float(found.time_of(found.rows))
    say(args, f"{log.path}: {found.rows} samples at {1 / found.sample_time:.6g} Hz, {found.start:g} s to {end:.6g} s")
    for text in log.mapping():
        say(args, f"  {text}")
    say(args, f"  {treatment.text}")
    if found.gaps:
        say(args, f"  {_gaps(found, level)}")
        keep = _keep([runner.name for runner in observers])
        if keep and (found.steps > level.longest_line).any():
            say(args, f"  where load or flux changes in a gap that is passed over, {', '.join(keep)} may stay off behind it, "
                      "as after a wrong start: cut the record there, so that it begins behind the gap")
    wide = default_bandwidth(machine, level, found.sample_time) if bandwidth is None else bandwidth
    if level.flux > 0 and any(runner.by_rule for runner in observers):
        noise = speed_noise(machine, level, found.sample_time, wide)
        say(args, f"  the rule's gains are for a bandwidth of {wide:.4g} rad/s and a flux of {level.flux:.3g} Wb; the "
                  f"currents' noise of {level.noise:.2g} A makes {noise:.2g} rad/s in the speed")
    turn = abs(level.stator_frequency) * found.sample_time
    if turn > LINE:
        say(args, f"  coarse: the voltages turn by {turn:.2g} rad a sample, and straight lines between samples miss up to "
                  f"{100 * turn * turn / 8:.2g} % of them")
    if fit is not None:
        say(args, f"  fits the machine: the currents account for {100 * fit.share:.2f} % of the voltages, factor "
                  f"{abs(fit.factor):.3f}")
    else:
        say(args, "  not checked against the machine" + ("" if args.trust else ": nothing turns in it"))


def _gaps(found: Any, level: Any) -> str:
    """What is done over the gaps."""
    from imo_analysis.replay.check import LINE

    short = found.steps[found.steps <= level.longest_line]
    long = found.steps[found.steps > level.longest_line]
    parts = [f"{len(short)} gap(s) of up to {short.max():.4g} s bridged by straight lines"] if len(short) else []
    parts += [f"{len(long)} gap(s) of up to {long.max():.4g} s, in which the voltages turn by more than {LINE:g} rad, passed "
              "over: flux and currents turn with the recorded current, speed and alpha stay"] if len(long) else []
    return "; ".join(parts)


def _keep(names: list[str]) -> list[str]:
    """The observers with which a wrong flux stays: those that adapt alpha."""
    from imo_analysis.equations.catalogue import OBSERVERS

    return [name for name in names if name in OBSERVERS and "alpha_hat" in OBSERVERS[name].states]


def _tell_start(args: argparse.Namespace, log: Any, observers: list[Any], source: Any) -> None:
    """How the observers begin, and which of them a wrong start stays with."""
    from imo_analysis.commands.output import say
    from imo_analysis.equations.catalogue import OBSERVERS

    say(args, f"  {observers[0].begun.how}")
    guessed = [runner.name for runner in observers if runner.guessed]
    keep = _keep(guessed)
    forget = [name for name in guessed if name in OBSERVERS and name not in keep and "printed" not in name]
    if keep:
        say(args, f"  as far as that flux is wrong, z_hat and xi_hat of {', '.join(keep)} stay wrong; the flux that they "
                  "reconstruct does not, but alpha_hat and omega_hat may be moved by it, until the flux's magnitude varies")
    if forget:
        verb, whose = ("forgets", "its") if len(forget) == 1 else ("forget", "their")
        say(args, f"  {', '.join(forget)}: {verb} a wrong start where {whose} poles are stable")
    known = [name for name in (log.origin.begun if log.origin else ()) if name in source.observers]
    if any(name in guessed for name in known):
        say(args, "  the record is a simulation's, and its study says how they began: --initial study begins them so")


def _source(runner: Any, source: Any, bandwidth: float | None, given: dict[str, float]) -> str:
    """Where an observer's gains come from, in words."""
    mine = [name for name in runner.gains if name in given]
    if len(mine) == len(runner.gains):
        return "the command line and [replay]"
    if not runner.by_rule:
        text = f"[observers.{source.observers[runner.kind][0]}.gains] of {source.place}"
    else:
        text = "the rule" if bandwidth is None else f"the rule, at {bandwidth:g} rad/s"
    return text + (f" with {', '.join(mine)} as given" if mine else "")


def _run(
    args: argparse.Namespace, log: Any, observers: list[Any], found: Any, machine: Any, treatment: Any, place: str
) -> dict[str, dict[str, Any]]:
    import sys

    from imo_analysis.replay import estimate as replay
    from imo_analysis.replay.estimate_file import write_estimates
    from imo_analysis.replay.summary import Tally

    tally = Tally(found, observers)
    names = [runner.name for runner in observers]
    attrs = replay.provenance(log, machine, observers, treatment)

    def write(progress: Any = None) -> None:
        blocks = replay.estimate(log, observers, progress=progress)
        write_estimates(blocks, place, found.rows, names, attrs, args.every, tally.add)

    if sys.stderr.isatty():
        from tqdm import tqdm

        with tqdm(total=found.rows, unit=" samples", unit_scale=True, leave=False, delay=0.5) as bar:
            write(bar.update)
    else:
        write()
    return tally.results(args.after)


def _excitation(
    args: argparse.Namespace, place: str, machine: Any, found: Any, has_speed: bool, results: dict[str, dict[str, Any]]
) -> dict[str, Any]:
    """The verdict of each observer that the conditions are about, as `imo excite` gives it; or why there is none."""
    import numpy as np

    from imo_analysis.excitation import signals, words
    from imo_analysis.excitation.trajectory import excitation

    window = min(0.1, found.most * found.sample_time / 5) if args.window is None else args.window
    first = np.unique(-(-found.first // args.every))  # of those that are written
    gaps = signals.Gaps(first[first * args.every < found.rows], found.sample_time * args.every) if found.gaps else None
    verdicts: dict[str, Any] = {}
    with signals.open_file(place, machine) as source:
        known = signals.adaptive_observers(source)
        for name, one in results.items():
            if one["lost_at"] is not None:
                verdicts[name] = {"verdict": f"observer {name} diverged: no verdict"}
            elif has_speed and one["settled_at"] is None:
                verdicts[name] = {"verdict": f"observer {name} never settled: no verdict (the condition holds its estimates)"}
            elif name not in known:
                verdicts[name] = {"verdict": f"observer {name}: no verdict; (19) is about the adaptive observers with xi_hat"}
            else:
                try:
                    chosen = signals.select(source, name, "true" if has_speed else "estimated", gaps)
                    verdicts[name] = words.summary(excitation(chosen, window, conditions=["reduced"]))
                except InputError as error:
                    # the estimates may be in a temporary file, of which nobody knows
                    verdicts[name] = {"verdict": f"observer {name}: no verdict: {str(error).replace(place, 'the estimates')}"}
    return verdicts


def _report(
    args: argparse.Namespace, results: dict[str, dict[str, Any]], verdicts: dict[str, Any], sources: dict[str, str]
) -> None:
    from imo_analysis.commands.output import say

    for name, one in results.items():
        if one["lost_at"] is not None:
            say(args, f"{name}: diverged at t = {one['lost_at']:.6g} s; its estimates end there")
            continue
        missed = 100 * one["current_error_share"]
        say(args, f"{name}: last omega_hat {one['omega_hat']:.5g} rad/s"
                  + (f", current error {missed:.2g} %" if math.isfinite(missed) else ", and no estimate of the currents"))
        if one["speed_error_rms"] is not None:
            std, mean, rms, peak = (one[f"speed_error_{key}"] for key in ("std", "mean", "rms", "peak"))
            say(args, f"  {_settled(one['settled_at'])}; from {one['counted_from']:.4g} s on: speed error std {std:.3g}, "
                      f"mean {mean:.3g}, rms {rms:.3g}, peak {peak:.3g} rad/s")
        gains = ", ".join(f"{key} = {value:.4g}" for key, value in one["gains"].items())
        say(args, f"  gains of {sources[name]}: {gains}")
        say(args, "  " + verdicts[name]["verdict"].replace("\n", "\n  "))
    if args.out:
        say(args, f"wrote {args.out}")


def _settled(at: float | None) -> str:
    from imo_analysis.replay.summary import SETTLED

    band = f"within {100 * SETTLED:g} % of the largest speed"
    if at is None:
        return f"does not stay {band}"
    return f"{band} from {at:.4g} s on" if at > 0 else f"{band} from the start"


def _emit(
    args: argparse.Namespace, log: Any, found: Any, treatment: Any, fit: Any, level: Any, results: Any, verdicts: Any
) -> None:
    from imo_analysis.commands.output import emit_json

    emit_json(args, "imo-replay/1", {
        "log": str(log.path), "rows": found.rows, "sample_time": found.sample_time, "start": found.start, "gaps": found.gaps,
        "columns": [{"role": c.role, "name": c.name, "unit": c.unit} for c in log.columns],
        "treatment": {"voltage": treatment.voltage, "current": treatment.current, "direction": treatment.direction},
        "fit": None if fit is None else {"factor": fit.factor, "share": fit.share},
        "stator_frequency": level.stator_frequency, "flux": level.flux,
        "observers": results, "excitation": verdicts, "out": args.out, "plot": args.plot,
    })
