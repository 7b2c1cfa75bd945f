"""``imo tune``: gains that meet a wish over a range of speeds."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from imo_analysis.errors import InputError

DESCRIPTION = """Choose gains for the observers of a study, each by the same rule: the wish in its table [tuning] (settling and
recovery time, damping, noise, range of speeds, loads, parameter errors) is met over the whole range on the exact
linearisations, the choice is made in simulation and verified on simulations that it has not seen. The front between noise and
times comes with it. Exit code 1 if an observer's wish cannot be met."""
EXAMPLE = """imo tune study.toml --plot tuned.svg --out tuned.toml
  imo tune --observer repaired baseline --json -"""
_SHOWN = (("settling", "settling", 1e3, "ms"), ("recovery", "recovery", 1.0, "s"), ("overshoot", "overshoot", 100.0, "%"),
          ("lag", "lag", 1e3, "ms"), ("noise", "noise", 1.0, "rad/s"), ("bias", "bias", 1.0, "rad/s"))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("study", nargs="?", metavar="STUDY.toml", help="study with a [tuning]; the paper's where left out")
    parser.add_argument("--observer", metavar="NAME", nargs="+", action="extend", help="observers of the study, not all")
    parser.add_argument("--out", metavar="FILE.toml", help="write the study with the chosen gains")
    parser.add_argument("--plot", metavar="FILE.svg", help="draw the fronts, and settling and noise over speed")


def run(args: argparse.Namespace) -> int:
    """Do it; 0 when every wish is met, 1 when not."""
    from imo_analysis.commands.output import check_places, emit_json, say
    from imo_analysis.study import Study

    if args.out and Path(args.out).suffix != ".toml":
        raise InputError(f"--out {args.out} must end in .toml")
    if args.plot and Path(args.plot).suffix != ".svg":
        raise InputError(f"--plot {args.plot} must end in .svg")
    check_places(args, "out", "plot")
    study = Study.load(args.study) if args.study else Study.paper()
    results = _tuned(args, study)
    for one in results:
        say(args, "\n".join(_lines(one)))
    if args.out:
        from imo_analysis.files import write_text
        from imo_analysis.tuning.tune import with_gains

        write_text(args.out, with_gains(study, results).to_toml())
        say(args, f"wrote {args.out}")
    if args.plot:
        from imo_analysis.drawing import save_svg
        from imo_analysis.tuning.data import front_data
        from imo_analysis.tuning.figures import tuning_figure
        from imo_analysis.tuning.tune import over_speed

        save_svg(tuning_figure(front_data(study, results), over_speed(study, results)), args.plot)
        say(args, f"drawn in {args.plot}")
    if args.json:
        from imo_analysis.tuning.data import plain

        emit_json(args, "imo-tune/1", plain(study, results))
    return 1 if any(one.chosen.missed for one in results) else 0


def _tuned(args: argparse.Namespace, study: Any) -> list[Any]:
    from tqdm import tqdm

    from imo_analysis.tuning.tune import STEPS, tunable, tune
    from imo_analysis.tuning.wish import Wish

    names = tunable(study, args.observer or ())
    Wish.of(study)  # a wish that cannot be is said before anything begins
    with tqdm(total=STEPS * len(names), desc="tune", unit="generation", file=sys.stderr, disable=None, delay=2,
              leave=False) as bar:
        results = []
        for n, name in enumerate(names):
            bar.set_description(f"tune {name}")
            results.append(tune(study, name, lambda: bar.update() and None))
            bar.update(STEPS * (n + 1) - bar.n)
    return results


def _lines(one: Any) -> list[str]:
    """What is said of one observer."""
    lines = [f"{one.name}" + (f" ({one.note})" if one.note else "")]
    lines.append("  gains  " + "  ".join(f"{gain} = {value:.5g}" for gain, value in one.chosen.gains.items()))
    lines.append(f"  {'':<14}" + "".join(f"{label + ' ' + unit:>16}" for _, label, _, unit in _SHOWN))
    for label, found in (("before", one.before), ("rule of thumb", one.rule), ("chosen", one.chosen)):
        cells = "".join(f"{_cell(found.values[name], scale):>16}" for name, _, scale, _ in _SHOWN)
        lines.append(f"  {label:<14}{cells}")
    limits = one.chosen.limits
    lines.append(f"  {'wished':<14}" + "".join(
        f"{'<= ' + _cell(limits[name], scale) if name in limits else '-':>16}" for name, _, scale, _ in _SHOWN))
    after, before = one.verified, one.verified_before
    lines.append(f"  chosen: {one.reason}")
    lines.append("  verified on simulations not used: rms speed error "
                 f"{after.rms_median:.3g} rad/s in half of the runs, {after.rms_95:.3g} in 95 % of them, {after.lost:.0%} lost "
                 f"(before: {before.rms_median:.3g}, {before.rms_95:.3g}, {before.lost:.0%});")
    lines.append(f"    noise {after.noise:.3g} rad/s where {after.noise_predicted:.3g} is predicted, settling "
                 f"{_cell(after.settling, 1e3)} ms where {_cell(after.settling_predicted, 1e3)} ms is")
    shown = {key: (label, scale, unit) for key, label, scale, unit in _SHOWN}
    price = [f"{label} {_cell(one.chosen.values[key], scale)} where it was {_cell(one.before.values[key], scale)} {unit}"
             for key, (label, scale, unit) in shown.items() if key in one.price]
    if price:
        lines.append(f"  worse than with the study's gains: {', '.join(price)}")
    return lines + [_missed(one, name) for name in one.chosen.missed]


def _missed(one: Any, name: str) -> str:
    """Which wish is missed, how near it gets, and what is possible if the others are let go."""
    shown = {key: (label, scale, unit) for key, label, scale, unit in (*_SHOWN, ("fastest", "fastest mode", 1.0, "rad/s"))}
    label, scale, unit = shown[name]
    near = min(found.values[name] for found in (*one.front, one.rule, one.before))
    reached, wished = _cell(one.chosen.values[name], scale), _cell(one.chosen.limits[name], scale)
    return (f"  MISSED: {label} {reached} {unit} where {wished} is wished; {_cell(near, scale)} {unit} is possible at the "
            "price of other wishes (--json has the front)")


def _cell(value: float, scale: float) -> str:
    return "unstable" if value == float("inf") else f"{value * scale:.3g}"
