"""The two ways in which a command ends early: the user's input was wrong, or a simulation left the finite numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
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


def unknown_key(where: str, name: str, known: Iterable[str], also: Mapping[str, str] | None = None) -> str:
    """The text for a key that is not known, with the one that was probably meant.

    Parameters
    ----------
    where : str
        Names the table.
    name : str
        The key as written.
    known : iterable of str
        The keys that there are.
    also : mapping, optional
        Other names, in lower-case letters only, to the key that they mean.
    """
    import difflib

    def plain(text: str) -> str:
        return "".join(letter for letter in text.lower() if letter.isalnum())

    by_plain = {**(also or {}), **{plain(key): key for key in known}}
    near = difflib.get_close_matches(plain(name), by_plain, 1, 0.7)
    place = f"{where}.{name}" if where else name
    return f"{place} is not a known key" + (f"; did you mean {by_plain[near[0]]}?" if near else "")
