"""The part of the excitation chapter on what cures: a flux modulation, and an adaptation that rests when excitation is lost."""

from __future__ import annotations

from imo_analysis.excitation.choice import passed_over
from imo_analysis.excitation.design import LIMITS, Design
from imo_analysis.report.duty import EDGE, Duty
from imo_analysis.report.modulation import Modulation
from imo_analysis.report.page import Html, answer, figure, number, prose, table, tag
from imo_analysis.report.words import typeset


def cure_section(cured: Modulation | None) -> list[Html]:
    """Design, checks and duty; empty where no modulation was looked for."""
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
            f"rad/s, {found.slowest[1]:.3g} N m), by Floquet's multipliers at most {100 * chosen.slowest.left:.2g} % of it "
            f"is left after {wanted.time:g} s; the noise leaves it {found.bias:.3g} /s off. No unbiased "
            f"estimate can have a standard deviation below "
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
