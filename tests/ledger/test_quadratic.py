"""Quadratic forms as sums of squares, found by L D L^T and checked by the kernels."""

import pytest

from imo_analysis.errors import InputError
from imo_analysis.ledger.claim import Claim, Verdict
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.quadratic import squares_of
from imo_analysis.ledger.setting import setting
from imo_analysis.ledger.settle import settle

NAMES = {"x": "1", "y": "1", "z": "1", "a": "1", "c": "1"}
WHERE = setting("form", "", {}, ["a > 0", "a*c - 1 > 0"], units=NAMES)


def test_the_certificate_settles_the_inequality_in_two_kernels() -> None:
    form = "a*x**2 + 2*x*y + c*y**2 + (x + y - z)**2/a"
    claim = Claim("form", "", "", Verdict.HOLDS, WHERE, printed=f"0 <= {form}", squares=squares_of(form, ["z", "x", "y"]))
    entry = settle([claim], [kernel("sympy"), kernel("flint")])[0]
    assert entry.ok and entry.verdict is Verdict.HOLDS


def test_numbers_and_symbols() -> None:
    assert squares_of("x**2 + x*y + y**2", ["x", "y"]) == (("1", "x + (1/2)*y"), ("3/4", "y"))
    assert squares_of("a*x**2 + 2*x*y + c*y**2", ["x", "y"]) == (("a", "x + ((1)/(a))*y"), ("(a*c - 1)/(a)", "y"))
    assert squares_of("0*x**2 + y**2", ["x", "y"]) == (("1", "y"),)


@pytest.mark.parametrize("form", ["x**2 + y", "x**3", "x**2*y**2", "1 + x**2"])
def test_what_is_not_a_quadratic_form_is_refused(form: str) -> None:
    with pytest.raises(InputError, match="not a quadratic form"):
        squares_of(form, ["x", "y"])


def test_an_indefinite_form_with_a_zero_pivot_is_refused() -> None:
    with pytest.raises(InputError, match="indefinite"):
        squares_of("2*x*y", ["x", "y"])
