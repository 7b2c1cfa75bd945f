"""Three independent ways to settle a question exactly: sympy's polynomial rings, FLINT, and Coq on an exported script."""

from __future__ import annotations

from imo_analysis.errors import InputError
from imo_analysis.ledger.question import Kernel

NAMES = ("sympy", "flint", "coq")


def kernel(name: str) -> Kernel:
    """A kernel by name, imported only now.

    Parameters
    ----------
    name : str
        ``sympy``, ``flint`` or ``coq``.

    Raises
    ------
    InputError
        If there is no such kernel, or what it needs is not installed.
    """
    if name == "sympy":
        from imo_analysis.ledger.kernels.sympy_kernel import SympyKernel

        return SympyKernel()
    if name == "flint":
        from imo_analysis.ledger.kernels.flint_kernel import FlintKernel

        return FlintKernel()
    if name == "coq":
        from imo_analysis.ledger.kernels.coq_kernel import CoqKernel

        return CoqKernel()
    raise InputError(f"kernel {name!r}: there are {', '.join(NAMES)}")
