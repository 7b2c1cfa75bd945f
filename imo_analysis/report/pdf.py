"""The dossier as PDF, printed by a browser where there is one."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
_PATIENCE = 180  # s
_FLAGS = ("--headless", "--disable-gpu", "--no-first-run", "--disable-background-networking",
          "--disable-component-update", "--disable-sync", "--no-pdf-header-footer", "--generate-pdf-document-outline")
_BESIDE = re.compile(r' href="(?!#|data:)[^"]*"')  # links to files beside the page, not the pictures inside it
_DATE = re.compile(rb"/(CreationDate|ModDate) \(D:\d{14}")
_NO_DATE = b"20000101000000"


def browser() -> str | None:
    """A browser that can print without a screen, or None."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


def _root() -> list[str]:
    """A browser that root starts refuses its own sandbox."""
    return ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []


def print_page(page: Path, target: Path) -> str:
    """Print a page on A4, with bookmarks; the same page gives the same bytes.

    Parameters
    ----------
    page, target : Path
        HTML file and PDF file.

    Returns
    -------
    str
        Empty when it is done; else why there is no PDF.
    """
    found = browser()
    if found is None:
        return f"no PDF: none of {', '.join(BROWSERS)} is on the path; install one, or print index.html from any browser"
    with tempfile.TemporaryDirectory() as place:
        made = Path(place) / "page.pdf"
        try:
            # links to files beside the page would become addresses on this machine
            copy = Path(place) / "page.html"
            copy.write_text(_BESIDE.sub("", page.read_text(encoding="utf-8")), encoding="utf-8")
            done = subprocess.run([found, *_FLAGS, *_root(), f"--user-data-dir={place}/profile", f"--print-to-pdf={made}",
                                   copy.as_uri()], capture_output=True, timeout=_PATIENCE)
        except (OSError, subprocess.TimeoutExpired) as error:
            return f"no PDF: {found} did not print ({error})"
        if not made.is_file():
            return f"no PDF: {found} did not print: {done.stderr.decode(errors='replace').strip()[-300:]}"
        target.write_bytes(_DATE.sub(rb"/\1 (D:" + _NO_DATE, made.read_bytes()))
    return ""
