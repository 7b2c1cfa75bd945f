"""Files appear whole or not at all; what cannot be read or written is an `InputError` in one line."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from imo_analysis.errors import InputError


def read_toml(path: str | Path) -> dict[str, Any]:
    """The contents of a TOML file.

    Raises
    ------
    InputError
        If it cannot be read or is not TOML; the text has the line.
    """
    import tomllib

    text = ""
    try:
        text = Path(path).read_bytes().decode()
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path} is not TOML: {error}{_in_quotes(text, str(error))}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is not TOML: it is not UTF-8 text") from None
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None


def _in_quotes(text: str, fault: str) -> str:
    """What to write in the line at fault where a quantity lacks its quotes, or has a comma in its number."""
    at = re.search(r"at line (\d+)", fault)
    if not at:
        return ""
    line = dict(enumerate(text.split("\n"), 1)).get(int(at[1]), "").rstrip("\r")
    found = re.match(r"\s*[\w.-]+\s*=\s*([-+]?\d+(?:[.,]\d+)?)\s*([^\s\d#,\"'\]}][^#\"']*)?(?:#.*)?$", line)
    if not found:
        return ""
    number, unit = found[1].replace(",", "."), (found[2] or "").strip()
    if unit:
        point = " and with a point" if "," in found[1] else ""
        return f'; in line {at[1]} write "{number} {unit}", in quotes{point}'
    return f"; in line {at[1]} write {number}, with a point" if "," in found[1] else ""


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A name beside ``path`` to write to; renamed to ``path`` when the block ends well, removed when it does not.

    Raises
    ------
    InputError
        If the folder does not take the file (missing, not writable, full).
    """
    path = Path(path)
    beside = _beside(path)
    try:
        yield beside
        umask = os.umask(0)
        os.umask(umask)
        beside.chmod(0o666 & ~umask)
        beside.replace(path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}; the file is as it was before") from None
    finally:
        beside.unlink(missing_ok=True)


def check_place(path: str | Path) -> None:
    """Refuse a place to which `replacing` could not write a file, before anything is computed for it.

    Raises
    ------
    InputError
        If the name is empty, a folder's or a device's, or its folder does not take the file.
    """
    if not str(path):
        raise InputError("cannot write a file without a name; name one, or leave the option out")
    _beside(Path(path)).unlink()


def _beside(path: Path) -> Path:
    """An empty file beside ``path``, on its file system."""
    try:
        if path.is_dir():
            raise InputError(f"cannot write {path}: it is a folder; name a file in it")
        if path.exists() and not path.is_file():
            raise InputError(f"cannot write {path}: it is not a file; choose another place")
        if not path.parent.is_dir():
            raise InputError(f"cannot write {path}: there is no folder {path.parent}; make it or choose another place")
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=path.suffix, dir=path.parent)
        os.close(handle)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}; choose another place") from None
    return Path(name)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file whole."""
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")


def folder(path: str | Path) -> Path:
    """Make a folder that can be written to.

    Raises
    ------
    InputError
        If it cannot be made or written to.
    """
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {path}: {error.strerror}; choose another place") from None
    if not os.access(path, os.W_OK):
        raise InputError(f"cannot write to the folder {path}: permission denied; choose another place")
    return path


def remove_empty(path: str | Path) -> None:
    """Remove a folder and those in it, unless there is a file in any of them."""
    path = Path(path)
    if path.is_dir() and not any(one.is_file() for one in path.rglob("*")):
        for inner in sorted((one for one in path.rglob("*") if one.is_dir()), reverse=True):
            inner.rmdir()
        path.rmdir()
