"""What an engineer asks of the study of his own machine, answered in sentences: which observer works, how far off, and why.

Built from the runs of the dossier and from the map of `imo_analysis.sweeps.sensorless_map`. An observer *works* here if the
loop closed on it holds at rated torque and the first speed of the map's limits with a stator resistance that is off by
`R_S_OFF` either way. Best first: by the share of the map at which it holds; then by the runs in which it tracks; then by its
largest error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.own import astray, is_file, shown
from imo_analysis.nameplate import guessed_range
from imo_analysis.report.metrics import Resting
from imo_analysis.report.page import number
from imo_analysis.report.scenarios import Scenario, judged, outcome
from imo_analysis.simulation.judge import R_S_OFF, rpm, size, spared
from imo_analysis.study import Study
from imo_analysis.sweeps.sensorless_map import WIDEST

if TYPE_CHECKING:
    import xarray as xr

NEAR = 0.1  # of the largest stator frequency: what is called near zero
COPPER = 0.00393  # 1/K: how the resistance of copper rises from that at 20 °C
GENERATING = ("Where the load drives the machine its R_s drifts away from the right one, whatever its gains are, the faster "
              "the slower the machine turns (`imo derive resistance`).")
# In a few words, where the catalogue's meaning takes the paper for granted.
_WHAT = {
    "baseline": "the classical adaptive full-order observer of Kubota and Matsuse",
    "baseline_resistance": "the classical one with an adaptation of the stator resistance",
    "baseline_turned": "the classical one with an adaptation of the stator resistance that turns round where the machine "
                       "generates",
    "consistent_12": "the paper's observer, in the one reading of its equations that agrees with its proof, (12)",
    "repaired": "the paper's observer with the repair that makes its proof hold",
    "quiet": "the repaired one, changed so that current noise does not push its estimate of alpha",
}


@dataclass(frozen=True)
class Limit:
    """Relative errors of R_s, at most 0 and at least 0, between which the loop holds at a speed (rad/s); NaN: not even at 0."""

    omega: float
    low: float
    high: float

    @property
    def bears(self) -> bool:
        """Whether that is what is asked for."""
        return self.low <= -R_S_OFF and self.high >= R_S_OFF


@dataclass(frozen=True)
class Standing:
    """What is known of one observer.

    Attributes
    ----------
    observer, kind : str
    share : float
        Of the points of the map at which the loop closed on it holds; NaN without a map.
    error : float
        Of the speed in rad/s at the first of the limits' speeds with the map's R_s; NaN without a map.
    limits : tuple of Limit
    ends : tuple of (Scenario, Resting)
        The end of each run, of the one that it drives itself where an estimate drives.
    """

    observer: str
    kind: str
    share: float
    error: float
    limits: tuple[Limit, ...]
    ends: tuple[tuple[Scenario, Resting], ...]

    @property
    def off(self) -> list[tuple[Scenario, Resting]]:
        """The ends of the runs in which it does not track."""
        return [(run, end) for run, end in self.ends if outcome(end) != "tracks"]

    @property
    def works(self) -> bool:
        """See the head of this file."""
        return bool(self.limits) and self.limits[0].bears


def meaning(kind: str) -> str:
    """What the catalogue or the user's file says of an observer; of one in a file, too, whether right estimates stay right."""
    observer = OBSERVERS[kind]
    if not is_file(kind):
        return observer.meaning
    off = ", ".join(f"`{row}`" for row in astray(observer))
    stays = f"right estimates leave the machine in {off}" if off else "right estimates stay right"
    return f"{observer.meaning}; in `{shown(kind)}`, where {stays}"


def standings(study: Study, scenarios: Sequence[Scenario], plane: xr.Dataset | None) -> list[Standing]:
    """What is known of every observer of the runs, best first."""
    names = dict.fromkeys(end.observer for run in scenarios for end in judged(run))
    found = [_standing(study, name, scenarios, plane) for name in names]
    return sorted(found, key=lambda one: (-one.share if math.isfinite(one.share) else 1.0, len(one.off), _worst(one)))


def _standing(study: Study, name: str, scenarios: Sequence[Scenario], plane: xr.Dataset | None) -> Standing:
    ends = tuple((run, end) for run in scenarios for end in judged(run) if end.observer == name)
    kind = next((one.observers[name].kind for run in ("", *study.scenarios) for one in (study.scenario(run) if run else study,)
                 if name in one.observers), name)
    if plane is None or name not in plane["observer"].values:
        return Standing(name, kind, math.nan, math.nan, (), ends)
    one = plane.sel(observer=name)
    limits = limits_of(one)
    error = float(one["speed_error"].sel(omega=limits[0].omega, T_l=plane.attrs["limit_torque"], method="nearest"))
    return Standing(name, kind, float(one["holds"].mean()), error, limits, ends)


def _worst(one: Standing) -> float:
    return max((_distance(end) for _, end in one.ends), default=0.0)


def speed(omega: float, n_p: int) -> str:
    """An electrical speed with that of the shaft."""
    return f"{omega:.4g} rad/s ({rpm(omega, n_p):.4g} r/min)"


def per_cent(value: float) -> str:
    """A relative error of R_s in per cent; the widest that is tried stands for what is beyond it, too."""
    return f"{100 * abs(value):.2g} %" + (" or more" if abs(value) >= WIDEST else "")


def within(limit: Limit) -> str:
    """For which errors of R_s the loop holds, in words."""
    if math.isnan(limit.low):
        return "not even with the right R_s"
    return f"with R_s believed from {per_cent(limit.low)} too low to {per_cent(limit.high)} too high"


def where_it_fails(plane: xr.Dataset, name: object) -> str:
    """How often it is lost near zero stator frequency and away from it, braking and driving."""
    one = plane.sel(observer=name)
    lost = 1 - one["holds"].values
    frequency = plane["stator_frequency"].values
    near = np.abs(frequency) <= NEAR * np.abs(frequency).max()
    braking = plane["T_l"].values[:, None] * plane["omega"].values[None, :] < 0
    if not lost.any():
        return "It fails nowhere."
    return (f"It fails at {lost[near].sum()} of the {near.sum()} points within {100 * NEAR:g} % of the largest stator "
            f"frequency around zero ({lost[near & braking].sum()} of them braking), and at {lost[~near].sum()} of the other "
            f"{(~near).sum()}.")


def to_take(found: Sequence[Standing]) -> Standing:
    """The first of the observers, best first, that works; if none does, the best."""
    return next((one for one in found if one.works), found[0])


def advice(study: Study, found: Sequence[Standing], plane: xr.Dataset | None, refused: str) -> list[str]:
    """Which observer to take, or that none works, and what decides."""
    n_p, best = study.machine.n_p, found[0]
    if plane is None or not best.limits:
        said = f"Which observer can drive this machine was not computed: {refused}. In the runs `{best.observer}` does best."
        return [said, _decides(study, best, ())] if guessed_range(study.machine.source) else [said]
    able = [one for one in found if one.works]
    chosen = to_take(found)
    first, *others = chosen.limits
    where = f"at {speed(first.omega, n_p)} and {plane.attrs['limit_torque']:.4g} N m"
    bounds = within(first) + "".join(f"; at {speed(one.omega, n_p)} {within(one)}" for one in others)
    asked = f"{100 * R_S_OFF:g} % either way is asked for"
    if able:
        said = f"Take `{chosen.observer}`: driven by it alone, the machine holds {where} {bounds} ({asked})."
        rest = [f"`{one.observer}`" for one in found if one.limits and not one.works]
        said += f" {where_it_fails(plane, chosen.observer)}"
        said += f" It does not hold so with {', '.join(rest)}." if rest else ""
        said += f" {GENERATING}" if chosen.kind == "baseline_resistance" else ""
    else:
        said = ("None of these observers works on this machine without a speed sensor. The best of them is "
                f"`{chosen.observer}`: driven by it alone, the machine holds {where} {bounds} ({asked}).")
    return [said, _decides(study, chosen, able)]


def run_of(study: Study, run: Scenario) -> Study:
    """The study of one run of the dossier."""
    return study.scenario(run.name) if run.name in study.scenarios else study


def overloads(study: Study, scenarios: Sequence[Scenario]) -> list[str]:
    """The runs in which the load is more than the machine can give."""
    from imo_analysis.simulation.run import overload

    loads = {run.title: overload(run_of(study, run)) for run in scenarios}
    return [f"In “{title}” {said}: no observer can help that." for title, said in loads.items() if said]


def _decides(study: Study, chosen: Standing, able: Sequence[Standing]) -> str:
    """That the stator resistance decides, what the one of the study is worth, and whether the loop holds for that.

    Where it does not, but with another observer that works it does, that one is named.
    """
    R_s = f"R_s = {study.machine.R_s:.4g} Ω"
    span = guessed_range(study.machine.source)
    if span:
        low, high = study.machine.R_s / span[1] - 1, study.machine.R_s / span[0] - 1 if span[0] else math.inf
        tried = min(high, WIDEST)

        def borne(one: Standing) -> bool:
            return all(limit.low <= max(low, -WIDEST) and tried <= limit.high for limit in one.limits)

        other = next((one for one in able if borne(one)), chosen)
        if not chosen.limits:
            beside = ""
        elif borne(chosen):
            beside = (", for all of which the loop above holds" if high == tried else
                      f", and as far as that was tried, {100 * WIDEST:g} %, the loop above holds")
        elif other is chosen:
            beside = ", which is more than the loop above holds for"
        else:
            beside = (f", which is more than the loop above holds for; with `{other.observer}` it holds for all that was tried "
                      "at those two points")
        warned = f" {GENERATING}" if other is not chosen and other.kind == "baseline_resistance" else ""
        return (f"What decides is the stator resistance. {R_s} is only an estimate: the name plate gives it only to between "
                f"{span[0]:.3g} and {span[1]:.3g} Ω, for losses in the iron and in the bearings are counted with it. So it may "
                f"be from {per_cent(low)} too low to {per_cent(tried)} too high{beside}.{warned} Measure it, half of "
                "what an ohmmeter shows between two terminals, and make the study again, before relying on any line below.")
    return (f"What decides is the stator resistance, here {R_s}. It must be known as closely as that at any temperature: "
            f"copper that warms by {R_S_OFF / COPPER:.0f} K has {100 * R_S_OFF:g} % more.")


def verdicts(study: Study, found: Sequence[Standing], plane: xr.Dataset | None) -> list[str]:
    """A sentence on each observer, best first: the map, the limits of R_s, and the runs in which it is off, with the size."""
    n_p, lines = study.machine.n_p, []
    for one in found:
        line = f"`{one.observer}` ({_WHAT.get(one.kind) or meaning(one.kind)})"
        if plane is not None and one.limits:
            first = one.limits[0]
            point = f"at {first.omega:.4g} rad/s and {plane.attrs['limit_torque']:.4g} N m"
            then = f"off by {size(one.error, first.omega, n_p)}" if math.isfinite(one.error) else "lost"
            line += (f": driven by it alone, with R_s believed {100 * plane.attrs['R_s_error']:g} % too high, the machine "
                     f"holds at {100 * one.share:.0f} % of the points up to rated speed and torque; {point} the speed is then "
                     f"{then}. There it holds {within(first)}")
        line += f". It tracks in {_count(one)} of {len(one.ends)} runs"
        if easier := sum(one.observer in spared(run_of(study, run))[0] for run, _ in one.ends):
            line += f", in {easier} of which it has the right parameters and others have not"
        if one.off:
            run, end = max(one.off, key=lambda both: _distance(both[1]))
            line += f", worst in “{run.title}”, where it is {_end(end, n_p)}"
            if run.driven:
                line += ", driving itself"
            elif run.driver not in ("", one.observer):
                line += f" (`{run.driver}` drives)"
        lines.append(f"{line}.")
    return lines


def limits_of(one: xr.Dataset) -> tuple[Limit, ...]:
    """The limits of R_s of one observer of a map."""
    return tuple(Limit(float(omega), *(float(one[side].sel(limit_omega=omega)) for side in ("R_s_low", "R_s_high")))
                 for omega in one["limit_omega"].values)


def _distance(end: Resting) -> float:
    error = abs(end.error)
    return math.inf if math.isnan(error) else error


def _count(one: Standing) -> str:
    well = len(one.ends) - len(one.off)
    return "all" if not one.off else str(well) if well else "none"


def _end(end: Resting, n_p: int) -> str:
    if outcome(end) == "is lost":
        return "lost"
    mean = f"off by {size(end.error, end.omega, n_p)}"
    return mean if end.rms <= 2 * abs(end.error) else f"{mean} in the mean, {number(end.rms)} rad/s rms"


@dataclass(frozen=True)
class Cured:
    """A run in which an observer is off, again with a modulation of the flux: its ends, before and after."""

    title: str
    before: Resting
    after: Resting


def cures(study: Study, scenarios: Sequence[Scenario], observer: str, modulated: object) -> list[Cured]:
    """The runs in which the observer does not track, simulated again with a design of `imo_analysis.excitation.design`.

    It drives in those that each observer drove.
    """
    from imo_analysis.errors import Diverged
    from imo_analysis.excitation.design import Design
    from imo_analysis.excitation.design_check import modulated_study
    from imo_analysis.report.scenarios import resting_of
    from imo_analysis.simulation.run import simulate

    assert isinstance(modulated, Design)
    found = []
    for run in scenarios:
        before = [one for one in judged(run) if one.observer == observer and outcome(one) != "tracks"]
        if not before:
            continue
        chosen = modulated_study(run_of(study, run), modulated)
        if run.driven:
            chosen = chosen.changed({"drive.feedback": observer})
        try:
            data = simulate(chosen)
        except Diverged as error:
            if error.data is None or error.data.sizes["time"] < 2:
                continue
            data = error.data
        after = resting_of(data, chosen, drives=bool(run.driven))
        found.append(Cured(run.title, before[0], next(one for one in reversed(after) if one.observer == observer)))
    return found
