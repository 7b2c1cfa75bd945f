"""Each kernel confirms what is true, and refuses what is not: wrong identities, wrong certificates, wrong counterexamples."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imo_analysis.ledger.expression import Expr, Name, Number, Op, Relation, evaluate, parse, parse_relation
from imo_analysis.ledger.kernels import NAMES, kernel
from imo_analysis.ledger.question import Question, Square
from imo_analysis.ledger.setting import setting

WHERE = setting(
    "where", "a test", {"w": parse("x/(y**2 + 1)"), "v": parse("abs(s)*w"), "leak": parse("(a*b - m*m)/b")},
    ["y > 0", "x >= 0", "k != 0", "b > 0", "leak > 0", "n < 0"], [{"s": 1}, {"s": -1}], {})
# Cases that fix different names: where only p is spoken of, the second case leaves it free.
MIXED = setting("mixed", "a test", {}, [], [{"p": 1}, {"r": 1}], {})


def _question(name: str, relation: str, kind: str = "identity", squares: tuple = (), point: dict | None = None) -> Question:
    return Question(name, WHERE, parse_relation(relation), kind, squares=[Square(parse(a), parse(b)) for a, b in squares],
                    point=point and {key: Fraction(value) for key, value in point.items()})


TRUE = [
    Question("true_in_mixed_cases", MIXED, parse_relation("(p - 1)*(r - 1) = 0"), "identity"),
    _question("cancels", "v*k/k = w"),
    _question("absolute_by_hypothesis", "x*abs(y)**2/y - x*y = 0"),
    _question("absolute_of_a_negative", "abs(n) = -n"),
    _question("absolute_of_a_product", "abs(x*y) = x*y"),
    _question("through_a_definition", "1/leak = b/(a*b - m**2)"),
    _question("negative_power", "k**-2*k = 1/k"),
    _question("squares", "-x*k**2/(y + 1) - y**3*w**2 <= 0", "squares", (("x/(y + 1)", "k"), ("y**3", "w"))),
    _question("negative_weights_cancel", "k**2*n/y <= 0", "squares", (("-n/y", "k"),)),
    _question("two_negatives", "0 <= x*m**2*n/(n*y)", "squares", (("x*n/(n*y)", "m"),)),
    _question("empty_sum", "x <= x", "squares"),
    _question("other_way_round", "m**2 >= 0", "squares", (("1", "m"),)),
    _question("differs", "v = 2*w", "counterexample", point={"x": 3, "y": Fraction(1, 2), "s": -1}),
    _question("not_below", "k*m <= m", "counterexample", point={"k": 2, "m": 1}),
]
FALSE = [
    _question("true_in_the_first_case_only", "s*w = w"),
    _question("true_in_the_second_case_only", "s*w = -w"),
    _question("bound_in_the_first_case_only", "0 <= s*k**2", "squares", (("s", "k"),)),
    Question("true_in_the_first_of_mixed_cases_only", MIXED, parse_relation("p = 1"), "identity"),
    _question("weight_over_what_may_be_zero", "0 <= k**2/x", "squares", (("1/x", "k"),)),
    _question("absolute_of_unknown_sign", "abs(m) = m"),
    _question("factor", "v = 2*w"),
    _question("sign", "abs(n) = n"),
    _question("no_certificate", "m**2 >= 0", "squares"),
    _question("certificate_of_something_else", "-x*k**2/(y + 1) <= 0", "squares", (("x/(y + 2)", "k"),)),
    _question("weight_of_unknown_sign", "-z*k**2/(y + 1) <= 0", "squares", (("z/(y + 1)", "k"),)),
    _question("true_at_the_point", "v = w", "counterexample", point={"x": 3, "y": Fraction(1, 2), "s": -1}),
    _question("point_outside_the_hypotheses", "v = 2*w", "counterexample", point={"x": -3, "y": 1, "s": -1}),
    _question("point_outside_the_cases", "v = 3*w", "counterexample", point={"x": 3, "y": 1, "s": 2}),
]


@pytest.mark.parametrize("name", [name if name != "coq" else pytest.param(name, marks=pytest.mark.slow) for name in NAMES])
def test_kernel_confirms_the_true_and_refuses_the_false(name: str) -> None:
    answers = dict(zip([q.id for q in (*TRUE, *FALSE)], kernel(name).answer([*TRUE, *FALSE]), strict=True))
    assert answers == {**{q.id: True for q in TRUE}, **{q.id: False for q in FALSE}}


@pytest.mark.parametrize("name", ["sympy", "flint"])
def test_residual_is_the_difference_in_lowest_terms(name: str) -> None:
    plain = setting("plain", "", {"c": parse("a/b")})
    shown = kernel(name).residual(plain, parse_relation("2*c + a*b/b**2 = a/b"))  # type: ignore[attr-defined]
    assert shown in (["(2*a)/(b)"], ["2*a/b"], ["(2*a)/b"])


def test_coqc_missing_is_said_with_the_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    from imo_analysis.errors import InputError

    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(InputError, match="apt install coq"):
        kernel("coq")


_LEAVES = st.one_of(st.sampled_from(["a", "b", "c"]).map(Name), st.integers(0, 3).map(Fraction).map(Number))
_TREES = st.recursive(_LEAVES, lambda inner: st.one_of(
    *(st.tuples(inner, inner).map(lambda pair, kind=kind: Op(kind, pair)) for kind in "+-*/"),
    st.tuples(inner, st.integers(0, 3)).map(lambda pair: pair[0] ** pair[1])), max_leaves=10)


@settings(max_examples=150, deadline=None)
@given(_TREES, _TREES)
def test_the_field_kernels_agree_with_each_other_and_with_exact_points(left: Expr, right: Expr) -> None:
    free = setting("free", "", {})
    pairs = [(left, right), (left, left + right - right), (left * right, right * left), (left, Op("neg", (-left,)))]
    questions = [Question(f"q{n}", free, Relation("=", a, b), "identity") for n, (a, b) in enumerate(pairs)]
    first, second = (kernel(name).answer(questions) for name in ("sympy", "flint"))
    assert first == second
    for (a, b), confirmed in zip(pairs, first, strict=True):
        values = []
        for n in (5, 7, 11, 13):
            point = {"a": Fraction(n), "b": Fraction(n * n + 2, 3), "c": Fraction(-n, n + 1)}
            try:
                values.append(evaluate(a, point) == evaluate(b, point))
            except ZeroDivisionError:
                continue
        if confirmed:
            assert all(values)
        elif len(values) == 4:  # degree at most 30: an identity of the field holds at all of them, a difference rarely at four
            assert not all(values) or _vanishes_somewhere(a) or _vanishes_somewhere(b)


def _vanishes_somewhere(tree: Expr) -> bool:
    """Whether the tree divides by something that is zero as a polynomial, so that it has no value in the field."""
    return not kernel("flint").answer([Question("q", setting("free", "", {}), Relation("=", tree, tree), "identity")])[0]
