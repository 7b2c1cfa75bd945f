"""All claims of the paper in its order, and the entries that settle them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from importlib import import_module

from imo_analysis.errors import InputError
from imo_analysis.ledger.claim import Claim, Entry
from imo_analysis.ledger.claims import MODULES
from imo_analysis.ledger.kernels import NAMES, kernel
from imo_analysis.ledger.settle import settle
from imo_analysis.paper.contents import ITEMS

SUBJECTS = ("kubota",)  # modules of ledger/subjects/


@cache
def claims() -> tuple[Claim, ...]:
    """Every claim of the paper, in its order, and after them what is ours.

    Raises
    ------
    InputError
        If two claims have one id.
    """
    found = [claim for name in MODULES for claim in import_module(f"imo_analysis.ledger.claims.{name}").CLAIMS]
    places = {one.id: place for place, one in enumerate(ITEMS)}
    last = len(places)  # what is ours
    found.sort(key=lambda claim: places.get(claim.id, places.get(claim.id.partition(".")[0], last)))
    return checked(found)


def checked(found: Iterable[Claim]) -> tuple[Claim, ...]:
    """The claims, after a look at ids and links."""
    found = tuple(found)
    ids = [claim.id for claim in found]
    for name in ids:
        if ids.count(name) > 1:
            raise InputError(f"claim id {name!r} is used twice; ids are unique")
    return found


def subject(name: str = "paper") -> tuple[Claim, ...]:
    """The claims of a subject: the paper, or another audit shipped as an example.

    Parameters
    ----------
    name : str
        ``paper`` or one of `SUBJECTS`.

    Raises
    ------
    InputError
        If there is no such subject.
    """
    if name == "paper":
        return claims()
    if name not in SUBJECTS:
        raise InputError(f"subject {name!r}: there are paper, {', '.join(SUBJECTS)}")
    return checked(import_module(f"imo_analysis.ledger.subjects.{name}").CLAIMS)


def kernel_names(which: str) -> tuple[str, ...]:
    """The kernels of ``sympy``, ``flint``, ``coq`` or ``all``."""
    return NAMES if which == "all" else (which,)


def entries(kernels: Sequence[str] = ("flint",), which: Iterable[Claim] | None = None) -> list[Entry]:
    """Settled entries, with the kernels by name; they must agree.

    Parameters
    ----------
    kernels : sequence of str
        Any of ``sympy``, ``flint``, ``coq``.
    which : iterable of Claim, optional
        Some claims instead of all of the paper's.
    """
    return settle(claims() if which is None else which, [kernel(name) for name in kernels])
