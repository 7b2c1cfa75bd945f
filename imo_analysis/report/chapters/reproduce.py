"""The last chapter: how to get every number of the dossier again."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version

from imo_analysis import __version__
from imo_analysis.report.page import Chapter, join, prose, table, tag
from imo_analysis.study import Study

_PACKAGES = ("numpy", "scipy", "sympy", "python-flint", "control", "numba", "xarray", "h5netcdf", "matplotlib", "pydantic")


def versions() -> dict[str, str]:
    """Versions of this package, Python and what it computes with."""
    found = {"imo_analysis": __version__, "python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def reproduce_chapter(study: Study, files: Sequence[tuple[str, str]]) -> Chapter:
    """Commands, versions, the hash of the study, and the files beside the page."""
    commands = "\n".join(f"{command:<44}# {meaning}" if meaning else command for command, meaning in _commands(study))
    body = join(
        [
            prose("Everything on this page was computed by these commands from the study file; nothing was typed in."),
            tag("pre", tag("code", commands)),
            table(("", ""), [("study", study.title), ("SHA-256 of the study", tag("code", study.sha256)),
                             ("seed of all noise", str(study.simulation.seed))]),
            table(("package", "version"), list(versions().items()), "Versions"),
            table(("file", "what it holds"), [(tag("a", name, href=name), meaning) for name, meaning in files],
                  "Beside this page"),
            tag("details", tag("summary", "The study, whole"), tag("pre", tag("code", study.to_toml())), class_="more whole"),
        ]
    )
    return Chapter("reproduce", "Reproduce", "How to reproduce this", body)


def _commands(study: Study) -> list[tuple[str, str]]:
    """Commands with what each does, for this study: beside the page it is study.toml."""
    from imo_analysis.report.scenarios import scenario_names

    name = scenario_names(study)[-1]
    init = ("imo study --init study.toml", "the paper's study, commented, to change")
    return [
        *([init] if study.sha256 == Study.paper().sha256 else []),
        ("imo report study.toml --out imo-report", "this dossier; --markdown and --pdf make copies"),
        ("imo derive", "the ledger as a table"),
        ("imo derive eq12", "one entry, with its evidence"),
        (f"imo poles study.toml --omega {','.join(f'{omega:g}' for omega in study.poles.omega)}", ""),
        (f"imo simulate study.toml{f' --scenario {name}' if name else ''} --out run.nc", ""),
        ("imo excite run.nc", "whether alpha and speed can be told apart along it"),
        ("imo tune study.toml", "gains for what the study wishes"),
    ]
