"""The chapter on gains: the study's own against those of one rule for all, judged, compared and run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from imo_analysis.notation import symbol
from imo_analysis.report.page import Chapter, Html, answer, figure, formula, inline, join, number, prose, table, tag
from imo_analysis.report.searched import Searched
from imo_analysis.report.tuned import SHOWN, Judged, Tuned
from imo_analysis.report.words import typeset
from imo_analysis.tuning.formulas import ALPHA_STEP, written
from imo_analysis.tuning.rule import DAMPING, REGION
from imo_analysis.tuning.schedule import pays, sentence
from imo_analysis.tuning.tune import Tuned as Result
from imo_analysis.tuning.verify import FAR, WORSE, faults

_SCALE = {"settling": 1e3, "recovery": 1.0, "overshoot": 100.0, "lag": 1e3, "noise": 1.0, "bias": 1.0}
_HEAD = {"settling": "settling (ms)", "recovery": "recovery (s)", "overshoot": "overshoot (%)",
         "lag": "lag behind an acceleration (ms)", "noise": "noise (rad/s)", "bias": "largest bias (rad/s)"}

_SHORT = _HEAD | {"lag": "lag (ms)", "bias": "bias (rad/s)"}  # over a column

_LOST = "unstable, or without a state at rest, in part of the range"


def tuned_chapter(result: Tuned, found: Searched | None = None) -> Chapter:
    """What the gains of the study give, and what the rule's."""
    body = join([
        prose("The paper leaves open which gains are good. An observer is only as good as its gains, so that a comparison is "
              "fair only where one rule has chosen all of them."),
        *(_refused(result) if result.wish is None else
          (*_wish(result), *_judged(result), *_searched(found), *_compared(result))),
    ])
    return Chapter("gains", "Gains", "Gains by one rule: the repaired observers, the paper's and the baseline", body)


def _refused(result: Tuned) -> list[Html]:
    return [answer(typeset(f"There is nothing to compare: {result.refused}."))]


def _wish(result: Tuned) -> list[Html]:
    wish = result.wish
    assert wish is not None
    errors = ", ".join(f"${symbol(name).latex}$ by {100 * value:g} %" for name, value in wish.uncertainty.items())
    limits = ", ".join(f"{_HEAD[name].split(' (')[0]} at most {_written(name, wish.limits[name])}"
                       for name in SHOWN if name in wish.limits)
    both = "in both directions" if len(wish.signs) > 1 else "forward"
    return [prose(
        f"The wish of the study: {limits}; from {wish.low:g} to {wish.high:g} rad/s {both}, with a slip of up to "
        f"{wish.slip:.3g} rad/s either way" + (f", and off parameters ({errors})" if errors else "")
        + f". Noise: {wish.current_noise:g} A on every sample of the currents. What is judged is the worst over all of it, "
        "on the exact linearisation with the adaptation of the speed at work.")]


def _written(name: str, value: float) -> str:
    unit = _HEAD[name].split("(")[1].rstrip(")")
    return f"{number(_SCALE[name] * value)} {unit}"


def _judged(result: Tuned) -> list[Html]:
    rows = [(join([tag("code", one.observer), "the rule's" if one.rule else "the study's"], ", "),
             *_values(one.values), number(one.measured), _verdict(one)) for one in result.judged]
    head = ("observer, gains", *(_SHORT[name] for name in SHOWN), "rms in the run (rad/s)", "meets the wish")
    gains = [(tag("code", one.observer), _gains(one.gains)) for one in result.judged if one.rule]
    return [
        table(head, rows, "The worst over the range (lag: behind an acceleration), and what the run below shows",
              range(1, 2 + len(SHOWN))),
        answer(*_sentences(result.judged)),
        *([figure(result.run.svg, result.run.caption, result.run.caption, result.run.file)] if result.run else []),
        table(("observer", "gains by the rule (SI units)"), gains),
        tag("h3", "The rule of thumb"),
        *_rule(),
    ]


def _rule() -> list[Html]:
    """Its formulas, by the functions that the program computes with, and where they hold."""
    parts = [prose(
        "$t_s$, $t_r$ and $t_l$ are the wished settling time of the speed estimate, recovery time of the flux and lag behind "
        f"accelerations, $\\zeta$ the damping ({DAMPING:g}; the baseline's own is below), $a_0$ the decay of the current error "
        "without feedback: $R_s/\\sigma$, or $\\gamma + \\alpha$ for quiet, across, supervised and the baselines. $g$ is for a "
        f"speed step $\\Delta\\omega$ of {ALPHA_STEP:g} of the range, $\\omega_{{\\mathrm{{drive}}}}$ the bandwidth of the "
        "drive's speed loop.")]
    for heading, lines in written():
        parts += [tag("p", inline(f"For {heading}:")), *(formula(line) for line in lines)]
    return [*parts, tag("ul", *(tag("li", inline(one)) for one in REGION))]


def _gains(gains: Mapping[str, float]) -> Html:
    return inline(", ".join(f"${symbol(name).latex} = {value:.4g}$" for name, value in gains.items() if math.isfinite(value)))


def _values(values: Mapping[str, float]) -> list[str]:
    """The quantities of a table's row, a dash where there is none."""
    return [number(_SCALE[name] * values[name]) if math.isfinite(values[name]) else "–" for name in SHOWN]


def _verdict(one: Judged) -> str:
    if not one.stable:
        return f"no: {_LOST}"
    ahead = "forward only, backward it is unstable; " if one.forward else ""
    return f"{ahead}{_met(one.missed, one.faults)}"


def _met(missed: Sequence[str], faults: Sequence[str]) -> str:
    """Yes only where the linearisation says so and simulations bear it out."""
    if missed:
        return f"misses {_names(missed)}"
    return f"not verified: {'; '.join(faults)}" if faults else "yes, verified"


def _names(missed: Sequence[str]) -> str:
    return ", ".join(missed)


def _sentences(judged: Sequence[Judged]) -> list[str]:
    """For each observer what the rule changes, and who is best."""
    lines = []
    for before, after in zip(judged[::2], judged[1::2], strict=True):
        lines.append(f"`{before.observer}`: {_change(before, after)}")
    able = [one for one in judged if one.stable and not one.forward]
    if able:
        quiet, quick = (min(able, key=lambda one, name=name: one.values[name]) for name in ("noise", "settling"))  # type: ignore[misc]
        lines.append(f"Of those that are stable all over the range the quietest is {_called(quiet)} with "
                     f"{_written('noise', quiet.values['noise'])}, the quickest {_called(quick)} with "
                     f"{_written('settling', quick.values['settling'])}.")
    return lines


def _called(one: Judged) -> str:
    return f"`{one.observer}` with {'the rule' if one.rule else 'the study'}'s gains"


def _change(before: Judged, after: Judged) -> str:
    where = " (forward only)" if after.forward else ""
    if not after.stable:
        return f"{_LOST} with the rule's gains" + ("." if before.stable else ", as with the study's.")
    now = f"{_written('settling', after.values['settling'])} and {_written('noise', after.values['noise'])}{where}"
    if not before.stable or before.forward != after.forward:
        return (f"{_LOST} with the study's gains; with the rule's it has a settling time and noise of "
                f"{now}.")
    better = [after.values[name] < before.values[name] for name in ("settling", "noise")]
    word = "both better" if all(better) else "quicker, but noisier" if better[0] else "quieter, but slower" if better[1] else (
        "neither better")
    return (f"settling time and noise of {_written('settling', before.values['settling'])} and "
            f"{_written('noise', before.values['noise'])}; with the rule's gains {now}: {word}.")


_ROLES = (("before", "the study's", "verified_before"), ("rule", "the rule's", "verified_rule"),
          ("chosen", "chosen", "verified"))


def _searched(found: Searched | None) -> list[Html]:
    """What a search finds that is left to itself, with what simulations say that had no part in it."""
    if found is None or not found.results:
        return [answer(typeset(f"No gains were searched for: {'; '.join(found.refused)}."))] if found and found.refused else []
    rows = [(tag("code", one.name), word, *_values(gains.values),
             _met(gains.missed, faults(getattr(one, seen), one.verified_before, one.chosen.limits)))
            for one in found.results for role, word, seen in _ROLES for gains in (getattr(one, role),)]
    checked = [(tag("code", one.name), word, f"{100 * seen.lost:.3g}", *(
        number(value) if math.isfinite(value) else "–" for value in (
            seen.rms_median, seen.rms_95, seen.corner, seen.rms, seen.noise, seen.noise_predicted, 1e3 * seen.settling,
            1e3 * seen.settling_predicted)))
               for one in found.results for _, word, place in _ROLES for seen in (getattr(one, place),)]
    columns = ("observer", "gains", "lost (%)", "rms error in random runs (rad/s): median", "95 %", "worst corner",
               "all runs", "noise (rad/s)", "predicted", "settling (ms)", "predicted")
    return [
        tag("h3", "Gains that a search finds"),
        prose("The search looks on the exact linearisation for the least noise that the wish leaves. What it finds is then "
              "tried in simulations that had no part in it: random machines, speeds and loads, the corners of the parameter "
              "errors with the largest loads at the ends of the range, and speeds between those of the search. Gains are "
              f"verified where no run loses the speed, the error over all runs is at most {WORSE:g} times that of the study's "
              f"gains, and settling time and noise are at most {FAR:g} times those of the linearisation."),
        table(("observer", "gains", *(_HEAD[name] for name in SHOWN), "meets the wish"), rows, "The worst over the range",
              range(2, 2 + len(SHOWN))),
        answer(*(typeset(line) for one in found.results for line in _chosen(one))),
        *([figure(found.figure.svg, found.figure.caption, found.figure.caption, found.figure.file)] if found.figure else []),
        table(columns, checked, "Simulations that were not used in the search", range(2, len(columns))),
        table(("observer", "gains that were chosen (SI units)"),
              [(tag("code", one.name), _gains(one.chosen.gains)) for one in found.results]),
        *_schedules(found.results),
        tag("p", tag("code", "imo tune study.toml"), class_="note"),
    ]


def _schedules(results: Sequence[Result]) -> list[Html]:
    """Whether gains that change with the speed would pay, and which they are."""
    parts = [tag("h3", "Is a schedule over the speed worth it?"),
             answer(*(typeset(f"`{one.name}`: {sentence(one.schedule, one.chosen.missed)}.") for one in results))]
    rows = [(tag("code", one.name), number(at.omega), number(at.constant), number(at.noise), _gains(at.gains))
            for one in results if pays(one.schedule, one.chosen.missed) for at in one.schedule]
    if rows:
        parts.append(table(("observer", "speed (rad/s)", "noise, constant gains (rad/s)", "noise, these (rad/s)",
                            "gains for that speed alone (SI units)"), rows, "Schedules that pay", (1, 2, 3)))
    return parts


def _chosen(one: Result) -> list[str]:
    """The reason of a choice, and whether simulations agree that it is better."""
    before, after = one.verified_before, one.verified
    better = (after.settling < before.settling, after.noise < before.noise)
    word = {(True, True): "quicker and quieter", (True, False): "quicker, not quieter", (False, True): "quieter, not quicker",
            (False, False): "neither quicker nor quieter"}[better]
    lines = [f"`{one.name}`: {one.reason}. " + (f"NOT verified: {'; '.join(one.faults)}." if one.faults else "Verified.")]
    if math.isfinite(before.settling):
        lines.append(f"In simulation it is {word} than with the study's gains: {_written('settling', after.settling)} in place "
                     f"of {_written('settling', before.settling)}, {_written('noise', after.noise)} in place of "
                     f"{_written('noise', before.noise)}.")
    if price := [name for name in one.price if name in SHOWN]:
        lines.append("Worse than with the study's gains: " + ", ".join(
            f"{_HEAD[name].split(' (')[0]}, {_written(name, one.chosen.values[name])} in place of "
            f"{_written(name, one.before.values[name])}" for name in price) + ".")
    if one.note:
        lines.append(f"`{one.name}` is tuned {one.note}.")
    return lines


def _compared(result: Tuned) -> list[Html]:
    data, drawn = result.compared, result.decay
    if data is None or drawn is None:
        return []
    rows = [(tag("code", str(name)), number(float(one["slowest_decay"])), number(float(one["least_damping"])),
             number(float(one["reached"])),
             _gains({str(gain): float(value) for gain, value in zip(one["gain"].values, one["gains"].values, strict=True)}))
            for name in data["observer"].values for one in (data.sel(observer=name).isel(fastest=0),)]
    head = ("kind", "slowest decay (1/s)", "least damping", "fastest pole (rad/s)", "gains")
    order = sorted((str(name) for name in data["observer"].values),
                   key=lambda name: -float(data["slowest_decay"].sel(observer=name).isel(fastest=0)))
    return [
        tag("h3", "The comparison that Table II set out to make"),
        prose("Frozen poles only, as in Table II, but with gains that are chosen alike: the slowest error of the whole range "
              "decays as fast as it can, and no pole is faster than a limit that sampling sets."),
        table(head, rows, f"No pole beyond {result.fastest:g} rad/s", (1, 2, 3)),
        answer(f"From the fastest decay to the slowest: {', '.join(f'`{name}`' for name in order)}."),
        figure(drawn.svg, drawn.caption, drawn.caption, drawn.file),
    ]
