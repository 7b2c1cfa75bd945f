"""The reduced matrix has the whole one's characteristic polynomial but for the poles that no gain moves: exactly."""

from random import Random

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import linear_sum_assignment

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.machine import preset
from imo_analysis.pencils.error import OperatingPoint, poles_at
from imo_analysis.pencils.jacobian import jacobian
from imo_analysis.pencils.reduced import reduced
from imo_analysis.pencils.sweep import evaluator

MACHINE = preset("table-iii-printed-alpha")
GAINS = {"k_1": 300.0, "k_2": 50.0, "kappa": 70.0, "k_3": 100.0, "g": 1.0, "K_p": 100.0, "alpha_l": 0.05, "delta": 0.01,
         "l_1": 160.0, "l_2": 12.0, "l_3": -0.08, "l_4": 0.35, "h": 100.0, "h_s": 0.03, "P_0": 4.0, "k": 1.5, "eta": 1.0,
         "S_0": 100.0}
FULL = [name for name in OBSERVERS if not name.endswith("printed_7") and name != "supervised"]


@pytest.mark.parametrize(("name", "kind"), [*((name, "frozen") for name in OBSERVERS), *((name, "full") for name in FULL)])
def test_the_polynomial_is_the_whole_ones_over_what_no_gain_moves(name: str, kind: str) -> None:
    derived = jacobian(name, kind)  # type: ignore[arg-type]
    n = len(derived.states)
    smaller = reduced(name, kind).matrix  # type: ignore[arg-type]
    random = Random(4)
    whole = derived.matrix[:n, :n]
    at = {symbol: sp.Rational(random.randint(1, 60), random.randint(1, 7)) for symbol in sorted(whole.free_symbols, key=str)}
    named = {symbol.name: symbol for symbol in whole.free_symbols}
    if kind == "full" and "z_1" in named:  # a steady state: the flux is L_m i_ds, along the frame
        at |= {named["z_1"]: at[named["i_ds"]] * (1 + at.get(named.get("L_m"), 2) * at.get(named.get("beta"), 3)),
               named["z_2"]: at[named["i_qs"]]}
    s = sp.Symbol("s")
    frame = next((value for symbol, value in at.items() if symbol.name == "stator_frequency"), 0)
    left_out = sp.Poly((s**2 + frame**2) * (s if kind == "full" else 1) if "xi_1_tilde" in derived.states else 1, s)
    assert smaller.rows == n - left_out.degree()
    assert whole.subs(at).charpoly(s) == smaller.subs(at).charpoly(s) * left_out


@pytest.mark.parametrize("name", FULL)
def test_moving_and_neutral_together_are_the_eigenvalues(name: str) -> None:
    gains = {gain: GAINS[gain] for gain in OBSERVERS[name].gains}
    speeds = np.array([-70.0, 25.0, 60.0])
    point = OperatingPoint(0.0, 0.5307, 3.0)
    found = evaluator(MACHINE, name, gains, "omega", point, "full")
    both = np.concatenate([found.moving(speeds), found.neutral(speeds)], axis=-1)
    for row, omega in zip(both, speeds, strict=True):
        expected = poles_at(MACHINE, name, gains, OperatingPoint(omega, 0.5307, 3.0), "full")
        distance = np.abs(row[:, None] - expected[None, :])
        assert distance[linear_sum_assignment(distance)].max() < 1e-9 * np.abs(row).max()


def test_what_has_no_full_linearisation_is_refused() -> None:
    with pytest.raises(InputError, match="no time-invariant linearisation"):
        reduced("printed_7", "full")
