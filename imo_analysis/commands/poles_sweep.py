"""The sweeps of ``imo poles``: over one parameter, two, or a cloud of random points; their pictures and files."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from imo_analysis.commands.poles_input import left, turning
from imo_analysis.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from imo_analysis.pencils.setup import Setup
    from imo_analysis.study import Study


def sweep(
    args: argparse.Namespace, study: Study, setups: dict[str, Setup], refused: dict[str, str],
    over: dict[str, tuple[float, float, int | None]],
) -> dict[str, Any]:
    """Sweep, say what was found, draw and write; what goes into the JSON, under ``sweep`` or ``map``."""
    from imo_analysis.pencils.error import OperatingPoint
    from imo_analysis.pencils.sweep import ERROR, SweptKind, axes, evaluator

    values = axes(_values(args, study, over), cloud=args.cloud is not None)
    names = tuple(values)
    if "omega" not in names and args.at is None:
        raise InputError(f"--over {names[0]} needs the speed: --at OMEGA in rad/s")
    if "omega" in names and args.at is not None:
        raise InputError(f"--at {args.at} and --over omega both give the speed; leave one of them out")
    at = 0.0 if args.at is None else turning(args.at, "--at", "speed")
    if args.plot and len(names) > 1:
        raise InputError(f"--plot draws over one parameter, and there are {', '.join(names)}; use --map for "
                         + ("two" if args.cloud is None else "a cloud"))
    kind: SweptKind = "frozen" if args.full is None else "full"
    if kind == "full" and any(name.endswith(ERROR) for name in names):
        kind = "settled"
    point = OperatingPoint(at, study.drive.flux, args.full or 0.0)
    first = tuple(column[:1] for column in values.values())
    setups = left(
        setups, refused, lambda _, one: evaluator(one.machine, one.observer, one.gains, names, point, kind).moving(first))
    _standing(args, values, point, kind)
    if len(names) == 2 and args.cloud is None:
        return {"map": _map(args, setups, values, point, kind)}
    return {"sweep": _lines(args, setups, values, point, kind)}


def _standing(args: argparse.Namespace, values: dict[str, Any], point: Any, kind: str) -> None:
    """Say where the sweep passes zero stator frequency, and what that means."""
    import numpy as np

    from imo_analysis.commands.output import say
    from imo_analysis.pencils.operating import STANDING, STANDSTILL

    if kind == "frozen":
        return
    omega, slip = (values.get(name, np.array([getattr(point, name)])) for name in ("omega", "slip"))
    frequency = omega + slip if args.cloud is not None else np.add.outer(omega, slip)
    if count := int((np.abs(frequency) <= STANDING).sum()):
        say(args, f"at {count} of {frequency.size} pairs of speed and slip the {STANDSTILL}; a pole is zero there")


def _values(args: argparse.Namespace, study: Study, over: dict[str, tuple[float, float, int | None]]) -> dict[str, Any]:
    from imo_analysis.pencils.sweep import grid

    if not over:
        span = study.poles.sweep
        return {"omega": grid(span.start, span.stop, span.count, "poles.sweep")}
    if args.cloud is None:
        return {name: grid(start, stop, int(count or 0), f"--over {name}") for name, (start, stop, count) in over.items()}

    import numpy as np

    from imo_analysis.sweeps.distributions import draw

    try:
        count, seed = (int(word) for word in (args.cloud if ":" in args.cloud else f"{args.cloud}:1").split(":"))
    except ValueError:
        raise InputError(f"--cloud {args.cloud} must be COUNT or COUNT:SEED, whole numbers") from None
    if not 1 <= count <= 1_000_000:
        raise InputError(f"--cloud {args.cloud}: COUNT must be 1 to 1000000")
    for name, (start, stop, _) in over.items():
        if not start < stop:
            raise InputError(f"--over {name}={start:g}:{stop:g} must have STOP above START")
    index = np.arange(count, dtype=np.int64)
    return {name: draw(name, {"uniform": [start, stop]}, 0.0, seed, index) for name, (start, stop, _) in over.items()}


def _lines(args: argparse.Namespace, setups: dict[str, Setup], values: dict[str, Any], point: Any, kind: Any) -> dict[str, Any]:
    from imo_analysis.pencils.sweep import pole_sweep
    from imo_analysis.pencils.table2 import table2

    found = pole_sweep(setups, values, point, kind, cloud=args.cloud is not None)
    data = found.data
    title = "Poles of the error dynamics" + {"frozen": " at frozen speed", "full": ", with adaptation",
                                             "settled": " where the observer rests"}[kind] + _held(values, point, kind)
    if args.plot:
        _save(args, found.plot("against", title), args.plot)
    if args.map and len(values) == 1 and args.cloud is None and kind != "settled":
        beside = None
        if kind == "frozen" and "omega" in values:
            beside = table2(next(iter(setups.values())).machine,
                            {label: (one.observer, one.gains) for label, one in setups.items()})
        contours = "" if args.show == "decay" else args.show
        _save(args, found.plot("plane", title, printed=beside, contours=contours), args.map)
    elif args.map:
        _save(args, found.plot("plane", title), args.map)
    if args.out:
        _write(args, data)
    summary = _summary(args, setups, data, values, point, kind)
    if args.json:
        summary |= {name: data[name].values for name in values}
        summary |= {"re": data["re"].values, "im": data["im"].values, "dims": list(data["re"].dims), "observer": list(setups)}
    return summary


def _held(values: dict[str, Any], point: Any, kind: Any) -> str:
    """What a picture's title says of the operating point: what of it is not swept."""
    parts = {"omega": (point.omega, "rad/s"), "slip": (point.slip, "rad/s"), "flux": (point.flux, "Wb")}
    used = ("omega",) if kind == "frozen" else tuple(parts)
    texts = [f"{name} = {parts[name][0]:.4g} {parts[name][1]}" for name in used if name not in values]
    return f"; {', '.join(texts)}" if texts else ""


def _summary(
    args: argparse.Namespace, setups: dict[str, Setup], data: xr.Dataset, values: dict[str, Any], point: Any, kind: Any
) -> dict[str, Any]:
    """Print, for each observer, the least damped moving pole, where the sweep is unstable, and where stability ends."""
    import numpy as np

    from imo_analysis.commands.output import say
    from imo_analysis.pencils.boundaries import stability_boundaries

    over = next(iter(values))
    unstable: dict[str, int] = {}
    limits: dict[str, list[dict[str, float]]] = {}
    for label in data["observer"].values:
        part = data.sel(observer=label)
        moving = part["re"].where(~part["neutral"]).values
        if not np.isfinite(moving).any():
            say(args, f"{label}: has no state at rest at any point of the sweep")
            continue
        worst = np.nanmax(np.where(np.isfinite(moving), moving, -np.inf), axis=1)
        at = int(np.argmax(worst))
        unstable[str(label)] = int((worst > 1e-9 * np.nanmax(np.abs(moving))).sum())
        where = ", ".join(_at(part[name], float(part[name].values[at])) for name in values)
        say(args, f"{label}: slowest pole {worst[at]:.4g} /s at {where}; unstable at {unstable[str(label)]} of {len(worst)} "
            f"points; {int(part['neutral'].sum())} poles on the axis by structure")
        there = moving[:, np.isfinite(moving).any(axis=0)]
        if len(values) == 1 and args.cloud is None and np.all(np.isfinite(there)):
            limits[str(label)] = stability_boundaries(setups[str(label)], values, point, kind)
            for value in dict.fromkeys(round(one["value"], 9) + 0.0 for one in limits[str(label)]):
                say(args, f"  a pole crosses the imaginary axis at {_at(data[over], value, 10)}")
    unclear = int(data.attrs.get("unclear", 0))
    if unclear:
        say(args, f"at {unclear} step{'s' if unclear > 1 else ''} two branches come too close to be told apart, and may be "
            f"swapped from there on; give --over {over} more points than {data.sizes[over]}, or a range without that place")
    return {"over": ", ".join(values), "unstable": unstable, "boundaries": limits, "unclear": unclear}


def _at(axis: xr.DataArray, value: float, digits: int = 6) -> str:
    """A swept value with its unit: SI was meant where none was given."""
    unit = axis.attrs.get("units", "1")
    return f"{axis.name} = {value + 0.0:.{digits}g}" + ("" if unit == "1" else f" {unit}")


def _map(args: argparse.Namespace, setups: dict[str, Setup], values: dict[str, Any], point: Any, kind: Any) -> dict[str, Any]:
    from imo_analysis.commands.output import say
    from imo_analysis.pencils.stability import stability_map
    from imo_analysis.pencils.sweep import pole_sweep

    found = stability_map(setups, values, point, kind)
    data = found.data
    title = {"frozen": "At frozen speed", "full": "With adaptation", "settled": "Where the observer rests"}[kind]
    title += _held(values, point, kind)
    if args.map:
        _save(args, found.plot(args.show, title), args.map)
    if args.out:
        _write(args, pole_sweep(setups, values, point, kind).data)
    x_name, y_name = values
    for label, share in found.stable_share().items():
        decay = data["decay"].sel(observer=label)
        if not bool(decay.notnull().any()):
            say(args, f"{label}: has no state at rest at any point of the map")
            continue
        best = decay.fillna(-float("inf")).argmax(...)
        at = decay.isel({str(name): place for name, place in best.items()})
        where = ", ".join(_at(at[name], float(at[name])) for name in (x_name, y_name))
        if share == 0:
            say(args, f"{label}: no stable point on this map; the least unstable is {where}, "
                f"with a pole at {-float(at):+.4g} /s")
        else:
            say(args, f"{label}: stable at {share:.1%} of the points; fastest decay {float(at):.4g} /s at {where}")
    result: dict[str, Any] = {"over": [x_name, y_name], "stable_share": found.stable_share()}
    if args.json:
        result |= {str(name): data[name].values for name in (x_name, y_name, *data.data_vars)}
        result |= {"dims": list(data["decay"].dims), "observer": list(setups)}
    return result


def _save(args: argparse.Namespace, figure: Any, path: str) -> None:
    from imo_analysis.commands.output import say
    from imo_analysis.drawing import save_svg

    save_svg(figure, path)
    say(args, f"wrote {path}")


def _write(args: argparse.Namespace, data: xr.Dataset) -> None:
    """The poles as NetCDF or CSV by the ending; in CSV without the lines that only pad."""
    from imo_analysis.commands.output import say
    from imo_analysis.files import replacing
    from imo_analysis.simulation.runfile import write_netcdf

    with replacing(args.out) as beside:
        if args.out.endswith(".nc"):
            write_netcdf(data.assign_coords(neutral=data["neutral"].astype("int8")), beside)
        else:
            data.to_dataframe().reset_index().dropna(subset=["re"]).to_csv(beside, index=False)
    say(args, f"wrote {args.out}")
