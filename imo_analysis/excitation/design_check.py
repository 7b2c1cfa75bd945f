"""A designed flux modulation in closed loop: simulated with noise for its accuracy and loss, without for what is limited."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.excitation.design import LIMITS, Design, Plant, Wanted, points_looked_at, torques_looked_at
from imo_analysis.excitation.settling import floquet_rate
from imo_analysis.excitation.swing import shape_of
from imo_analysis.machine import InductionMachine

if TYPE_CHECKING:
    from imo_analysis.study import Study

_SAMPLED = 1.01  # of a limit: what a sampled drive may add to peaks that are predicted in continuous time


def plant_of(study: Study, observer: str) -> Plant:
    """What a study's modulation acts on, for one of its observers."""
    settings = study.observers[observer]
    return Plant(study.machine, settings.kind, settings.gains, study.drive.flux, study.drive)


def wanted_of(study: Study, observer: str, alpha: float = 0.3, omega: float = 2.0, time: float = 5.0, **more: Any) -> Wanted:
    """What a design for one observer of a study must reach, over the range of ``[tuning]`` and within the drive's limits.

    Parameters
    ----------
    study : Study
        Its range of speeds with their geometric mean, loads from none to the largest, noise, limits of current and voltage.
        The error of alpha at the start is that of the observer's initial value or the uncertainty of R_r, whichever is more.
    observer : str
        Its name in the study.
    alpha, omega, time : float
        Accuracy in 1/s and rad/s, and the time in s to reach it.
    **more
        Other fields of `Wanted`, in place of those of the study.
    """
    settings, machine, (low, high) = study.observers[observer], study.machine, study.tuning.omega
    off = abs(dict(settings.initial).get("alpha_hat", machine.alpha) - machine.alpha)
    fields: dict[str, Any] = {
        "start": max(off, study.tuning.uncertainty.get("R_r", 0.0) * machine.alpha),
        "speeds": (low, math.sqrt(low * high), high), "torques": (0.0, study.largest_torque), "noise": study.noise,
        "current_limit": study.drive.current_limit, "voltage_limit": study.drive.voltage_limit,
        "step": study.simulation.sample_time}
    return Wanted(alpha, omega, time, **(fields | more))


def slowest_rate(plant: Plant, found: Design, wanted: Wanted) -> tuple[float, tuple[float, float]]:
    """The slowest decay of the alpha error in 1/s by Floquet's multiplier, with its speed and torque (rad/s, N m).

    Looked for at every point that the design was made for: where a sideband nearly stands, a part of the error settles far
    more slowly than on average.
    """
    shape = plant.shape(found.waveform, found.frequency)
    slips, speeds = points_looked_at(plant, wanted, found.frequency, shape)
    rates = np.array([floquet_rate(plant.machine, plant.gains, plant.flux, found.depth, found.frequency, speeds, slip, shape,
                                   plant.kind) for slip in slips])
    row, column = np.unravel_index(np.argmin(rates), rates.shape)
    return float(rates[row, column]), (float(speeds[column]), float(torques_looked_at(wanted)[int(row)]))


def modulated_study(study: Study, found: Design) -> Study:
    """The study with the modulation in its drive, the reference as large as the drive's loops need it."""
    shape = shape_of(found.waveform, found.frequency, study.drive, study.machine.alpha)
    return study.changed({"drive.flux_modulation": found.depth * study.drive.flux * shape.reference,
                          "drive.flux_modulation_frequency": found.frequency, "drive.flux_waveform": found.waveform})


@dataclass(frozen=True)
class Check:
    """A design in closed loop at one speed and load, late on.

    Attributes
    ----------
    omega, torque : float
        The operating point, rad/s and N m.
    alpha_error, alpha_deviation, omega_error, omega_deviation : float
        Mean and deviation of the errors of alpha_hat (1/s) and omega_hat (rad/s).
    noise_torque : float
        Deviation of the torque in N m that the noise makes without the modulation.
    ripple : float
        Half the swing of the torque in N m that the modulation makes without noise.
    depth, current, voltage : float
        Without noise too: half the swing of the flux as a part of its mean, and peaks in A and V.
    loss : float
        Mean copper loss that the modulation added, in W.
    """

    omega: float
    torque: float
    alpha_error: float
    alpha_deviation: float
    omega_error: float
    omega_deviation: float
    noise_torque: float
    ripple: float
    depth: float
    current: float
    voltage: float
    loss: float

    def missed(self, wanted: Wanted) -> list[str]:
        """What is not reached: ``alpha`` and ``omega`` by their rms errors, and the names of limits."""
        rms = {"alpha": math.hypot(self.alpha_error, self.alpha_deviation),
               "omega": math.hypot(self.omega_error, self.omega_deviation)}
        over = [name for name, value in rms.items() if value > getattr(wanted, name)]
        return over + [limit.name for limit in LIMITS if getattr(self, limit.found) > limit.value(wanted) * _SAMPLED]

    def keeps(self, wanted: Wanted) -> bool:
        """Whether the accuracy is reached and every limit kept."""
        return not self.missed(wanted)


def verify(study: Study, found: Design, wanted: Wanted, observer: str, more: Sequence[tuple[float, float]] = ()) -> list[Check]:
    """Simulate the design at each speed and load that is given, where it is predicted to settle the slowest, and at ``more``.

    With noise over the whole periods of the second after ``wanted.time``, and without noise for the limits.
    """
    from imo_analysis.simulation.run import simulate

    period = 2 * math.pi / found.frequency
    late = slice(wanted.time, wanted.time + max(1, int(1.0 / period)) * period)
    points = [(omega, torque) for omega in wanted.speeds for torque in wanted.torques]
    rows = []
    for omega, torque in dict.fromkeys([*points, found.slowest, *more]):
        still = study.only([observer]).changed({
            "sensors.current_noise": 0.0, "reference.shape": "steps", "reference.time": [0.0], "reference.omega": [omega],
            "load.shape": "steps", "load.time": [0.0], "load.T_l": [torque], "simulation.duration": late.stop + 1e-3,
            "simulation.record_every": 1, "drive.flux_modulation": 0.0, "drive.flux_modulation_off": [0.0, 0.0]})
        plain = still.changed({"sensors.current_noise": wanted.noise})
        run = simulate(modulated_study(plain, found)).sel(observer=observer, time=late)
        before = simulate(plain).sel(time=late)
        exact = simulate(modulated_study(still, found)).sel(time=late)
        alpha = (run["alpha_hat"] - study.machine.alpha).values
        speed = (run["omega_hat"] - run["omega"]).values
        flux, current, voltage = (np.hypot(exact[f"{one}_d{end}"].values, exact[f"{one}_q{end}"].values)
                                  for one, end in (("phi", "r"), ("i", "s"), ("u", "s")))
        rows.append(Check(omega, torque, float(alpha.mean()), float(alpha.std()), float(speed.mean()), float(speed.std()),
                          float(before["torque"].std()), float(np.ptp(exact["torque"].values)) / 2,
                          float(np.ptp(flux) / 2 / flux.mean()), float(current.max()), float(voltage.max()),
                          _copper_loss(study.machine, run) - _copper_loss(study.machine, before)))
    return rows


def _copper_loss(machine: InductionMachine, run: Any) -> float:
    """Mean loss in stator and rotor, in W."""
    stator = run["i_ds"].values + 1j * run["i_qs"].values
    rotor = (run["phi_dr"].values + 1j * run["phi_qr"].values - machine.L_m * stator) / machine.L_r
    return float(1.5 * np.mean(machine.R_s * np.abs(stator) ** 2 + machine.R_r * np.abs(rotor) ** 2))
