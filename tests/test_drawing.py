"""The house style: lines that can be told apart by any eye and in grey, figures of the same bytes, text that stays text."""

import base64
import io
import itertools
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from fontTools.ttLib import TTFont
from numpy.typing import NDArray

from imo_analysis.drawing import (
    LIMIT,
    LINES,
    OBSERVER_LINES,
    TRUTH,
    Line,
    legend_above,
    line,
    named,
    new_figure,
    points,
    save_svg,
    sized,
    style,
    svg_text,
)
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.study import Study
from imo_analysis.svg import inside_page, italic, standalone

Array = NDArray[np.float64]

# Machado, Oliveira and Fernandes (IEEE Trans. Visualization and Computer Graphics 15(6), 2009), severity 1, on linear RGB.
SEEN_BY = {
    "most": np.eye(3),
    "deuteranopes": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    "protanopes": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
}
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = np.array([0.9505, 1.0, 1.089])


def linear(color: str) -> Array:
    """Linear RGB of #rrggbb."""
    c = np.array([int(color[k:k + 2], 16) / 255 for k in (1, 3, 5)])
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(rgb: Array) -> Array:
    """CIE L*a*b* of linear RGB."""
    t = TO_XYZ @ np.clip(rgb, 0, 1) / WHITE
    f = np.where(t > 0.008856, np.cbrt(t), 7.787 * t + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def distance(one: Line, other: Line) -> float:
    """The smallest distance of two colours in L*a*b* among all eyes."""
    return min(float(np.linalg.norm(lab(m @ linear(one.color)) - lab(m @ linear(other.color)))) for m in SEEN_BY.values())


def grey(one: Line) -> float:
    """Lightness of a line printed in grey."""
    return float(lab(linear(one.color))[0])


def contrast_on_white(one: Line) -> float:
    return float(1.05 / (linear(one.color) @ [0.2126, 0.7152, 0.0722] + 0.05))


def test_every_kind_of_observer_has_a_line_of_its_own() -> None:
    assert set(OBSERVER_LINES) == set(OBSERVERS)
    assert len({one.color for one in LINES}) == len({one.marker for one in LINES}) == len(LINES)
    assert len({line(kind) for kind in OBSERVERS}) == len(OBSERVERS)


@pytest.mark.parametrize(("one", "other"), list(itertools.combinations(LINES, 2)))
def test_lines_of_one_style_differ_in_colour_for_any_eye_and_in_grey(one: Line, other: Line) -> None:
    if one.linestyle == other.linestyle:
        assert distance(one, other) >= 20
        assert abs(grey(one) - grey(other)) >= 15


def test_the_paper_s_observers_differ_in_colour_and_in_style() -> None:
    study = Study.paper()
    kinds = {one.kind for part in (study, *map(study.scenario, study.scenarios)) for one in part.observers.values()}
    assert len(kinds) >= 5
    for one, other in itertools.combinations(sorted(kinds), 2):
        assert line(one).linestyle != line(other).linestyle, (one, other)
        assert distance(line(one), line(other)) >= 12, (one, other)


@pytest.mark.parametrize("one", [*LINES, TRUTH, LIMIT])
def test_lines_are_seen_on_white(one: Line) -> None:
    assert contrast_on_white(one) >= 3


def test_the_measure_can_fail() -> None:
    """Red and green of one lightness: apart for most, alike for others."""
    red, green = Line("#C05A3C", "-", "o"), Line("#7A7A2E", "-", "s")
    normal = float(np.linalg.norm(lab(linear(red.color)) - lab(linear(green.color))))
    assert normal > 2 * distance(red, green) and distance(red, green) < 20


def test_names_of_a_study() -> None:
    kinds = {"mine": "repaired", "twin": "repaired", "repaired": "repaired", "old": "baseline"}
    with named(kinds):
        lines = {name: line(name) for name in kinds}
        assert lines["repaired"] == OBSERVER_LINES["repaired"] and lines["old"] == OBSERVER_LINES["baseline"]
        assert len(set(lines.values())) == len(kinds)
    assert line("old") in LINES and line("true") == TRUTH and line("reference") == LIMIT and line(1) == LINES[1]


def drawn() -> str:
    figure, axes = new_figure()
    with style():
        axes.plot([0.0, 1.0], [-0.5, 0.123456], label="a−b", **line("baseline").kwargs())
        axes.set(xlabel=r"$\hat{\alpha}$ and $\dot{x}_{ds}$ (1/s)", ylabel="speed (rad/s)")
        legend_above(axes)
    return svg_text(figure)


def test_text_is_text_and_twice_the_same() -> None:
    svg = drawn()
    assert svg == drawn()
    root = ET.fromstring(svg)
    space = "{http://www.w3.org/2000/svg}"
    words = ["".join(text.itertext()) for text in root.iter(f"{space}text")]
    assert "speed (rad/s)" in words and "a−b" in words
    assert "αˆ and x˙ds (1/s)" in [word.replace("\n", "") for word in words], "in reading order, with accents that stand alone"
    assert "dc:date" not in svg and "<!--" not in svg
    ids = re.findall(r' id="([^"]*)"', svg)
    assert set(ids) <= set(re.findall(r'(?:href="#|url\(#)([^")]+)', svg)), "an id that nothing uses"


def test_inside_a_page() -> None:
    inside = inside_page(drawn(), "f7", 'a "picture"')
    assert inside.startswith('<svg role="img" aria-label="a &quot;picture&quot;"')
    assert all(name.startswith("f7-") for name in re.findall(r' id="([^"]*)"|url\(#([^)]*)\)|href="#([^"]*)"', inside)
               for name in name if name)
    assert "\U0001d6fc" in inside and "xmlns" not in inside
    ET.fromstring(inside)
    assert italic("hω<") == "\u210e\U0001d714&lt;"


def fonts_inside(svg: str) -> dict[str, TTFont]:
    """The fonts of a figure that is a file of its own, by style."""
    rules = re.findall(r'{font-family:"Imo Figure";(?:font-style:(\w+);)?src:url\(data:font/woff2;base64,([^)]*)\)', svg)
    return {style or "normal": TTFont(io.BytesIO(base64.b64decode(data))) for style, data in rules}


def test_a_file_of_its_own_brings_its_letters(tmp_path: Path) -> None:
    figure, axes = new_figure()
    with style():
        axes.set(xlabel=r"electrical speed $\hat{\omega}$ (rad/s)", ylabel="−10² ≤ x·y")
    save_svg(figure, tmp_path / "a.svg")
    svg = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert svg == standalone(svg_text(figure))
    fonts = fonts_inside(svg)
    assert list(fonts) == ["normal", "italic"] and "font-family=\"'Imo Figure',STIXGeneral" in svg
    for text in ET.fromstring(svg).iter():
        if text.tag.endswith(("}text", "}tspan")) and text.text and text.text.strip():
            font = fonts["italic" if "italic" in text.get("style", "") else "normal"]
            assert {ord(letter) for letter in text.text} <= {*font.getBestCmap(), 0x0A}, text.text
    plain = fonts_inside(standalone(drawn().replace("font-style: italic", "")))
    assert list(plain) == ["normal"], "no font that nothing uses"


@pytest.mark.parametrize(("style_", "file"), [("normal", "STIXGeneral.ttf"), ("italic", "STIXGeneralItalic.ttf")])
def test_its_letters_are_as_wide_as_those_that_they_were_placed_by(style_: str, file: str) -> None:
    from matplotlib import get_data_path

    ours, theirs = fonts_inside(standalone(drawn()))[style_], TTFont(f"{get_data_path()}/fonts/ttf/{file}")
    known = theirs.getBestCmap()
    same = [code for code in ours.getBestCmap() if code in known]
    assert len(same) > 100
    for code in same:
        width, wanted = (font["hmtx"][font.getBestCmap()[code]][0] / font["head"].unitsPerEm for font in (ours, theirs))
        assert width == pytest.approx(wanted, abs=0.003), chr(code)


def test_sizes() -> None:
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    page, _ = new_figure(width=7.2, height=4.0)
    with sized("slide"):
        slide, axes = new_figure(width=7.2, height=4.0)
        with style():
            assert mpl.rcParams["font.size"] == 14.5 and mpl.rcParams["font.serif"] == ["STIXGeneral"]
        high, _ = new_figure(width=7.2, height=7.0)
        assert points(21.0) == pytest.approx(29.0)
    assert page.get_size_inches().tolist() == [7.2, 4.0]
    assert slide.get_size_inches().tolist() == pytest.approx([10.0, 5.5556], rel=1e-3)
    assert high.get_size_inches().tolist() == [10.0, 5.625], "as wide as the slide, and never higher"
    assert axes.xaxis.label.get_size() == 14.5 and points(21.0) == 21.0
    assert dict(mpl.rcParams) == before, "the reader's own settings are put back"
