"""The frozen-speed system matrix without the poles that are zero by structure, for those that have no closed form.

A of rank r is ``B C``, B being r of its columns and C what makes the others of them; ``C B`` is r x r and has the poles of A
but for the zeros. So a pole that passes near zero is not mixed up with those that stay there. B and C are found symbolically,
among the choices of columns with which C divides by nothing that can be zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import sympy as sp

from imo_analysis.pencils.jacobian import jacobian, structural_rank


@dataclass(frozen=True)
class Reduced:
    """The r x r matrix.

    Attributes
    ----------
    matrix : sympy.Matrix
        ``C B``.
    arguments : tuple of str
        Names of what it depends on.
    function : callable
        Its entries, row by row, from the arguments as floats or arrays that broadcast.
    """

    matrix: Any
    arguments: tuple[str, ...]
    function: Any

    def poles(self, values: Mapping[str, Any]) -> np.ndarray:
        """The poles that are not zero by structure, complex, shape ``(..., r)``."""
        r = self.matrix.rows
        entries = self.function(*(values[name] for name in self.arguments))
        shape = np.broadcast_shapes(*(np.shape(values[name]) for name in self.arguments))
        matrices = np.empty((*shape, r * r))
        for k, entry in enumerate(entries):
            matrices[..., k] = entry
        return np.asarray(np.linalg.eigvals(matrices.reshape(*shape, r, r)), dtype=complex)


@cache
def reduced(name: str) -> Reduced:
    """The reduced frozen-speed matrix of an observer.

    Raises
    ------
    InputError
        If the observer is not known.
    """
    derived = jacobian(name, "frozen")
    n, rank = len(derived.states), structural_rank(name)
    A = derived.matrix[:n, :n]
    for chosen in combinations(range(n), rank):
        B = A[:, list(chosen)]
        C = _factor(B, A)
        if C is not None:
            matrix = (C * B).applyfunc(sp.cancel)
            ordered = {symbol.name: symbol for symbol in matrix.free_symbols}
            used = tuple(argument for argument in derived.arguments if argument in ordered)
            function = sp.lambdify([ordered[argument] for argument in used], list(matrix), modules="numpy", cse=True)
            return Reduced(matrix, used, function)
    raise AssertionError(f"{name}: every choice of columns divides by something that can be zero")


def _factor(B: Any, A: Any) -> Any:
    """C with ``A = B C``, or None where B has less than full rank or C divides by what can be zero."""
    from sympy.polys.matrices import DomainMatrix

    whole, pivots = DomainMatrix.from_Matrix(B.row_join(A)).to_field().rref()
    if pivots != tuple(range(B.cols)):
        return None
    C = whole.to_Matrix()[: B.cols, B.cols :].applyfunc(sp.cancel)
    return C if all(sp.fraction(entry)[1].is_positive for entry in C) else None
