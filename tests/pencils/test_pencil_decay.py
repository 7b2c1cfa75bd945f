"""Stability over two parameters against single sweeps, and its picture."""

import numpy as np
import pytest

from imo_analysis.drawing import svg_text
from imo_analysis.errors import InputError
from imo_analysis.machine import preset
from imo_analysis.pencils.decay import decay_map, plot_decay
from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.pencils.sweep import pole_sweep

MACHINE = preset("table-iii-printed-alpha")
GAINS = {"k_1": 300.0, "k_2": 50.0, "k_3": 100.0, "g": 1.0, "K_p": 100.0, "alpha_l": 0.05, "delta": 0.01}


def test_map_agrees_with_single_sweeps() -> None:
    omega, k_2 = np.linspace(1.0, 60.0, 7), np.linspace(0.0, 80.0, 5)
    data = decay_map(MACHINE, "printed_L", GAINS, ("omega", omega), ("k_2", k_2), OperatingPoint(0.0, None))
    assert data["decay"].dims == ("k_2", "omega") and data["k_2"].attrs["units"] == "1"
    for k, gain in enumerate(k_2):
        single = pole_sweep(MACHINE, "printed_L", {**GAINS, "k_2": gain}, omega)
        moving = single["re"].where(~single["neutral"]).max("branch")
        assert data["decay"].values[k] == pytest.approx(-moving.values, rel=1e-9, abs=1e-9)
    # the limit of stability is alpha k_3 = k_2 omega^2
    stable = MACHINE.alpha * GAINS["k_3"] > k_2[:, None] * omega[None, :] ** 2
    assert np.array_equal(data["decay"].values > 0, stable)


def test_full_map_and_picture() -> None:
    data = decay_map(MACHINE, "consistent_12", GAINS, ("omega", [-50.0, 20.0, 80.0]), ("slip", [-4.0, 1.0, 4.0]),
                     OperatingPoint(0.0, 0.5307), "full")
    assert np.all(data["decay"].values[:, 0] < 0) and np.all(data["decay"].values[:, 1:] > 0)
    text = svg_text(plot_decay(data))
    assert text == svg_text(plot_decay(data)) and "<svg" in text


def test_refusals() -> None:
    with pytest.raises(InputError, match="given for both axes"):
        decay_map(MACHINE, "consistent_12", GAINS, ("omega", [1.0]), ("omega", [1.0]), OperatingPoint(0.0, None))
    with pytest.raises(InputError, match="over = 'mass'"):
        decay_map(MACHINE, "consistent_12", GAINS, ("omega", [1.0]), ("mass", [1.0]), OperatingPoint(0.0, None))
