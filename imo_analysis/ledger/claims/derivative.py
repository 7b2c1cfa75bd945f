"""(13)-(15) and the two claims below them: the Lyapunov function and its derivative, term by term."""

from __future__ import annotations

from functools import cache

from imo_analysis.equations import adaptive, lyapunov, projection
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.situations import BREAKS_16, ERRORS, lyapunov_13, with_function
from imo_analysis.ledger.claims.transcript import claim, printed, same
from imo_analysis.ledger.expression import Expr, Name, names, parse_relation
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS, errors

HOLDS, CORRECTED, FAILS = Verdict.HOLDS, Verdict.CORRECTED, Verdict.FAILS

# The terms of (14) as they have to be.
_TERMS: dict[str, str] = {
    "current": printed("eq14.current"),
    "gain": same("eq14.gain", "omega_dot", "omega_hat_dot"),
    "rho_1": same("eq14.rho_1", "(xi_2_hat - (1 + beta*L_m)*i_ds)", "(xi_2_hat - (1 + beta*L_m)*i_qs)"),
    "rho_2": printed("eq14.rho_2"),
    "rho_3": printed("eq14.rho_3"),
    "z": same("eq14.z", "(z_1*z_1_dot + z_2*z_2_dot)", "(z_1_tilde*z_1_tilde_dot + z_2_tilde*z_2_tilde_dot)"),
    "xi": same("eq14.xi", "(xi_1*xi_1_dot + xi_2*xi_2_dot)", "(xi_1_tilde*xi_1_tilde_dot + xi_2_tilde*xi_2_tilde_dot)"),
    "alpha": same("eq14.alpha", "alpha_dot", "alpha_tilde_dot"),
    "omega": same("eq14.omega", "omega_dot/g", "omega_tilde_dot/K_p"),
}


# Which errors move for a term; those of the currents give four terms together.
_MOVING: dict[str, tuple[str, ...]] = {
    "gain": ("omega_hat",),
    "z": ("z_1_tilde", "z_2_tilde"),
    "xi": ("xi_1_tilde", "xi_2_tilde"),
    "alpha": ("alpha_tilde",),
    "omega": ("omega_tilde",),
}
_OF_CURRENTS = ("current", "rho_1", "rho_2", "rho_3")


@cache
def terms() -> Setting:
    """V of (13), corrected, and ``term_x``: what the row x of (14) must be.

    The derivative along the rates of some errors alone gives the terms of those errors. The rates of the current errors give
    four terms together; each of them is what the other three leave.
    """
    parts = {f"part_{name}": parse_relation(text).right for name, text in _TERMS.items()}
    defined: dict[str, Expr] = dict(parts)
    for name, moving in _MOVING.items():
        defined[f"term_{name}"] = with_function(lyapunov.corrected_13, moving)["V_dot"]
    of_currents = with_function(lyapunov.corrected_13, ERRORS[:2])["V_dot"]
    for name in _OF_CURRENTS:
        rest = of_currents
        for other in _OF_CURRENTS:
            rest = rest if other == name else rest - Name(f"part_{other}")
        defined[f"term_{name}"] = rest
    base = lyapunov_13()
    return base.extended(
        "terms_14", base.text, defined, units={f"term_{name}": "A^2/s" for name in _TERMS} | {"V_dot": "A^2/s"}
    )


@cache
def in_the_layer(side: str) -> Setting:
    """The alpha law while the projection acts: alpha_hat in the layer and the signal pointing out of it."""
    base = errors()
    signal = adaptive.alpha_signal(names("i_ds_tilde i_qs_tilde"), CURRENTS, names("xi_1_hat xi_2_hat"), *names("beta L_m"))
    before = {name: tree for name, tree in base.definitions.items() if name != "alpha_tilde_dot"}
    return setting(
        f"in_the_layer_{'above' if '>' in side else 'below'}",
        "the alpha law where the projection scales it by 1 - p, p >= 0, its signal being negative",
        {
            **before,
            "signal": signal,
            "p": projection.layer(*names("alpha_hat alpha_l delta")),
            "alpha_tilde_dot": -(1 - Name("p")) * (Name("g") * Name("signal")),
        },
        (
            *base.hypotheses,
            "g > 0",
            "signal <= 0",
            "p >= 0",
            side,
            "2*delta*alpha_l - delta*delta > 0",
            "alpha_l > 0",
            "delta > 0",
        ),
        base.cases,
        {"signal": "A^2", "p": "1"},
    )


_WHY_TILDE = "the same accents are missing in (14) and (15), so the print may lack them; what is meant is clear"
_T = terms()


def _term(name: str, title: str, edit: str = "", **more: object) -> Claim:
    if not edit:
        return claim(f"eq14.{name}", title, HOLDS, _T, **more)
    return claim(f"eq14.{name}", title, CORRECTED, _T, corrected=_TERMS[name], edit=edit, **more)


CLAIMS: list[Claim] = [
    claim(
        "eq13.V",
        "the function whose xi and z terms cancel",
        CORRECTED,
        lyapunov_13(),
        corrected=same("eq13.V", "alpha/(2*k_2)", "alpha/(2*k_3)"),
        edit="alpha / (2 k_3) for alpha / (2 k_2)",
        origin="paper",
        units="k_2 is a pure number here, so alpha / k_2 gives A^2/s where V is A^2",
        why="k_2 is clear in the scan; (15) has alpha/k_3, which is right",
        checks=(
            Algebra(
                "evidence",
                "with the printed weight, this is left over of the xi terms",
                (
                    "alpha*(i_ds_tilde*xi_1_tilde + i_qs_tilde*xi_2_tilde) + alpha/k_2*(xi_1_tilde*xi_1_tilde_dot"
                    " + xi_2_tilde*xi_2_tilde_dot) = alpha*(1 - k_3/k_2)*(i_ds_tilde*xi_1_tilde + i_qs_tilde*xi_2_tilde)",
                ),
            ),
            Algebra(
                "evidence",
                "V is no Lyapunov function where omega and its estimate differ in sign: the z term is negative",
                ("omega/(2*k_2*omega_hat)*(z_1_tilde**2 + z_2_tilde**2) <= 0",),
                squares=(("-omega/(2*k_2*omega_hat)", "z_1_tilde"), ("-omega/(2*k_2*omega_hat)", "z_2_tilde")),
                setting=lyapunov_13().extended("opposite_signs", hypotheses=("omega > 0", "omega_hat < 0")),
            ),
        ),
        assumptions=("k_2 > 0; omega and omega_hat not zero and of one sign",),
        note="V is not defined at omega_hat = 0, which is where Section V starts its observers.",
        consequences=("eq16.bound", "initial-conditions"),
    ),
    _term(
        "current",
        "the damping of the current errors",
        checks=(
            Algebra(
                "evidence",
                "all terms together, corrected, are the derivative of V along (12)",
                (f"V_dot = {' + '.join('part_' + one for one in _TERMS)}",),
            ),
        ),
    ),
    _term(
        "gain",
        "what the moving weight of z adds",
        "omega_hat_dot for omega_dot",
        origin="scan",
        why="the weight omega/(2 k_2 omega_hat) moves with the estimate; omega is constant here, and then the printed "
        "term is zero",
        consequences=("sign-operator.inequality", "eq16.bound"),
    ),
    _term(
        "rho_1",
        "the terms of the alpha error",
        "i_qs for i_ds in the second bracket",
        origin="paper",
        why="(9) has i_qs; the slip is repeated in the inequality below (15)",
        consequences=("projection-inequality.inequality",),
    ),
    _term("rho_2", "the terms of the z and xi errors"),
    _term("rho_3", "the terms of the speed error", note="It has the signs that the i_qs row of (12) lacks."),
    _term("z", "the rate of the z error", "z_tilde for z", origin="scan", why=_WHY_TILDE),
    _term("xi", "the rate of the xi error", "xi_tilde for xi", origin="scan", why=_WHY_TILDE),
    _term("alpha", "the rate of the alpha error", "alpha_tilde for alpha under the dot", origin="scan", why=_WHY_TILDE),
    _term(
        "omega",
        "the rate of the speed error",
        "K_p for g, and omega_tilde for omega under the dot",
        origin="paper",
        why="1/g is clear in the scan, where (13) has 1/(2 K_p)",
    ),
    claim(
        "eq15.z",
        "the z terms cancel",
        CORRECTED,
        lyapunov_13(),
        corrected=same(
            "eq15.z", "(z_1*z_1_tilde_dot + z_2*z_2_tilde_dot)", "(z_1_tilde*z_1_tilde_dot + z_2_tilde*z_2_tilde_dot)"
        ),
        edit="z_tilde for z",
        origin="scan",
        why=_WHY_TILDE,
    ),
    claim(
        "eq15.xi",
        "the xi terms cancel",
        CORRECTED,
        lyapunov_13(),
        corrected=same(
            "eq15.xi", "(xi_1*xi_1_tilde_dot + xi_2*xi_2_tilde_dot)", "(xi_1_tilde*xi_1_tilde_dot + xi_2_tilde*xi_2_tilde_dot)"
        ),
        edit="xi_tilde for xi",
        origin="scan",
        why=_WHY_TILDE,
    ),
    claim(
        "projection-inequality.inequality",
        "the alpha terms are together at most zero",
        CORRECTED,
        in_the_layer("alpha_tilde >= 0"),
        corrected=same(
            "projection-inequality.inequality", "(xi_2_hat - (1 + beta*L_m)*i_ds)", "(xi_2_hat - (1 + beta*L_m)*i_qs)"
        ),
        squares=(("-alpha_tilde*signal*p", "1"),),
        edit="i_qs for i_ds in the second bracket",
        origin="paper",
        why="the slip of rho_1 in (14), repeated",
        checks=(
            Algebra(
                "evidence",
                "outside the layer they cancel",
                ("alpha_tilde*rho_terms + alpha_tilde*alpha_tilde_dot/g = 0",),
                setting=errors().extended(
                    "no_layer",
                    definitions={"rho_terms": in_the_layer("alpha_tilde >= 0").definitions["signal"]},
                    hypotheses=("g > 0",),
                ),
            ),
            Algebra(
                "evidence",
                "if alpha is below its estimate in the layer, hence below alpha_l, the inequality is reversed",
                (
                    same(
                        "projection-inequality.inequality",
                        "(xi_2_hat - (1 + beta*L_m)*i_ds)",
                        "(xi_2_hat - (1 + beta*L_m)*i_qs)",
                    ).replace("<=", ">="),
                ),
                squares=(("alpha_tilde*signal*p", "1"),),
                setting=in_the_layer("alpha_tilde <= 0"),
            ),
        ),
        assumptions=("alpha >= alpha_l, which is not printed; in the layer then alpha_tilde >= 0",),
    ),
    claim(
        "sign-operator.inequality",
        "the term with the rate of omega_hat is at most zero",
        FAILS,
        lyapunov_13().extended("forwards", hypotheses=("omega > 0", "omega_hat > 0"), cases=({"direction": 1},)),
        printed=same("sign-operator.inequality", "-omega_dot", "-omega_hat_dot"),
        point=BREAKS_16,
        origin="paper",
        why="the text says why the term should be negative, and that reason does not hold",
        checks=(
            Algebra(
                "evidence",
                "with (11), the term has the sign of a signal that changes sign; Sign(omega) makes |omega| of "
                "omega and no more",
                (
                    "-omega_hat_dot/omega_hat**2*omega/(2*k_2)*(z_1_tilde**2 + z_2_tilde**2)"
                    " = -K_p*(direction*omega)*(-i_qs_hat*i_ds_tilde + i_ds_hat*i_qs_tilde"
                    " + z_2_hat*i_ds_tilde - z_1_hat*i_qs_tilde)/(2*k_2*omega_hat**2)"
                    "*(z_1_tilde**2 + z_2_tilde**2)",
                ),
            ),
        ),
        note="Read with the rate of omega, as the scan has it, the term is zero, but then it is not the term of the "
        "derivative.",
        consequences=("eq16.bound", "proposition-IV.2"),
    ),
]
