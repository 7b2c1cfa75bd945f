"""No matrix that the paper prints gives Table II for any real gains: each printed form, each with its exact contradiction.

A real pencil with two complex pairs has ``(s^2 + a s + D_re)^2 + (omega s - D_im)^2`` as its characteristic polynomial when
each pair sums to ``-a + j omega`` and has the product ``D = D_re + j D_im``, as Table II's pairs do. Its coefficients give
the three back,

    a = c_3 / 2,   D_re = (c_2 - a^2 - omega^2) / 2,   D_im = (2 a D_re - c_1) / (2 omega),   c_0 = D_re^2 + D_im^2,

so a printed form is refuted when one of these, worked out from its definition with free gains, cannot take the values in the
intervals that the printed digits allow. Everything here is rational arithmetic; the matrices come from differentiating
`imo_analysis.equations`.

Two ways of reading (8) are tried. 'Expanded': rows as printed, with the measured current in the terms alpha (1 + beta L_m) i
and R_s/sigma i. 'Matrix': x_hat' = A(omega_hat) x_hat + B u + L (y - y_hat), with the estimated current in them; A itself is
lost in the scan. For (2)-(3) every real 4x2 gain matrix that does not change with speed is covered. Gains that may be any
function of speed are not refuted: with them any poles can be had at each speed (`baseline_gains_needed`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import Any

import sympy as sp

from imo_analysis.equations import parameters, plant
from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS
from imo_analysis.paper.tables import printed
from imo_analysis.pencils.interval import Interval, meet_all
from imo_analysis.pencils.jacobian import jacobian
from imo_analysis.pencils.table2_fit import COLUMNS, SPEEDS, Digits, Table, digits, product, sum_interval

# Table III, exactly, and its two values of alpha
R_S, L_M = printed("R_s"), printed("L_m")
L_S, L_R = L_M + printed("L_s - L_m"), L_M + printed("L_r - L_m")
SIGMA = parameters.leakage(L_S, L_M, L_R)
BETA = parameters.coupling(L_M, SIGMA, L_R)
ALPHAS = {"R_r/L_r": parameters.rotor_rate(printed("R_r"), L_R), "printed": printed("alpha")}

_SYMBOLS = {name: sp.Symbol(name, positive=True) for name in PARAMETERS}
_OMEGA = sp.Symbol("omega", real=True)


@dataclass(frozen=True)
class Refutation:
    """Why one printed form cannot give one column.

    Attributes
    ----------
    form : str
        The matrix, and how it is read.
    source : str
        Where the paper prints it.
    column : str
        ``proposed`` or ``baseline``.
    forced : str
        What the form forces on the poles whatever the real gains, proved from its definition.
    printed : dict of int to Interval
        What the printed digits give for that quantity, by speed in rad/s.
    alphas : tuple of str
        The values of alpha for which it is refuted; ``any`` where alpha does not matter.
    proved : bool
        Whether the contradiction is there. Computed, not asserted.
    """

    form: str
    source: str
    column: str
    forced: str
    printed: dict[int, Interval]
    alphas: tuple[str, ...]
    proved: bool


@dataclass(frozen=True)
class Invariants:
    """a, D_re, D_im and c_0 of a symbolic pencil."""

    a: Any
    D_re: Any
    D_im: Any
    c_0: Any


@cache
def invariants(matrix: Any) -> Invariants:
    """The invariants of a symbolic real matrix with four poles, or with six of which two are zero for all values."""
    *_, c_3, c_2, c_1, c_0 = _nonzero_coefficients(matrix)
    a = c_3 / 2
    D_re = (c_2 - a**2 - _OMEGA**2) / 2
    return Invariants(*(sp.cancel(e) for e in (a, D_re, (2 * a * D_re - c_1) / (2 * _OMEGA), c_0)))


@cache
def _nonzero_coefficients(matrix: Any) -> tuple[Any, ...]:
    """Coefficients of the characteristic polynomial, highest first, after dividing by the powers of s that it holds."""
    from sympy.polys.matrices import DomainMatrix

    domain_matrix = DomainMatrix.from_Matrix(matrix).to_field()
    coefficients = [domain_matrix.domain.to_sympy(c) for c in domain_matrix.charpoly()]
    while coefficients[-1] == 0:
        coefficients.pop()
    if len(coefficients) != 5:
        raise AssertionError(f"{len(coefficients) - 1} poles that are not zero for all values, and Table II has 4")
    return tuple(coefficients)


def expanded(name: str) -> Any:
    """The frozen-speed error matrix of an observer of the catalogue."""
    derived = jacobian(name, "frozen")
    n = len(derived.states)
    return derived.matrix[:n, :n].as_immutable()


@cache
def matrix_reading(name: str) -> Any:
    """A(omega_hat) - L C of an observer of (7) or (8), with the estimated current in every place where it has the current.

    A is the derivative of the rates with the innovation held at zero; L C is the rest, found from the feedback gains.
    """
    observer = OBSERVERS[name]
    estimate = [sp.Symbol(state, real=True) for state in observer.states]
    frozen = {"alpha_hat": _SYMBOLS["alpha"], "omega_hat": _OMEGA}
    x = tuple(frozen.get(state, symbol) for state, symbol in zip(observer.states, estimate, strict=True))
    kept = [k for k, state in enumerate(observer.states) if state not in frozen]
    gains = {gain: sp.Symbol(gain, real=True) for gain in observer.gains}
    innovation = sp.symbols("e_d e_q", real=True)
    u = sp.symbols("u_ds u_qs", real=True)
    p = tuple(_SYMBOLS.values())
    no_gain = dict.fromkeys(gains, sp.Integer(0)) | {gain: gains[gain] for gain in ("alpha_l", "delta") if gain in gains}
    free = observer.rates(x, (x[0], x[1]), u, 1, p, tuple(no_gain.values()))
    i = (x[0] + innovation[0], x[1] + innovation[1])
    fed = observer.rates(x, i, u, 1, p, tuple(gains.values()))
    unfed = observer.rates(x, i, u, 1, p, tuple(no_gain.values()))
    A = sp.Matrix([[sp.diff(free[r], estimate[c]) for c in kept] for r in kept])
    L = sp.Matrix([[sp.diff(fed[r] - unfed[r], e) for e in innovation] for r in kept])
    A[:, :2] -= L
    return A.as_immutable()


@cache
def baseline_any_gain() -> Any:
    """A'(omega) - L C' of (2)-(3), with all eight entries of the real 4x2 gain L free."""
    x = sp.symbols("i_ds i_qs phi_dr phi_qr", real=True)
    rates = plant.plant((*x, _OMEGA), (0, 0), 0, 0, (*_SYMBOLS.values(), 0, 0, 1))[:4]
    A = sp.Matrix([[sp.diff(rate, symbol) for symbol in x] for rate in rates])
    A[:, :2] -= sp.Matrix(4, 2, sp.symbols("L_11 L_12 L_21 L_22 L_31 L_32 L_41 L_42", real=True))
    return A.as_immutable()


def error_12_as_printed() -> Any:
    """The linear part of (12) with the sign that it prints in its second row: -omega i_ds_tilde for +omega i_ds_tilde."""
    A = expanded("consistent_12").as_mutable()
    A[1, 0] = -A[1, 0]
    return A.as_immutable()


def _same(one: Any, other: Any) -> bool:
    return bool(sp.cancel(one - other) == 0)


def _apart(intervals: dict[Any, Interval]) -> bool:
    return meet_all(list(intervals.values())) is None


def _slopes(values: dict[int, Interval]) -> dict[int, Interval]:
    """Slopes over omega^2 between neighbouring speeds, under the higher speed: equal for what is affine in omega^2."""
    return {high: (values[high] - values[low]) / (high * high - low * low) for low, high in pairwise(SPEEDS)}


@cache
def refutations() -> tuple[Refutation, ...]:
    """Every printed form against both columns."""
    return refuted()


def refuted(table: Table | None = None, source: str = "") -> tuple[Refutation, ...]:
    """Every printed form, or those that the paper prints in one place, against both columns of the paper's or another table."""
    chosen = [argue for argue, sources in _ARGUMENTS.items() if not source or source in sources]
    found = (one for column in COLUMNS for argue in chosen for one in argue(column, digits(column, table)))
    return tuple(one for one in found if not source or one.source == source)


def _real_part_constant(column: str, said: Digits) -> list[Refutation]:
    """(8) expanded with the z feedback of (7): D_re is alpha k_3; (7) read as a matrix: alpha R_s/sigma. Neither moves."""
    alpha, rho = _SYMBOLS["alpha"], _SYMBOLS["R_s"] / _SYMBOLS["sigma"]
    real = said.D_re
    found = []
    for form, source, matrix, value in (
        ("(8) expanded", "(8)", expanded("printed_7"), alpha * sp.Symbol("k_3", real=True)),
        ("(7) as a matrix equation", "(7)", matrix_reading("luenberger_printed_7"), alpha * rho),
    ):
        proved = _same(invariants(matrix).D_re, value) and _apart(real)
        found.append(Refutation(form, source, column, f"D_re = {value} at every speed", real, ("any",), proved))
    return found


def _imaginary_part_zero(column: str, said: Digits) -> list[Refutation]:
    """(8) expanded with L(omega_hat) or with (12)'s z feedback: D_im = 0."""
    imag = said.D_im
    return [
        Refutation(f"(8) expanded, z feedback of {where}", where, column, "D_im = 0", imag, ("any",),
                   _same(invariants(expanded(name)).D_im, 0) and not any(i.holds(0) for i in imag.values()))
        for name, where in (("printed_L", "L(omega_hat)"), ("consistent_12", "(12)"))
    ]


def _imaginary_part_of_12(column: str, said: Digits) -> list[Refutation]:
    """(12) with its printed signs: D_im = -a omega."""
    form = invariants(error_12_as_printed())
    rate = {omega: -imag / omega for omega, imag in said.D_im.items()}
    proved = _same(form.D_im, -form.a * _OMEGA) and all(r.meet(said.a) is None for r in rate.values())
    return [Refutation("(12) with its printed signs", "(12)", column, "-D_im / omega = a", rate, ("any",), proved)]


def _stator_rate(column: str, said: Digits) -> list[Refutation]:
    """(8) read as a matrix equation: -D_im / omega is R_s/sigma, which Table III gives."""
    rho = _SYMBOLS["R_s"] / _SYMBOLS["sigma"]
    rate = {omega: -imag / omega for omega, imag in said.D_im.items()}
    return [
        Refutation(
            f"(8) as a matrix equation, z feedback of {where}", "(8)", column,
            f"-D_im / omega = R_s/sigma = {float(R_S / SIGMA):.4f} /s", rate, ("any",),
            _same(invariants(matrix_reading(name)).D_im, -_OMEGA * rho)
            and not any(r.holds(R_S / SIGMA) for r in rate.values()))
        for name, where in (("printed_7", "(7)"), ("printed_L", "L(omega_hat)"), ("consistent_12", "(12)"))
    ]


def _luenberger(column: str, said: Digits) -> list[Refutation]:
    """(7) expanded: c_0 = -+(alpha^2 + omega^2) (k_2 omega)^2."""
    alpha, k_2 = _SYMBOLS["alpha"], sp.Symbol("k_2", real=True)
    c_0 = said.c_0
    found = []
    for name, where, sign in (("printed_7", "(7)", -1), ("printed_L", "L(omega_hat)", 1), ("consistent_12", "(12)", 1)):
        identity = _same(invariants(expanded(f"luenberger_{name}")).c_0, sign * (alpha**2 + _OMEGA**2) * (k_2 * _OMEGA) ** 2)
        if sign < 0:
            forced, values = "c_0 is not positive", c_0
            proved = identity and all(value.low > 0 for value in values.values())
        else:
            forced = "c_0 / omega^2 is affine in omega^2 (the slopes between the speeds, k_2^2, agree)"
            values = _slopes({omega: value / (omega * omega) for omega, value in c_0.items()})
            proved = identity and _apart(values)
        found.append(Refutation(f"(7) expanded, z feedback of {where}", "(7)", column, forced, values, ("any",), proved))
    return found


def _luenberger_matrix(column: str, said: Digits) -> list[Refutation]:
    """(7) read as a matrix equation: D = (alpha - j omega) (R_s/sigma + j k omega), k = -k_2 for L(omega_hat), k_2 for (12).

    D_re = alpha R_s/sigma + k omega^2 and -D_im / omega = R_s/sigma - alpha k: D_re taken at two speeds gives k; then both.
    """
    alpha, rho, k_2 = _SYMBOLS["alpha"], _SYMBOLS["R_s"] / _SYMBOLS["sigma"], sp.Symbol("k_2", real=True)
    real, imag = said.D_re, said.D_im
    found = []
    for name, where, k in (("printed_L", "L(omega_hat)", -k_2), ("consistent_12", "(12)", k_2)):
        form = invariants(matrix_reading(f"luenberger_{name}"))
        identity = _same(form.D_re, alpha * rho + k * _OMEGA**2) and _same(form.D_im, _OMEGA * (alpha * k - rho))
        gain = meet_all(list(_slopes(real).values()))
        rate = {omega: -value / omega for omega, value in imag.items()}
        # any alpha > 0: a k above zero leaves -D_im/omega below R_s/sigma; and no common k at all settles it at once
        impossible = gain is None or (gain.low > 0 and all(r.low > R_S / SIGMA for r in rate.values()))
        forced = f"-D_im / omega = R_s/sigma - alpha k <= {float(R_S / SIGMA):.4f} /s, k > 0 the slope of D_re over omega^2"
        if gain is None:
            forced, rate = "D_re is affine in omega^2 (its slopes between the speeds agree)", _slopes(real)
        found.append(Refutation(f"(7) as a matrix equation, z feedback of {where}", "(7)", column, forced, rate, ("any",),
                                identity and impossible))
    return found


def _baseline(column: str, said: Digits) -> list[Refutation]:
    """(2)-(3) with any constant real 4x2 gain: c_0 = (alpha^2 + omega^2) Q, where Q does not depend on the speed."""
    alpha = _SYMBOLS["alpha"]
    quotient = sp.cancel(_nonzero_coefficients(baseline_any_gain())[-1] / (alpha**2 + _OMEGA**2))
    identity = _OMEGA not in quotient.free_symbols
    c_0 = said.c_0
    found = []
    for reading, value in ALPHAS.items():
        ratio = {omega: c / (value * value + omega * omega) for omega, c in c_0.items()}
        found.append(Refutation("(2)-(3) with any constant real 4x2 gain", "(2)-(3)", column,
                                "c_0 / (alpha^2 + omega^2) is the same at every speed", ratio, (reading,),
                                identity and _apart(ratio)))
    slopes = _slopes(c_0)
    found.append(Refutation("(2)-(3) with any constant real 4x2 gain", "(2)-(3)", column,
                            "c_0 is affine in omega^2 (its slopes between the speeds agree)", slopes, ("any",),
                            identity and _apart(slopes)))
    return found


# with where the paper prints the forms that each is about
_ARGUMENTS: dict[Callable[[str, Digits], list[Refutation]], tuple[str, ...]] = {
    _luenberger: ("(7)",), _luenberger_matrix: ("(7)",), _real_part_constant: ("(7)", "(8)"),
    _imaginary_part_zero: ("(12)", "L(omega_hat)"), _stator_rate: ("(8)",), _imaginary_part_of_12: ("(12)",),
    _baseline: ("(2)-(3)",),
}


def required_gains() -> dict[str, dict[str, Any]]:
    """What the gains would have to be, for each value of alpha, in the forms that come closest.

    ``expanded``: k_1, k_2, k_3 of (8) for which a, b and d are the table's; c then is 0 and not 254.6 /s. ``matrix``: the same
    for (8) as a matrix equation; c then is Table III's R_s/sigma = 139.47 /s. ``R_s`` (ohm) and ``sigma`` (H) are what
    either would have to be, alone, for c to be the table's.
    """
    from imo_analysis.pencils.table2_constants import ranges

    a, b, c, d = (r.outer for r in ranges())
    rho = R_S / SIGMA
    gains: dict[str, dict[str, Any]] = {}
    for reading, alpha in ALPHAS.items():
        gains[reading] = {
            "expanded": {"k_1": a - rho, "k_2": d, "k_3": b / alpha},
            "matrix": {"k_1": a - rho - alpha * (1 + BETA * L_M), "k_2": d, "k_3": b / alpha - rho},
            "R_s": c * SIGMA,
            "sigma": Interval.of(R_S) / c,
        }
    return gains


def baseline_gains_needed(alpha: Fraction) -> dict[int, dict[str, Interval]]:
    """The gains (l_1, l_2, l_3, l_4) with which (2)-(3) has the baseline column's poles: another set at each speed.

    From D = (alpha - j omega) (R_s/sigma + l_1 + beta l_3 + j beta l_4) and a = gamma + l_1 + alpha, with l_2 = 0. At 60 and
    100 rad/s the gains must differ from those at 30, so no constant set does it.
    """
    gamma = parameters.current_decay(R_S, L_M, SIGMA, alpha, BETA)
    needed = {}
    for omega in SPEEDS:
        real, imag = product("baseline", omega)
        size = alpha * alpha + omega * omega
        x = (real * alpha - imag * omega) / size
        y = (imag * alpha + real * omega) / size
        l_1 = sum_interval() - gamma - alpha
        needed[omega] = {"l_1": l_1, "l_2": Interval.of(0), "l_3": (x - l_1 - R_S / SIGMA) / BETA, "l_4": y / BETA}
    return needed
