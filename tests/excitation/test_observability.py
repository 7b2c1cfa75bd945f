"""Observability: exact steady ranks against random ones, and the rows against Lie derivatives of (1) itself."""

from random import Random

import pytest
import sympy

from imo_analysis.equations.plant import plant
from imo_analysis.excitation import observability as o

CONSTANT = {r.problem.unknown: r for r in o.rank_table(mechanical=False)}
MECHANICAL = {r.problem.unknown: r for r in o.rank_table(mechanical=True)}


def test_every_combination_is_there():
    for mechanical, count in ((False, 3), (True, 4)):
        found = {problem.unknown for problem in o.problems(mechanical)}
        assert len(found) == 2**count and set().union(*found) == set(o.UNKNOWNS[:count])


def test_every_combination_is_observable_in_general_motion():
    for row in (*CONSTANT.values(), *MECHANICAL.values()):
        assert row.ranks["general motion"] == row.size, row.problem


def test_every_steady_state_loses_alpha_with_omega():
    for rows in (CONSTANT, MECHANICAL):
        for unknown, row in rows.items():
            lost = {"omega", "alpha"} <= set(unknown)
            assert (row.ranks["steady state"] < row.size) == lost, unknown
            assert row.ranks["constant slip, modulated flux"] == row.size


def test_known_lines():
    """omega alone: lost at zero stator frequency unless the load torque is known; alpha alone: lost without load."""
    assert CONSTANT[("omega",)].ranks["steady, zero stator frequency"] == 2
    assert MECHANICAL[("omega", "T_l")].ranks["steady, zero stator frequency"] == 3
    assert MECHANICAL[("omega",)].ranks["steady, zero stator frequency"] == 3 == MECHANICAL[("omega",)].size
    assert CONSTANT[("alpha",)].ranks["steady, no load"] == 2
    assert MECHANICAL[("alpha",)].ranks["steady, no load"] == 3


@pytest.mark.parametrize("mechanical", [False, True])
def test_exact_steady_ranks_agree_with_random_ones(mechanical):
    for row in o.rank_table(mechanical):
        for family in o.FAMILIES:
            if family.steady:
                assert o.steady_rank(row.problem, family.fixed) == row.ranks[family.name], (row.problem, family)


def names(problem):
    return {str(factor) for factor in o.steady_conditions(problem)[1]}


def test_surfaces_on_which_a_steady_state_loses_more():
    line, idle = "omega + slip", "slip"
    expected = {("omega",): {line}, ("alpha",): {line, idle}, ("R_s",): set(), ("omega", "R_s"): {line, idle},
                ("omega", "alpha"): {line}, ("omega", "alpha", "R_s"): {line, idle}}
    for unknown, surfaces in expected.items():
        assert names(o.Problem(unknown, mechanical=False)) == surfaces
    assert names(o.Problem(("omega", "T_l"))) == {line}
    assert names(o.Problem(("omega",))) == set()
    assert names(o.Problem(("alpha",))) == {idle}


NAMES = ("i1", "i2", "f1", "f2", "w", "al", "R", "T")
PARAMETER = {"alpha": "al", "R_s": "R", "T_l": "T"}


def lie_rows(gens, rates, outputs, columns, orders, point):
    """Differentials of the Lie derivatives of the outputs, at a point; all in one polynomial ring."""
    rows = []
    for _ in range(orders):
        rows += [[h.diff(gens[c]).evaluate(point) for c in columns] for h in outputs]
        outputs = [sum((h.diff(gens[s]) * r for s, r in rates.items()), 0 * h) for h in outputs]
    return sympy.Matrix([[sympy.Rational(int(x.numerator), int(x.denominator)) for x in row] for row in rows])


@pytest.mark.parametrize("unknown", [("omega",), ("omega", "T_l"), ("omega", "alpha"), ("R_s",)])
def test_lie_derivatives_of_the_machine_itself(unknown):
    """Straight from `plant` at a random rational point; voltages are polynomials in time, time is a state."""
    draw = Random(3)
    QQ = sympy.QQ

    def number():
        return QQ(draw.randint(1, 30), draw.randint(1, 9))

    made, *variables = sympy.ring((*NAMES, "t"), QQ)
    gens = dict(zip((*NAMES, "t"), variables, strict=True))
    columns = [*NAMES[:5], *[PARAMETER[n] for n in unknown if n != "omega"]]
    orders = len(columns) - 2
    u = [sum((number() * gens["t"] ** k for k in range(orders + 1)), made.zero) for _ in range(2)]
    p = (gens["R"], number(), number(), number(), gens["al"], number(), QQ(2), number())
    rates = dict(zip(NAMES[:5], plant([gens[n] for n in NAMES[:5]], u, 0, gens["T"], p), strict=True)) | {"t": made.one}
    outputs = [gens["i1"], gens["i2"]] + ([] if "omega" in unknown else [gens["w"]])
    point = [(gens[n], number()) for n in NAMES] + [(gens["t"], QQ(0))]
    assert lie_rows(gens, rates, outputs, columns, orders, point).rank() == len(columns)
    assert MECHANICAL[unknown].ranks["general motion"] == MECHANICAL[unknown].size


@pytest.mark.parametrize(
    "unknown", [("omega",), ("omega", "alpha"), ("omega", "T_l"), ("omega", "R_s"), ("omega", "alpha", "T_l")])
@pytest.mark.parametrize("slip", ["13/9", "0", "-11/3"])
def test_rows_agree_with_lie_derivatives_in_a_steady_state(unknown, slip):
    """Loaded, idle and at zero stator frequency, in the frame of the flux, where voltages are constant.

    The fields of current and flux in that frame are autonomous, and ranks differ by the two measured currents.
    """
    QQ = sympy.QQ
    L_m, sigma, beta, mu, n_p, J, R_s, alpha, omega, psi, slip = (
        QQ(*map(int, (text + "/1").split("/")[:2])) for text in
        ("3/5", "1/7", "9/4", "5/3", "2", "1/3", "3/8", "7/2", "11/3", "4/5", slip))
    i_d, i_q = psi / L_m, slip * psi / (alpha * L_m)
    load = J / n_p * mu * psi * i_q
    stator = omega + slip
    u = (sigma * (R_s / sigma * i_d - stator * (i_q)), sigma * (R_s / sigma * i_q + stator * (i_d + beta * psi)))
    made, *variables = sympy.ring(NAMES, QQ)
    gens = dict(zip(NAMES, variables, strict=True))
    p = (gens["R"], L_m, sigma, beta, gens["al"], mu, n_p, J)
    fields = plant([gens[n] for n in NAMES[:5]], u, stator, gens["T"], p)
    point = list(zip(variables, (i_d, i_q, psi, QQ(0), omega, alpha, R_s, load), strict=True))
    assert all((made.zero + f).evaluate(point) == 0 for f in fields)
    columns = [*NAMES[:5], *[PARAMETER[n] for n in unknown if n != "omega"]]
    rates = dict(zip(NAMES[:5], fields, strict=True))
    found = lie_rows(gens, rates, [gens["i1"], gens["i2"]], columns, len(columns) - 1, point).rank()
    family = {"13/9": "steady state", "0/1": "steady, no load", "-11/3": "steady, zero stator frequency"}
    name = next(v for k, v in family.items() if QQ(*map(int, k.split("/"))) == slip)
    assert found - 2 == MECHANICAL[unknown].ranks[name]


def test_determinant_at_an_instant_is_that_of_the_machine_itself():
    """Straight from `plant` in the stator frame, at a random point: singular with the one load torque that it names."""
    closed = o.instant_determinant()
    alpha, omega, psi, slip, omega_dot = sympy.symbols("alpha omega psi slip omega_dot")
    turning = omega + slip + alpha * omega_dot / (alpha**2 + omega**2)  # omega_s, and the rate of arctan(omega/alpha)
    assert sympy.simplify(closed - psi**2 * (alpha**2 + omega**2) * turning) == 0

    draw, QQ = Random(8), sympy.QQ

    def number():
        return QQ(draw.randint(1, 30), draw.randint(1, 9))

    made, *variables = sympy.ring(NAMES, QQ)
    gens = dict(zip(NAMES, variables, strict=True))
    p = (gens["R"], number(), number(), number(), gens["al"], number(), QQ(2), number())
    voltage = (number(), number())
    rates = dict(zip(NAMES[:5], plant([gens[n] for n in NAMES[:5]], voltage, 0, gens["T"], p), strict=True))
    point = {n: number() for n in NAMES}

    def at(name):
        return (made.zero + rates[name]).evaluate([(gens[n], point[n]) for n in NAMES])

    f1, f2, w, al = (point[n] for n in ("f1", "f2", "w", "al"))
    frequency = (f1 * at("f2") - f2 * at("f1")) / (f1**2 + f2**2)
    wanted = -frequency * (al**2 + w**2) / al  # of the speed's rate, which is even in the load torque
    unloaded = at("w") + point["T"] * QQ(2) / p[7]
    for load, rank in (((unloaded - wanted) * p[7] / QQ(2), 5), (point["T"], 6)):
        point["T"] = load
        found = lie_rows(gens, rates, [gens["i1"], gens["i2"]], [*NAMES[:5], "T"], 3, [(gens[n], point[n]) for n in NAMES])
        assert found.rank() == rank


def test_constant_speed_is_lost_exactly_on_circles():
    """omega and alpha part unless the flux runs evenly round a circle, which need not be centred on zero."""
    import math

    import numpy as np
    from synthetic import MACHINE

    from imo_analysis.excitation.bounds import Measurement, Motion, deviations

    circle = Motion(80.0, np.array([83.0, 0.0]), np.array([0.5, 0.2 + 0.1j]))
    other = Motion(80.0, np.array([83.0, 40.0]), np.array([0.5, 0.05 + 0j]))
    assert deviations(MACHINE, circle, Measurement())["omega"] == math.inf
    assert deviations(MACHINE, other, Measurement())["omega"] < 1.0


def test_cannot_vanish():
    x, M = sympy.symbols("omega M")
    assert o.cannot_vanish(x**2 + M) and o.cannot_vanish(x**4 + 2 * x**2 * M + 1)
    assert not o.cannot_vanish(x) and not o.cannot_vanish(x**2 - M) and not o.cannot_vanish(x**2 * M)
