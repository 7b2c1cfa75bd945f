"""A tuning as labelled data and as plain data for JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.study import Study
from imo_analysis.tuning.search import Found
from imo_analysis.tuning.tune import Tuned
from imo_analysis.tuning.wish import QUANTITIES, Wish

if TYPE_CHECKING:
    import xarray as xr


def front_data(study: Study, results: Sequence[Tuned]) -> xr.Dataset:
    """Every set of gains of a tuning that was judged, one a point.

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


def plain(study: Study, results: Sequence[Tuned]) -> dict[str, Any]:
    """The layout imo-tune/1, but for its head (FORMATS.md)."""
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
                "verified": asdict(one.verified), "verified_before": asdict(one.verified_before),
            } for one in results},
    }
