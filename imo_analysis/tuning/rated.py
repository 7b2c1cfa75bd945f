"""The rated point of a motor, which its own study is made for: from the name plate, or what is typical of such a machine.

Without a plate, standard four-pole motors tell what is likely: the power at 50 Hz grows as J^0.83 and the magnetising
reactance per unit as the power^0.2. Inertia and inductance then give the flux, and flux and inductance give the power. That is
within a fifth of the rated flux and torque of the presets (tests hold it to that); a name plate knows better.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

from imo_analysis.equations.steady_state import slip_of_torque
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.nameplate import Nameplate, rated_flux

_RESERVE = 0.1  # of voltage at rated speed, left for control: less flux than rated, or more voltage than the point takes
_NETWORK = 100 * math.pi  # rad/s
_POWER, _REACTANCE, _INERTIA = 2200.0, 1.8, 0.015  # W, per unit, kg m^2: a small standard motor


@dataclass(frozen=True)
class Rated:
    """What a drive for this motor is sized by.

    Attributes
    ----------
    omega, slip : float
        Speed and slip at rated load in rad/s, electrical.
    torque : float
        In N m.
    flux : float
        Rotor flux that the drive keeps, in Wb.
    current, voltage : float
        Of the rated point and the most there is, in A and V, peak of a phase.
    source : str
        Where this comes from, for people.
    """

    omega: float
    slip: float
    torque: float
    flux: float
    current: float
    voltage: float
    source: str

    @classmethod
    def of_plate(cls, plate: Nameplate, machine: InductionMachine) -> Self:
        """What the plate says.

        Parameters
        ----------
        plate : Nameplate
        machine : InductionMachine
        """
        flux, current = rated_flux(plate, machine)
        return cls(plate.n_p * plate.speed, plate.slip, plate.torque, (1 - _RESERVE) * flux, current, plate.phase_voltage,
                   f"by the name plate; flux {100 * _RESERVE:g} % lower, so that voltage is left for control")

    @classmethod
    def typical(cls, machine: InductionMachine, flux: float | None = None) -> Self:
        """What is likely, at 50 Hz.

        Parameters
        ----------
        machine : InductionMachine
        flux : float, optional
            Magnitude of the rotor flux in Wb; `typical_flux` where left out.

        Raises
        ------
        InputError
            If the flux is not one, or no motor with this inductance is run with it.
        """
        known = "typical of such an inductance and inertia, at 50 Hz" if flux is None else (
            "typical of such an inductance and the flux given, at 50 Hz")
        flux = typical_flux(machine) if flux is None else flux
        if not (math.isfinite(flux) and flux > 0):
            raise InputError(f"flux = {flux:g} Wb must be above 0 Wb")
        # power / reactance = flux^2 omega / L_s, the reactance growing as the power^0.2
        power = _POWER * (flux * flux * _NETWORK / machine.L_s * _REACTANCE / _POWER) ** (1 / 0.8)
        torque = power * machine.n_p / _NETWORK
        slip = float(slip_of_torque(torque, flux, machine.n_p, machine.L_r, machine.alpha))
        if slip > 0.2 * _NETWORK:
            raise InputError(f"flux = {flux:.3g} Wb gives this machine a rated torque of about {torque:.3g} N m and a slip of "
                             f"{slip:.3g} rad/s, more than a motor has; check the parameters, or give its [nameplate]")
        i_d, i_q = flux / machine.L_m, slip / machine.alpha * flux / machine.L_m
        behind_leakage = complex(machine.sigma * i_d + machine.L_m / machine.L_r * flux, machine.sigma * i_q)
        voltage = abs(machine.R_s * complex(i_d, i_q) + 1j * _NETWORK * behind_leakage)
        return cls(_NETWORK - slip, slip, torque, flux, math.hypot(i_d, i_q), (1 + _RESERVE) * voltage,
                   f"{known}; a [nameplate] would know. {100 * _RESERVE:g} % more voltage than that takes")


def typical_flux(machine: InductionMachine) -> float:
    """Rated rotor flux in Wb of a standard motor with this inductance and inertia; see the head of this file."""
    power = _POWER * (machine.J / _INERTIA) ** 0.83
    reactance = _REACTANCE * (power / _POWER) ** 0.2
    return math.sqrt(power * machine.L_s / (reactance * _NETWORK))
