"""The tuning rule against python-control's poles, its exactness, and where it refuses."""

import numpy as np
import pytest

from imo_analysis.cli import main
from imo_analysis.errors import InputError
from imo_analysis.machine import preset
from imo_analysis.pencils.error import OperatingPoint, frozen_pencil, poles_at
from imo_analysis.pencils.pole_rule import tune

MACHINE = preset("table-iii-printed-alpha")


@pytest.mark.parametrize(("decay", "damping", "omega"), [(50.0, 0.7, 150.0), (100.0, 0.5, 300.0), (200.0, 0.3, 60.0)])
def test_the_rule_is_exact_at_every_speed(decay: float, damping: float, omega: float) -> None:
    """Slow pole -delta (1 + j omega/b), fast pole -(delta + b) (1 - j omega/b), by python-control's own poles."""
    found = tune(MACHINE, "consistent_12", decay, damping, omega)
    b = MACHINE.R_s / MACHINE.sigma + found.gains["k_1"] - 2 * decay
    for speed in (-omega, 0.3 * omega, omega):
        poles = frozen_pencil(MACHINE, "consistent_12", found.gains, speed).poles()
        for expected in (-decay * (1 + 1j * speed / b), -(decay + b) * (1 - 1j * speed / b)):
            for value in (expected, expected.conjugate()):
                assert np.abs(poles - value).min() < 1e-8 * abs(value)
    assert found.decay == pytest.approx(decay, rel=1e-9)
    assert found.damping == pytest.approx(damping, rel=1e-9) or found.gains["k_1"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("observer", ["repaired", "baseline"])
def test_the_wish_is_met_over_the_range_and_not_by_far(observer: str) -> None:
    wish = (40.0, 0.6, 120.0) if observer == "repaired" else (5.0, 0.3, 150.0)
    found = tune(MACHINE, observer, *wish)
    assert found.decay >= wish[0] * (1 - 1e-9) and found.damping >= wish[1] * (1 - 1e-9)
    for speed in np.linspace(-wish[2], wish[2], 41):
        moving = [p for p in frozen_pencil(MACHINE, observer, found.gains, speed).poles() if abs(p) > 1e-6]
        assert len(moving) == 4
        assert max(p.real for p in moving) <= -wish[0] * (1 - 1e-6)
        assert min(-p.real / abs(p) for p in moving) >= wish[1] * (1 - 1e-6)
    assert found.decay == pytest.approx(wish[0], rel=0.05) or found.damping == pytest.approx(wish[1], rel=0.05)


def test_routh_criterion_decides_exactly() -> None:
    """D a little above and below delta (delta + b) (1 + omega^2 / b^2): all poles faster than delta, or one slower."""
    random = np.random.default_rng(2)
    rho = MACHINE.R_s / MACHINE.sigma
    for _ in range(40):
        delta, b, omega = random.uniform(1, 200), random.uniform(1, 500), random.uniform(-300, 300)
        limit = delta * (delta + b) * (1 + omega**2 / b**2)
        for factor, meets in ((1 + 1e-6, True), (1 - 1e-6, False)):
            gains = {"k_1": 2 * delta + b - rho, "k_2": 0.0, "k_3": factor * limit / MACHINE.alpha}
            poles = poles_at(MACHINE, "consistent_12", gains, OperatingPoint(omega, None))
            moving = poles[np.argsort(np.abs(poles))[2:]]
            assert bool(moving.real.max() < -delta) is meets


def test_baseline_with_constant_gains_cannot_be_faster_than_alpha_from_standstill_on() -> None:
    with pytest.raises(InputError, match="no constant gains of baseline were found for decay 11 /s"):
        tune(MACHINE, "baseline", 11.0, 0.05, 3000.0)


@pytest.mark.parametrize(("observer", "wish", "message"), [
    ("printed_7", (50.0, 0.7, 150.0), "has no tuning rule"),
    ("repaired", (-1.0, 0.7, 150.0), "decay = -1.0 must be above 0"),
    ("repaired", (float("nan"), 0.7, 150.0), "decay = nan"),
    ("repaired", (50.0, 1.0, 150.0), "damping = 1.0 must lie between 0 and 1"),
    ("repaired", (50.0, 0.7, 0.0), "must be 0 <= omega_min < omega_max"),
    ("repaired", (5e6, 0.7, 150.0), "were found for decay"),
])
def test_refusals(observer: str, wish: tuple[float, float, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        tune(MACHINE, observer, *wish)


def test_from_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["poles", "--tune", "50:0.7:150", "--observer", "consistent_12", "--omega", "60"]) == 0
    out = capsys.readouterr().out
    assert "give decay 50 /s, damping 0.700" in out and "-50.00" in out
    assert main(["poles", "--tune", "50:0.7"]) == 2
    assert "must be DECAY:DAMPING:OMEGA_MAX" in capsys.readouterr().err
