"""The loop closed on estimates: the map against single runs, its symmetry, where it holds and where it is lost."""

import numpy as np
import pytest

from imo_analysis.errors import InputError
from imo_analysis.simulation.run import simulate
from imo_analysis.sweeps import sensorless_map as maps
from imo_analysis.sweeps.sensorless_map import sensorless_map

SPEEDS, TORQUES = [-40.0, 5.0, 10.0, 40.0], [-15.0, 0.0, 15.0]


@pytest.fixture(scope="module")
def cold(paper):
    """Observers that start from the right alpha and believe 5 % too much stator resistance."""
    return paper.only(["baseline", "repaired"]).changed({
        "observers.repaired.initial.alpha_hat": 9.9354,
        **{f"observers.{name}.errors.R_s": 0.05 for name in ("baseline", "repaired")},
    })


@pytest.fixture(scope="module")
def plane(cold):
    return sensorless_map(cold, SPEEDS, TORQUES)


def test_the_map_is_that_of_single_runs(cold, plane):
    for name, omega, T_l in (("repaired", 5.0, -15.0), ("baseline", 40.0, 15.0), ("repaired", -40.0, 15.0)):
        study = maps._prepared(cold, name, "reference", 2.0).changed({
            "reference.omega": [0.0, 0.0, omega], "load.T_l": [0.0, 0.0, T_l], "simulation.record_every": 10,
            "simulation.duration": maps.LOADED + 2.0001})
        run = simulate(study)
        kept = run.isel(time=slice(-1001, -1))
        peak = float(np.abs(kept["omega_hat"][0] - kept["omega"]).max())
        final = abs(float(run["omega"][-1]) - omega)
        found = float(plane["speed_error"].sel(observer=name, omega=omega, T_l=T_l))
        assert found == pytest.approx(max(peak, final), rel=1e-5)


def test_it_holds_far_from_zero_stator_frequency_and_is_lost_near_it(plane):
    holds, near = plane["holds"], {"omega": 10.0, "T_l": -15.0}
    assert holds.sel(omega=[-40.0, 40.0], T_l=0.0).values.all() and holds.sel(observer="baseline", omega=40.0).values.all()
    assert abs(float(plane["stator_frequency"].sel(near))) < 1.0 and not holds.sel(near).values.any()
    # braking below that line the baseline comes back, the repaired observer does not
    assert list(holds.sel(omega=5.0, T_l=-15.0).values) == [1, 0]


def test_stator_frequency_is_the_one_of_a_run(cold, plane):
    """At steady state the rotor flux turns with it."""
    study = maps._prepared(cold, "baseline", "reference", 2.0).changed({
        "observers.baseline.errors.R_s": 0.0, "reference.omega": [0.0, 0.0, 40.0], "load.T_l": [0.0, 0.0, 15.0]})
    run = simulate(study)
    phase = np.unwrap(np.angle(run["phi_dr"] + 1j * run["phi_qr"]))
    turned = np.polyfit(run["time"].values[-500:], phase[-500:], 1)[0]
    assert turned == pytest.approx(float(plane["stator_frequency"].sel(omega=40.0, T_l=15.0)), rel=1e-3)


def test_the_map_has_the_mirror_symmetry_of_the_machine(cold):
    # of the baseline alone: at standstill the others are told to turn forward, and q remembers it
    plane = sensorless_map(cold, [-20.0, 20.0], [-10.0, 10.0], observers=["baseline"])
    error = plane["speed_error"].values
    np.testing.assert_allclose(error, error[:, ::-1, ::-1], rtol=1e-4)


def test_figure(plane):
    from imo_analysis.drawing import svg_text
    from imo_analysis.report.sensorless_figure import sensorless_figure

    text = svg_text(sensorless_figure(plane))
    assert text == svg_text(sensorless_figure(plane)) and len(text) < 400_000


@pytest.mark.parametrize(("change", "text"), [
    ({"omega": []}, "the map has 0 speeds"), ({"hold": 0.01}, "hold = 0.01 s must be at least 0.1 s"),
    ({"observers": ["nobody"]}, "observer = 'nobody' is not in the study"), ({"direction": "left"}, "'true', 'reference' or"),
])
def test_bad_input(cold, change, text):
    with pytest.raises(InputError, match=text):
        sensorless_map(**{"study": cold, "omega": [10.0], "T_l": [0.0], **change})
