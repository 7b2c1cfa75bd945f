"""From a name plate to a machine: parameters that reproduce the rated point, and the flux and torque of that point.

A name plate gives one steady state: voltage, current, power factor, frequency, speed and shaft power. In the inverse-Gamma form
it determines R_s (from what the stator loses; iron and stray losses are counted with it), L_M and R_R (from the current along
and across the rotor flux), once the leakage L_sgm is known. That comes from the starting current, or is taken as 0.2 of the
machine's base impedance, which is typical. Friction is left out. Such parameters reproduce the plate; a measurement beats them.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.quantity import si_value

LEAST_EFFICIENCY = 0.3  # of any motor that a drive feeds, at its rated point
TYPICAL_LEAKAGE = 0.2  # of the base impedance; catalogues of standard motors lie between 0.15 and 0.25
_UNITS = {"power": "W", "voltage": "V", "current": "A", "frequency": "Hz", "speed": "rad/s", "power_factor": "1",
          "starting_current": "1"}
_NEEDED = ("power", "voltage", "frequency", "speed")
_PARAMETERS = ("R_s", "R_r", "L_m", "L_s", "L_r", "J")  # with the plate's n_p a whole machine


@dataclass(frozen=True)
class Nameplate:
    """What is printed on a motor.

    Attributes
    ----------
    power : float
        At the shaft, in W.
    voltage, current : float
        Between lines and in a line, rms, in V and A; ``current`` is 0 where it is not given.
    frequency : float
        In Hz.
    speed : float
        Of the shaft at that power, in rad/s; text such as ``"1430 rpm"`` in files.
    power_factor : float
        At that power; 0 where it is not given.
    starting_current : float
        At standstill and full voltage, over the rated one; 0 where it is not given.
    """

    power: float
    voltage: float
    frequency: float
    speed: float
    current: float = 0.0
    power_factor: float = 0.0
    starting_current: float = 0.0

    @classmethod
    def build(cls, values: Mapping[str, Any], where: str = "nameplate") -> Nameplate:
        """Check a mapping as a file gives it.

        Parameters
        ----------
        values : mapping
            Under the names of the attributes, as numbers in SI units or as text with a unit.
        where : str
            Names the place in error texts.

        Raises
        ------
        InputError
            If something is missing, unknown or cannot be.
        """
        for name in values:
            if name not in _UNITS:
                raise InputError(f"{where}.{name} is not a known key; it has: {', '.join(_UNITS)}")
        for name in _NEEDED:
            if name not in values:
                raise InputError(f"{where}.{name} is missing; it is on the plate (in {_UNITS[name]}, or text with a unit)")
        plate = cls(**{name: si_value(value, _UNITS[name], f"{where}.{name}") for name, value in values.items()})
        for name in values:
            if getattr(plate, name) <= 0:
                raise InputError(f"{where}.{name} = {getattr(plate, name):g} {_UNITS[name]} must be above 0")
        if plate.power_factor >= 1:
            raise InputError(f"{where}.power_factor = {plate.power_factor:g} must be below 1")
        if not 0 < plate.slip < 0.2 * plate.stator_frequency:
            raise InputError(
                f"{where}.speed = {plate.speed:.4g} rad/s, {plate.speed * 30 / math.pi:.4g} rpm, must be a little (up to 20 %) "
                f"below the synchronous {plate.stator_frequency / plate.n_p * 30 / math.pi:g} rpm of {plate.n_p} pole pair(s) "
                f"at {plate.frequency:g} Hz; is it the speed at rated power, and has it its unit, as in \"1455 rpm\"?")
        return plate

    @property
    def stator_frequency(self) -> float:
        """In rad/s."""
        return 2 * math.pi * self.frequency

    @property
    def n_p(self) -> int:
        """Pole pairs: the most with which the synchronous speed is not below the rated one."""
        return max(int(self.stator_frequency / self.speed), 1)

    @property
    def slip(self) -> float:
        """Rated slip frequency in rad/s, electrical."""
        return self.stator_frequency - self.n_p * self.speed

    @property
    def torque(self) -> float:
        """Rated torque of the shaft in N m."""
        return self.power / self.speed

    @property
    def phase_voltage(self) -> float:
        """Peak value of a phase in V."""
        return self.voltage * math.sqrt(2 / 3)


def machine_of(plate: Nameplate, known: Mapping[str, Any], where: str = "nameplate") -> InductionMachine:
    """A machine that reproduces the plate.

    Parameters
    ----------
    plate : Nameplate
        With current and power factor.
    known : mapping
        What is known of the machine besides: J (kg m^2) at least; a measured R_s (ohm); B, name, source.
    where : str
        Names the place in error texts.

    Returns
    -------
    InductionMachine
        In the inverse-Gamma form, L_r = L_m: rotor flux and resistance as that form sees them.

    Raises
    ------
    InputError
        If J, current or power factor is missing, or no machine has such a plate.
    """
    for name, value in (("current", plate.current), ("power_factor", plate.power_factor)):
        if value == 0:
            raise InputError(f"{where}.{name} is missing; parameters cannot be found without it: give it, or all of [machine]")
    if "J" not in known:
        raise InputError(f"{where}: no plate has the inertia; write J in [machine], in kg m^2, of rotor and load together")
    u, i = plate.phase_voltage, math.sqrt(2) * plate.current * cmath.exp(-1j * math.acos(plate.power_factor))
    taken = 1.5 * u * i.real
    gap = plate.torque * plate.stator_frequency / plate.n_p
    if not LEAST_EFFICIENCY < plate.power / taken < 1:
        raise InputError(f"{where}.power = {plate.power:g} W at the shaft of the {taken:.4g} W that voltage, current and power "
                         f"factor give is an efficiency of {plate.power / taken:.3g}; it must be between {LEAST_EFFICIENCY:g} "
                         "and 1: check the four, and the unit of the power (\"7.5 kW\")")
    R_s = si_value(known["R_s"], "ohm", "machine.R_s") if "R_s" in known else (taken - gap) / (1.5 * abs(i) ** 2)
    if R_s <= 0:
        raise InputError(f"{where}: {plate.power:g} W at the shaft are {gap:.4g} W over the air gap, more than the {taken:.4g} "
                         "W that voltage, current and power factor give; check the four")
    crossing = taken - 1.5 * R_s * abs(i) ** 2
    if not 0.97 * gap < crossing < 1.3 * gap:
        raise InputError(f"machine.R_s = {R_s:.4g} ohm leaves {crossing:.4g} W of the plate's {taken:.4g} W for the air gap, "
                         f"where {plate.power:g} W at the shaft need {gap:.4g} W, and up to 30 % more with iron and friction; "
                         "check R_s, of one phase in star")
    base = u / abs(i)
    stator_flux = (u - R_s * i) / (1j * plate.stator_frequency)
    L_sgm = TYPICAL_LEAKAGE * base / plate.stator_frequency
    for _ in range(50):  # R_R in the starting impedance depends weakly on L_sgm
        flux = stator_flux - L_sgm * i
        along = (i * flux.conjugate() / abs(flux)).real
        across = (i * flux.conjugate() / abs(flux)).imag
        if along <= 0 or across <= 0:
            raise InputError(f"{where}: power factor {plate.power_factor:g} leaves no current for the flux; check it")
        R_R, L_M = plate.slip * abs(flux) / across, abs(flux) / along
        if plate.starting_current == 0:
            break
        whole = (base / plate.starting_current) ** 2 - (R_s + R_R) ** 2
        if whole <= 0:
            raise InputError(f"{where}.starting_current = {plate.starting_current:g} must be below {base / (R_s + R_R):.3g}, "
                             "which the resistances alone allow")
        L_sgm = math.sqrt(whole) / plate.stator_frequency
    more = {key: value for key, value in known.items() if key not in ("R_s", "n_p")}
    assumed = "starting current" if plate.starting_current else f"a leakage of {TYPICAL_LEAKAGE:g} of the base impedance"
    return InductionMachine.from_inverse_gamma(**{
        "n_p": plate.n_p, "R_s": R_s, "R_R": R_R, "L_sgm": L_sgm, "L_M": L_M,
        "source": f"estimated from its name plate, with {assumed}", **more})


def rated_flux(plate: Nameplate, machine: InductionMachine) -> tuple[float, float]:
    """``(flux, current)``: magnitude of the rotor flux in Wb and of the stator current in A, peak, at rated voltage and slip.

    Parameters
    ----------
    plate : Nameplate
    machine : InductionMachine
        The flux is as its T form sees it.
    """
    form = machine.inverse_gamma()
    rotor = form["L_M"] / (1 + 1j * plate.slip * form["L_M"] / form["R_R"])
    current = plate.phase_voltage / (form["R_s"] + 1j * plate.stator_frequency * (form["L_sgm"] + rotor))
    return abs(rotor * current) * machine.L_r / machine.L_m, abs(current)


def plated(data: dict[str, Any], where: str) -> tuple[Nameplate, InductionMachine]:
    """Name plate and machine of a file with ``[nameplate]``; what ``[machine]`` leaves out is estimated from the plate.

    Raises
    ------
    InputError
        If either cannot be used, or they contradict each other.
    """
    given = data.get("machine", {})
    if not isinstance(given, dict) or not isinstance(data["nameplate"], dict):
        raise InputError(f"{where}: machine and nameplate must be tables, [machine] and [nameplate]")
    plate = Nameplate.build(data["nameplate"], f"{where}: nameplate")
    if all(name in given for name in _PARAMETERS) or "preset" in given:
        machine = InductionMachine.build({"n_p": plate.n_p, **given} if "preset" not in given else given, f"{where}: machine")
    else:
        half = [name for name in ("R_r", "L_m", "L_s", "L_r") if name in given]
        if half:
            rest = [name for name in _PARAMETERS if name not in given]
            raise InputError(f"{where}: [machine] has {', '.join(half)} and lacks {', '.join(rest)}; give all, or leave "
                             "R_r, L_m, L_s and L_r to the plate")
        machine = machine_of(plate, given, f"{where}: nameplate")
    if machine.n_p != plate.n_p:
        raise InputError(f"{where}: machine.n_p = {machine.n_p} does not fit the plate, whose {plate.speed * 30 / math.pi:.4g} "
                         f"rpm at {plate.frequency:g} Hz need {plate.n_p}")
    return plate, machine
