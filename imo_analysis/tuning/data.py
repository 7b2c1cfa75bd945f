"""A tuning as labelled data and as plain data for JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.study import Study
from imo_analysis.tuning.schedule import sentence
from imo_analysis.tuning.search import Found
from imo_analysis.tuning.tune import Tuned
from imo_analysis.tuning.wish import QUANTITIES, Wish, missed

if TYPE_CHECKING:
    import xarray as xr


def front_data(study: Study, results: Sequence[Tuned]) -> xr.Dataset:
    """Every set of gains of a tuning that was judged, one a point.

    Parameters
    ----------
    study : Study
        What was tuned.
    results : sequence of Tuned
        From `tune.tune`, one an observer.

    Returns
    -------
    xarray.Dataset
        Dimension ``point``; ``observer``; ``role`` (``before``, ``rule``, ``wish``, ``settling``, ``recovery``, ``chosen``);
        ``meets`` (1 where it meets the wish of the study); ``gains`` (JSON); and the `QUANTITIES`, worst over range and
        uncertainty, infinite where unstable.
    """
    import xarray as xr

    rows = [(one.name, role, found) for one in results for role, found in (
        ("before", one.before), ("rule", one.rule), *((f.role, f) for f in one.front), ("chosen", one.chosen))]
    wish = Wish.of(study)
    data: dict[str, Any] = {
        name: ("point", np.array([found.values[name] for *_, found in rows]), {"units": unit, "long_name": meaning})
        for name, (unit, meaning) in QUANTITIES.items()}
    data["meets"] = ("point", np.array([not Found(f.gains, f.values, wish.limits, f.role).missed for *_, f in rows], dtype=int),
                     {"units": "1", "long_name": "whether the wish is met"})
    data |= {"observer": ("point", [name for name, *_ in rows]), "role": ("point", [role for _, role, _ in rows]),
             "gains": ("point", [json.dumps(found.gains) for *_, found in rows])}
    return xr.Dataset(data, attrs={"study_sha256": study.sha256, "wish": json.dumps(wish.limits)})


def undominated(front: xr.Dataset, observer: str, axis: str) -> tuple[list[int], list[int]]:
    """What of an observer's gains no other beats in noise and one of the times, among those within the other wishes.

    With the settling time the lag is let go too, as the search did.

    Parameters
    ----------
    front : xarray.Dataset
        From `front_data`.
    observer : str
    axis : str
        ``settling`` or ``recovery``.

    Returns
    -------
    tuple of two lists of int
        Points that are beaten by none, the shortest time first; and all points within the other wishes.
    """
    free = {"noise", axis} | ({"lag"} if axis == "settling" else set())
    others = {name: limit for name, limit in json.loads(front.attrs["wish"]).items() if name not in free}
    x, y = front[axis].values, front["noise"].values
    within = [int(k) for k in np.flatnonzero(front["observer"].values == observer)
              if np.isfinite(x[k] + y[k]) and not missed(others, {name: float(front[name].values[k]) for name in others})]
    best: list[int] = []
    for k in sorted(within, key=lambda k: (x[k], y[k])):
        if not best or y[k] < y[best[-1]]:
            best.append(k)
    return best, within


def plain(study: Study, results: Sequence[Tuned]) -> dict[str, Any]:
    """The layout imo-tune/2, but for its head (FORMATS.md)."""
    wish = Wish.of(study)
    return {
        "study_sha256": study.sha256,
        "wish": {"omega": [wish.low, wish.high], "slip": wish.slip, "current_noise": wish.current_noise,
                 "uncertainty": wish.uncertainty, "limits": wish.limits},
        "observers": {
            one.name: {
                "kind": one.kind, "directions": "both" if len(one.signs) > 1 else "forward", "note": one.note,
                "meets": not one.chosen.missed, "missed": one.chosen.missed, "reason": one.reason,
                **{role: {"gains": found.gains, "values": found.values}
                   for role, found in (("before", one.before), ("rule", one.rule), ("chosen", one.chosen))},
                "front": [{"role": found.role, "gains": found.gains, "values": found.values, "limits": found.limits}
                          for found in one.front],
                "verified": not one.faults, "faults": one.faults,
                "simulated": {"before": asdict(one.verified_before), "rule": asdict(one.verified_rule),
                              "chosen": asdict(one.verified)},
                "schedule": {"says": sentence(one.schedule, one.chosen.missed), "alone": [asdict(at) for at in one.schedule]},
            } for one in results},
    }
