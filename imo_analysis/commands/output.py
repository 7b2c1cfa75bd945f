"""What every command prints: text for people, and ``--json`` with a versioned layout (FORMATS.md)."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any

from imo_analysis import __version__
from imo_analysis.errors import InputError
from imo_analysis.files import check_place, write_text


def check_places(args: argparse.Namespace, *options: str, force: bool = False) -> None:
    """Refuse, before anything is computed, files that must not or could not be written: those of ``--json`` and of ``options``.

    An output is refused that is an input of the command (whatever else on its command line names a file), that another option
    writes too, or that is an existing ``.toml``: studies are written by people. Results (.nc, .csv, .svg, .json) are replaced.

    Parameters
    ----------
    args : argparse.Namespace
        Of the command.
    *options : str
        Names of the options that write a file.
    force : bool
        Let an existing ``.toml`` be replaced.

    Raises
    ------
    InputError
        In one line.
    """
    outputs = ("json", *options)
    read = _inputs(args, outputs)
    taken: dict[Path, str] = {}
    for option in outputs:
        place = getattr(args, option)
        if place is None or (option, place) == ("json", "-"):
            continue
        check_place(place)
        whole = Path(place).resolve()
        if whole in read:
            raise InputError(f"--{option} {place} would overwrite {read[whole]}, which the command reads; choose another name")
        other = taken.setdefault(whole, option)
        if other != option:
            raise InputError(f"--{other} and --{option} both write {place}; give each a file of its own")
        if whole.suffix.lower() == ".toml" and whole.exists() and not force:
            raise InputError(f"{place} exists already, and --{option} does not overwrite a .toml file; choose another name"
                             + (", or --force to overwrite it" if hasattr(args, "force") else ""))


def _inputs(args: argparse.Namespace, outputs: tuple[str, ...]) -> dict[Path, str]:
    """Files that the command line names, outputs aside, by their whole path."""
    found = {}
    for name, value in vars(args).items():
        for text in value if isinstance(value, list) else [value]:
            if name not in outputs and isinstance(text, str) and text and len(text) < 1000:
                path = Path(text)
                try:
                    if path.is_file():
                        found[path.resolve()] = text
                except (OSError, ValueError):
                    continue  # no name of a file
    return found


def say(args: argparse.Namespace, text: str = "") -> None:
    """Print text for people; it goes to standard error when standard output carries JSON."""
    print(text, file=sys.stderr if args.json == "-" else sys.stdout)


def emit_json(args: argparse.Namespace, schema: str, data: dict[str, Any]) -> None:
    """Write ``data`` as JSON where ``--json`` says, headed by its schema and the program's version.

    Numbers that JSON does not have (NaN, infinities) are written as null.
    """
    if args.json is None:
        return
    whole = plain({"schema": schema, "imo_analysis": __version__, **data})
    text = json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False)
    if args.json == "-":
        print(text)
    else:
        write_text(args.json, text + "\n")


def plain(value: Any) -> Any:
    """Data as JSON can hold it: arrays as lists, complex as [real, imaginary], NaN and infinities as None."""
    if isinstance(value, dict):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
