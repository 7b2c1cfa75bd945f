"""A periodic swing of the rotor flux: its shape as the drive makes it, and what it costs in current, voltage and copper loss.

The flux is psi (1 + depth shape(frequency t)), the torque held: the slip is that of the mean flux times (psi_0 / psi)^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.steady_state import current_of_flux
from imo_analysis.excitation.bounds import slip_at
from imo_analysis.machine import InductionMachine
from imo_analysis.simulation.waveforms import TOP, lines
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
    edge : float
        By how much the second derivative by the angle is more just after an angle of 0, and less half a turn later, than the
        sum of the lines: half its jump, and the lines left out.
    """

    orders: NDArray[np.int64]
    amplitudes: NDArray[np.complex128]
    reference: float = 1.0
    edge: float = 0.0

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


_MANY = 40_001  # lines of what an edge asks of the voltage
COSINE = Shape(np.array([1]), np.array([0.5 + 0j]))


def shape_of(waveform: str, frequency: float, drive: Drive, alpha: float) -> Shape:
    """What the drive makes of a waveform of the flux reference: its flux loop acting through its current loop.

    Line n is passed with w / ((s + alpha) (1 + s / w_i) + w - alpha) at s = j n frequency, w and w_i the bandwidths of the
    flux and the current loop: as long as no limit is hit. At the edges of a square, which lines sum up too slowly, the second
    derivative of the flux jumps by 2 w w_i.
    """
    def followed(top: int) -> Shape:
        orders, amplitudes = lines(waveform, top)
        s = 1j * orders * frequency
        passed = drive.flux_bandwidth / ((s + alpha) * (1 + s / drive.current_bandwidth) + drive.flux_bandwidth - alpha)
        return Shape(orders, amplitudes * passed)

    kept = followed(TOP)
    edge = 0.0
    if waveform == "square":
        at_edge = [one.sampled(1, 2)[0] for one in (kept, followed(_MANY))]
        edge = at_edge[1] - at_edge[0] + drive.flux_bandwidth * drive.current_bandwidth / frequency**2
    peak = float(np.abs(kept.sampled()).max())
    return Shape(kept.orders, kept.amplitudes / peak, 1 / peak, float(edge) / peak)


def costs(
    machine: InductionMachine, flux: float, depth: float, frequency: float, omega: float, torque: float, shape: Shape = COSINE
) -> tuple[float, float, float]:
    """``(peak current, peak voltage, added copper loss)`` in A, V and W at held torque, over one period."""
    psi = flux * (1 + depth * shape.sampled())
    rate = flux * depth * frequency * shape.sampled(derivative=1)
    bend = shape.sampled(derivative=2)
    bend[[0, len(bend) // 2]] += shape.edge, -shape.edge
    bend *= flux * depth * frequency**2
    slip = slip_at(machine, torque, flux) * (flux / psi) ** 2
    i_d, i_q = current_of_flux(psi, rate, slip, machine.alpha, machine.L_m)
    current = i_d + 1j * i_q
    turn = 1j * (omega + slip)
    moving = current_of_flux(rate, bend, 0.0, machine.alpha, machine.L_m)[0] - 1j * i_q * rate / psi  # slip goes with psi^-2
    change = moving + turn * current + machine.beta * (rate + turn * psi)
    voltage = machine.sigma * change + machine.R_s * current
    rotor = (psi - machine.L_m * current) / machine.L_r
    steady = current_of_flux(flux, 0.0, slip_at(machine, torque, flux), machine.alpha, machine.L_m)
    still = steady[0] + 1j * steady[1]
    still_rotor = (flux - machine.L_m * still) / machine.L_r

    def loss(stator: Any, in_rotor: Any) -> float:
        return float(1.5 * np.mean(machine.R_s * np.abs(stator) ** 2 + machine.R_r * np.abs(in_rotor) ** 2))

    added = loss(current, rotor) - loss(still, still_rotor)
    return float(np.abs(current).max()), float(np.abs(voltage).max()), added
