"""Frozen-speed poles without an eigenvalue solver, where the error dynamics commute with rotations.

Then every 2x2 block of the system matrix is ``[[x, -y], [y, x]]``, and with ``x + j y`` for each the matrix is a complex one of
half the size. Its characteristic polynomial, worked out from the derivative of the definitions, is ``s^m (s^2 + p s + q)`` for
all observers but those with the z feedback of (7): m poles stay at zero, two are found here, and the rest are their
conjugates. The z feedback of (7) does not commute: its quartic ``(s^2 + a s + d)^2 + omega^2 (s^2 - w^2)`` has no such factors.

The root of larger magnitude comes first, from the sum in which nothing cancels; the other is q over it. Each is right to
``1e-15 sqrt(1 + |p|^2 / |p^2 - 4 q|)``, relatively: 1e-15 but for near-double roots, which rounding of p and q alone
moves that far; and times what p or q loses where its own terms cancel.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from imo_analysis.pencils.jacobian import jacobian

COMPILED_FROM = 20_000  # points; below, Python is done before numba is loaded


@dataclass(frozen=True)
class ClosedForm:
    """The quadratic of one observer.

    Attributes
    ----------
    observer : str
        Its name in the catalogue.
    arguments : tuple of str
        Names of what p and q depend on.
    coefficients : tuple of sympy expressions
        Real and imaginary part of p, real and imaginary part of q.
    at_zero : int
        How many poles of the real system are zero whatever the numbers are.
    function : callable
        The coefficients as numbers; takes the arguments as floats or arrays that broadcast.
    """

    observer: str
    arguments: tuple[str, ...]
    coefficients: tuple[Any, Any, Any, Any]
    at_zero: int
    function: Any

    def poles(self, values: Mapping[str, Any]) -> np.ndarray:
        """The four poles that can move, complex, shape ``(..., 4)``: larger, smaller, and their conjugates.

        Parameters
        ----------
        values : mapping
            The arguments by name, floats or arrays that broadcast.
        """
        re_1, im_1, re_2, im_2 = pairs(self, values)
        result = np.empty((*re_1.shape, 4), dtype=complex)
        result.real[..., 0::2], result.imag[..., 0], result.imag[..., 2] = re_1[..., None], im_1, -im_1
        result.real[..., 1::2], result.imag[..., 1], result.imag[..., 3] = re_2[..., None], im_2, -im_2
        return result


@cache
def closed_form(name: str) -> ClosedForm | None:
    """The quadratic of an observer, or None where its frozen-speed polynomial does not factor into one.

    Parameters
    ----------
    name : str
        The observer, as in the catalogue.

    Raises
    ------
    InputError
        If the observer is not known.
    """
    derived = jacobian(name, "frozen")
    n = len(derived.states)
    whole = complex_matrix(derived.matrix[:n, :n])
    if whole is None:
        return None
    coefficients = [sp.expand(c) for c in whole.charpoly().all_coeffs()]
    zeros = 0
    while coefficients[-1] == 0:
        coefficients.pop()
        zeros += 1
    if len(coefficients) != 3:
        return None
    _, p, q = coefficients
    parts = tuple(sp.factor_terms(part) for c in (p, q) for part in (c.coeff(sp.I, 0), c.coeff(sp.I, 1)))
    ordered = {symbol.name: symbol for part in parts for symbol in part.free_symbols}
    used = tuple(argument for argument in derived.arguments if argument in ordered)
    function = sp.lambdify([ordered[argument] for argument in used], parts, modules="numpy", cse=True)
    return ClosedForm(name, used, parts, 2 * zeros, function)


def complex_matrix(matrix: Any) -> Any:
    """The complex matrix that a real one stands for, pair by pair; None where a block is not ``[[x, -y], [y, x]]``."""
    half = matrix.rows // 2

    def block(r: int, c: int) -> Any:
        return matrix[2 * r : 2 * r + 2, 2 * c : 2 * c + 2]

    for r in range(half):
        for c in range(half):
            b = block(r, c)
            if sp.expand(b[0, 0] - b[1, 1]) != 0 or sp.expand(b[0, 1] + b[1, 0]) != 0:
                return None
    return sp.Matrix(half, half, lambda r, c: block(r, c)[0, 0] + sp.I * block(r, c)[1, 0])


def larger_first(p_re, p_im, q_re, q_im):  # type: ignore[no-untyped-def]
    """Both roots of ``s^2 + p s + q``, real and imaginary part of the larger, then of the other. Floats; also compiled.

    ``p_re``, ``p_im``, ``q_re``, ``q_im`` are the parts of p and q.
    """
    d_re = (p_re - p_im) * (p_re + p_im) - 4 * q_re
    d_im = 2 * p_re * p_im - 4 * q_im
    long = math.sqrt(0.5 * (math.sqrt(d_re * d_re + d_im * d_im) + abs(d_re)))
    short = 0.5 * abs(d_im) / (long if long > 0 else 1.0)
    w_re = long if d_re >= 0 else short
    w_im = math.copysign(short if d_re >= 0 else long, d_im)
    half = math.copysign(0.5, p_re * w_re + p_im * w_im)
    x = -0.5 * p_re - half * w_re
    y = -0.5 * p_im - half * w_im
    size = x * x + y * y
    size = size if size > 0 else 1.0
    return x, y, (q_re * x + q_im * y) / size, (q_im * x - q_re * y) / size


def pairs(form: ClosedForm, values: Mapping[str, Any], out: np.ndarray | None = None) -> np.ndarray:
    """Real and imaginary part of the larger root, then of the other, shape ``(4, ...)``, in 1/s and rad/s.

    Parameters
    ----------
    form : ClosedForm
    values : mapping
        The arguments by name, floats or arrays that broadcast.
    out : array, optional
        Of shape (4, points), to be filled.
    """
    given = {name: np.asarray(values[name], dtype=float) for name in form.arguments}
    shape = np.broadcast_shapes(*(array.shape for array in given.values()))
    size = math.prod(shape)
    found = np.empty((4, size)) if out is None else out
    if size < COMPILED_FROM:
        parts = [np.broadcast_to(part, shape).ravel().tolist() for part in form.function(*given.values())]
        for k, coefficients in enumerate(zip(*parts, strict=True)):
            found[:, k] = larger_first(*coefficients)
    else:
        vectors = {name: np.ascontiguousarray(np.broadcast_to(array, shape)).reshape(-1)
                   for name, array in given.items() if array.ndim}
        if "omega" in vectors:  # the loop finds the direction itself
            vectors.pop("direction", None)
            given.pop("direction", None)
        fixed = [float(array) for name, array in given.items() if name not in vectors]
        _kernel(form.observer, tuple(vectors))(*vectors.values(), *fixed, *found)
    return found.reshape(4, *shape)


@cache
def _kernel(observer: str, vectors: tuple[str, ...]) -> Any:
    """The loop over points, compiled; ``vectors`` are the arguments that change from point to point."""
    from imo_analysis import compile as compiler

    form = closed_form(observer)
    assert form is not None
    told = "direction" in form.arguments and "omega" in vectors
    fixed = [name for name in form.arguments if name not in vectors and not (told and name == "direction")]
    lines = [f"        {name} = {name}_[k]" for name in vectors]
    if told:
        lines.append("        direction = -1.0 if omega < 0 else 1.0")
    roots = ", ".join(sp.pycode(part, fully_qualified_modules=False) for part in form.coefficients)
    text = "\n".join([
        '@njit(cache=True, error_model="numpy")',
        f"def run({', '.join([*(f'{name}_' for name in vectors), *fixed])}, re_1, im_1, re_2, im_2):",
        "    for k in range(re_1.size):",
        *lines,
        f"        re_1[k], im_1[k], re_2[k], im_2[k] = larger_first({roots})",
        "",
    ])
    return compiler.entry(text, {"larger_first": larger_first})
