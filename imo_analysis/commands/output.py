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


def check_places(args: argparse.Namespace, *options: str) -> None:
    """Refuse, before anything is computed, files that could not be written: those of ``--json`` and of ``options``.

    Raises
    ------
    InputError
        In one line; also where two options name one file.
    """
    taken: dict[Path, str] = {}
    for option in ("json", *options):
        place = getattr(args, option)
        if place is not None and (option, place) != ("json", "-"):
            check_place(place)
            other = taken.setdefault(Path(place).resolve(), option)
            if other != option:
                raise InputError(f"--{other} and --{option} both write {place}; give each a file of its own")


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
