"""``imo notebook``: the derivations as Jupyter notebooks, run on request."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from imo_analysis.errors import InputError

DESCRIPTION = """The derivations as Jupyter notebooks: the model and the stator flux, the transformation, the three
conventions, the error dynamics, the Lyapunov function, what breaks and the repairs, Barbalat's step, excitation.
Needs the extra 'notebooks'. Exit code 1 if a notebook that is executed fails."""
EXAMPLE = """\
  imo notebook --out notebooks
  imo notebook --out notebooks --only 06 --execute"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--out", metavar="DIR", help="folder for the .ipynb files; without it they are listed only")
    parser.add_argument("--only", action="append", metavar="NN", help="number or beginning of the name; repeat for more")
    parser.add_argument("--execute", action="store_true", help="run them, so that they hold their results")


def sources() -> list[Path]:
    """The derivations, in order: beside the package in a checkout, inside it when installed.

    Raises
    ------
    InputError
        If they are in neither place.
    """
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "derivations", package.parent / "derivations"):
        found = sorted(folder.glob("[0-9][0-9]_*.py"))
        if found:
            return found
    raise InputError("the derivations are missing from this installation; install imo-analysis again")


def title(path: Path) -> str:
    """The heading of a derivation."""
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("# # "):
            return line.removeprefix("# # ")
    return path.stem


def run(args: argparse.Namespace) -> int:
    """List the derivations, or write them as notebooks."""
    from imo_analysis.commands.output import check_places, emit_json, say

    check_places(args)
    chosen = [path for path in sources() if not args.only or any(path.name.startswith(one) for one in args.only)]
    if not chosen:
        have = ", ".join(path.stem for path in sources())
        raise InputError(f"--only {' '.join(args.only)} matches none of: {have}")
    if args.execute and not args.out:
        raise InputError("--execute writes results into notebooks; say where with --out DIR")
    rows: list[dict[str, Any]] = []
    failed = False
    for path in chosen:
        row: dict[str, Any] = {"name": path.stem, "title": title(path), "file": None, "executed": False, "error": None}
        if args.out:
            row.update(_write(path, Path(args.out), args.execute))
        failed = failed or row["error"] is not None
        rows.append(row)
        fault = f": {row['error']}" if row["error"] else ""
        say(args, f"{row['file']}{fault}" if args.out else f"{path.stem:45s} {row['title']}")
    emit_json(args, "imo-notebooks/1", {"notebooks": rows})
    return int(failed)


def _write(path: Path, folder: Path, execute: bool) -> dict[str, Any]:
    """Write one notebook; one that fails is written too, with its traceback in place."""
    from imo_analysis.files import write_text

    try:
        import jupytext
        import nbformat
    except ImportError:
        raise InputError("notebooks need jupytext and nbformat: pip install 'imo-analysis[notebooks]'") from None
    notebook = jupytext.read(path, fmt="py:percent")
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number:02d}"  # a fixed name, so that two exports are the same file
    error = None
    if execute:
        try:
            from nbclient import NotebookClient
            from nbclient.exceptions import CellExecutionError
        except ImportError:
            raise InputError("--execute needs nbclient and ipykernel: pip install 'imo-analysis[notebooks]'") from None
        try:
            NotebookClient(notebook, timeout=120, kernel_name="python3", extra_arguments=["--log-level=40"]).execute()
        except CellExecutionError as fault:
            error = str(fault).strip().splitlines()[-1]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"cannot make the folder {folder}: {fault.strerror}; choose another --out") from None
    target = folder / f"{path.stem}.ipynb"
    write_text(target, nbformat.writes(notebook) + "\n")
    return {"file": str(target), "executed": execute, "error": error}
