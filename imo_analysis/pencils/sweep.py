"""Poles over a sweep of the speed, a machine parameter or a gain, as a labelled data set with continuous branches.

Branches are carried on from point to point along their tangents, by the assignment of least total distance from where the
tangents lead. Where an assignment is not clear (a pole misses its place by more than half of what the next candidate does)
points in between are computed until it is, down to a 4096th of a step; places that stay unclear, such as a double pole, are
counted in the attribute ``unclear``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.catalogue import PARAMETERS
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.notation import symbol
from imo_analysis.pencils.error import Gains, OperatingPoint, arguments, gain_values, poles, poles_of_rank
from imo_analysis.pencils.jacobian import Kind, jacobian, known_observer, structural_rank

if TYPE_CHECKING:
    import xarray as xr

_DEPTH = 12
_BUDGET = 48  # points between two neighbours, so that a double pole does not cost 2^12 of them
_SAME = 1e-9  # of the largest pole: closer than this, two poles are one


@dataclass(frozen=True)
class Track:
    """Poles with continuous branches: ``branches`` of shape (points, n), and how many steps stayed unclear."""

    branches: np.ndarray
    unclear: int


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
    if count > 10_000_000:
        raise InputError(f"{name} = {start:g}:{stop:g}:{count} has too many points; COUNT must be at most 10000000")
    return np.linspace(start, stop, count)


def pole_sweep(
    machine: InductionMachine,
    observer: str,
    gains: Gains,
    values: Sequence[float] | np.ndarray,
    over: str = "omega",
    point: OperatingPoint | None = None,
    kind: Kind = "frozen",
) -> xr.Dataset:
    """Poles of an observer's error dynamics over a sweep.

    Parameters
    ----------
    machine : InductionMachine
        As the observer believes it to be.
    observer : str
        Its name in the catalogue.
    gains : mapping or sequence of float
        Its gains.
    values : array of float, shape (points,)
        Strictly increasing.
    over : str
        What the values are of: ``omega``, ``slip`` or ``flux`` of the operating point, a machine field (``R_s``, ``R_r``,
        ``L_m``, ``L_s``, ``L_r``), a parameter (``alpha``, ``sigma``, ``beta``) or a gain.
    point : OperatingPoint, optional
        Speed, and for ``kind="full"`` flux and slip. May be left out for a frozen sweep over ``omega``.
    kind : str
        ``frozen`` or ``full``, see `imo_analysis.pencils.jacobian`.

    Returns
    -------
    xarray.Dataset
        Dimensions (``over``, ``branch``): ``re`` (1/s), ``im`` (rad/s), ``natural_frequency`` (rad/s) and ``damping`` (1).
        The coordinate ``neutral`` marks branches that stay on the imaginary axis by structure.

    Raises
    ------
    InputError
        For an unknown observer, parameter or gain, and for values that are empty, not finite or not increasing.
    """
    import xarray as xr

    points = checked(values, over)
    found = evaluator(machine, observer, gains, over, point, kind)
    tracked = track(points, found.moving)
    still = found.neutral(points)
    roots = np.concatenate([tracked.branches, still], axis=-1)
    size = np.abs(roots)
    neutral = np.arange(roots.shape[1]) >= tracked.branches.shape[1]
    damping = np.divide(-roots.real, size, out=np.zeros_like(size), where=size > 0)
    dims = (over, "branch")
    return xr.Dataset(
        {
            "re": (dims, roots.real, {"units": "1/s", "long_name": "pole, real part", "latex": r"\mathrm{Re}\,s"}),
            "im": (dims, roots.imag, {"units": "rad/s", "long_name": "pole, imaginary part", "latex": r"\mathrm{Im}\,s"}),
            "natural_frequency": (dims, size, {"units": "rad/s", "long_name": "magnitude of the pole", "latex": "|s|"}),
            "damping": (dims, damping, {"units": "1", "long_name": "damping ratio, -Re s / |s|; 0 for a pole at zero",
                                        "latex": r"\zeta"}),
        },
        coords={
            over: (over, points, described(over)),
            "branch": np.arange(1, roots.shape[1] + 1),
            "neutral": ("branch", neutral),
        },
        attrs={"schema": "imo-poles/1", "observer": observer, "kind": kind, "machine": machine.name, "over": over,
               "unclear": tracked.unclear, "gains": _gain_text(observer, gains)},
    )


def checked(values: Sequence[float] | np.ndarray, name: str) -> np.ndarray:
    """The values as a strictly increasing array of floats."""
    points = np.asarray(values, dtype=float)
    if points.ndim != 1 or points.size == 0:
        raise InputError(f"the sweep over {name} is empty; give at least one value")
    if not np.all(np.isfinite(points)):
        raise InputError(f"the sweep over {name} has a value that is not finite; every value must be a number")
    if np.any(np.diff(points) <= 0):
        raise InputError(f"the sweep over {name} must increase from value to value")
    return points


def described(name: str) -> dict[str, str]:
    """Unit, meaning and LaTeX of anything that can be swept, as attributes."""
    own = {
        "flux": ("Wb", "magnitude of the rotor flux", r"|\phi_r|"),
        "omega": ("rad/s", "electrical speed", r"\hat{\omega}"),
    }
    unit, meaning, latex = own.get(name) or (symbol(name).unit, symbol(name).meaning, symbol(name).latex)
    return {"units": unit, "long_name": meaning, "latex": latex}


def _gain_text(observer: str, gains: Gains) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in gain_values(observer, gains, ()).items())


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


def evaluator(
    machine: InductionMachine,
    observer: str,
    gains: Gains,
    over: str | tuple[str, ...],
    point: OperatingPoint | None,
    kind: Kind,
) -> Poles:
    """The poles as functions of the swept parameter; arguments as in `pole_sweep`.

    With a tuple of names for ``over`` the functions take a tuple of arrays that broadcast.

    The adaptive observers have poles that no gain moves: at zero at frozen speed; at zero and at plus and minus j times the
    stator frequency in the frame of the flux. Near one of them an eigenvalue solver mixes it with a pole that crosses the
    axis there, so they are taken out first: exactly, through the rank, at frozen speed; by position otherwise.
    """
    derived = jacobian(observer, kind)
    if point is None:
        if over != "omega" or kind != "frozen":
            raise InputError(f"a sweep over {over} ({kind}) needs an operating point: give its speed"
                             + (", flux and slip" if kind == "full" else ""))
        point = OperatingPoint(0.0, None)
    swept = {"omega", *known_observer(observer).gains, *PARAMETERS, "R_r", "L_s", "L_r"}
    if kind == "full":
        swept |= {"slip", "flux"}
    names = over if isinstance(over, tuple) else (over,)
    for name in names:
        if name not in swept:
            known = ", ".join(sorted(swept))
            raise InputError(f"over = {name!r} is not a parameter of {observer} ({kind}); choose one of: {known}")
    fixed = point
    n = len(derived.states)

    def arrays(values: Any) -> dict[str, np.ndarray]:
        given = values if isinstance(over, tuple) else (values,)
        return {name: np.asarray(value, dtype=float) for name, value in zip(names, given, strict=True)}

    def shape(values: Any) -> tuple[int, ...]:
        return np.broadcast_shapes(*(array.shape for array in arrays(values).values()))

    def matrices(values: Any) -> np.ndarray:
        found = derived.system_matrix(arguments(derived, machine, gains, fixed, arrays(values)))
        return np.broadcast_to(found, (*shape(values), n, n))

    if kind == "frozen":
        rank = structural_rank(observer)
        return Poles(
            lambda values: poles_of_rank(matrices(values), rank),
            lambda values: np.zeros((*shape(values), n - rank), dtype=complex),
        )

    def targets(values: Any) -> np.ndarray:
        changed = replace(fixed, **{name: at for name, at in arrays(values).items() if name in ("omega", "slip")})
        frame = np.broadcast_to(np.asarray(changed.omega + changed.slip, dtype=float), shape(values))
        return np.stack([np.zeros_like(frame), frame, -frame], axis=-1) * 1j

    count = 3 if "xi_1_tilde" in derived.states else 0
    return Poles(
        lambda values: _without(poles(matrices(values)), targets(values)[..., :count]),
        lambda values: targets(values)[..., :count],
    )


def _without(values: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """The poles without the one nearest to each target in turn."""
    for k in range(targets.shape[-1]):
        nearest = np.argmin(np.abs(values - targets[..., k : k + 1]), axis=-1)
        keep = np.arange(values.shape[-1]) != nearest[..., None]
        values = values[keep].reshape(*values.shape[:-1], values.shape[-1] - 1)
    return values


def track(points: np.ndarray, evaluate: Callable[[Any], np.ndarray]) -> Track:
    """Join the poles of neighbouring points to branches, with more points where that is not clear."""
    raw = evaluate(points)
    if len(points) == 1:
        return Track(raw, 0)
    walk = _Walk(evaluate, _SAME * float(np.abs(raw).max()))
    branches = np.empty_like(raw)
    near = points[0] + (points[1] - points[0]) / 1024
    beside = _nearest(raw[0], evaluate(np.array([near]))[0])
    branches[0], slope = raw[0], (beside - raw[0]) / (near - points[0])
    unclear = 0
    for k in range(1, len(points)):
        walk.budget = _BUDGET
        branches[k], slope, failed = walk.join(branches[k - 1], slope, raw[k], points[k - 1], points[k], _DEPTH)
        unclear += failed
    return Track(branches, unclear)


def _nearest(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    from scipy.optimize import linear_sum_assignment

    return np.asarray(after[linear_sum_assignment(np.abs(before[:, None] - after[None, :]))[1]])


@dataclass
class _Walk:
    """Carries branches from one point to the next; ``budget`` is how many points in between it may still compute."""

    evaluate: Callable[[Any], np.ndarray]
    tolerance: float
    budget: int = 0

    def join(
        self, before: np.ndarray, slope: np.ndarray, after: np.ndarray, x_0: float, x_1: float, depth: int
    ) -> tuple[np.ndarray, np.ndarray, bool]:
        """``after`` in the order of ``before``, the slopes there, and whether the order stayed unclear somewhere."""
        from scipy.optimize import linear_sum_assignment

        distance = np.abs((before + slope * (x_1 - x_0))[:, None] - after[None, :])
        chosen = linear_sum_assignment(distance)[1]
        ordered = after[chosen]
        clear = _clear(distance, chosen, after, self.tolerance)
        if clear or depth == 0 or self.budget == 0:
            return ordered, (ordered - before) / (x_1 - x_0), not clear
        self.budget -= 1
        middle = 0.5 * (x_0 + x_1)
        between = self.evaluate(np.array([middle]))[0]
        half, slope, first = self.join(before, slope, between, x_0, middle, depth - 1)
        ordered, slope, second = self.join(half, slope, after, middle, x_1, depth - 1)
        return ordered, slope, first or second


def _clear(distance: np.ndarray, chosen: np.ndarray, after: np.ndarray, tolerance: float) -> bool:
    """Whether every pole misses its predicted place by less than half of what any other value misses it by."""
    rows = np.arange(len(chosen))
    moved = distance[rows, chosen]
    other = np.abs(after[None, :] - after[chosen][:, None]) > tolerance
    rival = np.where(other, distance, np.inf).min(axis=1)
    return bool(np.all((moved <= tolerance) | (moved < 0.5 * rival)))


def stability_boundaries(
    machine: InductionMachine,
    observer: str,
    gains: Gains,
    values: Sequence[float] | np.ndarray,
    over: str = "omega",
    point: OperatingPoint | None = None,
    kind: Kind = "frozen",
) -> list[dict[str, float]]:
    """Where a pole crosses the imaginary axis, to 1e-10 of the step.

    Crossings are looked for between neighbouring values, on tracked branches, and then halved in. A branch that stays on the
    axis by structure is not counted; two crossings within one step are missed: use a finer sweep.

    Returns
    -------
    list of dict
        Keys ``value`` (of what is swept), ``im`` (rad/s, of the pole there), ``branch`` and ``direction`` (+1 when it becomes
        unstable with rising value), in the order of the sweep.
    """
    points = checked(values, over)
    evaluate = evaluator(machine, observer, gains, over, point, kind).moving
    roots = track(points, evaluate).branches
    tolerance = _SAME * float(np.abs(roots).max())
    found = []
    side = np.where(np.abs(roots.real) <= tolerance, 0, np.sign(roots.real))
    for branch in range(roots.shape[1]):
        for k in np.flatnonzero(side[:-1, branch] * side[1:, branch] < 0):
            value, pole = _crossing(evaluate, (points[k], points[k + 1]), (roots[k, branch], roots[k + 1, branch]))
            found.append({"value": value, "im": float(pole.imag), "branch": branch + 1,
                          "direction": float(side[k + 1, branch])})
        for k in np.flatnonzero((side[1:-1, branch] == 0) & (side[:-2, branch] * side[2:, branch] < 0)):
            found.append({"value": float(points[k + 1]), "im": float(roots[k + 1, branch].imag), "branch": branch + 1,
                          "direction": float(side[k + 2, branch])})
    return sorted(found, key=lambda crossing: crossing["value"])


def _crossing(
    evaluate: Callable[[Any], np.ndarray], ends: tuple[float, float], poles_there: tuple[complex, complex]
) -> tuple[float, complex]:
    """Halve the step in which one branch crosses the axis; at each point the branch is the pole nearest to its chord."""
    (low, high), (left, right) = ends, poles_there
    for _ in range(60):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        candidates = evaluate(np.array([middle]))[0]
        pole = candidates[np.argmin(np.abs(candidates - 0.5 * (left + right)))]
        if np.sign(pole.real) == np.sign(left.real):
            low, left = middle, pole
        else:
            high, right = middle, pole
    return float(0.5 * (low + high)), left


def sweep_observers(
    machines: Mapping[str, InductionMachine],
    observers: Mapping[str, tuple[str, Gains]],
    values: np.ndarray,
    over: str = "omega",
    point: OperatingPoint | None = None,
    kind: Kind = "frozen",
) -> xr.Dataset:
    """Sweeps of several observers in one data set: `pole_sweep` with the dimension ``observer`` first.

    ``machines`` and ``observers`` (kind, gains) have the same labels. Observers with fewer poles are padded with NaN.
    """
    import xarray as xr

    parts = []
    for label, (name, gains) in observers.items():
        part = pole_sweep(machines[label], name, gains, values, over, point, kind)
        parts.append(part.reset_coords("neutral").expand_dims(observer=[label]))
    whole = xr.concat(parts, dim="observer", join="outer", fill_value={"neutral": False}, combine_attrs="drop_conflicts")
    whole = whole.set_coords("neutral").assign_coords(observer_kind=("observer", [name for name, _ in observers.values()]))
    whole.attrs["unclear"] = sum(part.attrs["unclear"] for part in parts)
    return whole
