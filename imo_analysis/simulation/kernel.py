"""The loop over samples: drive, machine and observers as one ordinary differential equation, the voltage held.

The text of the entry is generated for a composition (`Loop`), since numba unrolls tuples of a fixed length only. It holds
no equation: those it calls by name.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from imo_analysis import compile as compiler
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.simulation import drive, inverter, loaded_machine, runge_kutta, saturated_machine, sensor, shaft

PLANT_STATES = ("i_ds", "i_qs", "phi_dr", "phi_qr", "omega")
APPLIED = ("u_ds", "u_qs")
MEASURED = ("i_ds_meas", "i_qs_meas")
# rows of the array of inputs, one column a sample
INPUTS = ("omega_ref", "flux_ref", "T_l", "noise_d", "noise_q")
TOLD = ("u_ds_told", "u_qs_told")
STATOR_FLUX = ("psi_ds", "psi_qs")


@dataclass(frozen=True)
class Loop:
    """What a kernel is made of.

    Attributes
    ----------
    observers : tuple of str
        Kinds of the observers that run along, in the order of their states in the output.
    feedback : bool
        Whether the drive takes speed and flux from the first of them, instead of true speed and its own flux model.
    delay : bool
        Whether a voltage is applied one sample after the measurement that it was computed from.
    inverter : str
        Empty, ``average`` or ``switched``: `simulation.inverter`.
    quantised : bool
        Whether measured currents are rounded.
    believes : bool
        Whether the drive believes another machine than there is.
    coulomb, two_mass : bool
        `simulation.shaft`.
    saturated : bool
        Whether the machine is that of `simulation.saturated_machine`; the first two entries of ``x`` are then stator fluxes.
    directions : tuple of str
        Whence each observer has the direction: ``true``, ``reference``, ``estimate``. Empty where all have the true one.
    order : int
        Order of the integrator: `simulation.runge_kutta`.
    """

    observers: tuple[str, ...] = ()
    feedback: bool = False
    delay: bool = False
    inverter: str = ""
    quantised: bool = False
    believes: bool = False
    coulomb: bool = False
    two_mass: bool = False
    saturated: bool = False
    directions: tuple[str, ...] = ()
    order: int = 4

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the output's columns; those of observer n end in ``@n``."""
        states = tuple(f"{state}@{n}" for n, kind in enumerate(self.observers) for state in OBSERVERS[kind].states)
        return (*PLANT_STATES, *APPLIED, *MEASURED, *states, *self.more_columns)

    @property
    def more_columns(self) -> tuple[str, ...]:
        """Columns after the observers': what only this composition has."""
        more = ((TOLD if self.inverter else ()), ("omega_load", "shaft_torque") if self.two_mass else (),
                STATOR_FLUX if self.saturated else ())
        return tuple(name for names in more for name in names)

    @property
    def width(self) -> int:
        """Number of states of the machine and its shaft."""
        return 7 if self.two_mass else 5

    @property
    def control_width(self) -> int:
        """Length of ``c``: that of `kernel`, and the voltage that waits where there is a delay."""
        return 9 if self.delay else 7

    @property
    def extras(self) -> tuple[str, ...]:
        """Arguments of the entry, tuples of numbers, that only this composition has; they come after ``lost``.

        ``believed`` as ``p``; ``bridge``, ``step``, ``coulomb``, ``shaft`` and ``curve`` as in the modules that `Loop` names.
        """
        has = {"believed": self.believes, "bridge": bool(self.inverter), "step": self.quantised, "coulomb": self.coulomb,
               "shaft": self.two_mass, "curve": self.saturated}
        return tuple(name for name, on in has.items() if on)


def plain(loop: Loop) -> bool:
    """Whether a composition is one that `lanes` has too: observers, feedback, and one and the same direction for all.

    Where that is the estimate's own, one observer alone.
    """
    return (loop == Loop(loop.observers, loop.feedback, directions=loop.directions) and len(set(loop.directions)) <= 1
            and (len(loop.observers) == 1 or "estimate" not in loop.directions))


@cache
def kernel(loop: Loop) -> Any:
    """The compiled entry of a composition.

    ``run(start, samples, every, T, substeps, bound, x, c, inputs, sensor, p, friction, d, out, lost, ..., o_0, p_0, g_0, ...)``
    advances ``samples`` samples and returns how many it did: fewer when the machine, or the observer that the drive listens
    to, leaves ``bound`` (the sum of the sizes of its states). Other observers do not stop the run.

    Parameters of ``run``
    ---------------------
    start : int
        Number of the first sample; ``every`` counts from sample 0 of the run.
    x, c, o_n : ndarray
        States of machine (`Loop.width`), drive (`drive.CONTROL_STATES`, own flux and its last rate, the voltage that waits)
        and observers; changed.
    inputs : ndarray, shape (5, samples)
        As named in `INPUTS`.
    sensor : tuple of 5
        Gain and offset of each current, and 1 where the observers see samples, 0 where they see currents continuously.
    p, d, p_n, g_n : tuples of float
        Parameters of machine, drive, and each observer with its gains.
    friction : float
        As in `loaded_machine.machine_rates`.
    out : ndarray, shape (records, columns)
        Filled from row 0.
    lost : ndarray of int, shape (1 + observers,)
        -1, or the first sample at which the machine (entry 0) or an observer was out of bound; changed.
    """
    functions: dict[str, Any] = {"machine_rates": loaded_machine.machine_rates, "direction_of": loaded_machine.direction_of,
                 "control": drive.control, "flux_model": drive.flux_model}
    for n, kind in enumerate(loop.observers):
        functions[f"rates_{n}"] = OBSERVERS[kind].rates
    if loop.feedback:
        functions["flux_estimate"] = OBSERVERS[loop.observers[0]].flux
    if loop.inverter:
        functions |= {"reachable": inverter.reachable, "pulses": inverter.pulses, "mean_voltage": inverter.mean_voltage}
    if loop.inverter == "switched":
        functions |= {"edges": inverter.edges, "bridge_voltage": inverter.bridge_voltage}
    if loop.quantised:
        functions["quantised"] = sensor.quantised
    if loop.coulomb:
        functions["coulomb_torque"] = shaft.coulomb_torque
    if loop.two_mass:
        functions |= {"shaft_torque": shaft.shaft_torque, "shaft_rates": shaft.shaft_rates}
    if loop.saturated:
        functions |= {"machine_rates": saturated_machine.loaded, "stator_current": saturated_machine.stator_current}
    return compiler.entry(source(loop), functions)


def source(loop: Loop) -> str:
    """The text of the entry of a composition."""
    sizes = [len(OBSERVERS[kind].states) for kind in loop.observers]
    each = range(len(sizes))
    width, extras = loop.width, "".join(f", {name}" for name in loop.extras)
    arguments = "".join(f", o_{n}, p_{n}, g_{n}" for n in each)
    if loop.feedback:
        speed = OBSERVERS[loop.observers[0]].states.index("omega_hat")
        feedback = [f"speed = y_0[{speed}]", "flux = flux_estimate(y_0, seen, p_0[3])"]
    else:
        feedback = ["speed = x[4]"]
    i_d, i_q = ("current[0]", "current[1]") if loop.saturated else ("x[0]", "x[1]")
    believed = "believed" if loop.believes else "p"
    lines = [
        *runge_kutta.functions(loop.order, (width, *sizes)),
        runge_kutta.INLINE,
        *_rates(loop, len(sizes)),
        "", "",
        '@njit(cache=True, error_model="numpy", nogil=True)',
        "def run(start, samples, every, T, substeps, bound, x_0, c_0, inputs, sensor, p, friction, d, out, lost"
        f"{extras}{arguments}):",
        f"    x = {_tuple('x_0', width)}",
        f"    c = {_tuple('c_0', 3)}",
        "    flux = (c_0[3], c_0[4])",
        "    flow = (c_0[5], c_0[6])",
        *(["    waiting = (c_0[7], c_0[8])"] if loop.delay else []),
        *[f"    y_{n} = {_tuple(f'o_{n}', sizes[n])}" for n in each],
        "    h = T / substeps",
        "    row = 0",
        "    wait = -start % every",
        "    done = samples",
        "    continuous = (sensor[0] * (1.0 - sensor[4]), sensor[1] * (1.0 - sensor[4]))",
        "    for k in range(samples):",
        *_watch([width, *sizes], loop.feedback),
        "        error = (sensor[2] + inputs[3, k], sensor[3] + inputs[4, k])",
        *(["        current = stator_current(x, curve)"] if loop.saturated else []),
        f"        seen = (sensor[0] * {i_d} + error[0], sensor[1] * {i_q} + error[1])",
        *([
            "        seen = (quantised(seen[0], step[0]), quantised(seen[1], step[0]))",
            f"        error = (seen[0] - sensor[0] * {i_d}, seen[1] - sensor[1] * {i_q})",
        ] if loop.quantised else []),
        *[f"        {line}" for line in feedback],
        f"        u, c = control(c, seen, speed, flux, inputs[0, k], inputs[1, k], {believed}, d)",
        *([] if loop.feedback else [f"        flux, flow = flux_model(flux, flow, seen, speed, T, {believed})"]),
        *(["        u, waiting = waiting, u"] if loop.delay else []),
        *([
            "        told = reachable(u, bridge)",
            f"        on, off = pulses(told, ({i_d}, {i_q}), bridge)",
            "        u = mean_voltage(on, off, bridge)",
        ] if loop.inverter else []),
        "        if wait == 0:",
        *[f"            out[row, {column}] = {value}" for column, value in enumerate(_values(loop, sizes, i_d, i_q))],
        "            row += 1",
        "            wait = every",
        "        wait -= 1",
        "        T_l = inputs[2, k]",
        f"        direction = {_direction(loop)}",
        "        held = (seen[0] if sensor[4] > 0.5 else error[0], seen[1] if sensor[4] > 0.5 else error[1])",
        *_advance(loop, sizes),
        *[f"    x_0[{j}] = x[{j}]" for j in range(width)],
        *[f"    c_0[{j}] = c[{j}]" for j in range(3)],
        "    c_0[3], c_0[4], c_0[5], c_0[6] = flux[0], flux[1], flow[0], flow[1]",
        *(["    c_0[7], c_0[8] = waiting[0], waiting[1]"] if loop.delay else []),
        *[f"    o_{n}[{j}] = y_{n}[{j}]" for n in each for j in range(sizes[n])],
        "    return done",
        "",
    ]
    return "\n".join(lines)


def _values(loop: Loop, sizes: list[int], i_d: str, i_q: str) -> list[str]:
    """What stands in the columns of a record."""
    values = [i_d, i_q, "x[2]", "x[3]", "x[4]", "u[0]", "u[1]", "seen[0]", "seen[1]"]
    values += [f"y_{n}[{j}]" for n, size in enumerate(sizes) for j in range(size)]
    more = {**dict(zip(TOLD, ("told[0]", "told[1]"), strict=True)), "omega_load": "x[5]",
            "shaft_torque": "shaft_torque(x[4], x[5], x[6], shaft)", **dict(zip(STATOR_FLUX, ("x[0]", "x[1]"), strict=True))}
    return values + [more[name] for name in loop.more_columns]


def _rates(loop: Loop, observers: int) -> list[str]:
    """The function of all rates: machine and shaft, then observers."""
    each = range(observers)
    told = "told" if loop.inverter else "u"
    i_d, i_q = ("current[0]", "current[1]") if loop.saturated else ("x[0]", "x[1]")
    carried = "shaft_torque(x[4], x[5], x[6], shaft)" if loop.two_mass else "T_l"
    if loop.coulomb:
        carried += " + coulomb_torque(x[4], coulomb)"
    state = "x[:5]" if loop.two_mass else "x"
    machine = f"machine_rates({state}, u, {carried}, {'curve' if loop.saturated else 'p'}, friction)"
    if loop.two_mass:
        machine += " + shaft_rates(x[4], x[5], x[6], T_l, shaft)"
    directions = [f"direction[{n}]" if loop.directions else "direction" for n in each]
    return [
        f"def rates(x, u, {'told, ' if loop.inverter else ''}direction, T_l, held, sensor, p, friction{_physics(loop)}"
        + "".join(f", y_{n}, p_{n}, g_{n}" for n in each) + "):",
        *(["    current = stator_current(x, curve)"] if loop.saturated else []),
        f"    i = (sensor[0] * {i_d} + held[0], sensor[1] * {i_q} + held[1])",
        f"    return ({machine},"
        + "".join(f" rates_{n}(y_{n}, i, {told}, {directions[n]}, p_{n}, g_{n})," for n in each) + ")",
    ]


def _physics(loop: Loop) -> str:
    """Those extra arguments that the rates need."""
    return "".join(f", {name}" for name in loop.extras if name in ("coulomb", "shaft", "curve"))


def _direction(loop: Loop) -> str:
    """What each observer is told of the direction of rotation."""
    if not loop.directions:
        return "direction_of(x[4])"
    source = {"true": "x[4]", "reference": "inputs[0, k]"}
    of = [source.get(whence) or f"y_{n}[{OBSERVERS[loop.observers[n]].states.index('omega_hat')}]"
          for n, whence in enumerate(loop.directions)]
    return "(" + "".join(f"direction_of({value}), " for value in of) + ")"


def _advance(loop: Loop, sizes: list[int]) -> list[str]:
    """From one sample to the next: steps under one voltage, or under each of those that the inverter switches through."""
    each = [f"y_{n}" for n in range(len(sizes))]
    observers = "".join(f", {{{name}}}, p_{n}, g_{n}" for n, name in enumerate(each))
    step = runge_kutta.step(
        loop.order, dict(zip(("x", *each), (loop.width, *sizes), strict=True)),
        f"rates({{x}}, u, {'told, ' if loop.inverter else ''}direction, T_l, held, continuous, p, friction"
        f"{_physics(loop)}{observers})")
    if loop.inverter != "switched":
        return ["        for _ in range(substeps):", *[f"            {line}" for line in step]]
    return [
        "        edge = edges(on, off, bridge)",
        "        for _ in range(int(bridge[3])):",
        "            for piece in range(7):",
        "                h = (edge[piece + 1] - edge[piece]) / substeps",
        "                u = bridge_voltage(0.5 * (edge[piece] + edge[piece + 1]), on, off, bridge)",
        "                for _ in range(substeps):",
        *[f"                    {line}" for line in step],
    ]


def _watch(widths: list[int], feedback: bool) -> list[str]:
    """Notice states out of bound, NaN included; what the drive needs ends the run."""
    lines = []
    for entry, width in enumerate(widths):
        name = f"y_{entry - 1}" if entry else "x"
        size = sum_of([f"abs({name}[{j}])" for j in range(width)])
        lines += [f"        if lost[{entry}] < 0 and not {size} < bound:", f"            lost[{entry}] = start + k"]
        if entry == 0 or (entry == 1 and feedback):
            lines += ["            done = k", "            break"]
    return lines


def _tuple(name: str, size: int) -> str:
    return "(" + ", ".join(f"{name}[{j}]" for j in range(size)) + ")"


def sum_of(terms: list[str]) -> str:
    """A sum as a balanced tree: short chains of dependent additions."""
    if len(terms) == 1:
        return terms[0]
    half = len(terms) // 2
    return f"({sum_of(terms[:half])} + {sum_of(terms[half:])})"
