"""``imo notebook``: derivations and lessons as Jupyter notebooks, clean or executed."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from imo_analysis.errors import InputError

DESCRIPTION = """Jupyter notebooks: the derivations (the paper's steps, settled one by one) and the course (ten lessons with
checked exercises). Without --out they are listed. Needs the extra 'notebooks'. Exit code 1 if a notebook fails when executed,
or differs from the one that it is compared with."""
EXAMPLE = """\
  imo notebook --course --out lessons            clean, answers to fill in
  imo notebook --only lesson_03 --out lessons --execute"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--out", metavar="DIR", help="folder for the .ipynb files; without it they are listed only")
    parser.add_argument("--only", action="append", metavar="NAME",
                        help="name or its beginning, such as 06 (a derivation) or lesson_06; repeat for more")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--course", action="store_true", help="the lessons alone")
    which.add_argument("--derivations", action="store_true", help="the derivations alone")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--clean", action="store_true", help="without results, to be worked through (the default)")
    how.add_argument("--execute", action="store_true", help="run them, so that they hold their results")
    parser.add_argument("--against", metavar="DIR", help="compare with the notebooks of the same name in DIR, if there are any")


def run(args: argparse.Namespace) -> int:
    """List the notebooks, or write them."""
    from imo_analysis.commands.output import check_places, emit_json, say
    from imo_analysis.notebooks import KINDS, sources, title

    check_places(args)
    kinds = ["course"] if args.course else ["derivations"] if args.derivations else list(KINDS)
    have = [(kind, path) for kind in kinds for path in sources(kind)]
    chosen = [(kind, path) for kind, path in have if not args.only or any(path.name.startswith(one) for one in args.only)]
    if not chosen:
        raise InputError(f"--only {' '.join(args.only)} matches none of: {', '.join(path.stem for _, path in have)}")
    for option, given in (("--execute", args.execute), ("--clean", args.clean), ("--against", args.against)):
        if given and not args.out:
            raise InputError(f"{option} is about notebooks that are written; say where with --out DIR")
    if args.against and not Path(args.against).is_dir():
        raise InputError(f"--against {args.against} is not a folder; give one with notebooks to compare with")
    rows: list[dict[str, Any]] = []
    for kind, path in chosen:
        row: dict[str, Any] = {"name": path.stem, "kind": kind, "title": title(path), "file": None, "executed": False,
                               "error": None, "differences": []}
        if args.out:
            row.update(_write(path, Path(args.out), args.execute, args.against))
        rows.append(row)
        faults = [*([row["error"]] if row["error"] else []), *row["differences"]]
        say(args, "\n    ".join([row["file"], *faults]) if args.out else f"{path.stem:45s} {row['title']}")
    if args.out and any(kind == "course" for kind, _ in chosen):
        say(args, _index(Path(args.out)))
    emit_json(args, "imo-notebooks/1", {"notebooks": rows})
    return int(any(row["error"] or row["differences"] for row in rows))


def _write(path: Path, folder: Path, execute: bool, against: str | None) -> dict[str, Any]:
    """Write one notebook; one that fails is written too, with its traceback in place."""
    from imo_analysis.files import write_text
    from imo_analysis.notebooks import converted, differences, executed, written

    notebook = converted(path)
    error = executed(notebook) if execute else None
    _make(folder)
    target = folder / f"{path.stem}.ipynb"
    text = written(notebook)
    changed: list[str] = []
    if against and (old := Path(against) / target.name).is_file():
        try:
            changed = differences(json.loads(old.read_text(encoding="utf-8")), json.loads(text))
        except (ValueError, KeyError, TypeError):
            raise InputError(f"{old} is not a notebook; remove it from the folder of --against") from None
    write_text(target, text)
    return {"file": str(target), "executed": execute, "error": error, "differences": changed}


def _index(folder: Path) -> str:
    """The course's table of contents, with links to the notebooks."""
    from imo_analysis.files import write_text
    from imo_analysis.notebooks import sources

    text = (sources("course")[0].parent / "README.md").read_text(encoding="utf-8").replace(".py)", ".ipynb)")
    write_text(folder / "START_HERE.md", text)
    return str(folder / "START_HERE.md")


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"cannot make the folder {folder}: {fault.strerror}; choose another --out") from None
