"""Trees: reading, writing, tracing, typesetting, and the derivative by dual numbers against sympy's."""

from fractions import Fraction
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from imo_analysis.equations.plant import plant_z
from imo_analysis.errors import InputError
from imo_analysis.ledger.audit import from_sympy
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Expr, Name, Number, evaluate, free_names, names, parse, parse_relation, substitute
from imo_analysis.ledger.latex import relation_latex, to_latex

_LEAVES = st.one_of(
    st.sampled_from(["alpha", "omega_hat", "i_ds_tilde", "k_2"]).map(Name), st.integers(0, 9).map(Fraction).map(Number))


def _grow(children: st.SearchStrategy[Expr]) -> st.SearchStrategy[Expr]:
    pair = st.tuples(children, children)
    return st.one_of(
        pair.map(lambda p: p[0] + p[1]), pair.map(lambda p: p[0] - p[1]), pair.map(lambda p: p[0] * p[1]),
        pair.map(lambda p: p[0] / p[1]), children.map(lambda c: -c), children.map(abs),
        st.tuples(children, st.integers(-2, 3)).map(lambda p: p[0] ** p[1]),
    )


_TREES = st.recursive(_LEAVES, _grow, max_leaves=12)


@given(_TREES)
def test_writing_and_reading_give_the_tree_back(tree: Expr) -> None:
    assert parse(str(tree)) == tree


@given(_TREES)
def test_every_tree_can_be_typeset(tree: Expr) -> None:
    text = to_latex(tree)
    assert text.count("{") == text.count("}") and text.count(r"\left") == text.count(r"\right")


@pytest.mark.parametrize("text", [
    "__import__('os').system('true')", "a.b", "a[0]", "a if b else c", "lambda: 1", "f(a)", "a ** b", "a ** 0.5", "a ** 9999",
    "a // b", "a @ b", "'text'", "1j", "True", "a := 1", "abs(a, b)", "abs(a, key=b)", "a < b", "", "a +", "[a]", "not a", "+a",
])
def test_anything_that_is_not_a_formula_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError) as caught:
        parse(text)
    assert "formula" in str(caught.value) and "\n" not in str(caught.value)


def test_deep_and_long_formulas_are_refused() -> None:
    for text in ("(" * 4000 + "a" + ")" * 4000, "a+" * 30000 + "a"):
        with pytest.raises(InputError):
            parse(text)


def test_decimals_are_exact() -> None:
    assert evaluate(parse("0.1 + 0.2"), {}) == Fraction(3, 10)


def test_a_float_never_enters_a_formula() -> None:
    with pytest.raises(InputError, match="exact"):
        Name("alpha") * 0.5


def test_tracing_a_definition_equals_running_it() -> None:
    random = Random(4)
    x, u, p = names("i_ds i_qs z_1 z_2"), names("u_ds u_qs"), names("R_s L_m sigma beta alpha")
    rows = plant_z(x, u, Name("omega"), Name("omega_1"), p)
    values = {n.name: Fraction(random.randint(-9, 9) or 3, random.randint(1, 5)) for n in (*x, *u, *p, *names("omega omega_1"))}

    def at(which: tuple[Name, ...]) -> tuple[Fraction, ...]:
        return tuple(values[n.name] for n in which)

    assert tuple(evaluate(row, values) for row in rows) == plant_z(at(x), at(u), values["omega"], values["omega_1"], at(p))
    assert free_names(rows[3]) == ["R_s", "sigma", "i_qs", "omega_1", "z_1", "u_qs"]


def test_printed_order_hats_tildes_dots_and_fractions_are_kept() -> None:
    relation = parse_relation("z_1_tilde_dot = -R_s/sigma*i_ds_hat - k_2*omega_hat*(i_ds - i_ds_hat)**2")
    assert relation_latex(relation) == (
        r"\dot{\tilde{z}}_1 = -\frac{R_s}{\sigma} \hat{i}_{ds} - k_2 \hat{\omega} \left(i_{ds} - \hat{i}_{ds}\right)^{2}")


def test_words_do_not_run_together() -> None:
    assert to_latex(parse("alpha*depth*angle_cosine")) == r"\alpha \, \mathrm{depth} \, \mathrm{angle}_{cosine}"
    assert to_latex(parse("alpha*beta*2")) == r"\alpha \beta \cdot 2"


def test_substitution_is_simultaneous() -> None:
    assert str(substitute(parse("a + b"), {"a": Name("b"), "b": Name("a")})) == "b + a"


def test_dual_numbers_agree_with_sympy() -> None:
    sympy = pytest.importorskip("sympy")
    formula = parse("omega/(2*k_2*omega_hat)*(z_1**2 + z_2**2) + abs(alpha)*z_1**3/(1 + z_2**2) - 2/omega_hat**2")
    moving = ["omega_hat", "z_1", "z_2", "alpha"]
    every = free_names(formula)
    rate = rate_along(lambda **q: evaluate(formula, q), {n: Name(n) for n in every}, {n: Name(f"{n}_dot") for n in moving})
    symbols = {n: sympy.Symbol(n, real=True) for n in [*every, *(f"{m}_dot" for m in moving)]}
    whole = evaluate(formula, symbols, lambda v: sympy.Rational(v.numerator, v.denominator))
    second = sum(sympy.diff(whole, symbols[n]) * symbols[f"{n}_dot"] for n in moving)
    random = Random(2)
    for _ in range(10):
        point = {n: Fraction(random.randint(-7, 7) or 2, random.randint(1, 4)) for n in symbols}
        exact = second.subs({symbols[n]: sympy.Rational(v.numerator, v.denominator) for n, v in point.items()})
        assert evaluate(rate, point) == Fraction(int(exact.p), int(exact.q))


def test_sympy_expressions_become_formulas() -> None:
    sympy = pytest.importorskip("sympy")
    a, b = sympy.symbols("a b")
    tree = from_sympy((a - b / 3) ** 2 / b + sympy.Abs(a) * b**-2)
    values = {"a": Fraction(-5, 2), "b": Fraction(7)}
    assert evaluate(tree, values) == (Fraction(-5, 2) - Fraction(7, 3)) ** 2 / 7 + Fraction(5, 2) / 49
    with pytest.raises(InputError):
        from_sympy(sympy.sin(a))
