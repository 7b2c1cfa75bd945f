"""``imo study``: write the paper's study to start from, or check a study."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from imo_analysis.errors import InputError

if TYPE_CHECKING:
    from imo_analysis.study import Study

DESCRIPTION = """Write a study to start from, commented, or check a study and say what is in it. Without --machine it is the
paper's; with a machine, one of that motor: rated flux, speed and torque, from its [nameplate] or as typical of such a machine,
five observers with gains by the rule of thumb (imo_analysis.tuning.rule), and nine runs that ask whether they work. Of an
observer of your own (kind = "mine.py") a check says, exactly, whether estimates that are right stay right."""
EXAMPLE = "imo study --init study.toml\n  imo study --init study.toml --machine motor.toml\n  imo study study.toml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("study", nargs="?", metavar="STUDY.toml", help="study to check; the paper's where left out")
    parser.add_argument("--init", metavar="FILE", help="write a study to FILE")
    parser.add_argument("--machine", metavar="FILE", help="with --init: machine file or preset in place of the paper's")
    parser.add_argument("--flux", metavar="WB", type=float, help="with --machine: rated rotor flux; estimated where left out")
    parser.add_argument("--force", action="store_true", help="let --init overwrite a file")


def run(args: argparse.Namespace) -> int:
    """Do it; 0 when done."""
    from imo_analysis.commands.output import check_places, emit_json, say
    from imo_analysis.files import write_text
    from imo_analysis.study import Study, paper_text

    check_places(args, "init", force=args.force)
    if args.init is not None:
        if args.flux is not None and not args.machine:
            raise InputError(f"--flux {args.flux:g} goes with --machine FILE; the paper's study has its own")
        if args.study:
            raise InputError(f"study = {args.study} cannot be given with --init; leave one of the two out")
        if Path(args.init).exists() and not args.force:  # whatever its ending
            raise InputError(f"{args.init} exists already; choose another name, or --force to overwrite it")
        write_text(args.init, _own(args.machine, args.flux) if args.machine else paper_text())
        then = f"imo report {args.init}" if args.machine else f"imo simulate {args.init} --out run.nc"
        say(args, f"wrote {args.init}; now: {then}")
        for remark in _remarks(args.machine) if args.machine else []:
            say(args, f"  plate: {remark}")
    elif args.flux is not None:
        raise InputError(f"--flux {args.flux:g} goes with --init FILE --machine FILE; the flux of a study is its drive.flux")
    elif args.machine:
        raise InputError(f"--machine {args.machine} goes with --init FILE; write the machine of a study into its [machine]")
    place = args.study or args.init
    study = Study.load(place) if place else Study.paper()
    simulation = study.simulation
    lines = [
        f"study      {study.title} (sha256 {study.sha256[:12]})",
        f"machine    {study.machine.name}: alpha = {study.machine.alpha:.4f} /s, {study.machine.n_p} pole pairs",
        f"run        {simulation.duration:g} s at {1 / simulation.sample_time:g} Hz, {simulation.substeps} step(s) of order "
        f"{simulation.order} a sample",
        f"observers  {', '.join(study.observers) or 'none'}",
        f"scenarios  {', '.join(study.scenarios) or 'none'}",
    ]
    if not args.init:
        say(args, "\n".join([*lines, *_spared(study)]))
    own = _own_observers(study)
    for name, off in own.items():
        say(args, "\n  ".join([f"{name}: at zero error the estimates follow the machine: {'no' if off else 'yes'}", *off]))
    emit_json(args, schema="imo-study/1", data={"sha256": study.sha256, "study": study.data, "own": own})
    return 0


def _spared(study: Study) -> list[str]:
    """The runs in which some observers have right parameters and others wrong ones."""
    from imo_analysis.simulation.judge import spared

    lines = []
    for name in ("", *study.scenarios):
        right, wrong = spared(study.scenario(name) if name else study)
        if right:
            where, table = (f"scenario {name}: ", f"scenarios.{name}.observers") if name else ("", "observers")
            lines.append(f"{where}{', '.join(right)} with the right parameters beside {', '.join(wrong)} with wrong ones; to "
                         f"compare them, give the same errors, as [{table}.{right[0]}.errors]")
    return lines


def _own_observers(study: Study) -> dict[str, list[str]]:
    """Of every observer's file, by how much which rows leave right estimates; empty where they stay right."""
    from imo_analysis.equations.own import is_file, shown

    found: dict[str, tuple[Study, str]] = {}
    for whole in (study, *map(study.scenario, study.scenarios)):
        for name, settings in whole.observers.items():
            if is_file(settings.kind):
                found.setdefault(settings.kind, (whole, name))
    several = [shown(kind) for kind in found]
    return {shown(kind) if several.count(shown(kind)) == 1 else kind: _departures(whole, name)
            for kind, (whole, name) in found.items()}


def _departures(study: Study, name: str) -> list[str]:
    """How far each row leaves the machine, in symbols where that is short, and in numbers at the study's first speed, idle."""
    from imo_analysis.equations.catalogue import OBSERVERS
    from imo_analysis.equations.own import ESTIMATED
    from imo_analysis.notation import over_time, symbol
    from imo_analysis.pencils.error import OperatingPoint
    from imo_analysis.pencils.own import departures, size_of

    settings, p = study.observers[name], study.machine.observer_parameters
    point = OperatingPoint(study.poles.omega[0], study.drive.flux, 0.0)
    rows = []
    found = departures(settings.kind)
    for state, departure in found.items():
        flux = state not in OBSERVERS[settings.kind].states
        size = size_of(departure, settings.kind, settings.gains, p, point)
        unit = "Wb" if flux else over_time(symbol(state).unit)
        text = str(departure)
        rows.append(f"{f'the flux estimate, {state[-1]} axis,' if flux else 'the rate of ' + state} is off by "
                    + (f"{text}: " if len(text) <= 80 else "") + f"{size:.4g} {unit} at {point.omega:g} rad/s, idle")
    unknown = [state for state in found if state.endswith("_hat") and state.removesuffix("_hat") not in ESTIMATED]
    if unknown:
        verb = "is no estimate" if len(unknown) == 1 else "are no estimates"
        rows.append(f"{', '.join(unknown)} {verb} of a quantity that is known here, and so counted as zero while the estimates "
                    f"are right; those are NAME_hat of {', '.join(ESTIMATED)}")
    return rows


def _own(name: str, flux: float | None) -> str:
    from imo_analysis.tuning.start import study_of

    return study_of(name, flux)


def _remarks(name: str) -> list[str]:
    from imo_analysis.tuning.start import remarks_of

    return remarks_of(name)
