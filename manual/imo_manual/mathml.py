"""Formulas as MathML through the converter of the dossier, with its math font: nothing is fetched and no script runs."""

from __future__ import annotations

import html
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util import logging

from imo_analysis.report.math import font_face, mathml

_LOG = logging.getLogger(__name__)
_STYLE = """
math{font-family:"Imo Math","STIX Two Math","Cambria Math",math;font-size:1.08em}
.formula{display:flex;align-items:center;gap:1rem;margin:.4rem 0}
.formula .number{margin-left:auto;color:var(--color-foreground-secondary);white-space:nowrap}
.formula .scrolled{overflow-y:hidden;padding:.35rem 0;min-width:0}
.formula + .formula{margin-top:-.2rem}
"""


def element(latex: str, display: bool, place: Any = None) -> str:
    """The ``<math>`` element of a formula; a warning if it cannot be read."""
    found = mathml(latex, display)
    if "unread" in found:
        _LOG.warning("formula cannot be set: %s", latex, location=place)
    return found


def _inline(self: Any, node: nodes.math) -> None:
    self.body.append(element(node.astext(), False, node))
    raise nodes.SkipNode


def _block(self: Any, node: nodes.math_block) -> None:
    number = node.get("number_text") or (f"({node['number']})" if node.get("number") else "")
    said = f'<span class="number">{html.escape(number)}</span>' if number else ""
    ids = f' id="{node["ids"][0]}"' if node.get("ids") else ""
    # a formula that is wider than the page is scrolled beside its number, so the keyboard must reach it
    box = f'<div class="scrolled" tabindex="0" role="group" aria-label="formula">{element(node.astext(), True, node)}</div>'
    self.body.append(f'<div class="formula"{ids}>{box}{said}</div>\n')
    raise nodes.SkipNode


def _write_font(app: Sphinx) -> None:
    place = Path(app.outdir) / "_static"
    place.mkdir(parents=True, exist_ok=True)
    (place / "imo-math.css").write_text(font_face() + _STYLE, encoding="utf-8")


def setup(app: Sphinx) -> None:
    """Register the renderer and its style sheet."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.connect("builder-inited", _write_font)
    app.add_css_file("imo-math.css")
