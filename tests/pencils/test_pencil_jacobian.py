"""The symbolic error dynamics against exact dual numbers, entry by entry, for every observer."""

from fractions import Fraction
from random import Random
from typing import Any

import pytest
import sympy as sp
from oracle_pencils import columns

from imo_analysis.equations import plant, transformation
from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS, RUNNING_GRAM
from imo_analysis.errors import InputError
from imo_analysis.pencils.jacobian import commutes_with_rotation, jacobian, structural_rank


def _case(seed: int, name: str) -> dict[str, Fraction]:
    """Rational numbers for everything that the error dynamics can depend on; xi equals z, as in truth."""
    random = Random(seed)
    values = {symbol: Fraction(random.randint(1, 90), random.randint(1, 9)) for symbol in PARAMETERS}
    values |= {gain: Fraction(random.randint(-90, 90), random.randint(1, 9)) for gain in OBSERVERS[name].gains}
    for symbol in ("i_ds", "i_qs", "z_1", "z_2", "omega", "stator_frequency", "u_ds", "u_qs", *RUNNING_GRAM):
        values[symbol] = Fraction(random.randint(-90, 90), random.randint(1, 9))
    values |= {"alpha_l": values["alpha"] / 3, "delta": values["alpha"] / 9, "direction": Fraction(random.choice((-1, 1))),
               "R_s_shift": Fraction(0)}
    values["phi_dr"], values["phi_qr"] = transformation.from_z(*(values[s] for s in ("i_ds", "i_qs", "z_1", "z_2", "beta")))
    return values


def _by_duals(name: str, kind: str, v: dict[str, Fraction]) -> list[list[Fraction]]:
    """The same matrix as `jacobian`, by running the definitions on dual numbers."""
    observer = OBSERVERS[name]
    bases = [state.removesuffix("_hat") for state in observer.states]
    kept = [b for b in bases if kind == "full" or b not in ("alpha", "omega", "R_s_shift", *RUNNING_GRAM)]
    true = {b: v[{"xi_1": "z_1", "xi_2": "z_2"}.get(b, b)] for b in bases}
    p = tuple(v[symbol] for symbol in PARAMETERS)
    moving = [b for b in ("alpha", "omega") if b in kept]

    def difference(seeds: list[Any]) -> list[Any]:
        errors = dict(zip(kept, seeds[: len(kept)], strict=True))
        i_d, i_q, u_d, u_q, *rates_of = seeds[len(kept):]
        estimate = tuple(true[b] - errors.get(b, 0) for b in bases)
        i, u = (v["i_ds"] + i_d, v["i_qs"] + i_q), (v["u_ds"] + u_d, v["u_qs"] + u_q)
        gains = tuple(v[gain] for gain in observer.gains)
        hat = dict(zip(bases, observer.rates(estimate, i, u, v["direction"], p, gains), strict=True))
        told = (v["u_ds"], v["u_qs"])
        z = plant.plant_z((v["i_ds"], v["i_qs"], v["z_1"], v["z_2"]), told, v["omega"], 0, p)
        whole = plant.plant((v["i_ds"], v["i_qs"], v["phi_dr"], v["phi_qr"], v["omega"]), told, 0, 0, (*p, 0, 0, 1))
        machine = {"i_ds": z[0], "i_qs": z[1], "z_1": z[2], "z_2": z[3], "xi_1": z[2], "xi_2": z[3], "phi_dr": whole[2],
                   "phi_qr": whole[3], **dict.fromkeys((*RUNNING_GRAM, "R_s_shift"), 0),
                   **dict(zip(moving, rates_of, strict=True))}
        rows = {b: machine[b] - hat[b] for b in kept}
        if kind == "full":
            vectors = [b for b in kept if b not in ("alpha", "omega", "R_s_shift", "S")]
            for d, q in zip(vectors[::2], vectors[1::2], strict=True):
                rows[d], rows[q] = rows[d] + v["stator_frequency"] * errors[q], rows[q] - v["stator_frequency"] * errors[d]
        outputs = [errors[b] for b in kept]
        if "phi_dr" not in kept:
            flux = observer.flux(estimate, i, v["beta"])
            outputs += [v["phi_dr"] - flux[0], v["phi_qr"] - flux[1]]
        return [*rows.values(), *outputs]

    return columns(difference, [Fraction(0)] * (len(kept) + 4 + len(moving)))


@pytest.mark.parametrize("name", OBSERVERS)
@pytest.mark.parametrize("kind", ["frozen", "full"])
def test_every_entry_equals_the_dual_number_jacobian(name: str, kind: Any) -> None:
    if kind == "full" and not commutes_with_rotation(name):
        with pytest.raises(InputError, match="no time-invariant linearisation"):
            jacobian(name, kind)
        return
    derived = jacobian(name, kind)
    for seed in range(3):
        v = _case(seed, name)
        exact = {s: sp.Rational(v[s.name].numerator, v[s.name].denominator) for s in derived.matrix.free_symbols}
        symbolic = derived.matrix.xreplace(exact)
        for r, row in enumerate(_by_duals(name, kind, v)):
            for c, entry in enumerate(row):
                assert symbolic[r, c] == sp.Rational(entry.numerator, entry.denominator), (derived.outputs, r, c)


@pytest.mark.parametrize("name", OBSERVERS)
def test_the_compiled_function_is_the_symbolic_matrix(name: str) -> None:
    derived = jacobian(name)
    v = _case(5, name)
    numbers = derived.evaluate({argument: float(v[argument]) for argument in derived.arguments})
    exact = {s: sp.Rational(v[s.name].numerator, v[s.name].denominator) for s in derived.matrix.free_symbols}
    symbolic = derived.matrix.xreplace(exact)
    for r in range(symbolic.rows):
        for c in range(symbolic.cols):
            assert numbers[r, c] == pytest.approx(float(symbolic[r, c]), rel=1e-13, abs=1e-13)


def test_only_the_feedback_of_7_depends_on_the_axes() -> None:
    assert [name for name in OBSERVERS if not commutes_with_rotation(name)] == ["luenberger_printed_7", "printed_7"]


def test_the_adaptive_observers_have_two_poles_at_zero_that_no_gain_moves() -> None:
    assert {name: len(jacobian(name).states) - structural_rank(name) for name in OBSERVERS} == {
        name: 2 if "xi_1_hat" in OBSERVERS[name].states else 0 for name in OBSERVERS}


def test_unknown_observer() -> None:
    with pytest.raises(InputError, match=r"observer = 'kalman' is not known; choose one of: baseline"):
        jacobian("kalman")
