"""Table I once: symbol, Python name, LaTeX, unit, meaning. Every other module takes its names from here.

Three suffixes make further names by rule: ``_hat`` (an estimate), ``_tilde`` (true minus estimate) and ``_dot`` (the time
derivative, written last), so ``alpha_hat_dot`` is the rate of the estimate of alpha.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction

from imo_analysis.errors import InputError


@dataclass(frozen=True)
class Symbol:
    """One quantity.

    Attributes
    ----------
    name : str
        The Python name, used in equations, data sets and files.
    latex : str
        The printed symbol.
    unit : str
        SI unit; ``1`` for a pure number. Radians are kept in the text and have no dimension.
    meaning : str
        What it is, in a line.
    source : str
        Where the paper introduces it; ``ours`` where the paper has no such symbol.
    """

    name: str
    latex: str
    unit: str
    meaning: str
    source: str = "Table I"


def _table() -> dict[str, Symbol]:
    rows = [
        ("i_ds", r"i_{ds}", "A", "stator current, d axis", "Table I"),
        ("i_qs", r"i_{qs}", "A", "stator current, q axis", "Table I"),
        ("u_ds", r"u_{ds}", "V", "stator voltage, d axis", "Table I"),
        ("u_qs", r"u_{qs}", "V", "stator voltage, q axis", "Table I"),
        ("phi_dr", r"\phi_{dr}", "Wb", "rotor flux linkage, d axis", "Table I"),
        ("phi_qr", r"\phi_{qr}", "Wb", "rotor flux linkage, q axis", "Table I"),
        ("omega", r"\omega", "rad/s", "rotor speed, electrical (pole pairs times the shaft's speed)", "Table I"),
        ("omega_m", r"\omega_m", "rad/s", "rotor speed, mechanical", "ours"),
        ("omega_1", r"\omega_1", "rad/s", "speed of the reference frame; 0 is the stationary frame", "Table I"),
        ("T_l", r"T_l", "N m", "load torque on the shaft", "Table I"),
        ("J", r"J", "kg m^2", "inertia of rotor and load", "Table I"),
        ("L_s", r"L_s", "H", "stator inductance", "Table I"),
        ("L_m", r"L_m", "H", "mutual inductance (Table I prints L_M)", "Table I"),
        ("L_r", r"L_r", "H", "rotor inductance", "Table I"),
        ("R_s", r"R_s", "ohm", "stator resistance", "Table I"),
        ("R_r", r"R_r", "ohm", "rotor resistance", "Table I"),
        ("sigma", r"\sigma", "H", "(L_s L_r - L_m^2) / L_r, the total leakage inductance seen by the stator", "Table I"),
        ("alpha", r"\alpha", "1/s", "R_r / L_r, the inverse of the rotor time constant", "Table I"),
        ("beta", r"\beta", "1/H", "L_m / (sigma L_r)", "Table I"),
        ("gamma", r"\gamma", "1/s", "R_s / sigma + alpha beta L_m", "Table I"),
        ("mu", r"\mu", "1/(kg m^2)", "3 n_p^2 L_m / (2 J L_r); Table I prints 3 L_m / (2 L_r)", "Table I"),
        ("z_1", r"z_1", "A", "i_ds + beta phi_dr: stator flux over sigma, d axis", "Table I"),
        ("z_2", r"z_2", "A", "i_qs + beta phi_qr: stator flux over sigma, q axis", "Table I"),
        ("xi_1", r"\xi_1", "A", "the second copy of z_1 in the adaptive observer", "(8)"),
        ("xi_2", r"\xi_2", "A", "the second copy of z_2 in the adaptive observer", "(8)"),
        ("n_p", r"n_p", "1", "number of pole pairs (Table III prints p)", "Table III"),
        ("B", r"B", "N m s", "viscous friction of the shaft", "ours"),
        ("k_1", r"k_1", "1/s", "current feedback gain", "(7)"),
        ("k_2", r"k_2", "1", "z feedback gain of (7), multiplied by omega_hat", "(7)"),
        ("kappa", r"\kappa", "1/s", "z feedback gain of the repaired observer, in place of k_2 omega_hat", "ours"),
        ("k_3", r"k_3", "1/s", "xi feedback gain", "(8)"),
        ("g", r"g", "1/(A^2 s^2)", "gain of the alpha adaptation", "(9)"),
        ("K_p", r"K_p", "1/(A^2 s^2)", "gain of the speed adaptation", "(11)"),
        ("h", r"h", "1/(A^2 s^2)", "gain of the baseline speed adaptation", "(4)"),
        ("k", r"k", "1", "poles of the baseline over the machine's, where its gain is scheduled on the speed", "ours"),
        ("h_s", r"h_s", "ohm/(A^2 s)", "gain of the stator resistance adaptation of the baseline", "ours"),
        ("P_0", r"P_0", "Wb^3 A/s", "power across the air gap, times |phi|^2 L_r / L_m, below which R_s rests", "ours"),
        ("R_s_shift", r"\Delta R_s", "ohm", "what an observer adds to the stator resistance that it was given", "ours"),
        ("l_1", r"l_1", "1/s", "baseline gain, current rows, along the error", "(3)"),
        ("l_2", r"l_2", "1/s", "baseline gain, current rows, across the error", "(3)"),
        ("l_3", r"l_3", "ohm", "baseline gain, flux rows, along the error", "(3)"),
        ("l_4", r"l_4", "ohm", "baseline gain, flux rows, across the error", "(3)"),
        ("alpha_l", r"\alpha_l", "1/s", "value below which the projection acts", "(10)"),
        ("delta", r"\delta", "1/s", "width of the layer in which the projection acts", "(10)"),
        ("rho", r"\rho", "1/s^2", "the signal that is projected", "(10)"),
        ("direction", r"s", "1", "direction of rotation, sgn(omega): +1 or -1", "Remark III.1"),
        ("slip", r"\omega_{sl}", "rad/s", "slip frequency, stator_frequency - omega", "ours"),
        ("stator_frequency", r"\omega_s", "rad/s", "electrical frequency of flux and currents", "ours"),
        ("torque", r"T_e", "N m", "electromagnetic torque", "ours"),
        ("V", r"V", "A^2", "Lyapunov function", "(13)"),
        ("t", r"t", "s", "time", "ours"),
        ("m_1d", r"\bar{v}_{1d}", "A", "running mean of v_1, d axis", "ours"),
        ("m_1q", r"\bar{v}_{1q}", "A", "running mean of v_1, q axis", "ours"),
        ("m_2d", r"\bar{v}_{2d}", "A", "running mean of v_2, d axis", "ours"),
        ("m_2q", r"\bar{v}_{2q}", "A", "running mean of v_2, q axis", "ours"),
        ("S", r"S", "A^2", "running mean square of what v_1 holds beyond its mean and across v_2", "ours"),
        ("eta", r"\eta", "1/s", "forgetting rate of the running Gram matrix", "ours"),
        ("S_0", r"S_0", "A^2", "excitation at which the supervisor is half open", "ours"),
        ("T", r"T", "s", "length of the excitation window", "(19)"),
        ("m", r"m", "1", "excitation level", "(19)"),
    ]
    return {row[0]: Symbol(*row) for row in rows}


SYMBOLS: dict[str, Symbol] = _table()
_GREEK = ("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda", "mu", "nu", "xi", "rho",
          "sigma", "tau", "phi", "chi", "psi", "omega")


def _shorthands() -> dict[str, Symbol]:
    rows = [
        ("i", r"i", "A", "stator current as a d/q pair, i_ds + j i_qs in complex shorthand"),
        ("i_d", r"i_d", "A", "stator current along the rotor flux, or d axis of any frame"),
        ("i_q", r"i_q", "A", "stator current across the rotor flux, or q axis of any frame"),
        ("u", r"u", "V", "stator voltage as a d/q pair"),
        ("u_d", r"u_d", "V", "stator voltage, d axis of any frame"),
        ("u_q", r"u_q", "V", "stator voltage, q axis of any frame"),
        ("z", r"z", "A", "z_1 and z_2 as a pair"),
        ("xi", r"\xi", "A", "xi_1 and xi_2 as a pair"),
        ("phi", r"\phi", "Wb", "rotor flux linkage as a pair"),
        ("psi", r"\psi", "Wb", "magnitude of the rotor flux linkage"),
        ("psi_0", r"\psi_0", "Wb", "its mean where it is modulated"),
        ("psi_ds", r"\psi_{ds}", "Wb", "stator flux linkage, d axis"),
        ("psi_qs", r"\psi_{qs}", "Wb", "stator flux linkage, q axis"),
        ("v_1", r"v_1", "A", "how an error of alpha acts on the currents, a pair: xi_hat - (1 + beta L_m) i"),
        ("v_2", r"v_2", "A", "how an error of the speed acts on the currents, a pair: -j (z_hat - i_hat)"),
        ("w", r"w", "A/s", "what the currents see of the errors of xi and z, a pair: alpha xi_tilde - j omega z_tilde"),
        ("w_1", r"w_1", "A/s", "w, d axis"),
        ("w_2", r"w_2", "A/s", "w, q axis"),
        ("q_1", r"q_1", "A/s", "what the repaired observer conserves, d axis"),
        ("q_2", r"q_2", "A/s", "what the repaired observer conserves, q axis"),
        ("omega_s", r"\omega_s", "rad/s", "stator_frequency, in formulas"),
        ("T_e", r"T_e", "N m", "torque, in formulas"),
    ]
    return {row[0]: Symbol(*row, source="ours") for row in rows}


SHORTHANDS: dict[str, Symbol] = _shorthands()  # in texts only: no data set and no file has these names
_declared: dict[str, Symbol] = {}  # of the observers' files that this process has loaded


def in_table(name: str) -> bool:
    """Whether the table itself has a name, taken apart by its suffixes."""
    while name not in SYMBOLS:
        bare = re.sub("_(hat|tilde|dot)$", "", name)
        if bare == name:
            return False
        name = bare
    return True


def declare(name: str, unit: str, where: str) -> None:
    """Add a name of a user's observer that the table does not have, with its unit; `symbol` knows it from then on.

    Parameters
    ----------
    name : str
        Of a gain or a state. With it goes the quantity that a state ``NAME_hat`` estimates.
    unit : str
        SI unit; ``1`` for a pure number.
    where : str
        The file.

    Raises
    ------
    InputError
        If the unit cannot be read, or another file has the name with another unit: in one process a name has one meaning.
    """
    dimension(unit)
    base = name.removesuffix("_hat")
    before = _declared.get(base)
    if before is not None and before.unit != unit and before.source != where:
        raise InputError(f"{name} is in {unit!r}, and {before.source} has it in {before.unit!r}; give one of them another name")
    head, _, rest = base.partition("_")
    letter = head if len(head) == 1 else rf"\{head}" if head in _GREEK else rf"\mathrm{{{head}}}"
    latex = letter + (f"_{{{rest.replace('_', ',')}}}" if rest else "")
    _declared[base] = Symbol(base, latex, unit, base, where)


def symbol(name: str) -> Symbol:
    """The symbol for a name, with the suffixes ``_hat``, ``_tilde`` and ``_dot`` taken apart.

    Parameters
    ----------
    name : str
        A name of the table, with any suffixes.

    Raises
    ------
    InputError
        If the name is not in the table.
    """
    if name in SYMBOLS:
        return SYMBOLS[name]
    if name in _declared:
        return _declared[name]
    for suffix, accent, words in (
        ("_dot", r"\dot", "rate of the "),
        ("_hat", r"\hat", "estimate of the "),
        ("_tilde", r"\tilde", "error (true minus estimate) of the "),
    ):
        if name.endswith(suffix):
            base = symbol(name.removesuffix(suffix))
            unit = over_time(base.unit) if suffix == "_dot" else base.unit
            meaning = words + base.meaning.removeprefix("the ")
            return Symbol(name, _accented(accent, base.latex), unit, meaning, base.source)
    raise InputError(f"no symbol {name!r} in the notation table (imo_analysis/notation.py)")


def _accented(accent: str, latex: str) -> str:
    """Put the accent on the letter alone: ``i_{ds}`` becomes ``\\hat{i}_{ds}``."""
    head, mark, rest = latex.partition("_")
    return f"{accent}{{{head}}}{mark}{rest}"


def over_time(unit: str) -> str:
    """The unit of a time derivative."""
    simple = {"1": "1/s", "1/s": "1/s^2", "rad/s": "rad/s^2", "s": "1"}
    return simple.get(unit, f"{unit}/s" if "/" not in unit else f"{unit} 1/s")


# Exponents of (kg, m, s, A).
Dimension = tuple[Fraction, Fraction, Fraction, Fraction]
_BASE = {
    "1": (0, 0, 0, 0),
    "rad": (0, 0, 0, 0),
    "kg": (1, 0, 0, 0),
    "m": (0, 1, 0, 0),
    "s": (0, 0, 1, 0),
    "A": (0, 0, 0, 1),
    "N": (1, 1, -2, 0),
    "J": (1, 2, -2, 0),
    "W": (1, 2, -3, 0),
    "V": (1, 2, -3, -1),
    "ohm": (1, 2, -3, -2),
    "Wb": (1, 2, -2, -1),
    "H": (1, 2, -2, -2),
    "Hz": (0, 0, -1, 0),
}
_TOKEN = re.compile(r"\s*(?:([A-Za-z]+|1)(?:\^(-?\d+))?|([/()]))")


def dimension(unit: str) -> Dimension:
    """Exponents of (kg, m, s, A) of a unit such as ``1/(A^2 s^2)`` or ``kg m^2``.

    A space multiplies; a slash divides by the one factor, or the bracket, that follows it.

    Parameters
    ----------
    unit : str
        As the table writes units.

    Raises
    ------
    InputError
        If the unit holds something unknown.
    """
    total = [Fraction(0)] * 4
    signs = [1]  # one entry an open bracket
    divide = False
    position = 0
    while position < len(unit.rstrip()):
        match = _TOKEN.match(unit, position)
        if not match or (match[1] and match[1] not in _BASE):
            raise InputError(f"unit {unit!r}: cannot read {unit[position:].strip()!r}; known: {', '.join(_BASE)}")
        position = match.end()
        if match[3] == "/":
            divide = True
        elif match[3] == "(":
            signs.append(signs[-1] * (-1 if divide else 1))
            divide = False
        elif match[3] == ")":
            if len(signs) == 1:
                raise InputError(f"unit {unit!r}: a bracket is closed that was not opened")
            signs.pop()
        else:
            power = signs[-1] * (-1 if divide else 1) * int(match[2] or 1)
            total = [have + power * one for have, one in zip(total, _BASE[match[1]], strict=True)]
            divide = False
    return (total[0], total[1], total[2], total[3])
