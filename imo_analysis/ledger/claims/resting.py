"""Why alpha_hat stops where it does: what a build-up of the flux leaves, the rest states, the balance that the laws keep, and
the drift of a speed change.

These statements are ours; they explain the paper's Fig. 4. Errors are those of (12), alpha and omega constant.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from imo_analysis.equations import drift, plant, steady_state, transformation
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Name, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import MACHINE, VOLTAGES, errors

ITEM = "Rest states (ours)"
_UNITS = {"flux_d": "Wb", "flux_q": "Wb", "psi": "Wb", "balance_dot": "A^2", "flux_error_d": "Wb", "flux_error_q": "Wb",
          "drift_rate": "1", "omega_hat_at_rest": "rad/s", "psi_dot": "V", "v_1": "A", "w": "1/s", "n": "1", "before": "1",
          "v_0": "A", "p_i": "1/(A s)", "p_w": "1/A", "p_a": "1"}


@cache
def constant_flux(observer: str, unloaded: bool = False) -> Setting:
    """`errors` at constant flux magnitude: i = (1 + j slip/alpha) phi / L_m, as the rotor rows of (1) need it."""
    d, q = names("flux_d flux_q")
    slip: Any = 0 if unloaded else Name("slip")
    along, across = steady_state.current_of_flux(1, 0, slip, Name("alpha"), Name("L_m"))
    current = (along * d - across * q, along * q + across * d)
    z = transformation.to_z(current[0], current[1], d, q, Name("beta"))
    base = errors(observer)
    motion = {"i_ds": current[0], "i_qs": current[1], "z_1": z[0], "z_2": z[1], **({"slip": 0} if unloaded else {})}
    kappa_s = (Name("kappa") if observer == "repaired" else Name("k_2") * Name("omega_hat")) * Name("direction")
    defined = {**motion, **base.definitions}
    xi, z_tilde = names("xi_1_tilde xi_2_tilde"), names("z_1_tilde z_2_tilde")

    def value(alpha_hat: Any, omega_hat: Any, x1: Any, x2: Any, z1: Any, z2: Any, slip: Any, alpha: Any,
              g: Any, K_p: Any, k_3: Any, kappa_s: Any) -> Any:
        return drift.balance(alpha_hat, omega_hat, (x1, x2), (z1, z2), slip, alpha, (g, K_p, k_3, kappa_s))

    moving = {"alpha_hat": "alpha_hat", "omega_hat": "omega_hat", "x1": xi[0].name, "x2": xi[1].name,
              "z1": z_tilde[0].name, "z2": z_tilde[1].name}
    still = {"slip": slip, "alpha": Name("alpha"), "g": Name("g"), "K_p": Name("K_p"), "k_3": Name("k_3"), "kappa_s": kappa_s}
    defined["balance_dot"] = rate_along(value, {**{k: Name(v) for k, v in moving.items()}, **still},
                                        {k: Name(f"{v}_dot") for k, v in moving.items()})
    defined["drift_rate"] = drift.drift_rate(slip, *names("alpha g K_p"))
    hypotheses = ("alpha > 0", "L_m > 0", "sigma > 0", "beta > 0", "g > 0", "K_p > 0", "k_3 > 0", "kappa > 0", "direction != 0")
    return setting(f"constant_flux_{observer}{'_idle' if unloaded else ''}",
                   base.text + ", constant flux magnitude" + (", no load" if unloaded else ""), defined, hypotheses,
                   base.cases, _UNITS)


@cache
def at_rest(observer: str) -> Setting:
    """`constant_flux` with zero current error and the other errors on the family of rest states."""
    base = constant_flux(observer)
    omega, slip, alpha, alpha_tilde = names("omega slip alpha alpha_tilde")
    omega_hat, xi = drift.rest(alpha - alpha_tilde, names("z_1_tilde z_2_tilde"), omega, slip, alpha)
    tildes = {"i_ds_tilde": 0, "i_qs_tilde": 0, "omega_tilde": omega - omega_hat, "xi_1_tilde": xi[0], "xi_2_tilde": xi[1]}
    defined: dict[str, Any] = {**tildes, **base.definitions}
    i_d, i_q, *hats = names("i_ds i_qs z_1_hat z_2_hat xi_1_hat xi_2_hat alpha_hat omega_hat")
    z_1, z_2, xi_1, xi_2, alpha_hat, speed = hats
    flux = transformation.reconstructed_flux(i_d, i_q, z_1, z_2, xi_1, xi_2, alpha_hat, speed, Name("beta"))
    defined |= {"flux_error_d": Name("flux_d") - flux[0], "flux_error_q": Name("flux_q") - flux[1]}
    defined.pop("balance_dot")
    hypotheses: tuple[Any, ...] = (*base.hypotheses, "alpha - alpha_tilde > 0", "alpha_hat > 0")
    return setting(f"at_rest_{observer}", base.text + ", on the family of rest states", defined, hypotheses, base.cases, _UNITS)


@cache
def no_copies(observer: str) -> Setting:
    """`constant_flux` with z_hat and xi_hat exact."""
    base = constant_flux(observer)
    zero = dict.fromkeys(("xi_1_tilde", "xi_2_tilde", "z_1_tilde", "z_2_tilde"), 0)
    defined = {**zero, **base.definitions}
    defined.pop("balance_dot")
    text = base.text + ", z_hat and xi_hat exact"
    return setting(f"exact_copies_{observer}", text, defined, base.hypotheses, base.cases, _UNITS)


@cache
def turning_shaft() -> Setting:
    """The speed row of (1) in the frame of a constant rotor flux."""
    psi, slip, omega, alpha, L_m = names("psi slip omega alpha L_m")
    current = steady_state.current_of_flux(psi, 0, slip, alpha, L_m)
    rates = plant.plant((*current, psi, 0, omega), VOLTAGES, omega + slip, Name("T_l"), (*MACHINE, *names("mu n_p J")))
    return setting("turning_shaft", "the speed row of (1) at constant flux", {"omega_dot": rates[4]},
                   ("alpha > 0", "L_m > 0", "J > 0", "mu > 0", "psi > 0"), units=_UNITS)


@cache
def build_up() -> Setting:
    """The paper's observer at standstill while the flux moves along its own axis; errors along the flux and of alpha alone."""
    base = errors("consistent_12")
    psi, psi_dot, alpha, beta = names("psi psi_dot alpha beta")
    current = steady_state.current_of_flux(psi, psi_dot, 0, alpha, Name("L_m"))
    z = transformation.to_z(current[0], current[1], psi, 0, beta)
    zero = dict.fromkeys(("omega", "omega_tilde", "i_qs_tilde", "z_1_tilde", "z_2_tilde", "xi_2_tilde"), 0)
    motion = {"i_ds": current[0], "i_qs": current[1], "z_1": z[0], "z_2": z[1]}
    v_1 = steady_state.regressors_of_flux(psi, psi_dot, 0, alpha, beta)[0][0]
    return setting("build_up", "the machine at standstill while the flux builds up, and the paper's observer with errors along "
                   "the flux alone", {**zero, **motion, **base.definitions, "v_1": v_1},
                   (*base.hypotheses, "alpha > 0", "L_m > 0"), base.cases, _UNITS)


@cache
def first_order() -> Setting:
    """The n-th term of the series in which what a first-order build-up leaves of an error of alpha_hat is summed."""
    n, before, w, alpha, beta, psi, g = names("n before w alpha beta psi g")
    damping = Name("k_1") + Name("R_s") / Name("sigma")
    swing = beta * psi / alpha
    term = before * drift.forgetting_ratio(n, g * swing * swing, damping / w, alpha * Name("k_3") / (w * w))
    p_i, p_w, p_a = drift.adjoint_term(n, term, w, Name("v_0"))
    return setting("first_order", "a term of the series for psi' = w psi exp(-w t), errors small",
                   {"v_0": swing * w, "p_i": p_i, "p_w": p_w, "p_a": p_a},
                   ("alpha > 0", "beta > 0", "psi > 0", "w > 0", "sigma > 0", "R_s > 0", "k_1 > 0", "k_3 > 0", "g > 0",
                    "n > 0", "2*n - 1 > 0"), units=_UNITS)


_REST = ("i_ds_tilde_dot = 0", "i_qs_tilde_dot = 0", "z_1_tilde_dot = 0", "z_2_tilde_dot = 0", "xi_1_tilde_dot = 0",
         "xi_2_tilde_dot = 0", "alpha_hat_dot = 0", "omega_hat_dot = 0")

CLAIMS = [
    Claim(
        id="resting.build_up", item=ITEM, title="what an error of alpha_hat meets while the flux builds up at standstill",
        expected=Verdict.HOLDS, setting=build_up(),
        prose="Along the flux v_1 = -beta psi'/alpha. It lets alpha_hat follow the current error, and the same current error "
              "moves xi_hat by k_3: with alpha_hat xi_tilde that acts on the current as alpha_tilde v_1 does.",
        printed=("i_ds_tilde_dot = v_1*alpha_tilde + alpha_hat*xi_1_tilde - (k_1 + R_s/sigma)*i_ds_tilde",
                 "xi_1_tilde_dot = -k_3*i_ds_tilde", "alpha_hat_dot = g*(v_1 - xi_1_tilde)*i_ds_tilde", "i_qs_tilde_dot = 0",
                 "xi_2_tilde_dot = 0", "z_1_tilde_dot = 0", "z_2_tilde_dot = 0", "omega_hat_dot = 0"),
    ),
    Claim(
        id="resting.forgetting", item=ITEM, title="what a first-order build-up of the flux leaves of an error of alpha_hat",
        expected=Verdict.HOLDS, setting=first_order(),
        prose="With products of errors left out of resting.build_up and psi' = w psi exp(-w t), the sum p_i i_tilde + "
              "p_w alpha xi_tilde + p_a alpha_tilde is constant and ends as alpha_tilde. p_a is a series in exp(-2 w t) that "
              "starts with 1, of which this is the n-th term beside the one before; its sum at time 0 is the share of the "
              "error that is left.",
        printed=("(1 - 2*n)*w*p_i = (k_1 + R_s/sigma)*p_i + alpha*k_3*p_w - g*v_0*before", "(1 - 2*n)*w*p_w = -p_i",
                 "-2*n*w*p_a = v_0*p_i"),
    ),
    Claim(
        id="resting.family", item=ITEM, title="a family of three dimensions on which everything measured is right",
        expected=Verdict.HOLDS, setting=at_rest("consistent_12"),
        prose="At constant flux, speed and slip every alpha_hat is a rest state, with omega_tilde = -(slip/alpha) alpha_tilde "
              "and alpha_hat xi_tilde = j omega_hat z_tilde, z_tilde free: the current error stays zero.",
        printed=_REST, checks=(Algebra("evidence", "the same for the repaired observer", _REST, setting=at_rest("repaired")),),
    ),
    Claim(
        id="resting.flux", item=ITEM, title="at rest the reconstructed flux is exact, however wrong alpha_hat is",
        expected=Verdict.HOLDS, setting=at_rest("consistent_12"),
        prose="On the family of rest states the flux reconstructed below (11) equals the true flux.",
        printed=("flux_error_d = 0", "flux_error_q = 0"),
        assumptions=("alpha_hat^2 + omega_hat^2 > 0",),
    ),
    Claim(
        id="resting.drift", item=ITEM, title="at constant flux alpha_hat moves only together with omega_hat",
        expected=Verdict.HOLDS, setting=no_copies("repaired"),
        prose="With z_hat and xi_hat exact and the flux magnitude constant, d alpha_hat = (g/K_p) (slip/alpha) d omega_hat, "
              "whatever the current error is.",
        printed=("alpha_hat_dot = drift_rate*omega_hat_dot",),
        checks=(Algebra("evidence", "the paper's observer, with its sign",
                        ("alpha_hat_dot = drift_rate*direction*omega_hat_dot",), setting=no_copies("consistent_12")),),
    ),
    Claim(
        id="resting.slip", item=ITEM, title="slip is torque: an accelerating drive slips with its acceleration",
        expected=Verdict.HOLDS, setting=turning_shaft(),
        prose="At constant flux slip/alpha = L_m (omega' + n_p T_l/J) / (mu psi^2), so that without load slip d omega is a "
              "square: alpha_hat drifts upwards at every change of speed, up or down.",
        printed=("slip/alpha = L_m*(omega_dot + n_p*T_l/J)/(mu*psi**2)",),
    ),
    Claim(
        id="resting.balance", item=ITEM, title="what the laws conserve at constant flux and slip",
        expected=Verdict.HOLDS, setting=constant_flux("repaired"),
        prose="alpha_hat/g - |xi_tilde|^2/(2 k_3) - (slip/alpha) (omega_hat/K_p - |z_tilde|^2/(2 kappa s)) is constant in the "
              "repaired observer; without load alpha_hat/g - |xi_tilde|^2/(2 k_3) is constant in the paper's observer too.",
        printed=("balance_dot = 0",),
        checks=(Algebra("evidence", "the paper's observer without load",
                        ("alpha_hat_dot/g = (xi_1_tilde*xi_1_tilde_dot + xi_2_tilde*xi_2_tilde_dot)/k_3",),
                        setting=constant_flux("consistent_12", unloaded=True)),),
    ),
]
