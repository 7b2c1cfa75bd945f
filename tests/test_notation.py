"""The notation table: suffixes, units, dimensions."""

from fractions import Fraction

import pytest

from imo_analysis.errors import InputError
from imo_analysis.notation import SYMBOLS, dimension, symbol


def test_suffixes_compose() -> None:
    assert symbol("alpha_hat_dot").latex == r"\dot{\hat{\alpha}}"
    assert symbol("alpha_hat_dot").unit == "1/s^2"
    assert symbol("i_ds_tilde").latex == r"\tilde{i}_{ds}"
    assert dimension(symbol("z_1_dot").unit) == (0, 0, -1, 1)


def test_every_unit_can_be_read_and_every_symbol_has_words() -> None:
    for entry in SYMBOLS.values():
        dimension(entry.unit)
        assert entry.meaning and entry.latex


def test_dimensions() -> None:
    assert dimension("1/(A^2 s^2)") == (0, 0, -2, -2)
    assert dimension("kg m^2/s^2") == dimension("J") == dimension("N m") == dimension("Wb A")
    assert dimension("ohm") == dimension("V/A") == dimension("H/s")
    assert dimension("rad/s") == (Fraction(0), 0, -1, 0)


@pytest.mark.parametrize("unit", ["parsec", "A)", "m^x", "A,s"])
def test_unknown_units_are_refused(unit: str) -> None:
    with pytest.raises(InputError):
        dimension(unit)


def test_unknown_names_are_refused() -> None:
    with pytest.raises(InputError, match="no symbol 'foo'"):
        symbol("foo")
