"""The system matrix without the poles that z_tilde and xi_tilde have between them whatever the gains are.

Both are driven by the current error alone and turn with the frame: ``(z, xi)' = -w_s J (z, xi) + C i``. So what is excited of
them is ``(z, xi) = C y`` with ``y' = -w_s J y + i``, and with y in their place two states fewer have all poles but a pair:
zero twice at frozen speed, where the frame rests, and plus and minus j w_s in the frame of the flux. Nothing is divided by,
and a pole that passes near one of those is not mixed up with it by an eigenvalue solver.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from imo_analysis.pencils.error import poles
from imo_analysis.pencils.jacobian import Kind, jacobian

_LOOPS = ("z_1_tilde", "z_2_tilde", "xi_1_tilde", "xi_2_tilde")


@dataclass(frozen=True)
class Reduced:
    """The smaller matrix.

    Attributes
    ----------
    matrix : sympy.Matrix
        In (i_tilde, y, the adapted), or the whole matrix where there is no xi.
    arguments : tuple of str
        Names of what it depends on.
    function : callable
        Its entries, row by row, from the arguments as floats or arrays that broadcast.
    """

    matrix: Any
    arguments: tuple[str, ...]
    function: Any

    def poles(self, values: Mapping[str, Any]) -> np.ndarray:
        """Its poles, complex, shape ``(..., n)``, sorted."""
        n = self.matrix.rows
        shape = np.broadcast_shapes(*(np.shape(values[name]) for name in self.arguments))
        matrices = np.empty((*shape, n * n))
        for k, entry in enumerate(self.function(*(values[name] for name in self.arguments))):
            matrices[..., k] = entry
        return poles(matrices.reshape(*shape, n, n))


@cache
def reduced(name: str, kind: Kind = "frozen") -> Reduced:
    """The reduced matrix of an observer.

    Raises
    ------
    InputError
        As `imo_analysis.pencils.jacobian.jacobian`.
    """
    derived = jacobian(name, kind)
    n = len(derived.states)
    matrix = derived.matrix[:n, :n]
    if set(_LOOPS) <= set(derived.states):
        matrix = _without_the_pair(matrix, derived.states)
    ordered = {symbol.name: symbol for symbol in matrix.free_symbols}
    used = tuple(argument for argument in derived.arguments if argument in ordered)
    function = sp.lambdify([ordered[argument] for argument in used], list(matrix), modules="numpy", cse=True)
    return Reduced(matrix, used, function)


def _without_the_pair(A: Any, states: tuple[str, ...]) -> Any:
    current = [states.index("i_ds_tilde"), states.index("i_qs_tilde")]
    loops = [states.index(state) for state in _LOOPS]
    rest = [k for k in range(len(states)) if k not in (*current, *loops)]
    C = A[loops, current]
    turning = A[loops[:2], loops[:2]]
    P = sp.zeros(len(states), 4 + len(rest))
    for column, row in enumerate((*current, None, None, *rest)):
        if row is not None:
            P[row, column] = 1
    for k, row in enumerate(loops):
        P[row, 2:4] = C[k, :]
    smaller = sp.zeros(P.cols, P.cols)
    AP = A * P
    for new, row in enumerate((*current, None, None, *rest)):
        if row is not None:
            smaller[new, :] = AP[row, :]
    smaller[2:4, 0:2] = sp.eye(2)
    smaller[2:4, 2:4] = turning
    if any(sp.expand(entry) != 0 for entry in AP[loops, :] - (P * smaller)[loops, :]):
        raise AssertionError(f"z and xi of {states} are not driven by the current error alone")
    return smaller
