"""Stability boundaries against Routh's criterion for complex coefficients, in exact and 50-digit arithmetic.

``s^2 + (p_1 + j p_2) s + q_1 + j q_2`` is stable exactly when ``p_1 > 0`` and ``p_1^2 q_1 + p_1 p_2 q_2 - q_2^2 > 0``.
"""

from fractions import Fraction

import mpmath
import numpy as np
import pytest

from imo_analysis.errors import InputError
from imo_analysis.machine import preset
from imo_analysis.pencils.boundaries import stability_boundaries
from imo_analysis.pencils.setup import Setup
from imo_analysis.pencils.stability import stability_map
from imo_analysis.pencils.sweep import OperatingPoint, grid, pole_sweep

MACHINE = preset("table-iii-printed-alpha")
LUENBERGER = {"k_1": 300.0, "k_2": 50.0, "K_p": 100.0}
BASELINE = {"l_1": 20.0, "l_2": 15.0, "l_3": -0.5, "l_4": -0.6, "h": 100.0}


def test_luenberger_boundary_in_k_2_exactly() -> None:
    """p = a - j w and q = k_2 w (w + j alpha), so the boundary k_2 = a (a - alpha) / alpha^2 has no speed in it."""
    a = Fraction(MACHINE.R_s) / Fraction(MACHINE.sigma) + 300
    alpha = Fraction(MACHINE.alpha)
    exact = float(a * (a - alpha) / alpha**2)
    for omega in (-80.0, 3.0, 60.0):
        found = stability_boundaries(Setup("luenberger_consistent_12", MACHINE, LUENBERGER), {"k_2": grid(0.5, 5000.0, 60)},
                                     OperatingPoint(omega, None))
        assert len(found) == 2 and all(one["direction"] == 1.0 for one in found)
        assert [one["value"] for one in found] == pytest.approx([exact, exact], rel=1e-10)


def _baseline_limits() -> list[float]:
    """Zeros over the speed of the criterion for (2)-(3), a polynomial of the second degree, with 50 digits."""
    with mpmath.workdps(50):
        R_s, sigma, alpha, beta, L_m = (mpmath.mpf(getattr(MACHINE, n)) for n in ("R_s", "sigma", "alpha", "beta", "L_m"))
        l_1, l_2, l_3, l_4 = (mpmath.mpf(BASELINE[f"l_{k}"]) for k in range(1, 5))
        p_1 = R_s / sigma + alpha * beta * L_m + l_1 + alpha
        x, y = R_s / sigma + l_1 + beta * l_3, l_2 + beta * l_4

        def criterion(w: mpmath.mpf) -> mpmath.mpf:
            q_1, q_2, p_2 = alpha * x + w * y, alpha * y - w * x, l_2 - w
            return p_1**2 * q_1 + p_1 * p_2 * q_2 - q_2**2

        # a polynomial of the second degree in w: three values give it
        c_0, plus, minus = criterion(mpmath.mpf(0)), criterion(mpmath.mpf(1)), criterion(mpmath.mpf(-1))
        c_2, c_1 = (plus + minus) / 2 - c_0, (plus - minus) / 2
        assert abs(criterion(mpmath.mpf(7)) - (c_0 + 7 * c_1 + 49 * c_2)) < mpmath.mpf(10) ** -30
        return sorted(float(root.real) for root in mpmath.polyroots([c_2, c_1, c_0]) if abs(root.imag) < 1e-30)


def test_baseline_boundaries_in_the_speed_to_50_digits() -> None:
    setup = Setup("baseline", MACHINE, BASELINE)
    inside = [value for value in _baseline_limits() if abs(value) < 400]
    assert inside, "the case must have a boundary"
    found = sorted({round(one["value"], 12) for one in stability_boundaries(setup, {"omega": grid(-400.0, 400.0, 81)})})
    assert len(found) == len(inside)
    assert found == pytest.approx(inside, rel=1e-9)
    # a boundary that falls on a value of the sweep is found there, not beside it
    shifted = grid(inside[0] - 40.0, inside[0] + 40.0, 5)
    on = stability_boundaries(setup, {"omega": shifted})
    assert on and on[0]["value"] == pytest.approx(inside[0], rel=1e-9)
    limit = stability_map(setup, {"omega": grid(-400.0, 400.0, 81), "h": [1.0, 2.0]}).data["limit_omega"].values
    assert np.sort(limit[np.isfinite(limit)]) == pytest.approx(np.repeat(inside, 2), rel=1e-9)


def test_a_pole_that_rests_on_the_axis_is_no_boundary() -> None:
    """Without z feedback the Luenberger observer of known alpha has two poles at zero at every speed."""
    still = Setup("luenberger_consistent_12", MACHINE, LUENBERGER | {"k_2": 0.0})
    assert stability_boundaries(still, {"omega": grid(-100.0, 100.0, 21)}) == []
    rows = stability_map(still, {"omega": grid(-100.0, 100.0, 21), "k_1": [100.0, 300.0]}).data
    assert rows.sizes["crossing"] == 0 and np.all(rows["decay"].values == 0)


def test_a_sweep_of_one_point_is_a_point() -> None:
    setup = Setup("baseline", MACHINE, BASELINE)
    assert stability_boundaries(setup, {"omega": [5.0]}) == []
    assert dict(pole_sweep(setup, {"omega": [5.0]}).data.sizes) == {"omega": 1, "branch": 4}


def test_boundaries_over_two_parameters_are_the_maps() -> None:
    with pytest.raises(InputError, match="along one parameter; stability_map finds those over two"):
        stability_boundaries(Setup("baseline", MACHINE, BASELINE), {"omega": [1.0, 2.0], "l_1": [1.0, 2.0]})
