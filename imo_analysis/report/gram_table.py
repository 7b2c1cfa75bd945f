"""The closed forms of the mean Gram matrix beside simulated ones: the machine under its drive, flux constant and modulated."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from imo_analysis.study import Study

Triple = tuple[float, float, float]
_SETTLED, _PERIODS = 1.0, 5  # s; whole periods of the modulation that are averaged


@dataclass(frozen=True)
class GramRow:
    """Means ``(v_1.v_1, v_1.v_2, v_2.v_2)`` in A^2 at one speed (rad/s), torque (N m) and depth of the flux.

    ``held`` is the closed form at constant torque and ``even`` that at constant slip; the drive holds the torque.
    """

    omega: float
    torque: float
    depth: float
    simulated: Triple
    held: Triple
    even: Triple


def gram_rows(study: Study, depth: float, frequency: float) -> list[GramRow]:
    """Simulated and closed, for constant and modulated flux, without and with half the largest load; empty without an adaptive
    observer that a modulation can be designed for, for it is run beside it.
    """
    from imo_analysis.excitation.design import Design
    from imo_analysis.excitation.design_check import modulated_study, steady_study
    from imo_analysis.excitation.settling import KINDS
    from imo_analysis.simulation.run import simulate

    names = [name for name, settings in study.observers.items() if settings.kind in KINDS]
    if not names:
        return []
    period = 2 * math.pi / frequency
    late = slice(_SETTLED, _SETTLED + _PERIODS * period)
    omega = math.sqrt(study.tuning.omega[0] * study.tuning.omega[1])
    rows = []
    for swing in (0.0, depth):
        for torque in (0.0, study.largest_torque / 2):
            still = steady_study(study, names[0], omega, torque).changed({"simulation.duration": late.stop + 1e-2})
            nothing = (math.nan,) * 8
            swung = modulated_study(still, Design(swing, frequency, *nothing, (omega, torque))) if swing else still
            rows.append(_row(study, simulate(swung).sel(time=late), (omega, torque), swing, frequency))
    return rows


def _row(study: Study, run: object, point: tuple[float, float], depth: float, frequency: float) -> GramRow:
    from imo_analysis.equations import steady_state
    from imo_analysis.excitation import signals
    from imo_analysis.excitation.bounds import slip_at
    from imo_analysis.excitation.conditions import CONDITIONS

    machine, flux, (omega, torque) = study.machine, study.drive.flux, point
    source = signals.select(signals.of_dataset(run, machine), signals.PLANT)
    rows = CONDITIONS["reduced"].of(source.block(slice(0, source.samples)), machine)
    v_1, v_2 = (np.array([row[k] for row in rows]) for k in (2, 3))
    simulated = tuple(float((a * b).sum(axis=0).mean()) for a, b in ((v_1, v_1), (v_1, v_2), (v_2, v_2)))
    slip, alpha, beta = slip_at(machine, torque, flux), machine.alpha, machine.beta
    held = steady_state.gram_constant_torque(flux, depth, math.sqrt(1 - depth**2), frequency, slip, alpha, beta)
    even = steady_state.gram_constant_slip(flux, depth, frequency, slip, alpha, beta)
    return GramRow(omega, torque, depth, simulated, held, even)  # type: ignore[arg-type]
