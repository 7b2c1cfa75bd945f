"""The chapter on the poles: Table II beside what is computed, the map over the speed, and a slider."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from imo_analysis.drawing import line
from imo_analysis.ledger.claims.printed_poles import CLAIMS as PRINTED_POLES
from imo_analysis.pencils.table2_fit import PRINTED
from imo_analysis.report.atlas import Atlas, Unstable
from imo_analysis.report.chapters.ledger import anchor
from imo_analysis.report.page import Chapter, Html, answer, figure, formula, join, number, prose, table, tag
from imo_analysis.report.pencils import PoleResult, moving
from imo_analysis.report.words import typeset, unit


def pencils_chapter(poles: PoleResult, proofs: dict[str, Any], papers: bool, maps: Atlas | None = None) -> Chapter:
    """Poles of the frozen-speed error dynamics.

    Parameters
    ----------
    poles : PoleResult
    proofs : dict
        From `imo_analysis.report.checks.checks`.
    papers : bool
        Whether the machine is that of Table II.
    maps : Atlas, optional
    """
    body = join(
        [
            prose(
                r"""
At a fixed $\hat{\omega}$ (and $\hat{\alpha}$) the errors of an observer obey a linear differential equation. Its matrix is
found here by differentiating the definitions of plant and observer, not typed in; Table II claims to list its eigenvalues.
""" + _neutral(poles)
            ),
            *(figure(drawn.svg, drawn.caption, drawn.caption, drawn.file) for drawn in poles.figures),
            _unstable(poles),
            _slider(poles),
            *(_maps(maps) if maps else ()),
            *((tag("h3", "Table II, printed and computed"), *_table2(poles),
               tag("h3", "Where the printed numbers come from"), *_explanation(proofs)) if papers else
              (tag("p", "Table II is about the paper's machine; the dossier of the paper's study goes into it. The poles of "
                        "this machine at the speeds of the study are in ", tag("code", "table2.csv"), ".", class_="note"),)),
        ]
    )
    return Chapter("poles", "Poles", "Poles of the error dynamics", body)


def _maps(maps: Atlas) -> list[Html]:
    """The maps of stability, with what the one over speed and slip says of each observer."""
    return [
        tag("h3", "Where an observer is stable"),
        prose("With the laws that adapt the speed at work, the linearisation at a steady state tells more than frozen poles: "
              "it is exact there, in the frame of the flux, where the steady state is a point at rest."),
        answer(*(_said(one) for one in maps.unstable)),
        *(figure(drawn.svg, drawn.caption, drawn.caption, drawn.file) for drawn in maps.figures),
    ]


def _said(one: Unstable) -> str:
    if not (one.forward or one.backward):
        return f"`{one.observer}` is stable all over the map of speed and slip."
    return (f"`{one.observer}` is unstable on {100 * one.forward:.3g} % of the map with positive speed, on "
            f"{100 * one.backward:.3g} % of that with negative speed, and on {100 * one.braking:.3g} % of that which brakes.")


def _unstable(poles: PoleResult) -> Html:
    rows = []
    for name, runs in poles.unstable.items():
        where = "; ".join(f"{first:g} to {last:g}" if first < last else f"{first:g}" for first, last in runs)
        rows.append((tag("code", name), f"unstable at {where} rad/s" if runs else "none at any speed of the sweep"))
    return table(("observer", "poles in the right half plane"), rows)


def _table2(poles: PoleResult) -> list[Html]:
    parts = [
        prose("Conjugates are left out: each line stands for a pole and its mirror image, or for a real pole. The difference "
              "is the distance in the complex plane to the printed value that is assigned to it.")
    ]
    for name in poles.table["observer"].values:
        one = poles.table.sel(observer=name)
        rows = []
        for omega in one["omega"].values:
            for pole in one["pole"].values:
                at = one.sel(omega=omega, pole=pole)
                if float(at["computed_im"]) >= 0:
                    rows.append((f"{float(omega):g}", _complex(at, "printed"), _complex(at, "computed"),
                                 number(float(at["difference"]))))
        column = one["column"].item()
        printed = f"printed, {column} column (1/s)" if column else "printed (1/s)"
        head = (r"$\hat{\omega}$ (rad/s)", printed, "computed (1/s)", "difference (1/s)")
        parts.append(table(head, rows, f"`{name}`", (0, 1, 2, 3)))
    return parts


def _complex(at: Any, name: str) -> str:
    re, im = float(at[f"{name}_re"]), float(at[f"{name}_im"])
    if math.isnan(re):
        return "–"
    return f"{re:.2f} {'+' if im >= 0 else '-'} {abs(im):.2f} j".replace("-", "−")


def _explanation(proofs: dict[str, Any]) -> list[Html]:
    constants = {one["name"]: one for one in proofs["constants"]}
    forms = proofs["refutations"]
    failed = [one for one in forms if not one["proved"]]
    rows = [
        (typeset(one["form"]), one["column"], typeset(_tidy(one["forced"])), _by_speed(one["printed"]),
         "any" if one["alphas"] == ["any"] else typeset(", ".join(one["alphas"])),
         "contradiction" if one["proved"] else "not shown")
        for one in forms
    ]
    head = ("printed form", "column", "what it forces, whatever the gains", "what the printed digits say", r"$\alpha$", "")
    return [
        prose(
            r"""
Every printed pair of eigenvalues sums to one constant plus $\mathrm{j}\hat{\omega}$. One complex quadratic gives all """
            + f"{_printed_numbers()} numbers to the last printed digit, and the two columns differ in one factor only:"
        ),
        formula(r"s^{2} + (a - \mathrm{j}\hat{\omega})\, s + b - \mathrm{j} c\, \hat{\omega} + d\, \hat{\omega}^{2} = 0 \quad "
                r"\text{(proposed)}, \qquad s^{2} + (a - \mathrm{j}\hat{\omega})\, s + b - \mathrm{j} c\, \hat{\omega} + "
                r"d\, |\hat{\omega}| = 0 \quad \text{(baseline)}"),
        table(("constant", "unit", "at least", "at most"),
              [(f"${name}$", unit(one["unit"]), f"{one['low']:.7g}", f"{one['high']:.7g}") for name, one in constants.items()],
              "No other values give the printed digits", (2, 3)),
        answer(
            f"No matrix that the paper prints gives Table II with Table III's machine, for any real gains: {len(forms)} forms "
            f"were tried, {len(forms) - len(failed)} end in a contradiction of exact intervals."
            + (f" {len(failed)} are not settled." if failed else "")
        ),
        tag("details", tag("summary", "Each printed form with its contradiction"), table(head, rows), class_="more"),
        tag("p", "In the ledger, each with what would refute it: ", join(
            (tag("a", typeset(one.title), href=f"#{anchor(one.id)}") for one in PRINTED_POLES), "; "), ".", class_="note"),
        *_questions(proofs["answers"]),
    ]


def _questions(answers: list[dict[str, Any]]) -> list[Html]:
    """What the table says and what it leaves open, question by question."""
    settled = {(True, True): "settled by the digits", (True, False): "left open"}
    rows = [(one["question"], typeset(one["answer"]), settled.get((one["shown"], one["determined"]), "not shown"))
            for one in answers]
    head = ("question", "answer, worked out from the printed digits", "")
    return [table(head, rows, "What Table II says and what it does not")] if rows else []


def _tidy(text: str) -> str:
    return text.replace("*", " ")


def _by_speed(printed: list[list[float]]) -> Html:
    return join((f"{omega:g} rad/s: {number(low, 5)} to {number(high, 5)}" for omega, low, high in printed), "; ")


def _printed_numbers() -> int:
    """How many numbers Table II has: two for each eigenvalue."""
    return sum(2 * len(pair) for column in PRINTED.values() for pair in column.values())


def _neutral(poles: PoleResult) -> str:
    """Which observers have poles at zero at every speed, with the direction in which nothing moves."""
    still = {str(name): int(poles.sweep["neutral"].sel(observer=name).sum()) for name in poles.sweep["observer"].values}
    with_some = [f"`{name}`" for name, count in still.items() if count]
    if not with_some:
        return ""
    counts = {count for count in still.values() if count}
    number_of = f"{counts.pop()} more" if len(counts) == 1 else "more"
    have = "has" if len(with_some) == 1 else "have"
    return (f"Of these observers {', '.join(with_some)} {have} {number_of}, at zero at every speed: in the direction "
            r"$\alpha \tilde{\xi} = \mathrm{j} \omega \tilde{z}$ nothing moves. The table leaves them out.")


def _slider(poles: PoleResult) -> Html:
    """The poles at one speed, chosen by hand; needs a script and is hidden without one."""
    sweep = poles.sweep
    omega = sweep["omega"].values
    step = max(1, len(omega) // 150)
    picked = np.arange(0, len(omega), step)
    series = []
    for name in sweep["observer"].values:
        one = sweep.sel(observer=name)
        one = one.isel(omega=picked, branch=np.flatnonzero(moving(one)))
        roots = np.stack([one["re"].values, one["im"].values], axis=-1)
        present = np.isfinite(roots).all(axis=(0, 2))
        style = line(str(name))
        series.append({"label": str(name), "color": style.color, "mark": style.marker,
                       "poles": np.round(roots[:, present], 2).tolist()})
    data = {"omega": [round(float(value), 3) for value in omega[picked]], "series": series}
    written = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    start = int(np.argmin(np.abs(omega[picked] - np.median(poles.table["omega"].values))))
    control = Html(f'<input type="range" id="speed" step="1" min="0" max="{len(picked) - 1}" value="{start}">')
    keys = (tag("label", Html('<input type="checkbox" checked><svg class="key" viewBox="0 0 18 18" aria-hidden="true"></svg>'),
                one["label"]) for one in series)
    return tag(
        "div",
        tag("p", tag("label", "Speed, also by the arrow keys: ", for_="speed"), tag("output", "", for_="speed")), control,
        tag("p", *keys, class_="keys"),
        Html('<svg class="map" role="img" aria-label="poles of each observer at the chosen speed"></svg>'),
        tag("p", "", class_="say note", aria_live="polite"),
        Html(f'<script type="application/json">{written}</script>'),
        class_="slider js-only",
    )
