"""Where the observers begin: the flux that the record has at its first sample, from voltages and currents alone.

By (1), for omega_1 = 0, the rotor flux is phi = c + y, where y is known: y = (L_r/L_m) (integral of u - R_s i, less sigma times
the change of i), and c, the flux at the first sample, is not. Its rows in (1) turn with the speed, which drops out of

    d|phi|^2/dt = -2 alpha |phi|^2 + 2 alpha L_m Re(conj(phi) i).

With F for the low pass 2 alpha L_m / (s + 2 alpha) and |c|^2 taken for an unknown of its own this is linear,

    c . (2 y - F i) + |c|^2 (1 - exp(-2 alpha t)) = F (y . i) - |y|^2,

and three unknowns follow by least squares over the first turn of the flux, whatever speed and load do meanwhile.

A wrong c stays: z and xi are integrals of voltages, and the adaptive observers conserve a combination of their errors. The flux
that they reconstruct gets rid of it, but alpha_hat has moved by then, with omega_hat, along the direction that a constant flux
does not tell apart; the baseline and the Luenberger observers with known alpha forget their start.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from imo_analysis import compile as compiler
from imo_analysis.machine import InductionMachine
from imo_analysis.replay.check import LEAK
from imo_analysis.replay.logs import Samples

_NO_CURRENT = 0.05  # of the largest: a record that begins with less has no flux yet
_REST = 0.2  # s; the mean current of a machine at rest is taken over it
_SPEED = 0.01  # s, over which the first speed is taken
_CHORD = 0.1  # of the extent of the flux's path: its turning is seen on pieces as long as this, ...
_LEAST_CHORD = 0.02  # ... and this part of L_s |i|: the integral of noise alone turns at random
_LEAST_TURN = 1.0  # rad


@dataclass(frozen=True)
class Start:
    """Estimates at the first sample.

    Attributes
    ----------
    values : dict of str to float
        By state; empty for a machine at rest without flux.
    how : str
        In words, for people.
    guessed : bool
        Whether the flux was estimated or guessed, and so may be wrong.
    """

    values: dict[str, float]
    how: str
    guessed: bool = True


def flying_start(head: Samples, T: float, machine: InductionMachine, voltage: str = "linear") -> Start:
    """Estimates to begin with.

    A record that begins without current has no flux yet. One in which nothing turns is taken for a machine at rest, magnetised
    by its current. In any other the flux is found by the least squares of this module.

    Parameters
    ----------
    head : Samples
        The first samples of the record.
    T : float
        Sampling period in s.
    machine : InductionMachine
        As the observers believe it to be.
    voltage : str
        What a sample of it stands for, see `imo_analysis.replay.estimate.Treatment`.
    """
    u, i = head.u_ds + 1j * head.u_qs, head.i_ds + 1j * head.i_qs
    between = {"linear": (u[1:] + u[:-1]) / 2, "held": u[:-1], "averaged": u[1:]}[voltage]
    stator = np.concatenate([[0.0], np.cumsum(T * (between - machine.R_s * (i[1:] + i[:-1]) / 2))])
    count, turn = _first_turn(stator, _LEAST_CHORD * machine.L_s * math.sqrt(float((np.abs(i) ** 2).mean())))
    if abs(i[0]) <= _NO_CURRENT * float(np.abs(i[:count]).max()):
        return Start({}, "begun at standstill without flux, since the record begins without current", guessed=False)
    if abs(turn) < _LEAST_TURN:
        rest = complex(i[: max(1, round(_REST / T))].mean())
        return Start(_states(complex(i[0]), machine.L_m * rest, 0.0, machine),
                     f"begun at rest with the flux L_m i = {abs(machine.L_m * rest):.3g} Wb: nothing turns in the first "
                     f"{len(head) * T:.3g} s, so that this is a guess")
    i = i[:count]
    y = (stator[:count] - machine.sigma * (i - i[0])) * machine.L_r / machine.L_m
    c = _first_flux(y, i, T, machine)
    phi = c + y
    near = slice(0, max(2, min(count, round(_SPEED / T))))
    size = float((np.abs(phi[near]) ** 2).sum())
    if not (math.isfinite(size) and size > 0):
        return Start({}, "begun at standstill without flux, since none can be made out")
    torque = float((phi[near].conj() * i[near]).imag.sum())
    frequency = float(np.polyfit(T * np.arange(len(phi[near])), np.unwrap(np.angle(phi[near])), 1)[0])
    omega = frequency - machine.alpha * machine.L_m * torque / size
    return Start(_states(complex(i[0]), c, omega, machine),
                 f"begun on the fly at omega_hat = {omega:.4g} rad/s with a flux of {abs(c):.3g} Wb, by least squares over the "
                 f"first {count * T:.3g} s, in which it turns by {math.degrees(abs(turn)):.0f} degrees")


def _states(i: complex, phi: complex, omega: float, machine: InductionMachine) -> dict[str, float]:
    z = i + machine.beta * phi
    return {"phi_dr_hat": phi.real, "phi_qr_hat": phi.imag, "z_1_hat": z.real, "z_2_hat": z.imag,
            "xi_1_hat": z.real, "xi_2_hat": z.imag, "omega_hat": omega}


def _first_turn(path: np.ndarray, least: float) -> tuple[int, float]:
    """``(count, angle)``: samples until the path has turned once, or all of them, and by how much it has turned then in rad."""
    chord = max(_CHORD * float(np.abs(path).max()), least)
    last, before, turn = complex(path[0]), 0j, 0.0
    if chord > 0:
        for k, point in enumerate(path):
            step = complex(point) - last
            if abs(step) >= chord:
                turn += cmath.phase(step * before.conjugate()) if before else 0.0
                before, last = step, complex(point)
                if abs(turn) >= 2 * math.pi:
                    return k + 1, turn
    return len(path), turn


def _first_flux(y: np.ndarray, i: np.ndarray, T: float, machine: InductionMachine) -> complex:
    rate = 2 * machine.alpha
    keep = math.exp(-rate * T)

    def low_passed(x: np.ndarray) -> np.ndarray:
        out = np.empty(len(x), dtype=complex)
        compiler.entry(LEAK, {})(rate * machine.L_m * T / 2 * (x[1:] + keep * x[:-1]), keep, out)
        return out

    slow = low_passed(i)
    fading = 1 - np.exp(-rate * T * np.arange(len(y)))
    sides = np.column_stack([2 * y.real - slow.real, 2 * y.imag - slow.imag, fading])
    known = low_passed((y * i.conj()).real + 0j).real - np.abs(y) ** 2
    scale = np.linalg.norm(sides, axis=0)
    scale[scale == 0] = 1.0
    found, *_ = np.linalg.lstsq(sides / scale, known, rcond=1e-9)
    return complex(found[0] / scale[0], found[1] / scale[1])
