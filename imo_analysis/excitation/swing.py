"""A periodic swing of the rotor flux: its shape as the drive makes it, and what it costs in current, voltage and copper loss.

The flux is psi (1 + depth shape(frequency t)), the torque held: the slip is that of the mean flux times (psi_0 / psi)^2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.steady_state import current_of_flux
from imo_analysis.excitation.bounds import slip_at
from imo_analysis.machine import InductionMachine
from imo_analysis.simulation.waveforms import lines
from imo_analysis.study_tables import Drive


@dataclass(frozen=True, eq=False)
class Shape:
    """A periodic swing of the flux with a peak of 1, as the sum of c_n exp(j n angle) and the conjugates.

    Attributes
    ----------
    orders, amplitudes : array of shape (lines,)
        n and c_n.
    reference : float
        Peak of the flux reference that makes it.
    """

    orders: NDArray[np.int64]
    amplitudes: NDArray[np.complex128]
    reference: float = 1.0

    @cached_property
    def swing(self) -> NDArray[np.float64]:
        """The swing at 256 points of a period."""
        return self.sampled(256)

    @cached_property
    def mean_square_rate(self) -> float:
        """Mean square of the derivative of the swing by the angle."""
        return float(2 * (np.abs(self.amplitudes) ** 2 * self.orders**2).sum())

    def sampled(self, points: int = 512, derivative: int = 0) -> NDArray[np.float64]:
        """The swing, or its derivative by the angle, evenly over a period."""
        spectrum = np.zeros(points, dtype=complex)
        np.add.at(spectrum, self.orders % points, self.amplitudes * (1j * self.orders) ** derivative)
        values: NDArray[np.float64] = 2 * points * np.real(np.fft.ifft(spectrum))
        return values


COSINE = Shape(np.array([1]), np.array([0.5 + 0j]))


def shape_of(waveform: str, frequency: float, drive: Drive, alpha: float) -> Shape:
    """What the drive makes of a waveform of the flux reference: its flux loop acting through its current loop.

    Line n is passed with w / ((s + alpha) (1 + s / w_i) + w - alpha) at s = j n frequency, w and w_i the bandwidths of the
    flux and the current loop: as long as no limit is hit.
    """
    orders, amplitudes = lines(waveform)
    s = 1j * orders * frequency
    passed = drive.flux_bandwidth / ((s + alpha) * (1 + s / drive.current_bandwidth) + drive.flux_bandwidth - alpha)
    followed = Shape(orders, amplitudes * passed)
    peak = float(np.abs(followed.sampled()).max())
    return Shape(orders, followed.amplitudes / peak, 1 / peak)


def costs(
    machine: InductionMachine, flux: float, depth: float, frequency: float, omega: float, torque: float, shape: Shape = COSINE
) -> tuple[float, float, float]:
    """``(peak current, peak voltage, added copper loss)`` in A, V and W at held torque, over one period."""
    t = 2 * math.pi / frequency * np.arange(512) / 512
    psi = flux * (1 + depth * shape.sampled())
    rate = flux * depth * frequency * shape.sampled(derivative=1)
    slip = slip_at(machine, torque, flux) * (flux / psi) ** 2
    i_d, i_q = current_of_flux(psi, rate, slip, machine.alpha, machine.L_m)
    current = i_d + 1j * i_q
    turn = 1j * (omega + slip)
    change = np.gradient(current, t, edge_order=2) + turn * current + machine.beta * (rate + turn * psi)
    voltage = machine.sigma * change + machine.R_s * current
    rotor = (psi - machine.L_m * current) / machine.L_r
    steady = current_of_flux(flux, 0.0, slip_at(machine, torque, flux), machine.alpha, machine.L_m)
    still = steady[0] + 1j * steady[1]
    still_rotor = (flux - machine.L_m * still) / machine.L_r

    def loss(stator: Any, in_rotor: Any) -> float:
        return float(1.5 * np.mean(machine.R_s * np.abs(stator) ** 2 + machine.R_r * np.abs(in_rotor) ** 2))

    added = loss(current, rotor) - loss(still, still_rotor)
    return float(np.abs(current).max()), float(np.abs(voltage).max()), added
