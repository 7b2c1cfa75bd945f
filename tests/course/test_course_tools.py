"""What the lessons share: checks that print, predictions, formulas, figures with and without sliders."""

from __future__ import annotations

import pytest

from imo_analysis import course_tools
from imo_analysis.drawing import new_figure
from imo_analysis.errors import InputError
from imo_analysis.exercises.exercise import equal
from imo_analysis.ledger.expression import names, parse
from imo_analysis.ledger.setting import setting


def drawing(depth=0.1, frequency=20.0):
    figure, axes = new_figure(height=2.0)
    axes.plot([0, depth], [0, frequency])
    return figure


@pytest.mark.parametrize(
    ("guess", "words"),
    [(10.5, "well seen"), (15, "the right order"), (-20, "far off"), (..., "no prediction"), ("ten", "you wrote")])
def test_a_prediction_beside_the_result(guess, words, capsys):
    course_tools.expected(guess, 10.0, "A")
    said = capsys.readouterr().out
    assert "it is 10 A" in said and words in said


@pytest.mark.parametrize(("guess", "words"), [(1, "well seen"), (2, "not so"), (0, "not so"), ("one", "you wrote")])
def test_a_count_is_right_or_not(guess, words, capsys):
    course_tools.expected(guess, 1, "of three")
    assert words in capsys.readouterr().out


def test_check_says_right_wrong_or_nothing_yet(capsys):
    for answer, word in ((..., "not answered yet"), ("8.83 A", "right"), (0.5307 / 61.9e-3, "L_m"), ("9 V", "wrong unit")):
        course_tools.check("1.1", answer)
        assert word in capsys.readouterr().out


def test_rows_are_printed_in_a_script(capsys):
    course_tools.rows(("z_1_dot",), (names("i_ds")[0] * 2,))
    assert capsys.readouterr().out.strip() == "z_1_dot = i_ds*2"


@pytest.mark.parametrize(
    ("long", "short"),
    [("a + (-b*c)", "a - b*c"), ("a*1*(b + c)", "a*(b + c)"), ("a + (-b*c/d) + e", "a - b*c/d + e"), ("1*1", "1"),
     ("a - (-b)", "a - (-b)"), ("a + b**2", "a + b**2"), ("-a*b + c", "-a*b + c")])
def test_a_formula_is_written_plainly_and_stays_equal(long, short):
    tree = course_tools.plain(parse(long))
    assert tree == parse(short)
    assert equal(setting("plain", "", {}, ("d != 0",)), tree, parse(long))


def test_an_entry_in_full(capsys):
    course_tools.entry("eq12.i_qs")
    said = capsys.readouterr().out
    assert "holds after correction" in said and "flint, sympy" in said
    with pytest.raises(InputError, match="not in the ledger"):
        course_tools.entry("eq99.x")


def test_a_figure_in_a_script_is_only_counted(capsys):
    assert course_tools.vary(drawing, depth=(0.0, 0.2, 0.1)) is None
    said = capsys.readouterr().out
    assert "a figure with 1 axes" in said and "depth from 0 to 0.2" in said


def test_a_figure_in_a_notebook_has_a_caption(monkeypatch, capsys):
    monkeypatch.setattr(course_tools, "in_notebook", lambda: True)
    monkeypatch.setattr(course_tools, "_display", lambda kind, value: None)
    monkeypatch.setenv("IMO_STATIC", "1")
    course_tools.vary(drawing, depth=(0.0, 0.2, 0.1), frequency=(5.0, 60.0, 5.0))
    assert "figure: drawing; depth = 0.1, frequency = 20\n" in capsys.readouterr().out


def test_vary_needs_a_parameter_with_a_default():
    with pytest.raises(InputError, match="must be a parameter"):
        course_tools.vary(drawing, width=(0.0, 1.0, 0.1))


def test_sliders_where_ipywidgets_is_installed(monkeypatch):
    widgets = pytest.importorskip("ipywidgets")
    shown = []
    monkeypatch.setattr(course_tools, "in_notebook", lambda: True)
    monkeypatch.setattr(course_tools, "_display", lambda kind, value: shown.append((kind, value)))
    monkeypatch.delenv("IMO_STATIC", raising=False)
    course_tools.vary(drawing, depth=(0.0, 0.2, 0.1), frequency=(5.0, 60.0, 5.0))
    sliders = shown[-1][1]
    assert isinstance(sliders, widgets.interactive)
    assert [(one.min, one.value, one.max) for one in sliders.children[:2]] == [(0.0, 0.1, 0.2), (5.0, 20.0, 60.0)]
    shown.clear()
    sliders.children[1].value = 60.0
    sliders.update()
    first = [value for kind, value in shown if kind == "SVG"]
    assert first and "<svg" in first[-1]
    monkeypatch.setenv("IMO_STATIC", "1")
    shown.clear()
    course_tools.vary(drawing, depth=(0.0, 0.2, 0.1))
    assert [kind for kind, _ in shown] == ["SVG"]


VARIED = """from imo_analysis.course_tools import vary
from imo_analysis.drawing import new_figure


def drawing(depth=0.1):
    return new_figure(height=2.0)[0]


vary(drawing, depth=(0.0, 0.2, 0.1))"""


@pytest.mark.slow
@pytest.mark.parametrize(("ending", "views"), [("", 1), (";", 1), ("\nimport ipywidgets\nipywidgets.FloatSlider()", 2)])
def test_a_notebook_shows_the_sliders_once(monkeypatch, ending, views):
    """In a kernel, as a reader's notebook runs: a cell shows what `vary` displays and what its last line is worth."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipywidgets")
    monkeypatch.delenv("IMO_STATIC", raising=False)
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(VARIED + ending)])
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = notebook.cells[0].outputs
    assert sum("application/vnd.jupyter.widget-view+json" in one.get("data", {}) for one in outputs) == views
