"""The derivative of an observer's rates at any estimates, with alpha_hat held: for observers that believe wrong parameters.

`imo_analysis.pencils.jacobian` differentiates at the truth, where estimates and machine agree. Here estimates, currents and
voltages are independent of each other, so that the same exact derivative serves Newton's method and the linearisation at the
biased state where an observer with parameter errors settles. alpha_hat is held because it has no such state of its own: at
constant flux its law drives it along a line or away (see `imo_analysis.pencils.operating`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from imo_analysis.equations.catalogue import PARAMETERS, RUNNING_GRAM, Observer
from imo_analysis.equations.own import is_file, shown
from imo_analysis.equations.plain import exact
from imo_analysis.errors import InputError
from imo_analysis.pencils.jacobian import commutes_with_rotation, known_observer, pairs

_FLUX = ("phi_dr_hat", "phi_qr_hat")
_MEASURED = ("i_ds", "i_qs", "u_ds", "u_qs")


@dataclass(frozen=True)
class HeldRates:
    """An observer whose alpha_hat is held: its rates in a turning frame and their exact derivative, for arrays.

    Attributes
    ----------
    observer : str
        Its name in the catalogue.
    states : tuple of str
        The estimates that move: all but alpha_hat, and but the filters that only alpha_hat's law uses.
    variables : tuple of str
        What the derivative is taken by: the states, ``i_ds, i_qs, u_ds, u_qs``, and ``alpha_hat`` where the observer has one.
    outputs : tuple of str
        The rows below the states: ``phi_dr_hat, phi_qr_hat``.
    arguments : tuple of str
        What both depend on, by name: variables, parameters as the observer believes them, gains, ``direction`` and
        ``stator_frequency``.
    """

    observer: str
    states: tuple[str, ...]
    variables: tuple[str, ...]
    outputs: tuple[str, ...]
    arguments: tuple[str, ...]
    _rates: Any
    _derivative: Any

    def rates(self, values: dict[str, Any]) -> np.ndarray:
        """Rates of the states in the frame, then the outputs, shape ``(..., rows)``."""
        return self._stack(self._rates, values)

    def derivative(self, values: dict[str, Any]) -> np.ndarray:
        """Derivative of ``rates`` by the variables, shape ``(..., rows, columns)``."""
        flat = self._stack(self._derivative, values)
        return flat.reshape(*flat.shape[:-1], -1, len(self.variables))

    def _stack(self, function: Any, values: dict[str, Any]) -> np.ndarray:
        numbers = [values[name] for name in self.arguments]
        return np.stack(np.broadcast_arrays(*function(*numbers), *numbers)[: -len(numbers)], axis=-1).astype(float)


def with_held_alpha(observer: Observer) -> Observer:
    """The observer that this one is while alpha_hat is held: a supervisor of alpha_hat has nothing to do then."""
    return known_observer("across") if set(RUNNING_GRAM) & set(observer.states) else observer


@cache
def held_rates(name: str) -> HeldRates:
    """Derive an observer's rates with alpha_hat held; kept for the life of the process.

    Raises
    ------
    InputError
        If the observer is not known, or its equations change under a rotation of the axes: it then has no state at rest while
        the flux turns.
    """
    if not commutes_with_rotation(name):
        raise InputError(
            f"observer = {shown(name)!r} has no state at rest while the flux turns: its z feedback changes when the axes turn; "
            "use imo_analysis.pencils.floquet"
        )
    observer = with_held_alpha(known_observer(name))
    symbols = {s: sp.Symbol(s, real=True) for s in (*observer.states, *_MEASURED, *PARAMETERS, *observer.gains)}
    direction, frame = sp.symbols("direction stator_frequency", real=True)
    own = is_file(name)  # its alpha_hat is held by leaving out the row, whatever its gain is called
    gains = tuple(sp.Integer(0) if gain == "g" and not own else symbols[gain] for gain in observer.gains)
    x = tuple(symbols[state] for state in observer.states)
    i, u = (symbols["i_ds"], symbols["i_qs"]), (symbols["u_ds"], symbols["u_qs"])
    p = tuple(symbols[parameter] for parameter in PARAMETERS)
    rates = dict(zip(observer.states, exact(observer.rates)(x, i, u, direction, p, gains), strict=True))
    if rates.pop("alpha_hat", 0) != 0 and not own:
        raise AssertionError(f"{name}: alpha_hat moves although g is 0")
    for d, q in pairs(rates):
        rates[d] += frame * symbols[q]
        rates[q] -= frame * symbols[d]
    flux = dict(zip(_FLUX, exact(observer.flux)(x, i, symbols["beta"]), strict=True))
    variables = (*rates, *_MEASURED, *(("alpha_hat",) if "alpha_hat" in observer.states else ()))
    rows = [*rates.values(), *flux.values()]
    derivative = [sp.diff(row, symbols[variable]) for row in rows for variable in variables]
    arguments = (*variables, *PARAMETERS, *observer.gains, "direction", "stator_frequency")
    inputs = [{**symbols, "direction": direction, "stator_frequency": frame}[argument] for argument in arguments]
    return HeldRates(
        name, tuple(rates), variables, _FLUX, arguments,
        sp.lambdify(inputs, rows, modules="numpy", cse=True), sp.lambdify(inputs, derivative, modules="numpy", cse=True))
