"""The closed form against 50-digit arithmetic, python-control and numpy; where it is right to 1e-15 and where no method is."""

from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.machine import preset
from imo_analysis.pencils.closed_form import COMPILED_FROM, ClosedForm, closed_form, complex_matrix, larger_first, pairs
from imo_analysis.pencils.error import OperatingPoint, arguments, frozen_pencil, machine_parameters
from imo_analysis.pencils.jacobian import commutes_with_rotation, jacobian, structural_rank

MACHINE = preset("table-iii-printed-alpha")
FACTORED = [name for name in OBSERVERS if closed_form(name) is not None]


def _random(seed: int, name: str, points: int) -> dict[str, np.ndarray]:
    """Machine parameters, gains and speeds over three decades, gains of either sign for the baseline's couplings."""
    random = np.random.default_rng(seed)
    values = {field: getattr(MACHINE, field) * np.exp(random.uniform(-0.3, 0.3, points)) for field in ("R_s", "R_r")}
    p = {key: np.broadcast_to(v, points) for key, v in machine_parameters(MACHINE, values).items()}
    for gain in OBSERVERS[name].gains:
        p[gain] = 10 ** random.uniform(-1, 3, points)
    p["omega"] = random.choice((-1, 1), points) * 10 ** random.uniform(-1, 3, points)
    p["direction"] = np.where(p["omega"] < 0, -1.0, 1.0)
    return p


def _exact(form: ClosedForm, at: dict[str, float]) -> tuple[Any, Any, Any, Any]:
    """p, q and both roots with 50 digits, from the exact values of the floats."""
    given = {name: mpmath.mpf(at[name]) for name in form.arguments}
    p_re, p_im, q_re, q_im = (
        sp.lambdify([*given], part, modules="mpmath")(*given.values()) for part in form.coefficients)
    p, q = mpmath.mpc(p_re, p_im), mpmath.mpc(q_re, q_im)
    w = mpmath.sqrt(p * p - 4 * q)
    roots = sorted(((-p + w) / 2, (-p - w) / 2), key=lambda root: -abs(root))
    return p, q, roots[0], roots[1]


def test_those_that_commute_with_rotations_have_one_and_the_others_have_none() -> None:
    assert [name for name in OBSERVERS if commutes_with_rotation(name)] == FACTORED
    for name in FACTORED:
        form = closed_form(name)
        assert form is not None and form.at_zero == len(jacobian(name).states) - structural_rank(name)


@pytest.mark.parametrize("name", FACTORED)
def test_within_1e_15_times_the_condition_of_50_digit_roots(name: str) -> None:
    """The bound of the module: 1e-15 sqrt(1 + |p|^2 / |p^2 - 4 q|), where p and q themselves do not cancel."""
    form = closed_form(name)
    assert form is not None
    values = _random(3, name, 60)
    found = pairs(form, values)
    with mpmath.workdps(50):
        for k in range(60):
            p, q, *roots = _exact(form, {key: float(value[k]) for key, value in values.items()})
            condition = float(mpmath.sqrt(1 + abs(p) ** 2 / abs(p * p - 4 * q)))
            for n, root in enumerate(roots):
                error = abs(mpmath.mpc(found[2 * n, k], found[2 * n + 1, k]) - root) / abs(root)
                assert error < 1e-15 * condition * _cancelled(form, values, k), (name, k, n)


def _cancelled(form: ClosedForm, values: dict[str, np.ndarray], k: int) -> float:
    """How many times larger the terms of a coefficient are than p or q: no arithmetic can give back what inputs round away."""
    worst = 1.0
    for parts in (form.coefficients[:2], form.coefficients[2:]):
        terms = [[float(_at(term, values, k)) for term in sp.Add.make_args(sp.expand(part))] for part in parts]
        worst = max(worst, sum(abs(t) for part in terms for t in part) / abs(complex(*(sum(part) for part in terms))))
    return worst


def _at(term: Any, values: dict[str, np.ndarray], k: int) -> Any:
    return term.subs({symbol: float(values[symbol.name][k]) for symbol in term.free_symbols})


def test_near_double_roots_the_bound_holds_and_is_needed() -> None:
    """s^2 + 2 s + 1 - e: the distance of the roots is 2 sqrt(e), and half of the digits are gone where e is the rounding."""
    worst = 0.0
    random = Random(5)
    with mpmath.workdps(50):
        for k in range(400):
            e = 10.0 ** random.uniform(-16, 0)
            p = 10 ** random.uniform(-2, 3) * complex(random.gauss(0, 1), random.gauss(0, 1))
            q = p * p / 4 * (1 - e * complex(random.gauss(0, 1), random.gauss(0, 1)))
            exact_p, exact_q = mpmath.mpc(p), mpmath.mpc(q)
            w = mpmath.sqrt(exact_p**2 - 4 * exact_q)
            x = larger_first(p.real, p.imag, q.real, q.imag)
            condition = float(mpmath.sqrt(1 + abs(exact_p) ** 2 / abs(w) ** 2))
            for found in (mpmath.mpc(*x[:2]), mpmath.mpc(*x[2:])):
                error = min(abs(found + (exact_p + sign * w) / 2) for sign in (-1, 1)) / abs(found)
                assert error < 1e-15 * condition, k
                worst = max(worst, float(error))
    assert worst > 1e-12


@pytest.mark.parametrize(("p", "q", "roots"), [
    ((0.0, 0.0), (0.0, 0.0), (0.0, 0.0)),
    ((3.0, 0.0), (0.0, 0.0), (-3.0, 0.0)),
    ((2.0, 0.0), (1.0, 0.0), (-1.0, -1.0)),
    ((0.0, 0.0), (4.0, 0.0), (-2.0j, 2.0j)),
    ((0.0, 0.0), (-4.0, 0.0), (2.0, -2.0)),
    ((1e8, 0.0), (1.0, 0.0), (-1e8, -1e-8)),
    ((0.0, -1e8), (-1.0, 0.0), (1e8j, 1e-8j)),
])
def test_roots_that_are_known(p: tuple[float, float], q: tuple[float, float], roots: tuple[complex, complex]) -> None:
    x = larger_first(*p, *q)
    found = (complex(x[0], x[1]), complex(x[2], x[3]))
    assert min(max(abs(a - b) for a, b in zip(found, order, strict=True)) for order in (roots, roots[::-1])) <= 1e-15 * max(
        1e-300, *map(abs, roots))
    assert abs(found[0]) >= abs(found[1])


@pytest.mark.parametrize("name", FACTORED)
def test_the_same_poles_as_control_and_as_50_digit_eigenvalues(name: str) -> None:
    """Neither uses the complex structure: control takes the whole real matrix, mpmath too, with 50 digits."""
    form = closed_form(name)
    assert form is not None
    derived = jacobian(name)
    n = len(derived.states)
    gains = dict(zip(OBSERVERS[name].gains, (300.0, 40.0, 90.0, 1.0, 20.0, 0.05, 0.01, 1.0, 1.0), strict=False))
    gains |= {"l_1": 162.0, "l_2": 3.0, "l_3": -0.08, "l_4": 0.35} if name == "baseline" else {}
    gains |= {"k": 1.5, "h": 20.0} if name == "baseline_scheduled" else {}
    for omega in (-140.0, -3.0, 0.0, 17.0, 95.0):
        values = arguments(derived, MACHINE, gains, OperatingPoint(omega, None))
        found = np.concatenate([form.poles(values), np.zeros(form.at_zero)])
        for other, tolerance in ((frozen_pencil(MACHINE, name, gains, omega).poles(), 1e-7),
                                 (np.linalg.eigvals(derived.system_matrix(values)), 1e-7)):
            assert _apart(found, other) < tolerance * np.abs(found).max()
        with mpmath.workdps(50):
            entries = sp.lambdify([*values], list(derived.matrix[:n, :n]), modules="mpmath")(
                *(mpmath.mpf(float(value)) for value in values.values()))
            exact, _ = mpmath.eig(mpmath.matrix(n, n) + mpmath.matrix(np.array(entries, dtype=object).reshape(n, n).tolist()))
            # two poles at zero are a double root of the eigenvalue problem: 50 digits leave 25
            assert _apart(found, np.array([complex(root) for root in exact])) < 1e-13 * np.abs(found).max()


def _apart(one: np.ndarray, other: np.ndarray) -> float:
    from scipy.optimize import linear_sum_assignment

    distance = np.abs(one[:, None] - other[None, :])
    return float(distance[linear_sum_assignment(distance)].max())


@pytest.mark.parametrize("name", ["consistent_12", "repaired", "baseline"])
def test_the_compiled_loop_gives_the_same_numbers(name: str) -> None:
    form = closed_form(name)
    assert form is not None
    values = _random(8, name, COMPILED_FROM)
    fast = pairs(form, values)
    few = pairs(form, {key: value[:500] for key, value in values.items()})
    # the compiler may contract a multiplication and an addition, no more
    assert np.abs(fast[:, :500] - few).max() <= 1e-13 * np.abs(few).max()
    assert np.median(np.abs(fast[:, :500] - few) / np.abs(few)) <= 1e-15
    out = np.empty((4, COMPILED_FROM))
    assert pairs(form, values, out).base is out or np.shares_memory(pairs(form, values, out), out)
    one = {**{key: float(value[0]) for key, value in values.items()}, "omega": values["omega"]}
    grid = {**one, "omega": values["omega"][None, :], "R_s": values["R_s"][:2, None]}
    assert pairs(form, grid)[:, 1] == pytest.approx(pairs(form, {**one, "R_s": float(values["R_s"][1])}), rel=1e-13)


def test_a_matrix_that_is_no_complex_one_is_seen() -> None:
    a, b = sp.symbols("a b")
    assert complex_matrix(sp.Matrix([[a, -b], [b, a]])) == sp.Matrix([[a + sp.I * b]])
    assert complex_matrix(sp.Matrix([[a, b], [b, a]])) is None
    assert complex_matrix(sp.Matrix([[a, -b], [b, a + 1]])) is None
