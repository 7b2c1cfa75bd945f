"""The loop over samples: drive, machine and observers as one ordinary differential equation under a held voltage, by RK4.

The text of the entry is generated for a composition (`Loop`), since numba unrolls tuples of a fixed length only. It holds
no equation: those it calls by name.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.simulation import compile as compiler
from imo_analysis.simulation import drive, loaded_machine

PLANT_STATES = ("i_ds", "i_qs", "phi_dr", "phi_qr", "omega")
APPLIED = ("u_ds", "u_qs")
MEASURED = ("i_ds_meas", "i_qs_meas")
# rows of the array of inputs, one column a sample
INPUTS = ("omega_ref", "flux_ref", "T_l", "noise_d", "noise_q")


@dataclass(frozen=True)
class Loop:
    """What a kernel is made of.

    Attributes
    ----------
    observers : tuple of str
        Kinds of the observers that run along, in the order of their states in the output.
    feedback : bool
        Whether the drive takes speed and flux from the first of them, instead of true speed and its own flux model.
    """

    observers: tuple[str, ...] = ()
    feedback: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the output's columns; those of observer n end in ``@n``."""
        states = tuple(f"{state}@{n}" for n, kind in enumerate(self.observers) for state in OBSERVERS[kind].states)
        return (*PLANT_STATES, *APPLIED, *MEASURED, *states)


@cache
def kernel(loop: Loop) -> Any:
    """The compiled entry of a composition.

    ``run(start, samples, every, T, substeps, bound, x, c, inputs, sensor, p, friction, d, out, lost, o_0, p_0, g_0, o_1, ...)``
    advances ``samples`` samples and returns how many it did: fewer when the machine, or the observer that the drive listens
    to, leaves ``bound`` (the sum of the sizes of its states). Other observers do not stop the run.

    Parameters of ``run``
    ---------------------
    start : int
        Number of the first sample; ``every`` counts from sample 0 of the run.
    x, c, o_n : ndarray
        States of machine (5), drive (7: `drive.CONTROL_STATES`, own flux and its last rate) and observers; changed.
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
    return compiler.entry(source(loop), functions)


def source(loop: Loop) -> str:
    """The text of the entry of a composition."""
    sizes = [len(OBSERVERS[kind].states) for kind in loop.observers]
    each = range(len(sizes))
    arguments = "".join(f", o_{n}, p_{n}, g_{n}" for n in each)
    if loop.feedback:
        speed = OBSERVERS[loop.observers[0]].states.index("omega_hat")
        feedback = [f"speed = y_0[{speed}]", "flux = flux_estimate(y_0, seen, p_0[3])"]
    else:
        feedback = ["speed = x[4]"]
    values = ["x[0]", "x[1]", "x[2]", "x[3]", "x[4]", "u[0]", "u[1]", "seen[0]", "seen[1]"]
    values += [f"y_{n}[{j}]" for n in each for j in range(sizes[n])]
    lines = [
        *combine(5, *sizes),
        f"def rates(x, u, direction, T_l, held, sensor, p, friction{''.join(f', y_{n}, p_{n}, g_{n}' for n in each)}):",
        "    i = (sensor[0] * x[0] + held[0], sensor[1] * x[1] + held[1])",
        "    return (machine_rates(x, u, T_l, p, friction),"
        + "".join(f" rates_{n}(y_{n}, i, u, direction, p_{n}, g_{n})," for n in each) + ")",
        "", "",
        '@njit(cache=True, error_model="numpy", nogil=True)',
        f"def run(start, samples, every, T, substeps, bound, x_0, c_0, inputs, sensor, p, friction, d, out, lost{arguments}):",
        f"    x = {_tuple('x_0', 5)}",
        f"    c = {_tuple('c_0', 3)}",
        "    flux = (c_0[3], c_0[4])",
        "    flow = (c_0[5], c_0[6])",
        *[f"    y_{n} = {_tuple(f'o_{n}', sizes[n])}" for n in each],
        "    h = T / substeps",
        "    row = 0",
        "    wait = -start % every",
        "    done = samples",
        "    continuous = (sensor[0] * (1.0 - sensor[4]), sensor[1] * (1.0 - sensor[4]))",
        "    for k in range(samples):",
        *_watch(sizes, loop.feedback),
        "        error = (sensor[2] + inputs[3, k], sensor[3] + inputs[4, k])",
        "        seen = (sensor[0] * x[0] + error[0], sensor[1] * x[1] + error[1])",
        *[f"        {line}" for line in feedback],
        "        u, c = control(c, seen, speed, flux, inputs[0, k], inputs[1, k], p, d)",
        *([] if loop.feedback else ["        flux, flow = flux_model(flux, flow, seen, speed, T, p)"]),
        "        if wait == 0:",
        *[f"            out[row, {column}] = {value}" for column, value in enumerate(values)],
        "            row += 1",
        "            wait = every",
        "        wait -= 1",
        "        T_l = inputs[2, k]",
        "        direction = direction_of(x[4])",
        "        held = (seen[0] if sensor[4] > 0.5 else error[0], seen[1] if sensor[4] > 0.5 else error[1])",
        "        for _ in range(substeps):",
        *[f"            {line}" for line in rk4(sizes)],
        *[f"    x_0[{j}] = x[{j}]" for j in range(5)],
        *[f"    c_0[{j}] = c[{j}]" for j in range(3)],
        "    c_0[3], c_0[4], c_0[5], c_0[6] = flux[0], flux[1], flow[0], flow[1]",
        *[f"    o_{n}[{j}] = y_{n}[{j}]" for n in each for j in range(sizes[n])],
        "    return done",
        "",
    ]
    return "\n".join(lines)


def rk4(sizes: list[int]) -> list[str]:
    """One classical Runge-Kutta step of all states together."""
    names = ["x", *(f"y_{n}" for n in range(len(sizes)))]
    widths = [5, *sizes]
    lines = []
    places = ("{0}", "move_{1}({0}, h / 2, k_1[{2}])", "move_{1}({0}, h / 2, k_2[{2}])", "move_{1}({0}, h, k_3[{2}])")
    for stage, at in enumerate(places, 1):
        x, *rest = [at.format(name, width, n) for n, (name, width) in enumerate(zip(names, widths, strict=True))]
        more = "".join(f", {value}, p_{n}, g_{n}" for n, value in enumerate(rest))
        lines.append(f"k_{stage} = rates({x}, u, direction, T_l, held, continuous, p, friction{more})")
    for n, (name, width) in enumerate(zip(names, widths, strict=True)):
        lines.append(f"{name} = step_{width}({name}, h / 6, k_1[{n}], k_2[{n}], k_3[{n}], k_4[{n}])")
    return lines


def _watch(sizes: list[int], feedback: bool) -> list[str]:
    """Notice states out of bound, NaN included; what the drive needs ends the run."""
    lines = []
    for entry, (name, width) in enumerate([("x", 5), *((f"y_{n}", size) for n, size in enumerate(sizes))]):
        size = sum_of([f"abs({name}[{j}])" for j in range(width)])
        lines += [f"        if lost[{entry}] < 0 and not {size} < bound:", f"            lost[{entry}] = start + k"]
        if entry == 0 or (entry == 1 and feedback):
            lines += ["            done = k", "            break"]
    return lines


def combine(*widths: int) -> list[str]:
    """The two combinations of states and rates that RK4 needs, for each number of states."""
    lines = []
    for width in sorted(set(widths)):
        moved = ", ".join(f"y[{j}] + h * k[{j}]" for j in range(width))
        stepped = ", ".join(f"y[{j}] + h * (a[{j}] + 2.0 * (b[{j}] + c[{j}]) + d[{j}])" for j in range(width))
        for head, body in ((f"move_{width}(y, h, k)", moved), (f"step_{width}(y, h, a, b, c, d)", stepped)):
            lines += ['@njit(forceinline=True, error_model="numpy")', f"def {head}:", f"    return ({body})", "", ""]
    lines.append('@njit(forceinline=True, error_model="numpy")')
    return lines


def _tuple(name: str, size: int) -> str:
    return "(" + ", ".join(f"{name}[{j}]" for j in range(size)) + ")"


def sum_of(terms: list[str]) -> str:
    """A sum as a balanced tree: short chains of dependent additions."""
    if len(terms) == 1:
        return terms[0]
    half = len(terms) // 2
    return f"({sum_of(terms[:half])} + {sum_of(terms[half:])})"
