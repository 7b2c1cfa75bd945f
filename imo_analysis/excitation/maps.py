"""Identifiability over the speed-torque plane and over flux modulation, as labelled data.

Numbers are Cramer-Rao bounds (`imo_analysis.excitation.bounds`): the smallest standard deviation that an unbiased
estimate can have. What others have published beside it: `imo_analysis.excitation.published`. The lines in the maps are computed
and proved here (claims ``excitation.*``), not taken from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from imo_analysis.excitation.bounds import Measurement, bounds_over_speed, deviations, held_torque, slip_at
from imo_analysis.machine import InductionMachine

CLASSES = ("neither", "omega only", "alpha only", "either, not both", "both")
RATED_FLUX = 0.5307  # Table III, Wb


def _attributes(data: xr.Dataset, machine: InductionMachine, measurement: Measurement, **more: Any) -> xr.Dataset:
    data.attrs.update(machine=machine.name, noise=measurement.noise, rate=measurement.rate, duration=measurement.duration)
    data.attrs.update(more)
    return data


def speed_torque_map(
    machine: InductionMachine,
    speeds: Sequence[float],
    torques: Sequence[float],
    *,
    flux: float = RATED_FLUX,
    depth: float = 0.0,
    frequency: float = 0.0,
    measurement: Measurement | None = None,
) -> xr.Dataset:
    """Bounds of omega and alpha over the speed-torque plane.

    Parameters
    ----------
    machine : InductionMachine
    speeds : sequence of float
        Electrical speeds in rad/s.
    torques : sequence of float
        Torques in N m, held while the flux is modulated.
    flux : float
        Rotor flux in Wb.
    depth, frequency : float
        Modulation psi = flux (1 + depth cos(frequency t)); zero for constant flux.
    measurement : Measurement, optional

    Returns
    -------
    xarray.Dataset
        On (omega, torque): ``omega_alone`` and ``alpha_alone`` (the other one known), ``omega_both``, ``alpha_both`` (neither
        known), in rad/s and 1/s, infinite where there is no unbiased estimate; ``kind``, an index into `CLASSES`; and
        ``slip``, ``stator_frequency`` in rad/s.
    """
    measurement = measurement or Measurement()
    speed = np.asarray(speeds, float)
    found = {name: np.empty((len(speed), len(torques)))
             for name in ("omega_alone", "alpha_alone", "omega_both", "alpha_both", "slip")}
    for b, torque in enumerate(torques):
        slip = slip_at(machine, torque, flux)
        bound = bounds_over_speed(machine, held_torque(flux, 0.0, slip, depth, frequency), speed, measurement)
        for name, values in bound.items():
            found[name][:, b] = values
        found["slip"][:, b] = slip
    dims = ("omega", "torque")
    data = xr.Dataset({name: (dims, values) for name, values in found.items()},
                      coords={"omega": speed, "torque": np.asarray(torques, float)})
    data["stator_frequency"] = data["omega"] + data["slip"]
    data["kind"] = (dims, classify(found["omega_alone"], found["alpha_alone"], found["omega_both"], found["alpha_both"]))
    for name, unit, meaning in (
        ("omega", "rad/s", "electrical speed"), ("torque", "N m", "torque"),
        ("omega_alone", "rad/s", "smallest standard deviation of omega, alpha known"),
        ("alpha_alone", "1/s", "smallest standard deviation of alpha, omega known"),
        ("omega_both", "rad/s", "smallest standard deviation of omega, alpha unknown"),
        ("alpha_both", "1/s", "smallest standard deviation of alpha, omega unknown"),
        ("slip", "rad/s", "slip frequency"), ("stator_frequency", "rad/s", "stator frequency"),
        ("kind", "1", "what can be identified: " + "; ".join(f"{k} {name}" for k, name in enumerate(CLASSES))),
    ):
        data[name].attrs.update(units=unit, long_name=meaning)
    return _attributes(data, machine, measurement, flux=flux, depth=depth, frequency=frequency)


def classify(omega_alone: Any, alpha_alone: Any, omega_both: Any, alpha_both: Any, within: tuple[float, float] | None = None,
             ) -> Any:
    """Index into `CLASSES` of what has a finite bound; or one of at most ``within`` (1/s for alpha, rad/s for omega)."""
    largest = within or (np.finfo(float).max, np.finfo(float).max)
    omega, alpha = np.asarray(omega_alone) <= largest[1], np.asarray(alpha_alone) <= largest[0]
    both = (np.asarray(omega_both) <= largest[1]) & (np.asarray(alpha_both) <= largest[0])
    return np.where(both, 4, np.where(omega & alpha, 3, np.where(omega, 1, np.where(alpha, 2, 0))))


def modulation_map(
    machine: InductionMachine,
    depths: Sequence[float],
    frequencies: Sequence[float],
    *,
    omega: float = 100.0,
    torque: float = 0.0,
    flux: float = RATED_FLUX,
    measurement: Measurement | None = None,
) -> xr.Dataset:
    """Bounds of omega and alpha, neither known, over depth and frequency of the flux modulation at one operating point.

    They are those of a long time: of a window T they hold where frequency T is above 2 pi, say, and are far too good below,
    where a window shows less than a period.

    Returns
    -------
    xarray.Dataset
        ``omega_both`` (rad/s) and ``alpha_both`` (1/s) on (depth, frequency); frequency in rad/s.
    """
    measurement = measurement or Measurement()
    slip = slip_at(machine, torque, flux)
    found = np.empty((2, len(depths), len(frequencies)))
    for a, depth in enumerate(depths):
        for b, frequency in enumerate(frequencies):
            bound = deviations(machine, held_torque(flux, omega, slip, depth, frequency), measurement)
            found[:, a, b] = bound["omega"], bound["alpha"]
    dims = ("depth", "frequency")
    data = xr.Dataset({"omega_both": (dims, found[0]), "alpha_both": (dims, found[1])},
                      coords={"depth": np.asarray(depths, float), "frequency": np.asarray(frequencies, float)})
    for name, unit, meaning in (
        ("depth", "1", "depth of the flux modulation"), ("frequency", "rad/s", "angular frequency of the flux modulation"),
        ("omega_both", "rad/s", "smallest standard deviation of omega"),
        ("alpha_both", "1/s", "smallest standard deviation of alpha"),
    ):
        data[name].attrs.update(units=unit, long_name=meaning)
    return _attributes(data, machine, measurement, flux=flux, omega=omega, torque=torque)
