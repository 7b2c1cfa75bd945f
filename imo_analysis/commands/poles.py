"""``imo poles``: poles of the observers' error dynamics, beside Table II, over sweeps, and as pictures."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from imo_analysis.commands.poles_input import chosen, doubtful, left, numbers, quantity, turning, wanted
from imo_analysis.errors import InputError

if TYPE_CHECKING:
    from imo_analysis.pencils.setup import Setup

DESCRIPTION = "Poles of the observers' error dynamics at frozen speed, beside the paper's Table II, or over a sweep."
EXAMPLE = """imo poles --omega 30,60,100 --observer all
  imo poles --over omega=-150:150:301 --plot poles.svg --out poles.nc
  imo poles --over omega=-150:150:121 --over R_r_error=-0.5:0.5:61 --full 2 --map stability.svg
  imo poles --tune 50:0.7:150 --observer consistent_12 repaired"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("study", nargs="?", metavar="STUDY.toml",
                        help="machine, observers, gains; the paper's if left out")
    parser.add_argument("--omega", metavar="LIST", help="speeds, in rad/s without a unit: 30,60,100; else the study's")
    parser.add_argument("--over", metavar="NAME=A:B:COUNT", action="append",
                        help="sweep omega, a gain, R_r, R_r_error, alpha, ...; twice for a map; SI or with units")
    parser.add_argument("--cloud", metavar="COUNT[:SEED]", help="random points, evenly within each --over NAME=A:B")
    parser.add_argument("--at", metavar="OMEGA", help="speed where it is not swept, in rad/s or as 30 rpm")
    parser.add_argument("--full", metavar="SLIP", help="with the adaptation, running at this slip, in rad/s or with a unit")
    parser.add_argument("--observer", metavar="NAME", nargs="+", action="extend",
                        help="of study or catalogue, mine.py, all; else the study's")
    parser.add_argument("--machine", metavar="FILE", help="machine file or preset in place of the study's machine")
    parser.add_argument("--tune", metavar="D:Z:W",
                        help="gains for decay D (1/s) and damping Z up to speed W (rad/s), both ways")
    parser.add_argument("--plot", metavar="SVG", help="draw the poles against what is swept")
    parser.add_argument("--map", metavar="SVG", help="their paths in the s-plane, or the stability map")
    parser.add_argument("--show", metavar="WHAT", default="decay", help="on a map: decay, damping or settling_time (decay)")
    parser.add_argument("--out", metavar="FILE", help="write the sweep, .nc or .csv")


def run(args: argparse.Namespace) -> int:
    """Do it; 0 when done."""
    from imo_analysis.commands.output import check_places, emit_json, say

    if args.out and not args.out.endswith((".nc", ".csv")):
        raise InputError(f"--out {args.out} must end in .nc or .csv")
    for option, path in (("--plot", args.plot), ("--map", args.map)):
        if path and not path.endswith(".svg"):
            raise InputError(f"{option} {path} must end in .svg")
    if args.show not in (known := ("decay", "damping", "settling_time")):
        raise InputError(f"--show {args.show} is not in the map; choose one of: {', '.join(known)}")
    if args.full is not None:
        args.full = turning(args.full, "--full", "slip")
    check_places(args, "out", "plot", "map")
    speeds = numbers(args.omega) if args.omega is not None else None

    from imo_analysis.commands.poles_sweep import sweep
    from imo_analysis.study import Study

    study = Study.load(args.study) if args.study else Study.paper()
    setups, refused, assumed = chosen(study, args)
    over = wanted(args)
    doubtful(args.over or [], setups)
    _check_own(args, setups)
    for label, gains in assumed.items():
        taken = "by the rule of thumb" if "h_s" in gains else "as imo excite --design does without noise"
        say(args, f"{label}: the study has no " + ", ".join(gains) + f"; taken {taken}: "
            + ", ".join(f"{name} = {value:g}" for name, value in gains.items()))
    if args.tune is not None:
        setups = _tuned(args, setups, refused)
    result: dict[str, Any] = {
        "machine": {label: setup.machine.model_dump() for label, setup in setups.items()},
        "observers": {label: {"kind": setup.observer, "gains": dict(setup.gains)} for label, setup in setups.items()},
        "refused": refused, "assumed": assumed,
    }
    if speeds is not None or over is None:
        result["table"] = _table(args, setups, refused, speeds or list(study.poles.omega), study.drive.flux)
    if over is not None:
        result |= sweep(args, study, setups, refused, over)
    for label, reason in refused.items():
        say(args, f"left out {label}: {reason}")
    emit_json(args, schema="imo-poles/1", data=result)
    return 0


def _check_own(args: argparse.Namespace, setups: dict[str, Setup]) -> None:
    """Derive the error dynamics of observers of the user's own by a second route too, and say that both agree."""
    from imo_analysis.commands.output import say
    from imo_analysis.equations.own import is_file
    from imo_analysis.pencils.own import check_derivative

    for label, setup in setups.items():
        if is_file(setup.observer):
            count = check_derivative(setup.observer)
            say(args, f"{label}: {count} entries of its error dynamics agree, differentiated and as exact difference quotients")


def _tuned(args: argparse.Namespace, setups: dict[str, Setup], refused: dict[str, str]) -> dict[str, Setup]:
    """The observers with gains from `imo_analysis.pencils.pole_rule` in place of their own; printed with what they give."""
    from imo_analysis.commands.output import say
    from imo_analysis.pencils.pole_rule import tune
    from imo_analysis.pencils.setup import Setup

    try:
        words = dict(zip(("1/s", "1", "rad/s"), args.tune.split(":"), strict=True))
    except ValueError:
        raise InputError(f"--tune {args.tune} must be DECAY:DAMPING:OMEGA_MAX, such as 50:0.7:150") from None
    decay, damping, omega_max = (quantity(word, unit, "--tune") for unit, word in words.items())
    result = {}

    def choose(label: str, setup: Setup) -> None:
        found = tune(setup.machine, setup.observer, decay, damping, omega_max)
        say(args, f"{label}: " + ", ".join(f"{name} = {value:.6g}" for name, value in found.gains.items())
            + f" give decay {found.decay:.4g} /s, damping {found.damping:.3f}, fastest pole {found.fastest:.4g} rad/s")
        result[label] = Setup(setup.observer, setup.machine, {**setup.gains, **found.gains})

    left(setups, refused, choose)
    return result


def _table(
    args: argparse.Namespace, setups: dict[str, Setup], refused: dict[str, str], speeds: list[float], flux: float
) -> list[dict[str, Any]]:
    """Print the poles at single speeds; the same as data."""
    import numpy as np

    from imo_analysis.commands.output import say
    from imo_analysis.pencils.error import OperatingPoint, poles_at
    from imo_analysis.pencils.table2 import table2
    from imo_analysis.pencils.table2_fit import WITNESS, mismatches

    if args.full is not None:
        return _full_table(args, setups, refused, speeds, flux)
    rows: list[dict[str, Any]] = []
    for label, setup in setups.items():
        kind, machine, gains = setup.observer, setup.machine, setup.gains
        say(args, _title(label, setup))
        data = table2(machine, {label: (kind, gains)}, speeds).isel(observer=0)
        column = str(data["column"].values)
        beside = f"Table II, {column}" if column else ""
        say(args, f"  {'omega_hat':>9}  {'computed':>22}  {beside:>22}  {'distance' if column else ''}".rstrip())
        for n, speed in enumerate(speeds):
            at = data.isel(omega=n)
            computed = at["computed_re"].values + 1j * at["computed_im"].values
            printed = at["printed_re"].values + 1j * at["printed_im"].values
            for pole, text, distance in zip(computed, printed, at["difference"].values, strict=True):
                if not np.isfinite(pole):
                    continue  # fewer poles than there are places
                known = f"{_complex(text):>22}  {distance:8.2f}" if np.isfinite(distance) else ""
                say(args, f"  {speed:9g}  {_complex(pole):>22}  {known}".rstrip())
            rows.append({"observer": label, "omega": speed, "poles": computed, "column": column,
                         "printed": printed if column else None, "distance": at["difference"].values if column else None,
                         "at_zero": len(poles_at(machine, kind, gains, OperatingPoint(speed, None))) - len(computed)})
    a, b, c, d = (float(value) for value in WITNESS)
    right = 24 - len(mismatches(*WITNESS))
    say(args, f"{right} of Table II's 24 numbers are those of s^2 + ({a:g} - j w) s + {b:g} - j {c:g} w + {d:g} w^2,\n"
        f"with {d:g} |w| for the last term in the baseline column. Poles that stay at zero are left out above.")
    return rows


def _full_table(
    args: argparse.Namespace, setups: dict[str, Setup], refused: dict[str, str], speeds: list[float], flux: float
) -> list[dict[str, Any]]:
    """The same with the adaptation; Floquet exponents where the linearisation is periodic in any frame."""
    from imo_analysis.commands.output import say
    from imo_analysis.pencils.error import OperatingPoint, poles_at
    from imo_analysis.pencils.floquet import floquet_exponents
    from imo_analysis.pencils.jacobian import commutes_with_rotation
    from imo_analysis.pencils.operating import STANDING, STANDSTILL

    rows: list[dict[str, Any]] = []

    def table(label: str, setup: Setup) -> None:
        turns = commutes_with_rotation(setup.observer)
        own, lines = [], []
        for speed in speeds:
            point = OperatingPoint(speed, flux, args.full)
            found = (poles_at(setup.machine, setup.observer, setup.gains, point, "full") if turns
                     else floquet_exponents(setup.machine, setup.observer, setup.gains, point))
            lines.append(f"  {speed:8g} rad/s  " + "  ".join(_complex(pole) for pole in found if pole.imag >= 0))
            if stands := abs(speed + args.full) <= STANDING:
                lines.append(f"  {'':8}        {STANDSTILL}; poles at zero belong to it")
            own.append({"observer": label, "omega": speed, "slip": args.full, "flux": flux, "poles": list(found),
                        "floquet": not turns, "undetermined": stands})
        rows.extend(own)
        say(args, "\n".join([_title(label, setup) + ("" if turns else ", Floquet exponents"), *lines]))

    left(setups, refused, table)
    return rows


def _title(label: str, setup: Setup) -> str:
    from imo_analysis.equations.catalogue import OBSERVERS

    return (f"{label} ({OBSERVERS[setup.observer].name}), alpha = {setup.machine.alpha:.4f} /s"
            + "".join(f", {name} = {value:g}" for name, value in setup.gains.items()))


def _complex(value: complex) -> str:
    return f"{round(value.real, 2) + 0.0:.2f} {'-' if value.imag < 0 else '+'} {abs(value.imag):.2f}j"
