"""Audit an observer of your own: plant, observer, Lyapunov candidate and printed formulas in, entries and mutants out.

Plain functions are given; the names of their parameters are the names of the quantities::

    def plant(x, u, a):                 # the true system
        return {"x": -a * x + u}

    def observer(x, x_hat, u, a_hat, k, g):    # estimates end in _hat; x is measured
        return {"x": -a_hat * x_hat + u + k * (x - x_hat), "a": -g * (x - x_hat) * x_hat}

    where = error_setting("mine", "a first-order system", plant, observer, hypotheses=("g > 0", "k > 0"),
                          units={"x": "A", "a": "1/s", ...})
    where = with_lyapunov(where, lambda x_tilde, a_tilde, g: x_tilde**2 / 2 + a_tilde**2 / (2 * g))
    result = audit([Claim("v", "(7)", "the derivative", Verdict.HOLDS, where, printed="V_dot = -(a + k)*x_tilde**2")])
    print(result.text())

sympy expressions are taken as well: `from_sympy` turns one into a formula. The functions may only use ``+ - * /``, integer
powers and ``abs``.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from imo_analysis.errors import InputError
from imo_analysis.ledger.claim import Claim, Entry
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Expr, Name, Number, as_expr
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.mutants import MutantReport, try_mutants
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settle import settle


def trace(function: Callable[..., Any]) -> Any:
    """What a plain function returns when its parameters are the names that they carry.

    Parameters
    ----------
    function : callable
        Of scalars; its parameters carry the names of the quantities.

    Raises
    ------
    InputError
        If it uses something that is not algebra.
    """
    parameters = inspect.signature(function).parameters
    try:
        return function(**{name: Name(name) for name in parameters})
    except (TypeError, AttributeError) as error:
        label = getattr(function, "__name__", "the function")
        raise InputError(f"{label} cannot be traced: {error}; use + - * /, integer powers and abs() only") from None


def error_setting(name: str, text: str, plant: Callable[..., Mapping[str, Any]], observer: Callable[..., Mapping[str, Any]],
                  hypotheses: Iterable[str] = (), cases: Iterable[Mapping[str, int | Fraction]] = ({},),
                  units: Mapping[str, str] | None = None) -> Setting:
    """The true system and its estimate side by side.

    Parameters
    ----------
    name, text : str
        Short name, and a sentence for the reader.
    plant : callable
        Returns the rate of each true state. A quantity that the observer estimates and the plant does not move is constant.
    observer : callable
        Returns the rate of each estimate, under the true quantity's name.
    hypotheses, cases, units
        As in `setting`. A unit holds for the quantity, its estimate and its error; rates have it over seconds.

    Returns
    -------
    Setting
        With ``x_hat`` (true minus error), ``x_dot``, ``x_hat_dot`` and ``x_tilde_dot`` defined for each estimated x.
    """
    true, estimated = dict(trace(plant)), dict(trace(observer))
    defined: dict[str, Any] = {f"{one}_hat": Name(one) - Name(f"{one}_tilde") for one in estimated}
    defined |= {f"{one}_dot": as_expr(true.get(one, 0)) for one in {**true, **estimated}}
    defined |= {f"{one}_hat_dot": as_expr(rate) for one, rate in estimated.items()}
    defined |= {f"{one}_tilde_dot": Name(f"{one}_dot") - Name(f"{one}_hat_dot") for one in estimated}
    known = dict(units or {})
    for one, unit in (units or {}).items():
        known |= {f"{one}_hat": unit, f"{one}_tilde": unit}
        known |= {f"{one}{mark}_dot": f"{unit} 1/s" if unit != "1" else "1/s" for mark in ("", "_hat", "_tilde")}
    return setting(name, text, defined, hypotheses, cases, known)


def with_lyapunov(where: Setting, candidate: Callable[..., Any], name: str = "V", unit: str = "") -> Setting:
    """The setting with a candidate and its derivative along the motion, ``V`` and ``V_dot``.

    Every parameter of the candidate that has a rate in the setting moves; the others stand still.

    Parameters
    ----------
    where : Setting
        From `error_setting`.
    candidate : callable
        V as a plain function; its parameters carry the names of the quantities.
    name : str
        What V is called.
    unit : str
        Unit of V, for the check of units.
    """
    parameters = inspect.signature(candidate).parameters
    moving = {one: Name(f"{one}_dot") for one in parameters if f"{one}_dot" in where.definitions}
    rate = rate_along(candidate, {one: Name(one) for one in parameters}, moving)
    units = {name: unit, f"{name}_dot": f"{unit} 1/s"} if unit else {}
    return where.extended(where.name, definitions={name: as_expr(trace(candidate)), f"{name}_dot": as_expr(rate)}, units=units)


def from_sympy(expression: Any) -> Expr:
    """The formula of a sympy expression made of symbols, rationals, sums, products, integer powers and absolute values.

    Parameters
    ----------
    expression : sympy expression
        In symbols that have the names of the quantities.

    Raises
    ------
    InputError
        For anything else.
    """
    import sympy

    if isinstance(expression, sympy.Symbol):
        return Name(expression.name)
    if isinstance(expression, sympy.Rational):
        return as_expr(Fraction(int(expression.p), int(expression.q)))
    parts = [from_sympy(arg) for arg in expression.args] if not isinstance(expression, sympy.Pow) else []
    if isinstance(expression, (sympy.Add, sympy.Mul)):
        result = parts[0]
        for part in parts[1:]:
            result = result + part if isinstance(expression, sympy.Add) else result * part
        return result
    if isinstance(expression, sympy.Pow) and isinstance(expression.exp, sympy.Integer):
        base, power = from_sympy(expression.base), int(expression.exp)
        return base**power if power >= 0 else Number(Fraction(1)) / (base ** -power if power < -1 else base)
    if isinstance(expression, sympy.Abs):
        return abs(parts[0])
    raise InputError(f"{expression}: only symbols, rationals, sums, products, integer powers and Abs are formulas here")


@dataclass(frozen=True)
class Audit:
    """Entries and mutants of a subject.

    Attributes
    ----------
    entries : list of Entry
        One a claim, settled.
    mutants : MutantReport
        How many mutants were tried and rejected.
    """

    entries: list[Entry]
    mutants: MutantReport

    @property
    def ok(self) -> bool:
        """No error of the tool, and no mutant missed."""
        return all(entry.ok for entry in self.entries) and self.mutants.ok

    def text(self) -> str:
        """The ledger in full, for a terminal."""
        from imo_analysis.ledger import show

        return "\n\n".join([*(show.full(entry) for entry in self.entries), show.summary(self.entries), self.mutants.text()])


def audit(claims: Sequence[Claim], kernels: Sequence[str] = ("sympy", "flint")) -> Audit:
    """Settle claims with kernels that must agree, and run all mutants of the true ones.

    Parameters
    ----------
    claims : sequence of Claim
        What is claimed.
    kernels : sequence of str
        Any of ``sympy``, ``flint``, ``coq``.
    """
    return Audit(settle(claims, [kernel(name) for name in kernels]), try_mutants(claims, kernels))
