"""Prose with the names of the notation table set as symbols: ``alpha_hat`` in a sentence is shown as the letter with its hat."""

from __future__ import annotations

import re

from imo_analysis.errors import InputError
from imo_analysis.notation import symbol
from imo_analysis.report.page import Html, inline

_GREEK = "alpha|beta|gamma|sigma|omega|mu|xi|kappa|rho|delta"
_NAME = re.compile(rf"(?<![\w.$\\])(?:[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)+|{_GREEK})(?![\w(])")
_KEPT = re.compile(r"(`[^`]*`|\$[^$]*\$)")


def typeset(source: object) -> Html:
    """Text with backticks, dollars and bare names of the notation table as HTML."""
    if isinstance(source, Html):
        return source
    pieces = _KEPT.split(str(source))
    return inline("".join(piece if number % 2 else _NAME.sub(_symbol, piece) for number, piece in enumerate(pieces)))


def _symbol(match: re.Match[str]) -> str:
    if match[0] in ("xi", "rho"):
        return rf"$\{match[0]}$"
    try:
        return f"${symbol(match[0]).latex}$"
    except InputError:
        return match[0]
