"""``imo poles``: poles of the observers' error dynamics, beside Table II, over sweeps, and as pictures."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from imo_analysis.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from imo_analysis.machine import InductionMachine

# Faster than any machine turns, in rad/s; far above it the squares of a pencil overflow.
_FASTEST = 1e6

DESCRIPTION = "Poles of the observers' error dynamics at frozen speed, beside the paper's Table II, or over a sweep."
EXAMPLE = """imo poles --omega 30,60,100
  imo poles --sweep -150:150:301 --plot poles.svg --out poles.nc
  imo poles --over k_2 --sweep 0:100:101 --at 60 --observer consistent_12 --map k2.svg
  imo poles --tune 50:0.7:150 --observer consistent_12 repaired"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--omega", metavar="LIST", help="speeds in rad/s, such as 30,60,100; the study's where left out")
    parser.add_argument("--sweep", metavar="A:B:COUNT", help="equally spaced values, both ends included")
    parser.add_argument("--over", metavar="NAME", default="omega", help="what is swept: omega, a gain, R_r, alpha, ... (omega)")
    parser.add_argument("--at", metavar="OMEGA", type=float, help="speed in rad/s for a sweep over something else")
    parser.add_argument("--full", metavar="SLIP", type=float,
                        help="include the adaptation of speed and alpha, about steady running at this slip in rad/s")
    parser.add_argument("--observer", metavar="NAME", nargs="+", action="extend",
                        help="observers of the study or the catalogue; the study's where left out")
    parser.add_argument("--study", metavar="FILE", help="study with machine, observers, gains; the paper's where left out")
    parser.add_argument("--machine", metavar="FILE", help="machine file or preset in place of the study's machine")
    parser.add_argument("--tune", metavar="D:Z:W",
                        help="gains for decay D (1/s) and damping Z up to speed W (rad/s), both ways")
    parser.add_argument("--plot", metavar="SVG", help="draw the poles against what is swept")
    parser.add_argument("--map", metavar="SVG", help="draw the paths of the poles in the s-plane")
    parser.add_argument("--out", metavar="FILE", help="write the sweep, .nc or .csv")


def run(args: argparse.Namespace) -> int:
    """Do it; 0 when done."""
    from imo_analysis.commands.output import check_places, emit_json, say

    wants_sweep = any((args.sweep, args.plot, args.map, args.out, args.over != "omega"))
    if args.out and not args.out.endswith((".nc", ".csv")):
        raise InputError(f"--out {args.out} must end in .nc or .csv")
    for option, path in (("--plot", args.plot), ("--map", args.map)):
        if path and not path.endswith(".svg"):
            raise InputError(f"{option} {path} must end in .svg")
    check_places(args, "out", "plot", "map")
    speeds = _numbers(args.omega) if args.omega is not None else None
    if args.sweep is not None:
        _range(args.sweep)

    from imo_analysis.study import Study

    study = Study.load(args.study) if args.study else Study.paper()
    machines, observers = _chosen(study, args)
    if args.tune is not None:
        observers = _tuned(args, machines, observers)
    result: dict[str, Any] = {
        "machine": {label: machine.model_dump() for label, machine in machines.items()},
        "observers": {label: {"kind": kind, "gains": dict(gains)} for label, (kind, gains) in observers.items()},
    }
    if speeds is not None or not wants_sweep:
        result["table"] = _table(args, machines, observers, speeds or list(study.poles.omega), study.drive.flux)
    if wants_sweep:
        data = _sweep(args, study, machines, observers)
        for option, path in (("plot", args.plot), ("map", args.map)):
            if path:
                _draw(option, path, data, machines, observers)
                say(args, f"wrote {path}")
        if args.out:
            _write(data, args.out)
            say(args, f"wrote {args.out}")
        result["sweep"] = _summary(args, data)
        if args.json:
            over = args.over
            result["sweep"] |= {over: data[over].values, "re": data["re"].values, "im": data["im"].values,
                                "dims": list(data["re"].dims), "observer": list(observers)}
    emit_json(args, schema="imo-poles/1", data=result)
    return 0


def _numbers(text: str) -> list[float]:
    try:
        values = [float(word) for word in text.split(",")] if text.strip() else []
    except ValueError:
        raise InputError(f"--omega {text} must be numbers with commas between, in rad/s: 30,60,100") from None
    if not values:
        raise InputError("--omega is empty; give at least one speed in rad/s")
    if not all(math.isfinite(value) for value in values):
        raise InputError(f"--omega {text} must be finite, in rad/s")
    if max(map(abs, values)) > _FASTEST:
        raise InputError(f"--omega {text} must lie within +-{_FASTEST:g} rad/s")
    return values


def _range(text: str) -> tuple[float, float, int]:
    words = text.split(":")
    try:
        start, stop, count = float(words[0]), float(words[1]), int(words[2])
        if len(words) != 3:
            raise ValueError
    except (ValueError, IndexError):
        raise InputError(f"--sweep {text} must be START:STOP:COUNT, such as -150:150:301") from None
    if count < 1:
        raise InputError(f"--sweep {text} is empty; COUNT must be 1 or more")
    if not (math.isfinite(start) and math.isfinite(stop)):
        raise InputError(f"--sweep {text} must have finite ends")
    return start, stop, count


def _chosen(
    study: Any, args: argparse.Namespace
) -> tuple[dict[str, InductionMachine], dict[str, tuple[str, dict[str, float]]]]:
    """Machine and (kind, gains) of every observer that is asked for, by label."""
    from imo_analysis.equations.catalogue import OBSERVERS
    from imo_analysis.machine import PRESETS, InductionMachine

    other = None
    if args.machine:
        other = PRESETS[args.machine] if args.machine in PRESETS else InductionMachine.load(args.machine)
    shared = study.known_gains
    machines, observers = {}, {}
    for label in args.observer or study.observers:
        if label in study.observers:
            settings = study.observers[label]
            machines[label] = other or study.observer_machine(label)
            observers[label] = (settings.kind, settings.gains)
        elif label in OBSERVERS:
            needed = OBSERVERS[label].gains
            if missing := [gain for gain in needed if gain not in shared]:
                raise InputError(f"observer = {label!r} is not in the study, and no observer there has its gains "
                                 f"{', '.join(missing)}; add [observers.{label}] to the study")
            machines[label] = other or study.machine
            observers[label] = (label, {gain: shared[gain] for gain in needed})
        else:
            known = ", ".join(dict.fromkeys([*study.observers, *OBSERVERS]))
            raise InputError(f"observer = {label!r} is not known; choose from: {known}")
    if not observers:
        raise InputError("the study has no observers; name one with --observer")
    return machines, observers


def _tuned(args: argparse.Namespace, machines: Any, observers: Any) -> dict[str, tuple[str, dict[str, float]]]:
    """The observers with gains from `imo_analysis.pencils.tune` in place of their own; printed with what they give."""
    from imo_analysis.commands.output import say
    from imo_analysis.pencils.tune import tune

    try:
        decay, damping, omega_max = (float(word) for word in args.tune.split(":"))
    except ValueError:
        raise InputError(f"--tune {args.tune} must be DECAY:DAMPING:OMEGA_MAX, such as 50:0.7:150") from None
    result = {}
    for label, (kind, gains) in observers.items():
        found = tune(machines[label], kind, decay, damping, omega_max)
        say(args, f"{label}: " + ", ".join(f"{name} = {value:.6g}" for name, value in found.gains.items())
            + f" give decay {found.decay:.4g} /s, damping {found.damping:.3f}, fastest pole {found.fastest:.4g} rad/s")
        result[label] = (kind, {**gains, **found.gains})
    return result


def _table(args: argparse.Namespace, machines: Any, observers: Any, speeds: list[float], flux: float) -> list[dict[str, Any]]:
    """Print the poles at single speeds; the same as data."""
    import numpy as np

    from imo_analysis.commands.output import say
    from imo_analysis.pencils.error import OperatingPoint, poles_at
    from imo_analysis.pencils.table2 import table2
    from imo_analysis.pencils.table2_fit import WITNESS, mismatches

    rows: list[dict[str, Any]] = []
    for label, (kind, gains) in observers.items():
        machine = machines[label]
        say(args, f"{label} ({kind}), alpha = {machine.alpha:.4f} /s, "
            + ", ".join(f"{name} = {value:g}" for name, value in gains.items()))
        if args.full is not None:
            for speed in speeds:
                found = poles_at(machine, kind, gains, OperatingPoint(speed, flux, args.full), "full")
                say(args, f"  {speed:8g} rad/s  " + "  ".join(_complex(pole) for pole in found if pole.imag >= 0))
                rows.append({"observer": label, "omega": speed, "slip": args.full, "flux": flux, "poles": list(found)})
            continue
        data = table2(machine, {label: (kind, gains)}, speeds).isel(observer=0)
        column = str(data["column"].values)
        beside = f"Table II, {column}" if column else ""
        say(args, f"  {'omega_hat':>9}  {'computed':>22}  {beside:>22}  {'distance' if column else ''}".rstrip())
        for n, speed in enumerate(speeds):
            at = data.isel(omega=n)
            computed = at["computed_re"].values + 1j * at["computed_im"].values
            printed = at["printed_re"].values + 1j * at["printed_im"].values
            for pole, text, distance in zip(computed, printed, at["difference"].values, strict=True):
                known = f"{_complex(text):>22}  {distance:8.2f}" if np.isfinite(distance) else ""
                say(args, f"  {speed:9g}  {_complex(pole):>22}  {known}".rstrip())
            rows.append({"observer": label, "omega": speed, "poles": computed, "column": column,
                         "printed": printed if column else None, "distance": at["difference"].values if column else None,
                         "at_zero": len(poles_at(machine, kind, gains, OperatingPoint(speed, None))) - 4})
    if args.full is None:
        a, b, c, d = (float(value) for value in WITNESS)
        right = 24 - len(mismatches(*WITNESS))
        say(args, f"{right} of Table II's 24 numbers are those of s^2 + ({a:g} - j w) s + {b:g} - j {c:g} w + {d:g} w^2,\n"
            f"with {d:g} |w| for the last term in the baseline column. Poles that stay at zero are left out above.")
    return rows


def _complex(value: complex) -> str:
    return f"{round(value.real, 2) + 0.0:.2f} {'-' if value.imag < 0 else '+'} {abs(value.imag):.2f}j"


def _sweep(args: argparse.Namespace, study: Any, machines: Any, observers: Any) -> xr.Dataset:
    from imo_analysis.pencils.error import OperatingPoint
    from imo_analysis.pencils.sweep import grid, sweep_observers

    if args.sweep is None:
        if args.over != "omega":
            raise InputError(f"--over {args.over} needs --sweep START:STOP:COUNT")
        sweep = study.poles.sweep
        values = grid(sweep.start, sweep.stop, sweep.count, "poles.sweep")
    else:
        values = grid(*_range(args.sweep), "--sweep")
    if args.over != "omega" and args.at is None:
        raise InputError(f"--over {args.over} needs the speed: --at OMEGA in rad/s")
    point = OperatingPoint(0.0 if args.at is None else args.at, study.drive.flux, args.full or 0.0)
    return sweep_observers(machines, observers, values, args.over, point, "frozen" if args.full is None else "full")


def _summary(args: argparse.Namespace, data: xr.Dataset) -> dict[str, Any]:
    """Print, for each observer, the least damped moving pole and where the sweep is unstable."""
    import numpy as np

    from imo_analysis.commands.output import say

    over = args.over
    summary: dict[str, Any] = {"over": over, "unstable": {}}
    for label in data["observer"].values:
        part = data.sel(observer=label)
        moving = part["re"].where(~part["neutral"]).values
        worst = np.nanmax(moving, axis=1)
        at = int(np.argmax(worst))
        unstable = int((worst > 1e-9 * np.nanmax(np.abs(moving))).sum())
        say(args, f"{label}: slowest pole {worst[at]:.4g} /s at {over} = {part[over].values[at]:g}; "
            f"unstable at {unstable} of {len(worst)} points; {int(part['neutral'].sum())} poles on the axis by structure")
        summary["unstable"][str(label)] = unstable
    return summary


def _draw(option: str, path: str, data: xr.Dataset, machines: Any, observers: Any) -> None:
    from imo_analysis.drawing import save_svg
    from imo_analysis.pencils.maps import plot_against, plot_plane
    from imo_analysis.pencils.table2 import table2

    frozen = data.attrs.get("kind") == "frozen"
    title = "Poles of the error dynamics" + (" at frozen speed" if frozen else ", with adaptation")
    if option == "plot":
        save_svg(plot_against(data, title), path)
        return
    beside = table2(next(iter(machines.values())), observers) if frozen and data.attrs.get("over") == "omega" else None
    save_svg(plot_plane(data, title, printed=beside), path)


def _write(data: xr.Dataset, path: str) -> None:
    from imo_analysis.files import replacing
    from imo_analysis.simulation.runfile import write_netcdf

    with replacing(path) as beside:
        if path.endswith(".nc"):
            write_netcdf(data.assign_coords(neutral=data["neutral"].astype("int8")), beside)
        else:
            data.to_dataframe().reset_index().dropna(subset=["re"]).to_csv(beside, index=False)
