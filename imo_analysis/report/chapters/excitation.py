"""The chapter on persistence of excitation: can this drive tell alpha and speed apart along these runs?"""

from __future__ import annotations

from collections.abc import Sequence
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
    varied: Sequence[Variation] = (), papers: bool = False,
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
            *_varied(varied),
            *_possible(possible),
            *cure_section(cured),
        ]
    )
    return Chapter("excitation", "Excitation", "Excitation and identifiability", body)


def _drift(scenarios: Sequence[Scenario], papers: bool) -> list[Html]:
    explained = [scenario for scenario in scenarios if scenario.drift]
    if not explained:
        return []
    rows = [
        (typeset(scenario.title.split(":")[0]), tag("code", row.observer), f"{row.before:g} to {row.after:g}",
         *(f"{value:.3f}" for value in (
             row.start, row.step_from_study, row.step_from_motion, row.step, row.from_study, row.end)))
        for scenario in explained for row in scenario.drift
    ]
    head = ("run", "observer", "step (rad/s)", "before it", "adds: from the study", "from the motion", "simulated",
            "after it: from the study", "simulated")
    main = main_scenario(explained)
    drawn = main.drift_figure
    omega_hat, xi = drift.rest(Name("alpha_hat"), names("z_1_tilde z_2_tilde"), Name("omega"), Name("slip"), Name("alpha"))
    alpha = main.alpha
    landings = [(scenario.title, row) for scenario in explained for row in scenario.drift
                if row.time == min(one.time for one in scenario.drift)]
    furthest = max(landings, key=lambda one: abs(one[1].start - alpha))
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
While the flux builds up, its magnitude moves, and alpha is identifiable for so long. From then on the flux is
constant, and $\hat{\alpha}$ can only slide along the family, in step with the speed estimate: $d\hat{\alpha} = \frac{g}{K_p}
\frac{\omega_{sl}}{\alpha} d\hat{\omega}$ (`resting.drift`). Slip is torque, so without load every change of speed, up or
down, raises it by
"""
        ),
        formula(r"\Delta\hat{\alpha} = \frac{g}{K_p} \frac{L_m}{\mu \psi^{2}} \int \dot{\omega} \dot{\hat{\omega}} \, dt ,"),
        prose(
            rf"""
with $\psi$ the flux. That number follows from the study before anything is simulated: speed loop, current loop, inertia and
gains, and how late $\hat{{\omega}}$ follows a speed (the linearised observer, with $\hat{{\alpha}}$ held). From the motion of
the machine, without a look at the observer, it follows with $\dot{{\omega}}^2$ in place of that product.

Not predicted is where the start leaves $\hat{{\alpha}}$: with voltages and currents at their limits and the flux near zero no
closed form holds. From the study it is taken for the true {alpha:.5g} /s; in these runs it is
{min(row.start for _, row in landings):.4g} to {max(row.start for _, row in landings):.4g} /s, at most
{abs(furthest[1].start - alpha):.2g} /s off (`{furthest[1].observer}`, {furthest[0]}). A step's own prediction is at most
{abs(worst.step_from_study - worst.step):.2g} /s off ({worst.step_from_study:.3f} for {worst.step:.3f} /s).
""" + (f" The paper reads {ALPHA_FINAL:g} off its Fig. {ALPHA_FIGURE}." if papers else "")
        ),
        table(head, rows, r"$\hat{\alpha}$ before and after each step, and what the step adds, in 1/s", range(3, 9)),
        *([figure(drawn.svg, drawn.caption, drawn.caption, drawn.file)] if drawn else []),
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
              "flux, speed and load torque is exactly"),
        formula(possible.instant),
        prose(r"""
that is $\psi^2 (\alpha^2 + \omega^2)$ times the sum of the stator frequency and the rate of $\arctan(\omega / \alpha)$. Where
it is not zero, the speed is told at that very instant. At constant speed only zero stator frequency is left; while the speed
changes, what hides it lies beside that line.
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
                 "against the one found here; “implied” is a loss found here beside others")


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
