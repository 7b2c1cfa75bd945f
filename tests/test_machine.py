"""The machine: derived parameters against circuit theory, files, and refusal of what no machine can be."""

import math
from pathlib import Path

import numpy as np
import pytest

from imo_analysis.errors import InputError
from imo_analysis.machine import PRESETS, InductionMachine
from imo_analysis.quantity import si_value

MACHINE = PRESETS["table-iii"]


def test_the_two_readings_of_alpha() -> None:
    assert MACHINE.alpha == pytest.approx(6.6236, abs=5e-5)
    printed = PRESETS["table-iii-printed-alpha"]
    assert printed.alpha == pytest.approx(9.9354, abs=1e-12)
    assert printed.alpha / MACHINE.alpha == pytest.approx(1.5, abs=2e-5)


def _impedance(machine: InductionMachine, omega_s: float, slip: float) -> complex:
    """Stator impedance of the T circuit, from its elements alone."""
    leak_s, leak_r = machine.L_s - machine.L_m, machine.L_r - machine.L_m
    rotor = machine.R_r * omega_s / slip + 1j * omega_s * leak_r
    magnetising = 1j * omega_s * machine.L_m
    return machine.R_s + 1j * omega_s * leak_s + rotor * magnetising / (rotor + magnetising)


def test_derived_parameters_give_the_impedance_of_the_t_circuit() -> None:
    """(1) in steady state, solved with sigma, alpha, beta and gamma, is the textbook circuit."""
    omega_s, slip = 80.0, 7.0
    m = MACHINE
    # (j w + gamma) i = beta (alpha - j omega) phi + u / sigma;  (j slip + alpha) phi = alpha L_m i
    omega = omega_s - slip
    phi_per_i = m.alpha * m.L_m / (1j * slip + m.alpha)
    impedance = m.sigma * (1j * omega_s + m.gamma - m.beta * (m.alpha - 1j * omega) * phi_per_i)
    assert impedance == pytest.approx(_impedance(m, omega_s, slip), rel=1e-12)


def test_circuit_forms_have_the_same_impedance() -> None:
    omega_s, slip = 80.0, 7.0
    ig = MACHINE.inverse_gamma()
    rotor = ig["R_R"] * omega_s / slip
    magnetising = 1j * omega_s * ig["L_M"]
    inverse_gamma = ig["R_s"] + 1j * omega_s * ig["L_sgm"] + rotor * magnetising / (rotor + magnetising)
    ga = MACHINE.gamma_form()
    rotor = ga["R_r"] * omega_s / slip + 1j * omega_s * ga["L_ell"]
    magnetising = 1j * omega_s * ga["L_s"]
    gamma = ga["R_s"] + rotor * magnetising / (rotor + magnetising)
    expected = _impedance(MACHINE, omega_s, slip)
    assert np.allclose([inverse_gamma, gamma], expected, rtol=1e-12)
    back = InductionMachine.from_inverse_gamma(n_p=2, J=MACHINE.J, **ig)
    assert _impedance(back, omega_s, slip) == pytest.approx(expected, rel=1e-12)


def test_round_trip_through_toml(tmp_path: Path) -> None:
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE.to_toml())
    assert InductionMachine.load(str(file)) == MACHINE


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"L_m": 0.07}, "L_m = 0.07 H must be below sqrt(L_s L_r) = 0.0617 H"),
        ({"L_m": -0.01}, "L_m = -0.01 H must be above 0 H"),
        ({"L_m": "60 mohm"}, "must be in H"),
        ({"R_s": float("nan")}, "not finite"),
        ({"R_s": True}, "not a number"),
        ({"R_s": "much"}, "not a number with a unit"),
        ({"L_s": 61500.0}, "is the unit right?"),
        ({"n_p": 0}, "n_p"),
        ({"n_p": 1.5}, "n_p"),
        ({"rs": 1.0}, "rs is not a known key"),
        ({"B": -1.0}, "B = -1"),
        ({"preset": "none"}, "choose one of"),
    ],
)
def test_impossible_values_are_refused_with_value_bound_and_place(values: dict[str, object], says: str) -> None:
    with pytest.raises(InputError) as caught:
        InductionMachine.build({"preset": "table-iii", **values}, "m.toml: machine")
    assert says in str(caught.value) and "m.toml" in str(caught.value)
    assert "\n" not in str(caught.value) and "http" not in str(caught.value)


@pytest.mark.parametrize("missing", ["n_p", "R_s", "R_r", "L_m", "L_s", "L_r", "J"])
def test_nothing_has_a_silent_default(missing: str) -> None:
    values = {k: v for k, v in MACHINE.model_dump().items() if k != missing}
    with pytest.raises(InputError, match=f"{missing} is missing"):
        InductionMachine.build(values)


def test_units_as_people_write_them() -> None:
    assert si_value("60.1 mH", "H", "x") == pytest.approx(0.0601)
    assert si_value("0.41 Ω", "ohm", "x") == 0.41
    assert si_value("1500 rpm", "rad/s", "x") == pytest.approx(1500 * math.pi / 30)
    assert si_value("163 kg m^2", "kg m^2", "x") == 163
    assert si_value("100 us", "s", "x") == pytest.approx(1e-4)
    assert si_value("1 ms", "s", "x") == 1e-3


@pytest.mark.parametrize("text", ["", "[machine", "\x00", "machine = 3"])
def test_files_that_are_not_machines(tmp_path: Path, text: str) -> None:
    file = tmp_path / "m.toml"
    file.write_text(text)
    with pytest.raises(InputError, match=r"m\.toml"):
        InductionMachine.load(str(file))
