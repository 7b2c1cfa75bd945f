"""The study that ``imo study --init`` writes for a motor with a name plate: rated flux, gains that fit, five runs."""

from __future__ import annotations

import math
from typing import Any

from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.nameplate import Nameplate, machine_of, rated_flux

OBSERVERS = ("baseline", "consistent_12", "repaired", "quiet")
SAMPLE_TIME = 1e-4
NOISE = 0.002  # of the rated current: what a good sensor and twelve bits leave
_PARAMETERS = ("n_p", "R_s", "R_r", "L_m", "L_s", "L_r", "J")

_TEXT = """# A study of your own motor, written by imo study --init. Numbers are SI, or text with a unit: "60.1 mH", "100 us".
# Speeds are electrical: pole pairs times the speed of the shaft.
# Rated here: {rated:.4g} rad/s, {torque:.4g} N m, slip {slip:.3g} rad/s.

title = {title}

{machine}
[simulation]
duration = 6.0        # s
sample_time = 1e-4    # s, the drive's sampling: 10 kHz
record_every = 10     # one record in so many samples
seed = 1              # of all noise

[initial]
# magnetised, at standstill
i_ds = {i_d:.5g}          # A
phi_dr = {flux:.5g}       # Wb

[reference]
shape = "linear"
time = [0.0, 0.3, 1.5, 3.0, 4.0]         # s
omega = [0.0, 0.0, {half:.4g}, {half:.4g}, {rated:.4g}]     # rad/s

[load]
shape = "linear"
time = [0.0]          # s
T_l = [0.0]           # N m

[drive]
# Field-oriented control on the measured speed: the observers look on. The scenario "closed" lets one of them drive.
flux = {flux:.5g}             # Wb: the rotor flux at rated voltage, less {reserve:g} %
current_bandwidth = 1500.0    # rad/s
flux_bandwidth = 30.0         # rad/s
speed_bandwidth = 45.0        # rad/s
voltage_limit = {voltage:.4g}     # V, phase peak: the rated one
current_limit = {limit:.4g}     # A, phase peak: twice the rated one
feedback = "measured"         # or the name of an observer below

[sensors]
current_noise = {noise:.3g}     # A, standard deviation of each sample

# Gains by the rule of imo replay, for this machine and noise. direction: whence the observers have the sign of the speed.
{observers}
[excitation]
window = 0.5    # s
every = 0.1     # s

[poles]
omega = [{low:.4g}, {half:.4g}, {rated:.4g}]                          # rad/s
sweep = {{ start = {back:.4g}, stop = {rated:.4g}, count = 201 }}    # rad/s

[sweep]
# imo sweep FILE --out sweep.nc --plot sweep.svg: machines whose resistances are off by up to half, unknown to the observers.
scenario = "load"
runs = 1000
seed = 1
believe = "nominal"
start = 3.0           # s; errors count from here on
band = {band:.3g}           # rad/s: 2 % of half the rated speed; a smaller error counts as none
hold = 0.5            # s
[sweep.fields]
machine.R_r = {{ relative = 0.5 }}
machine.R_s = {{ relative = 0.5 }}

[scenarios.speed]
title = "idle, up to rated speed"
windows = [{{ title = "to rated speed", start = 2.9, stop = 4.6, caption = "from half to all of the rated speed" }}]

[scenarios.load]
title = "rated load at half speed"
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {half:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]

[scenarios.warm]
# the observers still believe the cold machine: its resistances have risen by 30 %, 1 / 1.3 - 1 = -0.23
title = "the same, resistances 30 % up and unknown"
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {half:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]
{warm}
[scenarios.slow]
title = "rated load at {slow_percent:g} % of rated speed"
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {low:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]

[scenarios.closed]
# the drive has nothing but the estimates of the observer "{feedback}"
title = "sensorless: driven by {feedback}, rated load at half speed"
drive = {{ feedback = "{feedback}" }}
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {half:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]
"""
_RESERVE = 0.1  # of the flux, so that voltage is left for control at rated speed
_SLOW = 0.1  # of rated speed


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
    if all(name in given for name in _PARAMETERS[1:]) or "preset" in given:
        machine = InductionMachine.build({"n_p": plate.n_p, **given} if "preset" not in given else given, f"{where}: machine")
    else:
        half = [name for name in ("R_r", "L_m", "L_s", "L_r") if name in given]
        if half:
            rest = [name for name in _PARAMETERS[1:] if name not in given]
            raise InputError(f"{where}: [machine] has {', '.join(half)} and lacks {', '.join(rest)}; give all, or leave "
                             "R_r, L_m, L_s and L_r to the plate")
        machine = machine_of(plate, given, f"{where}: nameplate")
    if machine.n_p != plate.n_p:
        raise InputError(f"{where}: machine.n_p = {machine.n_p} does not fit the plate, whose {plate.speed * 30 / math.pi:.4g} "
                         f"rpm at {plate.frequency:g} Hz need {plate.n_p}")
    return plate, machine


def own_text(plate: Nameplate, machine: InductionMachine) -> str:
    """The study as TOML text with comments.

    Raises
    ------
    InputError
        If no gains can be chosen for it.
    """
    from imo_analysis.replay.check import Level
    from imo_analysis.replay.gains import default_bandwidth, default_gains
    from imo_analysis.toml_writer import toml_text

    flux, current = rated_flux(plate, machine)
    flux *= 1 - _RESERVE
    rated = plate.n_p * plate.speed
    level = Level(plate.stator_frequency / 2, flux, NOISE * current)
    bandwidth = default_bandwidth(machine, level, SAMPLE_TIME)
    i_d, z = flux / machine.L_m, flux / machine.L_m + machine.beta * flux
    starts = {"i_ds_hat": i_d, "phi_dr_hat": flux, "z_1_hat": z, "xi_1_hat": z, "alpha_hat": machine.alpha}
    tables = {}
    for kind in OBSERVERS:
        gains = default_gains(kind, machine, level, bandwidth)
        states = _states(kind)
        tables[kind] = {"gains": {name: float(f"{value:.4g}") for name, value in gains.items()},
                        "initial": {name: float(f"{value:.5g}") for name, value in starts.items() if name in states}}
    # a drive knows the direction that it asks for
    observers = toml_text({"observers": {kind: {"kind": kind, "direction": "reference", **tables[kind]} for kind in OBSERVERS}})
    warm = "".join(f"observers.{kind}.errors = {{ R_s = -0.23, R_r = -0.23 }}\n" for kind in OBSERVERS)
    name = machine.name if machine.name != "unnamed" else "my motor"
    return _TEXT.format(
        title=toml_text({"t": name}).split("=", 1)[1].strip(), machine=machine.to_toml(), rated=rated, half=rated / 2,
        low=_SLOW * rated, back=-rated, slow_percent=100 * _SLOW, torque=plate.torque, slip=plate.slip, i_d=i_d, flux=flux,
        reserve=100 * _RESERVE, voltage=plate.phase_voltage, limit=2 * current, noise=level.noise, band=0.02 * rated / 2,
        observers=observers, warm=warm, feedback=OBSERVERS[-1])


def _states(kind: str) -> tuple[str, ...]:
    from imo_analysis.equations.catalogue import OBSERVERS as known

    return known[kind].states
