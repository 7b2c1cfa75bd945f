"""Dimensions of formulas, and printed decimals as exact intervals."""

from fractions import Fraction

import pytest

from imo_analysis.errors import InputError
from imo_analysis.ledger import intervals
from imo_analysis.ledger.expression import parse, parse_relation
from imo_analysis.ledger.units import UnitError, dimension_of, dimension_text, unit_faults


@pytest.mark.parametrize(("formula", "text"), [
    ("R_s/sigma", "1/s"), ("beta*phi_dr", "A"), ("mu*(phi_dr*i_qs - phi_qr*i_ds)", "1/s^2"), ("i_ds_tilde_dot", "A/s"),
    ("u_ds*i_ds", "kg m^2/s^3"), ("V", "A^2"), ("sigma**2/L_s**2", "1"), ("abs(-omega)", "1/s"), ("1/beta", "kg m^2/(s^2 A^2)"),
])
def test_dimension_of_a_formula(formula: str, text: str) -> None:
    dimension = dimension_of(parse(formula))
    assert dimension is not None and dimension_text(dimension) == text


def test_the_part_at_fault_is_named() -> None:
    with pytest.raises(UnitError, match=r"adding kg m\^2/\(s\^3 A\) to A in i_ds \+ u_ds"):
        dimension_of(parse("alpha*(i_ds + u_ds) - i_qs_dot"))
    assert unit_faults(parse_relation("i_ds_dot = i_ds")) == ["A/s on the left, A on the right of i_ds_dot = i_ds"]
    assert unit_faults(parse_relation("omega_dot = mu*(phi_dr*i_qs - phi_qr*i_ds) - n_p*T_l/J")) == []


def test_zero_fits_anywhere_and_unknown_names_need_a_unit() -> None:
    assert unit_faults(parse_relation("i_ds + 0 = 0")) == []
    with pytest.raises(InputError, match="no symbol"):
        unit_faults(parse_relation("pressure = 0"))
    assert unit_faults(parse_relation("pressure = i_ds"), {"pressure": "A"}) == []


def test_a_printed_decimal_is_the_interval_that_rounds_to_it() -> None:
    assert intervals.printed("9.9354") == (Fraction("9.93535"), Fraction("9.93545"))
    assert intervals.printed("60.1e-3") == (Fraction("0.06005"), Fraction("0.06015"))
    assert intervals.printed("2") == (Fraction(3, 2), Fraction(5, 2))
    for wrong in ("", "nine", "1/2", "nan"):
        with pytest.raises(InputError):
            intervals.printed(wrong)


def test_intervals_contain_every_result() -> None:
    a, b = intervals.printed("0.41"), intervals.printed("-61.9e-3")
    for x in (a[0], a[1], sum(a) / 2):
        for y in (b[0], b[1], sum(b) / 2):
            for whole, value in (
                (intervals.add(a, b), x + y), (intervals.multiply(a, b), x * y), (intervals.divide(a, b), x / y),
            ):
                assert whole[0] <= value <= whole[1]
    assert not intervals.overlap(intervals.divide(a, intervals.printed("61.9e-3")), intervals.printed("9.9354"))
    with pytest.raises(InputError, match="contains zero"):
        intervals.divide(a, intervals.printed("0.0"))
