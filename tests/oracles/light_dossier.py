"""A dossier without what takes long and is the same for every machine."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from imo_analysis.ledger.book import entries
from imo_analysis.study import Study


@cache
def settled() -> Any:
    return entries(("flint",))


@contextmanager
def light() -> Iterator[None]:
    """Without what is the same for every machine: ledger and proofs on Table II are tested elsewhere, the modulation too."""
    from imo_analysis.report import checks, drive, modulation

    seen: dict[str, Any] = {}

    @contextmanager
    def beside(path: Path, file: Path) -> Iterator[None]:
        seen["no_map"] = drive.compute(Study.load(file), path.parent)
        yield None

    nothing = {"claims": 0, "tried": 0, "rejected": {}, "equivalent": [], "missed": []}
    code = {"functions": 0, "tried": 0, "killed": 0, "equivalent": [], "survived": [], "unchecked": []}

    def collect(worker: None, path: Path) -> dict[str, Any]:
        path.write_text("{}", encoding="utf-8")
        return {"mutants": nothing, "definition_mutants": code, "constants": [], "refutations": [],
                "searched": {"results": [], "refused": ["left out"]}, **seen}

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(checks, "beside", beside)
        patch.setattr(checks, "collect", collect)
        patch.setattr("imo_analysis.ledger.book.entries", lambda kernels=(): settled())
        patch.setattr(modulation, "modulation", lambda study, folder: None)
        yield
