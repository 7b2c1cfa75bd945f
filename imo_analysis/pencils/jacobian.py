"""Error dynamics by differentiating the plain definitions: plant minus observer, in the errors, symbolically and once.

``x_tilde' = f_plant(x) - f_observer(x - x_tilde, i + noise, u + error)``; its Jacobian at ``x_tilde = 0`` with respect to the
errors and the inputs is [[A, B], [C, D]]. Nothing is typed in: `imo_analysis.equations` is all that is differentiated.

Two kinds: ``frozen`` holds omega_hat, alpha_hat and every other scalar at the true values and drops their rows, as Table II
does; the result depends on parameters, gains and speed alone. ``full`` keeps the adaptation, about a steady operating point, in
the frame that turns with the flux, where that point is an equilibrium. A state that estimates nothing of the machine is a
correction, whose true value is zero.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from random import Random
from typing import Any, Literal

import numpy as np
import sympy as sp

from imo_analysis.equations import plant, transformation
from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS, RUNNING_GRAM, Observer
from imo_analysis.equations.own import ESTIMATED, shown
from imo_analysis.equations.plain import exact
from imo_analysis.errors import InputError

# The axis in a name: before s, r or the end of the name, in i_ds, psi_ds_hat, m_1d; and the 1 of z_1.
_D_AXIS = re.compile(r"(?<=_)d(?=[sr]?(_hat)?$)|(?<=_\d)d(?=(_hat)?$)|(?<=_)1(?=(_hat)?$)")

Kind = Literal["frozen", "full"]
_NOISE = ("i_ds_noise", "i_qs_noise", "u_ds_error", "u_qs_error")


@dataclass(frozen=True)
class Jacobian:
    """The matrices of one observer's error dynamics, symbolic and as a numpy function.

    Attributes
    ----------
    observer : str
        Its name in the catalogue.
    kind : str
        ``frozen`` or ``full``.
    states, inputs, outputs : tuple of str
        Names; states end in ``_tilde`` (true minus estimate). Inputs are the noise added to the measured currents (A), the
        error of the voltages that the observer is told (V) and, for ``full``, the rates of the true omega and of the parameters
        that are estimated. Outputs are the states, and the errors of the rotor flux where it is not a state.
    matrix : sympy.Matrix
        [[A, B], [C, D]].
    arguments : tuple of str
        Names of what the matrix depends on, in the order of ``function``.
    function : callable
        Takes the arguments as floats or arrays that broadcast; returns the entries of ``matrix``, row by row.
    """

    observer: str
    kind: Kind
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    matrix: Any
    arguments: tuple[str, ...]
    function: Any

    def evaluate(self, values: dict[str, Any]) -> np.ndarray:
        """The matrix [[A, B], [C, D]] at the given arguments, as an array of shape ``(..., rows, columns)``."""
        rows, columns = self.matrix.shape
        shape = np.broadcast_shapes(*(np.shape(values[name]) for name in self.arguments))
        result = np.empty((*shape, rows * columns))
        for k, entry in enumerate(self.function(*(values[name] for name in self.arguments))):
            result[..., k] = entry
        return result.reshape(*shape, rows, columns)

    def system_matrix(self, values: dict[str, Any]) -> np.ndarray:
        """The matrix A alone, shape ``(..., n, n)``."""
        n = len(self.states)
        return self.evaluate(values)[..., :n, :n]


def known_observer(name: str) -> Observer:
    """The observer of that name in the catalogue, or of that file.

    Raises
    ------
    InputError
        If there is none.
    """
    return OBSERVERS[name]


@cache
def jacobian(name: str, kind: Kind = "frozen") -> Jacobian:
    """The error dynamics of an observer, derived on the first call and kept for the life of the process.

    Raises
    ------
    InputError
        If the observer is not known, or ``full`` is asked for one whose equations change under a rotation of the axes: about
        a turning flux its linearisation is not time-invariant in any frame (see `imo_analysis.pencils.floquet`).
    """
    if kind == "full" and not commutes_with_rotation(name):
        raise InputError(
            f"observer = {shown(name)!r} has no time-invariant linearisation about a turning flux: its z feedback changes when "
            "the axes turn; use the frozen-speed poles, or its Floquet exponents (imo_analysis.pencils.floquet)"
        )
    return derive(name, kind)


@cache
def derive(name: str, kind: Kind) -> Jacobian:
    """As `jacobian`, but without asking whether the result is time-invariant: ``full`` holds at an instant for any observer."""
    observer = known_observer(name)
    bases = [state.removesuffix("_hat") for state in observer.states]
    vectors = {base for pair in pairs(bases) for base in pair} - set(RUNNING_GRAM)
    kept = [base for base in bases if kind == "full" or base in vectors]
    parameters = {symbol: sp.Symbol(symbol, positive=True) for symbol in PARAMETERS}
    true = {base: sp.Symbol(base, real=True) for base in (*bases, "i_ds", "i_qs", "omega")} | parameters
    gains = {gain: sp.Symbol(gain, real=True) for gain in observer.gains}
    direction, frame = sp.symbols("direction stator_frequency", real=True)
    voltages = sp.symbols("u_ds u_qs", real=True)

    errors = {base: sp.Symbol(f"{base}_tilde", real=True) for base in kept}
    noise = {label: sp.Symbol(label, real=True) for label in _NOISE}
    moving = {f"{base}_dot": sp.Symbol(f"{base}_dot", real=True) for base in ("alpha", "omega", *PARAMETERS) if base in errors}
    aliases = {true[base]: sp.Integer(0) for base in bases if base not in (*ESTIMATED, *RUNNING_GRAM)}
    if "xi_1" in true:
        aliases |= {true[f"xi_{n}"]: true.setdefault(f"z_{n}", sp.Symbol(f"z_{n}", real=True)) for n in "12"}

    p = tuple(parameters.values())
    estimate = tuple(true[base] - errors.get(base, 0) for base in bases)
    currents = (true["i_ds"] + noise["i_ds_noise"], true["i_qs"] + noise["i_qs_noise"])
    told = (voltages[0] + noise["u_ds_error"], voltages[1] + noise["u_qs_error"])
    rates = dict(zip(bases, exact(observer.rates)(estimate, currents, told, direction, p, tuple(gains.values())), strict=True))
    machine = true_rates(true, voltages, p)
    difference = {base: machine.get(base, moving.get(f"{base}_dot", 0)) - rates[base] for base in kept}
    if kind == "full":
        for d, q in pairs(kept):
            difference[d] += frame * errors[q]
            difference[q] -= frame * errors[d]

    outputs = dict(errors)
    flux = exact(observer.flux)(estimate, currents, parameters["beta"])
    for k, base in enumerate(("phi_dr", "phi_qr")):
        if base not in errors:
            truth = transformation.from_z(true["i_ds"], true["i_qs"], true["z_1"], true["z_2"], parameters["beta"])[k]
            outputs[base] = truth - flux[k]

    variables = [*errors.values(), *noise.values(), *moving.values()]
    at_rest = dict.fromkeys(variables, sp.Integer(0)) | aliases
    rows = [*difference.values(), *outputs.values()]
    matrix = sp.Matrix([[sp.diff(row, variable).xreplace(at_rest) for variable in variables] for row in rows])
    if kind == "frozen":
        matrix = matrix.applyfunc(sp.cancel)
    arguments = [*PARAMETERS, *gains, *(s.name for s in true.values() if s.name not in parameters), "direction",
                 "stator_frequency"]
    depends = {symbol.name for symbol in matrix.free_symbols}
    used = tuple(argument for argument in arguments if argument in depends)
    if kind == "frozen" and (leaked := depends - {*PARAMETERS, *gains, "omega", "direction"}):
        raise InputError(f"observer = {observer.name!r} has no poles at frozen speed: its error dynamics depend on "
                         f"{', '.join(sorted(leaked))}; with the adaptation it has some about an operating point: --full SLIP")
    ordered = {symbol.name: symbol for symbol in matrix.free_symbols}
    function = sp.lambdify([ordered[argument] for argument in used], list(matrix), modules="numpy", cse=True)
    return Jacobian(
        name, kind, tuple(f"{base}_tilde" for base in kept), (*_NOISE, *moving), tuple(f"{base}_tilde" for base in outputs),
        matrix, used, function)


@cache
def structural_rank(name: str) -> int:
    """Rank of the frozen-speed system matrix at a random rational point: the number of poles that are not zero by structure."""
    derived = jacobian(name, "frozen")
    n = len(derived.states)
    matrix = derived.matrix[:n, :n]
    random = Random(11)
    symbols = sorted(matrix.free_symbols, key=str)
    point = {symbol: sp.Rational(random.randint(1, 997), random.randint(1, 89)) for symbol in symbols}
    return int(matrix.subs(point).rank())


def true_rates(true: Any, voltages: Any, p: Any) -> dict[str, Any]:
    """The machine's rates by name, in every coordinate that ``true`` has, in the stationary frame."""
    rates: dict[str, Any] = {}
    i_ds, i_qs, omega = true["i_ds"], true["i_qs"], true["omega"]
    if "phi_dr" in true:
        whole = plant.plant((i_ds, i_qs, true["phi_dr"], true["phi_qr"], omega), voltages, 0, 0, (*p, 0, 0, 1))
        rates |= dict(zip(("i_ds", "i_qs", "phi_dr", "phi_qr"), whole[:4], strict=True))
    if "z_1" in true:
        whole = plant.plant_z((i_ds, i_qs, true["z_1"], true["z_2"]), voltages, omega, 0, p)
        rates |= dict(zip(("i_ds", "i_qs", "z_1", "z_2"), whole, strict=True))
        rates |= {"xi_1": rates["z_1"], "xi_2": rates["z_2"]}
    return rates


def pairs(names: Any) -> list[tuple[str, str]]:
    """The d/q pairs among state names: ``i_ds, i_qs``; ``m_1d, m_1q``; ``z_1, z_2``. What has no partner is a scalar."""
    names = list(names)
    partners = ((name, _D_AXIS.sub(lambda axis: {"d": "q", "1": "2"}[axis[0]], name)) for name in names)
    return [(name, other) for name, other in partners if other != name and other in names]


@cache
def commutes_with_rotation(name: str) -> bool:
    """Whether turning all vectors by an angle turns the rates of the observer by the same angle.

    Tested at a random rational point with the rational rotation (3/5, 4/5): unequal means certainly not; equal at a random
    point means yes, but for a null set of points.
    """
    observer = known_observer(name)
    random = Random(7)

    def number() -> Fraction:
        return Fraction(random.randint(1, 97), random.randint(1, 13))

    def turn(v: Any) -> tuple[Any, Any]:
        return (3 * v[0] - 4 * v[1]) / 5, (4 * v[0] + 3 * v[1]) / 5

    def turned(x: Any) -> tuple[Any, ...]:
        values = dict(zip(observer.states, x, strict=True))
        for d, q in pairs(observer.states):
            values[d], values[q] = turn((values[d], values[q]))
        return tuple(values.values())

    x = tuple(number() for _ in observer.states)
    i, u = (number(), number()), (number(), number())
    p = tuple(number() for _ in PARAMETERS)
    gains = tuple(number() for _ in observer.gains)
    rates = exact(observer.rates)
    return turned(rates(x, i, u, 1, p, gains)) == tuple(rates(turned(x), turn(i), turn(u), 1, p, gains))
