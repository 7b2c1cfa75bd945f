"""From a study to the composition that runs it: which features it has, and their numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.simulation.kernel import Loop, plain
from imo_analysis.simulation.saturated_machine import stator_current
from imo_analysis.study import Study


def observer_order(study: Study) -> list[str]:
    """The observers by name, the one that the drive listens to first."""
    return sorted(study.observers, key=lambda name: name != study.drive.feedback)


def loop_of(study: Study) -> Loop:
    """The composition of a study, its observers in the order of `observer_order`."""
    order = observer_order(study)
    directions = tuple(study.observers[name].direction for name in order)
    two_mass = study.mechanics.load_share > 0
    return Loop(
        tuple(study.observers[name].kind for name in order),
        study.drive.feedback != "measured",
        delay=study.inverter.delay > 0,
        inverter=study.inverter.pwm if study.inverter.dc_link > 0 else "",
        quantised=study.sensors.current_resolution > 0,
        believes=two_mass or any(study.drive.errors.values()),
        coulomb=study.mechanics.coulomb > 0,
        two_mass=two_mass,
        saturated=study.saturation.on,
        directions=directions if set(directions) - {"true"} else (),
        order=study.simulation.order,
    )


def require_plain(study: Study, what: str) -> None:
    """Refuse a study with features that only a single run has.

    Raises
    ------
    InputError
        In one line; ``what`` names the one that cannot.
    """
    loop = loop_of(study)
    if plain(loop):
        return
    has = {"inverter.delay": loop.delay, "inverter.dc_link": bool(loop.inverter), "sensors.current_resolution": loop.quantised,
           "drive.errors": loop.believes and not loop.two_mass, "mechanics.coulomb": loop.coulomb,
           "mechanics.load_share": loop.two_mass, "saturation": loop.saturated,
           f"simulation.order = {loop.order}": loop.order != 4,
           "different observers.*.direction": not plain(Loop(loop.observers, loop.feedback, directions=loop.directions))}
    found = ", ".join(name for name, on in has.items() if on)
    raise InputError(f"{found}: {what} must do without; take it out of the study, or run the study alone with imo simulate")


def motor(study: Study) -> InductionMachine:
    """The machine without the inertia behind an elastic shaft."""
    share = study.mechanics.load_share
    return study.machine.with_values(J=study.machine.J * (1 - share)) if share > 0 else study.machine


def extra_arguments(study: Study, loop: Loop) -> list[tuple[Any, ...]]:
    """The tuples for `Loop.extras`."""
    inverter, mechanics, machine = study.inverter, study.mechanics, study.machine
    values: dict[str, tuple[Any, ...]] = {
        "believed": study.drive_machine.plant_parameters,
        "bridge": (inverter.dc_link, study.simulation.sample_time / inverter.carriers, inverter.dead_time,
                   float(inverter.carriers)),
        "step": (study.sensors.current_resolution,),
        "coulomb": (mechanics.coulomb, mechanics.coulomb_speed),
        "shaft": (mechanics.stiffness, mechanics.damping, mechanics.load_share * machine.J, float(machine.n_p)),
    }
    if loop.saturated:
        values["curve"] = curve_parameters(study)
    return [values[name] for name in loop.extras]


def curve_parameters(study: Study) -> tuple[Any, ...]:
    """The tuple ``q`` of `simulation.saturated_machine`."""
    machine = motor(study)
    form = machine.gamma_form()
    knee, power = study.saturation.curve(machine.L_s)
    return (form["R_s"], form["R_r"], form["L_ell"], form["L_s"], machine.L_s / machine.L_m, float(machine.n_p), machine.J,
            knee, power)


def machine_state(study: Study, loop: Loop, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """The states of the composition's machine at time 0, from those of (1); a shaft starts untwisted."""
    x = x.copy()
    if loop.saturated:
        x[:2] = _stator_flux(x, curve_parameters(study))
    return np.append(x, [x[4], 0.0]) if loop.two_mass else x


def _stator_flux(x: NDArray[np.float64], q: tuple[Any, ...]) -> NDArray[np.float64]:
    """The stator flux that carries the current ``x[:2]`` beside the rotor flux: along i + k phi / L_ell, found by bisection."""
    target = x[:2] + q[4] * x[2:4] / q[2]
    size = float(np.hypot(*target))
    if size == 0.0:
        return np.zeros(2)
    unit, low, high = target / size, 0.0, size * q[2]
    while low < (middle := 0.5 * (low + high)) < high:
        i = stator_current((middle * unit[0], middle * unit[1], x[2], x[3], 0.0), q)
        if (i[0] - x[0]) * unit[0] + (i[1] - x[1]) * unit[1] < 0:
            low = middle
        else:
            high = middle
    return np.asarray(low * unit)
