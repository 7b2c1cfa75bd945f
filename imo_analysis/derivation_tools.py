"""What the files in ``derivations/`` share: symbols with their LaTeX, a way to show results, the ledger's entries, a run.

A derivation is a script, a test and a notebook. As a script it prints; in a notebook formulas are typeset. `settled` puts a
claim of the ledger before the reader and fails where it does not come out as its entry says.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from imo_analysis.machine import InductionMachine
from imo_analysis.notation import symbol

Values = tuple[float, ...]


def symbols(text: str) -> tuple[sympy.Symbol, ...]:
    """Real symbols for names of the notation table.

    Parameters
    ----------
    text : str
        Names, parted by spaces.
    """
    for name in text.split():
        symbol(name)
    return tuple(sympy.Symbol(name, real=True) for name in text.split())


def show(words: str, *values: Any) -> None:
    """A sentence and what it is about: typeset in a notebook, plain text in a script.

    Parameters
    ----------
    words : str
        The sentence.
    *values
        What it is about: formulas of sympy, numbers, text.
    """
    print(words)
    for value in values:
        if in_notebook() and isinstance(value, sympy.Basic):
            from IPython.display import Math, display

            display(Math(latex(value)))
        else:
            print("   ", value)


def latex(value: Any) -> str:
    """LaTeX with the symbols of the notation table."""
    names = {one: symbol(one.name).latex for one in value.free_symbols if _known(one.name)}
    return str(sympy.latex(value, symbol_names=names))


def _known(name: str) -> bool:
    try:
        symbol(name)
    except ValueError:
        return False
    return True


def in_notebook() -> bool:
    """Whether this runs in a notebook, where formulas are typeset and figures shown."""
    try:
        from IPython import get_ipython
    except ImportError:
        return False
    return get_ipython() is not None


def settled(*identifiers: str) -> None:
    """Settle entries of the ledger by two kernels and print a line for each.

    Parameters
    ----------
    *identifiers : str
        Ids, or beginnings of ids that end in a full stop: ``eq12.`` stands for all rows of (12).

    Raises
    ------
    AssertionError
        If there is no such entry, or one does not come out as it should.
    """
    from imo_analysis.ledger.book import claims, entries

    whole = tuple(name for name in identifiers if name.endswith("."))
    wanted = [one for one in claims() if one.id in identifiers or (whole and one.id.startswith(whole))]
    assert wanted, f"no entry {', '.join(identifiers)}"
    for entry in entries(("flint", "sympy"), wanted):
        assert entry.ok, entry.errors
        print(f"    {entry.claim.id:34s} {entry.verdict}" + (f": {entry.claim.edit}" if entry.claim.edit else ""))


@dataclass(frozen=True)
class TurningFlux:
    """A machine whose rotor flux turns at a constant frequency, in closed form: currents, z and voltages follow from (1).

    Attributes
    ----------
    machine : InductionMachine
    omega, stator_frequency : float
        In rad/s; their difference is the slip.
    flux : float
        Mean magnitude in Wb.
    depth, frequency : float
        The magnitude is ``flux (1 + depth sin(frequency t))``; frequency in rad/s.
    """

    machine: InductionMachine
    omega: float
    stator_frequency: float
    flux: float
    depth: float = 0.0
    frequency: float = 0.0

    def at(self, t: float) -> tuple[complex, complex, complex, complex]:
        """Rotor flux in Wb, current in A, z in A and voltage in V as complex numbers at a time in s.

        Parameters
        ----------
        t : float
            Time in s.
        """
        m = self.machine
        phi, rate, bend = self._flux(t)
        decay = m.alpha - 1j * self.omega
        i, i_rate = (rate + decay * phi) / (m.alpha * m.L_m), (bend + decay * rate) / (m.alpha * m.L_m)
        return phi, i, i + m.beta * phi, m.sigma * (i_rate + m.beta * rate) + m.R_s * i

    def _flux(self, t: float) -> tuple[complex, complex, complex]:
        """Flux and its first two derivatives."""
        turn, w, a = cmath.exp(1j * self.stator_frequency * t), self.stator_frequency, self.frequency
        size = self.flux * (1 + self.depth * math.sin(a * t))
        growth, bend = self.flux * self.depth * a * math.cos(a * t), -self.flux * self.depth * a * a * math.sin(a * t)
        return size * turn, (growth + 1j * w * size) * turn, (bend + 2j * w * growth - w * w * size) * turn


def follow(rates: Callable[..., Any], start: Sequence[float], plant: TurningFlux, gains: Sequence[float], direction: float,
           duration: float, step: float) -> list[tuple[float, Values]]:
    """An observer of `equations` along a turning flux, by the classical Runge-Kutta method.

    Parameters
    ----------
    rates : callable
        ``rates(x, i, u, direction, p, gains)``.
    start : sequence of float
        Initial estimates.
    plant : TurningFlux
    gains : sequence of float
    direction : float
        +1 or -1.
    duration, step : float
        In s.

    Returns
    -------
    list of (time, state)
    """
    parameters = plant.machine.observer_parameters

    def slope(x: Values, t: float) -> Values:
        _, i, _, u = plant.at(t)
        return tuple(rates(x, (i.real, i.imag), (u.real, u.imag), direction, parameters, gains))

    def moved(x: Values, k: Values, by: float) -> Values:
        return tuple(a + by * b for a, b in zip(x, k, strict=True))

    x: Values = tuple(start)
    path = [(0.0, x)]
    for number in range(round(duration / step)):
        t = number * step
        a = slope(x, t)
        b = slope(moved(x, a, step / 2), t + step / 2)
        c = slope(moved(x, b, step / 2), t + step / 2)
        d = slope(moved(x, c, step), t + step)
        mean = tuple((k + 2 * h + 2 * m + n) / 6 for k, h, m, n in zip(a, b, c, d, strict=True))
        x = moved(x, mean, step)
        path.append((t + step, x))
    return path


def errors_at(plant: TurningFlux, t: float, x: Values) -> dict[str, float]:
    """The errors (true minus estimate) of the state of an adaptive observer, by name.

    Parameters
    ----------
    plant : TurningFlux
        The motion.
    t : float
        Time in s.
    x : tuple of float
        The state of the observer: i_ds_hat, i_qs_hat, z_1_hat, z_2_hat, xi_1_hat, xi_2_hat, alpha_hat, omega_hat.
    """
    _, i, z, _ = plant.at(t)
    true = (i.real, i.imag, z.real, z.imag, z.real, z.imag, plant.machine.alpha, plant.omega)
    which = ("i_ds", "i_qs", "z_1", "z_2", "xi_1", "xi_2", "alpha", "omega")
    return {f"{name}_tilde": a - b for name, a, b in zip(which, true, x, strict=True)}
