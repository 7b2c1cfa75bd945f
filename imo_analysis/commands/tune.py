"""``imo tune``: gains that meet a wish over a range of speeds."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from imo_analysis.errors import InputError

DESCRIPTION = """Choose gains for the observers of a study, each by the same rule: the wish in its table [tuning] (settling and
recovery time, damping, noise, range of speeds, loads, parameter errors) is met over the whole range on the exact
linearisations, the choice is made in simulation and verified on simulations that it has not seen, beside the study's gains and
those of a rule of thumb. The front between noise and times comes with it. Exit code 1 if an observer's wish cannot be met, or
its gains are NOT verified."""
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
        _write(args, study, results)
    if args.plot:
        from imo_analysis.drawing import save_svg
        from imo_analysis.tuning.data import front_data
        from imo_analysis.tuning.figures import tuning_figure
        from imo_analysis.tuning.tune import over_speed

        save_svg(tuning_figure(front_data(study, results), over_speed(study, results)), args.plot)
        say(args, f"drawn in {args.plot}")
    if args.json:
        from imo_analysis.tuning.data import plain

        emit_json(args, "imo-tune/2", plain(study, results))
    return 1 if any(one.chosen.missed or one.faults for one in results) else 0


def _write(args: argparse.Namespace, study: Any, results: list[Any]) -> None:
    """The study with the chosen gains, as it was written but for these numbers."""
    import tomllib

    from imo_analysis.commands.output import say
    from imo_analysis.files import write_text
    from imo_analysis.study import Study, paper_text
    from imo_analysis.tuning.edit import edited
    from imo_analysis.tuning.tune import with_gains

    whole = with_gains(study, results)
    text = Path(args.study).read_text(encoding="utf-8") if args.study else paper_text()
    changed = edited(text, {one.name: whole.data["observers"][one.name]["gains"] for one in results})
    try:  # a machine in a file beside the study is looked for beside the new one
        same = changed is not None and whole.data == Study.from_data(
            tomllib.loads(changed), args.out, Path(args.out).parent).data
    except InputError:
        same = False
    write_text(args.out, changed if changed is not None and same else whole.to_toml())
    say(args, f"wrote {args.out}" + ("" if same else ", without comments: the gains stand where they cannot be replaced alone"))


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
    lines.append(f"  chosen: {one.reason}")
    lines += _simulated(one)
    shown = {key: (label, scale, unit) for key, label, scale, unit in _SHOWN}
    price = [f"{label} {_cell(one.chosen.values[key], scale)} where it was {_cell(one.before.values[key], scale)} {unit}"
             for key, (label, scale, unit) in shown.items() if key in one.price]
    new, old = one.verified, one.verified_before
    price += [f"error in {share} of the random runs {now:.3g} where it was {was:.3g} rad/s"
              for share, now, was in (("half", new.rms_median, old.rms_median), ("95 %", new.rms_95, old.rms_95)) if now > was]
    if price:
        lines.append(f"  worse than with the study's gains: {', '.join(price)}")
    lines.append("  NOT verified: " + "; ".join(one.faults) if one.faults else "  verified")
    return lines + [_missed(one, name) for name in one.chosen.missed] + _schedule(one)


def _schedule(one: Any) -> list[str]:
    """Whether gains that change with the speed would pay, and if so which."""
    from imo_analysis.tuning.schedule import pays, sentence

    lines = [f"  {sentence(one.schedule, one.chosen.missed)}"]
    if pays(one.schedule, one.chosen.missed):
        lines += [f"    at {at.omega:.3g} rad/s: " + "  ".join(f"{gain} = {value:.4g}" for gain, value in at.gains.items())
                  for at in one.schedule]
    return lines


_RUNS = (("half of runs", "rms_median", 1.0), ("95 % of runs", "rms_95", 1.0), ("worst corner", "corner", 1.0),
         ("all rad/s", "rms", 1.0), ("lost %", "lost", 100.0))


def _simulated(one: Any) -> list[str]:
    """The three sets of gains on simulations that had no part in the choice."""
    lines = ["  simulations not used before: rms error of the speed, then settling and noise with what is predicted",
             f"  {'':<14}" + "".join(f"{label:>14}" for label, *_ in _RUNS) + f"{'settling ms':>17}{'noise rad/s':>17}"]
    for label, seen in (("before", one.verified_before), ("rule of thumb", one.verified_rule), ("chosen", one.verified)):
        cells = "".join(f"{_cell(getattr(seen, name), scale, 'lost'):>14}" for _, name, scale in _RUNS)
        settling = f"{_cell(seen.settling, 1e3, 'never')} ({_cell(seen.settling_predicted, 1e3, 'never')})"
        noise = f"{_cell(seen.noise, 1.0, 'lost')} ({_cell(seen.noise_predicted, 1.0, 'unstable')})"
        lines.append(f"  {label:<14}{cells}{settling:>17}{noise:>17}")
    return lines


def _missed(one: Any, name: str) -> str:
    """Which wish is missed, how near it gets, and what is possible if the others are let go."""
    shown = {key: (label, scale, unit) for key, label, scale, unit in (*_SHOWN, ("fastest", "fastest mode", 1.0, "rad/s"))}
    label, scale, unit = shown[name]
    near = min(found.values[name] for found in (*one.front, one.rule, one.before))
    reached, wished = _cell(one.chosen.values[name], scale), _cell(one.chosen.limits[name], scale)
    return (f"  MISSED: {label} {reached} {unit} where {wished} is wished; {_cell(near, scale)} {unit} is possible at the "
            "price of other wishes (--json has the front)")


def _cell(value: float, scale: float, infinite: str = "unstable") -> str:
    return infinite if value == float("inf") else f"{value * scale:.3g}"
