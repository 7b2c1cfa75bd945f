"""The verdict is computed: what changes it, what is an error of the tool, and what a reader is shown."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import pytest

from imo_analysis.errors import InputError
from imo_analysis.ledger import show
from imo_analysis.ledger.claim import Algebra, Claim, Computed, Entry, Verdict
from imo_analysis.ledger.expression import parse, parse_relation
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.question import Question
from imo_analysis.ledger.sampling import counterexample, points
from imo_analysis.ledger.setting import Setting, setting, true_at
from imo_analysis.ledger.settle import settle

HOLDS, CORRECTED, FAILS, OPEN = Verdict.HOLDS, Verdict.CORRECTED, Verdict.FAILS, Verdict.OPEN
WHERE = setting("where", "a test", {"z_1": parse("i_ds + beta*phi_dr")}, ["beta > 0", "sigma != 0"])


def _entry(expected: Verdict, kernels: Sequence[Any] | None = None, **fields: Any) -> Entry:
    claim = Claim(**{"id": "x", "item": "(1)", "title": "t", "expected": expected, "setting": WHERE, **fields})
    return settle([claim], kernels or [kernel("sympy"), kernel("flint")])[0]


class Contrary:
    """A kernel that says yes to everything, or no to everything."""

    name = "contrary"

    def __init__(self, answer: bool) -> None:
        self._answer = answer

    def answer(self, questions: Sequence[Question]) -> list[bool]:
        return [self._answer] * len(questions)


def test_the_four_verdicts() -> None:
    true, false = "z_1 - i_ds = beta*phi_dr", "z_1 + i_ds = beta*phi_dr"
    assert _entry(HOLDS, printed=true).verdict is HOLDS
    assert _entry(CORRECTED, printed=false, corrected=true, edit="sign").verdict is CORRECTED
    assert _entry(FAILS, printed=false).verdict is FAILS
    readings = (Algebra("reading", "one", (true,)), Algebra("reading", "other", (false,)))
    assert _entry(OPEN, checks=readings).verdict is OPEN
    assert all(_entry(verdict, **fields).ok for verdict, fields in (  # type: ignore[arg-type]
        (HOLDS, {"printed": true}), (CORRECTED, {"printed": false, "corrected": true, "edit": "sign"}),
        (FAILS, {"printed": false}), (OPEN, {"checks": readings}), (OPEN, {})))


def test_a_verdict_that_is_not_the_expected_one_is_an_error() -> None:
    entry = _entry(HOLDS, printed="z_1 = i_ds")
    assert entry.verdict is FAILS and "expected was holds" in entry.errors[0]


def test_a_correction_that_is_wrong_is_not_accepted() -> None:
    entry = _entry(CORRECTED, printed="z_1 = i_ds", corrected="z_1 = 2*i_ds", edit="a wrong one")
    assert entry.verdict is None and not entry.ok


@pytest.mark.parametrize("answer", [True, False])
def test_kernels_that_disagree_are_an_error(answer: bool) -> None:
    question = "z_1 - i_ds = beta*phi_dr" if not answer else "beta*phi_dr <= z_1"
    entry = _entry(HOLDS, [kernel("flint"), Contrary(answer)], printed=question, squares=(("1", "i_ds"),) if answer else ())
    if not answer:
        assert any("kernels disagree" in error for error in entry.errors) and entry.verdict is None
    else:  # a false inequality is refuted by a point, which flint confirms; the contrary kernel agrees with everything
        assert entry.verdict is FAILS


def test_an_unproved_inequality_is_not_called_true() -> None:
    assert _entry(HOLDS, printed="0 <= i_ds**2 + phi_dr**2").verdict is None
    assert _entry(HOLDS, printed="0 <= i_ds**2", squares=(("1", "i_ds"),)).verdict is HOLDS


def test_a_denominator_without_a_hypothesis_is_an_error() -> None:
    entry = _entry(HOLDS, printed="i_ds*R_s/R_s = i_ds")
    assert "the denominator R_s needs a hypothesis" in entry.errors[0]
    assert _entry(HOLDS, printed="i_ds*sigma/sigma = i_ds").ok


def test_a_computed_check_must_reject_its_failing_input() -> None:
    def even(number: int) -> tuple[bool, str]:
        return number % 2 == 0, f"{number}"

    assert _entry(HOLDS, checks=(Computed("printed", "even", even, True, (2,), (3,)),)).ok
    assert not _entry(HOLDS, checks=(Computed("printed", "even", even, True, (2,), (4,)),)).ok
    failing = _entry(FAILS, checks=(Computed("printed", "even", even, True, (3,), passing=(2,)),))
    assert failing.ok and failing.verdict is FAILS
    assert not _entry(FAILS, checks=(Computed("printed", "even", even, True, (3,), passing=(5,)),)).ok


def test_a_computed_check_with_one_answer_only_is_an_error() -> None:
    def never(number: int) -> tuple[bool, str]:
        return False, f"{number}"

    def always(number: int) -> tuple[bool, str]:
        return True, f"{number}"

    one_sided = _entry(FAILS, checks=(Computed("printed", "no", never, True, (2,)),))
    assert "needs an input that it passes" in one_sided.errors[0]
    one_sided = _entry(HOLDS, checks=(Computed("printed", "yes", always, True, (2,)),))
    assert "needs an input that it rejects" in one_sided.errors[0]


def test_an_absolute_value_of_unknown_sign_is_not_settled_and_stops_no_other_claim() -> None:
    entry = _entry(HOLDS, printed="abs(i_ds)**2 = i_ds**2")
    assert entry.verdict is None and entry.findings[0].true is None
    assert "not settled" in entry.errors[0] and "abs(i_ds): its sign does not follow" in entry.errors[0]
    refuted = _entry(FAILS, printed="abs(i_ds) = i_ds")
    assert refuted.ok and refuted.findings[0].detail["residual"] == ""


def test_a_square_over_what_may_be_zero_is_an_error() -> None:
    may_be_zero = setting("may_be_zero", "", {}, ["alpha >= 0"])
    fields: dict[str, Any] = {"printed": "0 <= i_ds**2/alpha", "squares": (("1/alpha", "i_ds"),)}
    entry = _entry(HOLDS, **fields, setting=may_be_zero)
    assert entry.verdict is None and "the denominator alpha needs a hypothesis" in entry.errors[0]
    in_the_square = _entry(HOLDS, printed="0 <= i_ds**2", squares=(("1/alpha*alpha", "i_ds"),), setting=may_be_zero)
    assert in_the_square.verdict is None and "the denominator alpha needs a hypothesis" in in_the_square.errors[0]


def test_a_name_that_is_zero_by_hypothesis_is_zero_at_every_point() -> None:
    still = setting("still", "", {}, ["z_2 = 0", "beta > 0"])
    assert all(point["z_2"] == 0 for point in points(still, [parse_relation("z_2*i_ds = beta")], 5))
    entry = _entry(FAILS, printed="i_ds = z_2", setting=still)
    assert entry.ok and entry.findings[0].detail["point"]["z_2"] == "0"


def test_what_rests_on_a_citation_says_so() -> None:
    entry = _entry(HOLDS, printed="z_1 - i_ds = beta*phi_dr", cited="Khalil, Lemma 8.2")
    assert entry.verdict is HOLDS and entry.label == "holds (cited)"
    assert "holds (cited)" in show.table([entry]) and "Khalil, Lemma 8.2" in show.full(entry)
    assert entry.to_dict()["cited"] == "Khalil, Lemma 8.2"


def test_units_are_checked_and_expected_faults_are_named() -> None:
    entry = _entry(FAILS, printed="z_1 = i_ds + t")
    assert entry.unit_faults == ["adding s to A in i_ds + t"] and not entry.ok
    assert _entry(FAILS, printed="z_1 = i_ds + t", units="a time is added to a current").ok
    assert not _entry(HOLDS, printed="z_1 - i_ds = beta*phi_dr", units="nothing is wrong here").ok


def test_cases_are_all_settled() -> None:
    both = setting("both", "", {"magnitude": parse("s*omega")}, cases=({"s": 1}, {"s": -1}),
                   units={"magnitude": "1/s", "s": "1"})
    assert _entry(HOLDS, printed="s*magnitude = omega", setting=both).verdict is HOLDS
    entry = _entry(FAILS, printed="magnitude = omega", setting=both)
    assert entry.verdict is FAILS and entry.findings[0].detail["point"]["s"] == "-1"


def test_counterexamples_are_small_exact_and_true() -> None:
    relation = parse_relation("z_1*sigma = i_ds*sigma + beta*phi_dr*sigma + (R_s - 2)*omega*beta")
    point = counterexample(WHERE, relation)
    assert point is not None and set(point.values()) <= {Fraction(0), Fraction(1), Fraction(-1), Fraction(2)}
    values = WHERE.values(point)
    assert not true_at(relation, values) and all(true_at(one, values) for one in WHERE.hypotheses_for(point))
    assert counterexample(WHERE, parse_relation("z_1 = i_ds + beta*phi_dr")) is None


def test_hypotheses_that_contradict_each_other_are_refused() -> None:
    with pytest.raises(InputError, match="contradict"):
        points(setting("none", "", {}, ["alpha > 0", "alpha < 0"]), [parse_relation("alpha = alpha")], 1)


def test_definitions_come_in_any_order_but_not_in_circles() -> None:
    ordered = setting("any", "", {"b": parse("a + 1"), "a": parse("2*x")})
    assert list(ordered.definitions) == ["a", "b"]
    with pytest.raises(InputError, match="a -> b -> a"):
        setting("circle", "", {"a": parse("b"), "b": parse("a")})


def test_an_entry_shows_the_difference_and_the_point() -> None:
    entry = _entry(CORRECTED, printed="z_1 = i_ds - beta*phi_dr", corrected="z_1 = i_ds + beta*phi_dr", edit="plus for minus")
    text = show.full(entry, 100)
    lines = text.splitlines()
    above, below, marks = (next(n for n, line in enumerate(lines) if line.strip().startswith(word)) for word in
                           ("printed", "corrected", "^"))
    assert below == above + 1 and marks == below + 1
    where = lines[marks].index("^")
    assert lines[above][where] == "-" and lines[below][where] == "+"
    assert "left = " in text and "plus for minus" in text
    data = entry.to_dict()
    assert data["verdict"] == "holds after correction" and data["printed"][0]["latex"].startswith("z_1 = i_{ds}")


def test_the_setting_is_shared_not_copied() -> None:
    assert isinstance(WHERE.extended("more", definitions={"y": parse("z_1**2")}), Setting)
    with pytest.raises(TypeError):
        WHERE.definitions["new"] = parse("1")  # type: ignore[index]


def test_several_formulas_of_one_check_are_shown_under_one_heading() -> None:
    both = Algebra("evidence", "two rows", ("z_1 - i_ds = beta*phi_dr", "i_ds - z_1 = -beta*phi_dr"))
    text = show.full(_entry(HOLDS, printed="z_1 = z_1", checks=(both,)))
    assert text.count("two rows") == 1
    assert "z_1 - i_ds = beta*phi_dr" in text and "i_ds - z_1 = -beta*phi_dr" in text
