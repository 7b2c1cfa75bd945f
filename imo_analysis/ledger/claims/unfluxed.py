"""The errors near zero of a machine without flux: i = z = u = 0, omega and alpha constant, the adaptation running.

There the laws (9) and (11) are of second order in the errors, because what they multiply with is itself an error. So their
gains do not appear in the linear part, and where that grows, zero error is unstable for all g, K_p > 0 (Lyapunov's indirect
method; Khalil, Nonlinear Systems, Theorem 4.7; the error dynamics are autonomous there).
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache

from imo_analysis.ledger.claim import Algebra
from imo_analysis.ledger.claims.situations import ERRORS
from imo_analysis.ledger.dual import Dual
from imo_analysis.ledger.expression import Name, as_expr, evaluate
from imo_analysis.ledger.setting import Setting
from imo_analysis.ledger.settings import errors

_STILL = ("i_ds", "i_qs", "z_1", "z_2", "u_ds", "u_qs")

# Small numbers in which every rate of the linear part is a rational multiple of a state. Every gain is above zero.
_GROWS_7: dict[str, int | str] = {
    "R_s": "1/8", "sigma": 1, "k_1": "1/8", "alpha": "1/2", "k_3": "1/2", "k_2": "5/8", "omega": 2, "direction": 1,
    "i_ds_tilde": 3, "i_qs_tilde": -1, "z_1_tilde": "15/4", "z_2_tilde": "5/4", "xi_1_tilde": "-3/2", "xi_2_tilde": "1/2",
}
_GROWS_L: dict[str, int | str] = {
    "R_s": "1/4", "sigma": 1, "k_1": "1/4", "alpha": 5, "k_3": 1, "k_2": "1/2", "omega": 5, "direction": 1,
    "i_ds_tilde": 1, "i_qs_tilde": 0, "z_1_tilde": 1, "z_2_tilde": "1/2", "xi_1_tilde": "-1/5", "xi_2_tilde": "2/5",
}
_GROWTH_7 = tuple(f"{one}_linear = {one}" for one in ERRORS[:6])
_GROWTH_L = tuple(
    text for d, q in (ERRORS[0:2], ERRORS[2:4], ERRORS[4:6])
    for text in (f"{d}_linear = {d} - 2*{q}", f"{q}_linear = 2*{d} + {q}")
)
SECOND_ORDER = ("alpha_tilde_linear = 0", "omega_tilde_linear = 0")
_QUADRATIC = (
    "alpha_tilde_dot = g*(xi_1_tilde*i_ds_tilde + xi_2_tilde*i_qs_tilde)",
    "omega_tilde_dot = K_p*direction*(z_2_tilde*i_ds_tilde - z_1_tilde*i_qs_tilde)",
)


@cache
def unfluxed(observer: str) -> Setting:
    """`errors` of a machine without current, flux and voltage, with the linear part of every rate as ``*_tilde_linear``.

    The linear part at zero error is the derivative along the errors themselves, by dual numbers through the traced rates.
    """
    base = errors(observer)
    still = base.extended(f"unfluxed_{observer}", f"{base.text}; i = z = u = 0", dict.fromkeys(_STILL, as_expr(0)),
                          ("k_1 > 0", "k_2 > 0", "k_3 > 0", "g > 0", "K_p > 0", "alpha > 0", "R_s > 0", "omega != 0"))
    known: dict[str, Dual] = {}

    def near_zero(name: str) -> Dual:
        if name in ERRORS:
            return Dual(as_expr(0), Name(name))
        if name not in still.definitions:
            return Dual(Name(name))
        if name not in known:
            known[name] = evaluate(still.definitions[name], near_zero, lambda value: Dual(as_expr(value)))
        return known[name]

    return still.extended(still.name, definitions={f"{one}_linear": as_expr(near_zero(f"{one}_dot").rate) for one in ERRORS})


def growing(feedback: str) -> tuple[Algebra, Algebra, Algebra]:
    """That zero error is unstable with a z feedback as printed, ``7`` for (7) and the expanded (8), ``L`` for the matrix.

    Raises
    ------
    KeyError
        For another feedback.
    """
    numbers, growth, words = {
        "7": (_GROWS_7, _GROWTH_7, "grows as exp(t)"), "L": (_GROWS_L, _GROWTH_L, "grows as exp(t) while it turns at 2 rad/s"),
    }[feedback]
    listed = ", ".join(f"{name} = {value}" for name, value in numbers.items())
    where = unfluxed(f"printed_{feedback}")
    in_numbers = where.extended(f"grows_{feedback}", f"{where.text}; in the numbers shown, for all g, K_p > 0",
                                cases=({name: Fraction(value) for name, value in numbers.items()},))
    return (
        Algebra("evidence", "in a machine without flux (i = z = 0) the laws (9) and (11) are of second order in the errors",
                _QUADRATIC, setting=where),
        Algebra("evidence", "so that nothing of them is left in the linear part, whatever g and K_p are", SECOND_ORDER,
                setting=where),
        Algebra("evidence", f"the linear part, as printed, has a solution that {words}, at {listed}: there zero error is "
                "unstable for all g, K_p > 0", (*growth, *SECOND_ORDER), setting=in_numbers),
    )
