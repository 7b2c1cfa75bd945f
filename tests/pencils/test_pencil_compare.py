"""Gains by one rule: against the exact rule where there is one, and what it says of the baseline."""

import numpy as np
import pytest

from imo_analysis.drawing import svg_text
from imo_analysis.errors import InputError
from imo_analysis.machine import preset
from imo_analysis.pencils.compare import best_gains, compare
from imo_analysis.pencils.error import OperatingPoint, poles_at

MACHINE = preset("table-iii-printed-alpha")


def test_the_search_finds_what_the_exact_rule_gives() -> None:
    """With b = a - 2 delta the fastest pole is (delta + b) sqrt(1 + omega^2 / b^2): `tune`'s rule solved for delta, best b."""
    omega_max, fastest = 150.0, 600.0
    b = np.linspace(1.0, fastest, 200_001)
    by_hand = (fastest / np.sqrt(1 + omega_max**2 / b**2) - b).max()
    data = compare(MACHINE, omega_max, fastest, observers=("consistent_12", "repaired", "baseline"), points=61).data
    assert data["slowest_decay"].sel(observer=["consistent_12", "repaired"]).values == pytest.approx(by_hand, rel=1e-6)
    # the baseline's slow pole does not get past -alpha + j omega, whatever its constant gains
    assert data["slowest_decay"].sel(observer="baseline").item() == pytest.approx(MACHINE.alpha, rel=1e-6)
    assert np.all(data["reached"] <= fastest * (1 + 1e-6))
    # decay and damping over the speed are those of the whole matrix with the gains that were found
    for name in ("baseline", "repaired"):
        one = data.sel(observer=name).isel(fastest=0)
        gains = {str(k): float(v) for k, v in zip(one["gain"].values, one["gains"].values, strict=True) if np.isfinite(v)}
        for k in (0, 17, 60):
            omega = float(one["omega"][k])
            roots = poles_at(MACHINE, name, gains, OperatingPoint(omega, None))
            roots = roots[np.argsort(np.abs(roots))[-4:]]
            assert one["decay"].values[k] == pytest.approx(-roots.real.max(), rel=1e-6)


def test_the_picture_and_the_range() -> None:
    found = compare(MACHINE, 100.0, [200.0], omega_min=20.0, observers=("baseline_scheduled",), points=21)
    assert np.isnan(found.data["decay"].sel(omega=10.0)).all() and np.isfinite(found.data["decay"].sel(omega=20.0)).all()
    assert "<svg" in svg_text(found.plot())
    assert found.data["slowest_decay"].item() > 0


def test_the_same_seed_gives_the_same_gains() -> None:
    assert best_gains(MACHINE, "baseline_scheduled", 50.0, 200.0) == best_gains(MACHINE, "baseline_scheduled", 50.0, 200.0)


@pytest.mark.parametrize(("arguments", "message"), [
    ((150.0, -1.0), "fastest = -1.0 must be above 0"),
    ((150.0, []), "must be above 0"),
    ((0.0, 100.0), "must be 0 <= omega_min < omega_max"),
    ((100.0, 100.0, 200.0), "must be 0 <= omega_min < omega_max"),
    ((100.0, 100.0, 0.0, ("printed_7",)), "'printed_7' has no gains to search for"),
])
def test_refusals(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(InputError, match=message):
        compare(MACHINE, *arguments)  # type: ignore[arg-type]
