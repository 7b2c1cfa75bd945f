"""Sweeps: branches that are continuous, boundaries at their known places, symmetry, and refusals."""

from typing import Any

import numpy as np
import pytest
from control import damp
from matplotlib.text import Annotation
from scipy.optimize import linear_sum_assignment

from imo_analysis.drawing import svg_text
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.machine import preset
from imo_analysis.pencils import branches
from imo_analysis.pencils.boundaries import stability_boundaries
from imo_analysis.pencils.branches import track
from imo_analysis.pencils.error import OperatingPoint, frozen_pencil, poles_at
from imo_analysis.pencils.setup import Setup
from imo_analysis.pencils.sweep import evaluator, grid, pole_sweep

MACHINE = preset("table-iii-printed-alpha")
ADAPTIVE = {"k_1": 300.0, "k_2": 50.0, "k_3": 100.0, "g": 1.0, "K_p": 100.0, "alpha_l": 0.05, "delta": 0.01}
SETUP = Setup("consistent_12", MACHINE, ADAPTIVE)
BASELINE = {"l_1": 162.0, "l_2": 0.0, "l_3": -0.08, "l_4": 0.35, "h": 100.0}
KUBOTA = Setup("baseline", MACHINE, BASELINE)


def test_branches_hold_the_poles_and_move_smoothly() -> None:
    omega = grid(-150.0, 150.0, 61)
    data = pole_sweep(SETUP, {"omega_hat": omega}).data
    roots = data["re"].values + 1j * data["im"].values
    direct = poles_at(MACHINE, "consistent_12", ADAPTIVE, OperatingPoint(omega, None))
    for row, other in zip(roots, direct, strict=True):
        assert np.sort(row) == pytest.approx(np.sort(other), abs=1e-9 * 1e3)
    assert data["neutral"].values.tolist() == [False] * 4 + [True] * 2
    # a branch is smooth where a finer sweep has the same branches, thinned
    fine = pole_sweep(SETUP, {"omega": grid(5.0, 150.0, 1161)}).data
    coarse = pole_sweep(SETUP, {"omega": grid(5.0, 150.0, 30)}).data
    assert coarse["im"].values == pytest.approx(fine["im"].values[::40], abs=1e-6)


def test_branches_that_cross_are_told_apart() -> None:
    """Two poles that pass each other at a distance less than a step: neighbours alone would swap them."""

    def crossing(x: np.ndarray) -> np.ndarray:
        return np.sort_complex(np.stack([x + 0.02j, -x - 0.02j], axis=-1))

    points = np.linspace(-1.0, 1.0, 12)
    found = track(points, crossing)
    assert found.unclear == 0
    for branch in found.branches.T:
        slope = np.diff(branch.real)
        assert np.all(slope > 0) or np.all(slope < 0)


def test_steps_too_long_to_tell_branches_apart_are_refined() -> None:
    """Two opposite poles on a circle, 2.6 rad a step: the nearest candidate, and the one on the tangent, is the wrong one."""
    angles = 2.6 * np.arange(8)
    turning = np.exp(1j * angles)

    def both(at: np.ndarray) -> np.ndarray:
        return np.sort(np.stack([np.exp(1j * at), -np.exp(1j * at)], axis=-1), axis=-1)

    found = track(angles, both)
    own = int(np.argmin(np.abs(found.branches[0] - turning[0])))
    assert found.unclear == 0 and np.abs(found.branches[:, own] - turning).max() < 1e-12


@pytest.mark.parametrize("count", [7, 301])
@pytest.mark.parametrize("name", ["consistent_12", "printed_7"])
def test_stretches_joined_at_once_are_what_step_by_step_gives(name: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    moving = evaluator(MACHINE, name, ADAPTIVE, "omega", None, "frozen").moving
    speeds = np.linspace(-150.0, 150.0, count)
    at_once = track(speeds, moving)
    steps = branches._chained(speeds, moving(speeds), 1e-9)[1]
    assert count < 100 or 0.8 < steps.mean() < 1
    monkeypatch.setattr(branches, "_chained", lambda points, raw, _: (raw, np.zeros(len(points), dtype=bool)))
    one_by_one = track(speeds, moving)
    assert np.abs(at_once.branches - one_by_one.branches).max() < 1e-12 * np.abs(one_by_one.branches).max()
    assert at_once.unclear == one_by_one.unclear


def test_mirrored_speed_has_the_same_poles() -> None:
    """With l_2 = l_4 = 0; a constant l_2 or l_4 makes the two directions of rotation different."""
    data = pole_sweep(Setup("baseline", MACHINE, BASELINE | {"l_4": 0.0}), {"omega": grid(-100.0, 100.0, 21)}).data
    roots = data["re"].values + 1j * data["im"].values
    for row, mirrored in zip(roots, roots[::-1], strict=True):
        assert np.sort(row) == pytest.approx(np.sort(mirrored), abs=1e-9)


@pytest.mark.parametrize("name", ["printed_7", "printed_L"])
def test_printed_feedbacks_lose_stability_where_hand_calculation_says(name: str) -> None:
    """Both have a pole at zero where alpha k_3 = k_2 omega^2, by the constant term of the characteristic polynomial."""
    limit = np.sqrt(MACHINE.alpha * ADAPTIVE["k_3"] / ADAPTIVE["k_2"])
    found = stability_boundaries(Setup(name, MACHINE, ADAPTIVE), {"omega": grid(0.5, 100.0, 40)})
    assert {round(crossing["value"], 9) for crossing in found} == {round(limit, 9)}
    assert all(crossing["direction"] == 1.0 for crossing in found)


def test_boundary_in_a_gain() -> None:
    """k_1 below -R_s/sigma leaves the sum of the poles positive: Re of one crosses before; check the sign on both sides."""
    point = OperatingPoint(60.0, None)
    found = stability_boundaries(SETUP, {"k_1": grid(-300.0, 300.0, 61)}, point)
    assert found
    for crossing in found:
        for step, sign in ((-1e-6, 1), (1e-6, -1)):
            poles = poles_at(MACHINE, "consistent_12", ADAPTIVE, point, changes={"k_1": crossing["value"] + step})
            assert np.sign(np.sort(poles.real)[-1] if sign > 0 else -np.sort(poles.real)[0]) == 1


def test_the_full_linearisation_is_unstable_backwards_with_the_printed_sign() -> None:
    point = OperatingPoint(0.0, 0.5307, 2.0)
    data = pole_sweep(SETUP, {"omega": [-60.0, -20.0, 20.0, 60.0]}, point, "full").data
    worst = data["re"].where(~data["neutral"]).max("branch").values
    assert np.all(worst[:2] > 1000) and np.all(worst[2:] < 0)
    assert data["neutral"].values.sum() == 3


def test_the_poles_taken_out_as_neutral_are_there() -> None:
    for speed in (-80.0, 45.0):
        raw = poles_at(MACHINE, "consistent_12", ADAPTIVE, OperatingPoint(speed, 0.5307, 2.0), "full")
        for target in (0.0, 1j * (speed + 2.0), -1j * (speed + 2.0)):
            assert np.abs(raw - target).min() < 1e-7 * np.abs(raw).max()


def test_labels_and_padding() -> None:
    data = pole_sweep({"b": KUBOTA, "a": SETUP}, {"omega": grid(10.0, 20.0, 3)}).data
    assert dict(data.sizes) == {"observer": 2, "omega": 3, "branch": 6}
    assert np.isnan(data["re"].sel(observer="b")).sum() == 6
    assert data["omega"].attrs["units"] == "rad/s" and data["re"].attrs["units"] == "1/s"
    over = pole_sweep(KUBOTA, {"R_r": [0.3, 0.41, 0.8]}, OperatingPoint(30.0, None)).data
    assert over["R_r"].attrs["units"] == "ohm"
    again = poles_at(MACHINE.with_values(R_r=0.8), "baseline", BASELINE, OperatingPoint(30.0, None))
    assert np.sort(over["re"].values[2] + 1j * over["im"].values[2]) == pytest.approx(again, abs=1e-9)


@pytest.mark.parametrize(("values", "over", "message"), [
    ([], "omega", "the sweep over omega is empty"),
    ([1.0, float("nan")], "omega", "not finite"),
    ([2.0, 1.0], "omega", "must increase"),
    ([1.0, 2.0], "k_2", "needs an operating point"),
    ([1.0, 2.0], "mass", "not a parameter"),
    (["fast"], "omega", "must be numbers, in rad/s"),
])
def test_refusals(values: list[float], over: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        pole_sweep(SETUP, {over: values})


@pytest.mark.parametrize("name", OBSERVERS)
def test_branches_are_the_poles_of_python_control(name: str) -> None:
    gains = {**ADAPTIVE, **BASELINE, "kappa": 40.0, "h_s": 0.03, "P_0": 4.0, "k": 1.5, "eta": 1.0, "S_0": 1.0}
    setup = Setup(name, MACHINE, {gain: gains[gain] for gain in OBSERVERS[name].gains})
    data = pole_sweep(setup, {"omega": grid(-120.0, 140.0, 14)}).data
    for k, omega in enumerate(data["omega"].values):
        expected = frozen_pencil(MACHINE, name, setup.gains, float(omega)).poles()
        distance = np.abs((data["re"].values[k] + 1j * data["im"].values[k])[:, None] - expected[None, :])
        chosen = linear_sum_assignment(distance)
        # of the double root at standstill an eigenvalue solver keeps half of the digits
        assert distance[chosen].max() < (1e-9 if omega else 1e-6) * np.abs(expected).max()


def test_pictures_of_a_sweep_and_of_a_cloud() -> None:
    omega = grid(5.0, 90.0, 12)
    one = pole_sweep({"a": SETUP, "b": KUBOTA}, {"omega": omega})
    two = pole_sweep(SETUP, {"omega": omega, "k_2": [1.0, 2.0]})
    cloud = pole_sweep({"a": SETUP, "b": KUBOTA}, {"omega": omega[::-1], "R_r": np.linspace(0.3, 0.5, 12)}, cloud=True)
    assert dict(two.data.sizes) == {"omega": 12, "k_2": 2, "branch": 6} and two.over == ("omega", "k_2")
    assert dict(cloud.data.sizes) == {"observer": 2, "sample": 12, "branch": 6}
    pictures = [one.plot(), one.plot("against"), one.plot(contours="damping"), one.plot(contours="settling_time"), two.plot(),
                cloud.plot()]
    texts = [svg_text(picture) for picture in pictures]
    assert len(set(texts)) == len(texts) and all("<svg" in text for text in texts)
    for wrong, view in ((one, "globe"), (two, "against"), (cloud, "against")):
        with pytest.raises(InputError, match=r"view = 'globe' is not known|needs one swept parameter"):
            wrong.plot(view)
    with pytest.raises(InputError, match="omega has 12, R_r has 3"):
        pole_sweep(SETUP, {"omega": omega, "R_r": [0.3, 0.4, 0.5]}, cloud=True)


def test_slow_poles_that_are_one_spot_are_shown_in_a_window() -> None:
    """Of the repaired observer with a small kappa; not of one whose slow poles are as long a path as its fast ones."""
    omega = np.linspace(10.0, 100.0, 19)
    repaired = Setup("repaired", MACHINE, {"k_1": 300.0, "kappa": 50.0, "k_3": 100.0})
    found = pole_sweep(repaired, {"omega": omega})
    ax = found.plot(contours="settling_time").axes[0]
    (window,) = ax.child_axes
    roots = (found.data["re"] + 1j * found.data["im"]).where(~found.data["neutral"], drop=True).values
    slow = roots[:, np.abs(roots).max(axis=0) < 0.15 * np.abs(roots).max()]
    assert slow.shape == (19, 2)
    (x_0, x_1), (y_0, y_1) = window.get_xlim(), window.get_ylim()
    assert x_0 < slow.real.min() and slow.real.max() < x_1 and y_0 < slow.imag.min() and slow.imag.max() < y_1
    ax.figure.draw_without_rendering()
    box = window.get_window_extent()
    assert not any(box.contains(*ax.transData.transform((pole.real, pole.imag))) for pole in roots.ravel())
    assert not pole_sweep(SETUP, {"omega": omega}).plot().axes[0].child_axes


def test_arrows_and_contours_stand_where_their_numbers_say() -> None:
    found = pole_sweep(SETUP, {"omega": np.linspace(20.0, 150.0, 27)})
    for contours, holds in (
        ("damping", lambda x, y, ratio: -x / np.hypot(x, y) == pytest.approx(ratio, rel=1e-9)),
        ("settling_time", lambda x, _, time: np.exp(x * time) == pytest.approx(0.02, rel=1e-9)),
    ):
        ax = found.plot(contours=contours).axes[0]
        labels = [text for text in ax.texts if not isinstance(text, Annotation)]
        assert len(labels) >= 3
        for text in labels:
            x, y = text.get_position()
            assert holds(x, y, float(text.get_text().removesuffix(" s"))), (contours, text)
            straight = [np.asarray(line.get_xydata()) for line in ax.lines if str(line.get_linestyle()) != "-"]
            ends = [(complex(*line[0]), complex(*line[1])) for line in straight if line.shape == (2, 2)]
            off = [abs(((b - a).conjugate() * (complex(x, y) - a)).imag) / abs(b - a) for a, b in ends if a != b]
            assert min(off) < 1e-9 * abs(complex(x, y)), "the number stands on its line"
    arrows = [text for text in ax.texts if isinstance(text, Annotation)]
    roots = found.data["re"].values + 1j * found.data["im"].values
    assert len(arrows) == 4
    for arrow in arrows:
        tip, tail = (complex(*at) for at in (arrow.xy, arrow.xyann))
        where = [np.unravel_index(np.argmin(np.abs(roots - end)), roots.shape) for end in (tail, tip)]
        assert where[0][1] == where[1][1] and where[0][0] < where[1][0], "towards the rise of what is swept"


def test_damping_and_natural_frequency_are_those_of_the_poles() -> None:
    data = pole_sweep(SETUP, {"omega": [20.0, 60.0]}).data.sel(branch=[1, 2, 3, 4])
    poles = frozen_pencil(MACHINE, "consistent_12", ADAPTIVE, 60.0)
    frequency, damping, roots = damp(poles, doprint=False)
    for s, size, ratio in zip(roots, frequency, damping, strict=True):
        if abs(s) > 1e-3:
            at = np.argmin(np.abs(data["re"].values[1] + 1j * data["im"].values[1] - s))
            assert data["natural_frequency"].values[1, at] == pytest.approx(size, rel=1e-9)
            assert data["damping"].values[1, at] == pytest.approx(ratio, rel=1e-9) and ratio > 0


def test_a_cloud_takes_the_values_point_by_point() -> None:
    speeds, gains = np.array([60.0, -20.0, 30.0]), np.array([10.0, 50.0, 30.0])
    data = pole_sweep(SETUP, {"omega": speeds, "k_2": gains}, cloud=True).data
    for k, (omega, k_2) in enumerate(zip(speeds, gains, strict=True)):
        own = poles_at(MACHINE, "consistent_12", ADAPTIVE | {"k_2": float(k_2)}, OperatingPoint(float(omega), None))
        found = data["re"].values[k] + 1j * data["im"].values[k]
        distance = np.abs(found[:, None] - own[None, :])
        assert distance[linear_sum_assignment(distance)].max() < 1e-9 * np.abs(own).max()


def test_errors_of_the_believed_machine_are_the_machine_changed() -> None:
    point = OperatingPoint(45.0, None)
    by_error = pole_sweep(KUBOTA, {"R_r_error": [-0.2, 0.0, 0.3]}, point).data
    by_value = pole_sweep(KUBOTA, {"R_r": [MACHINE.R_r * (1 + e) for e in (-0.2, 0.0, 0.3)]}, point).data
    assert by_error["re"].values == pytest.approx(by_value["re"].values, rel=1e-12)
    assert by_error["R_r_error"].attrs["units"] == "1"


def test_unknown_parameter() -> None:
    with pytest.raises(InputError, match="over = 'mass' is not a parameter of baseline"):
        pole_sweep(KUBOTA, {"mass": [1.0]}, OperatingPoint(1.0, None))


@pytest.mark.parametrize(("arguments", "message"), [
    ((0.0, 1.0, 0), "is empty"),
    ((0.0, float("inf"), 3), "finite"),
    ((1.0, 1.0, 3), "STOP above START"),
    ((0.0, 1.0, 1), "one point"),
])
def test_bad_grids(arguments: tuple[float, float, int], message: str) -> None:
    with pytest.raises(InputError, match=message):
        grid(*arguments)


@pytest.mark.parametrize(("name", "kind"), [("consistent_12", "frozen"), ("printed_7", "frozen"), ("consistent_12", "full")])
def test_poles_that_overflow_are_refused_and_not_drawn(name: str, kind: Any) -> None:
    huge = Setup(name, MACHINE, ADAPTIVE | dict.fromkeys(("k_1", "k_2", "k_3", "K_p"), 1e307))
    with pytest.raises(InputError, match=f"the poles of {name} overflow somewhere over omega"):
        pole_sweep(huge, {"omega": [20.0, 60.0]}, OperatingPoint(60.0, 0.5307, 3.0), kind)
