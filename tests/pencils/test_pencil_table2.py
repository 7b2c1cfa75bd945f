"""Table II: the quadratic gives every printed digit, its ranges are certified, and the refutations can fail."""

from fractions import Fraction

import numpy as np
import pytest

from imo_analysis.machine import preset
from imo_analysis.pencils import table2_constants, table2_fit, table2_proofs
from imo_analysis.pencils.interval import Interval, meet_all, square_root
from imo_analysis.pencils.table2 import from_quadratic, printed, table2
from imo_analysis.pencils.table2_fit import COLUMNS, PRINTED, SPEEDS, WITNESS, as_printed, mismatches

RHO = float(table2_proofs.R_S / table2_proofs.SIGMA)


def test_intervals_enclose() -> None:
    one, other = Interval.printed("1.25"), Interval.printed("-0.5")
    assert (one.low, one.high) == (Fraction("1.245"), Fraction("1.255"))
    assert (one * other).low == Fraction("1.255") * Fraction("-0.55")
    assert Interval(Fraction(-1), Fraction(2)).square() == Interval(Fraction(0), Fraction(4))
    assert meet_all([one, one + 1]) is None
    root = square_root(Fraction(2))
    assert root.low**2 < 2 < root.high**2 and root.high - root.low < Fraction(1, 10**39)
    with pytest.raises(ZeroDivisionError):
        one / Interval(Fraction(-1), Fraction(1))


def test_the_quadratic_gives_all_24_numbers_to_the_printed_digit() -> None:
    assert mismatches(*WITNESS) == []
    for column in COLUMNS:  # the same in floating point by numpy's own root finder
        a, b, c, d = (float(value) for value in WITNESS)
        for omega, row in zip(SPEEDS, printed(column), strict=True):
            roots = np.roots([1.0, a - 1j * omega, b - 1j * c * omega + d * (omega**2 if column == "proposed" else omega)])
            both = np.concatenate([roots, roots.conj()])
            for value in row:
                nearest = both[np.argmin(np.abs(both - value))]
                assert abs(nearest.real - value.real) < 0.005 and abs(nearest.imag - value.imag) < 0.005


@pytest.mark.parametrize("k", range(4))
def test_a_constant_that_is_slightly_off_is_noticed(k: int) -> None:
    changed = list(WITNESS)
    changed[k] *= Fraction(10002, 10000)
    assert mismatches(*changed)


def test_the_columns_differ_in_one_factor_only() -> None:
    """With the factor of the other column nothing fits: omega^2 against omega is what the columns differ in."""
    assert from_quadratic("proposed")[0] == pytest.approx(printed("proposed")[0], abs=0.0075)
    swapped = {"proposed": PRINTED["baseline"], "baseline": PRINTED["proposed"]}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(table2_fit, "PRINTED", swapped)
        assert len(mismatches(*WITNESS)) >= 16


def test_ranges_are_tight_and_hold_the_witness() -> None:
    for found, value in zip(table2_constants.ranges(), WITNESS, strict=True):
        assert found.outer.low <= found.inner.low <= value <= found.inner.high <= found.outer.high
        assert found.inner.high - found.inner.low > Fraction(99, 100) * (found.outer.high - found.outer.low)
    a, b, c, d = (r.outer for r in table2_constants.ranges())
    assert d.holds(50) and float(d.high - d.low) < 1e-3
    assert (float(a.low), float(a.high)) == pytest.approx((495.39000, 495.39398), abs=1e-5)
    assert (float(b.low), float(b.high)) == pytest.approx((6074.3225, 6075.5894), abs=1e-3)
    assert (float(c.low), float(c.high)) == pytest.approx((254.58053, 254.61040), abs=1e-5)


def test_outer_bounds_hold_for_every_fitting_quadratic_that_a_random_search_finds() -> None:
    random = np.random.default_rng(4)
    boxes = [r.outer for r in table2_constants.ranges()]
    fitting = 0
    for _ in range(300):
        steps = random.uniform(-1, 1, 4) * (2e-3, 0.5, 1e-2, 3e-4)
        trial = [Fraction(float(w) + float(step)) for w, step in zip(WITNESS, steps, strict=True)]
        if not mismatches(*trial):
            fitting += 1
            assert all(box.holds(value) for box, value in zip(boxes, trial, strict=True))
    assert fitting > 3


def least_slack() -> Fraction:
    """How close an inequality comes to being broken by a quadratic whose root is in a corner of its printed digits' box.

    Each quadratic is made for its root in rational numbers, so that nothing of the certificate is used: a and d are chosen,
    and b and c follow from the root.
    """
    rows, slack = iter(table2_constants.inequalities()), []
    a_range, d = table2_fit.sum_interval(), WITNESS[3]
    for column in COLUMNS:
        for omega, pair in PRINTED[column].items():
            for re, im in pair:
                four = [next(rows) for _ in range(4)]
                digits = [Interval.printed(part) for part in (re, im)]
                for a in (a_range.low, a_range.high):
                    for x in (digits[0].low, digits[0].high):
                        for y in (digits[1].low, digits[1].high):
                            # s^2 + (a - j omega) s + b - j c omega + d f = 0 at s = x + j y, real and imaginary part
                            b = -(x * x - y * y + a * x + omega * y + d * table2_fit.scheduled(column, omega))
                            c = (2 * x * y + a * y - omega * x) / omega
                            slack += [bound - sum(k * v for k, v in zip(row, (a, b, c, d), strict=True)) for row, bound in four]
    assert next(rows, None) is None
    return min(slack)


def test_the_inequalities_hold_at_the_corners_of_the_digits_and_need_their_remainder(monkeypatch: pytest.MonkeyPatch) -> None:
    """The certificate's remainder: what the linear part alone leaves out breaks an inequality, and with it none breaks."""
    try:
        table2_constants.inequalities.cache_clear()
        assert least_slack() >= 0
        whole = table2_constants._remainder
        for share in (0, Fraction(1, 4)):
            monkeypatch.setattr(table2_constants, "_remainder", lambda *at, share=share: share * whole(*at))
            table2_constants.inequalities.cache_clear()
            assert least_slack() < 0, share
    finally:
        monkeypatch.undo()
        table2_constants.inequalities.cache_clear()


def test_every_printed_form_is_refuted_for_both_columns() -> None:
    found = table2_proofs.refutations()
    assert len(found) == 32
    assert all(r.proved for r in found), [r for r in found if not r.proved]
    forms = {r.form for r in found}
    for source in ("(7) expanded", "(7) as a matrix", "(8) expanded", "(8) as a matrix", "(12)", "(2)-(3)"):
        assert any(form.startswith(source) for form in forms), source


_A = table2_proofs.R_S / table2_proofs.SIGMA + 300
_X = table2_proofs.R_S / table2_proofs.SIGMA + 160
_RHO, _ALPHA = table2_proofs.R_S / table2_proofs.SIGMA, table2_proofs.ALPHAS["printed"]
CASES = {
    "(7) expanded, z feedback of (12)": ({w: (50 * w * w, 50 * w * _ALPHA) for w in SPEEDS}, _A),
    "(8) expanded, z feedback of (12)": ({w: (_ALPHA * 100 + 50 * w * w, 0) for w in SPEEDS}, _A),
    "(8) as a matrix equation, z feedback of (12)": ({w: (_ALPHA * 100 + 50 * w * w, -w * _RHO) for w in SPEEDS}, _A),
    "(7) as a matrix equation, z feedback of (12)": (
        {w: (_ALPHA * _RHO + 50 * w * w, w * (50 * _ALPHA - _RHO)) for w in SPEEDS}, _A),
    "(8) expanded": ({w: (_ALPHA * 100, -w) for w in SPEEDS}, _A),
    "(12) with its printed signs": ({w: (40_000, -_A * w) for w in SPEEDS}, _A),
    "(2)-(3) with any constant real 4x2 gain": ({w: (_ALPHA * _X + 80 * w, 80 * _ALPHA - w * _X) for w in SPEEDS}, _X + 300),
}


@pytest.mark.parametrize("form", CASES)
def test_a_table_made_with_a_form_is_not_refuted_for_that_form(form: str) -> None:
    """The argument can fail: fed with poles that the form does have, with Table III's parameters, it proves nothing."""
    products, a = CASES[form]
    table = as_printed(a, {w: (Fraction(re), Fraction(im)) for w, (re, im) in products.items()})
    for w, (re, im) in products.items():  # the table holds what it was made of: its pairs' roots, by numpy
        roots = np.roots([1.0, float(a) - 1j * w, complex(float(re), float(im))])
        assert np.sort_complex([complex(*map(float, one)) for one in table["baseline"][w]]) == pytest.approx(
            np.sort_complex(roots), abs=1e-6)
    verdicts = [r.proved for r in table2_proofs.refuted(table) if r.form == form and r.alphas != ("R_r/L_r",)]
    assert verdicts and not any(verdicts), verdicts


def test_required_gains_and_what_they_cannot_reach() -> None:
    needed = table2_proofs.required_gains()["printed"]
    assert needed["expanded"]["k_2"].holds(50)
    assert float(needed["expanded"]["k_1"].low) == pytest.approx(355.921, abs=1e-3)
    assert float(needed["sigma"].low) == pytest.approx(1.7242e-3, abs=1e-7)  # Table III: 3.1477e-3 H
    per_speed = table2_proofs.baseline_gains_needed(table2_proofs.ALPHAS["printed"])
    assert meet_all([g["l_4"] for g in per_speed.values()]) is None  # another set of gains at each speed


def test_baseline_gains_needed_do_give_the_column_at_each_speed() -> None:
    from imo_analysis.pencils.error import OperatingPoint, poles_at

    machine = preset("table-iii-printed-alpha")
    for k, (omega, gains) in enumerate(table2_proofs.baseline_gains_needed(table2_proofs.ALPHAS["printed"]).items()):
        middle = {name: float(i.low + i.high) / 2 for name, i in gains.items()}
        found = np.sort(poles_at(machine, "baseline", middle, OperatingPoint(float(omega), None)))
        assert found == pytest.approx(np.sort(printed("baseline")[k]), abs=0.02)


def test_data_set_beside_the_table() -> None:
    machine = preset("table-iii-printed-alpha")
    data = table2(machine, {"mine": ("consistent_12", {"k_1": 300.0, "k_2": 50.0, "k_3": 100.0})}, (30.0, 45.0))
    assert data["computed_re"].attrs["units"] == "1/s" and str(data["column"].values[0]) == "proposed"
    assert np.isfinite(data["difference"].sel(omega=30.0)).all() and np.isnan(data["difference"].sel(omega=45.0)).all()
    sums = data["computed_re"].sum("pole")  # two pairs, each with the sum of its real parts a
    assert sums.values == pytest.approx(-2 * (RHO + 300.0))
    repaired = table2(machine, {"r": ("repaired", {"k_1": 300.0, "kappa": 50.0, "k_3": 100.0})})
    assert np.isnan(repaired["printed_re"]).all()  # the paper has no such observer


def test_what_the_constants_are_where_8_is_read_as_a_matrix_equation() -> None:
    import sympy as sp

    R_s, L_m, sigma, beta, alpha = sp.symbols("R_s L_m sigma beta alpha", positive=True)
    k_1, k_2, k_3, omega = sp.symbols("k_1 k_2 k_3 omega", real=True)
    form = table2_proofs.invariants(table2_proofs.matrix_reading("consistent_12"))
    assert sp.cancel(form.a - (R_s / sigma + alpha * (1 + beta * L_m) + k_1)) == 0
    assert sp.cancel(form.D_re - (alpha * (R_s / sigma + k_3) + k_2 * omega**2)) == 0
    assert sp.cancel(form.D_im + omega * R_s / sigma) == 0
    expanded = table2_proofs.invariants(table2_proofs.expanded("consistent_12"))
    assert sp.cancel(expanded.D_re - (alpha * k_3 + k_2 * omega**2)) == 0 and expanded.D_im == 0
