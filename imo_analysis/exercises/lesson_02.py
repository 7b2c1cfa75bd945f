"""Exercises of lesson 2: sum and product of the machine's poles, its fast pole, the damping of the baseline."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations import parameters
from imo_analysis.exercises.exercise import Exercise, Formula, Number
from imo_analysis.exercises.lesson_01 import MACHINE
from imo_analysis.ledger.expression import names, number, substitute
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import machine as machine_setting
from imo_analysis.pencils.error import frozen_matrix
from imo_analysis.study import Study

NONE = {"l_1": 0.0, "l_2": 0.0, "l_3": 0.0, "l_4": 0.0}
GAINS = dict(Study.paper().observers["baseline"].gains)


def _where() -> Setting:
    gamma = parameters.current_decay(*names("R_s L_m sigma alpha beta"))
    return setting("machine_poles", "the machine at frozen speed", {"gamma": gamma}, ("sigma != 0",))


def _coefficient(row: str, state: str) -> Any:
    """How a row of (1) depends on a state: the row with the state 1 and all others 0."""
    signals = ("i_ds", "i_qs", "phi_dr", "phi_qr", "u_ds", "u_qs", "omega")
    return substitute(machine_setting().definitions[row], {name: number(int(name == state)) for name in signals})


def _sum() -> Any:
    return _coefficient("i_ds_dot", "i_ds") + _coefficient("phi_dr_dot", "phi_dr")


def _product() -> Any:
    """Of the 2x2 matrix at standstill, where it is real."""
    return (_coefficient("i_ds_dot", "i_ds") * _coefficient("phi_dr_dot", "phi_dr")
            - _coefficient("i_ds_dot", "phi_dr") * _coefficient("phi_dr_dot", "i_ds"))


def _poles(gains: dict[str, float], omega: float) -> NDArray[np.complex128]:
    return np.linalg.eigvals(frozen_matrix(MACHINE, "baseline", gains, omega))


def _damping(pick: Any) -> float:
    poles = _poles(GAINS, 100.0)
    return float(pick(-poles.real / np.abs(poles)))


EXERCISES: tuple[Exercise, ...] = (
    Formula(
        "2.1", _sum, _where,
        (("gamma + alpha", "The size is right. The poles of a damped system lie to the left: look at the sign."),
         ("-gamma", "That is the current alone; the trace has the flux's entry too."),
         ("-(R_s/sigma + alpha)", "gamma has a second term, alpha beta L_m: the rotor damps the current as well."),
         ("-2*(gamma + alpha)", "That is the trace of the 4x4 matrix: each complex pole is counted with its mirror image.")),
        "The speed does not appear: it turns the poles and leaves their damping's sum alone.",
        "The sum of the roots is the trace."),
    Formula(
        "2.2", _product, _where,
        (("alpha*gamma", "That is the diagonal alone; the coupling beta alpha times alpha L_m must be taken off."),
         ("alpha*gamma + alpha**2*beta*L_m", "A determinant: the product of the off-diagonal entries is subtracted."),
         ("R_s/sigma", "The unit must be 1/s^2: a factor alpha is lost."),
         ("(alpha*R_s/sigma)**2", "That is the determinant of the 4x4 matrix, where each pole is counted twice.")),
        "Stator and rotor resistance: both are needed for the flux to go.", "The product of the roots is the determinant."),
    Number(
        "2.3", lambda: float(_poles(NONE, 100.0).real.min()), "1/s",
        ((lambda _: float(_poles(NONE, 0.0).real.min()), "That is the fast pole at standstill."),
         (lambda _: float(_poles(NONE, 100.0).real.max()), "That is the slow one."),
         (lambda _: -(MACHINE.gamma + MACHINE.alpha), "That is the whole sum; the slow pole has a share of it."),
         (lambda s: -s, "Damped poles lie to the left: look at the sign.")),
        "", "The fastest pole is the one with the most negative real part.", tolerance=0.002),
    Number(
        "2.4", lambda: _damping(np.min), "1",
        ((lambda _: _damping(np.max), "That is the fast pair, which hardly swings; the smallest is asked for."),
         (lambda d: float(np.sqrt(1 - d * d)), "That is |Im s| / |s|, the sine where the cosine is meant."),
         (lambda d: d / float(np.sqrt(1 - d * d)), "That is Re s / Im s; divide by the magnitude.")),
        "The flux error is what swings.", "Take -Re s / |s| of all four poles, and the least of them."),
)
