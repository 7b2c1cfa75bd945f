"""The tables of a study for what a drive has and a paper leaves out: inverter, mechanics, saturation. All off by default."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Literal, Self

from pydantic import Field, model_validator

from imo_analysis.machine import InductionMachine
from imo_analysis.study_tables import Current, Damping, Flux, Number, Seconds, Speed, Table, Torque, Voltage

# A fitted curve may miss its table by this share of the largest current.
FIT = 0.05


class Inverter(Table):
    """``[inverter]``: what is between the voltage that the drive computes and the machine.

    Attributes
    ----------
    delay : int
        Samples from the measurement to the voltage computed from it: 0, or 1 as in a drive that computes in between.
    dc_link : float
        DC-link voltage in V; 0 leaves the inverter out.
    limit : str
        ``circle``: the drive keeps to dc_link / sqrt(3), reached in every direction; ``hexagon``: it asks for up to
        2 dc_link / 3, and what lies outside the hexagon is shortened.
    pwm : str
        ``average``: the mean of each sample is applied, dead time included; ``switched``: every pulse is.
    carriers : int
        Carrier periods in a sample.
    dead_time : float
        In s. Observers and drive are told the voltage without its effect.
    """

    delay: int = Field(default=0, ge=0, le=1)
    dc_link: Voltage = Field(default=0.0, ge=0)
    limit: Literal["circle", "hexagon"] = "circle"
    pwm: Literal["average", "switched"] = "average"
    carriers: int = Field(default=1, ge=1, le=1000)
    dead_time: Seconds = Field(default=0.0, ge=0)

    @model_validator(mode="after")
    def _link(self) -> Self:
        if self.dc_link == 0:
            for name in ("limit", "pwm", "carriers", "dead_time"):
                if getattr(self, name) != type(self).model_fields[name].default:
                    raise ValueError(f"{name} = {getattr(self, name)} needs a DC link; set dc_link in V, for example 600")
        return self

    @property
    def longest_voltage(self) -> float:
        """Largest magnitude in V that the drive may ask for."""
        if self.dc_link == 0:
            return math.inf
        return self.dc_link / math.sqrt(3) if self.limit == "circle" else 2 * self.dc_link / 3


class Mechanics(Table):
    """``[mechanics]``: dry friction, and a load behind an elastic shaft. Inertia and viscous friction are J and B of [machine].

    Attributes
    ----------
    coulomb : float
        Dry friction of the motor's shaft in N m.
    coulomb_speed : float
        Speed in rad/s, electrical, at which 71 % of it acts: it is smoothed about standstill.
    load_share : float
        Share of J, below 1, that sits behind the shaft; 0 makes the shaft stiff.
    stiffness : float
        Of the shaft in N m (per rad of twist). The load torque then acts behind it.
    damping : float
        Of the shaft's twist in N m s.
    """

    coulomb: Torque = Field(default=0.0, ge=0)
    coulomb_speed: Speed = Field(default=1.0, gt=0)
    load_share: Number = Field(default=0.0, ge=0, lt=1)
    stiffness: Torque = Field(default=0.0, ge=0)
    damping: Damping = Field(default=0.0, ge=0)

    @model_validator(mode="after")
    def _shaft(self) -> Self:
        if self.load_share > 0 and self.stiffness == 0:
            raise ValueError("stiffness = 0 N m must be above 0 when load_share is set: it is the shaft between the two")
        if self.load_share == 0 and (self.stiffness > 0 or self.damping > 0):
            raise ValueError("load_share = 0 must be above 0 for a shaft with stiffness or damping")
        return self

    def resonance(self, J: float) -> float:
        """Of the two masses that make up J, in rad/s, without damping."""
        return math.sqrt(self.stiffness / J / self.load_share / (1 - self.load_share))


class Saturation(Table):
    """``[saturation]``: the magnetising curve i = psi (1 + (psi / knee)^(2 power)) / L_s, by its two numbers or as a table.

    Attributes
    ----------
    knee : float
        Stator flux in Wb at which half of L_s is left; 0 leaves saturation out.
    power : int
        How sharp the knee is.
    flux : tuple of float
        A measured curve in place of both numbers, which are fitted to it: magnitudes of the stator flux in Wb.
    current : tuple of float
        The magnitude of the current in A at each ``flux`` of that curve.
    """

    knee: Flux = Field(default=0.0, ge=0)
    power: int = Field(default=3, ge=1, le=20)
    flux: tuple[Flux, ...] = ()
    current: tuple[Current, ...] = ()

    @model_validator(mode="after")
    def _table(self) -> Self:
        if len(self.flux) != len(self.current):
            raise ValueError(f"flux has {len(self.flux)} entries and current has {len(self.current)}; they must be as many")
        if not self.flux:
            return self
        if self.knee > 0:
            raise ValueError(f"knee = {self.knee:g} Wb and a table were both given; give one of them")
        if len(self.flux) < 3:
            raise ValueError(f"flux has {len(self.flux)} entries; a curve needs 3 or more")
        for name in ("flux", "current"):
            for before, after in pairwise((0.0, *getattr(self, name))):
                if after <= before:
                    raise ValueError(f"{name} must increase from above 0, but {after:g} follows {before:g}")
        return self

    @property
    def on(self) -> bool:
        """Whether the machine saturates."""
        return self.knee > 0 or bool(self.flux)

    def curve(self, L_s: float) -> tuple[float, int]:
        """``(knee, power)`` with this unsaturated inductance.

        Raises
        ------
        ValueError
            If no such curve comes within `FIT` of the table.
        """
        if not self.flux:
            return self.knee, self.power
        found = min((_fit(self.flux, self.current, L_s, power) for power in range(1, 21)), key=lambda fit: fit[0])
        if found[0] > FIT * self.current[-1]:
            raise ValueError(
                f"saturation.current misses every curve psi (1 + (psi/knee)^(2 power)) / L_s by {found[0]:.3g} A or more; it "
                f"must come within {FIT * self.current[-1]:.3g} A: does machine.L_s = {L_s:g} H fit the start of the table "
                f"({self.flux[0] / self.current[0]:.3g} H)?")
        return found[1], found[2]


def _fit(flux: tuple[float, ...], current: tuple[float, ...], L_s: float, power: int) -> tuple[float, float, int]:
    """Largest miss in A, knee and power, of the least-squares fit of knee^(-2 power), which is linear."""
    # relative to the last flux, so that the powers stay of order 1
    top = flux[-1]
    shapes = [psi / L_s * (psi / top) ** (2 * power) for psi in flux]
    rests = [i - psi / L_s for psi, i in zip(flux, current, strict=True)]
    share = max(sum(a * b for a, b in zip(shapes, rests, strict=True)) / sum(a * a for a in shapes), 1e-12)
    miss = max(abs(share * a - b) for a, b in zip(shapes, rests, strict=True))
    return miss, top * share ** (-1 / (2 * power)), power


def check_realism(machine: InductionMachine, sample_time: float, substeps: int, inverter: Inverter, mechanics: Mechanics,
                  saturation: Saturation) -> None:
    """What one table alone cannot see.

    Raises
    ------
    ValueError
        In one line.
    """
    period = sample_time / inverter.carriers
    if inverter.dead_time >= 0.25 * period:
        raise ValueError(f"inverter.dead_time = {inverter.dead_time:g} s must be below a quarter of the carrier period, "
                         f"{0.25 * period:g} s")
    if saturation.on:
        saturation.curve(machine.L_s)
    if mechanics.load_share > 0:
        turn = mechanics.resonance(machine.J) * sample_time / substeps
        if turn > 0.5:
            raise ValueError(f"mechanics.stiffness = {mechanics.stiffness:g} N m makes the shaft ring at "
                             f"{mechanics.resonance(machine.J):.4g} rad/s, too fast for the step: set simulation.substeps to "
                             f"{math.ceil(2 * turn * substeps)} or more")
