"""Error dynamics together with a Lyapunov function: V, its derivative, w and q as names that claims can use."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from inspect import signature
from typing import Any

from imo_analysis.equations import adaptive, excitation, lyapunov
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Expr, Name, names, parse
from imo_analysis.ledger.setting import Setting
from imo_analysis.ledger.settings import CURRENTS, errors

ERRORS = ("i_ds_tilde", "i_qs_tilde", "z_1_tilde", "z_2_tilde", "xi_1_tilde", "xi_2_tilde", "alpha_tilde", "omega_tilde")
POSITIVE = ("R_s > 0", "k_1 > 0", "k_3 > 0", "g > 0", "K_p > 0", "alpha > 0")
BOUND = "-(k_1 + R_s/sigma)*(i_ds_tilde**2 + i_qs_tilde**2)"

# All parameters and gains 1, speed and its estimate 1, no error but 1 A in the d current and 4 A in z_1.
BREAKS_16 = {
    **dict.fromkeys(("R_s", "L_m", "sigma", "beta", "alpha", "k_1", "k_2", "k_3", "g", "K_p", "omega", "direction"), 1),
    **dict.fromkeys((*ERRORS, "i_ds", "i_qs", "z_1", "z_2", "u_ds", "u_qs"), 0),
    "i_ds_tilde": 1,
    "z_1_tilde": 4,
    "z_2": -1,
}


def with_function(function: Callable[..., Any], moving: tuple[str, ...]) -> dict[str, Expr]:
    """``V`` and ``V_dot`` of a plain function of names, along the rates of the names that move."""
    values = {name: Name(name) for name in signature(function).parameters}
    return {"V": function(**values), "V_dot": rate_along(function, values, {one: Name(f"{one}_dot") for one in moving})}


@cache
def lyapunov_13() -> Setting:
    """The observer that (12) needs, with V of (13), its weight of xi put right; speeds away from zero."""
    base = errors("consistent_12")
    return base.extended(
        "lyapunov_13",
        f"{base.text}; V of (13) with alpha/(2 k_3)",
        with_function(lyapunov.corrected_13, (*ERRORS, "omega_hat")),
        (*POSITIVE, "k_2 > 0", "omega_hat != 0", "omega != 0"),
    )


def _observable() -> dict[str, Any]:
    """w, its rate, and the directions v_1, v_2 in which the errors of alpha and omega act on the currents."""
    z, xi = ERRORS[2:4], ERRORS[4:6]
    w = lyapunov.observable(*names(*z), *names(*xi), *names("alpha omega"))
    rates = [
        rate_along(
            lambda which=which, **q: lyapunov.observable(**q)[which],
            {name: Name(name) for name in (*z, *xi, "alpha", "omega")},
            {name: Name(f"{name}_dot") for name in (*z, *xi)},
        )
        for which in (0, 1)
    ]
    v_1 = excitation.alpha_direction(CURRENTS, names("xi_1_hat xi_2_hat"), *names("beta L_m"))
    v_2 = excitation.speed_direction(names("i_ds_hat i_qs_hat"), names("z_1_hat z_2_hat"))
    return {
        "w_1": w[0],
        "w_2": w[1],
        "w_1_dot": rates[0],
        "w_2_dot": rates[1],
        "v_11": v_1[0],
        "v_12": v_1[1],
        "v_21": v_2[0],
        "v_22": v_2[1],
        "signal": adaptive.speed_signal(names("i_ds_tilde i_qs_tilde"), names("i_ds_hat i_qs_hat"), names("z_1_hat z_2_hat")),
    }


UNITS = {
    "w_1": "A/s",
    "w_2": "A/s",
    "w_1_dot": "A/s^2",
    "w_2_dot": "A/s^2",
    "v_11": "A",
    "v_12": "A",
    "v_21": "A",
    "v_22": "A",
    "q_1": "A/s",
    "q_2": "A/s",
    "signal": "A^2",
    "V_dot": "A^2/s",
    "strength": "1/s^2",
    "strength_dot": "1/s^3",
    "kappa_dot": "1/s^2",
}


@cache
def observable(observer: str = "consistent_12") -> Setting:
    """An observer's error dynamics with w = alpha xi_tilde - j omega z_tilde, v_1 and v_2."""
    base = errors(observer)
    return base.extended(
        f"observable_{observer}", f"{base.text}; w = alpha xi_tilde - j omega z_tilde", _observable(), (*POSITIVE,), units=UNITS
    )


@cache
def repaired(name: str = "repaired_V", kappa_dot: bool = False, kappa: str = "kappa > 0") -> Setting:
    """The repaired observer with V of `equations.lyapunov.with_direction`, w, and q with its rate.

    ``kappa_dot`` lets the gain move; s omega > 0 is what the direction means.
    """
    base = observable("repaired")
    defined: dict[str, Any] = with_function(lyapunov.with_direction, (*ERRORS, *(("kappa",) if kappa_dot else ())))
    q = lyapunov.conserved(*names(*ERRORS[2:6]), *names("kappa k_3 direction"))
    rates = lyapunov.conserved(*(Name(f"{one}_dot") for one in ERRORS[2:6]), *names("kappa k_3 direction"))
    defined |= {"q_1": q[0], "q_2": q[1], "q_1_dot": rates[0], "q_2_dot": rates[1]}
    text = "the repaired observer, kappa moving" if kappa_dot else "the repaired observer, kappa constant"
    return base.extended(
        name,
        f"{text}; s = direction, s omega > 0; omega and alpha constant, omega_hat and alpha_hat free",
        defined,
        (kappa, "direction*omega > 0"),
        units={"q_1_dot": "A/s^2", "q_2_dot": "A/s^2", "kappa_dot": "1/s^2"},
    )


def constant_observable(
    observer: str, strength: str, name: str, hypotheses: tuple[str, ...], strength_dot: Expr | None = None, cases: Any = None
) -> Setting:
    """V of the observable errors alone, with the strength c of w' = -c i_tilde given as a formula."""
    base = observable(observer)
    moving = (
        "i_ds_tilde",
        "i_qs_tilde",
        "w_1",
        "w_2",
        "alpha_tilde",
        "omega_tilde",
        *(("strength",) if strength_dot is not None else ()),
    )
    defined: dict[str, Any] = {"strength": parse(strength)}
    if strength_dot is not None:
        defined["strength_dot"] = strength_dot
    defined |= with_function(lyapunov.reduced, moving)
    return base.extended(
        name, f"{base.text}; V of the observable errors (i, w, alpha, omega)", defined, hypotheses, cases, UNITS
    )
