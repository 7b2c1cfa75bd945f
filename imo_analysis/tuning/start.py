"""The study of one's own motor as text: rated point, observers with gains by the rule of thumb, a wish, nine runs.

The motor comes from a file, with a name plate or with all parameters, or from a preset. What the paper's study says of speeds,
loads, voltages and gains means nothing to another motor. Here all of it goes with the rated point (`imo_analysis.tuning.rated`)
and with the rotor's time constant 1 / alpha; the gains are those that `imo_analysis.tuning.rule` gives for the wish in the same
file. The nine runs ask whether an observer works: idle, under load, with wrong estimates at the start (of the flux, of alpha),
with warm resistances, slowly, braking, and driven by its estimates, with the right stator resistance and with one 5 % off.
"""

from __future__ import annotations

import math
import textwrap
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from imo_analysis.equations.catalogue import OBSERVERS as KNOWN
from imo_analysis.equations.steady_state import slip_of_torque
from imo_analysis.errors import InputError
from imo_analysis.files import read_toml
from imo_analysis.machine import PAPER_PRESETS, PRESETS, InductionMachine, check_tables
from imo_analysis.nameplate import Nameplate, guess, plated, remarks, resistance_range
from imo_analysis.simulation.judge import R_S_OFF
from imo_analysis.study import Study, paper_text
from imo_analysis.study_tuning import Tuning
from imo_analysis.toml_writer import toml_text
from imo_analysis.tuning.rated import Rated
from imo_analysis.tuning.rule import alpha_gains, rule_gains
from imo_analysis.tuning.wish import times_of

OBSERVERS = ("baseline", "baseline_turned", "consistent_12", "repaired", "quiet")
SAMPLE_TIME = 1e-4  # s
SPEED_BANDWIDTH = 45.0  # rad/s, of the drive
NOISE = 0.002  # of the rated current: what a good sensor and twelve bits leave
RECOVERY = 25.0  # rotor time constants, the paper's 2.5 s; the baseline needs up to 23 where R_r and R_s are off
WARM = 1.3
FLUX_AT_START = 0.8  # of the true one: nobody knows the flux of a machine that was running before
_SLOW = 0.1  # of rated speed
_RANGE = (0.2, 0.5)  # of rated speed, for the wish; above that, at 10 kHz, no constant gains of the baseline are fast enough
_ABOVE_SLIP = 3.0  # times the slip: the lowest speed of the wish, ...
_LEAST = 0.4  # ... but no more than this of the rated one

_TEXT = """# A study of your own motor, written by imo study --init. Numbers are SI, or text with a unit: "60.1 mH", "100 us".
# Speeds are electrical: pole pairs times the speed of the shaft.
# Rated: {rated:.4g} rad/s, {torque:.4g} N m, slip {slip:.3g} rad/s,
# {source}.

title = {title}

{machine}
[simulation]
duration = {duration:.1f}        # s
sample_time = {sample_time:g}    # s, the drive's sampling
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
flux = {flux:.5g}             # Wb
current_bandwidth = 1500.0    # rad/s
flux_bandwidth = 30.0         # rad/s
speed_bandwidth = {speed_bandwidth:.1f}        # rad/s
voltage_limit = {voltage:.4g}     # V, phase peak
current_limit = {limit:.4g}     # A, phase peak: twice the rated one
feedback = "measured"         # or the name of an observer below

[sensors]
current_noise = {noise:.3g}     # A, standard deviation of each sample

# Gains by the rule of thumb (imo_analysis.tuning.rule). Adaptive observers are asked for the times of [tuning] with a quarter
# to spare; of the baselines only settling time and lag can be asked, their flux recovers with the rotor. imo tune FILE looks
# for better ones and verifies them, but for baseline_turned. direction: whence the observers have the sign of the speed.
{observers}
[excitation]
window = 0.5    # s
every = 0.1     # s

[poles]
omega = [{low:.4g}, {half:.4g}, {rated:.4g}]                          # rad/s
sweep = {{ start = {back:.4g}, stop = {rated:.4g}, count = 201 }}    # rad/s

{tuning}
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

[scenarios.flux]
# nobody knows the flux at the start
title = "rated load at half speed, estimates of flux {low_percent:.0f} % too low at the start"
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {half:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]
{start_flux}
[scenarios.alpha]
# nor how warm the rotor is
title = "rated load at half speed, estimate of alpha {warm_percent:.0f} % too high at the start"
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {half:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]
{start_alpha}
[scenarios.warm]
# The observers still believe the cold machine, above, whose alpha they start from: 1 / 1.3 - 1 = -0.2308. The drive knows.
title = "rated load at half speed, stator and rotor resistance 30 % up and unknown"
machine = {{ R_s = {warm_s:.5g}, R_r = {warm_r:.5g} }}    # ohm
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {half:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]
{warm}
[scenarios.slow]
title = "rated load at {slow_percent:g} % of rated speed"
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {low:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]

[scenarios.brake]
title = "braking with rated load, down to {least_percent:.0f} % of rated speed"
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, -{torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5, 3.0, 4.0], omega = [0.0, 0.0, {half:.4g}, {half:.4g}, {least:.4g}] }}
windows = [{{ title = "slower", start = 2.9, stop = 5.0, caption = "from half of the rated speed down, driven by the load" }}]

[scenarios.closed]
# The drive has nothing but the estimates of an observer. imo report lets each of them drive once, and draws the run of the one
# that it says to take; here, for imo simulate, stands the first (or --feedback NAME).
title = "sensorless, rated load at half speed"
drive = {{ feedback = "{feedback}" }}
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {half:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]

[scenarios.closed_off]
# the same, the observers believing 5 % more stator resistance than there is; imo sweep FILE --sensorless draws the whole map
title = "sensorless, rated load at half speed, R_s believed {cold_percent:g} % too high"
drive = {{ feedback = "{feedback}" }}
load = {{ time = [0.0, 2.0, 2.2], T_l = [0.0, 0.0, {torque:.4g}] }}
reference = {{ time = [0.0, 0.3, 1.5], omega = [0.0, 0.0, {half:.4g}] }}
windows = [{{ title = "load comes on", start = 1.9, stop = 3.0, caption = "0 to rated torque" }}]
{cold}"""
_TUNING = """[tuning]
# imo tune FILE --plot tuned.svg --out tuned.toml: gains that meet this wish over the whole range, loads of either sign, and
# what the observers may have wrong. Found on the exact linearisations, verified on simulations.
# Up to half of rated speed: above, the baseline meets no such wish at this sampling. From three times the rated slip, or a
# fifth of rated speed: where the machine brakes with a stator frequency near zero nothing determines the speed.
omega = [{least:.4g}, {half:.4g}]     # rad/s, electrical
torque = {torque:.4g}           # N m, driving and braking: the rated one
settling_time = 0.015     # s; after a step of the speed its estimate is within 2 %
recovery_time = {recovery:.3g}     # s; four time constants of the slowest error: {constants:g} / alpha, as in the paper's study
lag = 0.001               # s; behind an even acceleration, in rad/s for 1 rad/s^2
damping = 0.5             # of the speed estimate, by its overshoot
uncertainty = {{ R_s = 0.05, R_r = 0.2 }}    # relative, either sign; also L_m, L_s, L_r
# speed_noise = 0.1       # rad/s; as little as the rest allows where left out
# speed_error = 2.0       # rad/s at rest, from the uncertainty; reported only where left out
"""


def study_of(name: str, flux: float | None = None) -> str:
    """The study of the motor in a file, or of a preset, as ``imo study --init`` writes it.

    Parameters
    ----------
    name : str
        A file with ``[machine]``, or ``[nameplate]`` and what is known of ``[machine]``; or a preset.
    flux : float, optional
        Magnitude of the rotor flux in Wb; for a motor without a plate.

    Raises
    ------
    InputError
        If the file cannot be read, or no such motor can be.
    """
    if name in PAPER_PRESETS and flux is None:  # the paper's levels and gains are theirs
        return paper_text().replace('preset = "table-iii-printed-alpha"', f'preset = "{name}"')
    if name in PRESETS:
        return study_text(PRESETS[name], flux)
    data = read_toml(name)
    check_tables(data, name)
    if "nameplate" not in data:
        return study_text(_unplated(name, data), flux)
    if flux is not None:
        raise InputError(f"--flux {flux:g} cannot be given with a [nameplate], which gives the flux; leave one of them out")
    plate, machine = plated(data, name)
    if not {"R_s", "preset"} & set(data.get("machine", {})):
        machine = machine.model_copy(update={"source": f"{machine.source}; {guess(*resistance_range(plate))}"})
    head, newline, rest = study_text(machine, plate=plate).partition("\n\n")
    said = [f"# {line}" for text in remarks_of(name) for line in textwrap.wrap(f"Plate: {text}.", 118)]
    return "\n".join([head, *said]) + newline + rest


def remarks_of(name: str) -> list[str]:
    """What there is to say of the plate in a file, in sentences; nothing of a file without one.

    Parameters
    ----------
    name : str
        The file, or a preset.
    """
    data = {} if name in PRESETS else read_toml(name)
    return remarks(plated(data, name)[0], data.get("machine", {})) if "nameplate" in data else []


def _unplated(name: str, data: Mapping[str, Any]) -> InductionMachine:
    try:
        return InductionMachine.load(name)
    except InputError as error:
        if " is missing" not in str(error):
            raise
        known = "R_s, R_r, L_m, L_s, L_r, n_p and J in [machine]"
        if not data.get("machine"):
            raise InputError(f"{name} has no motor in it: write a [nameplate] with power, voltage, current, frequency, speed "
                             f"and power_factor, and J in [machine]; or {known}") from None
        raise InputError(f"{error}; give all of {known}, or leave R_s, R_r, L_m, L_s, L_r and n_p to a [nameplate]") from None


def study_text(machine: InductionMachine, flux: float | None = None, plate: Nameplate | None = None) -> str:
    """The study of a machine as commented TOML, checked with all its scenarios.

    Parameters
    ----------
    machine : InductionMachine
        Any.
    flux : float, optional
        Magnitude of the rotor flux in Wb that the drive keeps; typical of such a machine where left out.
    plate : Nameplate, optional
        Gives the rated point, and ``flux`` is not used.

    Raises
    ------
    InputError
        If the flux is not one, or the machine cannot be used.
    """
    point = Rated.of_plate(plate, machine) if plate else Rated.typical(machine, flux)
    flux = point.flux
    recovery = float(f"{RECOVERY / machine.alpha:.3g}")
    slip = float(slip_of_torque(point.torque, flux, machine.n_p, machine.L_r, machine.alpha))
    low, half = _SLOW * point.omega, _RANGE[1] * point.omega
    least = min(max(_RANGE[0] * point.omega, _ABOVE_SLIP * slip), _LEAST * point.omega)
    duration = max(6.0, float(math.ceil(2.5 + 10 / machine.alpha)))  # load comes on at 2 s; the baseline's flux takes 4 / alpha
    tuning = _TUNING.format(least=least, half=half, torque=point.torque, recovery=recovery, constants=RECOVERY)
    name = machine.name if machine.name.isprintable() and machine.name not in ("", "unnamed") else "my motor"
    low_flux = _right(machine, flux, FLUX_AT_START)
    believed = f"errors = {{ R_s = {1 / WARM - 1:.4f}, R_r = {1 / WARM - 1:.4f} }}"
    text = _TEXT.format(
        title=toml_text({"t": name[:200]}).split("=", 1)[1].strip(), machine=machine.to_toml(), rated=point.omega, half=half,
        low=low, back=-point.omega, slow_percent=100 * _SLOW, least=least,
        least_percent=100 * least / point.omega, torque=point.torque, slip=point.slip, source=point.source,
        sample_time=SAMPLE_TIME, speed_bandwidth=SPEED_BANDWIDTH, i_d=flux / machine.L_m, flux=flux, voltage=point.voltage,
        limit=2 * point.current, noise=NOISE * point.current, band=0.02 * half, duration=duration, tuning=tuning,
        warm_s=WARM * machine.R_s, warm_r=WARM * machine.R_r, observers=_observers(machine, flux, point.omega, tuning),
        warm="".join(f"observers.{kind}.{believed}\n" for kind in OBSERVERS), feedback=OBSERVERS[0],
        cold="".join(f"observers.{kind}.errors = {{ R_s = {R_S_OFF:g} }}\n" for kind in OBSERVERS), cold_percent=100 * R_S_OFF,
        low_percent=100 * (1 - FLUX_AT_START), warm_percent=100 * (WARM - 1),
        start_flux=_starts({state: low_flux[state] for state in ("phi_dr_hat", "z_1_hat", "xi_1_hat")}),
        start_alpha=_starts({"alpha_hat": WARM * machine.alpha}))
    Study.from_toml(text, "the study of this motor")
    return text


def _right(machine: InductionMachine, flux: float, share: float = 1.0) -> dict[str, float]:
    """The states of a magnetised machine at standstill as estimates, those that have the flux in them with a share of it."""
    z = flux / machine.L_m + share * machine.beta * flux
    return {"i_ds_hat": flux / machine.L_m, "phi_dr_hat": share * flux, "z_1_hat": z, "xi_1_hat": z, "alpha_hat": machine.alpha}


def _starts(values: dict[str, float]) -> str:
    """Lines of a scenario in which these estimates start so."""
    wrong = {kind: ", ".join(f"{state} = {value:.5g}" for state, value in values.items() if state in KNOWN[kind].states)
             for kind in OBSERVERS}
    return "".join(f"observers.{kind}.initial = {{ {one} }}\n" for kind, one in wrong.items() if one)


def _observers(machine: InductionMachine, flux: float, omega: float, tuning: str) -> str:
    """Their tables: gains by the rule for the wish, magnetised at the start."""
    times = times_of(Tuning(**tomllib.loads(tuning)["tuning"]), SPEED_BANDWIDTH, SAMPLE_TIME)
    starts, tables = _right(machine, flux), {}
    for kind in OBSERVERS:
        gains = rule_gains(machine, kind, flux, times)
        if "g" in gains:  # the runs go up to rated speed, and alpha_hat with them
            gains |= alpha_gains(machine, kind, flux, gains["K_p"], replace(times, omega_max=omega))
        tables[kind] = {
            "kind": kind, "direction": "reference",  # a drive knows the direction that it asks for
            "gains": {gain: float(f"{value:.5g}") for gain, value in gains.items()},
            "initial": {state: float(f"{value:.5g}") for state, value in starts.items() if state in KNOWN[kind].states}}
    return toml_text({"observers": tables})
