"""Table I and (1)-(6): the machine, its parameters, the baseline observer, the new coordinates."""

from __future__ import annotations

from functools import cache
from typing import Any

from imo_analysis.equations import baseline, parameters, plant, transformation
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.transcript import claim, printed, same, shapes
from imo_analysis.ledger.expression import Name, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS, MACHINE, VOLTAGES, machine

HOLDS, CORRECTED, FAILS, OPEN = Verdict.HOLDS, Verdict.CORRECTED, Verdict.FAILS, Verdict.OPEN


@cache
def first_principles() -> Setting:
    """Kirchhoff's and Faraday's laws for two coupled windings a phase, and the definitions that (1) should satisfy.

    Flux linkages come from the inductances alone, and Table I's parameters from resistances, inductances, inertia.
    """
    R_s, R_r, L_s, L_m, L_r, J, n_p = names("R_s R_r L_s L_m L_r J n_p")
    state = names("i_ds i_qs phi_dr phi_qr omega")
    rates = plant.plant(state, VOLTAGES, Name("omega_1"), Name("T_l"), names("R_s L_m sigma beta alpha mu n_p J"))
    defined: dict[str, Any] = {
        "sigma": parameters.leakage(L_s, L_m, L_r),
        "alpha": parameters.rotor_rate(R_r, L_r),
        "beta": parameters.coupling(L_m, Name("sigma"), L_r),
        "gamma": parameters.current_decay(R_s, L_m, *names("sigma alpha beta")),
        "mu": parameters.torque_gain(n_p, L_m, L_r, J),
        **{f"{one}_dot": rate for one, rate in zip(("i_ds", "i_qs", "phi_dr", "phi_qr", "omega"), rates, strict=True)},
        "torque": plant.torque(state, n_p, L_m, L_r),
    }
    for d, r, psi in (("i_ds", "phi_dr", "psi_ds"), ("i_qs", "phi_qr", "psi_qs")):
        rotor = f"{r.replace('phi', 'i')}"
        defined[rotor] = (Name(r) - L_m * Name(d)) / L_r
        defined[psi] = L_s * Name(d) + L_m * Name(rotor)
        defined[f"{rotor}_dot"] = (Name(f"{r}_dot") - L_m * Name(f"{d}_dot")) / L_r
        defined[f"{psi}_dot"] = L_s * Name(f"{d}_dot") + L_m * Name(f"{rotor}_dot")
    defined["z_1"], defined["z_2"] = transformation.to_z(*names("i_ds i_qs phi_dr phi_qr beta"))
    return setting(
        "first_principles",
        "stator and rotor windings with inductances L_s, L_m, L_r in a frame at omega_1",
        defined,
        ("L_r > 0", "sigma > 0", "J > 0", "L_m > 0", "n_p > 0"),
        units={"psi_ds": "Wb", "psi_qs": "Wb", "psi_ds_dot": "V", "psi_qs_dot": "V", "i_dr": "A", "i_qr": "A"},
    )


@cache
def baseline_errors() -> Setting:
    """The machine (1) in the stationary frame and the baseline observer (2)-(4), and their errors."""
    hats = names("i_ds_hat i_qs_hat phi_dr_hat phi_qr_hat omega_hat")
    rates = baseline.baseline(hats, CURRENTS, VOLTAGES, Name("direction"), MACHINE, names("l_1 l_2 l_3 l_4 h"))
    state = names("i_ds i_qs phi_dr phi_qr omega")
    true = plant.plant(state, VOLTAGES, 0, Name("T_l"), (*MACHINE, *names("mu n_p J")))
    which = ("i_ds", "i_qs", "phi_dr", "phi_qr", "omega")
    defined: dict[str, Any] = {f"{one}_hat": Name(one) - Name(f"{one}_tilde") for one in which}
    defined |= {f"{one}_dot": rate for one, rate in zip(which, true, strict=True)} | {"omega_dot": 0}
    defined |= {f"{one}_hat_dot": rate for one, rate in zip(which, rates, strict=True)}
    defined |= {f"{one}_tilde_dot": Name(f"{one}_dot") - Name(f"{one}_hat_dot") for one in which}
    return setting(
        "baseline_errors",
        "the machine (1) and the baseline observer (2)-(4), omega constant",
        defined,
        ("sigma > 0", "beta > 0", "h > 0"),
    )


@cache
def _without_current_error() -> Setting:
    """The baseline observer where its currents are the measured ones."""
    hats = (*CURRENTS, *names("phi_dr_hat phi_qr_hat omega_hat"))
    rates = baseline.baseline(hats, CURRENTS, VOLTAGES, Name("direction"), MACHINE, names("l_1 l_2 l_3 l_4 h"))
    which = ("i_ds", "i_qs", "phi_dr", "phi_qr", "omega")
    return setting(
        "baseline_without_error",
        "the baseline observer where its currents agree with the measured ones",
        {f"{one}_hat_dot": rate for one, rate in zip(which, rates, strict=True)},
        ("sigma > 0",),
    )


_FIRST = (
    Algebra(
        "evidence",
        "stator: voltage is the resistive drop and the change of the stator's flux linkage",
        ("psi_ds_dot = u_ds - R_s*i_ds + omega_1*psi_qs", "psi_qs_dot = u_qs - R_s*i_qs - omega_1*psi_ds"),
    ),
    Algebra(
        "evidence",
        "rotor: the winding is shorted and turns at omega",
        ("phi_dr_dot = -R_r*i_dr + (omega_1 - omega)*phi_qr", "phi_qr_dot = -R_r*i_qr - (omega_1 - omega)*phi_dr"),
    ),
)


def _known(name: str, words: str) -> Claim:
    return claim(name, words, HOLDS, first_principles(), checks=_FIRST if name == "eq1.i_ds" else ())


CLAIMS: list[Claim] = [
    *(
        _known(f"eq1.{name}", f"rate of {words}")
        for name, words in (
            ("i_ds", "the d-axis current"),
            ("i_qs", "the q-axis current"),
            ("phi_dr", "the d-axis rotor flux"),
            ("phi_qr", "the q-axis rotor flux"),
        )
    ),
    claim(
        "eq1.omega",
        "rate of the speed",
        CORRECTED,
        first_principles(),
        corrected=same("eq1.omega", "T_l/J", "n_p*T_l/J"),
        edit="n_p T_l / J for T_l / J, with mu = 3 n_p^2 L_m / (2 J L_r)",
        checks=(
            Algebra("evidence", "Newton's law for the shaft, whose speed is omega / n_p", ("J*omega_dot/n_p = torque - T_l",)),
            Algebra(
                "evidence",
                "with one pole pair the printed load term is right",
                (printed("eq1.omega"),),
                setting=first_principles().extended("one_pole_pair", cases=({"n_p": 1},)),
            ),
        ),
        assumptions=("omega is the electrical speed: the flux rows of (1) leave no choice",),
        origin="paper",
        why="the row is typeset in full; with n_p = 2 (Table III) the load term is off by a factor 2",
        consequences=("table1.mu",),
    ),
    *(_known(f"table1.{name}", f"definition of {name}") for name in ("sigma", "alpha", "beta", "gamma")),
    claim(
        "table1.mu",
        "definition of mu",
        CORRECTED,
        first_principles(),
        corrected="mu = 3*n_p**2*L_m/(2*J*L_r)",
        edit="multiply by n_p^2 / J",
        origin="paper",
        units="mu of (1) is in 1/(kg m^2), 3 L_m/(2 L_r) is a pure number",
        why="with a pure number for mu, (1) adds a torque to an acceleration",
        consequences=("eq1.omega",),
        checks=(
            Algebra(
                "evidence",
                "the torque of the machine, turned into electrical acceleration",
                ("mu*(phi_dr*i_qs - phi_qr*i_ds) = n_p*torque/J",),
            ),
        ),
    ),
    *(_known(f"table1.{name}", f"{name} as in (5)") for name in ("z_1", "z_2")),
    claim(
        "table1.names",
        "one name for the mutual inductance",
        CORRECTED,
        first_principles().extended("two_names", units={"L_M": "H"}),
        printed="beta = L_M/(sigma*L_r)",
        corrected="beta = L_m/(sigma*L_r)",
        edit="L_m for L_M",
        origin="paper",
        why="every equation and Table III write L_m; L_M is named in Table I alone",
        prose="The mutual inductance is called L_M in the list and L_m in the formulas.",
        mutate=False,
    ),
    *(
        claim(f"eq2.{name}", f"row {name[-1]} of A' and B' u", HOLDS, machine(), assumptions=("stationary frame, omega_1 = 0",))
        for name in ("A.1", "A.2", "A.3", "A.4")
    ),
    claim(
        "eq2.B",
        "shape of B'",
        CORRECTED,
        edit="remove the transpose",
        checks=(
            shapes("printed", "x' is 4x1; B' as printed is 2x4", (4, 1), ((4, 4), (4, 1)), ((2, 4), (2, 1))),
            shapes("corrected", "B' without the transpose is 4x2", (4, 1), ((4, 4), (4, 1)), ((4, 2), (2, 1))),
        ),
        prose="B' is printed as the transpose of a 4x2 matrix.",
        origin="paper",
        why="C' is printed in the same way, where the transpose belongs; B' seems to have been copied from it",
    ),
    claim(
        "eq2.C",
        "shape of C'",
        HOLDS,
        checks=(shapes("printed", "C' picks the two currents", (2, 1), ((2, 4), (4, 1))),),
        prose="C' is the transpose of a 4x2 matrix that picks the currents.",
    ),
    claim(
        "eq3.observer",
        "the baseline observer",
        OPEN,
        origin="scan",
        why="the display is missing, its number too",
        checks=(
            Algebra(
                "evidence",
                "the copy of (2) with an output feedback that we use in its place: with no current error "
                "it is (2) at the estimated speed",
                (
                    "phi_dr_hat_dot = -alpha*phi_dr_hat - omega_hat*phi_qr_hat + alpha*L_m*i_ds",
                    "phi_qr_hat_dot = -alpha*phi_qr_hat + omega_hat*phi_dr_hat + alpha*L_m*i_qs",
                ),
                setting=_without_current_error(),
            ),
            shapes("evidence", "L must be 4x2", (4, 1), ((4, 4), (4, 1)), ((4, 2), (2, 1))),
        ),
        note="No gain L of the paper is printed; Table II lists the poles it gave.",
        consequences=("table2",),
    ),
    claim(
        "eq4.omega_hat",
        "the baseline's speed law",
        HOLDS,
        baseline_errors(),
        checks=(
            Algebra(
                "evidence",
                "the law cancels what the speed error does to the squared current error: the choice of sign is right",
                ("beta*omega_tilde*(i_ds_tilde*phi_qr_hat - i_qs_tilde*phi_dr_hat) + omega_tilde*omega_tilde_dot/h = 0",),
            ),
            Algebra(
                "evidence",
                "the current rows carry the speed error as beta omega_tilde (phi_qr_hat, -phi_dr_hat)",
                (
                    "i_ds_tilde_dot = -(R_s/sigma + alpha*beta*L_m + l_1)*i_ds_tilde + l_2*i_qs_tilde + "
                    "beta*(alpha*phi_dr_tilde"
                    " + omega*phi_qr_tilde + omega_tilde*phi_qr_hat)",
                    "i_qs_tilde_dot = -(R_s/sigma + alpha*beta*L_m + l_1)*i_qs_tilde - l_2*i_ds_tilde + "
                    "beta*(alpha*phi_qr_tilde"
                    " - omega*phi_dr_tilde - omega_tilde*phi_dr_hat)",
                ),
            ),
            Algebra(
                "evidence",
                "the flux rows carry it too, and with it a term that no measured signal can cancel: this is "
                "what keeps the baseline without a proof",
                (
                    "phi_dr_tilde*phi_dr_tilde_dot + phi_qr_tilde*phi_qr_tilde_dot = -alpha*(phi_dr_tilde**2 + phi_qr_tilde**2)"
                    " + (alpha*L_m - l_3)*(i_ds_tilde*phi_dr_tilde + i_qs_tilde*phi_qr_tilde)"
                    " + l_4*(i_qs_tilde*phi_dr_tilde - i_ds_tilde*phi_qr_tilde)"
                    " + omega_tilde*(phi_dr_hat*phi_qr_tilde - phi_qr_hat*phi_dr_tilde)",
                ),
            ),
        ),
    ),
    claim(
        "baseline-not-convergent",
        "the baseline's errors cannot converge",
        OPEN,
        baseline_errors(),
        note="The literature it cites has no proof of convergence; that is no proof of the contrary, and Table II itself lists "
        "poles of the baseline with negative real parts at every speed. The obstacle is the last term under (4).",
    ),
    *(
        claim(
            f"eq5.{name}",
            f"{name} is the stator's flux linkage over sigma",
            HOLDS,
            first_principles(),
            checks=(Algebra("evidence", "from the inductances", (f"sigma*{name} = psi_{axis}",)),),
        )
        for name, axis in (("z_1", "ds"), ("z_2", "qs"))
    ),
    *(
        claim(
            f"eq6.{name}",
            f"rate of {name}",
            HOLDS,
            machine(),
            assumptions=("stationary frame, omega_1 = 0",),
            checks=(
                Algebra(
                    "evidence",
                    "in a frame that turns, this term is added",
                    (printed(f"eq6.{name}") + remainder,),
                    setting=machine("omega_1"),
                ),
            ),
        )
        for name, remainder in (
            ("i_ds", " + omega_1*i_qs"),
            ("i_qs", " - omega_1*i_ds"),
            ("z_1", " + omega_1*z_2"),
            ("z_2", " - omega_1*z_1"),
        )
    ),
]
