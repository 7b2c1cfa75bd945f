"""Formulas for the page: valid MathML, accents that stay small, and differences that mark what differs and nothing else."""

import re
import xml.etree.ElementTree as ET

import pytest

from imo_analysis.notation import SYMBOLS, symbol
from imo_analysis.report.math import atoms, difference, font_face, mathml
from imo_analysis.report.words import typeset


def tree(latex: str) -> ET.Element:
    return ET.fromstring(mathml(latex))


@pytest.mark.parametrize("name", SYMBOLS)
@pytest.mark.parametrize("suffix", ["", "_hat", "_tilde", "_hat_dot"])
def test_every_symbol_can_be_set(name: str, suffix: str) -> None:
    assert "unread" not in mathml(symbol(name + suffix).latex)


@pytest.mark.parametrize("latex", [r"\hat{i}_{ds}", r"\dot{\hat{\alpha}}", r"\tilde{\xi}_1"])
def test_accents_do_not_stretch(latex: str) -> None:
    accents = list(tree(latex).iter("mover"))
    assert accents
    for over in accents:
        assert over.get("accent") == "true"
        assert over[1].get("stretchy") == "false"
        assert over[1].text not in ("^", "~")


def test_a_matrix_keeps_its_exponent() -> None:
    power = next(tree(r"\begin{bmatrix} 1 & 0 \\ 0 & 1 \end{bmatrix}^T").iter("msup"))
    assert len(power) == 2
    assert power[0].find(".//mtable") is not None


def test_aligned_rows_become_a_table() -> None:
    rows = list(tree(r"\begin{aligned} a &= b \\ c &= d \end{aligned}").iter("mtr"))
    assert len(rows) == 2


def test_a_minus_after_an_equals_sign_is_a_prefix() -> None:
    signs = [mo for mo in tree(r"x = -a - b").iter("mo") if mo.text == "\u2212"]
    assert [mo.get("form") for mo in signs] == ["prefix", None]


def test_what_cannot_be_read_is_shown_as_source() -> None:
    shown = mathml(r"\left( <b>")
    assert shown.startswith('<code class="unread">') and "<b>" not in shown


def test_equal_formulas_have_no_mark() -> None:
    text = r"\dot{\tilde{i}}_{ds} = -\left(\frac{R_s}{\sigma} + k_1\right) \tilde{i}_{ds}"
    assert "differs" not in "".join(difference(text, text))


def marks(latex: str) -> list[str]:
    return re.findall(r"\\class\{differs\}\{([^{}]*(?:\{[^{}]*\}[^{}]*)*)\}", latex)


@pytest.mark.parametrize(
    ("printed", "derived", "first", "second"),
    [
        ("a - b", "a + b", ["-"], ["+"]),
        (r"\frac{\alpha}{2 k_2} x", r"\frac{\alpha}{2 k_3} x", ["k_2"], ["k_3"]),
        (r"\left(a + \hat{b}\right)^{2}", r"\left(a + \tilde{b}\right)^{2}", [r"\hat{b}"], [r"\tilde{b}"]),
        (r"\frac{3 L_m}{2 L_r}", r"\frac{3 n_p^{2} L_m}{2 J L_r}", [], [r"n_p^{2}", "J"]),
    ],
)
def test_differences(printed: str, derived: str, first: list[str], second: list[str]) -> None:
    one, other = difference(printed, derived)
    assert (marks(one), marks(other)) == (first, second)
    assert "unread" not in mathml(one) + mathml(other)


def test_atoms_keep_scripts_and_pairs_together() -> None:
    found = atoms(r"x_{1}^{2} + \left(a - b\right)^{2} \frac{1}{2}")
    assert found == [r"x_{1}^{2}", "+", r"\left(a - b\right)^{2}", r"\frac{1}{2}"]


def test_the_font_is_inside_the_page() -> None:
    assert font_face().startswith('@font-face{font-family:"Imo Math";src:url(data:font/woff2;base64,')


def test_names_in_prose_become_symbols() -> None:
    shown = typeset("plus for minus before omega_tilde i_ds_hat; alpha >= alpha_l; `k_2` stays, so does a_word_of_ours")
    assert shown.count("<math") == 4
    assert "≥" in shown and "<code>k_2</code>" in shown and "a_word_of_ours" in shown
