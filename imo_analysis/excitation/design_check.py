"""A designed flux modulation in closed loop: simulated with noise for its accuracy and loss, without for what is limited."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.steady_state import current_of_flux
from imo_analysis.equations.transformation import to_z
from imo_analysis.excitation.bounds import slip_at
from imo_analysis.excitation.choice import Chosen, by_loss, choose, settling_ones
from imo_analysis.excitation.design import LIMITS, Design, Plant, Wanted
from imo_analysis.excitation.resting import drift_of_step
from imo_analysis.excitation.settling import DRIFTS
from imo_analysis.excitation.swing import shape_of
from imo_analysis.machine import InductionMachine

if TYPE_CHECKING:
    from imo_analysis.study import Study

_TRIES = 5  # designs that are simulated, the cheapest first, until one holds
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
        The error of alpha at the start is that of the observer's initial value or the uncertainty of R_r, whichever is more,
        with what a step across the range of speeds adds to it (`resting.drift_of_step`) where the law drifts with the speed.
    observer : str
        Its name in the study.
    alpha, omega, time : float
        Accuracy in 1/s and rad/s, and the time in s to reach it.
    **more
        Other fields of `Wanted`, in place of those of the study.
    """
    settings, machine, (low, high) = study.observers[observer], study.machine, study.tuning.omega
    off = abs(dict(settings.initial).get("alpha_hat", machine.alpha) - machine.alpha)
    torque = study.largest_torque
    drift = max(abs(drift_of_step(study, settings.gains, low, high, load)) for load in (-torque, torque)) \
        if settings.kind in DRIFTS else 0.0
    fields: dict[str, Any] = {
        "start": max(off, study.tuning.uncertainty.get("R_r", 0.0) * machine.alpha) + drift,
        "speeds": (low, math.sqrt(low * high), high), "torques": (0.0, study.largest_torque), "noise": study.noise,
        "current_limit": study.drive.current_limit, "voltage_limit": study.drive.voltage_limit,
        "step": study.simulation.sample_time}
    return Wanted(alpha, omega, time, **(fields | more))


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


def steady_study(study: Study, observer: str, omega: float, torque: float) -> Study:
    """One observer of a study, all estimates right, at constant speed (rad/s) and load (N m) from the start, the flux built.

    Without modulation and noise. Only the drive's integrators have to find their values.
    """
    machine, flux = study.machine, study.drive.flux
    i_d, i_q = current_of_flux(flux, 0.0, slip_at(machine, torque, flux), machine.alpha, machine.L_m)
    z = to_z(i_d, i_q, flux, 0.0, machine.beta)
    right = {"i_ds_hat": i_d, "i_qs_hat": i_q, "z_1_hat": z[0], "z_2_hat": z[1], "xi_1_hat": z[0], "xi_2_hat": z[1],
             "alpha_hat": machine.alpha, "omega_hat": omega}
    return study.only([observer]).changed({
        "sensors.current_noise": 0.0, "reference.shape": "steps", "reference.time": [0.0], "reference.omega": [omega],
        "load.shape": "steps", "load.time": [0.0], "load.T_l": [torque], "simulation.record_every": 1,
        "initial": {"i_ds": i_d, "i_qs": i_q, "phi_dr": flux, "phi_qr": 0.0, "omega": omega},
        f"observers.{observer}.initial": right, "drive.flux_modulation": 0.0, "drive.flux_modulation_off": [0.0, 0.0]})


def verify(study: Study, found: Design, wanted: Wanted, observer: str, more: Sequence[tuple[float, float]] = ()) -> list[Check]:
    """Simulate the design at each speed and load that is given, where it is predicted to settle the slowest, and at ``more``.

    Each run begins at constant speed with alpha_hat off by ``wanted.start``, to either side; what is told is the worse. With
    noise over the whole periods of the second after ``wanted.time``, and without noise for the limits.
    """
    from imo_analysis.simulation.run import simulate

    period = 2 * math.pi / found.frequency
    late = slice(wanted.time, wanted.time + max(1, int(1.0 / period)) * period)
    points = [(omega, torque) for omega in wanted.speeds for torque in wanted.torques]
    rows = []
    for omega, torque in dict.fromkeys([*points, found.slowest, *more]):
        still = steady_study(study, observer, omega, torque).changed({"simulation.duration": late.stop + 1e-3})
        plain = still.changed({"sensors.current_noise": wanted.noise})
        before = simulate(plain).sel(time=late)
        exact = simulate(modulated_study(still, found)).sel(time=late)
        run, alpha, speed = max((_late_errors(modulated_study(plain, found), observer, sign * wanted.start, late)
                                 for sign in (-1, 1)), key=lambda one: float(np.mean(one[1] ** 2)))
        flux, current, voltage = (np.hypot(exact[f"{one}_d{end}"].values, exact[f"{one}_q{end}"].values)
                                  for one, end in (("phi", "r"), ("i", "s"), ("u", "s")))
        rows.append(Check(omega, torque, float(alpha.mean()), float(alpha.std()), float(speed.mean()), float(speed.std()),
                          float(before["torque"].std()), float(np.ptp(exact["torque"].values)) / 2,
                          float(np.ptp(flux) / 2 / flux.mean()), float(current.max()), float(voltage.max()),
                          _copper_loss(study.machine, run) - _copper_loss(study.machine, before)))
    return rows


@dataclass(frozen=True)
class Verified:
    """A design that was taken, its checks in closed loop, and how many cheaper ones missed there."""

    chosen: Chosen
    checks: list[Check]
    failed: int

    def missed(self, wanted: Wanted) -> list[str]:
        """What the checks miss, in order of the alphabet."""
        return sorted({name for one in self.checks for name in one.missed(wanted)})


def verified(study: Study, observer: str, wanted: Wanted, found: Sequence[Design], deepest: Sequence[Design]) -> Verified:
    """The cheapest of what `design.search` found that reaches the accuracy in closed loop; the cheapest of all if none does.

    Only the first few are tried, and none further for noise of the speed, which no modulation changes.

    Raises
    ------
    InputError
        As `choice.design`.
    """
    plant = plant_of(study, observer)
    first = None
    for number, chosen in enumerate(islice(settling_ones(plant, by_loss(found, wanted), wanted), _TRIES)):
        tried = Verified(chosen, verify(study, chosen.design, wanted, observer, [chosen.slowest.where]), number)
        if set(tried.missed(wanted)) <= {"omega"}:
            return tried
        first = first or tried
    return first or Verified(choose(plant, found, deepest, wanted), [], 0)  # which raises


def _late_errors(study: Study, observer: str, off: float, late: slice) -> tuple[Any, Any, Any]:
    """A run with alpha_hat ``off`` (1/s) at the start, late on, with the errors of alpha_hat and omega_hat."""
    from imo_analysis.simulation.run import simulate

    lowest = study.observers[observer].gains["alpha_l"]  # below it the law holds alpha_hat back
    begun = study.changed({f"observers.{observer}.initial.alpha_hat": max(study.machine.alpha + off, lowest)})
    run = simulate(begun).sel(observer=observer, time=late)
    return run, (run["alpha_hat"] - study.machine.alpha).values, (run["omega_hat"] - run["omega"]).values


def _copper_loss(machine: InductionMachine, run: Any) -> float:
    """Mean loss in stator and rotor, in W."""
    stator = run["i_ds"].values + 1j * run["i_qs"].values
    rotor = (run["phi_dr"].values + 1j * run["phi_qr"].values - machine.L_m * stator) / machine.L_r
    return float(1.5 * np.mean(machine.R_s * np.abs(stator) ** 2 + machine.R_r * np.abs(rotor) ** 2))
