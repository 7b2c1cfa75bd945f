"""How the dossier writes a number, wherever it stands: a true minus, thousands parted, powers of ten written out.

`number` writes a value; `tidied` puts right what a format of Python's has left in a sentence, `in_formula` in LaTeX.
"""

from __future__ import annotations

import math
import re

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_LARGE = 6  # the first power of ten that is not written out
_POWER = re.compile(r"(?<![\w.])([-−+]?)(\d+(?:\.\d+)?)e([-+]\d+)(?!\w)")
_MINUS = re.compile(r"(?<![\w.)\]%])-(?=\d)")


def number(value: float, digits: int = 3, sign: bool = False) -> str:
    """A number for a table or a sentence: so many digits, a dash for NaN."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "−∞" if value < 0 else "∞"
    return tidied(f"{value:{'+' if sign else ''}.{digits}g}")


def tidied(text: str) -> str:
    """A text in which ``1.87e+03`` is 1,870, ``8.5e-05`` is 8.5·10⁻⁵ and a hyphen before a number is a minus."""
    return _MINUS.sub("−", _POWER.sub(_written, text))


def in_formula(latex: str) -> str:
    """LaTeX in which ``2.3e+06`` is a product with a power of ten."""
    return re.sub(r"(?<![\w.])(\d+(?:\.\d+)?)e([-+]\d+)(?!\w)", lambda one: rf"{one[1]} \cdot 10^{{{int(one[2])}}}", latex)


def _written(match: re.Match[str]) -> str:
    sign, mantissa, power = match[1].replace("-", "−"), match[2], int(match[3])
    if 0 < power < _LARGE:
        return f"{sign}{round(float(mantissa) * 10**power):,}"
    return f"{sign}{mantissa}·10{str(power).translate(_RAISED)}"
