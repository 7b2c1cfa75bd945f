"""Explicit Runge-Kutta steps, as text for the generated loops: the classical one of order 4 and that of Dormand and Prince.

A method is what its stages add to the states, ``h`` being the step and ``{n}`` the rates of stage n (from 1), and what the
whole step adds.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

INLINE = '@njit(forceinline=True, error_model="numpy")'


@dataclass(frozen=True)
class Method:
    """An explicit Runge-Kutta method.

    Attributes
    ----------
    stages : tuple of str
        What each stage after the first adds to the states, of the rates of those before it.
    step : str
        What the step adds.
    """

    stages: tuple[str, ...]
    step: str

    @property
    def evaluations(self) -> int:
        """How often a step calls the rates."""
        return len(self.stages) + 1


METHODS = {
    4: Method(("h / 2 * {1}", "h / 2 * {2}", "h * {3}"), "h / 6 * ({1} + 2.0 * ({2} + {3}) + {4})"),
    # J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6(1), 1980; without the stage that only estimates the error
    5: Method(
        (
            "h * (1 / 5 * {1})",
            "h * (3 / 40 * {1} + 9 / 40 * {2})",
            "h * (44 / 45 * {1} - 56 / 15 * {2} + 32 / 9 * {3})",
            "h * (19372 / 6561 * {1} - 25360 / 2187 * {2} + 64448 / 6561 * {3} - 212 / 729 * {4})",
            "h * (9017 / 3168 * {1} - 355 / 33 * {2} + 46732 / 5247 * {3} + 49 / 176 * {4} - 5103 / 18656 * {5})",
        ),
        "h * (35 / 384 * {1} + 500 / 1113 * {3} + 125 / 192 * {4} - 2187 / 6784 * {5} + 11 / 84 * {6})",
    ),
}


def functions(order: int, widths: Iterable[int]) -> list[str]:
    """The functions that `step` calls, for each number of states: ``at_n_WIDTH`` for stage n, ``next_WIDTH`` for the step."""
    method = METHODS[order]
    lines = []
    for width in sorted(set(widths)):
        for stage, added in enumerate(method.stages, 2):
            lines += _added(f"at_{stage}_{width}", added, stage - 1, width)
        lines += _added(f"next_{width}", method.step, method.evaluations, width)
    return lines


def step(order: int, states: dict[str, int], rates: str) -> list[str]:
    """One step of all states together.

    Parameters
    ----------
    order : int
        Of `METHODS`.
    states : dict of str to int
        Name of each tuple of states and its width.
    rates : str
        The call that gives a tuple of rates for each, with its name in braces where the states stand.
    """
    method = METHODS[order]
    lines = [f"k_1 = {rates.format_map(dict(zip(states, states, strict=True)))}"]
    for stage in range(2, method.evaluations + 1):
        at = {name: _call(f"at_{stage}_{width}", name, stage - 1, n) for n, (name, width) in enumerate(states.items())}
        lines.append(f"k_{stage} = {rates.format_map(at)}")
    return lines + [f"{name} = {_call(f'next_{width}', name, method.evaluations, n)}"
                    for n, (name, width) in enumerate(states.items())]


def _call(function: str, name: str, stages: int, n: int) -> str:
    return f"{function}({name}, h, {', '.join(f'k_{stage}[{n}]' for stage in range(1, stages + 1))})"


def _added(name: str, added: str, stages: int, width: int) -> list[str]:
    """A function that adds to each of ``width`` states."""
    arguments = [f"k_{stage}" for stage in range(1, stages + 1)]
    values = [f"y[{j}] + " + added.format("", *(f"{argument}[{j}]" for argument in arguments)) for j in range(width)]
    return [INLINE, f"def {name}(y, h, {', '.join(arguments)}):", f"    return ({', '.join(values)})", "", ""]
