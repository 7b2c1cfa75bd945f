"""A study run in time: the labelled data set of machine, drive and observers."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.plant import torque
from imo_analysis.errors import Diverged, InputError
from imo_analysis.notation import symbol
from imo_analysis.simulation.composition import extra_arguments, loop_of, machine_state, motor, observer_order
from imo_analysis.simulation.drive import flux_rates
from imo_analysis.simulation.inputs import Array, inputs
from imo_analysis.simulation.kernel import PLANT_STATES, Loop, kernel
from imo_analysis.simulation.labelled import Labelled, Variable
from imo_analysis.simulation.saturated_machine import saturated_torque
from imo_analysis.study import Study

if TYPE_CHECKING:
    import xarray as xr

SCHEMA = "imo-run/1"
# A state whose sizes add up to more than this, in SI units, has left what any machine can do.
BOUND = 1e6
# Below this share of the flux reference the drive takes the flux for too small to divide by.
FLUX_FLOOR = 0.05
ESTIMATES = (
    "i_ds_hat", "i_qs_hat", "z_1_hat", "z_2_hat", "xi_1_hat", "xi_2_hat", "alpha_hat", "omega_hat", "phi_dr_hat", "phi_qr_hat",
)
# What only some compositions record: unit, meaning and symbol.
MORE = {
    "u_ds_told": ("V", "stator voltage as observers and drive are told, d axis", r"u_{ds}^{told}"),
    "u_qs_told": ("V", "stator voltage as observers and drive are told, q axis", r"u_{qs}^{told}"),
    "omega_load": ("rad/s", "speed behind the elastic shaft, electrical", r"\omega_L"),
    "shaft_torque": ("N m", "torque of the elastic shaft on the load", "T_{sh}"),
    "psi_ds": ("Wb", "stator flux linkage, d axis", r"\psi_{ds}"),
    "psi_qs": ("Wb", "stator flux linkage, q axis", r"\psi_{qs}"),
}
# A run that would need more bytes than this is refused.
MEMORY = 8e9
# Steps of the integrator between two looks at the keyboard and the progress bar; the inputs of so few stay in the
# processor's cache, so that a second of motor time costs the same in a short run and in a long one.
_STRETCH = 10_000


def simulate(study: Study, progress: Callable[[int], None] | None = None) -> xr.Dataset:
    """Run a study.

    All observers run side by side on the same machine; none changes what another computes, to the bit.

    Parameters
    ----------
    study : Study
        What to run.
    progress : callable, optional
        Called with the number of samples done since the last call.

    Returns
    -------
    xarray.Dataset
        Dimensions ``time`` (s) and ``observer``. The true machine ``i_ds i_qs phi_dr phi_qr omega torque``, the applied
        ``u_ds u_qs`` and ``T_l``, ``omega_ref``, the measured ``i_ds_meas i_qs_meas``, and for each observer the `ESTIMATES`,
        NaN where it has none. A record is the state at its time, with the voltage that is applied from then on.

    Raises
    ------
    Diverged
        When the machine or an observer leaves `BOUND`. Its ``data`` is the run so far: records after the machine was lost are
        left out, those of an observer that was lost are NaN.
    """
    data, fault = simulate_labelled(study, progress)
    if fault:
        fault.data = data.dataset()
        raise fault
    return data.dataset()


def simulate_labelled(study: Study, progress: Callable[[int], None] | None = None) -> tuple[Labelled, Diverged | None]:
    """As `simulate`, without xarray, and with the fault returned beside the run so far."""
    order, loop = observer_order(study), loop_of(study)
    out, outside, lost = _run(study, order, loop, progress)
    data = _label(study, order, loop, out, outside, lost)
    return data, _diverged(study, order, data, lost) if (lost >= 0).any() else None


def drive_parameters(study: Study) -> tuple[float, ...]:
    """The tuple ``d`` of `simulation.drive`."""
    drive = study.drive
    return (study.simulation.sample_time, drive.current_bandwidth, drive.flux_bandwidth, drive.speed_bandwidth,
            min(drive.voltage_limit, study.inverter.longest_voltage), drive.current_limit, FLUX_FLOOR * drive.flux)


def initial_state(study: Study) -> tuple[Array, Array]:
    """States of machine and drive at time 0; the drive's own flux starts at the machine's."""
    x = np.array([getattr(study.initial, name) for name in PLANT_STATES])
    flux = (x[2], x[3])
    return x, np.array([0.0, 0.0, 0.0, *flux, *flux_rates(flux, (x[0], x[1]), x[4], study.drive_machine.plant_parameters)])


def _run(
    study: Study, order: list[str], loop: Loop, progress: Callable[[int], None] | None
) -> tuple[Array, Array, Any]:
    """Records, the rows ``omega_ref`` and ``T_l`` at them, and what was lost when."""
    simulation, sensors = study.simulation, study.sensors
    every = simulation.record_every
    run = kernel(loop)
    x, c = initial_state(study)
    x, c = machine_state(study, loop, x), np.append(c, np.zeros(loop.control_width - len(c)))
    friction = study.machine.B / study.machine.n_p
    each: list[Any] = []
    for name in order:
        settings = study.observers[name]
        each += [np.array(settings.initial_values), study.observer_machine(name).observer_parameters, settings.gain_values]
    sensor = (*sensors.current_gain, *sensors.current_offset, 1.0 if sensors.sampling == "sampled" else 0.0)
    records = math.ceil(simulation.samples / every)
    size = 8 * records * (len(loop.columns) + len(order) * len(ESTIMATES) + 12)
    if size > MEMORY:
        raise InputError(
            f"simulation.record_every = {every} keeps {records} records, {size / 1e9:.1f} GB; that must be below "
            f"{MEMORY / 1e9:g} GB: make it {math.ceil(every * size / MEMORY)} or more, or shorten simulation.duration"
        )
    out = np.empty((records, len(loop.columns)))
    outside = np.empty((2, records))
    lost = np.full(1 + len(order), -1)
    stretch = math.ceil(_STRETCH / simulation.substeps / every) * every
    for start in range(0, simulation.samples, stretch):
        samples = min(stretch, simulation.samples - start)
        given = inputs(study, start, samples)
        row = start // every
        outside[:, row : row + math.ceil(samples / every)] = given[[0, 2], ::every]
        done = run(start, samples, every, simulation.sample_time, simulation.substeps, BOUND, x, c, given, sensor,
                   motor(study).plant_parameters, friction, drive_parameters(study), out[row:], lost,
                   *extra_arguments(study, loop), *each)
        if progress:
            progress(done)
        if done < samples:
            records = math.ceil((start + done) / every)
            break
    return out[:records], outside[:, :records], lost


def _label(study: Study, order: list[str], loop: Loop, out: Array, outside: Array, lost: Any) -> Labelled:
    names = list(study.observers)
    columns = {name: np.ascontiguousarray(out[:, n]) for n, name in enumerate(loop.columns)}
    machine = study.machine
    number = np.arange(len(out)) * study.simulation.record_every
    time = ("time",)
    data: dict[str, Variable] = {name: (time, columns[name], _attributes(name)) for name in (*PLANT_STATES, "u_ds", "u_qs")}
    state = tuple(columns[name] for name in PLANT_STATES)
    data["torque"] = (time, torque(state, machine.n_p, machine.L_m, machine.L_r), _attributes("torque"))
    data |= {name: (time, columns[name], dict(zip(("units", "long_name", "latex"), MORE[name], strict=True)))
             for name in loop.more_columns}
    if loop.saturated:
        flux = (columns["psi_ds"], columns["psi_qs"])
        data["torque"] = (time, saturated_torque(flux, state, machine.n_p), _attributes("torque"))
    data["T_l"] = (time, outside[1], _attributes("T_l"))
    data["omega_ref"] = (time, outside[0], {**_attributes("omega"), "long_name": "reference of the rotor speed, electrical",
                                              "latex": r"\omega^*"})
    seen = (columns["i_ds_meas"], columns["i_qs_meas"])
    for axis, values in zip("dq", seen, strict=True):
        data[f"i_{axis}s_meas"] = (time, values, {"units": "A", "long_name": f"stator current, {axis} axis, as measured",
                                                    "latex": rf"i_{{{axis}s}}^{{meas}}"})
    further = {state: None for name in order for state in OBSERVERS[study.observers[name].kind].states}
    estimates = {name: np.full((len(names), len(out)), np.nan) for name in dict.fromkeys((*ESTIMATES, *further))}
    for n, name in enumerate(order):
        observer = OBSERVERS[study.observers[name].kind]
        place = names.index(name)
        x_hat = tuple(columns[f"{state_name}@{n}"] for state_name in observer.states)
        if lost[n + 1] >= 0:
            for values in x_hat:
                values[number >= lost[n + 1]] = np.nan
        for state_name, values in zip(observer.states, x_hat, strict=True):
            estimates[state_name][place] = values
        with np.errstate(divide="ignore", invalid="ignore"):
            flux = observer.flux(x_hat, seen, study.observer_machine(name).beta)
        estimates["phi_dr_hat"][place], estimates["phi_qr_hat"][place] = flux
    data |= {name: (("observer", "time"), values, _attributes(name)) for name, values in estimates.items()}
    coordinates: dict[str, Variable] = {
        "time": (time, number * study.simulation.sample_time, _attributes("t")),
        "observer": (("observer",), np.array(names, dtype=str if names else "<U1"), {}),
    }
    return Labelled(data, coordinates, provenance(study))


def provenance(study: Study) -> dict[str, Any]:
    """Attributes of every result: schema, study, its hash, package versions, seed."""
    return {"schema": SCHEMA, "title": study.title, "study": study.to_toml(), "study_sha256": study.sha256,
            "versions": _versions(), "seed": study.simulation.seed}


@cache
def _versions() -> str:
    versions = {name: version(name) for name in ("imo-analysis", "numpy", "numba", "llvmlite")}
    return json.dumps({**versions, "python": platform.python_version()})


def _attributes(name: str) -> dict[str, Any]:
    entry = symbol(name)
    return {"units": entry.unit, "long_name": entry.meaning, "latex": entry.latex}


def overload(study: Study) -> str:
    """That the load is more than the machine can give, in a sentence; empty where it is not."""
    load, most = max(map(abs, study.load_torque.T_l), default=0.0), study.torque_limit
    return "" if load <= most else (
        f"the load reaches {load:.4g} N m (load.T_l), and this machine gives at most {most:.4g} N m with drive.flux = "
        f"{study.drive.flux:.4g} Wb and drive.current_limit = {study.drive.current_limit:.4g} A")


def _diverged(study: Study, order: list[str], data: Labelled, lost: Any) -> Diverged:
    """The fault that names who was lost, when, and the last state on record."""
    who = ["the machine", *(f"observer {name}" for name in order)]
    T = study.simulation.sample_time
    found = sorted((int(sample), n) for n, sample in enumerate(lost) if sample >= 0)
    texts = [f"{who[n]} diverged at t = {sample * T:.6g} s" for sample, n in found]
    sample, n = found[0]
    if lost[0] >= 0 and (too_much := overload(study)):
        texts.append(too_much)
    states = PLANT_STATES if n == 0 else OBSERVERS[study.observers[order[n - 1]].kind].states
    row = math.ceil(sample / study.simulation.record_every) - 1
    last: dict[str, float] = {}
    if row >= 0:
        place = () if n == 0 else (list(study.observers).index(order[n - 1]),)
        last = {name: float(data[name][*place, row]) for name in states}
        values = ", ".join(f"{name} = {value:.6g} {symbol(name).unit}".removesuffix(" 1") for name, value in last.items())
        texts.append(f"the last state on record, at t = {row * study.simulation.record_every * T:.6g} s, was {values}")
    return Diverged("; ".join(texts), sample * T, last)
