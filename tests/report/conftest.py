"""One dossier of a short study for all tests of this folder, also when they run in several processes; and a browser."""

import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsers import missing
from short_dossier import short_dossier_study

from imo_analysis.cli import main

PATIENCE = 300.0  # s


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if base.name.startswith("popen-") else base  # the parent is common to the processes of xdist
    place = shared / "dossier"
    try:
        place.mkdir()
    except FileExistsError:
        deadline = time.monotonic() + PATIENCE
        while not (place / "done").exists():
            assert time.monotonic() < deadline, "the process that makes the dossier did not finish"
            time.sleep(0.2)
    else:
        study = place / "study.toml"
        study.write_text(short_dossier_study().to_toml(), encoding="utf-8")
        code = main(["report", str(study), "--out", str(place / "out"), "--json", str(place / "summary.json"), "--quiet",
                     "--markdown"])
        (place / "done").write_text(str(code), encoding="utf-8")
    assert (place / "done").read_text(encoding="utf-8") == "0"
    return place / "out"


@pytest.fixture(scope="session")
def text(folder: Path) -> str:
    return (folder / "index.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    found = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if found is None:
        missing("chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        missing("playwright")
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=found, args=["--no-sandbox", "--disable-gpu"])
        yield started
        started.close()
