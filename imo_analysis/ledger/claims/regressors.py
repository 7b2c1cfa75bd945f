"""What (19)-(23) speak about: B* and the direction it does not see, a speed that moves, the regressors of a steady flux."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import cache
from typing import Any

from imo_analysis.equations import excitation, transformation
from imo_analysis.ledger.claims.model import first_principles
from imo_analysis.ledger.claims.situations import UNITS, observable
from imo_analysis.ledger.expression import Expr, Name, as_expr, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS

ARGUMENTS = (
    CURRENTS,
    names("i_ds_hat i_qs_hat"),
    names("z_1_hat z_2_hat"),
    names("xi_1_hat xi_2_hat"),
    *names("alpha omega beta L_m"),
)
ORDER = ("xi_1_tilde", "xi_2_tilde", "z_1_tilde", "z_2_tilde", "alpha_tilde", "omega_tilde")


def _product(row: Iterable[Any], vector: Iterable[Any]) -> Expr:
    total: Any = 0
    for entry, value in zip(row, vector, strict=True):
        total = as_expr(entry) * value + total
    return as_expr(total)


def products(prefix: str, rows: Iterable[Iterable[Any]], vector: Iterable[Any]) -> dict[str, Expr]:
    """Rows times a vector of names, under ``prefix_1``, ``prefix_2``, ..."""
    vector = tuple(vector)
    return {f"{prefix}_{number}": _product(row, vector) for number, row in enumerate(rows, 1)}


@cache
def compact() -> Setting:
    """The error dynamics with the products B* Z, as printed and corrected, and [I, v_1, v_2] (w, alpha_tilde, omega_tilde)."""
    base = observable()
    z, w = names(*ORDER), names("w_1 w_2 alpha_tilde omega_tilde")
    return base.extended(
        "compact",
        base.text,
        {
            **products("printed_BZ", excitation.printed_19(*ARGUMENTS), z),
            **products("BZ", excitation.corrected_19(*ARGUMENTS), z),
            **products("reduced", excitation.reduced(*ARGUMENTS), w),
        },
        ("omega != 0",),
        units={**UNITS, **{f"{one}_{n}": "A/s" for one in ("printed_BZ", "BZ", "reduced") for n in (1, 2)}},
    )


@cache
def null_space() -> Setting:
    """B* times the errors that it does not see: any z_tilde = (a, b), with alpha xi_tilde = j omega z_tilde."""
    a, b, alpha, omega = names("a b alpha omega")
    unseen = (-omega * b, omega * a, alpha * a, alpha * b, as_expr(0), as_expr(0))
    return setting(
        "null_space",
        "B* at any time, omega and alpha constant, applied to Z = (-omega b, omega a, alpha a, alpha b, 0, 0)",
        {
            **products("BZ", excitation.corrected_19(*ARGUMENTS), unseen),
            **products("printed_BZ", excitation.printed_19(*ARGUMENTS), unseen),
            "length": _product(unseen, unseen),
        },
        ("alpha > 0", "m > 0", "T > 0", "a**2 + b**2 > 0"),
        units={
            "a": "A s",
            "b": "A s",
            "length": "A^2",
            **{f"{one}_{n}": "A/s" for one in ("BZ", "printed_BZ") for n in (1, 2)},
        },
    )


@cache
def at_rest() -> Setting:
    """The observer that (12) needs, all errors zero but z_tilde, and xi_tilde where alpha xi_tilde = j omega z_tilde."""
    base = observable()
    alpha, omega = names("alpha omega")
    defined = {"xi_1_tilde": -omega * Name("z_2_tilde") / alpha, "xi_2_tilde": omega * Name("z_1_tilde") / alpha}
    quiet = dict.fromkeys(("i_ds_tilde", "i_qs_tilde", "alpha_tilde", "omega_tilde"), 0)
    return setting(
        "at_rest",
        "only z_tilde, and the xi_tilde that balances it, are not zero",
        {**defined, **base.definitions},
        base.hypotheses,
        ({**quiet, "direction": 1}, {**quiet, "direction": -1}),
        UNITS,
    )


def moving_speed(
    observer: str, cases: Iterable[Mapping[str, int | Fraction]] = ({"direction": 1}, {"direction": -1})
) -> Setting:
    """An observer's error dynamics with w, while the speed of the machine moves at a free rate omega_dot."""
    base = observable(observer)
    kept = {name: tree for name, tree in base.definitions.items() if name not in ("omega_dot", "w_1_dot", "w_2_dot")}
    kept["w_1_dot"] = (
        Name("alpha") * Name("xi_1_tilde_dot") + Name("omega") * Name("z_2_tilde_dot") + Name("omega_dot") * Name("z_2_tilde")
    )
    kept["w_2_dot"] = (
        Name("alpha") * Name("xi_2_tilde_dot") - Name("omega") * Name("z_1_tilde_dot") - Name("omega_dot") * Name("z_1_tilde")
    )
    return setting(
        f"moving_speed_{observer}",
        f"{base.text.replace('omega and alpha constant', 'alpha constant')}; the speed moves",
        kept,
        base.hypotheses,
        cases,
        UNITS,
    )


@cache
def true_regressors() -> Setting:
    """v_1 and v_2 of the machine itself, where no error is left."""
    base = first_principles()
    z = names("z_1 z_2")
    v_1 = excitation.alpha_direction(CURRENTS, z, *names("beta L_m"))
    v_2 = excitation.speed_direction(CURRENTS, z)
    return setting(
        "true_regressors",
        "the machine (1) in the stationary frame; v_1 and v_2 without errors",
        {**base.definitions, "v_11": v_1[0], "v_12": v_1[1], "v_21": v_2[0], "v_22": v_2[1]},
        (*base.hypotheses, "R_r > 0"),
        ({"omega_1": 0},),
        UNITS,
    )


@cache
def steady_flux() -> Setting:
    """A flux of constant magnitude that turns at the stator frequency; the rotor's equation then gives the currents."""
    phi_dr, phi_qr, alpha, L_m, beta, slip = names("phi_dr phi_qr alpha L_m beta slip")
    i = ((alpha * phi_dr - slip * phi_qr) / (alpha * L_m), (alpha * phi_qr + slip * phi_dr) / (alpha * L_m))
    z = transformation.to_z(i[0], i[1], phi_dr, phi_qr, beta)
    v_1, v_2 = excitation.alpha_direction(i, z, beta, L_m), excitation.speed_direction(i, z)
    omega = Name("stator_frequency") - slip
    return setting(
        "steady_flux",
        "a flux of constant magnitude that turns at the stator frequency, slip = stator_frequency - omega, no errors",
        {
            "i_ds": i[0],
            "i_qs": i[1],
            "v_11": v_1[0],
            "v_12": v_1[1],
            "v_21": v_2[0],
            "v_22": v_2[1],
            "rest_d": alpha * L_m * i[0] - alpha * phi_dr - omega * phi_qr + Name("stator_frequency") * phi_qr,
            "rest_q": alpha * L_m * i[1] - alpha * phi_qr + omega * phi_dr - Name("stator_frequency") * phi_dr,
        },
        ("alpha > 0", "L_m > 0"),
        units=UNITS,
    )


# The areas that v_1 and v_2 span, and their ratio in the steady state.
COLLINEAR = ("alpha*(v_11*v_22 - v_12*v_21) = beta**2*(phi_dr*phi_dr_dot + phi_qr*phi_qr_dot)",)
STEADY = ("rest_d = 0", "rest_q = 0", "alpha*v_11 = slip*v_21", "alpha*v_12 = slip*v_22")
