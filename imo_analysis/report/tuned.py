"""Gains by one rule for the dossier: the study's own beside those of the rule of thumb, judged on the same wish and run.

Nothing is searched for here: ``imo tune`` does that. The rule is `imo_analysis.tuning.rule`, the judge the exact linearisation
over the range of speeds, loads and parameter errors of the study's table ``[tuning]``; the run has noise and both directions.
Whether a wish is met is said only where the simulations of `imo_analysis.tuning.verify` agree.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.drawing import TRUTH, in_style, legend_above, line, new_figure
from imo_analysis.errors import Diverged, InputError
from imo_analysis.report.scenarios import Drawn, keep
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from imo_analysis.tuning.wish import Wish

SHOWN = ("settling", "recovery", "overshoot", "lag", "noise", "bias")
HOLD = 1.0  # s at each speed of the run
LATE = 0.5  # share of that time, at its end, over which the noise is taken
ROOM = 1.6  # times the calmest error of an observer: what its axes show
BY_RULE = "_rule"  # ending of the names of the observers with the rule's gains in the run


@dataclass(frozen=True)
class Judged:
    """Gains of an observer and what they give at worst.

    Attributes
    ----------
    observer : str
        Its name in the study.
    rule : bool
        Whether the gains are the rule's.
    gains : dict of str to float
    values : dict of str to float
        By name of `imo_analysis.tuning.wish.QUANTITIES`; infinite where it is unstable somewhere in the range.
    forward : bool
        Whether only positive speeds are judged, because at negative ones it is unstable.
    missed : list of str
        Quantities that miss the wish.
    faults : list of str
        What keeps simulations with noise and parameter errors from bearing it out.
    measured : float
        Root mean square error of the speed in the run at its constant speeds, in rad/s; NaN where it was not run.
    """

    observer: str
    rule: bool
    gains: dict[str, float]
    values: dict[str, float]
    forward: bool
    missed: list[str]
    faults: list[str]
    measured: float = math.nan

    @property
    def stable(self) -> bool:
        """Whether it is stable about a state at rest all over what is judged."""
        return math.isfinite(self.values["recovery"])


@dataclass(frozen=True)
class Tuned:
    """The wish, what each observer gives with the figure of the run, and the comparison of frozen poles with its figure.

    ``fastest`` is the limit of that comparison in rad/s; ``refused`` says why there is no wish to judge by.
    """

    wish: Wish | None
    judged: list[Judged]
    run: Drawn | None
    compared: xr.Dataset | None
    decay: Drawn | None
    fastest: float
    refused: str = ""


def tuned(study: Study, folder: Path) -> Tuned:
    """Judge, compare, simulate and draw."""
    from imo_analysis.tuning.loops import TUNABLE
    from imo_analysis.tuning.rule import rule_gains
    from imo_analysis.tuning.wish import Wish

    names = [name for name, one in study.observers.items() if one.kind in TUNABLE]
    if not names:
        return Tuned(None, [], None, None, None, math.nan, "no observer of the study is of a kind that the rule is for")
    try:
        wish = Wish.of(study)
        rules = {name: {**study.observers[name].gains,
                        **rule_gains(wish.machine, study.observers[name].kind, wish.flux, wish.times)} for name in names}
        found = [one for name in names for one in _judge(wish, study, name, rules[name])]
    except InputError as error:
        return Tuned(None, [], None, None, None, math.nan, str(error))
    drawn = None
    try:
        run = _run(study, wish, rules)
        found = [_measured(one, run, wish) for one in found]
        drawn = keep(folder, "tuned", _figure(run, names),
                     f"Error of the speed with {wish.current_noise:g} A of noise, at constant speeds: each observer with the "
                     "study's gains and with the rule's, in a band from the lowest to the highest value. An observer that "
                     "loses the speed leaves its axes.")
    except Diverged:  # nothing is left of the run
        pass
    return Tuned(wish, found, drawn, *_compared(wish, folder))


def _judge(wish: Wish, study: Study, name: str, rule: dict[str, float]) -> list[Judged]:
    """The study's gains and the rule's, over both directions; over the positive one alone where the other is unstable."""
    from imo_analysis.tuning.verify import faults, verify
    from imo_analysis.tuning.wish import judge, missed

    kind, rows = study.observers[name].kind, []
    for gains in (dict(study.observers[name].gains), rule):
        values, forward = judge(wish, kind, gains), False
        if not math.isfinite(values["recovery"]) and len(wish.signs) > 1:
            ahead = judge(wish, kind, gains, (1.0,))
            if math.isfinite(ahead["recovery"]):
                values, forward = ahead, True
        rows.append((gains, values, forward))
    signs = (1.0,) if any(forward for *_, forward in rows) else wish.signs
    seen = verify(study, name, wish, signs, [gains for gains, *_ in rows])
    return [Judged(name, place == 1, gains, values, forward, missed(wish.limits, values),
                   faults(seen[place], seen[0], wish.limits)) for place, (gains, values, forward) in enumerate(rows)]


def _speeds(wish: Wish) -> list[float]:
    return [wish.low, wish.high, wish.middle, -wish.middle, -wish.high][: 5 if len(wish.signs) > 1 else 3]


def _run(study: Study, wish: Wish, rules: dict[str, dict[str, float]]) -> xr.Dataset:
    """Steps of the speed over the range, idle, with noise; every observer twice."""
    from imo_analysis.simulation.run import simulate

    speeds = _speeds(wish)
    plain = study.only(list(rules)).changed({
        "sensors.current_noise": wish.current_noise, "reference.shape": "steps", "reference.omega": speeds,
        "reference.time": [HOLD * k for k in range(len(speeds))], "load.shape": "steps", "load.time": [0.0], "load.T_l": [0.0],
        "simulation.duration": HOLD * len(speeds), "simulation.record_every": 5, "windows": [], "drive.feedback": "measured"})
    data = dict(plain.data)
    data["observers"] = {key: value for name in rules for key, value in (
        (name, data["observers"][name]), (name + BY_RULE, {**data["observers"][name], "gains": rules[name]}))}
    data["scenarios"] = {}
    try:
        return simulate(Study.from_data(data))
    except Diverged as error:
        if error.data is None or error.data.sizes["time"] < 2:
            raise
        return error.data


def _measured(one: Judged, run: xr.Dataset, wish: Wish) -> Judged:
    """With the error in the late part of each constant speed."""
    name = one.observer + (BY_RULE if one.rule else "")
    error = (run["omega"] - run["omega_hat"].sel(observer=name)).values
    late = (run["time"].values % HOLD) > (1 - LATE) * HOLD
    ahead = run["omega"].values > 0 if one.forward else np.ones(len(error), dtype=bool)
    return replace(one, measured=float(np.sqrt(np.mean(error[late & ahead] ** 2))))


@in_style
def _figure(run: xr.Dataset, names: Sequence[str]) -> Figure:
    from imo_analysis.report.run_figures import banded

    figure, axes = new_figure(len(names) + 1, 1, height=1.2 + 1.25 * len(names), sharex=True,
                              gridspec_kw={"height_ratios": [*(1.0 for _ in names), 0.6]})
    time = run["time"].values
    for panel, name in zip(axes, names, strict=False):
        size = []
        for label, key, look in (("the study's gains", name, {"color": "#6f6f6f", "linestyle": (0, (5, 2))}),
                                 ("the rule's", name + BY_RULE, line(name).kwargs())):
            error = (run["omega"] - run["omega_hat"].sel(observer=key)).values
            pieces: Any = banded(time, error)
            if pieces is None:
                panel.plot(time, error, label=label, **look)
            else:
                at, mean, low, high = pieces
                panel.plot(at, mean, label=label, **look)
                panel.fill_between(at, low, high, color=look["color"], alpha=0.25, linewidth=0)
            late = time % HOLD > (1 - LATE) * HOLD
            parts = [np.abs(error[late & (time // HOLD == k)]) for k in range(int(time[-1] // HOLD) + 1)]
            calm = [float(one.max()) for one in parts if one.size and np.isfinite(one).all()]
            size.append(min(calm, default=0.0))
        limit = ROOM * max(size)
        if limit > 0:
            panel.set_ylim(-limit, limit)
        panel.set_ylabel("error (rad/s)")
        panel.margins(x=0.01)
        legend_above(panel)
        panel.annotate(name, (1.0, 1.02), xycoords="axes fraction", ha="right", va="bottom")
    axes[-1].plot(time, run["omega"].values, color=TRUTH.color)
    axes[-1].set_ylabel("speed (rad/s)")
    axes[-1].set_xlabel("time (s)")
    return figure


def _compared(wish: Wish, folder: Path) -> tuple[xr.Dataset, Drawn, float]:
    """Frozen poles of every kind with the largest decay below one limit: `imo_analysis.pencils.compare`."""
    from imo_analysis.pencils.compare import compare

    fastest = float(wish.limits["fastest"])
    comparison = compare(wish.machine, wish.high, fastest)
    drawn = keep(folder, "compared", comparison.plot(),
                 "The same rule for all: the slowest error of the range decays as fast as it can with no pole beyond "
                 f"{fastest:g} rad/s. Decay and damping that each kind then has, over the speed.")
    return comparison.data, drawn, fastest
