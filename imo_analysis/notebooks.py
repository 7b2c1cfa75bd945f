"""The literate sources, derivations and lessons, as Jupyter notebooks: found, converted, executed, compared."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from imo_analysis.errors import InputError

KINDS = {"derivations": "[0-9][0-9]_*.py", "course": "lesson_[0-9][0-9]_*.py"}
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_RELATIVE, _ABSOLUTE = 0.02, 1e-6  # how far a printed number may move: the last digits depend on the machine


def sources(kind: str) -> list[Path]:
    """The sources of a kind, in order: beside the package in a checkout, inside it when installed.

    Parameters
    ----------
    kind : str
        ``derivations`` or ``course``.

    Raises
    ------
    InputError
        If they are in neither place.
    """
    package = Path(__file__).resolve().parent
    for folder in (package / kind, package.parent / kind):
        found = sorted(folder.glob(KINDS[kind]))
        if found:
            return found
    raise InputError(f"the files of {kind} are missing from this installation; install imo-analysis again")


def title(path: Path) -> str:
    """The heading of a source."""
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("# # "):
            return line.removeprefix("# # ")
    return path.stem


def converted(path: Path) -> Any:
    """A source as a clean notebook; the same source gives the same notebook.

    Raises
    ------
    InputError
        If jupytext is not installed.
    """
    try:
        import jupytext
    except ImportError:
        raise InputError("notebooks need jupytext and nbformat: pip install 'imo-analysis[notebooks]'") from None
    notebook = jupytext.read(path, fmt="py:percent")
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number:02d}"
    return notebook


def executed(notebook: Any) -> str | None:
    """Run a notebook in a kernel of its own, in place, figures without sliders; the last line of its fault, if it has one.

    Raises
    ------
    InputError
        If nbclient is not installed.
    """
    try:
        from nbclient import NotebookClient
        from nbclient.exceptions import CellExecutionError
    except ImportError:
        raise InputError("--execute needs nbclient and ipykernel: pip install 'imo-analysis[notebooks]'") from None
    client = NotebookClient(notebook, timeout=120, kernel_name="python3", extra_arguments=["--log-level=40"],
                            record_timing=False, coalesce_streams=True)
    fault = None
    try:
        client.execute(env={**os.environ, "IMO_STATIC": "1"})
    except CellExecutionError as error:
        fault = str(error).strip().splitlines()[-1]
    notebook.metadata["language_info"] = {"name": "python"}  # without the version, so that two machines write the same
    return fault


def written(notebook: Any) -> str:
    """A notebook as the text of its file."""
    import nbformat

    return str(nbformat.writes(notebook)) + "\n"


def differences(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """What differs between two notebooks: the text of a cell, or what it printed, numbers to 2 %. Pictures are not compared.

    Parameters
    ----------
    old, new : mapping
        Notebooks, as nbformat or JSON gives them.
    """
    if len(old["cells"]) != len(new["cells"]):
        return [f"{len(old['cells'])} cells, now {len(new['cells'])}"]
    found = []
    for number, (a, b) in enumerate(zip(old["cells"], new["cells"], strict=True)):
        if _joined(a["source"]) != _joined(b["source"]):
            found.append(f"cell {number}: its text differs")
        elif not _alike(_printed(a), _printed(b)):
            found.append(f"cell {number}: its output differs")
    return found


def _joined(text: str | list[str]) -> str:
    return text if isinstance(text, str) else "".join(text)


def _printed(cell: Mapping[str, Any]) -> str:
    """Everything that a cell wrote as text or formulas; for a picture that there is one."""
    parts = []
    for output in cell.get("outputs", ()):
        data = output.get("data", {})
        parts.append(_joined(output.get("text", "")) or _joined(data.get("text/latex", "")) or " ".join(sorted(data)))
    return "\n".join(parts)


def _alike(old: str, new: str) -> bool:
    if _NUMBER.split(old) != _NUMBER.split(new):
        return False
    pairs = zip(_NUMBER.findall(old), _NUMBER.findall(new), strict=True)
    return all(abs(float(a) - float(b)) <= _RELATIVE * abs(float(a)) + _ABSOLUTE for a, b in pairs)
