"""The loop over samples for sixteen machines at once: the composition of `kernel`, written so that it becomes vector code.

What lets LLVM vectorise: one flat buffer with a width known at compile time, no branch and no call in a loop over lanes, and
`trace`, which moves what is constant out of the loop. The definitions are the ones of `kernel`. Two things make results differ
from it in the last digits: `trace` multiplies with reciprocals, and products are fused into sums where the processor can, which
is worth a seventh of the time (a test holds the two to 1e-12). From run to run on one kind of processor they are the same to
the bit, wherever in a batch a machine stands. Only summaries (`tally`) are kept: a run of any length needs the same memory.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from imo_analysis import compile as compiler
from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS
from imo_analysis.simulation import drive, loaded_machine
from imo_analysis.simulation.kernel import Loop, sum_of
from imo_analysis.simulation.runge_kutta import INLINE
from imo_analysis.sweeps import tally
from imo_analysis.sweeps.trace import CONSTANT, HELD, LIVE, Trace, Value, statements

WIDTH = 16
MACHINE = ("R_s", "L_m", "sigma", "beta", "alpha", "mu", "n_p", "J")
DRIVE = ("T", "current_bandwidth", "flux_bandwidth", "speed_bandwidth", "voltage_limit", "current_limit", "flux_floor")
OUTSIDE = ("flux", "flux_modulation", "gain_d", "gain_q", "offset_d", "offset_q")
MACHINE_STATES = 5
CONTROL = ("integral_d", "integral_q", "integral_speed", "phi_d", "phi_q", "flow_d", "flow_q")
_HELD = ("u_ds", "u_qs", "T_l", "direction", "held_d", "held_q", "seen_d", "seen_q")


class Lanes:
    """A composition for `WIDTH` machines: where its rows are, what its constants are, and its compiled entry.

    The entry ``run(start, samples, every, h, substeps, bound, window, band, sampled, piece, share, sine, noise, tables, rows)``
    advances ``samples`` samples and changes ``rows``. Its arguments:

    start, samples, every : int
        As in `kernel`; the tally is kept at every record.
    h : float
        Step of the integrator in s.
    window : tuple of 2
        Numbers of the first sample of the tally and of the one after its last.
    band : float
        Largest speed error in rad/s that counts as none.
    sampled : float
        1 where the observers see samples, 0 where they see currents continuously.
    piece, share : ndarray, shape (2, samples)
        Row of ``tables`` with the entry of omega_ref and of T_l in force, and how far it is on its way to the next.
    sine, noise : ndarray, shapes (samples,) and (2, samples)
        Of the flux modulation, and of the currents.
    tables, rows : ndarray
        Flat, `WIDTH` numbers a row. The last entry of each table stands twice.

    Attributes
    ----------
    constants : list of Value
        What the first rows hold, to be had from `trace.evaluated` with the names of `MACHINE`, ``friction``, `DRIVE`,
        `OUTSIDE`, ``sampled``, and ``name@n`` for parameters and gains of observer n.
    control, states, tally : int, int, tuple of int
        First row of the drive's states (`CONTROL`), of all states (machine, observers), of each tally (machine, observers).
    tally_names : tuple of tuple of str
        Names of the rows of each tally.
    rows : int
        Number of rows.
    """

    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        self.kinds = [OBSERVERS[kind] for kind in loop.observers]
        self._trace = Trace()
        self._inputs: dict[str, Value] = {}
        self.constants: list[Value] = []
        control = self._control_lines()
        parts = [self._machine_lines(), *(self._observer_lines(n) for n in range(len(self.kinds)))]
        tallies = self._tally_lines()
        outside = {name: self._row_of(value) for name, value in zip(OUTSIDE, self._constants(OUTSIDE), strict=True)}
        self.control = len(self.constants)
        self._held = self.control + len(CONTROL)
        self.states = self._held + len(_HELD) + 8
        self.tally_names = (tally.MACHINE, *(
            tally.OBSERVER + (tally.REGRESSOR if "xi_1_hat" in kind.states else ()) for kind in self.kinds))
        row = self.states + self._count()
        places = []
        for names in self.tally_names:
            places.append(row)
            row += len(names)
        self.tally = tuple(places)
        self.rows = row
        self.source = self._source(outside, control, parts, tallies)

    @property
    def run(self) -> Any:
        """The compiled entry."""
        functions: dict[str, Callable[..., Any]] = {
            "direction_of": loaded_machine.direction_of,
            "watched": tally.watched, "tallied": tally.tallied, "excited": tally.excited,
            **{f"flux_{n}": kind.flux for n, kind in enumerate(self.kinds)},
        }
        return compiler.entry(self.source, functions, fused=True)

    # Values --------------------------------------------------------------------------------------------------------
    def _constants(self, names: tuple[str, ...]) -> tuple[Value, ...]:
        return self._trace.inputs(names, CONSTANT)

    def _row_of(self, value: Value) -> str:
        """The text that reads a constant's row."""
        if value not in self.constants:
            self.constants.append(value)
        return _at(str(self.constants.index(value)))

    def _observer(self, n: int) -> tuple[tuple[Value, ...], tuple[Value, ...]]:
        """Parameters and gains of observer n."""
        return (self._constants(tuple(f"{name}@{n}" for name in PARAMETERS)),
                self._constants(tuple(f"{name}@{n}" for name in self.kinds[n].gains)))

    def _count(self) -> int:
        return MACHINE_STATES + sum(len(kind.states) for kind in self.kinds)

    def _first(self, n: int) -> int:
        """Number of the first state of observer n."""
        return MACHINE_STATES + sum(len(kind.states) for kind in self.kinds[:n])

    # Text ----------------------------------------------------------------------------------------------------------
    def _control_lines(self) -> list[str]:
        """One sample of the drive: feedback, voltage, the drive's own flux."""
        trace = self._trace
        p, d = self._constants(MACHINE), self._constants(DRIVE)
        names: dict[int, str] = {}

        def live(*texts: str) -> tuple[Value, ...]:
            values = trace.inputs(texts, LIVE)
            names.update({id(value): text for value, text in zip(values, texts, strict=True)})
            return values

        state = live(*(f"rows[CONTROL{j} + l]" for j in range(3)))
        own = live(*(f"rows[CONTROL{j} + l]" for j in range(3, 7)))
        seen = live("seen_d", "seen_q")
        if self.loop.feedback:
            y = live(*(f"rows[STATE{self._first(0) + j} + l]" for j in range(len(self.kinds[0].states))))
            speed = y[self.kinds[0].states.index("omega_hat")]
            flux = trace.run(self.kinds[0].flux, y, seen, self._observer(0)[0][3])
        else:
            (speed,) = live(f"rows[STATE{MACHINE_STATES - 1} + l]")
            flux = own[:2]
        u, integrals = trace.run(drive.control, state, seen, speed, flux, *live("omega_ref", "flux_ref"), p, d)
        results = [*u, *integrals]
        places = ["u_ds", "u_qs", *(f"rows[CONTROL{j} + l]" for j in range(3))]
        if not self.loop.feedback:
            flux, flow = trace.run(drive.flux_model, flux, own[2:], seen, speed, d[0], p)
            results += [*flux, *flow]
            places += [f"rows[CONTROL{j} + l]" for j in range(3, 7)]
        lines, needed = statements(results, LIVE, names, "t")
        loads = [f"{names[id(value)]} = {self._row_of(value)}" for value in needed]
        return loads + lines + [f"new_{j} = {names[id(value)]}" for j, value in enumerate(results)] + [
            f"{place} = new_{j}" for j, place in enumerate(places)]

    def _machine_lines(self) -> tuple[list[str], list[str]]:
        """The machine's function of rates, and its step; the currents at each stage are kept for the observers."""
        x = tuple(f"s[{j}]" for j in range(MACHINE_STATES))
        friction = self._constants(("friction",))[0]

        def rates(trace: Trace, s: Any, outside: Any, held: Any) -> Any:
            return trace.run(loaded_machine.machine_rates, s, held[:2], held[2], self._constants(MACHINE), friction)

        function, arguments = self._rates("rates", rates, x, ())
        return function, [*arguments, *_stages("rates", 0, MACHINE_STATES, ["c"] * 4, keep=True)]

    def _observer_lines(self, n: int) -> tuple[list[str], list[str]]:
        """An observer's function of rates, and its step."""
        kind = self.kinds[n]
        gain_d, gain_q, sampled = self._constants(("gain_d", "gain_q", "sampled"))

        def rates(trace: Trace, s: Any, outside: Any, held: Any) -> Any:
            i = (gain_d * (1.0 - sampled) * outside[0] + held[4], gain_q * (1.0 - sampled) * outside[1] + held[5])
            return trace.run(kind.rates, s, i, held[:2], held[3], *self._observer(n))

        states = tuple(f"s[{j}]" for j in range(len(kind.states)))
        function, arguments = self._rates(f"rates_{n}", rates, states, ("i_d", "i_q"))
        currents = [f"rows[STAGE{2 * stage} + l], rows[STAGE{2 * stage + 1} + l], c" for stage in range(4)]
        return function, [*arguments, *_stages(f"rates_{n}", self._first(n), len(kind.states), currents)]

    def _rates(self, name: str, rates: Any, states: tuple[str, ...], outside: tuple[str, ...]) -> tuple[list[str], list[str]]:
        """The text of a function of rates, and the lines that make its last argument, what is constant or held."""
        trace = self._trace
        live, more, held = trace.inputs(states, LIVE), trace.inputs(outside, LIVE), trace.inputs(_HELD[:6], HELD)
        names = {id(value): text for value, text in zip((*live, *more), (*states, *outside), strict=True)}
        results = rates(trace, live, more, held)
        lines, needed = statements(results, LIVE, names, "c")
        function = [
            INLINE,
            f"def {name}({', '.join(('s', *outside, 'c'))}):",
            "    " + "".join(f"{names[id(value)]}, " for value in needed) + "= c",
            *["    " + line for line in lines],
            "    return (" + ", ".join(names[id(one)] if isinstance(one, Value) else repr(one) for one in results) + ")",
            "", "",
        ]
        before = {id(value): _at_held(text) for value, text in zip(held, _HELD, strict=False)}
        made, missing = statements([value for value in needed if value.level == HELD], HELD, before, "h")
        loads = [f"{before[id(value)]} = {self._row_of(value)}" for value in missing]
        arguments = [before[id(value)] if value.level == HELD else self._row_of(value) for value in needed]
        return function, [*loads, *made, f"c = ({', '.join(arguments)},)"]

    def _whence(self) -> str:
        """What has the sign that the observers are told; `kernel.plain` holds them all to one."""
        if not self.loop.directions or self.loop.directions[0] == "true":
            return f"rows[STATE{MACHINE_STATES - 1} + l]"
        if self.loop.directions[0] == "reference":
            return "omega_ref"
        return f"rows[STATE{self._first(0) + self.kinds[0].states.index('omega_hat')} + l]"

    def _watch_lines(self) -> list[str]:
        """Who is lost; an observer is lost with the machine."""
        lines = []
        for n, row in enumerate(self.tally):
            first = self.states + (self._first(n - 1) if n else 0)
            count = len(self.kinds[n - 1].states) if n else MACHINE_STATES
            size = sum_of([f"abs({_at(first + j)})" for j in range(count)])
            lines.append(f"lost_{n} = watched({_at(row)}, {size}, bound, number)")
            if n:
                lines.append(f"lost_{n} = lost_0 if (lost_{n} < 0.0) & (lost_0 >= 0.0) else lost_{n}")
        return lines + [f"{_at(row)} = lost_{n}" for n, row in enumerate(self.tally)]

    def _tally_lines(self) -> list[str]:
        lines = ["seen = (rows[SEEN0 + l], rows[SEEN1 + l])", "phi = (rows[STATE2 + l], rows[STATE3 + l])"]
        for n, kind in enumerate(self.kinds):
            parameters = self._observer(n)[0]
            beta, L_m = self._row_of(parameters[3]), self._row_of(parameters[1])
            y = ", ".join(f"rows[STATE{self._first(n) + j} + l]" for j in range(len(kind.states)))
            lines += [
                f"y = ({y})",
                f"lost = rows[TALLY{n + 1} + l]",
                f"sums = tallied({_tally(n, 1, 6)}, lost, rows[STATE4 + l], y[{kind.states.index('omega_hat')}], phi,"
                f" flux_{n}(y, seen, {beta}), band, number)",
                *[f"rows[TALLY{n + 1} + {(1 + j) * WIDTH} + l] = sums[{j}]" for j in range(6)],
            ]
            if "xi_1_hat" in kind.states:
                lines += [f"more = excited({_tally(n, 7, 7)}, lost, seen, y[:2], y[2:4], y[4:6], {beta}, {L_m})",
                          *[f"rows[TALLY{n + 1} + {(7 + j) * WIDTH} + l] = more[{j}]" for j in range(7)]]
        return lines

    def _source(
        self, outside: dict[str, str], control: list[str], parts: list[tuple[list[str], list[str]]], tallies: list[str]
    ) -> str:
        lines = [
            "from numba import carray",
            "from imo_analysis.sweeps.stack import stack_memory",
            "", "",
            *(line for width in sorted({MACHINE_STATES, *(len(kind.states) for kind in self.kinds)}) for line in _move(width)),
            *(line for function, _ in parts for line in function),
            '@njit(cache=True, error_model="numpy", nogil=True)',
            "def run(start, samples, every, h, substeps, bound, window, band, sampled, piece, share, sine, noise, tables,",
            "        kept):",
            f"    rows = carray(stack_memory({self.rows * WIDTH}), ({self.rows * WIDTH},))",
            f"    for j in range({self.rows * WIDTH}):",
            "        rows[j] = kept[j]",
            "    wait = -start % every",
            "    for k in range(samples):",
            f"        here, there = piece[0, k] * {WIDTH}, piece[1, k] * {WIDTH}",
            "        to_omega, to_load = share[0, k], share[1, k]",
            "        swing, noise_d, noise_q = sine[k], noise[0, k], noise[1, k]",
            f"        for l in range({WIDTH}):",
            f"            error_d, error_q = {outside['offset_d']} + noise_d, {outside['offset_q']} + noise_q",
            f"            seen_d = {outside['gain_d']} * rows[STATE0 + l] + error_d",
            f"            seen_q = {outside['gain_q']} * rows[STATE1 + l] + error_q",
            f"            omega_ref = tables[here + l] + to_omega * (tables[here + {WIDTH} + l] - tables[here + l])",
            f"            T_l = tables[there + l] + to_load * (tables[there + {WIDTH} + l] - tables[there + l])",
            f"            flux_ref = {outside['flux']} + {outside['flux_modulation']} * swing",
            f"            direction = direction_of({self._whence()})",
            *_indented(3, control),
            "            held_d = seen_d if sampled > 0.5 else error_d",
            "            held_q = seen_q if sampled > 0.5 else error_q",
            *[f"            {_at(self._held + j)} = {name}" for j, name in enumerate(_HELD)],
            "        if wait == 0:",
            "            wait = every",
            "            number = float(start + k)",
            f"            for l in range({WIDTH}):",
            *_indented(4, self._watch_lines()),
            "            if window[0] <= start + k < window[1]:",
            f"                for l in range({WIDTH}):",
            *_indented(5, tallies),
            "        wait -= 1",
            "        for _ in range(substeps):",
            *(line for _, step in parts for line in (f"            for l in range({WIDTH}):", *_indented(4, step))),
            f"    for j in range({self.rows * WIDTH}):",
            "        kept[j] = rows[j]",
            "",
        ]
        return self._placed("\n".join(lines))

    def _placed(self, text: str) -> str:
        """The text with the names of rows that were not yet known replaced by their places."""
        import re

        first = {"CONTROL": self.control, "STATE": self.states, "HELD": self._held, "SEEN": self._held + 6,
                 "STAGE": self._held + len(_HELD)}

        def place(match: re.Match[str]) -> str:
            name, number = match[1], int(match[2])
            return str((self.tally[number] if name == "TALLY" else first[name] + number) * WIDTH)

        text = text.replace('error_model="numpy"', 'error_model="numpy", fastmath={"contract"}')
        return re.sub(r"\b(CONTROL|STATE|HELD|SEEN|STAGE|TALLY)(\d+)", place, text)


@cache
def lanes(loop: Loop) -> Lanes:
    """The composition for `WIDTH` machines."""
    return Lanes(loop)


def _at(row: int | str) -> str:
    return f"rows[{int(row) * WIDTH} + l]"


def _at_held(name: str) -> str:
    return f"rows[HELD{_HELD.index(name)} + l]"


def _stages(rates: str, first: int, count: int, arguments: list[str], keep: bool = False) -> list[str]:
    """One classical Runge-Kutta step of the states from number ``first`` on; ``keep`` stores the first two at each stage.

    The rates are summed up as they come, which leaves fewer numbers to hold than `kernel` has, for its order of additions.
    """
    states = [f"rows[STATE{first + j} + l]" for j in range(count)]
    lines = [f"s = ({', '.join(states)})"]
    for stage, step in enumerate(("", "h / 2", "h / 2", "h")):
        lines.append("at = " + (f"move_{count}(s, {step}, k)" if stage else "s"))
        if keep:
            lines += [f"rows[STAGE{2 * stage + j} + l] = at[{j}]" for j in range(2)]
        lines.append(f"k = {rates}(at, {arguments[stage]})")
        weight = "1.0" if stage == 3 else "2.0"
        lines.append(f"total = move_{count}(total, {weight}, k)" if stage else "total = k")
    return [*lines, f"s = move_{count}(s, h / 6, total)", *[f"{state} = s[{j}]" for j, state in enumerate(states)]]


def _move(width: int) -> list[str]:
    """``move_WIDTH``, which adds so much of the rates to so many states."""
    moved = ", ".join(f"y[{j}] + h * k[{j}]" for j in range(width))
    return [INLINE, f"def move_{width}(y, h, k):", f"    return ({moved})", "", ""]


def _tally(n: int, first: int, count: int) -> str:
    return "(" + ", ".join(f"rows[TALLY{n + 1} + {(first + j) * WIDTH} + l]" for j in range(count)) + ")"


def _indented(depth: int, lines: list[str]) -> list[str]:
    return ["    " * depth + line for line in lines]
