"""Sentences and figures that depend on results: changed data must change what is said."""

import html
import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from imo_analysis.paper.statements import ALPHA_FINAL
from imo_analysis.pencils.setup import Setup
from imo_analysis.pencils.sweep import pole_sweep
from imo_analysis.report import captions, searched
from imo_analysis.report.atlas import atlas
from imo_analysis.report.chapters.excitation import _alone, _signs
from imo_analysis.report.chapters.pencils import _neutral
from imo_analysis.report.chapters.simulations import _scenario, _stay
from imo_analysis.report.chapters.tuned import _searched, tuned_chapter
from imo_analysis.report.dossier import findings, strays
from imo_analysis.report.drift import DriftRow
from imo_analysis.report.figure_claims import figure_claims
from imo_analysis.report.metrics import Resting, StepResponse
from imo_analysis.report.pencils import PoleResult, _mirrored
from imo_analysis.report.run_figures import banded, leaving
from imo_analysis.report.scenarios import Divergence, Drawn, Scenario, WindowResult
from imo_analysis.report.tuned import BY_RULE, tuned
from imo_analysis.simulation.run import simulate
from imo_analysis.study import Study
from imo_analysis.study_tables import Window
from imo_analysis.svg import tidied


@pytest.fixture(scope="module")
def paper() -> Study:
    return Study.paper()


# The paper's figures -----------------------------------------------------------------------------------------------------
def runs(proposed: float, baseline: float, alpha: float) -> list[Scenario]:
    """Figs 1 to 4 with these errors and this end value."""
    both = {"consistent_12": proposed, "baseline": baseline}
    window = WindowResult("", 0.0, 1.0, [StepResponse(name, error, error, 0.0, 1.0) for name, error in both.items()])
    rest = [Resting("consistent_12", 1.0, 100.0, 100.0, alpha, 0.0, 0.0, 0.0)]
    return [Scenario(f"fig{k}", "", "", [], [window], rest, [], [], None, "") for k in (1, 2, 3, 4)]


@pytest.mark.parametrize(("proposed", "baseline", "alpha", "verdicts"), [
    (1.0, 5.0, ALPHA_FINAL, ["agrees"] * 4),
    (1.0, 1.5, ALPHA_FINAL + 0.2, ["agrees", "agrees", "does not agree", "does not agree"]),  # worse, but not much
    (5.0, 1.0, math.nan, ["does not agree"] * 4),
])
def test_what_the_paper_says_of_its_figures(
    paper: Study, proposed: float, baseline: float, alpha: float, verdicts: list[str]
) -> None:
    found = figure_claims(runs(proposed, baseline, alpha), paper)
    assert [one.figure for one in found] == [1, 2, 3, 4] and [one.verdict for one in found] == verdicts
    assert f"{proposed:.3g} rad/s against {baseline:.3g}" in found[0].here


def test_the_end_value_says_that_the_drive_was_chosen(paper: Study) -> None:
    """Of the paper's study; with another bandwidth nothing was chosen."""
    said, other = (figure_claims(runs(1.0, 5.0, ALPHA_FINAL), study)[-1].here
                   for study in (paper, paper.changed({"drive.speed_bandwidth": 30.0})))
    assert f"`speed_bandwidth = {paper.drive.speed_bandwidth:g}` was chosen to give it" in said
    assert "here `speed_bandwidth = 30`" in other and "chosen" not in other


def test_the_spread_of_the_predictions() -> None:
    """The worst of all runs is named, not only the main one's."""
    main, other = (Scenario(name, name, "", [], [], [Resting("a", 1.0, 1.0, 1.0, 9.0, 0.0, 0.0, 0.0)], [],
                            [DriftRow("a", 0.0, 0.0, 1.0, start, step, step, moved, predicted, simulated, 0.0)], None, "",
                            alpha=9.0)
                   for name, start, step, moved, predicted, simulated in (
                       ("fig4", 9.03, 1.44, 1.42, 10.46, 10.47), ("fig1", 8.75, 1.27, 1.30, 10.27, 10.05)))
    said = findings([other, main])[0]
    assert "before simulating: 10.46 /s (`a`)." in said
    assert "The start is predicted to end +0.02 /s from the true value and ends +0.03 /s from it" in said
    assert "the speed's steps add -0.02 /s to what is predicted of them. Over all 2 steps" in said
    assert "off by 0.22 /s at most (fig1: 10.27 for 10.05 /s, `a`)" in said


@pytest.mark.parametrize(("papers", "omega_hat", "inside"), [(False, 40.1, 1), (False, 47.0, 2), (True, 40.1, 3)])
def test_a_run_of_ones_own_machine_in_which_all_track_shows_one_figure(papers: bool, omega_hat: float, inside: int) -> None:
    svg = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 500 300"></svg>'
    drawn = [Drawn(svg, "A caption.", f"figures/{name}.svg") for name in ("speed", "window1", "flux")]
    state = Resting("a", 2.0, 40.0, omega_hat, math.nan, 0.0, 0.0, 0.0)
    said = _scenario(Scenario("run", "run", "imo", drawn, [], [state], [], [], None, ""), papers)
    assert said.count("<svg") == inside and said.count('href="figures/flux.svg"') == 1
    assert ("More figures of this run:" in said) == (inside < 3)


def test_captions_say_what_the_run_shows() -> None:
    states = [Resting(name, 2.0, 40.0, hat, math.nan, flux, 0.0, 0.0)
              for name, hat, flux in (("good", 39.5, 0.01), ("off", 1950.0, 0.9), ("gone", math.nan, math.nan))]
    said = captions.whole_speed([replace(states[0], time=1.0, omega_hat=7.0), *states], ["off"], noisy=False)
    assert "`good` +0.5 rad/s, `off` −1,910 rad/s, `gone` lost. The error of `off` leaves the axes." in said
    assert "bars" not in said and "bars" in captions.whole_speed(states, [], noisy=True)
    assert captions.flux(states).endswith("`good` 1 %, `off` 90 %, `gone` lost.")
    window = Window(title="step", start=1.0, stop=1.5, caption="up")
    responses = [StepResponse(name, peak, peak, 0.0, 1.0) for name, peak in (("gone", math.nan), ("b", 2.0), ("a", 0.25))]
    assert captions.part_speed(window, responses, []) == (
        "Step, 1 to 1.5 s: up. Largest error of the speed: `a` 0.25 rad/s, `b` 2 rad/s, `gone` lost.")
    assert "`good` 10 /s (+11 %); the machine has 9 /s" in captions.alpha([replace(states[0], alpha_hat=10.0)], 9.0)


def test_which_error_leaves_the_axes() -> None:
    """One far beyond the others and beyond a share of the speed; never more than half of them."""
    time = np.linspace(0.0, 1.0, 1000)
    omega, small, large = np.full(1000, 40.0), 5 * time, -1900 * time
    assert leaving(omega, {"a": small, "b": large, "c": 2 * small}) == ["b"]
    assert leaving(omega, {"a": small, "b": large, "c": large}) == [], "most of them"
    assert leaving(omega, {"a": 1e-6 * small, "b": small, "c": 1e-6 * small}) == [], "small beside the speed"
    assert leaving(omega, {"a": small, "b": np.full(1000, np.nan), "c": small}) == []


def test_the_window_of_another_chapter_is_named() -> None:
    end = Resting("a", 1.0, 100.0, 40.0, math.nan, 0.0, 0.0, 0.0, 60.0)
    off = [Scenario("real", "real", "", [], [], [end], [], [], None, "")]
    features = xr.Dataset(attrs={"start": 4.5, "stop": 6.0})
    assert "looks at 4.5 to 6 s of this run" in strays(off, features, "real")[0]
    assert "looks at" not in strays(off, features, "another")[0] + strays(off)[0]


# The printed feedbacks ---------------------------------------------------------------------------------------------------
def test_who_stays() -> None:
    lost = Divergence("a", "", True, 1.0, "")
    right, wrong = (Divergence(name, "", False, math.nan, "", off) for name, off in (("b", False), ("c", True)))
    assert _stay([lost, right]) == " `b` stays."
    assert _stay([lost, right, replace(right, observer="d")]) == " `b`, `d` stay."
    assert _stay([lost, wrong]) == " `c` is off the speed at the end without overflowing."
    assert _stay([lost]) == ""


# Poles -------------------------------------------------------------------------------------------------------------------
def sweep(shift: float) -> xr.Dataset:
    """Two observers over -2 .. 2 rad/s; the second one's poles are moved at negative speed."""
    omega = np.linspace(-2.0, 2.0, 5)
    pole = np.stack([-1.0 + 1j * omega, -3.0 - 1j * omega], axis=1)
    both = np.stack([pole, pole + shift * (omega < 0)[:, None]])
    dims = ("observer", "omega", "branch")
    return xr.Dataset({"re": (dims, both.real), "im": (dims, both.imag)},
                      coords={"observer": ["one", "two"], "omega": omega, "branch": [1, 2]})


def test_who_has_poles_that_stay_at_zero(paper: Study) -> None:
    """Those with xi, and not the baseline, although in one data set its missing poles are padded."""
    setups = {name: Setup.of_study(paper, name) for name in ("baseline", "repaired")}
    both = pole_sweep(setups, {"omega": [-60.0, 20.0, 60.0]}).data
    said = _neutral(PoleResult(both, both, [], [], [], {}))
    assert "`repaired` has 2 more, at zero" in said and "baseline" not in said
    assert _neutral(PoleResult(both, pole_sweep({"baseline": setups["baseline"]}, {"omega": [20.0, 60.0]}).data,
                               [], [], [], {})) == ""


def test_what_mirrors() -> None:
    assert _mirrored(sweep(0.0)) == " Negative speeds mirror positive ones at the real axis."
    assert _mirrored(sweep(0.5)).endswith("at the real axis, but not for `two`.")
    assert _mirrored(sweep(0.5).sel(observer=["two"])) == " The two directions of rotation differ."
    assert _mirrored(sweep(0.5).isel(omega=slice(1, None))) == ""


@pytest.mark.slow
def test_the_map_of_stability_is_what_the_simulator_does(paper: Study, tmp_path: Path) -> None:
    found = {one.observer: one for one in atlas(paper, tmp_path).unstable}
    assert found["consistent_12"].forward == 0 and found["consistent_12"].backward == 1
    assert found["repaired"].forward == found["repaired"].backward == 0
    assert 0 < found["baseline"].braking < 0.2
    for sign in (1.0, -1.0):
        run = simulate(paper.changed({"reference.time": [0.0], "reference.omega": [60.0 * sign], "simulation.duration": 3.0,
                                      "windows": []}))
        for name, one in found.items():
            error = abs(float(run["omega"][-1] - run["omega_hat"].sel(observer=name)[-1]))
            assert (error > 10) == ((one.forward if sign > 0 else one.backward) > 0.5), (name, sign, error)


# Gains -------------------------------------------------------------------------------------------------------------------
@pytest.mark.slow
def test_gains_are_judged_as_they_run(paper: Study, tmp_path: Path) -> None:
    """The linearisation's noise against that of the run, which had no part in it; and the sentence on who is best."""
    result = tuned(paper, tmp_path)
    assert result.wish is not None and not list(tmp_path.iterdir())
    for one in result.judged:
        if one.stable:
            assert one.measured == pytest.approx(one.values["noise"], rel=0.25), one.observer
    able = [one for one in result.judged if one.stable and not one.forward]
    quiet = min(able, key=lambda one: one.values["noise"])
    text = re.sub("<[^>]+>", "", tuned_chapter(result).body)
    assert f"quietest is {quiet.observer} with {'the rule' if quiet.rule else 'the study'}" in text
    worse = [replace(one, values={**one.values, "noise": 9.0, "settling": 9.0}) if one.rule else one for one in result.judged]
    changed = re.sub("<[^>]+>", "", tuned_chapter(replace(result, judged=worse)).body)
    assert "both better" in text and "both better" not in changed and "neither better" in changed
    assert BY_RULE not in text


def test_no_gains_to_judge(paper: Study, tmp_path: Path) -> None:
    observer = {**paper.data["observers"]["consistent_12"], "kind": "printed_7"}
    result = tuned(Study.from_data({**paper.data, "scenarios": {}, "observers": {"p": observer}}), tmp_path)
    assert result.wish is None and "There is nothing to compare" in tuned_chapter(result).body


# Lines -------------------------------------------------------------------------------------------------------------------
def test_noisy_lines_become_bands() -> None:
    time = np.linspace(0, 1, 20_000)
    noise = np.random.default_rng(1).normal(size=time.size)
    found = banded(time, np.sin(time) + 0.1 * noise)
    assert found is not None
    at, mean, low, high = found
    assert np.abs(mean - np.sin(at)).max() < 0.05 and (low < mean).all() and (mean < high).all()
    assert high.max() == pytest.approx((np.sin(time) + 0.1 * noise).max(), abs=0.1)
    assert banded(time, np.sin(30 * time)) is None and banded(time[:300], noise[:300]) is None
    assert banded(time, np.where(time > 0.5, np.nan, noise)) is None


def test_short_paths_go_where_the_long_ones_went() -> None:
    random = np.random.default_rng(2).uniform(0, 500, size=(200, 2))
    path = "M " + "\nL ".join(f"{x:.6f} {y:.6f}" for x, y in random) + " \nz\nM 10 20 \nL 30 20 \n"
    written = re.search(r' d="([^"]*)"', tidied(f'<svg><path d="{path}"/></svg>'))[1]  # type: ignore[index]
    places, at, start = [], np.zeros(2), np.zeros(2)
    for part in re.findall(r"[mlz][^mlz]*", written):
        numbers = [float(one) for one in re.findall(r"-?(?:\d+\.?\d*|\.\d+)", part)]
        for step in np.reshape(numbers, (-1, 2)):
            at = at + step
            places.append(at)
            start = at if part[0] == "m" else start
        at = start if part == "z" else at
    assert len(written) < 0.6 * len(path)
    assert np.abs(np.array(places) - np.vstack([random, [[10, 20], [30, 20]]])).max() <= 0.0501


@pytest.mark.slow
def test_what_a_search_finds(paper: Study, tmp_path: Path) -> None:
    """The sentence on the choice, from results that went through a file, against the numbers; and changed numbers."""
    study = paper.only(["repaired"])
    data = json.loads(json.dumps(searched.compute(study)))
    found = searched.drawn(study, data, tmp_path)
    one, = found.results
    before, after = one.verified_before, one.verified
    said = plain("".join(_searched(found)))
    better = after.settling < before.settling and after.noise < before.noise
    assert ("it is quicker and quieter than with the study's gains" in said) == better
    assert f"{1e3 * after.settling:.3g} ms in place of {1e3 * before.settling:.3g} ms" in said
    assert after.noise == pytest.approx(after.noise_predicted, rel=0.1), "the linearisation and the simulation, two routes"
    data["results"][0]["verified"] |= {"noise": 9.0, "settling": 9.0}
    assert "Verified." in said and said.count("yes, verified") >= 1
    worse = plain("".join(_searched(searched.drawn(study, data, tmp_path))))
    assert "it is neither quicker nor quieter than with the study's gains" in worse
    assert "NOT verified: the estimate settles in 9,000 ms" in worse
    assert worse.count("yes, verified") == said.count("yes, verified") - 1
    assert "No gains were searched for: why not" in plain("".join(_searched(searched.Searched([], None, ["why not"]))))


def plain(text: str) -> str:
    text = html.unescape(re.sub(r"<svg.*?</svg>|<[^>]+>", " ", text, flags=re.DOTALL))
    return re.sub(r"\s+", " ", text)


# Where a start lands -----------------------------------------------------------------------------------------------------
def test_what_is_said_of_what_the_copies_remember() -> None:
    assert _signs([]) == "" and "the other sign in 1 of 3 starts" in _signs([-2.0, 1.0, 0.5])
    said = _alone([0.006, -0.0014])
    assert said == "these starts would end -0.0014 to +0.006 /s off the truth: the rest is what the copies remember."
    assert "-0.1 to +0.2 /s off the truth, and 1 would not land:" in _alone([0.2, math.nan, -0.1])
    assert _alone([math.nan]) == "none of these starts would land."
