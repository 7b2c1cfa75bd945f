"""The chapter on persistence of excitation: can this drive tell alpha and speed apart along these runs?"""

from __future__ import annotations

from collections.abc import Sequence

from imo_analysis.excitation.choice import passed_over
from imo_analysis.excitation.conditions import CONDITIONS
from imo_analysis.excitation.design import LIMITS, Design
from imo_analysis.excitation.published import PUBLISHED, compare
from imo_analysis.excitation.variations import Variation
from imo_analysis.paper.statements import ALPHA_FIGURE, ALPHA_FINAL
from imo_analysis.report.duty import EDGE, Duty
from imo_analysis.report.identifiability import Identifiability, RankRow
from imo_analysis.report.modulation import Modulation
from imo_analysis.report.page import Chapter, Html, answer, figure, formula, join, number, prose, table, tag
from imo_analysis.report.scenarios import ExcitationResult, Scenario, main_scenario
from imo_analysis.report.words import typeset


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
            *(_result(result) for result in results),
            *_drift(scenarios, papers),
            *_varied(varied),
            *_possible(possible),
            *_cure(cured),
        ]
    )
    return Chapter("excitation", "Excitation", "Excitation and identifiability", body)


def _drift(scenarios: Sequence[Scenario], papers: bool) -> list[Html]:
    explained = [scenario for scenario in scenarios if scenario.drift]
    if not explained:
        return []
    rows = [
        (typeset(scenario.title), tag("code", row.observer), f"{row.time:g} s: {row.before:g} to {row.after:g}",
         f"{row.from_study:.3f}", f"{row.from_motion:.3f}", f"{row.simulated:.3f}")
        for scenario in explained for row in scenario.drift
    ]
    head = ("run", "observer", "step (rad/s)", "predicted from the study", "predicted from the motion", "simulated")
    drawn = main_scenario(explained).drift_figure
    return [
        tag("h3", "Why the estimate of alpha stops where it does"),
        prose(
            r"""
On a family of states all measured errors vanish although alpha and speed are wrong. While the flux builds up, its magnitude
moves, and alpha is identifiable for so long. From then on the flux is constant, and $\hat{\alpha}$ can only slide along the
family, in step with the speed estimate: $d\hat{\alpha} = \frac{g}{K_p} \frac{\omega_{sl}}{\alpha}
d\hat{\omega}$. Slip is torque, so without load every change of speed, up or down, raises it by
"""
        ),
        formula(r"\Delta\hat{\alpha} = \frac{g}{K_p} \frac{L_m}{\mu \psi^{2}} \int \dot{\omega}^{2} \, dt ,"),
        prose(
            r"""
with $\psi$ the flux. That number follows from the study before anything is simulated (current limit, speed loop, inertia,
gains), and again from the motion of the machine without a look at the observer.
""" + (f" The paper reads {ALPHA_FINAL:g} off its Fig. {ALPHA_FIGURE}." if papers else "")
        ),
        table(head, rows, r"$\hat{\alpha}$ after each step, in 1/s", (3, 4, 5)),
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
that motion has full rank. The ranks below are computed in exact arithmetic on random rational motions of each kind (a full rank
is proved by it; a deficit holds but for an unlucky draw).
""" + _steady(possible.constant_speed)
        ),
        _ranks(possible.constant_speed, "Speed a constant parameter, as in the paper"),
        tag("details", tag("summary", "With the speed row of (1), and the load torque as an unknown"),
            _ranks(possible.mechanical, "Speed by the mechanical equation"), class_="more"),
        *(figure(drawn.svg, drawn.caption, drawn.caption, drawn.file) for drawn in possible.figures),
        _conditions(possible),
        tag("h4", "Beside what is published"),
        _published(),
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
    rows = [(typeset(one.source), typeset(one.says), one.read, typeset(one.ours) if one.ours else "", compare(one))
            for one in PUBLISHED]
    return table(("source", "says", "checked against", "here", "the condition"), rows,
                 "Published statements on the sensorless machine; the last column is computed: the condition as published "
                 "against the one found here")


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


def _cure(cured: Modulation | None) -> list[Html]:
    if cured is None:
        return []
    head = tag("h3", "Making it identifiable")
    if cured.chosen is None:
        return [head, answer(typeset(cured.refused))]
    found, wanted, chosen = cured.chosen.design, cured.wanted, cured.chosen
    rows = [
        (f"{one.omega:.4g}", f"{one.torque:.3g}", f"{_signed(one.alpha_error)} ± {one.alpha_deviation:.3f}",
         f"{_signed(one.omega_error)} ± {one.omega_deviation:.3f}", f"{one.ripple:.4f}",
         f"{one.noise_torque:.3f}", f"{one.loss:.2f}")
        for one in cured.checks
    ]
    missed = sorted({name for one in cured.checks for name in one.missed(wanted)})
    columns = ("speed (rad/s)", "load (N m)", r"$\hat{\alpha} - \alpha$ (1/s)", r"$\hat{\omega} - \omega$ (rad/s)",
               "torque ripple of the modulation (N m)", "torque noise without it (N m)", "added loss (W)")
    waveforms = [
        (typeset(one.waveform.replace("_", " ")), f"{100 * one.depth:.3g}", f"{one.frequency:.4g}", f"{one.loss:.3g}",
         f"{one.ripple:.2g}", f"{one.current:.3g}", f"{one.voltage:.3g}")
        for one in cured.waveforms
    ]
    kinds = ("reference", "depth of the flux (%)", "frequency (rad/s)", "added loss (W)", "torque ripple (N m)",
             "peak current (A)", "peak voltage (V)")
    return [
        head,
        prose(
            f"""
A flux magnitude that swings separates speed and alpha. Asked for: alpha, at first {wanted.start:.3g} /s off, within
{wanted.alpha:g} /s and speed within {wanted.omega:g} rad/s after {wanted.time:g} s, all over {min(wanted.speeds):.4g} to
{max(wanted.speeds):.4g} rad/s and {min(wanted.torques):.3g} to {max(wanted.torques):.3g} N m, with {wanted.noise:g} A of noise
on every current sample, within limits of flux, torque ripple (half its swing), current and voltage. The cheapest modulation
from {cured.frequencies[0]:.4g} to {cured.frequencies[1]:.4g} rad/s that does it for `{cured.observer}`:
"""
        ),
        answer(
            f"{100 * found.depth:.3g} % of the flux at {found.frequency:.4g} rad/s, a {found.waveform.replace('_', ' ')} "
            f"of the reference. It costs {found.loss:.3g} W of copper loss and uses "
            f"{', '.join(limit.share(found, wanted) for limit in LIMITS)}. The error of the estimate of alpha then decays as "
            f"exp(−{found.rate:.3g} t) on average over the modulation, t in s (slowest at {found.slowest[0]:.4g} "
            f"rad/s, {found.slowest[1]:.3g} N m), its slowest part at {chosen.rate:.3g} 1/s by Floquet's multiplier; "
            f"the noise leaves it {found.bias:.3g} /s off. No unbiased estimate can have a standard deviation below "
            f"{found.alpha_bound:.2g} /s and "
            f"{found.omega_bound:.2g} rad/s all over the range.",
            "In closed loop " + ("the accuracy is reached within the limits, by rms errors." if not missed else
                                 f"it misses: {', '.join(missed)}.")
            + (f" {passed_over(chosen.passed, cured.failed).capitalize()}." if chosen.passed or cured.failed else "")),
        table(columns, rows, f"Simulated in closed loop, the second after {wanted.time:g} s from an alpha that is off by "
              f"{wanted.start:.3g} /s, to the worse side; the ripple is half the swing of the torque in a run without noise, "
              "the torque noise a standard deviation", range(7)),
        table(kinds, waveforms, "The cheapest modulation by waveform, as the drive's loops let the flux follow", range(1, 7)),
        *_other_laws(cured),
        *(figure(one.svg, one.caption, one.caption, one.file) for one in (cured.figure,) if one),
        tag("p", tag("code", f"imo excite --design study.toml --limit torque={wanted.torque_limit:g}"), class_="note"),
        *_duty(cured.duty),
    ]


def _signed(value: float) -> str:
    """A small error with its sign; what is rounded to zero has none."""
    return f"{value:+.3f}" if round(value, 3) else f"{0.0:.3f}"


def _other_laws(cured: Modulation) -> list[Html]:
    if not cured.others or cured.chosen is None:
        return []
    own: tuple[str, Design | str] = (cured.observer, cured.chosen.design)
    rows = [(tag("code", name), f"{100 * one.depth:.3g}", f"{one.frequency:.4g}", one.waveform.replace("_", " "),
             f"{one.rate:.3g}", f"{one.bias:.3g}", f"{one.loss:.3g}", f"{one.ripple:.2g}")
            for name, one in (own, *cured.others) if isinstance(one, Design)]
    head = ("observer", "depth of the flux (%)", "frequency (rad/s)", "reference", "decay (1/s)", "left by the noise (1/s)",
            "added loss (W)", "torque ripple (N m)")
    return [
        table(head, rows, "What other laws with the same gains need for the same accuracy", (1, 2, 4, 5, 6, 7)),
        *(tag("p", typeset(f"`{name}`: {one}."), class_="note") for name, one in cured.others if isinstance(one, str)),
        prose("`supervised` is the law of `across` times its gate: with the gate open it needs what `across` needs. Its "
              "threshold is set for the duty below."),
    ]


def _duty(duty: Duty | str) -> list[Html]:
    if not duty:
        return []
    if isinstance(duty, str):
        return [tag("h3", "An adaptation that rests when excitation is lost"), answer(typeset(duty))]
    rows = [(tag("code", row.observer), f"{row.excited:.3f}", _signed(row.end_of_pause), f"{row.moved:.2g}",
             f"{row.back:.3f}") for row in duty.rows]
    head = ("observer", "largest error, modulated", "error at the end of the pause",
            f"moved in the pause after its first {EDGE:g} s", "largest error, modulated again")
    return [
        tag("h3", "An adaptation that rests when excitation is lost"),
        prose(
            r"""
Noise on the measured current pulls the alpha of (9) down by $2 g (1 + \beta L_m)$ times its variance, until something pulls it
back or its lower bound stops it. `supervised` adapts alpha along what the speed cannot explain, and only while a running Gram
matrix of the regressors holds more of it than noise does: $S^4 / (S^4 + S_0^4)$ scales the law. Its proof is the ledger's
`supervisor.decay`: with the gate open that of the observer without supervisor; with the gate closed V still falls wherever the
regressor across is zero, and alpha stands still. The threshold follows from the noise: without excitation
""" + rf"""the noise leaves S at {duty.floor:.2g} A² on average, and with $S_0$ at {duty.least:.3g} A² or above it moves the
estimate by {duty.rest:g} /s at most over the run, on average (`supervisor.threshold`); the modulation opens the gate by
{100 * duty.opens:g} % with $S_0$ at {duty.most:.3g} A² or below. Here $S_0$ = {duty.S_0:g} A², as many times above the one
as below the other.
"""
        ),
        prose("""
What it cannot help: noise also makes the offsets of the two copies of the flux walk, without end (`excitation.walk`). No
current shows them while the speed stands still; they come out when it changes.
"""),
        table(head, rows,
              rf"$\hat{{\alpha}} - \alpha$ in 1/s over {number(duty.duration, 4)} s of mixed duty, {duty.noise:g} A noise",
              range(1, 5)),
        figure(duty.figure.svg, duty.figure.caption, duty.figure.caption, duty.figure.file),
    ]


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


def _share(share: float) -> str:
    return "all" if share == 1 else f"{100 * share:.3g} %"


def _result(result: ExcitationResult) -> Html:
    window = f"windows of {result.summary['window']:g} s every {result.summary['every']:g} s"
    note = f"{result.summary['scaling']}; threshold {result.summary['threshold']:g} of the largest; {window}."
    shown = figure(result.figure.svg, result.figure.caption, result.figure.caption, result.figure.file)
    return tag("details", tag("summary", typeset(f"Eigenvalues over time: {result.title}")), shown,
               tag("p", typeset(note), class_="note"), class_="more", open="" if result.open else None)
