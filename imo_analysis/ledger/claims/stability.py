"""(13)-(18), Lemma IV.1 and Proposition IV.2: the Lyapunov function, its derivative term by term, and what follows."""

from __future__ import annotations

from functools import cache

from imo_analysis.equations import adaptive, projection
from imo_analysis.ledger.claim import Algebra, Claim, Trajectory, Verdict
from imo_analysis.ledger.claims.situations import BOUND, ERRORS, lyapunov_13, repaired
from imo_analysis.ledger.claims.transcript import claim, printed, same
from imo_analysis.ledger.expression import Expr, Name, names, parse, parse_relation
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS, errors

HOLDS, CORRECTED, FAILS, OPEN = Verdict.HOLDS, Verdict.CORRECTED, Verdict.FAILS, Verdict.OPEN

# The terms of (14) as they have to be; None where the print is right.
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


@cache
def terms() -> Setting:
    """V of (13), corrected; ``term_x`` is the derivative less all the other terms, which is what the row x of (14) must be."""
    right = {name: parse_relation(text).right for name, text in _TERMS.items()}
    total: Expr = Name("V_dot")
    defined: dict[str, Expr] = {f"part_{name}": tree for name, tree in right.items()}
    for name in right:
        rest = total
        for other in right:
            if other != name:
                rest = rest - Name(f"part_{other}")
        defined[f"term_{name}"] = rest
    base = lyapunov_13()
    return base.extended("terms_14", base.text, defined, units={f"term_{name}": "A^2/s" for name in right} | {"V_dot": "A^2/s"})


@cache
def in_the_layer(side: str) -> Setting:
    """The alpha law while the projection acts: alpha_hat in the layer and the signal pointing out of it."""
    base = errors()
    signal = adaptive.alpha_signal(names("i_ds_tilde i_qs_tilde"), CURRENTS, names("xi_1_hat xi_2_hat"), *names("beta L_m"))
    before = {name: tree for name, tree in base.definitions.items() if name != "alpha_tilde_dot"}
    return setting(
        f"in_the_layer_{'above' if '>' in side else 'below'}",
        "the alpha law where the projection scales it by 1 - p, p >= 0, its signal being negative",
        {**before, "signal": signal, "p": projection.layer(*names("alpha_hat alpha_l delta")),
         "alpha_tilde_dot": -(1 - Name("p")) * (Name("g") * Name("signal"))},
        (*base.hypotheses, "g > 0", "signal <= 0", "p >= 0", side, "2*delta*alpha_l - delta*delta > 0", "alpha_l > 0", "delta > 0"),
        base.cases, {"signal": "A^2", "p": "1"})


@cache
def integrals() -> Setting:
    """(17) between 0 and t: V(0) - V(t) is at least c times the integral of the squared current error, c = k_1 + R_s/sigma."""
    return setting(
        "integrals", "V_0 = V(0) and V_t = V(t) >= 0; slack >= 0 is what (17) leaves: V_0 - V_t = c integral + slack",
        {"integral": (Name("V_0") - Name("V_t") - Name("slack")) / parse("k_1 + R_s/sigma")},
        ("k_1 + R_s/sigma > 0", "V_t >= 0", "slack >= 0", "sigma > 0", "R_s > 0", "k_1 > 0"),
        units={"V_0": "A^2", "V_t": "A^2", "slack": "A^2", "integral": "A^2 s"})


# All parameters and gains 1, speed and its estimate 1, no error but 1 A in the d current and 4 A in z_1.
BREAKS_16 = {
    **dict.fromkeys(("R_s", "L_m", "sigma", "beta", "alpha", "k_1", "k_2", "k_3", "g", "K_p", "omega", "direction"), 1),
    **dict.fromkeys((*ERRORS, "i_ds", "i_qs", "z_1", "z_2", "u_ds", "u_qs"), 0), "i_ds_tilde": 1, "z_1_tilde": 4, "z_2": -1,
}
_NO_ERROR = {**dict.fromkeys(ERRORS, 0), "direction": 1}
_RATE_V = (f"V_dot = {BOUND} - omega*omega_hat_dot/(2*k_2*omega_hat**2)*(z_1_tilde**2 + z_2_tilde**2)"
           " + omega_tilde*(omega_tilde_dot + K_p*(-i_qs_hat*i_ds_tilde + i_ds_hat*i_qs_tilde + z_2_hat*i_ds_tilde"
           " - z_1_hat*i_qs_tilde))/K_p")
_WHY_TILDE = "the same accents are missing in (14) and (15), so the print may lack them; what is meant is clear"
_T = terms()
# What V holds besides currents and z.
_SMALL = (("alpha/k_3", "xi_1_tilde"), ("alpha/k_3", "xi_2_tilde"), ("1/g", "alpha_tilde"), ("1/K_p", "omega_tilde"))


def _same_signs() -> Setting:
    return lyapunov_13().extended("same_signs", hypotheses=("omega > 0", "omega_hat > 0"))


def _triangle() -> Setting:
    return setting("triangle", "a function that reaches e > 0 and whose slope is at most M > 0", hypotheses=("e > 0", "M > 0"))


def _term(name: str, title: str, edit: str = "", **more: object) -> Claim:
    if not edit:
        return claim(f"eq14.{name}", title, HOLDS, _T, **more)
    return claim(f"eq14.{name}", title, CORRECTED, _T, corrected=_TERMS[name], edit=edit, **more)


CLAIMS: list[Claim] = [
    claim("eq13.V", "the function whose xi and z terms cancel", CORRECTED, lyapunov_13(), corrected=same("eq13.V", "alpha/(2*k_2)", "alpha/(2*k_3)"),
          edit="alpha / (2 k_3) for alpha / (2 k_2)", origin="paper", units="k_2 is a pure number here, so alpha / k_2 gives A^2/s where V is A^2",
          why="k_2 is clear in the scan; (15) has alpha/k_3, which is right",
          checks=(Algebra("evidence", "with the printed weight, this is left over of the xi terms",
                          ("alpha*(i_ds_tilde*xi_1_tilde + i_qs_tilde*xi_2_tilde) + alpha/k_2*(xi_1_tilde*xi_1_tilde_dot"
                           " + xi_2_tilde*xi_2_tilde_dot) = alpha*(1 - k_3/k_2)*(i_ds_tilde*xi_1_tilde + i_qs_tilde*xi_2_tilde)",)),
                  Algebra("evidence", "V is no Lyapunov function where omega and its estimate differ in sign: the z term is negative",
                          ("omega/(2*k_2*omega_hat)*(z_1_tilde**2 + z_2_tilde**2) <= 0",),
                          squares=(("-omega/(2*k_2*omega_hat)", "z_1_tilde"), ("-omega/(2*k_2*omega_hat)", "z_2_tilde")),
                          setting=lyapunov_13().extended("opposite_signs", hypotheses=("omega > 0", "omega_hat < 0")))),
          assumptions=("k_2 > 0; omega and omega_hat not zero and of one sign",),
          note="V is not defined at omega_hat = 0, which is where Section V starts its observers.",
          consequences=("eq16", "initial-conditions")),
    _term("current", "the damping of the current errors",
          checks=(Algebra("evidence", "all terms together, corrected, are the derivative of V along (12)",
                          (f"V_dot = {' + '.join('part_' + one for one in _TERMS)}",)),)),
    _term("gain", "what the moving weight of z adds", "omega_hat_dot for omega_dot", origin="scan",
          why="the weight omega/(2 k_2 omega_hat) moves with the estimate; omega is constant here, and then the printed term is zero",
          consequences=("sign-operator", "eq16")),
    _term("rho_1", "the terms of the alpha error", "i_qs for i_ds in the second bracket", origin="paper",
          why="(9) has i_qs; the slip is repeated in the inequality below (15)", consequences=("projection-inequality.inequality",)),
    _term("rho_2", "the terms of the z and xi errors"),
    _term("rho_3", "the terms of the speed error", note="It has the signs that the i_qs row of (12) lacks."),
    _term("z", "the rate of the z error", "z_tilde for z", origin="scan", why=_WHY_TILDE),
    _term("xi", "the rate of the xi error", "xi_tilde for xi", origin="scan", why=_WHY_TILDE),
    _term("alpha", "the rate of the alpha error", "alpha_tilde for alpha under the dot", origin="scan", why=_WHY_TILDE),
    _term("omega", "the rate of the speed error", "K_p for g, and omega_tilde for omega under the dot", origin="paper",
          why="1/g is clear in the scan, where (13) has 1/(2 K_p)"),
    claim("eq15.z", "the z terms cancel", CORRECTED, lyapunov_13(),
          corrected=same("eq15.z", "(z_1*z_1_tilde_dot + z_2*z_2_tilde_dot)", "(z_1_tilde*z_1_tilde_dot + z_2_tilde*z_2_tilde_dot)"),
          edit="z_tilde for z", origin="scan", why=_WHY_TILDE),
    claim("eq15.xi", "the xi terms cancel", CORRECTED, lyapunov_13(),
          corrected=same("eq15.xi", "(xi_1*xi_1_tilde_dot + xi_2*xi_2_tilde_dot)", "(xi_1_tilde*xi_1_tilde_dot + xi_2_tilde*xi_2_tilde_dot)"),
          edit="xi_tilde for xi", origin="scan", why=_WHY_TILDE),
    claim("projection-inequality.inequality", "the alpha terms are together at most zero", CORRECTED, in_the_layer("alpha_tilde >= 0"),
          corrected=same("projection-inequality.inequality", "(xi_2_hat - (1 + beta*L_m)*i_ds)", "(xi_2_hat - (1 + beta*L_m)*i_qs)"),
          squares=(("-alpha_tilde*signal*p", "1"),), edit="i_qs for i_ds in the second bracket", origin="paper",
          why="the slip of rho_1 in (14), repeated",
          checks=(Algebra("evidence", "outside the layer they cancel", ("alpha_tilde*rho_terms + alpha_tilde*alpha_tilde_dot/g = 0",),
                          setting=errors().extended("no_layer", definitions={"rho_terms": in_the_layer("alpha_tilde >= 0").definitions["signal"]},
                                                    hypotheses=("g > 0",))),
                  Algebra("evidence", "if alpha is below its estimate in the layer, hence below alpha_l, the inequality is reversed",
                          (same("projection-inequality.inequality", "(xi_2_hat - (1 + beta*L_m)*i_ds)",
                                "(xi_2_hat - (1 + beta*L_m)*i_qs)").replace("<=", ">="),),
                          squares=(("alpha_tilde*signal*p", "1"),), setting=in_the_layer("alpha_tilde <= 0"))),
          assumptions=("alpha >= alpha_l, which is not printed; in the layer then alpha_tilde >= 0",)),
    claim("sign-operator.inequality", "the term with the rate of omega_hat is at most zero", FAILS,
          lyapunov_13().extended("forwards", hypotheses=("omega > 0", "omega_hat > 0"), cases=({"direction": 1},)),
          printed=same("sign-operator.inequality", "-omega_dot", "-omega_hat_dot"), point=BREAKS_16, origin="paper",
          why="the text says why the term should be negative, and that reason does not hold",
          checks=(Algebra("evidence", "with (11), the term has the sign of a signal that changes sign; Sign(omega) makes |omega| of "
                          "omega and no more", ("-omega_hat_dot/omega_hat**2*omega/(2*k_2)*(z_1_tilde**2 + z_2_tilde**2)"
                                                " = -K_p*(direction*omega)*(-i_qs_hat*i_ds_tilde + i_ds_hat*i_qs_tilde"
                                                " + z_2_hat*i_ds_tilde - z_1_hat*i_qs_tilde)/(2*k_2*omega_hat**2)"
                                                "*(z_1_tilde**2 + z_2_tilde**2)",)),),
          note="Read with the rate of omega, as the scan has it, the term is zero, but then it is not the term of the derivative.",
          consequences=("eq16.bound", "proposition-IV.2")),
    claim("eq16.bound", "the bound on the derivative of V", FAILS,
          lyapunov_13().extended("forwards_16", hypotheses=("omega > 0", "omega_hat > 0"), cases=({"direction": 1},)),
          point=BREAKS_16, origin="paper", why="follows from the claim on the sign operator, which fails",
          checks=(Algebra("evidence", "the derivative of V, complete, for the law (11) with or without its sign", (_RATE_V,),
                          setting=lyapunov_13()),
                  Algebra("evidence", "in the state shown, V grows: its rate is above zero, not only above the bound", ("V_dot = 6",),
                          setting=lyapunov_13().extended("breaks_16", cases=(BREAKS_16,)))),
          assumptions=("everything else corrected: the feedback that (12) needs, alpha/(2 k_3), omega > 0 and omega_hat > 0",),
          note="Take all parameters and gains 1, omega = omega_hat = 1, i_ds_tilde = 1, z_1_tilde = 4, z_2 = z_2_hat = -1, all else 0. "
          "Then omega_hat' = -1, and V' = -2 + 16/2 = 6, where (16) allows -2. It holds where omega_hat stands still.",
          trajectories=(Trajectory("lyapunov-grows", "V rises although omega is constant and nothing else is wrong",
                                   "python derivations/06_what_breaks_and_the_repairs.py"),),
          consequences=("eq17.integral", "bounded-from-16", "proposition-IV.2")),
    claim("bounded-from-16", "(16) bounds all errors", CORRECTED,
          lyapunov_13().extended("no_error", f"{lyapunov_13().text}, where no error is left", cases=(_NO_ERROR,)),
          printed="V_dot < 0", corrected="V_dot <= 0", edit="V(t) <= V(0) for V(t) < V(0)", origin="paper",
          why="at zero error V does not fall", mutate=False,
          checks=(Algebra("evidence", "V bounds the current errors", ("i_ds_tilde**2 <= 2*V",), setting=_same_signs(),
                          squares=(("1", "i_qs_tilde"), ("omega/(k_2*omega_hat)", "z_1_tilde"), ("omega/(k_2*omega_hat)", "z_2_tilde"),
                                   *_SMALL)),
                  Algebra("evidence", "and the z errors, by a bound that moves with omega_hat",
                          ("omega/(k_2*omega_hat)*z_1_tilde**2 <= 2*V",), setting=_same_signs(),
                          squares=(("1", "i_ds_tilde"), ("1", "i_qs_tilde"), ("omega/(k_2*omega_hat)", "z_2_tilde"), *_SMALL))),
          assumptions=("(16), which fails for this V and holds for the repairs", "omega omega_hat > 0 all along"),
          note="alpha_tilde and omega_tilde are bounded with the others, though the text does not list them."),
    claim("eq17.integral", "(16), integrated", FAILS,
          lyapunov_13().extended("forwards_17", hypotheses=("omega > 0", "omega_hat > 0"), cases=({"direction": 1},)),
          printed=f"-V_dot >= -({BOUND})", point=BREAKS_16, prose="The integrands, which (17) compares over every interval from 0.",
          note="It is (16) integrated, no more and no less. From the state shown it fails for small t, because both integrands are "
          "continuous; it holds for each repair.", consequences=("eq18.integral",), origin="paper", why="follows from (16)", mutate=False),
    claim("eq18.integral", "a bound on the integral of the squared current error", CORRECTED, integrals(),
          printed="integral <= (k_1 + R_s/sigma)*V_0", corrected="integral <= V_0/(k_1 + R_s/sigma)",
          squares=(("slack/(k_1 + R_s/sigma)", "1"), ("V_t/(k_1 + R_s/sigma)", "1")),
          edit="divide by k_1 + R_s/sigma", origin="paper", why="the factor is clear in the scan",
          units="A^2 s on the left, A^2/s on the right", assumptions=("(17)", "V(t) >= 0"),
          note="With numbers in SI the printed bound is the weaker one as long as k_1 + R_s/sigma is 1/s or more, as in every run here. "
          "What is concluded, that the integral has a limit, stands: it grows and is bounded."),
    claim("lemma-IV.1", "Barbalat's lemma", HOLDS, _triangle(),
          checks=(Algebra("reading", "the heart of it: where f reaches e and is never steeper than M, its graph holds a triangle, so "
                          "that every such time adds at least e^2/(2 M) to the integral and it cannot settle",
                          ("e*(e/M) - M*(e/M)**2/2 = e**2/(2*M)",)),),
          prose="A uniformly continuous f whose integral has a finite limit tends to zero.",
          note="The domain is to be read as [0, infinity): on the printed [0, infinity] a uniformly continuous f has a limit anyway. The "
          "general statement is Khalil, Nonlinear Systems, Lemma 8.2; f is Lipschitz where it is used here."),
    claim("barbalat-step", "the current errors tend to zero", HOLDS, lyapunov_13(),
          checks=(Algebra("reading", "the rate of the squared current error has bounded terms only, so it is uniformly continuous",
                          ("2*(i_ds_tilde*i_ds_tilde_dot + i_qs_tilde*i_qs_tilde_dot) = 2*(part_current + part_rho_1 + part_rho_2"
                           " + part_rho_3)",), setting=_T),),
          assumptions=("(16) and the bounds that follow from it", "i, phi and omega of the machine bounded"),
          consequences=("proposition-IV.2",)),
    claim("proposition-IV.2", "current errors vanish, all errors stay bounded", CORRECTED, repaired(),
          checks=(Algebra("printed", "the bound that its proof rests on", (printed("eq16.bound"),), point=BREAKS_16,
                          setting=lyapunov_13().extended("forwards_IV2", hypotheses=("omega > 0", "omega_hat > 0"), cases=({"direction": 1},))),
                  Algebra("corrected", "with the direction in the z loop, the derivative is exactly this, for both directions and "
                          "wherever omega_hat goes", (f"V_dot = {BOUND}",))),
          edit="in (8), kappa s (-i_qs_tilde, +i_ds_tilde) in the z rows, s = sgn(omega), in place of k_2 omega_hat; in (11), no "
          "Sign(omega); in V, |omega|/(2 kappa) and alpha/(2 k_3)", origin="paper",
          why="the proof drops the term in the rate of omega_hat for a reason that does not hold",
          assumptions=("omega and alpha constant, omega not zero", "i and phi of the machine bounded", "alpha >= alpha_l"),
          note="What falls as printed: with the z rows of (8), and with L(omega_hat), the frozen error dynamics have growing solutions "
          "(eq8.z_1, eq8.L); for omega < 0 the law (11) has the wrong sign; and with all that put right, V can still grow. Whether the "
          "statement then holds without a further edit is open; near zero error it does under excitation (repair-4). With the "
          "edit, the rest of the proof goes through: V' <= 0 bounds the errors, and Barbalat's lemma does the rest.",
          trajectories=(Trajectory("fig1", "the three printed observers and the repaired one on the paper's own scenario", "imo simulate"),),
          consequences=("proposition-IV.3", "proposition-IV.4")),
]
