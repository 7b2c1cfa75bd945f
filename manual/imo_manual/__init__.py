"""A small Sphinx extension: everything in the manual that the program knows is read from the program."""

from __future__ import annotations

from typing import Any

from sphinx.application import Sphinx

from imo_manual import directives, mathml


def setup(app: Sphinx) -> dict[str, Any]:
    """Register formulas and directives."""
    mathml.setup(app)
    directives.setup(app)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
