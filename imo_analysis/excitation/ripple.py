"""The torque ripple that a flux modulation makes, without noise: what the drive's speed and current loops leave of it.

The drive asks for i_q = a / (mu psi), with a the acceleration that its speed loop wants and psi the flux at that moment. The
current loop C = w_i / (s + w_i) follows late, so that the acceleration that comes out, tau = mu psi i_q, ripples. With a load,
along a swing psi = psi_0 p(t) of known shape,

    tau = p C[(m + A tau) / p],    A(s) = -w_s (2 s + w_s) / s^2,    m such that the mean of tau is the load's,

A being the speed loop through the inertia. This is linear in tau and solved for all harmonics. Of a small swing delta it leaves

    tau~ / tau = (1 - C) / (1 - C A) delta.

To it comes, without load too, what holding a voltage for T does: the frame turns by omega_s T / 2 meanwhile and the couplings
fed forward are T / 2 old, so that to first order in T the axis across the flux is pushed by

    -(omega_s T / 2) (2 i_d' + (R_s / sigma) i_d + 2 beta psi')    of the swing, and i_q by s / ((s + gamma) (s + w_i)) of that,

gamma = R_s / sigma + alpha beta L_m. The two are added as if they were in phase: an upper estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.excitation.bounds import slip_at
from imo_analysis.excitation.swing import Shape
from imo_analysis.machine import InductionMachine
from imo_analysis.study_tables import Drive

Array = NDArray[np.float64]
_HELD_POINTS = 256  # of a period


def loaded_torque(drive: Drive, shape: Shape, depth: float, frequency: float) -> Array:
    """The torque over one period, over its mean, as the drive's loops let it swing under load."""
    points = max(32, 2 * (int(shape.orders.max()) + 1))
    p = 1 + depth * shape.sampled(points)
    order = np.fft.fftfreq(points, 1 / points)
    s = 1j * order * frequency
    with np.errstate(divide="ignore", invalid="ignore"):
        loop = np.where(order == 0, 0.0, -drive.speed_bandwidth * (2 * s + drive.speed_bandwidth) / (s * s))
    current = _filter(drive.current_bandwidth / (s + drive.current_bandwidth))
    follow = p[:, None] * current / p
    system = np.zeros((points + 1, points + 1))  # for tau and m
    system[:-1, :-1] = np.eye(points) - follow @ _filter(loop)
    system[:-1, -1] = -follow.sum(axis=1)
    system[-1, :-1] = 1 / points
    return np.asarray(np.linalg.solve(system, np.append(np.zeros(points), 1.0))[:-1])


def _filter(gains: NDArray[Any]) -> Array:
    """The matrix that filters a period's samples line by line."""
    spectrum = np.fft.fft(np.eye(len(gains)), axis=0)
    return np.real(np.fft.ifft(gains[:, None] * spectrum, axis=0))


def held_voltage(machine: InductionMachine, drive: Drive, flux: float, shape: Shape, depth: float, frequency: float,
                 stator_frequency: float, step: float) -> Array:
    """The torque in N m over one period that holding voltages for ``step`` seconds makes, whatever the load."""
    s = 1j * shape.orders * frequency
    psi = flux * depth * shape.amplitudes
    i_d = (s / machine.alpha + 1) * psi / machine.L_m
    pushed = -stator_frequency * step / 2 * ((2 * s + machine.R_s / machine.sigma) * i_d + 2 * machine.beta * s * psi)
    gamma = machine.R_s / machine.sigma + machine.alpha * machine.beta * machine.L_m
    i_q = pushed * s / ((s + gamma) * (s + drive.current_bandwidth))
    loops = 1 + drive.current_bandwidth / (s + drive.current_bandwidth) * drive.speed_bandwidth * (
        2 * s + drive.speed_bandwidth) / (s * s)
    torque = 1.5 * machine.n_p * machine.L_m / machine.L_r * flux * i_q / loops
    return Shape(shape.orders, np.asarray(torque, complex)).sampled(_HELD_POINTS)


def torque_ripple(machine: InductionMachine, drive: Drive, flux: float, shape: Shape, depth: float, frequency: float,
                  points: Sequence[tuple[float, float]], step: float = 1e-4) -> float:
    """Half the swing of the torque, in N m: what the load makes plus what holding the voltage makes, at the worst point.

    Parameters
    ----------
    drive : Drive
        Its current and speed bandwidths.
    flux : float
        Mean flux in Wb.
    points : sequence of (float, float)
        Speeds in rad/s with loads in N m.
    step : float
        Sampling time of the drive in s.
    """
    loaded = float(np.ptp(loaded_torque(drive, shape, depth, frequency)))
    turned = float(np.ptp(held_voltage(machine, drive, flux, shape, depth, frequency, 1.0, step)))  # per rad/s
    return max(abs(torque) * loaded + abs(omega + slip_at(machine, torque, flux)) * turned for omega, torque in points) / 2
