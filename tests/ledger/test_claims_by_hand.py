"""The central findings once more, by complex arithmetic and small steps (oracle_errors.py), without the ledger."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest
from oracle_errors import Case, error_rates

from imo_analysis.ledger.claims.simulation import QUADRATIC, real_product
from imo_analysis.ledger.claims.situations import BREAKS_16, lyapunov_13, repaired
from imo_analysis.paper.tables import EIGENVALUES, Pair, printed

NAMES = ("i_ds", "i_qs", "z_1", "z_2")


def random_case(seed):
    """A machine, gains, a true state and errors."""
    r = random.Random(seed)

    def c():
        return complex(r.uniform(-5, 5), r.uniform(-5, 5))

    case = Case(*(r.uniform(0.5, 3) for _ in range(9)), c(), c())
    return case, (c(), c(), c(), r.uniform(-1, 1), r.uniform(-0.3, 0.3))


def moved(errors, rates, step):
    return [a + step * b for a, b in zip(errors, rates, strict=True)]


def slope(function, errors, rates, step=1e-6):
    """The derivative of a function of the errors along the rates, by a central difference."""
    return (function(*moved(errors, rates, step)) - function(*moved(errors, rates, -step))) / (2 * step)


@pytest.mark.parametrize("seed", range(8))
def test_derivative_of_13_has_the_term_that_the_text_drops(seed):
    case, errors = random_case(seed)
    rates = error_rates(case, *errors, "consistent_12", case.k_2 * (case.omega - errors[4]))

    def V(e, z, xi, a, w):
        return (
            abs(e) ** 2 / 2
            + case.omega / (2 * case.k_2 * (case.omega - w)) * abs(z) ** 2
            + case.alpha / (2 * case.k_3) * abs(xi) ** 2
            + a**2 / (2 * case.g)
            + w**2 / (2 * case.K_p)
        )

    bound = -(case.k_1 + case.rate) * abs(errors[0]) ** 2
    gain = case.omega * rates[4] / (2 * case.k_2 * (case.omega - errors[4]) ** 2) * abs(errors[1]) ** 2
    assert slope(V, errors, rates) == pytest.approx(bound + gain, rel=1e-6)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("seed", range(4))
def test_repair_2_and_what_it_conserves(seed, direction):
    case, errors = random_case(seed)
    case = Case(**{**vars(case), "omega": direction * case.omega})
    rates = error_rates(case, *errors, "consistent_12", case.k_2 * direction)

    def V(e, z, xi, a, w):
        return (
            abs(e) ** 2 / 2
            + abs(case.omega) / (2 * case.k_2) * abs(z) ** 2
            + case.alpha / (2 * case.k_3) * abs(xi) ** 2
            + a**2 / (2 * case.g)
            + w**2 / (2 * case.K_p)
        )

    assert slope(V, errors, rates) == pytest.approx(-(case.k_1 + case.rate) * abs(errors[0]) ** 2, rel=1e-6)
    assert abs(case.k_3 * rates[1] - 1j * case.k_2 * direction * rates[2]) < 1e-12
    w_rate = case.alpha * rates[2] - 1j * case.omega * rates[1]
    assert w_rate == pytest.approx(-(case.alpha * case.k_3 + case.k_2 * direction * case.omega) * errors[0])


@pytest.mark.parametrize("feedback", ["printed_7", "printed_L", "consistent_12"])
def test_resting_errors(feedback):
    """Any z error rests with the xi error that balances it."""
    case, _ = random_case(5)
    z = 0.7 - 1.3j
    rates = error_rates(case, 0j, z, 1j * case.omega * z / case.alpha, 0.0, 0.0, feedback, case.k_2 * case.omega)
    assert np.allclose(rates, 0, atol=1e-12)


@pytest.mark.parametrize(
    ("feedback", "numbers", "eigenvalue"),
    [("printed_7", (1 / 8, 1 / 8, 1 / 2, 5 / 8, 1 / 2, 2), 1), ("printed_L", (1 / 4, 1 / 4, 5, 1 / 2, 1, 5), 1 + 2j)],
)
@pytest.mark.parametrize(("g", "K_p"), [(1, 100), (37, 0.2)])
def test_without_flux_zero_error_is_unstable_whatever_the_adaptation(feedback, numbers, eigenvalue, g, K_p):
    """The Jacobian at zero error of a machine at i = z = 0, by small steps: it grows, and g and K_p do not show in it."""
    rate, k_1, alpha, k_2, k_3, omega = numbers
    case = Case(rate, 1.7, alpha, omega, k_1, k_2, k_3, g, K_p, 0j, 0j)

    def flat(x):
        out = error_rates(case, complex(*x[:2]), complex(*x[2:4]), complex(*x[4:6]), x[6], x[7], feedback, k_2 * (omega - x[7]))
        return np.array([part for one in out[:3] for part in (one.real, one.imag)] + [out[3], out[4]])

    jacobian = np.column_stack([(flat(step) - flat(-step)) / 2e-4 for step in 1e-4 * np.eye(8)])
    assert np.allclose(jacobian[6:], 0, atol=1e-9)
    assert np.abs(np.linalg.eigvals(jacobian) - eigenvalue).min() < 1e-6


def test_the_state_by_hand():
    """V' = 6 where (16) allows -2, from the oracle and from the ledger."""
    case = Case(1, 2, 1, 1, 1, 1, 1, 1, 1, 0j, -1j)
    errors = (1 + 0j, 4 + 0j, 0j, 0.0, 0.0)
    rates = error_rates(case, *errors, "consistent_12", 1.0)

    def V(e, z, xi, a, w):
        return abs(e) ** 2 / 2 + abs(z) ** 2 / (2 * (1 - w)) + abs(xi) ** 2 / 2 + a**2 / 2 + w**2 / 2

    assert slope(V, errors, rates) == pytest.approx(6, abs=1e-6)
    assert lyapunov_13().values({name: Fraction(value) for name, value in BREAKS_16.items()})["V_dot"] == 6


def test_ledger_and_oracle_agree_on_the_rates():
    """The traced settings and the complex equations, at random rational points."""
    r = random.Random(3)
    where = repaired()
    point = {
        name: Fraction(r.randint(1, 9))
        for name in (
            "R_s",
            "L_m",
            "sigma",
            "beta",
            "alpha",
            "omega",
            "k_1",
            "kappa",
            "k_3",
            "g",
            "K_p",
            "i_ds",
            "i_qs",
            "z_1",
            "z_2",
            "u_ds",
            "u_qs",
            *(f"{one}_tilde" for one in (*NAMES, "xi_1", "xi_2", "alpha", "omega")),
        )
    }
    values = where.values({**point, "direction": Fraction(1)})
    v = {name: float(value) for name, value in point.items()}
    case = Case(
        v["R_s"] / v["sigma"],
        1 + v["beta"] * v["L_m"],
        v["alpha"],
        v["omega"],
        v["k_1"],
        v["kappa"],
        v["k_3"],
        v["g"],
        v["K_p"],
        complex(v["i_ds"], v["i_qs"]),
        complex(v["z_1"], v["z_2"]),
    )
    errors = (
        complex(v["i_ds_tilde"], v["i_qs_tilde"]),
        complex(v["z_1_tilde"], v["z_2_tilde"]),
        complex(v["xi_1_tilde"], v["xi_2_tilde"]),
        v["alpha_tilde"],
        v["omega_tilde"],
    )
    rates = error_rates(case, *errors, "consistent_12", case.k_2)
    flat = [rates[0].real, rates[0].imag, rates[1].real, rates[1].imag, rates[2].real, rates[2].imag, rates[3], rates[4]]
    for name, rate in zip((*NAMES, "xi_1", "xi_2", "alpha", "omega"), flat, strict=True):
        assert float(values[f"{name}_tilde_dot"]) == pytest.approx(rate, rel=1e-12)


def test_table_ii_by_numpy_roots():
    """The quadratic of the ledger gives the 24 numbers also in floating point."""
    a, b, c, d = map(float, QUADRATIC)
    for pair in EIGENVALUES:
        w = pair.omega_hat
        roots = np.roots([1, a - 1j * w, b - 1j * c * w + d * (w * w if pair.column == "proposed" else w)])
        for text in (pair.first, pair.second):
            value = complex(float(text[0]), float(text[1]))
            nearest = min(roots, key=lambda root: abs(root - value))
            assert abs(nearest.real - value.real) < 0.00501 and abs(nearest.imag - value.imag) < 0.00501


def test_alpha_of_table_iii():
    rotor = float(printed("L_m")) + float(printed("L_r - L_m"))
    assert float(printed("R_r")) / rotor == pytest.approx(6.6236, abs=5e-5)
    assert 1.5 * float(printed("R_r")) / rotor == pytest.approx(float(printed("alpha")), abs=5e-5)


def test_real_products_are_recognised():
    """Poles of the expanded (8), rounded as the table does, pass; the printed ones do not."""
    a, c, w = 439.5, 993.5, 60.0
    roots = np.roots([1, a - 1j * w, c + 50 * w * w])
    texts = [(f"{root.real:.2f}", f"{root.imag:.2f}") for root in roots]
    assert real_product((Pair("proposed", 60, *texts),))[0]
    assert not real_product(EIGENVALUES)[0]


def test_the_entries_on_the_printed_poles_hold_every_refutation_and_notice_each_made_table():
    """All forms against both columns stand in some entry; and a wrong proof in any one form turns its entry red."""
    from imo_analysis.ledger.claims import printed_poles
    from imo_analysis.pencils import table2_proofs

    checks = [check for claim in printed_poles.CLAIMS for check in claim.checks if check.function is printed_poles.cannot]
    covered = [(one.form, one.column, one.alphas) for check in checks for one in table2_proofs.refuted(None, check.arguments[0])
               if one.form.startswith(check.arguments[1])]
    whole = [(one.form, one.column, one.alphas) for one in table2_proofs.refutations()]
    assert {*covered} == {*whole} and len(whole) == 32
    used = {check.failing[2] for check in checks}
    assert used <= {*printed_poles.MADE_BY} and len(used) >= 6
    assert not printed_poles.cannot("(7)", "(9)")[0], "a form that there is not proves nothing"


@pytest.mark.parametrize("ends", [("495.38999", "495.39390"), ("495.38999", "495.39500"), ("495.38800", "495.39399")])
def test_a_range_that_is_too_short_or_too_long_is_not_the_constants(ends):
    from imo_analysis.ledger.claims.printed_poles import ranges_from

    assert ranges_from("a", "495.38999", "495.39399")[0] and not ranges_from("a", *ends)[0]
