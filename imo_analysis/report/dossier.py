"""The dossier of a study: everything computed once, written into a folder beside the wanted one, then moved into place."""

from __future__ import annotations

import json
import math
import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from imo_analysis.drawing import named
from imo_analysis.errors import InputError
from imo_analysis.excitation.conditions import CONDITIONS
from imo_analysis.files import folder as checked_folder
from imo_analysis.ledger.claim import Entry
from imo_analysis.report.metrics import Resting
from imo_analysis.report.page import number
from imo_analysis.report.pencils import observers_of
from imo_analysis.report.scenarios import ExcitationResult, Scenario, main_scenario, outcome
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr

ALIKE = 1.05  # an rms error up to so many times the mean says nothing new


@dataclass(frozen=True)
class Written:
    """What a dossier holds and where it is.

    Attributes
    ----------
    folder : Path
    files : list of (str, str)
        Names below ``folder`` and what each holds.
    entries : list of Entry
    found : list of str
        The findings of the first screen, a sentence each.
    own : list of str
        Those on a machine that is not the paper's, best observer first; else none.
    faults : list of str
        What diverged, by scenario; and errors of the ledger.
    no_pdf : str
        Why there is no PDF where one was asked for.
    """

    folder: Path
    files: list[tuple[str, str]]
    entries: list[Entry]
    found: list[str]
    faults: list[str]
    own: list[str]
    no_pdf: str = ""


def write_dossier(
    study: Study, out: str | Path, note: Callable[[str], None], small: bool = False, with_markdown: bool = False,
    with_pdf: bool = False,
) -> Written:
    """Compute and write the whole dossier.

    Parameters
    ----------
    study : Study
    out : str or Path
        The folder to make or to renew; files in it that the dossier does not write stay.
    note : callable
        Told what is being done, a line each.
    small : bool
        Leave out what is beside the page in bulk: runs and pole sweep as NetCDF and CSV, and the figures as files.
    with_markdown, with_pdf : bool
        Write the page as ``index.md`` with its figures, and print it to ``index.pdf`` if a browser is found.

    Raises
    ------
    InputError
        If the folder cannot be written to.
    Diverged
        If a scenario diverges and nothing is left of its run.
    """
    if not study.observers:
        raise InputError(f"the study {study.title!r} has no observers; add at least one table [observers.NAME]")
    out = Path(out)
    checked_folder(out)
    try:
        work = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.resolve().parent))
    except OSError:
        work = Path(tempfile.mkdtemp(prefix=".unfinished.", dir=out))
    try:
        for name, wanted in (("figures", with_markdown or not small), ("runs", not small)):
            if wanted:
                (work / name).mkdir()
        with named({name: kind for name, (kind, _) in observers_of(study)[1].items()}):
            written = _compute(study, work, note, not small)
        no_pdf = _copies(work, written[0], note, with_markdown, with_pdf)
        _move(work, out)
    except OSError as error:
        raise InputError(f"cannot write {out}: {error.strerror or error}; choose another place with --out") from None
    finally:
        shutil.rmtree(work, ignore_errors=True)
    return Written(out, *written, no_pdf)


def _copies(work: Path, files: list[tuple[str, str]], note: Callable[[str], None], with_markdown: bool, with_pdf: bool) -> str:
    """The page as Markdown and as PDF; says why there is no PDF where one was asked for."""
    from imo_analysis.report.markdown import markdown
    from imo_analysis.report.pdf import print_page

    if with_markdown:
        note("writing it as Markdown")
        (work / "index.md").write_text(markdown((work / "index.html").read_text(encoding="utf-8")), encoding="utf-8")
        files.append(("index.md", "this page as Markdown"))
    if not with_pdf:
        return ""
    note("printing it")
    missing = print_page(work / "index.html", work / "index.pdf")
    if not missing:
        files.append(("index.pdf", "this page as PDF"))
    return missing


def _move(work: Path, out: Path) -> None:
    """Move file by file, each in one step; the page last, so that it never points at what is not there."""
    files = sorted((path for path in work.rglob("*") if path.is_file()), key=lambda path: path.name == "index.html")
    for path in files:
        place = out / path.relative_to(work)
        place.parent.mkdir(exist_ok=True)
        path.replace(place)


def _compute(
    study: Study, work: Path, note: Callable[[str], None], runs: bool
) -> tuple[list[tuple[str, str]], list[Entry], list[str], list[str], list[str]]:
    from imo_analysis.ledger.book import entries as settle_all
    from imo_analysis.report import drive, searched
    from imo_analysis.report.atlas import atlas
    from imo_analysis.report.chapters.drive import drive_chapter
    from imo_analysis.report.chapters.excitation import excitation_chapter
    from imo_analysis.report.chapters.ledger import ledger_chapter
    from imo_analysis.report.chapters.machine import machine_chapter
    from imo_analysis.report.chapters.notation import notation_chapter
    from imo_analysis.report.chapters.own_machine import own_machine
    from imo_analysis.report.chapters.pencils import pencils_chapter
    from imo_analysis.report.chapters.reproduce import reproduce_chapter
    from imo_analysis.report.chapters.simulations import simulations_chapter
    from imo_analysis.report.chapters.theorem import theorem_chapter
    from imo_analysis.report.chapters.tuned import tuned_chapter
    from imo_analysis.report.chapters.verdicts import first_screen
    from imo_analysis.report.checks import beside, collect
    from imo_analysis.report.drift import varied, varied_landings
    from imo_analysis.report.driven import driven_by_each, is_sensorless
    from imo_analysis.report.growth import growth
    from imo_analysis.report.identifiability import identifiability
    from imo_analysis.report.modulation import modulation
    from imo_analysis.report.own import advice, cures, overloads, standings, to_take, verdicts
    from imo_analysis.report.page import Html, page
    from imo_analysis.report.paper_machine import is_paper
    from imo_analysis.report.pencils import pencils
    from imo_analysis.report.scenarios import divergences, run_scenario, scenario_names
    from imo_analysis.report.tuned import tuned

    (work / "study.toml").write_text(study.to_toml(), encoding="utf-8")
    with beside(work / "checks.json", work / "study.toml") as worker:
        note("ledger: settling every claim by sympy and FLINT")
        entries = settle_all(("sympy", "flint"))
        _write_json(work / "ledger.json", entries)
        note("excitation: what can be told apart at all")
        possible = identifiability(study, work)
        note("pencils: poles at the speeds of Table II and over the sweep")
        poles, maps = pencils(study, work, runs), atlas(study, work)
        lost = divergences(study, note)
        grown = growth(study, work)
        names, papers = scenario_names(study), is_paper(study.machine)
        sensorless = [] if papers else [name for name in names if is_sensorless(study, name)]
        made = {name: driven_by_each(study, name, note) if name in sensorless else run_scenario(study, name, work, note, runs)
                for name in names}
        note("gains: the study's and those of one rule")
        judged_gains = tuned(study, work)
        note("excitation: a flux modulation that makes alpha identifiable")
        cured = modulation(study, work)
        moved, landed = varied(study), varied_landings(study)
        note("waiting for the seeded faults, the proofs on Table II, and the drive as it is")
        proved = collect(worker, work / "checks.json")
    real = drive.drawn(study, work, proved["no_map"], runs)
    best = [] if papers else standings(study, list(made.values()), real.map)
    for name in sensorless:
        able = [one for one in best if one.observer in {end.observer for end in made[name].driven}]
        drawn = run_scenario(study, name, work, note, runs, to_take(able).observer)
        made[name] = replace(drawn, driven=made[name].driven)
    scenarios = list(made.values())
    note("writing the page")
    files = [("index.html", "this page"), ("ledger.json", "every entry of the ledger"), ("study.toml", "the study, whole"),
             *poles.files, ("checks.json", "seeded faults, and why no printed form gives Table II"), *real.files]
    files += [one for scenario in scenarios for one in scenario.files]
    found = [*poles.found, *findings(scenarios), *strays(scenarios, real.features, real.scenario)]
    judged = _judged(scenarios)
    ledger = [ledger_chapter(entries, proved), notation_chapter()]
    machine, theorem = machine_chapter(study.machine), theorem_chapter(entries, *grown)
    frozen, runs_of = pencils_chapter(poles, proved, papers, maps), simulations_chapter(study, scenarios, lost)
    gains = tuned_chapter(judged_gains, searched.drawn(study, proved["searched"], work))
    excited = excitation_chapter(judged, scenarios, possible, cured, moved, landed, papers)
    last = reproduce_chapter(study, files)
    chapters = ([*ledger, machine, theorem, frozen, runs_of, drive_chapter(real), gains, excited, last] if papers else
                [runs_of, drive_chapter(real), gains, excited, frozen, machine, *ledger, theorem, last])
    title = f"imo report: {study.title}"
    footer = Html("Made by <code>imo report</code>. Formulas are set in a subset of STIX Math (SIL Open Font License 1.1).")
    own, said = None, []
    if not papers:
        both = [*overloads(study, scenarios), *advice(study, best, real.map, real.refused)], verdicts(study, best, real.map)
        tried = cures(study, scenarios, cured.observer, cured.design) if cured and cured.design else []
        own, said = own_machine(study, scenarios, best, both, judged, cured, tried), [*both[0], *both[1]]
    (work / "index.html").write_text(page(title, first_screen(study, entries, found, own), chapters, footer), encoding="utf-8")
    files += sorted((str(path.relative_to(work)), "figure") for path in work.glob("figures/*"))
    faults = [fault for entry in entries for fault in entry.errors]
    faults += [f"{scenario.title}: {scenario.fault}" for scenario in scenarios if scenario.fault]
    return files, entries, found, faults, said


def _judged(scenarios: Sequence[Scenario]) -> list[ExcitationResult]:
    """The excitation along all runs; the figures of the main run are open."""
    main = main_scenario(scenarios)
    return [replace(one, open=scenario is main) for scenario in scenarios for one in scenario.excitation]


def _write_json(path: Path, entries: Sequence[Entry]) -> None:
    from imo_analysis import __version__
    data = {"schema": "imo-ledger/1", "imo_analysis": __version__, "entries": [entry.to_dict() for entry in entries]}
    path.write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def findings(scenarios: Sequence[Scenario]) -> list[str]:
    """What the main run shows (Fig. 4 in the paper's study), in sentences built from its numbers."""
    main = main_scenario(scenarios)
    end = main.resting[-1].time
    found: list[str] = []
    estimates = [one for one in main.resting if one.time == end and not math.isnan(one.alpha_hat)]
    if estimates:
        values = ", ".join(f"{one.alpha_hat:.4g} /s (`{one.observer}`, flux error {100 * one.flux_error:.2g} %)"
                           for one in estimates)
        found.append(f"{main.title}: alpha_hat ends at {values}; the machine has {main.alpha:.5g} /s."
                     + _predicted(main, scenarios))
    for result in main.excitation:
        for name, one in result.summary["conditions"].items():
            lost = one["lost"][0] if one["lost"] else None
            words = f"; mostly lost: {lost['text']} ({100 * lost['share']:.3g} % of the windows)" if lost else ""
            share = f"{one['holding']} of {one['windows']} windows"
            found.append(f"{result.title}: {CONDITIONS[name].title} holds in {share}{words}.")
    return found


def _predicted(main: Scenario, scenarios: Sequence[Scenario]) -> str:
    """What was predicted of the first observer's alpha_hat, how far its two parts are off, and the worst of all."""
    if not main.drift:
        return ""
    name = main.drift[0].observer
    own = [row for row in main.drift if row.observer == name]
    steps = sum(row.step_from_study for row in own) - sum(row.step for row in own)
    rows = [(scenario, row) for scenario in scenarios for row in scenario.drift]
    scenario, worst = max(rows, key=lambda one: abs(one[1].from_study - one[1].end))
    landed = own[0].from_study - own[0].step_from_study
    return (f" Predicted from the study, before simulating: {own[-1].from_study:.4g} /s (`{name}`). The start is predicted to "
            f"end {landed - main.alpha:+.2g} /s from the true value and ends {own[0].start - main.alpha:+.2g} /s from it; the "
            f"speed's steps add {-steps:+.2g} /s to what is predicted of them. Over all {len(rows)} steps that can be "
            f"predicted, their predicted end is off by {number(abs(worst.from_study - worst.end), 2)} /s at most "
            f"({scenario.title}: {worst.from_study:.4g} for {worst.end:.4g} /s, `{worst.observer}`).")


def _rms(one: Resting) -> str:
    """The rms error where it says more than the mean does."""
    return "" if one.rms <= ALIKE * abs(one.omega - one.omega_hat) else f", {number(one.rms)} rms"


def strays(scenarios: Sequence[Scenario], features: xr.Dataset | None = None, compared: str = "") -> list[str]:
    """The estimates of speed that are off at the end of a run, a sentence a run.

    ``features`` is what the chapter on a drive shows of the run with the title ``compared``, over a window of its own.
    """
    found = []
    for scenario in scenarios:
        end = scenario.resting[-1].time
        there = [one for one in scenario.resting if one.time == end]
        speed = there[0].omega
        off = [f"`{one.observer}` " + ("is lost" if math.isnan(one.omega_hat) else
                                       f"by {number(abs(one.omega - one.omega_hat))} rad/s in the mean" + _rms(one))
               for one in there if outcome(one) != "tracks"]
        if off:
            other = "" if features is None or scenario.title != compared else (
                f" (The chapter on a drive as it is looks at {features.attrs['start']:g} to {features.attrs['stop']:g} s of "
                "this run.)")
            found.append(f"{scenario.titled}: at the end, at {speed:.3g} rad/s, the estimate of speed is off: {', '.join(off)}."
                         + other)
    return found


def summary(written: Written) -> dict[str, Any]:
    """The outcome as plain data, for ``--json`` (imo-report/1)."""
    from imo_analysis.ledger.show import counts

    return {
        "folder": str(written.folder),
        "files": [{"name": name, "holds": meaning} for name, meaning in written.files],
        "verdicts": counts(written.entries),
        "errors": written.faults,
        "own": written.own,
        "found": written.found,
    }
