"""Stability over two parameters against single sweeps and limits worked out by hand, and its pictures."""

import numpy as np
import pytest

from imo_analysis.drawing import svg_text
from imo_analysis.errors import InputError
from imo_analysis.machine import preset
from imo_analysis.pencils.error import OperatingPoint, full_pencil
from imo_analysis.pencils.setup import Setup
from imo_analysis.pencils.stability import stability_map
from imo_analysis.pencils.sweep import grid, pole_sweep

MACHINE = preset("table-iii-printed-alpha")
GAINS = {"k_1": 300.0, "k_2": 50.0, "k_3": 100.0, "g": 1.0, "K_p": 100.0, "alpha_l": 0.05, "delta": 0.01}


SETUP = Setup("consistent_12", MACHINE, GAINS)
PRINTED = Setup("printed_L", MACHINE, GAINS)


def test_map_agrees_with_single_sweeps() -> None:
    omega, k_2 = np.linspace(1.0, 60.0, 7), np.linspace(0.0, 80.0, 5)
    data = stability_map(PRINTED, {"omega": omega, "k_2": k_2}).data
    assert data["decay"].dims == ("observer", "k_2", "omega") and data["k_2"].attrs["units"] == "1"
    decay = data["decay"].sel(observer="printed_L").values
    for k, gain in enumerate(k_2):
        single = pole_sweep(Setup("printed_L", MACHINE, {**GAINS, "k_2": gain}), {"omega": omega}).data
        moving = single["re"].where(~single["neutral"])
        assert decay[k] == pytest.approx(-moving.max("branch").values, rel=1e-9, abs=1e-9)
        damping = single["damping"].where(~single["neutral"]).min("branch").values
        assert data["damping"].values[0, k] == pytest.approx(damping, rel=1e-9, abs=1e-12)
    # the limit of stability is alpha k_3 = k_2 omega^2
    stable = MACHINE.alpha * GAINS["k_3"] > k_2[:, None] * omega[None, :] ** 2
    assert np.array_equal(decay > 0, stable)
    settling = data["settling_time"].values[0]
    assert np.array_equal(np.isfinite(settling), stable)
    assert np.exp(-settling[stable] * decay[stable]) == pytest.approx(0.02, rel=1e-12)


def test_limit_of_stability_in_the_map_is_the_one_by_hand() -> None:
    """The constant term alpha k_3 - k_2 omega^2 of the quadratic, for each of the printed signs that lose stability."""
    names = ("printed_L", "printed_7")
    found = stability_map({name: Setup(name, MACHINE, GAINS) for name in names}, {"omega": grid(0.5, 100.0, 40),
                                                                                  "k_2": grid(2.0, 90.0, 12)}).data
    for name in names:
        one = found.sel(observer=name)
        assert np.isfinite(one["limit_omega"]).sum() == 12
        by_hand = np.sqrt(MACHINE.alpha * GAINS["k_3"] / one["limit_k_2"].values)
        assert one["limit_omega"].values == pytest.approx(by_hand, rel=1e-9)


def test_full_map_and_pictures() -> None:
    found = stability_map(SETUP, {"omega": [-50.0, 20.0, 80.0], "slip": [-4.0, 1.0, 4.0]}, OperatingPoint(0.0, 0.5307), "full")
    decay = found.data["decay"].values[0]
    assert np.all(decay[:, 0] < 0) and np.all(decay[:, 1:] > 0)
    for quantity in ("decay", "damping", "settling_time"):
        text = svg_text(found.plot(quantity))
        assert text == svg_text(found.plot(quantity)) and "<svg" in text


def test_where_an_observer_with_a_wrong_rotor_resistance_rests() -> None:
    point = OperatingPoint(0.0, 0.5307, 2.0)
    over = {"omega": [-2.0, 30.0, 60.0], "R_r_error": [-0.3, 0.0, 0.3]}
    found = stability_map(SETUP, over, point, "settled")
    decay = found.data["decay"].sel(observer="consistent_12")
    assert np.isnan(decay.sel(omega=-2.0)).all(), "at zero stator frequency nothing determines the speed"
    assert (decay.sel(omega=[30.0, 60.0]) > 0).all()
    assert "<svg" in svg_text(found.plot())
    # without an error, with alpha_hat held: the full linearisation without the row and the column of alpha
    full = full_pencil(MACHINE, "consistent_12", GAINS, OperatingPoint(60.0, 0.5307, 2.0))
    keep = [k for k, name in enumerate(full.state_labels) if name != "alpha_tilde"]
    rest = np.linalg.eigvals(full.A[np.ix_(keep, keep)])
    moving = rest[np.abs(np.abs(rest.imag) - 62.0) + np.abs(rest.real) > 1e-6]
    assert decay.sel(omega=60.0, R_r_error=0.0).item() == pytest.approx(-moving.real.max(), rel=1e-8)


def test_a_gain_set_with_no_stable_region_is_said_to_have_none() -> None:
    found = stability_map(PRINTED, {"omega": grid(20.0, 90.0, 5), "k_2": grid(20.0, 90.0, 5)})
    assert found.stable_share() == {"printed_L": 0.0}
    assert np.isnan(found.data["settling_time"]).all()
    for quantity in ("decay", "damping", "settling_time"):
        assert "<svg" in svg_text(found.plot(quantity))


def test_standstill_is_a_point_like_any_other_at_frozen_speed() -> None:
    """No form divides by the speed: at zero the poles are the limit of those beside it."""
    for name in ("consistent_12", "printed_7", "printed_L"):
        roots = [pole_sweep(Setup(name, MACHINE, GAINS), {"omega": [speed]}).data for speed in (0.0, 1e-9)]
        zero, beside = (np.sort_complex(np.round((one["re"] + 1j * one["im"]).values[0], 5)) for one in roots)
        assert zero == pytest.approx(beside, abs=1e-4)


@pytest.mark.parametrize(("over", "message"), [
    ({"omega": [1.0], "omega_hat": [1.0]}, "omega and omega_hat are swept together, but are one quantity"),
    ({"R_r": [0.4], "alpha": [9.0]}, "R_r and alpha are swept together"),
    ({"omega": [1.0], "mass": [1.0]}, "over = 'mass'|no symbol 'mass'"),
    ({"omega": [1.0]}, "needs two parameters, and 1 is given"),
    ({"omega": [1.0], "k_2": []}, "the sweep over k_2 is empty"),
    ({"omega": [1.0, 2.0], "k_1": [1.0, 2.0], "k_2": [1.0]}, "3 parameters are swept"),
    ({}, "nothing is swept"),
])
def test_refusals(over: dict[str, list[float]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        stability_map(SETUP, over, OperatingPoint(0.0, None))


def test_pictures_that_cannot_be_drawn() -> None:
    found = stability_map(SETUP, {"omega": [1.0], "k_2": [1.0, 2.0]})
    with pytest.raises(InputError, match="one value of omega"):
        found.plot()
    with pytest.raises(InputError, match="quantity = 'colour' is not in the map"):
        found.plot("colour")
