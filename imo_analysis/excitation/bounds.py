"""How well alpha, omega and R_s can be known: the Cramer-Rao bound, line by line of the rotor flux's spectrum.

The voltage is known, the current is measured with white noise, the speed is constant, and the time is long against the
machine's transients. A line c exp(j nu t) of the rotor flux then answers to an error of a parameter with the line

    H(j nu) f,   H(s) = s / (s^2 + (R_s/sigma + alpha (1 + beta L_m) - j omega) s + (alpha - j omega) R_s/sigma),

in the measured current (claim ``excitation.response``); H is (6) solved for the current, f the forcing by that parameter:

    alpha:  -j beta c (nu - omega) / alpha
    omega:  -j beta c
    R_s:    -(i / sigma) (1 + (alpha - j omega) / (j nu)),   i = c (alpha + j (nu - omega)) / (alpha L_m).

So one line tells only alpha_tilde (nu - omega) / alpha + omega_tilde: with constant flux there is one line, and alpha and
omega cannot be told apart. H(0) = 0: a line at zero frequency tells nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.steady_state import answer_of_line, forcing_of_line, slip_of_torque
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine

PARAMETERS = ("alpha", "omega", "R_s")


@dataclass(frozen=True)
class Measurement:
    """What is measured, and for how long.

    Attributes
    ----------
    noise : float
        Standard deviation of each current sample and axis, in A.
    rate : float
        Samples per second.
    duration : float
        Time in s.
    """

    noise: float = 0.1
    rate: float = 10_000.0
    duration: float = 1.0

    @property
    def weight(self) -> float:
        """Samples over the noise's variance, in 1/A^2."""
        return self.rate * self.duration / (self.noise * self.noise)


@dataclass(frozen=True)
class Motion:
    """A periodic motion: constant speed and the lines of the rotor flux.

    Attributes
    ----------
    omega : float
        Electrical speed in rad/s.
    frequencies : array of shape (n,)
        Angular frequencies of the flux's lines in the stationary frame, in rad/s.
    amplitudes : complex array of shape (n,)
        Their amplitudes in Wb.
    """

    omega: float
    frequencies: NDArray[np.float64]
    amplitudes: NDArray[np.complex128]


def modulated(flux: float, omega: float, slip: float, depth: float = 0.0, frequency: float = 0.0) -> Motion:
    """The motion psi = flux (1 + depth cos(frequency t)) at constant speed and slip: three lines, or one."""
    if depth == 0 or frequency == 0:
        return Motion(omega, np.array([omega + slip]), np.array([flux * (1 + depth)], dtype=complex))
    stator = omega + slip
    return Motion(omega, np.array([stator, stator + frequency, stator - frequency]),
                  np.array([flux, flux * depth / 2, flux * depth / 2], dtype=complex))


def held_torque(flux: float, omega: float, slip: float, depth: float, frequency: float, points: int = 64) -> Motion:
    """The same at constant torque: the slip is ``slip`` (flux / psi)^2, so that the flux turns unevenly.

    The lines are those of psi exp(j theta) over one period of the modulation, by a discrete Fourier transform of ``points``.
    """
    if depth == 0 or frequency == 0:
        return modulated(flux, omega, slip / (1 + depth) ** 2, depth, 0.0)
    angle = 2 * np.pi * np.arange(points) / points
    return held_torque_along(1 + depth * np.cos(angle), flux, omega, slip, frequency)


def held_torque_along(psi: NDArray[np.float64], flux: float, omega: float, slip: float, frequency: float) -> Motion:
    """`held_torque` for a flux of any shape: ``psi`` is its magnitude over ``flux``, evenly sampled over one period."""
    points = len(psi)
    rate = np.fft.fft(slip / psi**2) / points
    mean = rate[0].real
    order = np.fft.fftfreq(points, 1 / points)
    with np.errstate(divide="ignore", invalid="ignore"):
        swing = np.where(order != 0, rate / (1j * order * frequency), 0.0)
    theta = np.real(np.fft.ifft(swing) * points)
    lines = np.fft.fft(flux * psi * np.exp(1j * theta)) / points
    strong = np.abs(lines) > 1e-12 * np.abs(lines).max()
    return Motion(omega, omega + mean + order[strong] * frequency, lines[strong])


def responses(machine: InductionMachine, motion: Motion, unknown: Sequence[str]) -> NDArray[np.complex128]:
    """Lines of the current's answer to each unknown, in A per unit of it; shape (unknowns, lines)."""
    alpha, beta, L_m, sigma = machine.alpha, machine.beta, machine.L_m, machine.sigma
    nu, c, omega = motion.frequencies, motion.amplitudes, motion.omega
    real, imaginary = answer_of_line(nu, omega, alpha, machine.R_s / sigma, beta, L_m)
    forcing = dict(zip(PARAMETERS, forcing_of_line(nu, omega, alpha, beta, L_m, sigma), strict=True))
    return np.array([c * (forcing[name][0] + 1j * forcing[name][1]) / (real + 1j * imaginary) for name in unknown])


def information(
    machine: InductionMachine, motion: Motion, measurement: Measurement, unknown: Sequence[str] = ("alpha", "omega")
) -> NDArray[np.float64]:
    """Fisher information of the unknowns, in one over the product of their units.

    Raises
    ------
    InputError
        If an unknown is not in `PARAMETERS` or the measurement is not positive.
    """
    wrong = [name for name in unknown if name not in PARAMETERS]
    if wrong:
        raise InputError(f"unknown = {', '.join(wrong)} must be among: {', '.join(PARAMETERS)}")
    if not (measurement.noise > 0 and measurement.rate > 0 and measurement.duration > 0):
        raise InputError("noise, rate and duration of the measurement must be above 0")
    lines = responses(machine, _merged(motion), unknown)
    return measurement.weight * np.real(np.conj(lines) @ lines.T)


def _merged(motion: Motion) -> Motion:
    """Lines at the same frequency added, for they cannot be told apart."""
    frequencies, where = np.unique(np.round(motion.frequencies, 9), return_inverse=True)
    amplitudes = np.zeros(len(frequencies), dtype=complex)
    np.add.at(amplitudes, where, motion.amplitudes)
    return Motion(motion.omega, frequencies, amplitudes)


def deviations(
    machine: InductionMachine, motion: Motion, measurement: Measurement, unknown: Sequence[str] = ("alpha", "omega")
) -> dict[str, float]:
    """Smallest standard deviation that an unbiased estimate of each unknown can have; infinity where there is none.

    A combination counts as unknowable when its share of the scaled information is below 1e-12.
    """
    matrix = information(machine, motion, measurement, unknown)
    size = np.sqrt(np.diag(matrix))
    if not (size > 0).all():
        known = [k for k in range(len(unknown)) if size[k] > 0]
        rest = deviations(machine, motion, measurement, [unknown[k] for k in known]) if known else {}
        return {name: rest.get(name, math.inf) for name in unknown}
    values, vectors = np.linalg.eigh(matrix / np.outer(size, size))
    lost = values < 1e-12
    variance = (vectors[:, ~lost] ** 2 / values[~lost]).sum(axis=1)
    touched = (vectors[:, lost] ** 2).sum(axis=1) > 1e-12
    return {name: math.inf if touched[k] else math.sqrt(variance[k]) / size[k] for k, name in enumerate(unknown)}


def bounds_over_speed(
    machine: InductionMachine, motion: Motion, speeds: NDArray[np.float64], measurement: Measurement
) -> dict[str, NDArray[np.float64]]:
    """The bounds of `deviations` for one motion of the flux past the rotor, at many speeds at once.

    Parameters
    ----------
    machine : InductionMachine
        The machine.
    measurement : Measurement
        Sampling, noise and length of the record.
    motion : Motion
        At omega = 0, with lines of different frequencies.
    speeds : array of shape (n,)
        In rad/s.

    Returns
    -------
    dict of arrays of shape (n,)
        ``alpha_alone``, ``omega_alone``: the other one known; ``alpha_both``, ``omega_both``: neither known.
    """
    turned = Motion(speeds[:, None], speeds[:, None] + motion.frequencies, motion.amplitudes)  # type: ignore[arg-type]
    lines = responses(machine, turned, ("alpha", "omega"))
    aa, ww, aw = (measurement.weight * np.real(np.conj(lines[j]) * lines[k]).sum(axis=1) for j, k in ((0, 0), (1, 1), (0, 1)))
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = 1 - (aw / np.sqrt(aa * ww)) ** 2  # 0 where the two act alike
        known = np.nan_to_num(apart, nan=0.0) > 1e-12
        alone = {"alpha": 1 / np.sqrt(aa), "omega": 1 / np.sqrt(ww)}
        # where alpha does nothing (no load) omega is still known; where neither does, nothing is
        return {
            "alpha_alone": alone["alpha"], "omega_alone": alone["omega"],
            "alpha_both": np.where(known, alone["alpha"] / np.sqrt(np.where(known, apart, 1)), np.inf),
            "omega_both": np.where(known, alone["omega"] / np.sqrt(np.where(known, apart, 1)),
                                   np.where(aa == 0, alone["omega"], np.inf)),
        }


def slip_at(machine: InductionMachine, torque: float, flux: float) -> float:
    """Slip in rad/s at a torque in N m and a constant rotor flux in Wb."""
    return float(slip_of_torque(torque, flux, machine.n_p, machine.L_r, machine.alpha))
