"""Table II beside what the observers of the catalogue really have: printed eigenvalues, computed ones, differences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.own import shown
from imo_analysis.machine import InductionMachine
from imo_analysis.pencils.error import Gains, OperatingPoint, poles_at
from imo_analysis.pencils.jacobian import structural_rank
from imo_analysis.pencils.table2_fit import PRINTED, SPEEDS, WITNESS, roots

if TYPE_CHECKING:
    import xarray as xr



def column_of(kind: str) -> str:
    """The column of Table II that an observer stands beside; empty for one that the paper does not have."""
    if kind.startswith("baseline"):
        return "baseline"
    return "proposed" if kind.endswith(("printed_7", "printed_L", "consistent_12")) else ""


def printed(column: str) -> np.ndarray:
    """The printed eigenvalues of a column, shape (speed, 4), complex, each pair with its conjugate.

    Parameters
    ----------
    column : str
        ``baseline`` or ``proposed``.
    """
    rows = []
    for omega in SPEEDS:
        pair = [complex(float(re), float(im)) for re, im in PRINTED[column][omega]]
        rows.append(sorted((*pair, *(value.conjugate() for value in pair)), key=lambda v: (v.real, v.imag)))
    return np.array(rows)


def from_quadratic(column: str) -> np.ndarray:
    """The same from the quadratic with the constants of `table2_fit.WITNESS`, rounded nowhere."""
    rows = []
    for omega in SPEEDS:
        pair = [complex(float(re.low), float(im.low)) for re, im in roots(*WITNESS, column, omega)]
        rows.append(sorted((*pair, *(value.conjugate() for value in pair)), key=lambda v: (v.real, v.imag)))
    return np.array(rows)


def without_neutral(values: np.ndarray, count: int) -> np.ndarray:
    """The ``count`` poles farthest from zero in each row, sorted by real, then imaginary part.

    The adaptive observers have two poles at zero at every speed, which Table II does not list.

    Parameters
    ----------
    values : ndarray
        Complex, the poles along the last axis.
    count : int
        How many to keep.
    """
    order = np.argsort(-np.abs(values), axis=-1, kind="stable")[..., :count]
    return np.sort(np.take_along_axis(values, order, axis=-1), axis=-1)


def table2(machine: InductionMachine, observers: Mapping[str, tuple[str, Gains]] | Sequence[Any],
           omega: Sequence[float] = SPEEDS) -> xr.Dataset:
    """Frozen-speed poles beside the printed ones.

    Parameters
    ----------
    machine : InductionMachine
        The machine that the observers' models hold.
    observers : mapping
        Label -> (observer of the catalogue, gains).
    omega : sequence of float
        Speeds in rad/s. Printed values stand beside 30, 60 and 100; NaN beside others.

    Returns
    -------
    xarray.Dataset
        Dimensions ``observer``, ``omega``, ``pole`` (four: the two poles at zero of the adaptive observers are left out; NaN
        where an own observer has fewer than another has).
        ``computed_re``, ``computed_im``, ``printed_re``, ``printed_im`` in 1/s (rad/s), ``difference`` (absolute value of
        printed minus computed, after the assignment with the least sum), ``quadratic_re``, ``quadratic_im`` (the
        constants of the explanation), and the coordinate ``column`` of Table II that the observer stands beside.
    """
    import xarray as xr
    from scipy.optimize import linear_sum_assignment

    observers = dict(observers)
    speeds = np.asarray(omega, dtype=float)
    places = [structural_rank(kind) for kind, _ in observers.values()]
    shape = (len(observers), len(speeds), max(places, default=4))
    computed = np.full(shape, np.nan + 1j * np.nan)
    beside = np.full(shape, np.nan + 1j * np.nan)
    quadratic = np.full(shape, np.nan + 1j * np.nan)
    for k, (kind, gains) in enumerate(observers.values()):
        computed[k, :, : places[k]] = without_neutral(poles_at(machine, kind, gains, OperatingPoint(speeds, None)), places[k])
        column = column_of(kind)
        for n, speed in enumerate(speeds):
            if column and speed in SPEEDS:
                at = SPEEDS.index(int(speed))
                cost = np.abs(computed[k, n][:, None] - printed(column)[at][None, :])
                beside[k, n] = printed(column)[at][linear_sum_assignment(cost)[1]]
                nearest = np.abs(beside[k, n][:, None] - from_quadratic(column)[at][None, :])
                quadratic[k, n] = from_quadratic(column)[at][linear_sum_assignment(nearest)[1]]
    dims = ("observer", "omega", "pole")
    data = xr.Dataset(
        {
            "computed_re": (dims, computed.real), "computed_im": (dims, computed.imag),
            "printed_re": (dims, beside.real), "printed_im": (dims, beside.imag),
            "quadratic_re": (dims, quadratic.real), "quadratic_im": (dims, quadratic.imag),
            "difference": (dims, np.abs(beside - computed)),
        },
        coords={
            "observer": list(observers), "omega": speeds, "pole": np.arange(1, shape[-1] + 1),
            "kind": ("observer", [shown(kind) for kind, _ in observers.values()]),
            "column": ("observer", [column_of(kind) for kind, _ in observers.values()]),
        },
        attrs={"machine": machine.name, "alpha": machine.alpha},
    )
    meanings = {"computed": "pole of the frozen-speed error dynamics", "printed": "Table II", "quadratic": "fitted quadratic"}
    for name, meaning in meanings.items():
        data[f"{name}_re"].attrs = {"units": "1/s", "long_name": f"{meaning}, real part"}
        data[f"{name}_im"].attrs = {"units": "rad/s", "long_name": f"{meaning}, imaginary part"}
    data["difference"].attrs = {"units": "1/s", "long_name": "distance of the printed from the computed pole"}
    data["omega"].attrs = {"units": "rad/s", "long_name": "electrical speed"}
    return data
