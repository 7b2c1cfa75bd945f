"""Before the poles of a user's own observer are believed: does it follow the machine, and is its derivative right?

`departures` puts right estimates and right parameters into the rates and subtracts the machine's, in symbols: what is left
drives the estimates away, and is as a rule a slip of sign or a missing term. `imo_analysis.equations.own.astray` finds the same
rows with numbers and another form of the machine. `check_derivative` holds the matrices of `imo_analysis.pencils.jacobian`
against difference quotients in exact fractions.
"""

from __future__ import annotations

from fractions import Fraction
from random import Random
from typing import Any

import sympy as sp

from imo_analysis.equations.own import ESTIMATED, PARAMETERS
from imo_analysis.equations.plain import exact
from imo_analysis.equations.transformation import to_z
from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.pencils.jacobian import Kind, derive, known_observer, pairs, true_rates

STEP = Fraction(1, 10**40)
AGREED = Fraction(1, 10**30)  # relative to the larger of the entry and 1; at a kink, |v| at 0, a quotient is off by its step
_NOISE = {"i_ds_noise": ("i", 0), "i_qs_noise": ("i", 1), "u_ds_error": ("u", 0), "u_qs_error": ("u", 1)}


def departures(kind: str) -> dict[str, Any]:
    """By how much each row leaves the machine at zero error and constant speed: expressions in the notation's names.

    Parameters
    ----------
    kind : str
        An observer, of the catalogue or of a file.

    Returns
    -------
    dict of str to sympy.Expr
        Rate of the estimate minus that of the machine, by state; ``flux_d`` and ``flux_q``, the flux estimate minus the flux.
        Empty where it follows.
    """
    observer = known_observer(kind)
    p = sp.symbols(PARAMETERS, positive=True)
    i, phi, u = sp.symbols("i_ds i_qs", real=True), sp.symbols("phi_dr phi_qr", real=True), sp.symbols("u_ds u_qs", real=True)
    omega, direction = sp.symbols("omega direction", real=True)
    gains = sp.symbols(observer.gains, real=True)
    true = _truth(i, phi, omega, p)
    moving = true_rates(true, u, p)
    bases = [_base(state) for state in observer.states]
    own = {state: sp.Symbol(state, real=True) for state, base in zip(observer.states, bases, strict=True) if not base}
    for corrections in (own, dict.fromkeys(own, sp.Integer(0))):
        x = tuple(true[base] if base else corrections[state] for state, base in zip(observer.states, bases, strict=True))
        rates = exact(observer.rates)(x, i, u, direction, p, gains)
        rows = {state: rate - moving.get(base, 0) for state, base, rate in zip(observer.states, bases, rates, strict=True)
                if base or corrections is not own}
        flux = exact(observer.flux)(x, i, p[3])
        rows |= {f"flux_{axis}": a - b for axis, a, b in zip("dq", flux, phi, strict=True)}
        rows = {state: rest for state, row in rows.items() if (rest := sp.factor(sp.sympify(row))) != 0}
        if not rows:
            break
    return rows


def size_of(departure: Any, kind: str, gains: Any, p: Any, point: OperatingPoint) -> float:
    """The size of a departure at an operating point, in SI units, when the flux is half way between the axes.

    Parameters
    ----------
    departure : sympy.Expr
        From `departures`.
    kind : str
        The observer.
    gains : mapping of str to float
        By name.
    p : sequence of float
        The parameters, as they are and as they are believed.
    point : OperatingPoint
        The steady state.
    """
    values = point.quantities(p)
    for d, q in (("i_ds", "i_qs"), ("phi_dr", "phi_qr"), ("u_ds", "u_qs")):
        values[d], values[q] = (values[d] - values[q]) * 0.5**0.5, (values[d] + values[q]) * 0.5**0.5
    values |= {**dict(zip(PARAMETERS, p, strict=True)), **{gain: gains[gain] for gain in known_observer(kind).gains},
               "direction": 1.0 if point.omega >= 0 else -1.0}
    return float(abs(departure.subs({symbol: values.get(symbol.name, 0.0) for symbol in departure.free_symbols})))


def check_derivative(kind: str) -> int:
    """Compare the symbolic matrices of an observer with exact difference quotients at a random rational point.

    Parameters
    ----------
    kind : str
        The observer.

    Returns
    -------
    int
        How many entries were compared; all of them agree.

    Raises
    ------
    AssertionError
        If one does not.
    """
    return sum(_compared(kind, which) for which in ("frozen", "full"))


def _compared(kind: str, which: Kind) -> int:
    observer, derived = known_observer(kind), derive(kind, which)
    random = Random(13)

    def numbers(names: Any) -> tuple[Fraction, ...]:
        return tuple(Fraction(random.randint(1, 97), random.randint(1, 13)) for _ in names)

    p, gains, i, phi, u, (omega, frame) = (numbers(names) for names in (PARAMETERS, observer.gains, "dq", "dq", "dq", "of"))
    true = _truth(i, phi, omega, p)
    further = dict(zip(observer.states, numbers(observer.states), strict=True))
    bases = [_base(state) for state in observer.states]
    free = {state.removesuffix("_hat") for state, base in zip(observer.states, bases, strict=True) if not base}
    at = {**true, **dict(zip(observer.gains, gains, strict=True)), "direction": Fraction(1), "stator_frequency": frame}
    at |= {name: further[name] for name in free if name in derived.arguments}
    kept = [state.removesuffix("_tilde") for state in derived.states]
    rates, flux = exact(observer.rates), exact(observer.flux)

    def rows(moved: str, step: Fraction) -> list[Fraction]:
        """The error dynamics and the outputs, but for the machine's part, which no error changes."""
        error = dict.fromkeys(kept, Fraction(0)) | ({moved: step} if moved in kept else {})
        seen = {"i": list(i), "u": list(u)}
        if moved in _NOISE:
            which_pair, axis = _NOISE[moved]
            seen[which_pair][axis] += step
        x = tuple((true[base] if base else at.get(state, Fraction(0))) - error.get(base or state.removesuffix("_hat"), 0)
                  for state, base in zip(observer.states, bases, strict=True))
        now = dict(zip((state.removesuffix("_hat") for state in observer.states),
                       rates(x, tuple(seen["i"]), tuple(seen["u"]), Fraction(1), p, gains), strict=True))
        difference = {base: (step if moved == f"{base}_dot" else 0) - now[base] for base in kept}
        if which == "full":
            for d, q in pairs(kept):
                difference[d] += frame * error[q]
                difference[q] -= frame * error[d]
        out = dict(error)
        for base, value in zip(("phi_dr", "phi_qr"), flux(x, tuple(seen["i"]), p[3]), strict=True):
            out.setdefault(base, -value)
        return [*difference.values(), *out.values()]

    symbols = {symbol: sp.Rational(at[symbol.name]) for symbol in derived.matrix.free_symbols}
    symbolic = derived.matrix.subs(symbols)
    columns = [name.removesuffix("_tilde") for name in derived.states] + list(derived.inputs)
    for column, moved in enumerate(columns):
        after, before = rows(moved, STEP), rows(moved, -STEP)
        for row, (high, low) in enumerate(zip(after, before, strict=True)):
            entry = Fraction(int(symbolic[row, column].p), int(symbolic[row, column].q))
            quotient = (high - low) / (2 * STEP)
            if not abs(entry - quotient) <= AGREED * max(abs(entry), Fraction(1)):
                raise AssertionError(f"{observer.name}: entry {row}, {column} of its {which} dynamics is {float(entry):.6g} by "
                                     f"differentiation and {float(quotient):.6g} as a difference quotient")
    return int(symbolic.rows * symbolic.cols)


def _base(state: str) -> str:
    """The quantity that a state estimates; empty for a correction."""
    base = state.removesuffix("_hat")
    return base if state.endswith("_hat") and base in ESTIMATED else ""


def _truth(i: Any, phi: Any, omega: Any, p: Any) -> dict[str, Any]:
    """Every quantity of `ESTIMATED`, from currents, fluxes, speed and parameters."""
    z_1, z_2 = to_z(i[0], i[1], phi[0], phi[1], p[3])
    return {"i_ds": i[0], "i_qs": i[1], "phi_dr": phi[0], "phi_qr": phi[1], "z_1": z_1, "z_2": z_2, "xi_1": z_1, "xi_2": z_2,
            "omega": omega, **dict(zip(PARAMETERS, p, strict=True))}
