"""Local observability of the machine (1) from measured currents and known voltages, by exact algebra.

The differentials of the Lie derivatives of the currents, of any order, vanish on a deviation exactly when it leaves the
current as it is along the whole motion (Hermann and Krener, IEEE TAC 22, 1977). With i fixed and phi = psi along d in its own
frame, which turns at omega + slip, a deviation (zeta = delta phi, w = delta omega, a = delta alpha / alpha, r, tau) obeys

    0    = (alpha - j omega) zeta - (psi' + j slip psi) a - j psi w - I r,       I = alpha psi + psi' + j slip psi
    zeta' = -j (omega + slip) zeta - I r
    w'   = M (zeta_d I_q - zeta_q I_d) - tau,                                    M = mu / (alpha L_m)

where r stands for R_s and tau for the load torque, both in units that remove constants, and I is the current in such units.
The mechanical rate is M psi^2 slip - tau_0. All entries are polynomials in alpha, omega, M, tau_0, psi, slip and the rates of
psi and slip, which the voltage can set at will; so the rank is that of a matrix of polynomials. Generic ranks are taken at
random rational points in exact arithmetic; steady states are decided over the field of rational functions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import combinations, cycle
from random import Random
from typing import Any

UNKNOWNS = ("omega", "alpha", "R_s", "T_l")
_COLUMN = {"omega": "w", "alpha": "a", "R_s": "r", "T_l": "tau"}


@dataclass(frozen=True)
class Problem:
    """What is not known. Fluxes never are.

    Attributes
    ----------
    unknown : tuple of str
        Out of `UNKNOWNS`, in that order. An omega that is not among them is measured.
    mechanical : bool
        Whether the speed row of (1) is used. Without it omega is a constant parameter, as in the paper, and the load torque
        does not appear.
    """

    unknown: tuple[str, ...]
    mechanical: bool = True

    @property
    def columns(self) -> tuple[str, ...]:
        """Deviations, in the order of the matrix."""
        measured = ("w",) if self.mechanical and "omega" not in self.unknown else ()
        return ("d", "q", *measured, *(_COLUMN[name] for name in self.unknown))


def problems(mechanical: bool) -> list[Problem]:
    """Every combination of unknowns."""
    names = UNKNOWNS if mechanical else UNKNOWNS[:3]
    return [Problem(chosen, mechanical) for size in range(len(names) + 1) for chosen in combinations(names, size)]


@dataclass(frozen=True)
class Jets:
    """A motion in any algebra: numbers, polynomials in time or in parameters, with their time derivative."""

    alpha: Any
    omega: Any
    M: Any
    psi: Any
    slip: Any
    rate: Callable[[Any], Any]
    zero: Any


def rows(problem: Problem, jets: Jets) -> list[list[Any]]:
    """The rows that a deviation must annihilate: the output row and its derivatives, as many as there are columns.

    Each derivative adds a d and a q row, and one of the measured speed; columns as `Problem.columns`.
    """
    alpha, omega, psi, slip, zero = jets.alpha, jets.omega, jets.psi, jets.slip, jets.zero
    psi_dot = jets.rate(psi)
    I_d, I_q = alpha * psi + psi_dot, slip * psi
    stator = omega + slip
    current = [
        {"d": alpha, "q": omega, "w": zero, "a": -psi_dot, "r": -I_d, "tau": zero},
        {"d": -omega, "q": alpha, "w": -psi, "a": -slip * psi, "r": -I_q, "tau": zero},
    ]
    if problem.mechanical and "omega" not in problem.unknown:
        current.append({**dict.fromkeys(_ALL, zero), "w": zero + 1})
    # rate of each deviation in terms of the others
    dynamics: dict[str, dict[str, Any]] = {"d": {"q": stator, "r": -I_d}, "q": {"d": -stator, "r": -I_q}}
    if problem.mechanical:
        dynamics["w"] = {"d": jets.M * I_q, "q": -jets.M * I_d, "tau": zero - 1}
    found = []
    for _ in problem.columns:
        found += [[row[name] for name in problem.columns] for row in current]
        current = [_next(row, dynamics, jets.rate) for row in current]
    return found


_ALL = ("d", "q", "w", "a", "r", "tau")


def _next(row: Mapping[str, Any], dynamics: Mapping[str, Mapping[str, Any]], rate: Callable[[Any], Any]) -> dict[str, Any]:
    out = {name: rate(entry) for name, entry in row.items()}
    for name, parts in dynamics.items():
        for other, factor in parts.items():
            out[other] = out[other] + row[name] * factor
    return out


@dataclass(frozen=True)
class Family:
    """A family of motions.

    Attributes
    ----------
    name : str
    constant_flux, constant_slip : bool
        Whether all rates of the flux magnitude, of the slip, are zero. Steady states are both, with the load in balance.
    fixed : str
        ``slip``, ``omega``, ``stator_frequency`` or ``psi``: what is zero; empty for nothing.
    """

    name: str
    constant_flux: bool = False
    constant_slip: bool = False
    fixed: str = ""

    @property
    def steady(self) -> bool:
        """Whether nothing changes in the frame of the flux."""
        return self.constant_flux and self.constant_slip


FAMILIES = (
    Family("general motion"),
    Family("constant flux magnitude", constant_flux=True),
    Family("constant slip, modulated flux", constant_slip=True),
    Family("steady state", True, True),
    Family("steady, no load", True, True, "slip"),
    Family("steady, shaft at rest", True, True, "omega"),
    Family("steady, zero stator frequency", True, True, "stator_frequency"),
    Family("no flux", True, True, "psi"),
)


def random_jets(family: Family, mechanical: bool, seed: int, orders: int = 8) -> Jets:
    """A motion of the family with small random rational coefficients, as polynomials in time."""
    from flint import fmpq, fmpq_poly

    draw = Random(f"{family.name} {seed}")

    def coefficient() -> Any:
        return fmpq(draw.randint(1, 97), draw.randint(1, 13))

    psi = fmpq_poly([coefficient() for _ in range(1 if family.constant_flux else orders)])
    slip = fmpq_poly([coefficient() for _ in range(1 if family.constant_slip else orders)])
    alpha, omega, M, load = (fmpq_poly([coefficient()]) for _ in range(4))
    if family.fixed == "slip":
        slip = fmpq_poly(0)
    elif family.fixed == "psi":
        psi = fmpq_poly(0)
    elif family.fixed == "omega":
        omega = fmpq_poly(0)
    elif family.fixed == "stator_frequency":
        omega = -slip
    if mechanical and not family.steady:
        omega = omega + (M * psi * psi * slip - load).integral()
    return Jets(alpha, omega, M, psi, slip, lambda p: p.derivative(), fmpq_poly(0))


TRIES = 3  # random motions, where a rank is not full


def rank(problem: Problem, family: Family = FAMILIES[0], tries: int = TRIES) -> int:
    """Generic rank on a family: the largest at ``tries`` random rational motions, in exact arithmetic.

    A rank found at a point proves that the generic rank is at least that. That it is not more is certain where it equals the
    number of columns, and with probability one elsewhere; `steady_rank` decides steady states for certain.
    """
    from flint import fmpq_mat

    best = 0
    for seed in range(tries):
        matrix = [[entry[0] for entry in row] for row in rows(problem, random_jets(family, problem.mechanical, seed))]
        best = max(best, int(fmpq_mat(matrix).rank()))
        if best == len(problem.columns):
            break
    return best


@dataclass(frozen=True)
class Row:
    """Ranks of a problem on every family; ``size`` is the rank that makes it observable."""

    problem: Problem
    size: int
    ranks: dict[str, int]


@cache
def rank_table(mechanical: bool = True) -> tuple[Row, ...]:
    """Ranks for every combination of unknowns on every family in `FAMILIES`: of steady states exact, else as `rank` says."""
    def found(problem: Problem, family: Family) -> int:
        return steady_rank(problem, family.fixed) if family.steady else rank(problem, family)

    return tuple(Row(p, len(p.columns), {f.name: found(p, f) for f in FAMILIES}) for p in problems(mechanical))


_MINORS = 3  # whose common factors are the candidates for a surface on which a rank drops


def steady_matrix(problem: Problem, fixed: str = "") -> Any:
    """The matrix in steady state as a sympy DomainMatrix over Q[omega, slip, M], in units where alpha and psi are 1.

    Units of time and flux scale rows and columns by positive numbers, which leaves the rank. In steady state the deviations
    obey equations with constant coefficients, so that by Cayley and Hamilton the orders taken are all that matter: its rank
    is exact. ``fixed`` as in `Family`; with ``psi`` the flux is 0.
    """
    from sympy import QQ, ring
    from sympy.polys.matrices import DomainMatrix

    made, omega, slip, M = ring("omega, slip, M", QQ)
    alpha = psi = made.one
    if fixed == "slip":
        slip = made.zero
    elif fixed == "psi":
        psi = made.zero
    elif fixed == "omega":
        omega = made.zero
    elif fixed == "stator_frequency":
        omega = -slip
    matrix = rows(problem, Jets(alpha, omega, M, psi, slip, lambda p: made.zero, made.zero))
    return DomainMatrix(matrix, (len(matrix), len(problem.columns)), made.to_domain())


def steady_rank(problem: Problem, fixed: str = "") -> int:
    """Rank in steady state over the field of rational functions: exact."""
    return int(steady_matrix(problem, fixed).to_field().rank())


@cache
def steady_conditions(problem: Problem) -> tuple[int, list[Any]]:
    """The rank in steady state, and the surfaces on which it drops.

    Returns
    -------
    rank : int
        As `steady_rank`.
    factors : list of sympy expressions
        Irreducible polynomials in omega, slip and M > 0, in units where alpha and psi are 1 (zero flux always loses, see
        `rank_table`). Where one is zero the rank drops. Candidates are the common factors of some minors;
        each is kept only if the rank does drop on its surface. What drops it on smaller sets only, such as two
        conditions at once, is not listed.
    """

    matrix = steady_matrix(problem)
    size = steady_rank(problem)
    domain = matrix.domain
    common = domain.zero
    draw = Random(1)
    minors = 0
    for columns in cycle(combinations(range(matrix.shape[1]), size)):
        chosen = matrix.extract(sorted(draw.sample(range(matrix.shape[0]), size)), list(columns))
        minor = chosen.charpoly()[-1]  # the determinant up to sign, without fractions
        common = domain.gcd(common, minor)
        minors += bool(minor)
        if minors == _MINORS:  # every surface on which the rank drops is a factor of each of them
            break
    factors = [domain.to_sympy(factor) for factor, _ in common.factor_list()[1]] if common else []
    whole = matrix.to_Matrix()
    return size, [factor for factor in factors if not cannot_vanish(factor) and _drops(whole, factor, size)]


def _drops(matrix: Any, factor: Any, size: int) -> bool:
    """Whether the rank is below ``size`` on the surface where a factor, linear in one of its symbols, is zero."""
    import sympy
    from sympy.polys.matrices import DomainMatrix

    for symbol in sorted(factor.free_symbols, key=str, reverse=True):
        if sympy.degree(factor, symbol) == 1:
            put = sympy.solve(factor, symbol)[0]
            return bool(DomainMatrix.from_Matrix(matrix.subs(symbol, put)).to_field().rank() < size)
    return False


def instant_determinant() -> Any:
    """Determinant of the current's row and its first derivative for flux, omega and an unknown T_l, along any motion: exact.

    Returns
    -------
    determinant : sympy expression
        In alpha, omega, psi, slip and omega_dot, the rate of the speed. Where it is not zero, the current and its first
        derivative tell the four apart at that instant. In a steady state what is left of it is the stator frequency.
    """
    import sympy
    from sympy import QQ, ring

    names = ("alpha", "omega", "M", "psi", "slip")
    made, *symbols = ring((*names, "omega_dot", "psi_dot", "psi_ddot", "slip_dot"), QQ)
    alpha, omega, M, psi, slip, omega_dot, psi_dot, psi_ddot, slip_dot = symbols
    rates = {omega: omega_dot, psi: psi_dot, psi_dot: psi_ddot, slip: slip_dot}

    def rate(entry: Any) -> Any:
        return sum((entry.diff(symbol) * its for symbol, its in rates.items()), made.zero)

    problem = Problem(("omega", "T_l"))
    first = rows(problem, Jets(alpha, omega, M, psi, slip, rate, made.zero))[:len(problem.columns)]
    return sympy.factor(sympy.Matrix([[entry.as_expr() for entry in row] for row in first]).det())


def cannot_vanish(factor: Any) -> bool:
    """Whether a polynomial is a sum of a positive term and even terms, for M > 0 and real omega and slip."""
    import sympy

    positive = {"M"}
    strict = False
    for powers, coefficient in sympy.Poly(factor, *sorted(factor.free_symbols, key=str)).terms():
        names = [str(symbol) for symbol in sorted(factor.free_symbols, key=str)]
        if coefficient < 0 or any(power % 2 for name, power in zip(names, powers, strict=True) if name not in positive):
            return False
        strict = strict or all(power == 0 for name, power in zip(names, powers, strict=True) if name not in positive)
    return strict
