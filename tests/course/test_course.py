"""The lessons run from top to bottom unanswered; every hidden solution is right, every declared mistake wrong with its hint."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from imo_analysis.exercises.exercise import LESSONS, Formula, Number, exercise, exercises, judge
from imo_analysis.exercises.lesson_05 import FORM
from imo_analysis.ledger.expression import Name
from imo_analysis.notebooks import sources, title

FILES = sources("course")
NUMBERS = range(1, LESSONS + 1)
IDS = [one.id for number in NUMBERS for one in exercises(number)]


def cells(path: Path) -> list[tuple[str, str]]:
    """Kind and text of each cell, without the comment marks of markdown."""
    found = []
    for part in re.split(r"(?m)^# %%", path.read_text(encoding="utf-8"))[1:]:
        head, _, body = part.partition("\n")
        if "[markdown]" in head:
            body = "\n".join(line.removeprefix("#").removeprefix(" ") for line in body.splitlines())
        found.append(("markdown" if "[markdown]" in head else "code", body.strip()))
    return found


def prose(path: Path) -> str:
    return "\n\n".join(text for kind, text in cells(path) if kind == "markdown")




@pytest.mark.parametrize("number", NUMBERS)
def test_a_lesson_runs_unanswered_and_its_solutions_are_right(number, capsys):
    path = FILES[number - 1]
    names = runpy.run_path(str(path), run_name="__main__")
    printed = capsys.readouterr().out
    solutions = dict(re.findall(r"<summary>Solution ([\d.]+)</summary>.*?```python\n(.*?)```", prose(path), flags=re.DOTALL))
    have = [one.id for one in exercises(number)]
    assert list(solutions) == have and len(have) >= 3
    for identifier in have:
        assert f"{identifier}: not answered yet." in printed
        name = f"answer_{identifier.replace('.', '_')}"
        assert names[name] is Ellipsis
        exec(solutions[identifier], names)
        outcome = judge(identifier, names[name])
        assert outcome.right is True, outcome.text


@pytest.mark.parametrize("identifier", IDS)
def test_wrong_answers_are_rejected_with_their_hint(identifier):
    wrong = exercise(identifier).wrong()
    assert len(wrong) >= 2
    for answer, hint in wrong:
        outcome = judge(identifier, answer)
        assert outcome.right is False, (answer, outcome.text)
        assert hint and hint in outcome.text, (answer, outcome.text)


@pytest.mark.parametrize("identifier", IDS)
def test_nonsense_is_wrong_and_never_raises(identifier):
    assert judge(identifier, ...).right is None
    for answer in ("", "no idea", "__import__('os')", None, float("nan"), float("inf"), {}, [], (1, 2, 3), lambda: 0, object()):
        assert judge(identifier, answer).right is False, answer


@pytest.mark.parametrize("identifier", [one.id for n in NUMBERS for one in exercises(n) if isinstance(one, Number)])
def test_a_number_that_is_a_little_off_is_wrong(identifier):
    truth = float(exercise(identifier).truth())
    assert judge(identifier, truth).right is True
    for factor in (0.95, 1.05, 2.0, 0.0):
        assert judge(identifier, factor * truth).right is False
    unit = exercise(identifier).unit
    if unit != "1":
        assert judge(identifier, f"{truth!r} {unit}").right is True
        assert judge(identifier, f"{truth!r} kg").right is False


@pytest.mark.parametrize("identifier", [one.id for n in NUMBERS for one in exercises(n) if isinstance(one, Formula)])
def test_a_formula_in_another_form_is_right_and_one_more_term_is_wrong(identifier):
    truth = exercise(identifier).right()
    other = tuple((tree * Name("alpha") - Name("beta") + Name("beta")) / Name("alpha") for tree in truth)
    assert judge(identifier, other).right is True
    more = tuple(tree + Name("alpha") for tree in truth)
    assert judge(identifier, more).right is False
    assert judge(identifier, "V_dot").right is judge(identifier, "z_1_dot").right is False


def test_formulas_are_taken_from_sympy():
    import sympy

    alpha, k_2, k_3, omega = sympy.symbols("alpha k_2 k_3 omega")
    assert judge("6.1", sympy.expand(alpha * k_3 + k_2 * omega**2)).right is True
    assert judge("6.1", alpha * k_3 + 2 * k_2 * omega**2).right is False
    assert judge("3.4", (k_2 * omega**2, alpha * k_2 * omega)).right is True


@pytest.mark.parametrize(
    ("identifier", "answer"),
    [("1.1", [["8.83 A"]]), ("1.2", "15.46 Nm"), ("1.3", "2000 rpm"), ("1.4", "2/3*R_r*torque/(n_p*phi_dr^2)"), ("7.3", "4"),
     ("4.3", "K_p*((i_ds - i_ds_hat)*(z_2_hat - i_qs_hat) - (i_qs - i_qs_hat)*(z_1_hat - i_ds_hat))"),
     ("5.1", "-2*(omega*i_ds - omega_hat*i_ds_hat)"), ("6.1", "alpha_hat*k_3 + k_2*omega_hat*omega"),
     ("9.4", lambda d, q, kappa, s: [-kappa * s * q, kappa * s * d]),
     ("10.2", lambda d, q, kappa, a, w: [kappa * (a * d - w * q), kappa * (a * q + w * d)])])
def test_what_is_right_in_another_way_of_writing_is_right(identifier, answer):
    outcome = judge(identifier, answer)
    assert outcome.right is True, outcome.text


@pytest.mark.parametrize(
    ("identifier", "answer", "hint"),
    [("1.2", "15.46 N", "wrong unit"), ("3.3", set(), "at least one"), ("4.3", "K_p*(i_ds*z_2_hat - i_qs*z_1_hat)", "v_2"),
     ("2.3", np.complex128(-321.755 + 12j), "complex"), ("6.1", "alpha*k_3 + k_2*omega_hat", "another omega"),
     ("7.3", "four", "evaluated")])
def test_what_is_nearly_right_is_wrong(identifier, answer, hint):
    outcome = judge(identifier, answer)
    assert outcome.right is False
    assert hint in outcome.text


def test_a_certificate_of_another_shape_is_taken():
    other = [("2/k_1", "w_1 + k_1*i_ds_tilde/2"), ("k_1/2", "i_ds_tilde")]
    assert judge("5.2", other).right is True
    assert str(FORM.op) == ">="


def test_unknown_exercises_are_named():
    from imo_analysis.errors import InputError

    for wrong in ("3.9", "11.1", "x", ""):
        with pytest.raises(InputError, match="exercise"):
            exercise(wrong)


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_a_lesson_is_complete(path):
    text = prose(path)
    assert all(f"**{word}.**" in text for word in ("Goals", "Needs", "Time"))
    assert "**Write down what you expect" in text
    assert "## What to take along" in text or "## Where to go from here" in text
    assert text.count("<details>") == text.count("</details>") >= 3
    for kind, cell in cells(path):
        if kind == "markdown":
            plain = re.sub(r"```.*?```|`[^`]*`", "", cell, flags=re.DOTALL)
            assert plain.count("$") % 2 == 0, cell[:200]
            assert not re.search(r"https?://|<img|<script", cell)
    assert not re.search(r"(?<![\w.])/(?:home|root|work)/\w", path.read_text(encoding="utf-8"))


def test_the_index_names_all_lessons():
    index = (FILES[0].parent / "README.md").read_text(encoding="utf-8")
    for number, path in enumerate(FILES, start=1):
        minutes = re.search(r"About (\d+) minutes", prose(path))
        assert minutes
        assert f"| [{number}]({path.name}) | {title(path).removeprefix(f'Lesson {number}. ')} | {minutes[1]} |" in index
