"""Gains for the observers of a study that meet its wish: search, choice, verification, for every observer by the same rule.

For each observer: the gains that the study has, those of the rule of thumb, and the front between noise and times about the
wish (`imo_analysis.tuning.search`). Of all that meet the wish on the linearisation (and, where the study's own gains do not,
are nowhere worse than those, if there are such) the one is chosen whose estimate is best in closed loop with noise and with
parameters that are off, at random and at the corners of the uncertainty (`imo_analysis.tuning.trial`); where none meets it, the
one that comes nearest. The choice is then verified beside the other two on machines, speeds, loads and noise that had no part
in it (`imo_analysis.tuning.verify`), and compared with gains for one speed alone (`imo_analysis.tuning.schedule`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from imo_analysis.equations.own import is_file, shown
from imo_analysis.errors import InputError
from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.study import Study
from imo_analysis.tuning import trial
from imo_analysis.tuning.loops import ADAPTIVE, TUNABLE
from imo_analysis.tuning.response import response
from imo_analysis.tuning.schedule import Alone, alone
from imo_analysis.tuning.search import Found, Search, front
from imo_analysis.tuning.verify import Verified, faults, verify
from imo_analysis.tuning.wish import QUANTITIES, Wish, excess, judge, missed

if TYPE_CHECKING:
    import xarray as xr

_COMPARED = ("settling", "recovery", "overshoot", "noise")
STEPS = 2 * 36 + 7 * 18 + 3 * 36  # generations of one observer's search, rounds that are made again aside


@dataclass(frozen=True)
class Tuned:
    """One observer's result.

    Attributes
    ----------
    name, kind : str
        In the study, and in the catalogue.
    signs : tuple of float
        Directions of rotation that it was tuned for.
    note : str
        Why not both, or empty.
    before, rule, chosen : Found
        Gains of the study, of the rule of thumb, and the choice.
    front : list of Found
        The search's.
    reason : str
        Of the choice.
    verified_before, verified_rule, verified : Verified
        The study's gains, the rule's and the choice on the same simulations.
    schedule : list of Alone
        The best gains for one speed alone.
    """

    name: str
    kind: str
    signs: tuple[float, ...]
    note: str
    before: Found
    rule: Found
    chosen: Found
    front: list[Found]
    reason: str
    verified_before: Verified
    verified_rule: Verified
    verified: Verified
    schedule: list[Alone]

    @property
    def faults(self) -> list[str]:
        """Why the choice is not verified; empty where it is."""
        return faults(self.verified, self.verified_before, self.chosen.limits)

    @property
    def price(self) -> list[str]:
        """Names of `QUANTITIES` that the choice makes worse than the study's gains have them."""
        return [name for name in QUANTITIES if self.chosen.values[name] > 1.001 * self.before.values[name]]


def tunable(study: Study, names: Sequence[str] = ()) -> list[str]:
    """The observers to tune: those named, or those of ``[tuning]``, or all of the study that can be.

    Raises
    ------
    InputError
        If one is not in the study, no gains make it stable, or none is left.
    """
    wanted = list(dict.fromkeys(names or study.tuning.observers))
    for name in wanted:
        if name not in study.observers:
            raise InputError(f"observer = {name!r} is not in the study; choose from: {', '.join(study.observers)}")
        kind = study.observers[name].kind
        if kind.startswith("printed"):
            raise InputError(f"observer {name!r} cannot be tuned: the z feedback of {kind} is unstable at speed; consistent_12 "
                             "and repaired are its corrections")
        if is_file(kind):
            raise InputError(f"observer {name!r} ({shown(kind)}) cannot be tuned: the search does not know how gains of "
                             "your own act; vary them with imo sweep, in [sweep.fields]")
        if kind == "baseline_resistance":
            raise InputError(f"observer {name!r} of kind {kind} cannot be tuned: where the machine generates it has a pole to "
                             "the right whatever its gains (imo derive resistance); tune a baseline and take its gains, with "
                             "h_s as imo study --init has it for baseline_turned")
        if kind == "baseline_turned":
            raise InputError(f"observer {name!r} of kind {kind} cannot be tuned: the search leaves R_s alone; tune a "
                             "baseline and take its gains, with h_s and P_0 as imo study --init writes them")
        if kind not in TUNABLE:
            raise InputError(f"observer {name!r} of kind {kind} cannot be tuned; kinds that can: {', '.join(TUNABLE)}")
    found = wanted or [name for name, settings in study.observers.items() if settings.kind in TUNABLE]
    if not found:
        raise InputError(f"the study has no observer that can be tuned; kinds that can: {', '.join(TUNABLE)}")
    return found


def tune(study: Study, name: str, tick: Callable[[], None] = lambda: None) -> Tuned:
    """Tune one observer of a study.

    Parameters
    ----------
    study : Study
        With its table ``[tuning]``.
    name : str
        Out of `tunable`.
    tick : callable
        Called once a generation of the search, about `STEPS` times.
    """
    wish, settings, seed = Wish.of(study), study.observers[name], study.tuning.seed
    kind = settings.kind
    kept = {gain: value for gain, value in settings.gains.items() if gain in ("alpha_l", "delta", "eta", "S_0")}
    signs, note = wish.signs, ""
    if len(signs) > 1 and kind == "consistent_12":
        signs = (1.0,)
        note = ("forward only: the speed law (11) changes its sign with the direction, and at negative speed no K_p above 0 is "
                "stable")
    search = Search(wish, kind, signs, seed, kept, tick)
    before = Found(dict(settings.gains), judge(wish, kind, settings.gains, signs), wish.limits, "before")
    rule = search.rule()
    wished = search.best(wish.limits, "wish")
    found = [wished, *front(search, wished)]
    if kind in ADAPTIVE:  # another family, which the search would leave for the sake of a little noise
        other = Search(wish, kind, signs, seed, kept, tick, rising=True)
        found += [other.best({**wish.limits, "recovery": share * wish.limits["recovery"]}, "recovery") for share in (1.0, 0.5)]
    chosen, reason = choose(study, name, wish, signs, seed, before, [*found, rule, before])
    able = [one for one in (*found, rule, before) if not missed(wish.limits, one.values)]
    steady = min(able, key=lambda one: one.values["noise"], default=chosen)
    schedule = alone(wish, kind, signs, seed, kept, steady, tick)
    was, by_rule, now = verify(study, name, wish, signs, [before.gains, rule.gains, chosen.gains])
    return Tuned(name, kind, signs, note, before, rule, chosen, found, reason, was, by_rule, now, schedule)


def choose(
    study: Study, name: str, wish: Wish, signs: tuple[float, ...], seed: int, before: Found, found: list[Found]
) -> tuple[Found, str]:
    """The set of gains to take, out of those found, and why."""
    found = [Found(one.gains, one.values, wish.limits, one.role) for one in found]
    able = [one for one in found if not one.missed]
    if not able:
        nearest = min(found, key=lambda one: float(excess(wish.limits, one.values)))
        return nearest, "no gains were found that meet the whole wish; these come nearest"
    better = [one for one in able if all(one.values[key] <= before.values[key] for key in _COMPARED)]
    which = f"of {len(able)} sets of gains that meet the wish"
    if before.missed and better and len(better) < len(able):
        able = better
        which += f", {len(able)} of them nowhere worse than the study's own in {', '.join(_COMPARED)}," if len(able) > 1 else (
            f" the only one nowhere worse than the study's own in {', '.join(_COMPARED)};")
    settled = [one for one in able if _settles(study, name, wish, signs, one)]
    if settled and len(settled) < len(able):
        able = settled
        which += f", {len(able)} of them as quick in simulation,"
    driven = trial.drive(study, name, [one.gains for one in able], wish, signs, seed, study.tuning.runs)
    best = int(np.argmin(driven.rms))
    if not np.isfinite(driven.rms[best]):
        quiet = min(able, key=lambda one: one.values["noise"])
        return quiet, f"{which} the quietest; in simulation each loses the speed of some machine"
    if len(able) == 1:
        return able[0], f"{which} {driven.rms[0]:.3g} rad/s rms of error in simulation, with noise and the uncertainty"
    rest = np.delete(driven.rms, best)
    return able[best], (f"{which} the one with the smallest error in simulation, {driven.rms[best]:.3g} rad/s rms with "
                        f"noise and the uncertainty (others {rest.min():.3g} to {rest.max():.3g})")


def _settles(study: Study, name: str, wish: Wish, signs: tuple[float, ...], one: Found) -> bool:
    """Whether it settles in simulation within the wish, at the ends and the middle of the range."""
    omega = np.array([sign * speed for sign in signs for speed in (wish.low, wish.middle, wish.high)])
    return bool(trial.settling(study, name, one.gains, wish, omega).max() <= wish.limits["settling"])


def with_gains(study: Study, results: Sequence[Tuned]) -> Study:
    """The study with the chosen gains, to six digits.

    Parameters
    ----------
    study : Study
        What was tuned.
    results : sequence of Tuned
        From `tune`, one an observer.
    """
    data = {**study.data, "observers": {**study.data["observers"]}}
    for one in results:
        order = [*study.observers[one.name].gains, *one.chosen.gains]
        gains = {gain: float(f"{one.chosen.gains[gain]:.6g}") for gain in dict.fromkeys(order) if gain in one.chosen.gains}
        data["observers"][one.name] = {**data["observers"][one.name], "gains": gains}
    return Study.from_data(data, "the study with these gains")


def over_speed(study: Study, results: Sequence[Tuned], speeds: int = 41) -> xr.Dataset:
    """Settling time and noise over the range of speeds, both directions, idle and at right parameters, before and after.

    Parameters
    ----------
    study : Study
        What was tuned.
    results : sequence of Tuned
        From `tune`, one an observer.
    speeds : int
        How many in each direction.

    Returns
    -------
    xarray.Dataset
        Dimensions ``observer``, ``gains`` (``before``, ``chosen``), ``omega`` (rad/s); ``settling`` (s), ``recovery`` (s),
        ``noise`` (rad/s); NaN where the estimate is unstable.
    """
    import xarray as xr

    wish = Wish.of(study)
    omega = np.geomspace(wish.low, wish.high, speeds)
    omega = np.concatenate([-omega[::-1], omega])
    shape = (len(results), 2, len(omega))
    data = {name: np.full(shape, np.nan) for name in ("settling", "recovery", "noise")}
    for n, one in enumerate(results):
        for k, gains in enumerate((one.before.gains, one.chosen.gains)):
            found = response(wish.machine, one.kind, gains, OperatingPoint(omega, wish.flux, 0.0 * omega))
            for name, values in data.items():
                values[n, k] = np.where(np.isfinite(getattr(found, name)), getattr(found, name), np.nan)
    data["noise"] *= wish.noise_scale
    attributes = {"settling": ("s", "time until the speed estimate is within 2 % of a step"),
                  "recovery": ("s", "four time constants of the slowest error"),
                  "noise": ("rad/s", "standard deviation of the speed estimate")}
    axes = ("observer", "gains", "omega")
    return xr.Dataset(
        {name: (axes, values, dict(zip(("units", "long_name"), attributes[name], strict=True)))
         for name, values in data.items()},
        {"observer": [one.name for one in results], "gains": ["before", "chosen"],
         "omega": ("omega", omega, {"units": "rad/s", "long_name": "rotor speed, electrical"})},
        {"study_sha256": study.sha256, "current_noise": wish.current_noise, "sample_time": wish.sample_time})
