"""Poles over any parameter or gain, over two of them, or over a cloud of points, as labelled data that can be drawn.

Over one parameter the poles are joined to continuous branches (`imo_analysis.pencils.branches`); over two, or in a cloud,
they are as the solver orders them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from imo_analysis.equations.catalogue import PARAMETERS
from imo_analysis.equations.own import shown
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.notation import symbol
from imo_analysis.pencils.branches import track
from imo_analysis.pencils.closed_form import closed_form
from imo_analysis.pencils.error import MACHINE_FIELDS, Gains, OperatingPoint, arguments, gain_values
from imo_analysis.pencils.jacobian import jacobian, known_observer
from imo_analysis.pencils.reduced import reduced
from imo_analysis.pencils.setup import Setup, labelled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

SweptKind = Literal["frozen", "full", "settled"]
ERROR = "_error"  # R_r_error is the relative error of the rotor resistance that the observer believes in
_ALIASES = {"omega_hat": "omega"}  # frozen at omega, or at rest there
_MOST = 10_000_000


@dataclass(frozen=True)
class PoleSweep:
    """Poles over what was swept.

    Attributes
    ----------
    data : xarray.Dataset
        As `pole_sweep` says.
    """

    data: xr.Dataset

    @property
    def over(self) -> tuple[str, ...]:
        """Names of what was swept."""
        return tuple(self.data.attrs["over"].split(", "))

    def plot(self, view: str = "plane", title: str = "", **kwargs: Any) -> Figure:
        """A picture of the poles.

        Parameters
        ----------
        view : str
            ``plane``, the paths of the poles, or ``against``, real and imaginary part over one parameter.
        title : str
            Above the picture.
        **kwargs
            Those of `imo_analysis.pencils.maps.plot_plane`: ``marks``, ``printed``, ``contours``.

        Notes
        -----
        Over two parameters, or of a cloud, the plane shows a point for each pole; a map of what two parameters do is
        `imo_analysis.pencils.stability.stability_map`.

        Raises
        ------
        InputError
            For a view that there is not, or that needs one parameter and has more.
        """
        from imo_analysis.pencils import maps

        views = {"plane": maps.plot_plane if self._followed else maps.plot_points, "against": maps.plot_against}
        if view not in views:
            raise InputError(f"view = {view!r} is not known; choose one of: {', '.join(views)}")
        if view == "against" and len(self.over) > 1:
            raise InputError(f"view = 'against' needs one swept parameter, and there are {', '.join(self.over)}; use plane")
        return views[view](self.data, title, **kwargs)

    @property
    def _followed(self) -> bool:
        return "unclear" in self.data.attrs


def grid(start: float, stop: float, count: int, name: str = "sweep") -> np.ndarray:
    """Equally spaced values, both ends included.

    Raises
    ------
    InputError
        If it is empty, not finite, or its ends are in the wrong order.
    """
    if count < 1:
        raise InputError(f"{name} = {start:g}:{stop:g}:{count} is empty; COUNT must be 1 or more")
    if not (np.isfinite(start) and np.isfinite(stop)):
        raise InputError(f"{name} = {start:g}:{stop:g}:{count} must have finite ends")
    if count == 1 and start != stop:
        raise InputError(f"{name} = {start:g}:{stop:g}:1 has one point but two ends; use more points, or equal ends")
    if count > 1 and stop <= start:
        raise InputError(f"{name} = {start:g}:{stop:g}:{count} must have STOP above START")
    if count > _MOST:
        raise InputError(f"{name} = {start:g}:{stop:g}:{count} has too many points; COUNT must be at most {_MOST}")
    return np.linspace(start, stop, count)


def pole_sweep(
    observer: Setup | Mapping[str, Setup],
    over: Mapping[str, Any],
    point: OperatingPoint | None = None,
    kind: SweptKind = "frozen",
    cloud: bool = False,
) -> PoleSweep:
    """Poles of the error dynamics of an observer, or of several, over one or two parameters or a cloud.

    Parameters
    ----------
    observer : Setup or mapping of str to Setup
        One, or several by label; those with fewer poles are then padded with NaN.
    over : mapping of str to array
        Name and values, strictly increasing: ``omega`` (or ``omega_hat``), ``slip`` or ``flux`` of the operating point, a
        machine field (``R_s``, ``R_r``, ``L_m``, ``L_s``, ``L_r``) of what the observer believes or its relative error
        (``R_r_error``), a parameter (``alpha``, ``sigma``, ``beta``) or a gain. One name, or two for a grid.
    point : OperatingPoint, optional
        Speed, and for ``kind="full"`` flux and slip. May be left out where the speed is swept and the kind is frozen.
    kind : str
        ``frozen`` or ``full``, see `imo_analysis.pencils.jacobian`; or ``settled``, where the observer rests with the
        parameter errors that are swept, alpha_hat held (`imo_analysis.pencils.operating`): NaN where it does not rest. There
        the machine is the true one, and of its fields only the errors can be swept.
    cloud : bool
        The values of all names, in any order and of one length, belong together point by point; any number of names.

    Returns
    -------
    PoleSweep
        Its data has the dimensions of ``over``, or ``sample`` for a cloud, and ``branch``, after ``observer`` for several:
        ``re`` (1/s), ``im`` (rad/s), ``natural_frequency`` (rad/s) and ``damping`` (1). The coordinate ``neutral`` marks
        branches that stay on the imaginary axis by structure. Over one parameter a branch is one pole followed through the
        sweep, and the attribute ``unclear`` counts the steps where branches could not be told apart.

    Raises
    ------
    InputError
        For an unknown observer, parameter or gain, one name twice, and values that are empty, not finite or not increasing.
    """
    import xarray as xr

    swept = axes(over, cloud)
    if isinstance(observer, Setup):
        return PoleSweep(_one(observer, swept, point, kind, cloud))
    parts = []
    for label, one in labelled(observer).items():
        part = _one(one, swept, point, kind, cloud)
        parts.append(part.reset_coords("neutral").expand_dims(observer=[label]))
    whole = xr.concat(parts, dim="observer", join="outer", fill_value={"neutral": False}, combine_attrs="drop_conflicts")
    kinds = [shown(one.observer) for one in observer.values()]
    whole = whole.set_coords("neutral").assign_coords(observer_kind=("observer", kinds))
    if "unclear" in parts[0].attrs:
        whole.attrs["unclear"] = sum(part.attrs["unclear"] for part in parts)
    return PoleSweep(whole)


def _one(setup: Setup, swept: dict[str, np.ndarray], point: OperatingPoint | None, kind: SweptKind, cloud: bool) -> xr.Dataset:
    import xarray as xr

    names = tuple(swept)
    found = evaluator(setup.machine, setup.observer, setup.gains, names, point, kind)
    attributes: dict[str, Any] = {}
    at = tuple(swept.values()) if cloud else tuple(np.meshgrid(*swept.values(), indexing="ij", sparse=True))
    moving = found.moving(at)
    if len(names) == 1 and not cloud and np.all(np.isfinite(moving)):
        tracked = track(at[0], lambda values: found.moving((values,)))
        moving, attributes["unclear"] = tracked.branches, tracked.unclear
    roots = np.concatenate([moving, found.neutral(at)], axis=-1)
    size = np.abs(roots)
    damping = np.divide(-roots.real, size, out=np.zeros_like(size), where=size > 0)
    dims = (*(("sample",) if cloud else names), "branch")
    return xr.Dataset(
        {
            "re": (dims, roots.real, {"units": "1/s", "long_name": "pole, real part", "latex": r"\mathrm{Re}\,s"}),
            "im": (dims, roots.imag, {"units": "rad/s", "long_name": "pole, imaginary part", "latex": r"\mathrm{Im}\,s"}),
            "natural_frequency": (dims, size, {"units": "rad/s", "long_name": "magnitude of the pole", "latex": "|s|"}),
            "damping": (dims, damping, {"units": "1", "long_name": "damping ratio, -Re s / |s|; 0 for a pole at zero",
                                        "latex": r"\zeta"}),
        },
        coords={
            **{name: ("sample" if cloud else name, values, described(name)) for name, values in swept.items()},
            "branch": np.arange(1, roots.shape[-1] + 1),
            "neutral": ("branch", np.arange(roots.shape[-1]) >= moving.shape[-1]),
        },
        attrs={"schema": "imo-poles/1", "observer": shown(setup.observer), "kind": kind, "machine": setup.machine.name,
               "over": ", ".join(names), "gains": _gain_text(setup), **attributes},
    )


def axes(over: Mapping[str, Any], cloud: bool = False) -> dict[str, np.ndarray]:
    """What is swept, under its own name and checked."""
    if not over:
        raise InputError("nothing is swept; name at least one parameter")
    swept: dict[str, np.ndarray] = {}
    for name, values in over.items():
        own = _ALIASES.get(name, name)
        same = {own, "alpha" if own == "R_r" else own, "R_r" if own == "alpha" else own, own.removesuffix(ERROR)}
        for other in swept:
            if same & {other, other.removesuffix(ERROR)}:
                raise InputError(f"{other} and {name} are swept together, but are one quantity; choose two that differ")
        swept[own] = checked(values, name, increasing=not cloud)
    if cloud:
        lengths = {name: len(values) for name, values in swept.items()}
        if len(set(lengths.values())) > 1:
            raise InputError("a cloud needs as many values of each parameter: "
                             + ", ".join(f"{name} has {length}" for name, length in lengths.items()))
    elif len(swept) > 2:
        raise InputError(f"{len(swept)} parameters are swept; give one or two, or a cloud for more")
    if not cloud and (count := int(np.prod([len(values) for values in swept.values()], dtype=float))) > _MOST:
        raise InputError(f"the sweep has {count} points; at most {_MOST} are possible")
    return swept


def checked(values: Any, name: str, increasing: bool = True) -> np.ndarray:
    """The values as an array of floats, strictly increasing where asked for."""
    try:
        points = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"the sweep over {name} must be numbers, in {described(name)['units']}") from None
    if points.ndim != 1 or points.size == 0:
        raise InputError(f"the sweep over {name} is empty; give at least one value")
    if not np.all(np.isfinite(points)):
        raise InputError(f"the sweep over {name} has a value that is not finite; every value must be a number")
    if increasing and np.any(np.diff(points) <= 0):
        raise InputError(f"the sweep over {name} must increase from value to value")
    return points


def described(name: str) -> dict[str, str]:
    """Unit, meaning and LaTeX of anything that can be swept, as attributes."""
    try:
        field = symbol(name.removesuffix(ERROR))
    except InputError:
        if name != "flux":
            raise InputError(f"{name!r} is neither a parameter nor a gain; names are as in Table I: omega, R_r, ...") from None
    if name.endswith(ERROR):
        return {"units": "1", "long_name": f"relative error of the {field.meaning} believed",
                "latex": rf"\Delta {field.latex} / {field.latex}"}
    own = {
        "flux": ("Wb", "magnitude of the rotor flux", r"|\phi_r|"),
        "omega": ("rad/s", "electrical speed", r"\hat{\omega}"),
    }
    unit, meaning, latex = own.get(name) or (field.unit, field.meaning, field.latex)
    return {"units": unit, "long_name": meaning, "latex": latex}


def _gain_text(setup: Setup) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in gain_values(setup.observer, setup.gains, ()).items())


@dataclass(frozen=True)
class Poles:
    """The poles as functions of the values of one parameter, those that are neutral by structure apart from the rest.

    Attributes
    ----------
    moving : callable
        Array of shape (points,) to complex (points, n - m).
    neutral : callable
        The same to complex (points, m): exactly on the imaginary axis.
    """

    moving: Callable[[Any], np.ndarray]
    neutral: Callable[[Any], np.ndarray]


def sweepable(observer: str, kind: SweptKind = "frozen") -> tuple[str, ...]:
    """Names of all that the poles of an observer can be swept over."""
    errors = tuple(f"{field}{ERROR}" for field in MACHINE_FIELDS)
    own = {"frozen": (*PARAMETERS, *MACHINE_FIELDS, *errors), "full": (*PARAMETERS, *MACHINE_FIELDS, "slip", "flux"),
           "settled": (*errors, "slip", "flux")}[kind]
    return tuple(sorted({"omega", *known_observer(observer).gains, *own}))


def evaluator(
    machine: InductionMachine,
    observer: str,
    gains: Gains,
    over: str | tuple[str, ...],
    point: OperatingPoint | None,
    kind: SweptKind,
) -> Poles:
    """The poles as functions of the swept parameter; ``point`` and ``kind`` as in `pole_sweep`.

    With a tuple of names for ``over`` the functions take a tuple of arrays that broadcast. The poles are not in any order.

    The adaptive observers have poles that no gain moves: two at zero at frozen speed; two at plus and minus j times the
    stator frequency and one at zero in the frame of the flux. Near one of them an eigenvalue solver mixes it with a pole that
    crosses the axis there, so they are left out of the matrix (`imo_analysis.pencils.reduced`).
    """
    names = over if isinstance(over, tuple) else (over,)
    possible = sweepable(observer, kind)
    for name in names:
        if name not in possible:
            raise InputError(f"over = {name!r} is not a parameter of {shown(observer)} ({kind}); choose one of: "
                             f"{', '.join(possible)}")
    if point is None:
        if "omega" not in names or kind != "frozen":
            raise InputError(f"a sweep over {', '.join(names)} ({kind}) needs an operating point: give its speed"
                             + (", flux and slip" if kind != "frozen" else ""))
        point = OperatingPoint(0.0, None)
    fixed = point

    def arrays(values: Any) -> dict[str, np.ndarray]:
        given = values if isinstance(over, tuple) else (values,)
        return {name: np.asarray(value, dtype=float) for name, value in zip(names, given, strict=True)}

    def shape(values: Any) -> tuple[int, ...]:
        return np.broadcast_shapes(*(array.shape for array in arrays(values).values()))

    def pair(values: Any) -> np.ndarray:
        changed = replace(fixed, **{name: at for name, at in arrays(values).items() if name in ("omega", "slip")})
        frame = np.broadcast_to(np.asarray(changed.omega + changed.slip, dtype=float), shape(values))
        return np.stack([frame, -frame], axis=-1) * 1j

    if kind == "settled":
        return _settled(machine, observer, gains, fixed, arrays, shape, pair)
    derived = jacobian(observer, kind)

    def finite(solve: Callable[[dict[str, Any]], np.ndarray], values: Any) -> np.ndarray:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # said below, once and in words
            found = solve(numbers(values))
            if not (np.isfinite(np.sum(found)) or np.all(np.isfinite(found))):
                raise InputError(f"the poles of {shown(observer)} overflow somewhere over {', '.join(names)}; "
                                 "sweep, or choose gains, within a smaller range")
        return np.broadcast_to(found, (*shape(values), found.shape[-1]))

    def numbers(values: Any) -> dict[str, Any]:
        changes = {}
        for name, value in arrays(values).items():
            field = name.removesuffix(ERROR)
            changes[field] = value if field == name else getattr(machine, field) * (1 + value)
        return arguments(derived, machine, gains, fixed, changes)

    form = closed_form(observer) if kind == "frozen" else None
    if form is not None:
        solved = form
        return Poles(
            lambda values: finite(solved.poles, values),
            lambda values: np.zeros((*shape(values), solved.at_zero), dtype=complex),
        )
    smaller = reduced(observer, kind)
    left_out = len(derived.states) - smaller.matrix.rows
    if kind == "frozen":
        return Poles(
            lambda values: finite(smaller.poles, values),
            lambda values: np.zeros((*shape(values), left_out), dtype=complex),
        )
    if left_out == 0:
        return Poles(lambda values: finite(smaller.poles, values), lambda values: pair(values)[..., :0])
    return Poles(
        lambda values: finite(smaller.poles, values),
        lambda values: np.concatenate([np.zeros((*shape(values), 1)), pair(values)], axis=-1),
    )


def _settled(
    machine: InductionMachine, observer: str, gains: Gains, point: OperatingPoint, arrays: Any, shape: Any, pair: Any
) -> Poles:
    """The poles where an observer with parameter errors rests, without the two at plus and minus j times the frequency.

    Those are exactly there but for the paper's conventions with a wrong R_s or leakage: see `operating.poles_with_errors`.
    """
    from imo_analysis.pencils.operating import poles_with_errors

    def whole(values: Any) -> np.ndarray:
        given = arrays(values)
        at = replace(point, **{name: value for name, value in given.items() if name in ("omega", "slip", "flux")})
        errors = {name.removesuffix(ERROR): value for name, value in given.items() if name.endswith(ERROR)}
        fed = gain_values(observer, gains) | {name: value for name, value in given.items() if name in known.gains}
        found = poles_with_errors(machine, observer, fed, at, errors)[0]
        return np.broadcast_to(found, (*shape(values), found.shape[-1]))

    known = known_observer(observer)
    count = 2 if "xi_1_hat" in known.states else 0
    return Poles(
        lambda values: _without(whole(values), pair(values)[..., :count]),
        lambda values: pair(values)[..., :count],
    )


def _without(values: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """The poles without the one nearest to each target in turn."""
    for k in range(targets.shape[-1]):
        nearest = np.argmin(np.abs(values - targets[..., k : k + 1]), axis=-1)
        keep = np.arange(values.shape[-1]) != nearest[..., None]
        values = values[keep].reshape(*values.shape[:-1], values.shape[-1] - 1)
    return values
