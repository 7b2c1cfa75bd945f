"""From a name plate to a machine: parameters that reproduce the rated point, and the flux and torque of that point.

A name plate gives one steady state: voltage, current, power factor, frequency, speed and shaft power. In the inverse-Gamma form
it determines R_s (from what the stator loses; iron and stray losses are counted with it), L_M and R_R (from the current along
and across the rotor flux), once the leakage L_sgm is known. That comes from the starting current, or is taken as 0.2 of the
machine's base impedance, which is typical. Friction is left out. Such parameters reproduce the plate; a measurement beats them.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from imo_analysis.efficiency import LEAST_CLASSED, NEVER, UNUSUAL, efficiency_at
from imo_analysis.errors import InputError, unknown_key
from imo_analysis.machine import InductionMachine
from imo_analysis.quantity import accepted, si_value, with_unit

TYPICAL_LEAKAGE = 0.2  # of the base impedance; catalogues of standard motors lie between 0.15 and 0.25
LEAST_LEAKAGE = 0.05  # of it, too: what saturation at the starting current leaves at least
ROUNDING = 0.01  # of the power that voltage, current and power factor give: plates have two or three digits of each
# Of what the stator loses, iron, stray and friction losses with it, the copper's part at least. Assumed: it goes with size and
# make; the 2.2 kW motor of the presets, measured, has 0.6.
COPPER_SHARE = 0.5
_CONTRADICTION = 0.03  # of the power taken; a plate's own digits explain half of it
# Of it, too: IEC 60034-1 leaves the power factor up to 0.07 and the losses 15 %, about an eighth together; digits add to that.
_IMPOSSIBLE = 0.2
_UNITS = {"power": "W", "voltage": "V", "current": "A", "frequency": "Hz", "speed": "rad/s", "power_factor": "1",
          "efficiency": "1", "starting_current": "1"}
_NEEDED = ("power", "voltage", "frequency", "speed")
_PARAMETERS = ("R_s", "R_r", "L_m", "L_s", "L_r", "J")  # with the plate's n_p a whole machine
_ALSO = {"cosphi": "power_factor", "cos": "power_factor", "pf": "power_factor", "eta": "efficiency", "eff": "efficiency",
         "n": "speed", "rpm": "speed", "u": "voltage", "v": "voltage", "i": "current", "amps": "current", "f": "frequency",
         "hz": "frequency", "p": "power", "kw": "power"}
CONNECTIONS = ("star", "delta")
GUESSED = "R_s too is estimated from the plate"  # in the source of a machine, which its study carries, with the range of R_s
_RANGE = re.compile(rf"{GUESSED}, between (\S+) and (\S+) Ω")
_BOTH = re.compile(r"\s*(\d+\.?\d*)\s*/\s*(\d+\.?\d*)\s*([A-Za-z]+)\s*$")


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
    efficiency : float
        At that power; 0 where it is not given. It stands in for a current or a power factor that the plate does not have.
    starting_current : float
        At standstill and full voltage, over the rated one; 0 where it is not given.
    connection : str
        ``star`` or ``delta``, where it chose from values for both, such as ``"400/690 V"`` with ``"15.2/8.8 A"``; else empty.
        Between lines and in a line a machine is the same in either: parameters are those of the equivalent star.
    """

    power: float
    voltage: float
    frequency: float
    speed: float
    current: float = 0.0
    power_factor: float = 0.0
    efficiency: float = 0.0
    starting_current: float = 0.0
    connection: str = ""

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
        unknown = [unknown_key(where, name, (*_UNITS, "connection"), _ALSO) for name in values
                   if name not in _UNITS and name != "connection"]
        if unknown:
            raise InputError(f"{'; '.join(unknown)}; a plate has: {', '.join(_UNITS)}, connection")
        for name in _NEEDED:
            if name not in values:
                raise InputError(f"{where}.{name} is missing; it is on the plate (in {accepted(_UNITS[name])})")
        values, connection = _of_connection(values, where)
        plate = cls(**{name: si_value(value, _UNITS[name], f"{where}.{name}") for name, value in values.items()},
                    connection=connection)
        for name in values:
            if getattr(plate, name) <= 0:
                raise InputError(f"{where}.{name} = {with_unit(getattr(plate, name), _UNITS[name])} must be above 0")
        for name in ("power_factor", "efficiency"):
            if getattr(plate, name) >= 1:
                raise InputError(f'{where}.{name} = {getattr(plate, name):g} must be below 1, as in 0.84 or "84 %"')
        if not plate._turns():
            meant = replace(plate, speed=plate.speed * math.pi / 30)
            bare = isinstance(values["speed"], int | float)  # a number without its unit is in rad/s
            hint = (f'did you mean "{plate.speed:g} rpm"?' if bare and meant._turns()
                    else 'is it the speed at rated power, and has it its unit, as in "1455 rpm"?')
            raise InputError(
                f"{where}.speed = {plate.speed:.4g} rad/s, {plate.speed * 30 / math.pi:.4g} rpm, must be a little (up to 20 %) "
                f"below the synchronous {plate.stator_frequency / plate.n_p * 30 / math.pi:g} rpm of {plate.n_p} pole pair(s) "
                f"at {plate.frequency:g} Hz; {hint}")
        return plate._completed(where)

    def _turns(self) -> bool:
        return 0 < self.slip < 0.2 * self.stator_frequency

    def _completed(self, where: str) -> Nameplate:
        """With the current or the power factor that the efficiency tells, where the plate lacks one of them."""
        if not self.efficiency:
            return self
        self._check_efficiency(where)
        apparent = math.sqrt(3) * self.voltage
        if self.power_factor and not self.current:
            return replace(self, current=self.power / (self.efficiency * apparent * self.power_factor))
        if self.current and not self.power_factor:
            found = self.power / (self.efficiency * apparent * self.current)
            if found >= 1:
                raise InputError(f"{where}.efficiency = {self.efficiency:g} makes a power factor of {found:.3g} with power, "
                                 "voltage and current; it must be below 1: check the four")
            return replace(self, power_factor=found)
        return self

    def _check_efficiency(self, where: str) -> None:
        """Refuse one that no motor of this plate can have."""
        given = f"{where}.efficiency = {100 * self.efficiency:.3g} %"
        most, least = self.power / self.gap, efficiency_at(NEVER, self.power)
        if self.efficiency >= most:
            raise InputError(f"{given} must be below {100 * most:.3g} %, for the slip alone takes the rest, {self.slip:.3g} of "
                             f"{self.stator_frequency:.4g} rad/s; check efficiency and speed")
        implied = self.power / self.taken if self.taken else self.efficiency
        if abs(self.efficiency / implied - 1) > _IMPOSSIBLE:
            raise InputError(f"{given} contradicts voltage, current and power factor, with which {self.power:g} W at the shaft "
                             f"are {100 * implied:.3g} %; a plate's digits and tolerances explain {100 * _IMPOSSIBLE:g} % at "
                             "most: check the five, or leave the efficiency out")
        if self.efficiency < least:
            raise InputError(f"{given} must be above {100 * least:.3g} %: no motor of {self.power:g} W loses more at its rated "
                             "point; check efficiency and power, or give current and power factor instead")

    @property
    def taken(self) -> float:
        """Power in W that voltage, current and power factor give."""
        return math.sqrt(3) * self.voltage * self.current * self.power_factor

    @property
    def gap(self) -> float:
        """Power over the air gap in W, friction left out: what the shaft gives and the slip takes."""
        return self.torque * self.stator_frequency / self.n_p

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
            raise InputError(f"{where}.{name} is missing; parameters cannot be found without it: give it, the "
                             "plate's efficiency in its place, or all of [machine]")
    if "J" not in known:
        raise InputError(f"{where}: no plate has the inertia; write J in [machine], in kg m^2, of rotor and load together")
    u, i = plate.phase_voltage, math.sqrt(2) * plate.current * cmath.exp(-1j * math.acos(plate.power_factor))
    taken, gap, least = plate.taken, plate.gap, efficiency_at(NEVER, plate.power)
    if not least < plate.power / taken < 1:
        raise InputError(f"{where}.power = {plate.power:g} W at the shaft of the {taken:.4g} W that voltage, current and power "
                         f"factor give is an efficiency of {plate.power / taken:.3g}; it must be between "
                         f"{least:.2g} and 1: check the four, and the unit of the power (\"7.5 kW\")")
    R_s = si_value(known["R_s"], "ohm", "machine.R_s") if "R_s" in known else _stator_resistance(plate, taken)
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
        most = base / math.hypot(R_s + R_R, LEAST_LEAKAGE * base)
        if plate.starting_current > most:
            fix = "" if "R_s" in known else " (R_s is estimated, with all that the stator loses in it) give a measured R_s, or"
            raise InputError(f"{where}.starting_current = {plate.starting_current:g} must be below {most:.3g}, which the "
                             f"resistances of the rated point, R_s + R_R = {R_s + R_R:.3g} ohm, and the least leakage "
                             f"allow;{fix} leave the starting current out")
        L_sgm = math.sqrt((base / plate.starting_current) ** 2 - (R_s + R_R) ** 2) / plate.stator_frequency
    more = {key: value for key, value in known.items() if key not in ("R_s", "n_p")}
    assumed = "starting current" if plate.starting_current else f"a leakage of {TYPICAL_LEAKAGE:g} of the base impedance"
    return InductionMachine.from_inverse_gamma(**{
        "n_p": plate.n_p, "R_s": R_s, "R_R": R_R, "L_sgm": L_sgm, "L_M": L_M,
        "source": f"estimated from its name plate, with {assumed}", **more})


def remarks(plate: Nameplate, known: Mapping[str, Any]) -> list[str]:
    """What a study of this plate should say of it, in sentences: which values were taken, its efficiency, how sure R_s is.

    The stator's loss is what is taken less what crosses the air gap; iron, stray and friction losses are in it. So R_s is at
    most all of it, with the rounding of the plate, and at least `COPPER_SHARE` of it.

    Parameters
    ----------
    plate : Nameplate
    known : mapping
        The table ``[machine]``.
    """
    line = f", {plate.current:.4g} A" if plate.current else ""
    found = [f"taken as {plate.voltage:g} V, {plate.connection}{line}"] if plate.connection else []
    if not plate.taken:
        return found
    implied, usual = plate.power / plate.taken, efficiency_at(1, plate.power)
    found.append(f"voltage, current and power factor give {plate.taken:.0f} W, so that {plate.power:.0f} W at the shaft are an "
                 f"efficiency of {100 * implied:.1f} %")
    if implied < efficiency_at(UNUSUAL, plate.power):
        has = "has" if plate.power >= LEAST_CLASSED else "carried on to smaller ones, would have"
        found.append(f"UNUSUAL: the lowest class of standard motors, IE1, {has} {100 * usual:.0f} % at this power, and half "
                     "the losses of this plate or less. Check it")
    measured = "R_s" in known or "preset" in known
    if plate.efficiency and abs(plate.efficiency / implied - 1) > _CONTRADICTION:
        current = plate.current * implied / plate.efficiency
        text = (f"CONTRADICTION: the plate's efficiency is {100 * plate.efficiency:.1f} %, which needs {current:.4g} A where "
                f"it has {plate.current:.4g} A. Check both; the study is made with the current")
        if not measured:
            less, R_s = plate.power / plate.efficiency - plate.gap, _stator_resistance(plate, plate.taken)
            text += f", and R_s is then {R_s:.3g} ohm" + (
                f" where the efficiency leaves {less / (3 * current**2):.3g} ohm" if less > 0 else "")
        found.append(text)
    if not measured:
        low, high = resistance_range(plate)
        found.append(f"R_s = {_stator_resistance(plate, plate.taken):.3g} ohm is estimated from the plate, between {low:.2g} "
                     f"and {high:.2g} ohm: iron, stray and friction losses are counted with the copper's, whose part is "
                     "taken as half of all or more. Measure it: half of what an ohmmeter shows between two terminals, in star "
                     "or delta")
    return found


def guess(low: float, high: float) -> str:
    """What the source of a machine says where its R_s, between two values in ohm, is guessed; `guessed_range` reads it."""
    return f"{GUESSED}, between {low:.3g} and {high:.3g} Ω"


def guessed_range(source: str) -> tuple[float, float] | None:
    """The least and the most R_s in ohm of a machine with this source; None where its R_s is no guess."""
    found = _RANGE.search(source)
    return (float(found[1]), float(found[2])) if found else None


def resistance_range(plate: Nameplate) -> tuple[float, float]:
    """The least and the most R_s in ohm that a plate with current and power factor leaves; see `remarks`."""
    low = COPPER_SHARE * _stator_resistance(plate, (1 - ROUNDING) * plate.taken)
    return max(low, 0.0), _stator_resistance(plate, (1 + ROUNDING) * plate.taken)


def _stator_resistance(plate: Nameplate, taken: float) -> float:
    """R_s in ohm of the equivalent star, if copper takes all that the stator loses of the power ``taken``."""
    return (taken - plate.gap) / (3 * plate.current**2)


def _of_connection(values: Mapping[str, Any], where: str) -> tuple[dict[str, Any], str]:
    """The values of one connection, where the plate has them for delta and star, ``"400/690 V"``, and which it then is."""
    values = dict(values)
    connection = values.pop("connection", None)
    if connection is not None and connection not in CONNECTIONS:
        raise InputError(f'{where}.connection = {connection!r} must be "star" or "delta"')
    both = {name: found for name in ("voltage", "current")
            if isinstance(values.get(name), str) and (found := _BOTH.match(values[name]))}
    if len(both) == 2:
        voltage, current = both["voltage"], both["current"]
        if (float(voltage[1]) - float(voltage[2])) * (float(current[1]) - float(current[2])) > 0:
            raise InputError(f'{where}.current = "{values["current"]}" beside voltage = "{values["voltage"]}": the lower '
                             f'voltage goes with the higher current; write "{current[2]}/{current[1]} {current[3]}"')
    for name, found in both.items():
        low, high = sorted((found[1], found[2]), key=float)
        # a winding takes the lower voltage in delta, and the line then carries the higher current
        star, delta = (high, low) if name == "voltage" else (low, high)
        if connection is None:
            raise InputError(f'{where}.{name} = "{values[name]}" is for two connections: write the value of yours, "{delta} '
                             f'{found[3]}" in delta or "{star} {found[3]}" in star, or add connection = "delta" or "star"')
        values[name] = f"{star if connection == 'star' else delta} {found[3]}"
    return values, (connection or "") if both else ""


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
