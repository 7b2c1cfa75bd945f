"""What a drive has and the paper leaves out: each feature by a route of its own, and all of them at once against an oracle."""

from itertools import pairwise

import numpy as np
import oracle_drive
import pytest

from imo_analysis.errors import InputError
from imo_analysis.simulation import composition, inverter, run, saturated_machine, shaft
from imo_analysis.simulation.kernel import Loop, plain
from imo_analysis.simulation.loaded_machine import machine_rates
from imo_analysis.simulation.run import simulate
from imo_analysis.sweeps.batch import run_batch


@pytest.fixture(scope="module")
def bare(turning):
    """Machine and drive alone."""
    return turning.only([])


@pytest.fixture(scope="module")
def everything(paper):
    """All features at once, one observer, no noise, away from any steady state."""
    return paper.scenario("real").only(["repaired"]).changed({
        "simulation.duration": 0.02, "simulation.record_every": 1, "sensors.current_noise": 0.0, "initial.omega": 30.0,
        "observers.repaired.initial.omega_hat": 25.0, "reference": {"time": [0, 0.01], "omega": [30.0, 40.0]},
        "load": {"time": [0.0, 0.01], "T_l": [2.0, 8.0]}, "inverter.dead_time": 2e-6,
    })


def largest(a, b):
    return float(np.max(np.abs(np.asarray(a) - np.asarray(b))))


# All at once --------------------------------------------------------------------------------------------------------------
def test_everything_on_agrees_with_the_oracle(everything):
    """Complex fluxes, a carrier compared in time and DOP853 give the same drive; the gap falls as the step's fourth power."""
    other = oracle_drive.run(everything, 200)
    gaps = []
    for substeps in (1, 2):
        data = simulate(everything.changed({"simulation.substeps": substeps}))
        gaps.append([
            largest(data["i_ds"].values + 1j * data["i_qs"].values, other["i"]),
            largest(data["phi_dr"].values + 1j * data["phi_qr"].values, other["phi"]),
            largest(data["omega"].values, other["omega"]), largest(data["omega_load"].values, other["omega_load"]),
            largest(data["omega_hat"][0].values, other["observer"][:, 7]),
        ])
    assert np.all(np.array(gaps[0]) < [1e-7, 1e-9, 1e-7, 1e-7, 1e-4]), gaps
    assert np.all(np.array(gaps[1]) < np.array(gaps[0]) / 10), gaps


def test_stretches_carry_the_voltage_that_waits(everything, monkeypatch):
    whole = simulate(everything)
    monkeypatch.setattr(run, "_STRETCH", 37)
    parts = simulate(everything)
    for name in whole.data_vars:
        assert np.array_equal(whole[name], parts[name], equal_nan=True), name


def test_what_is_recorded_says_its_unit(everything):
    data = simulate(everything)
    for name in ("u_ds_told", "omega_load", "shaft_torque", "psi_ds"):
        assert data[name].attrs["units"] and data[name].attrs["long_name"], name
    torque = 1.5 * 2 * (data["psi_ds"] * data["i_qs"] - data["psi_qs"] * data["i_ds"])
    np.testing.assert_allclose(data["torque"], torque, rtol=1e-13)


@pytest.mark.parametrize("neutral", [
    {"inverter.dc_link": 600.0}, {"saturation.knee": 1e6}, {"inverter.dc_link": 600.0, "inverter.limit": "hexagon"},
])
def test_a_feature_without_effect_changes_nothing(bare, neutral):
    """The inverter within its reach, and a flat curve, are the plain machine (1) but for rounding."""
    one, other = simulate(bare), simulate(bare.changed(neutral))
    for name in ("i_ds", "i_qs", "phi_dr", "phi_qr", "omega", "torque", "u_ds"):
        assert largest(one[name], other[name]) < 1e-11 * float(np.abs(one[name]).max()), name


# Delay and sensors -------------------------------------------------------------------------------------------------------
def test_delay_shifts_the_voltages_by_a_sample(bare):
    """Nothing else changes: fed with what the drive saw, the control gives the voltage of the next sample."""
    from imo_analysis.simulation import drive

    data = simulate(bare.changed({"inverter.delay": 1}))
    p, d = bare.machine.plant_parameters, run.drive_parameters(bare)
    _, c = run.initial_state(bare)
    state, flux, flow = tuple(c[:3]), tuple(c[3:5]), tuple(c[5:])
    assert float(data["u_ds"][0]) == 0.0 and float(data["u_qs"][0]) == 0.0
    for k in range(len(data["time"]) - 1):
        seen, omega = (float(data["i_ds_meas"][k]), float(data["i_qs_meas"][k])), float(data["omega"][k])
        u, state = drive.control(state, seen, omega, flux, float(data["omega_ref"][k]), bare.drive.flux, p, d)
        flux, flow = drive.flux_model(flux, flow, seen, omega, d[0], p)
        assert (float(data["u_ds"][k + 1]), float(data["u_qs"][k + 1])) == pytest.approx(u, rel=1e-9, abs=1e-9)


def test_quantised_currents_are_multiples_of_the_step(turning):
    step = 0.03
    data = simulate(turning.only(["repaired"]).changed(
        {"sensors.current_resolution": step, "sensors.current_gain": [1.01, 1.0]}))
    for axis, gain in (("d", 1.01), ("q", 1.0)):
        counts = data[f"i_{axis}s_meas"].values / step
        assert largest(counts, np.round(counts)) < 1e-9
        off = data[f"i_{axis}s_meas"].values - gain * data[f"i_{axis}s"].values
        assert np.abs(off).max() <= step / 2 * (1 + 1e-9)
        assert off.std() == pytest.approx(step / np.sqrt(12), rel=0.15)


# Inverter ------------------------------------------------------------------------------------------------------------------
BRIDGE = (600.0, 1e-4, 2e-6, 1.0)


def test_pulses_have_the_volt_seconds_of_their_mean():
    rng = np.random.default_rng(3)
    for _ in range(300):
        u = inverter.reachable(tuple(rng.normal(size=2) * 250), BRIDGE)
        on, off = inverter.pulses(u, tuple(rng.normal(size=2) * 10), BRIDGE)
        times = inverter.edges(on, off, BRIDGE)
        assert list(times) == sorted(times) and len(times) == 8
        pieces = [np.array(inverter.bridge_voltage((a + b) / 2, on, off, BRIDGE)) * (b - a)
                  for a, b in pairwise(times)]
        np.testing.assert_allclose(sum(pieces) / BRIDGE[1], inverter.mean_voltage(on, off, BRIDGE), atol=1e-9)


def test_without_dead_time_the_mean_is_what_was_asked_for():
    rng = np.random.default_rng(4)
    ideal = (600.0, 1e-4, 0.0, 1.0)
    for _ in range(300):
        u = inverter.reachable(tuple(rng.normal(size=2) * 250), ideal)
        on, off = inverter.pulses(u, (1.0, 2.0), ideal)
        np.testing.assert_allclose(inverter.mean_voltage(on, off, ideal), u, atol=1e-9)


def test_reach_is_the_hexagon():
    """Its six sides lie dc / sqrt(3) from the middle, across the directions 30, 90, 150, ... degrees."""
    normals = np.exp(1j * (np.pi / 6 + np.pi / 3 * np.arange(6)))
    angles = np.linspace(0, 2 * np.pi, 721)
    for angle in angles:
        d, q = inverter.reachable((1e4 * np.cos(angle), 1e4 * np.sin(angle)), BRIDGE)
        assert np.max((normals.conj() * complex(d, q)).real) == pytest.approx(600 / np.sqrt(3), rel=1e-12)
        assert np.angle(complex(d, q) * np.exp(-1j * angle)) == pytest.approx(0.0, abs=1e-12)
    assert inverter.reachable((100.0, -50.0), BRIDGE) == (100.0, -50.0)


def test_dead_time_error_has_the_closed_form():
    """A square wave of V = dc dead / period in each phase: fundamental 4 V / pi against the current, its 5th and 7th 1/5, 1/7.

    In the frame of the current these two are the ripple at six times its frequency.
    """
    angle = (np.arange(7200) + 0.5) * 2 * np.pi / 7200
    error = []
    for theta in angle:
        i, u = (5 * np.cos(theta), 5 * np.sin(theta)), (120 * np.cos(theta + 0.4), 120 * np.sin(theta + 0.4))
        mean = inverter.mean_voltage(*inverter.pulses(u, i, BRIDGE), BRIDGE)
        error.append(complex(mean[0] - u[0], mean[1] - u[1]))
    volts = 600 * 2e-6 / 1e-4
    for order, share in ((1, 1.0), (-5, 1 / 5), (7, 1 / 7), (-11, 1 / 11)):
        found = np.mean(np.array(error) * np.exp(-1j * order * angle))
        assert abs(found) == pytest.approx(4 * volts / np.pi * share, rel=1e-3)
    assert np.mean(np.array(error) * np.exp(-1j * angle)).real < 0
    for order in (-1, 2, 3, 5, -7):
        assert abs(np.mean(np.array(error) * np.exp(-1j * order * angle))) < 1e-3 * volts


def test_switching_converges_to_the_mean_as_the_carrier_rises(bare):
    link = {"inverter.dc_link": 600.0}
    mean = simulate(bare.changed(link))
    gaps = [largest(simulate(bare.changed({**link, "inverter.pwm": "switched", "inverter.carriers": n}))["i_qs"], mean["i_qs"])
            for n in (1, 4, 16)]
    assert gaps[0] > 3 * gaps[1] > 9 * gaps[2] > 0


def test_switching_with_dead_time_is_its_mean(bare):
    """The mean form and the pulses share one definition of the dead time; here what it does to the speed, by both."""
    dead = {"inverter.dc_link": 600.0, "inverter.dead_time": 1e-6}
    mean, none = simulate(bare.changed(dead)), simulate(bare)
    switched = simulate(bare.changed({**dead, "inverter.pwm": "switched"}))
    effect = largest(mean["omega"], none["omega"])
    assert effect > 0.01 and largest(switched["omega"], mean["omega"]) < 0.05 * effect


@pytest.mark.parametrize(("limit", "reach"), [("circle", 1 / np.sqrt(3)), ("hexagon", 2 / 3)])
def test_the_link_bounds_the_voltage(bare, limit, reach):
    low = {"inverter.dc_link": 60.0, "inverter.limit": limit, "reference.omega": [60.0, 300.0]}
    data = simulate(bare.changed(low))
    size = np.hypot(data["u_ds"], data["u_qs"]).values
    assert size.max() <= 60.0 * reach * (1 + 1e-12)
    assert size.max() > 60.0 * 0.99 / np.sqrt(3)


# Mechanics -----------------------------------------------------------------------------------------------------------------
def test_two_masses_ring_at_their_resonance(bare):
    """A drive too weak to matter: a step of load torque makes motor and load swing against each other."""
    shaft_data = {"mechanics": {"load_share": 0.4, "stiffness": 300.0, "damping": 0.02}}
    study = bare.changed({
        **shaft_data, "drive.current_limit": 1e-6, "drive.voltage_limit": 1e-6,
        "initial": {"phi_dr": 0.0, "i_ds": 0.0, "omega": 0.0}, "reference.omega": [0.0, 0.0],
        "load": {"time": [0.0], "T_l": [1.0]}, "machine.B": 0.0, "simulation.duration": 0.2,
    })
    data = simulate(study)
    J_motor, J_load = 0.6 * study.machine.J, 0.4 * study.machine.J
    both = 1 / J_motor + 1 / J_load
    natural, decay = np.sqrt(300.0 * both), 0.02 * both / 2
    assert study.mechanics.resonance(study.machine.J) == pytest.approx(natural, rel=1e-12)
    ringing = np.sqrt(natural**2 - decay**2)
    t = data["time"].values
    # twist from rest under 1 N m on the load: the shaft carries J_motor / J of it in the end
    rest = J_motor / study.machine.J
    twist = rest / 300.0 * (1 - np.exp(-decay * t) * (np.cos(ringing * t) + decay / ringing * np.sin(ringing * t)))
    rate = rest / 300.0 * np.exp(-decay * t) * (ringing + decay**2 / ringing) * np.sin(ringing * t)
    np.testing.assert_allclose(data["shaft_torque"], 300.0 * twist + 0.02 * rate, atol=2e-5 * rest)
    momentum = J_motor * data["omega"].values + J_load * data["omega_load"].values
    np.testing.assert_allclose(momentum, -1.0 * t * study.machine.n_p, rtol=1e-5, atol=1e-6)


def test_the_shaft_conserves_what_it_should():
    """Power taken from the motor = power to the load + change of the shaft's energy + what its damping burns."""
    rng, tight = np.random.default_rng(5), (200.0, 0.3, 0.01, 2.0)
    for _ in range(20):
        omega, omega_load, twist, T_l = rng.normal(size=4) * [50, 50, 0.1, 5]
        torque = shaft.shaft_torque(omega, omega_load, twist, tight)
        rate_load, rate_twist = shaft.shaft_rates(omega, omega_load, twist, T_l, tight)
        stored = 200.0 * twist * rate_twist + 0.01 * omega_load / 2 * rate_load / 2 + T_l * omega_load / 2
        assert torque * omega / 2 == pytest.approx(stored + 0.3 * ((omega - omega_load) / 2) ** 2, rel=1e-12, abs=1e-12)


def test_dry_friction_is_carried_by_the_machine(bare):
    """At steady speed the machine's torque is load, viscous and dry friction; the last is smoothed as stated and odd."""
    study = bare.changed({"mechanics.coulomb": 0.7, "mechanics.coulomb_speed": 3.0, "simulation.duration": 1.5,
                          "reference.omega": [60.0, 10.0]})
    end = simulate(study).isel(time=-1)
    viscous = study.machine.B * 10.0 / 2
    assert float(end["torque"]) == pytest.approx(5.0 + viscous + 0.7 * 10 / np.sqrt(109.0), rel=1e-5)
    assert shaft.coulomb_torque(-4.0, (0.7, 3.0)) == pytest.approx(-0.7 * 0.8)


# Saturation ----------------------------------------------------------------------------------------------------------------
def saturating(bare):
    return bare.changed({"saturation": {"knee": 0.6, "power": 3}})


def test_saturated_machine_keeps_the_power_balance(bare):
    """Electrical in = losses + mechanical + change of field energy, the latter by quadrature of i dpsi."""
    from scipy.integrate import quad

    machine, q = bare.machine, composition.curve_parameters(saturating(bare))
    form, k, rng = machine.gamma_form(), machine.L_s / machine.L_m, np.random.default_rng(8)

    def energy(x):
        size = np.hypot(x[0], x[1])
        main = quad(lambda psi: psi * saturated_machine.inverse_inductance(psi * psi, q), 0.0, size, epsabs=1e-13)[0]
        leak = abs(complex(x[0], x[1]) - k * complex(x[2], x[3])) ** 2 / (2 * form["L_ell"])
        return 1.5 * (main + leak)

    for _ in range(20):
        x, u = rng.normal(size=5) * [0.4, 0.4, 0.03, 0.03, 80], rng.normal(size=2) * 100
        x[2:4] += x[:2] / k
        rates = np.array(saturated_machine.saturated_plant(tuple(x), tuple(u), 0.0, q))
        i = saturated_machine.stator_current(tuple(x), q)
        i_rotor = (k * complex(x[2], x[3]) - complex(x[0], x[1])) / form["L_ell"]
        electrical = 1.5 * (u[0] * i[0] + u[1] * i[1])
        losses = 1.5 * (machine.R_s * (i[0] ** 2 + i[1] ** 2) + form["R_r"] * abs(i_rotor) ** 2)
        shaft_power = saturated_machine.saturated_torque(tuple(x), i, machine.n_p) * x[4] / machine.n_p
        step = 1e-7
        change = (energy(x + step * rates) - energy(x - step * rates)) / (2 * step)
        assert change == pytest.approx(electrical - losses - shaft_power, rel=1e-6, abs=1e-3)


def test_a_flat_curve_is_the_machine_of_the_paper(bare):
    """(1) at random states, through psi_s = sigma i + (L_m / L_r) phi."""
    machine, rng = bare.machine, np.random.default_rng(9)
    q = composition.curve_parameters(bare.changed({"saturation.knee": 1e9}))
    share = machine.L_m / machine.L_r
    for _ in range(20):
        i, phi, omega, u = rng.normal(size=2) * 10, rng.normal(size=2) * 0.5, rng.normal() * 80, rng.normal(size=2) * 100
        psi = machine.sigma * i + share * phi
        flat = saturated_machine.saturated_plant((*psi, *phi, omega), tuple(u), 3.0, q)
        plain_rates = np.array(machine_rates((*i, *phi, omega), tuple(u), 3.0, machine.plant_parameters, 0.0))
        np.testing.assert_allclose(saturated_machine.stator_current((*psi, *phi, omega), q), i, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(flat[:2], machine.sigma * plain_rates[:2] + share * plain_rates[2:4], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(flat[2:], plain_rates[2:], rtol=1e-9, atol=1e-9)


def test_saturation_draws_the_current_of_the_curve(bare):
    """Magnetised at no load, i = psi (1 + (psi / knee)^6) / L_s; and a run starts with the current that was asked for."""
    study = saturating(bare).changed({"load.T_l": [0.0, 0.0], "machine.B": 0.0, "reference.omega": [10.0, 10.0],
                                      "initial.omega": 10.0, "simulation.duration": 2.0})
    data = simulate(study)
    assert float(data["i_ds"][0]) == pytest.approx(8.0, rel=1e-12) and float(data["i_qs"][0]) == pytest.approx(0.0, abs=1e-12)
    end = data.isel(time=-1)
    psi, i = np.hypot(end["psi_ds"], end["psi_qs"]), np.hypot(end["i_ds"], end["i_qs"])
    assert float(i) == pytest.approx(float(psi * (1 + (psi / 0.6) ** 6) / study.machine.L_s), rel=1e-4)


def test_a_table_is_fitted(bare):
    L_s = bare.machine.L_s
    flux = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
    current = [psi / L_s * (1 + (psi / 0.62) ** 8) for psi in flux]
    knee, power = bare.changed({"saturation": {"flux": flux, "current": current}}).saturation.curve(L_s)
    assert power == 4 and knee == pytest.approx(0.62, rel=1e-9)


# Who believes what ---------------------------------------------------------------------------------------------------------
def test_the_drive_s_own_errors(bare):
    """A drive that takes R_r for 20 % larger than it is builds its flux with that, and the machine has another."""
    study = bare.changed({"drive.errors.R_r": 0.2, "simulation.duration": 1.0})
    end = simulate(study).isel(time=-1)
    right = simulate(bare.changed({"simulation.duration": 1.0})).isel(time=-1)
    assert study.drive_machine.R_r == pytest.approx(1.2 * bare.machine.R_r)
    assert float(np.hypot(right["phi_dr"], right["phi_qr"])) == pytest.approx(bare.drive.flux, rel=1e-3)
    # under load the real slip is that of the true rotor at another flux: i_q / i_d = slip' / alpha' as the drive orients it
    machine = bare.machine
    i, phi = complex(end["i_ds"], end["i_qs"]), complex(end["phi_dr"], end["phi_qr"])
    slip = machine.alpha * machine.L_m * (i / phi).imag
    believed = study.drive_machine
    own = believed.alpha * believed.L_m * i / (believed.alpha + 1j * slip)
    assert abs(own) == pytest.approx(bare.drive.flux, rel=1e-3) and abs(phi) != pytest.approx(bare.drive.flux, rel=0.02)


@pytest.mark.parametrize("whence", ["reference", "estimate"])
def test_direction_by_reference_or_estimate(paper, whence):
    """Turning backwards, all three ways of telling the direction agree once it turns; and lanes agree with the single run."""
    study = paper.only(["repaired"]).changed({"simulation.duration": 0.5001, "simulation.record_every": 1,
                                              "reference.time": [0, 0.2], "reference.omega": [30.0, -20.0]})
    told = study.changed({"observers.repaired.direction": whence, "drive.feedback": "repaired"})
    end = simulate(told).isel(time=-1)
    assert float(end["omega_hat"][0]) == pytest.approx(-20.0, abs=0.1)
    ends = run_batch(told.changed({"simulation.duration": 0.5}), {}).ends
    assert ends["omega"][0] == pytest.approx(float(end["omega"]), rel=1e-10)
    assert ends["repaired/alpha_hat"][0] == pytest.approx(float(end["alpha_hat"][0]), rel=1e-9)


def test_plain_or_not(paper, everything):
    assert plain(composition.loop_of(paper)) and plain(Loop(("repaired",), True, directions=("reference",)))
    assert not plain(Loop(("repaired", "baseline"), directions=("reference", "true")))
    with pytest.raises(InputError, match=r"inverter.delay, inverter.dc_link, .*saturation: a batch must do without"):
        run_batch(everything, {})
    with pytest.raises(InputError, match=r"^simulation.order = 5: a batch must do without"):
        run_batch(paper.changed({"simulation.order": 5}), {})


@pytest.mark.parametrize(("values", "text"), [
    ({"inverter.delay": 2}, "inverter.delay = 2 must be 1 or below"),
    ({"inverter.dead_time": "1 us"}, "dead_time = 1e-06 needs a DC link"),
    ({"inverter.dc_link": 500.0, "inverter.dead_time": 3e-5}, "must be below a quarter of the carrier period, 2.5e-05 s"),
    ({"mechanics.stiffness": 3.0}, "load_share = 0 must be above 0"),
    ({"mechanics.load_share": 0.1}, "stiffness = 0 N m must be above 0"),
    ({"mechanics": {"load_share": 1.0, "stiffness": 3.0}}, "load_share = 1 must be below 1"),
    ({"mechanics": {"load_share": 0.6, "stiffness": 3e6}}, "set simulation.substeps to 6 or more"),
    ({"mechanics.coulomb": "3 A"}, "it must be in N m"),
    ({"saturation": {"flux": [0.1, 0.2, 0.3], "current": [1.0, 2.0]}}, "must be as many"),
    ({"saturation": {"flux": [0.1, 0.2], "current": [1.0, 2.0]}}, "a curve needs 3 or more"),
    ({"saturation": {"flux": [0.1, 0.3, 0.2], "current": [1.0, 2.0, 3.0]}}, "flux must increase"),
    ({"saturation": {"flux": [0.1, 0.2, 0.3], "current": [1.0, 2.0, 3.0]}}, "saturation.current misses every curve"),
    ({"saturation": {"knee": 0.7, "flux": [0.1, 0.2, 0.3], "current": [1.0, 2.0, 3.0]}}, "were both given"),
    ({"drive.errors.n_p": 1.0}, "errors.n_p is not known for the drive"),
    ({"drive.errors.R_s": -1.0}, "must be above -1"),
    ({"observers.repaired.errors.L_m": 0.5}, "observers.repaired.errors make a machine that cannot be: L_m"),
    ({"observers.repaired.direction": "up"}, "observers.repaired.direction = 'up' must be 'true', 'reference' or 'estimate'"),
    ({"sensors.current_resolution": -1.0}, "current_resolution = -1 A must be 0 A or above"),
])
def test_bad_input_is_named_in_a_line(paper, values, text):
    with pytest.raises(InputError, match=text) as caught:
        paper.changed(values)
    assert "\n" not in str(caught.value)
