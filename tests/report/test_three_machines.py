"""The dossier of other people's motors: what its sentences say is what the runs and tables beside the page hold.

Three machines (2.2 kW, 45 kW, and the paper's with alpha badly wrong in every observer), none of them the paper's case, with
observers that lose the speed and one that overflows. What the same for every machine is not computed three times.
"""

import html
import json
import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr
from light_dossier import light

from imo_analysis.report.dossier import Written, write_dossier
from imo_analysis.simulation import judge
from imo_analysis.study import Study

pytestmark = pytest.mark.slow

PLATE_45 = {"power": 45e3, "voltage": 400.0, "current": 80.0, "power_factor": 0.86, "frequency": 50.0, "speed": "1475 rpm"}


def shortened(data: dict[str, Any], omega: float, **more: Any) -> Study:
    """The study with one scenario of speed steps, one that goes backward, and the printed feedbacks."""
    gains = data["observers"]["consistent_12"]["gains"]
    steps = {"simulation": {"duration": 1.6},
             "reference": {"shape": "steps", "time": [0.0, 0.8], "omega": [0.5 * omega, omega]},
             "windows": [{"title": "step", "start": 0.8, "stop": 1.2, "caption": "to the higher speed"}]}
    back = {"title": "backward", "simulation": {"duration": 1.2},
            "reference": {"shape": "steps", "time": [0.0], "omega": [-0.5 * omega]},
            "windows": [{"title": "backward", "start": 0.2, "stop": 1.0, "caption": "negative speed"}]}
    printed = {name: {"kind": name, "gains": gains} for name in ("printed_7", "printed_L")}
    rest = {key: value for key, value in data.items() if key not in ("scenarios", "reference", "load", "simulation", "windows")}
    return Study.from_data({
        **rest, **more, "simulation": {"duration": 1.6, "record_every": 10},
        "reference": {"shape": "steps", "time": [0.0], "omega": [omega]},
        "load": {"shape": "steps", "time": [0.0], "T_l": [0.0]},
        "poles": {"omega": [0.5 * omega, omega], "sweep": {"start": -omega, "stop": omega, "count": 41}},
        "scenarios": {"steps": {"title": "steps", **steps}, "back": back, "divergence": {
            "title": "as printed", "simulation": {"duration": 1.5}, "observers": printed, "windows": []}}})


def small() -> Study:
    from imo_analysis.machine import PRESETS
    from imo_analysis.tuning.start import study_text

    return shortened(dict(Study.from_toml(study_text(PRESETS["motulator-2.2-kw"]), "small").data), 150.0)


def large() -> Study:
    from imo_analysis.nameplate import Nameplate, machine_of
    from imo_analysis.tuning.start import study_text

    plate = Nameplate.build(PLATE_45)
    assert plate.power == 45e3
    machine = machine_of(plate, {"name": "m45", "J": 0.45}, "large")
    return shortened(dict(Study.from_toml(study_text(machine), "large").data), 200.0)


def wrong() -> Study:
    """Another rotor resistance than the paper's, and every observer believes twice or three times the alpha there is."""
    data = json.loads(json.dumps(dict(Study.paper().data), default=dict))
    machine = Study.paper().machine
    fields = {name: getattr(machine, name) for name in ("n_p", "R_s", "L_m", "L_s", "L_r", "J")}
    for name, one in data["observers"].items():
        one["errors"] = {"R_r": 1.0}
        if name != "baseline" and one["kind"] != "baseline_scheduled":
            one["initial"] = {"alpha_hat": 3.0 * machine.alpha}
    return shortened(data, 100.0, machine={**fields, "R_r": 1.1 * machine.R_r, "name": "wrong alpha"})


CASES = {"small": small, "large": large, "wrong": wrong}


class Made(NamedTuple):
    """A study with its dossier: what was written, the page, and the folder."""

    study: Study
    written: Written
    text: str
    out: Path


@pytest.fixture(scope="module", params=CASES)
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Made:
    """The dossier of a machine."""
    study = CASES[request.param]()
    out = tmp_path_factory.mktemp(request.param) / "out"
    with light():
        written = write_dossier(study, out, lambda line: None)
    return Made(study, written, (out / "index.html").read_text(encoding="utf-8"), out)


def plain(text: str) -> str:
    """What a reader reads, with formulas as their LaTeX."""
    text = re.sub(r'<math[^>]*alttext="([^"]*)".*?</math>', r"\1", text, flags=re.DOTALL)
    text = re.sub(r"<(script|style|svg).*?</\1>", "", text, flags=re.DOTALL)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", text)))


def chapter(text: str, anchor: str) -> str:
    return text.split(f'<section id="{anchor}"')[1].split("</section>")[0]


def errors_at_end(study: Study, out: Path, name: str) -> dict[str, tuple[float, float, float]]:
    """Speed, its mean error and the error's rms over the last of a run, from its file."""
    run = xr.load_dataset(out / "runs" / f"{name}.nc", engine="h5netcdf")
    end, last = float(run["time"][-1]), study.scenario(name).reference.time[-1]
    run = run.sel(time=slice(end - min(0.5, (end - last) / 4), None))
    error = run["omega"] - run["omega_hat"]
    return {str(one): (float(run["omega"].mean()), abs(float(error.sel(observer=one).mean(skipna=False))),
                       float((error.sel(observer=one) ** 2).mean(skipna=False)) ** 0.5) for one in run["observer"].values}


def test_it_is_about_this_machine(made: Made) -> None:
    words = plain(made.text)
    assert f"{made.study.machine.alpha:.4g}" in plain(chapter(made.text, "top"))
    for only_the_papers in ("The two readings of alpha", "Table II, printed and computed", "off its Fig.",
                            "What the paper says of its"):
        assert only_the_papers not in words
    assert 'class="unread"' not in made.text and " nan " not in words and "inf rad" not in words and len(made.text) < 3_000_000


@pytest.mark.parametrize("name", ["steps", "back"])
def test_who_tracks(made: Made, name: str) -> None:
    """The table on top and the list of strays against the run's own file."""
    title = made.study.scenario(name).title
    rows = re.findall(rf"<tr><td>{title}</td><td><code>(\w+)</code></td><td>([^<]*)</td>", chapter(made.text, "top"))
    said = dict(rows)
    truth = errors_at_end(made.study, made.out, name)
    assert set(said) == set(truth)
    for observer, (omega, error, rms) in truth.items():
        limit = max(0.02 * abs(omega), 1.0)
        expected = "is lost" if np.isnan(error) else "tracks" if error <= limit and rms <= 5 * limit else "is off"
        assert said[observer] == expected, (observer, omega, error)
    strays = [line for line in made.written.found if line.startswith(f"{title}: at the end")]
    bad = {observer for observer, word in said.items() if word != "tracks"}
    assert {one for line in strays for one in re.findall(r"`(\w+)`", line)} == bad


def test_both_outcomes_occur(made: Made) -> None:
    """The sentences are put to the test only where some observers track and some do not."""
    words = set(re.findall(r"<td>(tracks|is off|is lost)</td>", chapter(made.text, "top")))
    assert len(words) >= 2


def test_what_diverges_says_so(made: Made) -> None:
    from imo_analysis.errors import Diverged
    from imo_analysis.simulation.run import simulate

    part = plain(chapter(made.text, "simulations"))
    try:
        run = simulate(made.study.scenario("divergence"))
    except Diverged as error:
        run = error.data
    for observer in run["observer"].values:
        hat = run["omega_hat"].sel(observer=observer).values
        omega = run["omega"].values
        row = re.search(rf" {observer} [^.]*?(loses the speed for good|stays finite and ends off the speed|stays)",
                        part.split("as printed")[-1])
        assert row, observer
        if not np.isfinite(hat).all():
            assert row[1] == "loses the speed for good", observer
        else:
            right = abs(hat[-1] - omega[-1]) <= max(0.02 * abs(omega[-1]), 1.0)
            assert row[1] == ("stays" if right else "stays finite and ends off the speed"), observer
    overflowed = [str(one) for one in run["observer"].values
                  if not np.isfinite(run["omega_hat"].sel(observer=one).values).all()]
    assert ("Lost: " in part) == bool(overflowed)
    for name in overflowed:
        assert name in part.split("Lost: ")[1].split("What the observer does")[0]


def test_which_poles_are_unstable(made: Made) -> None:
    sweep = xr.load_dataset(made.out / "poles.nc", engine="h5netcdf")
    body = chapter(made.text, "poles")
    for name in sweep["observer"].values:
        one = sweep.sel(observer=name)
        size = float(np.nanmax(np.hypot(one["re"], one["im"])))
        bad = one["omega"].values[(one["re"] > 1e-6 * size).any("branch").values]
        said = re.search(rf"<code>{name}</code></td><td>([^<]*)</td>", body)[1]  # type: ignore[index]
        if bad.size:
            low, high = (float(f"{value:g}") for value in (bad.min(), bad.max()))
            numbers = [float(value.replace("−", "-")) for value in re.findall(r"[-−]?[\d.]+(?:e-?\d+)?", said)]
            assert said.startswith("unstable") and (min(numbers), max(numbers)) == (low, high)
        else:
            assert said.startswith("none")
    named = [line for line in made.written.found if "right half plane" in line]
    assert bool(named) == any("unstable at" in row for row in re.findall(r"<td>([^<]*)</td>", body))


def test_where_the_loop_holds(made: Made) -> None:
    part = plain(chapter(made.text, "drive"))
    plane = xr.load_dataset(made.out / "sensorless.nc", engine="h5netcdf")
    for name in plane["observer"].values:
        share = float(plane["holds"].sel(observer=name).mean())
        assert f"{name} holds at {100 * share:.0f} % of the points" in part
        assert (f"{name} holds at 100 % of the points. It fails nowhere" in part) == (share == 1)
    lost = 1 - plane["holds"].values
    near = np.abs(plane["stator_frequency"].values) <= 0.1 * np.abs(plane["stator_frequency"].values).max()
    wedge = any(one[near].mean() > 5 * one[~near].mean() for one in lost)
    assert ("in which holding is luck" in part) == wedge


def test_the_first_screen_says_what_the_map_and_the_runs_hold(made: Made) -> None:
    """Order, advice, percentages, limits of R_s and sizes, against the files beside the page."""
    top = plain(chapter(made.text, "top"))
    plane = xr.load_dataset(made.out / "sensorless.nc", engine="h5netcdf")
    share = {str(name): float(plane["holds"].sel(observer=name).mean()) for name in plane["observer"].values}
    said = [re.match(r"`(\w+)`", line)[1] for line in made.written.own if re.match(r"`\w+` \(", line)]  # type: ignore[index]
    assert sorted(said) == sorted(share) and [share[one] for one in said] == sorted(share.values(), reverse=True)
    for name in said:
        line = next(one for one in made.written.own if one.startswith(f"`{name}` ("))
        one = plane.sel(observer=name).isel(limit_omega=0)
        low, high = float(one["R_s_low"]), float(one["R_s_high"])
        assert f"holds at {100 * share[name]:.0f} % of the points" in line
        assert ("not even with the right R_s" in line) == np.isnan(low)
        if not np.isnan(low):
            assert f"from {-100 * low:.2g} %" in line and f"to {100 * high:.2g} %" in line
        ends = {run: errors_at_end(made.study, made.out, run)[name] for run in ("steps", "back")}
        off = {run: error for run, (omega, error, rms) in ends.items()
               if not (error <= judge.limit(omega) and rms <= 5 * judge.limit(omega))}
        assert ("It tracks in all of 2 runs" in line) == (not off)
        if off:
            worst = max(off, key=lambda run: np.inf if np.isnan(off[run]) else off[run])
            error, speed = off[worst], abs(ends[worst][0])
            turns = error / made.study.machine.n_p * 30 / np.pi
            assert f"worst in “{made.study.scenario(worst).title}”" in line
            assert np.isnan(error) or all(f"{value:.3g}" in line for value in (error, 100 * error / speed, turns)), line
    able = [name for name in said if float(plane["R_s_low"].sel(observer=name)[0]) <= -0.05
            and float(plane["R_s_high"].sel(observer=name)[0]) >= 0.05]
    assert made.written.own[0].startswith(f"Take `{able[0]}`" if able else "None of these observers works")
    assert top.index(made.written.own[0].split("`")[0].strip()) < top.index("About the paper, not this machine")


def test_best_and_worst_of_a_window(made: Made) -> None:
    """The table of the window orders the observers as the run does."""
    part = chapter(made.text, "simulations")
    run = xr.load_dataset(made.out / "runs" / "steps-window1.nc", engine="h5netcdf")
    peaks = {str(one): float(np.abs(run["omega"] - run["omega_hat"].sel(observer=one)).max()) for one in run["observer"].values}
    body = part.split("step: 0.8 to 1.2 s")[1].split("</table>")[0]
    said = dict(re.findall(r"<td>(\w+)</td><td class=\"n\">([^<]*)</td>", body))
    assert set(said) == set(peaks)
    for name, value in said.items():
        mantissa, _, power = value.replace("−", "-").replace(",", "").partition("·10")
        number = float(mantissa) * 10.0 ** int(power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or 0)
        assert number == pytest.approx(peaks[name], rel=0.02, abs=1e-9)  # the file holds one sample in some


def test_commands_name_what_the_study_has(made: Made) -> None:
    words = plain(chapter(made.text, "reproduce")) + plain(chapter(made.text, "simulations"))
    named = set(re.findall(r"--scenario (\w+)", words))
    assert named <= set(made.study.scenarios)
    assert "the paper's study" not in words, "imo study --init does not write this one"


def test_the_commands_are_understood(made: Made) -> None:
    from imo_analysis.cli import parser_of

    block = html.unescape(re.search(r"<pre><code>(.*?)</code>", chapter(made.text, "reproduce"), re.DOTALL)[1])  # type: ignore[index]
    lines = [line.split("#")[0].split() for line in block.splitlines()]
    assert len(lines) >= 6
    for program, command, *arguments in lines:
        assert program == "imo"
        parser_of(command).parse_args(arguments)


def test_no_table_is_cut(browser: Any, made: Made) -> None:
    """On a desktop each table is seen whole, that of the first screen of one's own machine, too."""
    page = browser.new_page(viewport={"width": 1200, "height": 900})
    page.goto((made.out / "index.html").as_uri())
    page.evaluate("document.querySelectorAll('details').forEach(e => { e.open = true })")
    cut = page.evaluate("""() => [...document.querySelectorAll(".scroll")].filter(e => e.scrollWidth > e.clientWidth + 1)
        .map(e => [e.clientWidth, e.scrollWidth, e.textContent.slice(0, 80)])""")
    page.close()
    assert cut == []


@pytest.mark.parametrize("made", ["wrong"], indirect=True)
def test_twice_the_same_bytes(made: Made, tmp_path: Path) -> None:
    with light():
        write_dossier(wrong(), tmp_path / "again", lambda line: None)
    first, second = ({str(path.relative_to(place)): path.read_bytes() for path in place.rglob("*") if path.is_file()}
                     for place in (made.out, tmp_path / "again"))
    assert len(first) > 20 and first.keys() == second.keys()
    assert [name for name in first if first[name] != second[name]] == []


def test_the_one_to_take_drives_what_is_drawn_of_a_sensorless_run(tmp_path: Path) -> None:
    """Whatever the study says, and the table says of each observer what becomes of the machine that it drives."""
    from imo_analysis.nameplate import Nameplate, machine_of
    from imo_analysis.simulation.run import simulate
    from imo_analysis.tuning.start import study_text

    plate = Nameplate.build({"power": 7.5e3, "voltage": 400.0, "current": 15.2, "power_factor": 0.84, "frequency": 50.0,
                             "speed": "1455 rpm"})
    data = dict(Study.from_toml(study_text(machine_of(plate, {"J": 0.03}, "plate"), plate=plate)).data)
    closed = {**data["scenarios"]["closed_off"], "drive": {"feedback": "quiet"}}
    study = Study.from_data({**data, "scenarios": {"load": data["scenarios"]["load"], "closed": closed}})
    with light():
        written = write_dossier(study, tmp_path / "out", lambda line: None)
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    taken = re.match(r"Take `(\w+)`", written.own[0])[1]  # type: ignore[index]
    part = plain(chapter(text, "simulations"))
    assert f"R_s believed 5 % too high, driven by {taken} " in part
    assert f"imo simulate study.toml --scenario closed --feedback {taken} --out closed.nc" in part
    drawn = xr.load_dataset(tmp_path / "out" / "runs" / "closed.nc", engine="h5netcdf")
    order = re.findall(r"^`(\w+)` \(", "\n".join(written.own), re.MULTILINE)
    row = re.search(r"driven by each</td>(.*?)</tr>", chapter(text, "top"))[1]  # type: ignore[index]
    cells = re.findall(r"<td>(.*?)</td>", row)
    held = {}
    for name, cell in zip(order, cells, strict=True):
        run = simulate(study.scenario("closed").changed({"drive.feedback": name}))
        end = run.isel(time=slice(-500, None))
        wanted = study.scenario("closed").reference.omega[-1]
        held[name] = abs(float(end["omega"].mean()) - wanted) <= 0.02 * wanted
        assert cell.startswith("holds" if held[name] else "does not hold"), (name, cell)
        assert np.allclose(run["omega"][-1], drawn["omega"][-1], rtol=1e-9) == (name == taken)
    assert held[taken] and not held["quiet"]
