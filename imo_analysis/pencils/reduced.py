"""The system matrix without the poles that no gain moves: those of z_tilde and xi_tilde, and that of the two adaptation laws.

z_tilde and xi_tilde are driven by the current error alone and turn with the frame: ``(z, xi)' = -w_s J (z, xi) + C i``. So what
is excited of them is ``(z, xi) = C y`` with ``y' = -w_s J y + i``, and with y in their place two states fewer have all poles
but a pair: zero twice at frozen speed, where the frame rests, and plus and minus j w_s in the frame of the flux.

About a steady state the laws of alpha_hat and omega_hat are driven by one and the same current error, that across the flux:
``alpha' = p i_q, omega' = q i_q``. With y_q' = i_q in place of the two a pole at zero is left out. Nothing is divided by, and a
pole that passes near one of those left out is not mixed up with it by an eigenvalue solver.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from imo_analysis.equations.own import is_file
from imo_analysis.pencils.error import poles
from imo_analysis.pencils.jacobian import Kind, jacobian

_ADAPTED = ("alpha_tilde", "omega_tilde")
_LOOPS = ("z_1_tilde", "z_2_tilde", "xi_1_tilde", "xi_2_tilde")


@dataclass(frozen=True)
class Reduced:
    """The smaller matrix.

    Attributes
    ----------
    matrix : sympy.Matrix
        In (i_tilde, y, what else there is, y_q), or the whole matrix where there is no xi.
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
    states = derived.states
    if set(_LOOPS) <= set(states):
        try:
            matrix = _smaller(matrix, states, kind)
        except (AssertionError, KeyError, ValueError):
            if not is_file(name):  # the catalogue's have this structure, an own observer need not
                raise
    ordered = {symbol.name: symbol for symbol in matrix.free_symbols}
    used = tuple(argument for argument in derived.arguments if argument in ordered)
    function = sp.lambdify([ordered[argument] for argument in used], list(matrix), modules="numpy", cse=True)
    return Reduced(matrix, used, function)


def _smaller(matrix: Any, states: tuple[str, ...], kind: Kind) -> Any:
    if kind == "full":
        matrix = _without_the_line(matrix, states)
        states = (*(state for state in states if state not in _ADAPTED), "y_q")
    return _without_the_pair(matrix, states)


def _without_the_line(A: Any, states: tuple[str, ...]) -> Any:
    """The matrix at a steady state, with y_q, the last, in place of alpha_tilde and omega_tilde."""
    names = {symbol.name: symbol for symbol in A.free_symbols}
    at_rest = {names["z_1"]: names["i_ds"] * (1 + names["L_m"] * names["beta"]), names["z_2"]: names["i_qs"]}
    A = A.xreplace(at_rest)  # phi_dr = L_m i_ds and phi_qr = 0
    laws = [states.index(state) for state in _ADAPTED]
    across = states.index("i_qs_tilde")
    drives = [sp.factor(A[row, across]) for row in laws]
    if any(sp.simplify(A[row, column]) != 0 for row in laws for column in range(A.cols) if column != across):
        raise AssertionError(f"alpha and omega of {states} are not driven by the current error across the flux alone")
    rest = [k for k in range(A.rows) if k not in laws]
    smaller = sp.zeros(len(rest) + 1, len(rest) + 1)
    smaller[:-1, :-1] = A.extract(rest, rest)
    smaller[:-1, -1] = A.extract(rest, laws) * sp.Matrix(drives)
    smaller[-1, rest.index(across)] = 1
    return smaller


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
