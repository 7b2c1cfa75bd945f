"""The command line itself: help is quick and light, faults are one line with exit code 2."""

import json
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from imo_analysis import cli

HEAVY = ("numpy", "sympy", "numba", "control", "scipy", "xarray", "matplotlib", "pydantic", "flint")


@pytest.mark.parametrize("command", ["", *cli.COMMANDS])
def test_help_fits_a_screen_and_imports_nothing_heavy(command: str) -> None:
    probe = (
        "import sys; from imo_analysis.cli import main\n"
        "try:\n main(sys.argv[1:])\nexcept SystemExit as e: assert e.code == 0\n"
        f"print([m for m in {HEAVY!r} if m in sys.modules], file=sys.stderr)"
    )
    words = [command, "--help"] if command else ["--help"]
    done = subprocess.run([sys.executable, "-c", probe, *words], capture_output=True, text=True, check=True)
    assert done.stderr.strip().endswith("[]")
    lines = done.stdout.splitlines()
    assert len(lines) <= 40 and max(map(len, lines)) <= 130
    assert not command or "example:" in done.stdout


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["fly"], "'fly' is not a command"),
        (["poles", "--omgea", "3"], "--omgea"),
        (["simulate", "no-such-file.toml"], "no-such-file.toml"),
        (["excite", "no-such-run.nc"], "no-such-run.nc"),
        (["report", "no-such-study.toml"], "no-such-study.toml"),
        (["poles", "--omega", "1e200"], "must lie within"),
        (["report", "--out", ""], "--out is empty"),
        (["excite", "."], "it is not a file"),
        (["poles", "--json", "/no-such-folder/x.json"], "/no-such-folder"),
        (["poles", "--omega", "30,,60"], "--omega 30,,60 must be numbers"),
        (["excite", "x.nc", "--json", ""], "a file without a name"),
        (["study", "--machine", "table-iii"], "goes with --init"),
        (["poles", "--size", "slide"], "--size slide is about a figure"),
        (["poles", "--plot", "x.svg", "--size", "poster"], "choose from"),
    ],
)
def test_a_fault_is_one_line_and_exit_code_2(words: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(words) == 2
    err = capsys.readouterr().err
    assert says in err
    assert err.startswith("imo: ") and "Traceback" not in err
    assert len(err.strip().splitlines()) == 1


OUTPUTS = [
    *(([command], "--json") for command in cli.COMMANDS if command not in ("replay", "excite")),
    (["excite", "run.nc"], "--json"), (["replay", "log.csv", "--machine", "table-iii"], "--json"),
    (["simulate"], "--out"), (["simulate"], "--plot"), (["sweep"], "--plot"), (["sweep"], "--out"),
    (["poles"], "--map"), (["poles"], "--plot"), (["poles"], "--out"), (["excite", "run.nc"], "--plot"),
    (["excite", "run.nc"], "--out"), (["replay", "log.csv", "--machine", "table-iii"], "--plot"),
]


@pytest.mark.parametrize(("words", "option"), OUTPUTS)
def test_a_place_that_takes_no_file_is_refused_before_the_run(
    words: list[str], option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing else is said or made, and no file is read before: the ones that are named are not there."""
    monkeypatch.chdir(tmp_path)
    ending = {"--json": "json", "--out": "nc"}.get(option, "svg")
    (tmp_path / f"folder.{ending}").mkdir()
    for place, why in ((f"folder.{ending}", "it is a folder"), (f"none/x.{ending}", "there is no folder none")):
        assert cli.main([*words, option, place]) == 2
        said = capsys.readouterr()
        assert said.err.startswith(f"imo: cannot write {place}: {why}") and said.err.count("\n") == 1 and not said.out
    assert [path.name for path in tmp_path.iterdir()] == [f"folder.{ending}"]


def test_every_command_that_draws_draws_for_a_slide_too() -> None:
    for command in cli.COMMANDS:
        options = {option for action in cli.parser_of(command)._actions for option in action.option_strings}
        assert ("--size" in options) == (command == "report" or "--plot" in options), command


def test_a_figure_for_a_slide(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Larger in letters and paper than one for a column, the same bytes each time; without --size it is for a column."""
    monkeypatch.chdir(tmp_path)
    slide = ["--size", "slide"]
    for name, size in (("plain", []), ("column", ["--size", "column"]), ("slide", slide), ("again", slide)):
        files = ["--plot", f"{name}.svg", "--map", f"{name}-map.svg"]
        assert cli.main(["poles", "--over", "omega=-150:150:31", *files, *size]) == 0
    for kind in ("", "-map"):
        plain, column, large, again = (Path(f"{name}{kind}.svg").read_text() for name in ("plain", "column", "slide", "again"))
        assert plain == column and large == again
        before, after = ({float(found) for found in re.findall(r"font-size: ([\d.]+)px", text)} for text in (column, large))
        assert min(after) > 1.3 * min(before) and max(after) > 1.3 * max(before), "small letters grow as the others do"
        width, height = (float(re.search(rf'{side}="([\d.]+)pt"', large)[1]) for side in ("width", "height"))  # type: ignore[index]
        assert width == 720 and height <= 405, "16 to 9, in points"
    from imo_analysis.drawing import new_figure

    assert new_figure()[0].get_size_inches().tolist() == [7.2, 3.0], "the next command draws for a column again"


def test_an_interrupt_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupt(argv: list[str]) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "_run", interrupt)
    assert cli.main(["report"]) == 2
    assert capsys.readouterr().err.startswith("imo: interrupted")


def test_a_warning_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def warn(argv: list[str]) -> int:
        warnings.warn("kernels are not kept", stacklevel=1)
        return 0

    monkeypatch.setattr(cli, "_run", warn)
    assert cli.main(["report"]) == 0
    assert capsys.readouterr().err == "imo: warning: kernels are not kept\n"


def test_a_report_never_replaces_its_own_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study = tmp_path / "study.toml"
    assert cli.main(["study", "--init", str(study)]) == 0
    before = study.read_bytes()
    assert cli.main(["report", str(study), "--out", str(tmp_path)]) == 2
    assert "choose another folder" in capsys.readouterr().err and study.read_bytes() == before


def test_numbers_that_json_lacks_become_null(tmp_path: Path) -> None:
    from argparse import Namespace

    from imo_analysis.commands.output import emit_json

    file = tmp_path / "out.json"
    emit_json(Namespace(json=str(file)), "imo-test/1", {"a": float("nan"), "b": 1 + 2j, "c": (1, float("inf"))})
    data = json.loads(file.read_text())
    assert data["a"] is None and data["b"] == [1.0, 2.0] and data["c"] == [1, None]


@pytest.mark.parametrize(("words", "says"), [
    (["sweep", "study.toml", "--runs", "5", "--out", "a.nc", "--json", "study.toml"], "--json study.toml would overwrite"),
    (["simulate", "./study.toml", "--out", "a.nc", "--json", "../{here}/study.toml"], "would overwrite ./study.toml"),
    (["replay", "log.csv", "--machine", "study.toml", "--json", "log.csv"], "--json log.csv would overwrite log.csv"),
    (["poles", "study.toml", "--json", "study.toml"], "--json study.toml would overwrite study.toml"),
    (["excite", "run.nc", "--out", "run.nc"], "--out run.nc would overwrite run.nc"),
    (["report", "study.toml", "--json", "study.toml"], "--json study.toml would overwrite study.toml"),
    (["study", "--init", "motor.toml", "--machine", "motor.toml", "--force"], "--init motor.toml would overwrite motor.toml"),
    (["tune", "study.toml", "--out", "motor.toml"], "--out does not overwrite a .toml file"),
    (["derive", "--json", "motor.toml"], "--json does not overwrite a .toml file"),
    (["study", "--init", "motor.toml"], "motor.toml exists already"),
    (["study", "--init", "new.toml", "--json", "new.toml"], "--json and --init both write new.toml"),
])
def test_no_output_overwrites_what_is_not_a_result(
    words: list[str], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("study.toml", "motor.toml", "log.csv", "run.nc"):
        Path(name).write_text("as it was")
    assert cli.main([word.format(here=tmp_path.name) for word in words]) == 2
    error = capsys.readouterr().err
    assert says in error and error.count("\n") == 1
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == dict.fromkeys(
        ("study.toml", "motor.toml", "log.csv", "run.nc"), "as it was")


def test_an_interrupted_report_leaves_no_empty_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from imo_analysis.report import dossier

    def stop(study: object, out: str, *more: object) -> None:
        (Path(out) / "figures").mkdir(parents=True, exist_ok=True)
        if tmp_path.name in out and out.endswith("kept"):
            (Path(out) / "table2.csv").write_text("whole")
        raise KeyboardInterrupt

    monkeypatch.setattr(dossier, "write_dossier", stop)
    (tmp_path / "mine").mkdir()
    for name in ("new", "kept", "mine"):
        assert cli.main(["report", "--out", str(tmp_path / name)]) == 2
    assert "interrupted" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kept", "mine"]
