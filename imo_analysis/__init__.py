"""Speed-sensorless observers of induction machines: printed equations proved, linearised, run and written up.

Importing this package costs nothing: every public name is loaded when it is first used.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

# public name -> the module that defines it
_PUBLIC = {
    "InductionMachine": "imo_analysis.machine",
    "Study": "imo_analysis.study",
    "InputError": "imo_analysis.errors",
    "Diverged": "imo_analysis.errors",
}

__all__ = ["__version__", *sorted(_PUBLIC)]


def __getattr__(name: str) -> Any:
    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module 'imo_analysis' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
