"""The chapter on persistence of excitation: can this drive tell alpha and speed apart along these runs?"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from imo_analysis.equations import drift
from imo_analysis.excitation.conditions import CONDITIONS
from imo_analysis.excitation.observability import TRIES
from imo_analysis.excitation.published import CITED, PUBLISHED, compare
from imo_analysis.excitation.variations import Variation
from imo_analysis.ledger.expression import Name, Relation, names
from imo_analysis.ledger.latex import relation_latex
from imo_analysis.paper.statements import ALPHA_FIGURE, ALPHA_FINAL
from imo_analysis.report.chapters.cure import cure_section
from imo_analysis.report.identifiability import Identifiability, RankRow
from imo_analysis.report.modulation import Modulation
from imo_analysis.report.page import Chapter, Html, beside, figure, formula, join, number, prose, table, tag
from imo_analysis.report.scenarios import ExcitationResult, Scenario, main_scenario
from imo_analysis.report.words import typeset

_INSTANTS = 5  # that a cell lists


def excitation_chapter(
    results: Sequence[ExcitationResult], scenarios: Sequence[Scenario], possible: Identifiability, cured: Modulation | None,
    varied: Sequence[Variation] = (), varied_landings: Mapping[str, Sequence[Variation]] | None = None, papers: bool = False,
) -> Chapter:
    """Verdicts along the runs and lost directions; where alpha_hat ends; what is possible at all; the modulation that cures."""
    body = join(
        [
            prose(
                r"""
An error along a direction that the signals of the drive do not excite leaves no trace in the currents, and no adaptation can
correct it; the others may converge all the same. The paper asks for excitation in every direction with (19): the Gram matrix
$\int_t^{t+T} B^{*T} B^{*} \, d\tau$ of six error components must stay above a positive level in every window. Here it is
computed along the runs above, together with the reduced condition on the four components that the outputs can show:
$w = \alpha \tilde{\xi} - \mathrm{j} \omega \tilde{z}$ (two), $\tilde{\alpha}$ and $\tilde{\omega}$.

The columns are scaled to pure numbers of like size; a direction is lost in a window when its eigenvalue is below the
threshold. The scaling and the threshold stand with each result.
"""
            ),
            _overview(results),
            _levels(results),
            *(_result(result) for result in results if papers or result.open),
            *_elsewhere([] if papers else [one.figure.file for one in results if not one.open]),
            *_drift(scenarios, papers),
            *_varied_landings(varied_landings or {}),
            *_varied(varied),
            *_possible(possible),
            *cure_section(cured),
        ]
    )
    return Chapter("excitation", "Excitation", "Excitation and identifiability", body)


def _short_title(scenario: Scenario) -> Html:
    """The title up to its colon, a figure's number beside its "Fig."."""
    return typeset(scenario.title.split(":")[0].replace("Fig. ", "Fig.\u00a0"))


def _drift(scenarios: Sequence[Scenario], papers: bool) -> list[Html]:
    explained = [scenario for scenario in scenarios if scenario.drift]
    if not explained:
        return []
    rows = [
        (_short_title(scenario), tag("code", row.observer), f"{row.before:g} to {row.after:g}",
         *(f"{value:.3f}" for value in (
             row.start, row.step_from_study, row.step_from_motion, row.step, row.from_study, row.end)))
        for scenario in explained for row in scenario.drift
    ]
    head = ("run", "observer", "step (rad/s)", "before it", "adds: from the study", "from the motion", "simulated",
            "after it: from the study", "simulated")
    main = main_scenario(explained)
    drawn = main.drift_figure
    omega_hat, xi = drift.rest(Name("alpha_hat"), names("z_1_tilde z_2_tilde"), Name("omega"), Name("slip"), Name("alpha"))
    steps = [row for scenario in explained for row in scenario.drift]
    worst = max(steps, key=lambda row: abs(row.step_from_study - row.step))
    return [
        tag("h3", "Why the estimate of alpha stops where it does"),
        prose(
            r"""
On a family of states all measured errors vanish although alpha and speed are wrong (the ledger's `resting.family`; any
$\hat{\alpha}$, and $\tilde{z}$ free):
"""
        ),
        *(formula(relation_latex(Relation("=", Name(name), value)))
          for name, value in (("omega_hat", omega_hat), ("xi_1_tilde", xi[0]), ("xi_2_tilde", xi[1]))),
        prose(
            r"""
that is $\hat{\alpha} \tilde{\xi} = \mathrm{j} \hat{\omega} \tilde{z}$. All over it the reconstructed flux is exact
(`resting.flux`); after the steps below it is """ + f"{100 * max(row.flux_error for row in steps):.2g} %" + r""" off at most.
"""
        ),
        *_landings(explained),
        tag("h4", "Where the steps take it"),
        prose(
            r"""
From then on the flux is constant, and $\hat{\alpha}$ can only slide along the family, in step with the speed estimate:
$d\hat{\alpha} = \frac{g}{K_p} \frac{\omega_{sl}}{\alpha} d\hat{\omega}$ (`resting.drift`). Slip is torque, so without load
every change of speed, up or down, raises it by
"""
        ),
        formula(r"\Delta\hat{\alpha} = \frac{g}{K_p} \frac{L_m}{\mu \psi^{2}} \int \dot{\omega} \dot{\hat{\omega}} \, dt ,"),
        prose(
            rf"""
with $\psi$ the flux. That number follows from the study before anything is simulated: speed loop, current loop, inertia and
gains, and how late $\hat{{\omega}}$ follows a speed (the linearised observer, with $\hat{{\alpha}}$ held). From the motion of
the machine, without a look at the observer, it follows with $\dot{{\omega}}^2$ in place of that product.

A step's own prediction is at most {abs(worst.step_from_study - worst.step):.2g} /s off ({worst.step_from_study:.3f} for
{worst.step:.3f} /s).
""" + (f" The paper reads {ALPHA_FINAL:g} off its Fig. {ALPHA_FIGURE}." if papers else "")
        ),
        table(head, rows, r"$\hat{\alpha}$ before and after each step, and what the step adds, in 1/s", range(3, 9)),
        *([figure(drawn.svg, drawn.caption, drawn.caption, drawn.file)] if drawn else []),
    ]


def _landings(explained: Sequence[Scenario]) -> list[Html]:
    """Where the start leaves alpha_hat: why, and predicted beside simulated."""
    landings = [(scenario, row) for scenario in explained for row in scenario.landings]
    title, worst = max(((scenario.title.split(":")[0], row) for scenario, row in landings),
                       key=lambda one: abs(one[1].predicted - one[1].simulated))
    furthest = max(abs(row.simulated - scenario.alpha) for scenario, row in landings)
    first = next((row for row in main_scenario(explained).landings), landings[0][1])
    wrong = [(row.initial - scenario.alpha) * row.from_error for scenario, row in landings if row.initial != scenario.alpha]
    alone = [row.left_alone - scenario.alpha for scenario, row in landings]
    rows = [(_short_title(scenario), tag("code", row.observer), f"{row.initial:.4g}",
             *(f"{value:.3f}" for value in (row.from_error, row.from_motion, row.predicted, row.simulated)),
             f"{row.predicted_xi:.2f}", f"{row.simulated_xi:.2f}", "–" if math.isnan(one) else f"{row.left_alone:.3f}")
            for (scenario, row), one in zip(landings, alone, strict=True)]
    head = ("run", "observer", "first value", "left of its error", "the acceleration adds", "predicted", "simulated",
            r"$|\tilde{\xi}|$ predicted", "simulated", "were the copies left alone")
    return [
        tag("h4", "Where the start lands, and why there"),
        prose(
            r"""
While the flux builds up to $\psi$, with the bandwidth $w$ of its loop, $v_1$ has the part $-\beta \dot{\psi} / \alpha$ along
the flux, across $v_2$, and what it brings into the currents only an error of alpha explains. Were the copy $\hat{\xi}$ exact,
that error would be forgotten, by about
"""
        ),
        formula(r"\exp\left(-\frac{g}{k_1 + R_s/\sigma} \int \, \frac{\beta^{2} \dot{\psi}^{2}}{\alpha^{2}} \, dt\right) = "
                r"\exp\left(-\frac{g \beta^{2} \psi^{2} w}{2 \alpha^{2} (k_1 + R_s/\sigma)}\right) ,"),
        prose(
            rf"""
and, with the time that the current error takes to follow, to $\varepsilon$ = {100 * first.share_of_exact:.2g} %. But the
current error that corrects $\hat{{\alpha}}$ also moves $\hat{{\xi}}$, through $k_3$, and an error of $\hat{{\xi}}$ pushes the
currents as one of alpha does (`resting.build_up`). As $v_1$ fades, $\hat{{\alpha}}$ follows that error instead of the truth,
until it can follow no longer. At standstill the two leave of a small error the share
"""
        ),
        formula(r"{}_1F_2\left(\frac{1}{2}; \, \frac{1}{2} + r_1, \, \frac{1}{2} + r_2; \, "
                r"-\frac{g \beta^{2} \psi^{2}}{4 \alpha^{2}}\right) "
                r"\approx \varepsilon + \frac{\alpha^{2} k_3}{\beta \psi w} \sqrt{\frac{\pi}{2 w g (k_1 + R_s/\sigma)}} ,"),
        prose(
            rf"""
with $r_1 + r_2 = \frac{{k_1 + R_s/\sigma}}{{2 w}}$ and $r_1 r_2 = \frac{{\alpha k_3}}{{4 w^{{2}}}}$ (`resting.forgetting`,
term by term). The second form holds while $\hat{{\xi}}$, once off, changes little. Here the share is {100 * first.share:.3g}
%. Of what $\hat{{\xi}}$ remembers, a higher $g$ or a faster flux loop leaves less, and a higher $k_3$ more.

A start that also turns the machine adds two effects. Torque is slip, so that $\hat{{\alpha}}$ is carried along with
$\hat{{\omega}}$ as by the steps below, and what that adds is forgotten only as far as the flux still moves. And once the flux
turns, $\tilde{{z}}$ pushes the currents too, the more the more $\hat{{z}}$ is fed back. The flux turns past what both
copies remember, so that neither part need have the sign that it has at standstill or on exact copies.{_signs(wrong)} Were both
copies left alone ($k_3$ and the feedback of $\hat{{z}}$ zero), {_alone(alone)}

Where both copies end, the repaired observer's conserved $q = k_3 \tilde{{z}} - \mathrm{{j}} \kappa s \tilde{{\xi}}$ says: from
exact copies it is zero, it stays so while the direction $s$ does, and on the family it is zero only where both copies are
exact. The paper's observer feeds $\hat{{z}}$ back by an $\hat{{\omega}}$ that moves, conserves no such $q$, and rests with
errors in both.

The prediction counts all of this: it integrates the error dynamics, machine less observer, along the motion that flux loop
and speed loop make with currents at their references, without a voltage, a current loop or a sample. It misses what these do
in the first milliseconds, while the flux is too small to orient the drive. The start ends up to {furthest:.2g} /s off the
truth in these runs; the prediction is at most {abs(worst.predicted - worst.simulated):.2g} /s off ({worst.predicted:.3f} for
{worst.simulated:.3f} /s, `{worst.observer}`, {title}).
"""
        ),
        table(head, rows, r"$\hat{\alpha}$ after the start and what it is made of, in 1/s; $\tilde{\xi}$ in A, which with "
              "the formulas above says which of the rest states it is", range(2, 10)),
    ]


def _signs(products: Sequence[float]) -> str:
    """In how many starts what is left of the initial error has its sign, by the products of both."""
    if not products:
        return ""
    turned = sum(one < 0 for one in products)
    return f" What is left of the initial error has the other sign in {turned} of {len(products)} starts here."


def _alone(off: Sequence[float]) -> str:
    """Where the starts end whose copies are left alone, by how far off the truth."""
    found = [one for one in off if not math.isnan(one)]
    if not found:
        return "none of these starts would land."
    lost = len(off) - len(found)
    return (f"these starts would end {min(found):+.2g} to {max(found):+.2g} /s off the truth"
            + (f", and {lost} would not land" if lost else "") + ": the rest is what the copies remember.")


def _varied_landings(varied: Mapping[str, Sequence[Variation]]) -> list[Html]:
    if not varied:
        return []
    head = ("what", *(join((tag("code", name), f" {word}")) for name in varied for word in ("predicted", "simulated")))
    first = next(iter(varied.values()))
    rows = [(typeset(one.what), *(f"{value:+.3f}" for of in varied.values() for value in (of[k].predicted, of[k].simulated)))
            for k, one in enumerate(first)]
    every = [one for of in varied.values() for one in of]
    misses = [abs(one.predicted - one.simulated) for one in every]
    return [
        prose(f"How the landing moves with gains, drive and load, one change at a time from the first row. The prediction is "
              f"{max(misses):.2g} /s off at most and {sum(misses) / len(misses):.2g} /s on average, where the starts end up to "
              f"{max(abs(one.simulated) for one in every):.2g} /s off the truth:"),
        table(head, rows, r"$\hat{\alpha}$ less the true alpha after the start, in 1/s", range(1, 1 + 2 * len(varied))),
    ]


def _varied(varied: Sequence[Variation]) -> list[Html]:
    if not varied:
        return []
    rows = [(typeset(one.what), f"{one.predicted:.3f}", f"{one.simulated:.3f}") for one in varied]
    return [
        prose("How the end value moves with gains, steps, load and drive, one change at a time from the first row, for the "
              "repaired observer on this machine; predicted from the study before each run:"),
        table(("what", "predicted", "simulated"), rows, r"what one step adds to $\hat{\alpha}$, in 1/s", (1, 2)),
    ]


def _possible(possible: Identifiability) -> list[Html]:
    return [
        tag("h3", "What can be told apart at all"),
        prose(
            r"""
Whatever the observer: the measured currents of (1) tell the unknowns apart near a motion when a matrix of derivatives along
that motion has full rank. In steady states and without flux the ranks below are exact: those of a matrix of polynomials in
speed, slip and inertia. On the other motions they are taken in exact arithmetic on random rational ones: a full rank is proved
by one of them, a deficit is what """ + f"{TRIES} of them agree on." + r"""
""" + _steady(possible.constant_speed)
        ),
        _ranks(possible.constant_speed, "Speed a constant parameter, as in the paper"),
        tag("details", tag("summary", "With the speed row of (1), and the load torque as an unknown"),
            _ranks(possible.mechanical, "Speed by the mechanical equation"), class_="more"),
        *(figure(drawn.svg, drawn.caption, drawn.caption, drawn.file) for drawn in possible.figures),
        *_grams(possible),
        _conditions(possible),
        prose("In motion, with the load torque unknown, the determinant of the current's row and its first derivative for "
              "flux, speed and load torque is, but for a factor of constants of the machine, exactly"),
        formula(possible.instant),
        prose(r"""
that is $\psi^2 (\alpha^2 + \omega^2)$ times the sum of the stator frequency and the rate of $\arctan(\omega / \alpha)$. Where
it is not zero, the speed is told at that very instant. Where it is zero, only higher derivatives can tell it, if any: at
constant speed that is at zero stator frequency; while the speed changes, it is beside that line.
"""),
        tag("h4", "Beside what is published"),
        _published(),
        prose("Cited only, since no text could be had that states a condition: " + "; ".join(CITED) + "."),
    ]


def _grams(possible: Identifiability) -> list[Html]:
    """Closed forms of the Gram matrix beside simulated ones."""
    if not possible.grams:
        return []
    entries = ("$v_1 \\cdot v_1$", "$v_1 \\cdot v_2$", "$v_2 \\cdot v_2$")
    rows = [
        (f"{row.torque:.3g}", f"{100 * row.depth:.3g}", entry,
         *(number(values[k], 5) for values in (row.simulated, row.held, row.even)))
        for row in possible.grams for k, entry in enumerate(entries)
    ]
    head = ("load (N m)", "swing of the flux (%)", "mean", "simulated", "closed, torque held", "closed, slip constant")
    return [
        prose(r"""
Behind the maps stand closed forms, each a claim in the ledger: the mean Gram matrix of $v_1$ and $v_2$ (`excitation.gram_slip`,
`excitation.gram_torque`) with its determinant (`excitation.determinant`), zero where the flux is constant, and what a line of
the flux leaves in the current (`excitation.response`). Here the first beside the machine as its drive runs it, sampled:
"""),
        table(head, rows, f"Means over whole periods at {possible.grams[0].omega:.3g} rad/s, in A²; the drive holds the torque",
              (0, 1, 3, 4, 5)),
    ]


def _conditions(possible: Identifiability) -> Html:
    rows = [
        (typeset(", ".join(row.unknown) or "nothing but the flux"), typeset(model), f"{row.steady} of {row.needed}",
         "; ".join(_SURFACES.get(one, one) for one in row.drops) or "nowhere")
        for model, part in (("omega constant", possible.constant_speed), ("speed row of (1)", possible.mechanical))
        for row in part
    ]
    caption = "Steady states with flux: the exact rank, and where in the speed-torque plane it is lower still (symbolically)"
    return tag("details", tag("summary", "The exact conditions in steady state"),
               table(("unknown", "model", "rank", "lower where"), rows, caption), class_="more")


_SURFACES = {"slip": "no load (slip 0)", "omega + slip": "zero stator frequency"}


def _published() -> Html:
    rows = [(typeset(one.source), typeset(one.says), one.read, typeset(one.ours), compare(one)) for one in PUBLISHED]
    return table(("source", "says", "checked against", "here", "the condition"), rows,
                 "Published statements on the sensorless machine; the last column is computed: the condition as published "
                 "against the one found here; “implied” is a loss found here beside others. An abstract that says only that "
                 "unknowns are estimated together is put as: some motions tell them apart")


def _steady(rows: Sequence[RankRow]) -> str:
    """What the ranks say of speed and alpha together: on which motions they are told apart, if in no steady state."""
    both = next((row for row in rows if set(row.unknown) == {"alpha", "omega"}), None)
    if both is None:
        return ""
    apart = [name for name, rank in both.ranks.items() if rank == both.needed]
    steady = [name for name in both.ranks if name.startswith("steady")]
    if not steady or set(steady) & set(apart):
        return ""
    return ("Speed and alpha together are lost in every steady state; they are told apart on: "
            f"{'; '.join(apart) or 'no motion'}.")


def _ranks(rows: Sequence[RankRow], caption: str) -> Html:
    families = list(rows[0].ranks) if rows else []
    written = [
        (typeset(", ".join(row.unknown) or "nothing but the flux"), f"{row.needed}",
         *(tag("span", f"{row.ranks[name]}" if row.ranks[name] == row.needed else f"{row.ranks[name]} (lost)",
               class_=None if row.ranks[name] == row.needed else "lost") for name in families))
        for row in rows
    ]
    return table(("unknown", "needed", *map(typeset, families)), written, caption)


def _overview(results: Sequence[ExcitationResult]) -> Html:
    rows = []
    for result in results:
        for name, one in result.summary["conditions"].items():
            lost = join((typeset(f"{where['text']} ({_share(where['share'])})") for where in one["lost"][:3]), "; ")
            low, high = one["rank"]["lowest"], one["rank"]["highest"]
            rank = f"{low}" if low == high else f"{low} to {high}"
            rows.append((typeset(result.title), typeset(CONDITIONS[name].title), f"{rank} of {len(one['states'])}",
                         f"{one['holding']} of {one['windows']}", lost or "none"))
    head = ("run", "condition", "rank", "holds in windows", "directions that are lost (share of the windows)")
    return table(head, rows, "The verdicts along the runs")


def _levels(results: Sequence[ExcitationResult]) -> Html:
    rows = []
    for result in results:
        for name, one in result.summary["conditions"].items():
            holding = next((level for level in one["level"] if level["holds"]), None)
            longest = one["level"][-1]["window"]
            shortest = f"{holding['window']:.3g}" if holding else f"none up to {longest:.3g}"
            m = f"{holding['smallest_eigenvalue'] * holding['window']:.3g}" if holding else "—"
            changes = (_instants(one, True), _instants(one, False))
            rows.append((result.title, typeset(CONDITIONS[name].title), shortest, m, *changes))
    head = ("run", "condition", "shortest T (s)", "its level m (s)", "appears (s)", "disappears (s)")
    return table(head, rows, "The shortest window of a geometric series with which a condition holds for all t, its level, "
                 "and the ends of the windows with which excitation appears and disappears", (2, 3))


def _instants(one: dict[str, Any], appears: bool) -> str:
    times = [instant["time"] for instant in one["instants"] if instant["appears"] is appears]
    shown = ", ".join(f"{time:.4g}" for time in times[:_INSTANTS])
    return shown + (f" and {len(times) - _INSTANTS} more" if len(times) > _INSTANTS else "") or "—"


def _share(share: float) -> str:
    return "all" if share == 1 else f"{100 * share:.3g} %"


def _elsewhere(files: Sequence[str]) -> list[Html]:
    return [beside("Eigenvalues over time in the other runs:", files)] if files else []


def _result(result: ExcitationResult) -> Html:
    window = f"windows of {result.summary['window']:g} s every {result.summary['every']:g} s"
    note = f"{result.summary['scaling']}; threshold {result.summary['threshold']:g} of the largest; {window}."
    shown = figure(result.figure.svg, result.figure.caption, result.figure.caption, result.figure.file)
    return tag("details", tag("summary", typeset(f"Eigenvalues over time: {result.title}")), shown,
               tag("p", typeset(note), class_="note"), class_="more", open="" if result.open else None)
