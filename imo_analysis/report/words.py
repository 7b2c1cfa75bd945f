"""Prose with names of the notation table set as symbols: ``alpha_hat`` in a sentence is shown as the letter with its hat."""

from __future__ import annotations

import re

from imo_analysis.errors import InputError
from imo_analysis.notation import symbol
from imo_analysis.report.page import Html, inline

_GREEK = "alpha|beta|gamma|sigma|omega|mu|xi|kappa|rho|delta|phi"
_NAME = re.compile(rf"(?<![\w.$\\])(?:[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)+|{_GREEK})(?![A-Za-z0-9_])")
_SIGNED = re.compile(r"(?<![\w)])-(?=[\w(])")  # a hyphen before a term is a minus
_KEPT = re.compile(r"(`[^`]*`|\$[^$]*\$)")


def typeset(source: object) -> Html:
    """Text with backticks, dollars and bare names of the notation table as HTML."""
    if isinstance(source, Html):
        return source
    pieces = _KEPT.split(str(source))
    return inline("".join(piece if number % 2 else _NAME.sub(_symbol, _signs(piece)) for number, piece in enumerate(pieces)))


_POWER = re.compile(r"\^(\d)(?!\d)")
_DIGITS = "⁰¹²³⁴⁵⁶⁷⁸⁹"


def _signs(text: str) -> str:
    """Signs as books set them: a minus for a hyphen before a term or between two, raised digits, and relation signs."""
    for written, sign in ((">=", "≥"), ("<=", "≤"), ("!=", "≠"), ("->", "→")):
        text = text.replace(written, sign)
    text = _POWER.sub(lambda power: _DIGITS[int(power[1])], text)
    return _SIGNED.sub("−", text).replace(" - ", " − ")


def _symbol(match: re.Match[str]) -> str:
    latex = _latex(match[0])
    return f"${latex}$" if latex else match[0]


def _latex(name: str) -> str:
    """LaTeX of a name of the table, or of a letter that stands for a d/q pair (``xi_hat``, ``v_1``); empty for other words."""
    try:
        return symbol(name).latex
    except InputError:
        pass
    for suffix, accent in (("_dot", r"\dot"), ("_hat", r"\hat"), ("_tilde", r"\tilde")):
        if name.endswith(suffix):
            inner = _latex(name.removesuffix(suffix))
            return f"{accent}{{{inner}}}" if inner else ""
    if name in ("xi", "rho", "phi"):
        return f"\\{name}"
    base, mark, index = name.partition("_")
    if len(base) == 1 and (not mark or index.isdigit()):
        return f"{base}_{{{index}}}" if mark else base
    if base in ("rho", "xi", "kappa") and index.isdigit():
        return f"\\{base}_{{{index}}}"
    return ""


def unit(written: str) -> str:
    """A unit as people write it: 1/(kg m²), Ω; a dash for a pure number."""
    raised = re.sub(r"\^(-?\d)", lambda power: power[1].replace("-", "⁻")[:-1] + _DIGITS[int(power[1][-1])], written)
    return "–" if written == "1" else raised.replace("ohm", "Ω")
