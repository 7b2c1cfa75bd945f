"""The chapter on the machine: its parameters, what follows from them, and for the paper's the two readings of alpha."""

from __future__ import annotations

from imo_analysis.machine import PAPER_PRESETS, PRESETS, InductionMachine
from imo_analysis.notation import symbol
from imo_analysis.paper.statements import ALPHA_START
from imo_analysis.report.page import Chapter, Html, answer, join, prose, table, tag
from imo_analysis.report.paper_machine import is_paper
from imo_analysis.report.words import typeset, unit

UNNAMED = str(InductionMachine.model_fields["name"].default)
_GIVEN = ("n_p", "R_s", "R_r", "L_m", "L_s", "L_r", "J", "B")
_DERIVED = ("sigma", "alpha", "beta", "gamma", "mu")


def machine_chapter(machine: InductionMachine) -> Chapter:
    """The study's machine; where it is the paper's, beside both readings of Table III."""
    papers = is_paper(machine)
    columns: dict[str, InductionMachine] = {"this study": machine}
    if papers:
        columns |= {name: PRESETS[name] for name in PAPER_PRESETS}
    head = ("", "unit", "meaning", *columns)
    numeric = range(3, len(head))

    def rows(names: tuple[str, ...]) -> list[tuple[object, ...]]:
        return [
            (f"${symbol(name).latex}$", unit(symbol(name).unit), typeset(symbol(name).meaning),
             *(f"{getattr(one, name):.5g}" for one in columns.values()))
            for name in names
        ]

    body = join(
        [
            tag("p", *_who(machine)),
            table(head, rows(_GIVEN), "Parameters", numeric),
            table(head, rows(_DERIVED), "What follows from them", numeric),
            *(_readings() if papers else ()),
            tag("h3", "Units of the speed equation"),
            prose(
                r"""
Table I prints $\mu = 3 L_m / (2 L_r)$. With it the speed row of (1) does not have consistent units: the inertia is missing from
the torque term, and without the pole pairs $\omega$ cannot be both the electrical speed that the flux equations need and the
speed of the shaft. Here $\omega$ is the electrical speed throughout, $\mu = 3 n_p^{2} L_m / (2 J L_r)$, and the load enters as
$n_p T_l / J$.
"""
            ),
            tag("h3", "The same machine in other circuit forms"),
            _forms(machine),
        ]
    )
    return Chapter("machine", "Machine", "The machine", body)


def _who(machine: InductionMachine) -> list[object]:
    """A sentence that names the machine and its source, or says that the study does not."""
    nameless = machine.name in ("", UNNAMED)
    if nameless and not machine.source:
        return ["The study neither names its machine nor says where the parameters are from."]
    named: list[object] = [Html("The study's machine is "), tag("code", machine.name)]
    if nameless:
        named = ["The study does not name its machine"]
    source = [". Source: ", typeset(machine.source)] if machine.source else ["; where its parameters are from it does not say"]
    return [*named, *source, "."]


def _readings() -> list[Html]:
    """Table III's resistance and its printed alpha do not fit together."""
    plain, printed = PRESETS["table-iii"], PRESETS["table-iii-printed-alpha"]
    return [
        tag("h3", "The two readings of alpha"),
        prose(
            rf"""
Table III gives $R_r = {plain.R_r:g}\;\Omega$ and, from its inductances, $L_r = {plain.L_r * 1e3:g}\;\mathrm{{mH}}$, so that
$\alpha = R_r / L_r = {plain.alpha:.4f}\;/\mathrm{{s}}$. The same table prints $\alpha = {printed.alpha:.4f}\;/\mathrm{{s}}$,
which is {printed.alpha / plain.alpha:.4f} times as much. Both cannot be right.
"""
        ),
        answer(
            f"The text starts the estimate at {ALPHA_START:g} and takes {printed.alpha:.4f} as the true value: the simulated "
            f"motor is the table's motor with its rotor resistance raised by {100 * (printed.R_r / plain.R_r - 1):.3g} % "
            f"($R_r = {printed.R_r:.3f}\\;\\Omega$), and the observers begin with the table's own value. Both readings are "
            "kept, as the presets `table-iii` and `table-iii-printed-alpha`."
        ),
    ]


def _forms(machine: InductionMachine) -> object:
    written = {"R_s": "R_s", "R_R": "R_R", "L_sgm": r"L_{\sigma}", "L_M": "L_M", "R_r": "R_r'", "L_s": "L_s",
               "L_ell": r"L_{\ell}"}
    rows = []
    for name, form in (("inverse-Γ (all leakage on the stator side)", machine.inverse_gamma()),
                       ("Γ (all leakage on the rotor side)", machine.gamma_form())):
        values = ", ".join(f"${written[key]} = {value:.5g}\\;{_si(key)}$" for key, value in form.items())
        rows.append((name, values))
    return table(("form", "parameters"), rows)


def _si(name: str) -> str:
    return r"\Omega" if name.startswith("R") else r"\mathrm{H}"
