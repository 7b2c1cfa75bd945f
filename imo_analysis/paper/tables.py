"""Tables I-III as printed. Decimals are kept as text, so that the number of printed digits is not lost."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from imo_analysis.paper.item import Item, Row

TABLE_I = Item(
    "table1", "Table I", "Section II-A", "The notation and the derived parameters.",
    (
        Row("sigma", "sigma = (L_s*L_r - L_m**2)/L_r"),
        Row("alpha", "alpha = R_r/L_r"),
        Row("beta", "beta = L_m/(sigma*L_r)"),
        Row("gamma", "gamma = R_s/sigma + alpha*beta*L_m"),
        Row("mu", "mu = 3*L_m/(2*L_r)"),
        Row("z_1", "z_1 = i_ds + beta*phi_dr"),
        Row("z_2", "z_2 = i_qs + beta*phi_qr"),
        Row("names", latex=r"L_s, L_M, L_r"),
    ),
)

TABLE_II = Item("table2", "Table II", "Section V", "Eigenvalues of the two observers at three values of omega_hat.")
TABLE_III = Item("table3", "Table III", "Section V", "The machine of the simulation.")
TABLES: tuple[Item, ...] = (TABLE_I, TABLE_II, TABLE_III)


@dataclass(frozen=True)
class Pair:
    """Two printed eigenvalues of a column, of which the conjugates are printed too.

    Attributes
    ----------
    column : str
        ``proposed`` or ``baseline``.
    omega_hat : int
        Estimated speed in rad/s.
    first, second : tuple of str
        Real and imaginary part in 1/s, as printed.
    """

    column: str
    omega_hat: int
    first: tuple[str, str]
    second: tuple[str, str]


# The scan sets both of the baseline's first two eigenvalues at 100 rad/s to -466.28 - 48.42i. Eigenvalues of a real matrix come
# in conjugate pairs, and the sum rule of the other five pairs needs the sign +.
EIGENVALUES: tuple[Pair, ...] = (
    Pair("proposed", 30, ("-347.97", "13.97"), ("-147.42", "16.03")),
    Pair("proposed", 60, ("-247.11", "384.43"), ("-248.28", "-324.43")),
    Pair("proposed", 100, ("-247.18", "718.75"), ("-248.21", "-618.75")),
    Pair("baseline", 30, ("-479.11", "14.55"), ("-16.28", "15.45")),
    Pair("baseline", 60, ("-474.37", "29.09"), ("-21.03", "30.91")),
    Pair("baseline", 100, ("-466.28", "48.42"), ("-29.11", "51.58")),
)


@dataclass(frozen=True)
class Parameter:
    """A row of Table III: printed symbol, our name, value as printed, unit as printed, meaning."""

    symbol: str
    name: str
    value: str
    unit: str
    meaning: str


PARAMETERS: tuple[Parameter, ...] = (
    Parameter("p", "n_p", "2", "", "pole pairs"),
    Parameter("J", "J", "0.0163", "kg m^2", "rotor inertia"),
    Parameter(r"R_s", "R_s", "0.439", "ohm", "stator resistance"),
    Parameter(r"R_r", "R_r", "0.41", "ohm", "rotor resistance"),
    Parameter(r"L_m", "L_m", "60.1e-3", "H", "mutual inductance"),
    Parameter(r"\sigma_s", "L_s - L_m", "1.4e-3", "H", "stator leakage inductance"),
    Parameter(r"\sigma_r", "L_r - L_m", "1.8e-3", "H", "rotor leakage inductance"),
    Parameter(r"\alpha", "alpha", "9.9354", "", "R_r / L_r"),
    Parameter(r"\phi^*", "flux_reference", "0.5307", "", "reference of the rotor flux"),
    Parameter(r"\omega^*", "omega_reference", "NA", "", "reference of the speed"),
)


def printed(name: str) -> Fraction:
    """The exact value of a row of Table III by our name."""
    return Fraction(next(row.value for row in PARAMETERS if row.name == name))
