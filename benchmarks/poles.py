"""Contenders for the poles: the closed form against C, and batches against a loop over python-control."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks import c_code
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.pencils.closed_form import closed_form, pairs
from imo_analysis.pencils.error import OperatingPoint, arguments
from imo_analysis.pencils.jacobian import jacobian
from imo_analysis.pencils.sweep import evaluator
from imo_analysis.study import Study

STUDY = Study.paper()
NAME = "consistent_12"
GAINS = {name: STUDY.known_gains[name] for name in OBSERVERS[NAME].gains}


def ours(omega: np.ndarray, out: np.ndarray) -> np.ndarray:
    """Both roots at every speed, from machine and gains: checks, coefficients and roots."""
    form = closed_form(NAME)
    assert form is not None
    return pairs(form, arguments(jacobian(NAME), STUDY.machine, GAINS, OperatingPoint(omega, None)), out)


class InC:
    """The same in C: poles.c."""

    def __init__(self) -> None:
        machine = STUDY.machine
        numbers = (machine.R_s, machine.sigma, machine.alpha, GAINS["k_1"], GAINS["k_2"], GAINS["k_3"])
        self.numbers = np.array(numbers)
        self.library = c_code.load("poles.c")

    def __call__(self, omega: np.ndarray, out: np.ndarray) -> np.ndarray:
        """Fill ``out``, of shape (4, points)."""
        self.library.pole_pairs(ctypes.c_long(len(omega)), c_code.pointer(omega), c_code.pointer(self.numbers),
                                *(c_code.pointer(row) for row in out))
        return out


def control_loop(
    name: str, omega: np.ndarray, kind: Any = "frozen", flux: float | None = None, slip: float = 0.0
) -> np.ndarray:
    """Poles by `control.StateSpace`, one after the other; the matrices are ready, inputs and outputs as small as can be."""
    import control

    derived = jacobian(name, kind)
    matrices = derived.system_matrix(arguments(derived, STUDY.machine, GAINS, OperatingPoint(omega, flux, slip)))
    n = matrices.shape[-1]
    B, C, D = np.zeros((n, 1)), np.zeros((1, n)), np.zeros((1, 1))
    return np.array([control.StateSpace(matrix, B, C, D).poles() for matrix in matrices])


def batch(name: str, omega: np.ndarray, kind: Any = "frozen", flux: float | None = None, slip: float = 0.0) -> np.ndarray:
    """Poles by batched eigenvalues, matrices included; those at rest by structure are taken out."""
    return evaluator(STUDY.machine, name, GAINS, "omega", OperatingPoint(0.0, flux, slip), kind).moving(omega)


def lines(
    quick: bool, ratio: Callable[..., tuple[float, float, float]], row: Callable[..., dict[str, Any]]
) -> list[dict[str, Any]]:
    """The rows of the table; ``ratio`` and ``row`` are its own."""
    found = []
    points = 1_000_000 if quick else 10_000_000
    omega = np.linspace(-150.0, 150.0, points)
    mine, theirs = np.empty((4, points)), np.empty((4, points))
    if c_code.compiler():
        in_c = InC()
        value, one, other = ratio(lambda: ours(omega, mine), lambda: in_c(omega, theirs), 9 if quick else 15)
        apart = float(np.max(np.abs(mine - theirs)) / np.max(np.abs(theirs)))
        found.append(row(f"poles in closed form at {points:,} speeds / C", value, 1.5, False,
                         f"{one / points * 1e9:.3g} and {other / points * 1e9:.3g} ns a point; they differ by {apart:.0e}"))
    else:
        print("no C compiler found (CC, cc, gcc, clang): the comparison of poles with C is left out", file=sys.stderr)
    few, many = np.linspace(-150.0, 150.0, 200), np.linspace(-150.0, 150.0, 4000)
    for what, name, kind, flux in (
        ("closed form", NAME, "frozen", None),
        ("no closed form", "printed_7", "frozen", None),
        ("with adaptation", NAME, "full", STUDY.drive.flux),
    ):
        given = (name, kind, flux, 2.0)
        value, loop, _ = ratio(lambda given=given: control_loop(given[0], few, *given[1:]),
                               lambda given=given: batch(given[0], many, *given[1:]), 5 if quick else 11)
        value *= len(many) / len(few)
        found.append(row(f"python-control, poles one by one / a batch ({what})", value, 10.0, True,
                         f"{loop / len(few) * 1e9:,.0f} ns a point"))
    return found
