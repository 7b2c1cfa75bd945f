"""What is said of Table II: each answer recomputed another way, and each can come out false."""

from fractions import Fraction

import numpy as np
import pytest

from imo_analysis.machine import preset
from imo_analysis.pencils import table2_answers, table2_fit
from imo_analysis.pencils.error import OperatingPoint, poles_at
from imo_analysis.pencils.table2 import printed
from imo_analysis.pencils.table2_answers import answers, by_column, machines_with_the_same_table, powers, scheduled_baseline
from imo_analysis.pencils.table2_fit import COLUMNS, SPEEDS, WITNESS


def test_every_answer_is_shown_and_has_a_question() -> None:
    found = answers()
    assert all(one.shown for one in found), [one.question for one in found if not one.shown]
    assert [one.determined for one in found] == [True] * 6 + [False]
    assert len({one.question for one in found}) == len(found)


def test_powers_by_floating_point() -> None:
    """The printed products alone, no rounding considered: the power that fits three speeds lies in the interval."""
    for column, expected in (("proposed", 2.0), ("baseline", 1.0)):
        product = []
        for omega, row in zip(SPEEDS, printed(column), strict=True):
            pairs = [(x, y) for x in row for y in row if x.real < y.real and abs((x + y).imag - omega) < 0.02]
            product.append((pairs[0][0] * pairs[0][1]).real)
        ratio = (product[2] - product[1]) / (product[1] - product[0])
        low, high = 0.2, 4.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if (100**middle - 60**middle) / (60**middle - 30**middle) > ratio else (middle, high)
        found = powers()[column]
        assert float(found.low) < low < float(found.high)
        assert found.holds(Fraction(expected)) and float(found.high - found.low) < 0.03


def test_each_column_alone_has_the_constants() -> None:
    for column in COLUMNS:
        for name, value in zip("bcd", WITNESS[1:], strict=True):
            assert by_column()[column][name].holds(value)


def test_machines_that_the_table_cannot_tell_apart() -> None:
    """The matrix reading typed anew: i' = (-a + j w) i + alpha xi - j w z, xi' = -(b/alpha) i, z' = -(c + j d w) i."""
    found = machines_with_the_same_table()
    assert len({one["alpha"] for one in found}) == len(found) == 3
    for one in found:
        v = {name: float(value) for name, value in one.items()}
        rho = v["R_s"] / v["sigma"]
        for omega, row in zip(SPEEDS, printed("proposed"), strict=True):
            matrix = np.array([
                [-rho - v["alpha"] * (1 + v["beta"] * v["L_m"]) - v["k_1"] + 1j * omega, v["alpha"], -1j * omega],
                [-rho - v["k_3"], 0, 0],
                [-rho - 1j * v["k_2"] * omega, 0, 0]])
            roots = np.linalg.eigvals(matrix)
            roots = roots[np.argsort(np.abs(roots))[1:]]
            for root in roots:
                assert np.abs(row - root).min() < 0.0075


@pytest.mark.parametrize("column", COLUMNS)
def test_the_baseline_with_scheduled_gains_has_either_column(column: str) -> None:
    machine = preset("table-iii-printed-alpha")
    for omega, row in zip(SPEEDS, printed(column), strict=True):
        gains = {name: float(value) for name, value in scheduled_baseline(column, omega).items()}
        roots = poles_at(machine, "baseline", gains, OperatingPoint(float(omega), None))
        assert np.abs(np.sort_complex(roots)[:, None] - row[None, :]).min(axis=1).max() < 0.05  # the preset rounds Table III


def test_a_table_with_other_digits_is_answered_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    """The two columns exchanged: powers, difference and unfairness must all come out as not shown."""
    for one in (powers, by_column, machines_with_the_same_table):
        one.cache_clear()
    swapped = {"proposed": table2_fit.PRINTED["baseline"], "baseline": table2_fit.PRINTED["proposed"]}
    monkeypatch.setattr(table2_fit, "PRINTED", swapped)
    monkeypatch.setattr(table2_answers, "PRINTED", swapped)
    try:
        assert not table2_answers._structure().shown
        assert not table2_answers._fairness().shown
        with pytest.raises(AssertionError):
            table2_answers._difference()
        with pytest.raises(AssertionError, match="does not give the table"):
            machines_with_the_same_table()
    finally:
        for one in (powers, by_column, machines_with_the_same_table):
            one.cache_clear()
