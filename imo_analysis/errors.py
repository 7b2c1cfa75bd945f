"""The two ways in which a command ends early: the user's input was wrong, or a simulation left the finite numbers."""

from __future__ import annotations

from typing import Any


class InputError(ValueError):
    """Input that cannot be used. The text names the thing, its value, the bound, where it was read, and the fix.

    The command line prints the text as it is, without a traceback, and exits with code 2.
    """


class Diverged(ArithmeticError):
    """A simulation whose state left the bounds of what can be computed.

    The command line keeps the run up to that time, prints the text and exits with code 1.

    Attributes
    ----------
    time : float
        Time of the first sample that was not finite or out of bounds, in s.
    state : dict of str to float
        The last recorded state within bounds, by name.
    data : xarray.Dataset or None
        The run so far.

    Parameters
    ----------
    message : str
        What diverged and when, in a line.
    """

    def __init__(self, message: str, time: float, state: dict[str, float], data: Any = None) -> None:
        super().__init__(message)
        self.time = time
        self.state = state
        self.data = data
