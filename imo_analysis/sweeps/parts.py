"""Chunks of a sweep kept in a folder beside the result, so that a sweep killed at any moment goes on where it was."""

from __future__ import annotations

import json
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.files import folder, replacing, write_text
from imo_analysis.sweeps.metrics import METRICS
from imo_analysis.sweeps.sweep import CHUNK, Part, Plan

_MANIFEST = "manifest.json"
_FIELDS = (*METRICS, "possible", "reasons")


class Parts:
    """The folder ``NAME.parts`` beside the result ``NAME``: a manifest that says of which sweep, and a file for each chunk.

    Raises
    ------
    InputError
        If it belongs to another sweep, or is there and ``resume`` is not asked for.
    """

    def __init__(self, plan: Plan, out: Path, resume: bool) -> None:
        self._plan = plan
        self.path = out.with_name(out.name + ".parts")
        manifest = {"schema": "imo-sweep-parts/1", "study": plan.text, "chunk": CHUNK,
                    "versions": {name: version(name) for name in ("imo-analysis", "numpy", "numba", "llvmlite")}}
        if self.path.exists() and not resume:
            raise InputError(
                f"{self.path} holds a sweep that was not finished; add --resume to go on with it, or remove the folder")
        folder(self.path)
        place = self.path / _MANIFEST
        if place.exists():
            try:
                before = json.loads(place.read_text(encoding="utf-8"))
            except ValueError:
                raise InputError(f"{place} cannot be read; remove the folder {self.path} and start anew") from None
            changed = [name for name in manifest if before.get(name) != manifest[name]]
            if changed:
                raise InputError(f"{self.path} holds another sweep (its {', '.join(changed)} differs); remove the folder, or "
                                 "choose another --out")
        else:
            write_text(place, json.dumps(manifest, indent=1) + "\n")

    def done(self) -> dict[int, Part]:
        """The chunks that are there and whole."""
        found: dict[int, Part] = {}
        for chunk in self._plan.chunks:
            place = self._file(chunk.number)
            if place.exists():
                try:
                    with np.load(place, allow_pickle=False) as data:
                        found[chunk.number] = {name: data[name] for name in _FIELDS}
                except (OSError, ValueError, KeyError, zipfile.BadZipFile):
                    continue  # computed again
        return found

    def keep(self, number: int, part: Part) -> None:
        """Write a chunk, whole or not at all."""
        with replacing(self._file(number)) as beside, open(beside, "wb") as file:
            np.savez(file, **{name: part[name] for name in _FIELDS})  # type: ignore[arg-type]

    def remove(self) -> None:
        """Remove the folder when the result stands."""
        for chunk in self._plan.chunks:
            self._file(chunk.number).unlink(missing_ok=True)
        (self.path / _MANIFEST).unlink(missing_ok=True)
        for left in self.path.glob(".chunk-*"):
            left.unlink(missing_ok=True)
        self.path.rmdir()

    def _file(self, number: int) -> Path:
        return self.path / f"chunk-{number:06d}.npz"
