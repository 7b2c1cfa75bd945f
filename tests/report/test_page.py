"""HTML pieces: escaping, prose, numbers; figures and metrics on data that is small enough to know the answer."""

import math
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import xarray as xr

from imo_analysis.drawing import svg_text
from imo_analysis.report.breaking import LINE, broken, width
from imo_analysis.report.growth import lyapunov_along
from imo_analysis.report.metrics import resting, step_responses
from imo_analysis.report.page import Chapter, Html, formula, inline, number, page, prose, table, tag
from imo_analysis.report.run_figures import alpha_figure, flux_error_figure, speed_figure, thinned
from imo_analysis.study import Study

NAMES = ("baseline", "consistent_12")


def run() -> xr.Dataset:
    """Two observers whose errors are known: the first is off by exp(-10 t), the second not at all."""
    time = np.arange(0, 10_000) * 1e-4
    omega = np.where(time < 0.5, 50.0, 100.0)
    error = np.stack([np.exp(-10 * time), np.zeros_like(time)])
    one = np.ones_like(time)
    pair = np.stack([one, one])
    both = ("observer", "time")
    data = {"omega": ("time", omega), "phi_dr": ("time", 0.5 * one), "phi_qr": ("time", 0 * one),
            "i_ds": ("time", one), "i_qs": ("time", 0 * one), "omega_hat": (both, omega - error),
            "alpha_hat": (both, np.stack([np.nan * one, 10.5 * one])), "phi_dr_hat": (both, 0.4 * pair),
            "phi_qr_hat": (both, 0 * pair)}
    data |= {name: (both, np.stack([np.nan * one, 3.0 * one])) for name in ("z_1_hat", "xi_1_hat")}
    data |= {name: (both, np.stack([np.nan * one, 0 * one])) for name in ("z_2_hat", "xi_2_hat")}
    return xr.Dataset(data, coords={"time": time, "observer": list(NAMES)})


def test_text_is_escaped_and_html_is_not() -> None:
    assert tag("p", "a < b & c", Html("<b>d</b>")) == "<p>a &lt; b &amp; c<b>d</b></p>"
    assert tag("a", "x", href='"><script>') == '<a href="&quot;&gt;&lt;script&gt;">x</a>'
    assert table(("<h>",), [("<c>",)]).count("&lt;") == 2


def test_prose_reads_code_and_formulas() -> None:
    shown = prose("first `k < 1`\n\nsecond $x_1$")
    assert shown.count("<p>") == 2 and "<code>k &lt; 1</code>" in shown and "<math" in shown
    assert inline("a < b") == "a &lt; b"


@pytest.mark.parametrize(("value", "written"), [(0.5, "0.5"), (-12.3456, "−12.3"), (4.08e-10, "4.08·10⁻¹⁰"), (math.nan, "–"),
                                                (1870.0, "1,870"), (-1910.3, "−1,910"), (2.273e6, "2.27·10⁶"), (math.inf, "∞")])
def test_numbers(value: float, written: str) -> None:
    assert number(value) == written


@pytest.mark.parametrize(("typed", "shown"), [
    ("1.87e+03 rad/s", "1,870 rad/s"), ("beside 8.5e-05", "beside 8.5·10⁻⁵"), ("at -309.3 to -8.00", "at −309.3 to −8.00"),
    ("exp(-0.2 t)", "exp(−0.2 t)"), ("2018-090, x-2, IV-2, 4-5", "2018-090, x-2, IV-2, 4-5"), ("v1e-3x", "v1e-3x"),
])
def test_numbers_in_a_sentence_are_written_as_in_a_table(typed: str, shown: str) -> None:
    assert inline(typed) == shown
    assert inline(f"`{typed}`") == f"<code>{typed}</code>"


def test_a_power_of_ten_inside_a_formula() -> None:
    assert r"2.273 \cdot 10^{6}" in inline("$h = 2.273e+06$")


def test_a_column_of_dashes_is_left_out() -> None:
    shown = table(("a", "b", "c"), [("1", "–", "–"), ("2", "–", "3")], numeric=(1, 2))
    assert "<th>a</th>" in shown and ">b<" not in shown and '<td class="n">3</td>' in shown


def test_a_head_is_broken_at_underscores_only() -> None:
    assert "<code>consistent_<wbr/>12</code>" in table(("`consistent_12`",), [("`consistent_12`",)])
    assert "<td><code>consistent_12</code></td>" in table(("`consistent_12`",), [("`consistent_12`",)])


def test_a_deviation_may_go_on_the_next_line() -> None:
    assert '<td class="n">1 ±<wbr/> 2</td>' in table(("a",), [("1 ± 2",)], numeric=(0,))


def test_long_formulas_are_broken_before_a_sign() -> None:
    term = r"\tilde{i}_{ds} \left(\hat{\xi}_1 - \left(1 + \beta L_m\right) i_{ds}\right)"
    long = f"V = {' + '.join([term] * 4)} - \\frac{{a}}{{b}}"
    rows = broken(long).removeprefix(r"\begin{aligned}").removesuffix(r"\end{aligned}").split(r" \\ ")
    assert len(rows) > 1 and all(width(row) <= LINE for row in rows) and rows[0].startswith("V &=")
    assert all(row.startswith((r"&\quad +", r"&\quad -")) for row in rows[1:])
    assert "".join(rows).replace(r"&\quad", "").replace("&", "").replace(" ", "") == long.replace(" ", ""), "nothing is lost"
    assert broken(f"V = {term}") == f"V = {term}" and 'class="unread"' not in formula(long)
    coloured = f"V = {term} \\class{{differs}}{{+}} {term} \\class{{differs}}{{-}} {term} + {term}"
    assert all(not row.rstrip().endswith(("}{+}", "{differs}")) for row in broken(coloured).split(r"\\"))


def test_the_page_is_well_formed_and_loads_nothing() -> None:
    text = page("a < b", tag("h1", "first"), [Chapter("one", "One", "Chapter one", tag("p", "x"))], tag("span", "end"))
    head, body = text.split("<body>")
    ET.fromstring("<body>" + body.split("<script>")[0] + "</body>")
    assert "<title>a &lt; b</title>" in head
    assert "http" not in text.replace("http://www.w3.org/", "")


def test_thinning_keeps_every_peak() -> None:
    time = np.linspace(0, 1, 100_000)
    values = np.zeros_like(time)
    values[54_321], values[77_777] = 1.0, -2.0
    short_time, short = thinned(time, values)
    assert len(short) < 6000 and short.max() == 1.0 and short.min() == -2.0
    assert (np.diff(short_time) > 0).all() and short_time[0] == 0 and short_time[-1] == 1


def test_figures_are_the_same_twice_and_have_units() -> None:
    data = run()
    for draw in (lambda: speed_figure(data), lambda: speed_figure(data, (0.4, 0.6)),
                 lambda: alpha_figure(data, 9.9, {"paper": 10.5}, NAMES[1:]), lambda: flux_error_figure(data, NAMES)):
        figure = draw()
        assert svg_text(figure) == svg_text(draw())
        for axes in figure.axes:
            assert "(" in axes.get_ylabel()
        assert "(s)" in figure.axes[-1].get_xlabel()


def test_step_response_of_a_known_error() -> None:
    late, exact = step_responses(run(), (0.0, 0.9999))
    assert late.peak == pytest.approx(1.0) and exact.peak == 0.0
    assert late.band == pytest.approx(1.0) and late.settled == pytest.approx(0.0)  # 2 % of the step of 50 rad/s
    assert late.rms == pytest.approx(math.sqrt((1 - math.exp(-20)) / 20), rel=1e-3)


def test_a_response_that_never_settles_says_so() -> None:
    data = run()
    data["omega_hat"][0] = data["omega_hat"][0] - 30.0
    assert math.isnan(step_responses(data, (0.4, 0.6))[0].settled)


def test_resting_state() -> None:
    first, second = resting(run(), 4.0, 0.8)
    assert first.time == pytest.approx(0.8) and first.flux_error == pytest.approx(0.2)
    assert math.isnan(first.alpha_hat) and math.isnan(first.z_error)
    assert second.alpha_hat == 10.5 and second.z_error == pytest.approx(0.0)  # z = 1 + 4 * 0.5
    mean = resting(run(), 4.0, 0.8, 0.1)[0]
    assert mean.omega - mean.omega_hat == pytest.approx((math.exp(-7) - math.exp(-8)) / 1.0, rel=2e-3)
    assert mean.rms == pytest.approx(math.sqrt((math.exp(-14) - math.exp(-16)) / 20 / 0.1), rel=2e-3)


def test_lyapunov_function_along_a_run() -> None:
    """Against complex arithmetic of its own, on random states."""
    study = Study.paper()
    random = np.random.default_rng(3)
    names = ["consistent_12", "repaired"]
    plant = {name: random.normal(size=5) for name in ("i_ds", "i_qs", "phi_dr", "phi_qr")} | {"omega": random.uniform(1, 9, 5)}
    hats = {name: random.normal(size=(2, 5)) for name in (
        "i_ds_hat", "i_qs_hat", "z_1_hat", "z_2_hat", "xi_1_hat", "xi_2_hat", "alpha_hat", "omega_hat")}
    data = xr.Dataset({**{k: ("time", v) for k, v in plant.items()}, **{k: (("observer", "time"), v) for k, v in hats.items()}},
                      coords={"time": np.arange(5.0), "observer": names})
    i = plant["i_ds"] + 1j * plant["i_qs"]
    z = i + study.machine.beta * (plant["phi_dr"] + 1j * plant["phi_qr"])
    for k, name in enumerate(names):
        gains = study.observers[name].gains
        current = abs(i - hats["i_ds_hat"][k] - 1j * hats["i_qs_hat"][k]) ** 2
        z_square = abs(z - hats["z_1_hat"][k] - 1j * hats["z_2_hat"][k]) ** 2
        xi_square = abs(z - hats["xi_1_hat"][k] - 1j * hats["xi_2_hat"][k]) ** 2
        alpha, omega = study.machine.alpha, plant["omega"]
        weight = omega / gains["kappa"] if name == "repaired" else omega / (gains["k_2"] * hats["omega_hat"][k])
        adapted = (alpha - hats["alpha_hat"][k]) ** 2 / gains["g"] + (omega - hats["omega_hat"][k]) ** 2 / gains["K_p"]
        expected = (current + weight * z_square + alpha / gains["k_3"] * xi_square + adapted) / 2
        assert lyapunov_along(data, study, name) == pytest.approx(expected, rel=1e-12)
