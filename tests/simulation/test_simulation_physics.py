"""What any right simulation of this machine must keep: power, frames, mirror, units, invariants, and an independent model."""

import numpy as np
import oracle_motulator
import pytest

from imo_analysis.equations.plant import plant, torque
from imo_analysis.simulation.kernel import PLANT_STATES
from imo_analysis.simulation.run import simulate


def close(a, b, tolerance):
    """Whether two series agree relative to their size."""
    assert np.max(np.abs(np.asarray(a) - np.asarray(b))) <= tolerance * np.max(np.abs(b))


def powers(machine, x, u):
    """Electrical, lost and mechanical power (W), and field energy (J), of the T circuit with the rotor current spelled out."""
    i_s, phi = x[0] + 1j * x[1], x[2] + 1j * x[3]
    i_r = (phi - machine.L_m * i_s) / machine.L_r
    psi_s = machine.L_s * i_s + machine.L_m * i_r
    electrical = 1.5 * (np.conj(u) * i_s).real
    losses = 1.5 * (machine.R_s * abs(i_s) ** 2 + machine.R_r * abs(i_r) ** 2)
    mechanical = 1.5 * machine.n_p * (np.conj(psi_s) * i_s).imag * x[4] / machine.n_p
    energy = 0.75 * (np.conj(psi_s) * i_s + np.conj(phi) * i_r).real
    return electrical, losses, mechanical, energy


def test_power_balance(turning):
    """Electrical in = losses + mechanical + change of field energy, integrated over each sample to the order of RK4."""
    machine, T = turning.machine, turning.simulation.sample_time
    run = simulate(turning.changed({"simulation.substeps": 2}))
    x = np.array([run[name].values for name in PLANT_STATES])
    u = run["u_ds"].values + 1j * run["u_qs"].values
    T_l = run["T_l"].values

    def surplus(x, u):
        electrical, losses, mechanical, _ = powers(machine, x, u)
        return electrical - losses - mechanical

    def slope(x, u, load):
        carried = load + machine.B * x[4] / machine.n_p
        rates = np.array(plant(tuple(x), (u.real, u.imag), 0.0, carried, machine.plant_parameters))
        step = 1e-4
        return (surplus(x + step * rates, u) - surplus(x - step * rates, u)) / (2 * step)

    start, end, held, load = x[:, :-1], x[:, 1:], u[:-1], T_l[:-1]
    work = T / 2 * (surplus(start, held) + surplus(end, held))
    work += T**2 / 12 * (slope(start, held, load) - slope(end, held, load))
    gain = np.diff(powers(machine, x, u)[3])
    assert np.max(np.abs(work - gain)) < 1e-6 * np.max(np.abs(gain))


def test_power_balance_is_exact_in_the_rates(turning):
    machine, rng = turning.machine, np.random.default_rng(7)
    for _ in range(50):
        x, u = rng.normal(size=5) * [10, 10, 0.5, 0.5, 80], complex(*rng.normal(size=2) * 100)
        rates = np.array(plant(tuple(x), (u.real, u.imag), 0.0, 3.0, machine.plant_parameters))
        electrical, losses, mechanical, _ = powers(machine, x, u)
        step = 1e-5
        change = (powers(machine, x + step * rates, u)[3] - powers(machine, x - step * rates, u)[3]) / (2 * step)
        assert change == pytest.approx(electrical - losses - mechanical, rel=1e-7, abs=1e-6)
        shaft = torque(tuple(x), machine.n_p, machine.L_m, machine.L_r) * x[4] / machine.n_p
        assert mechanical == pytest.approx(shaft, rel=1e-12)


VECTORS = [("i_ds", "i_qs"), ("phi_dr", "phi_qr"), ("u_ds", "u_qs"), ("i_ds_hat", "i_qs_hat"), ("z_1_hat", "z_2_hat"),
           ("xi_1_hat", "xi_2_hat"), ("phi_dr_hat", "phi_qr_hat")]
SCALARS = ["omega", "torque", "omega_hat", "alpha_hat"]


def turned(data, angle):
    """The study's initial vectors turned by an angle, in its plain data."""
    c, s = np.cos(angle), np.sin(angle)
    changes = {}
    tables = {"initial": data["initial"], **{f"observers.{n}.initial": one["initial"] for n, one in data["observers"].items()}}
    for table, values in tables.items():
        for d, q in VECTORS:
            if d in values:
                changes[f"{table}.{d}"], changes[f"{table}.{q}"] = float(c * values[d]), float(s * values[d])
    return changes


def test_turning_the_axes_turns_the_run(turning):
    angle = 0.7
    one, other = simulate(turning), simulate(turning.changed(turned(turning.data, angle)))
    for d, q in VECTORS:
        a = np.nan_to_num((one[d].values + 1j * one[q].values) * np.exp(1j * angle))
        close(np.nan_to_num(other[d].values + 1j * other[q].values), a, 1e-11)
    for name in SCALARS:
        close(np.nan_to_num(other[name].values), np.nan_to_num(one[name].values), 1e-11)


def test_a_rotating_frame_gives_the_same_machine(turning):
    """(1) integrated at omega_1 = 50 rad/s, its voltages turned, against the stationary run."""
    run, machine, T, omega_1 = simulate(turning.changed({"simulation.substeps": 4})), turning.machine, 1e-4, 50.0
    x = np.array([float(run[name][0]) for name in PLANT_STATES])

    def rates(t, x, u, load):
        turned_u = u * np.exp(-1j * omega_1 * t)
        return np.array(plant(tuple(x), (turned_u.real, turned_u.imag), omega_1, load + machine.B * x[4] / machine.n_p,
                              machine.plant_parameters))

    n, h = 4, T / 4
    for k in range(200):
        u, load = complex(run["u_ds"][k], run["u_qs"][k]), float(run["T_l"][k])
        for j in range(n):
            t = k * T + j * h
            a = rates(t, x, u, load)
            b = rates(t + h / 2, x + h / 2 * a, u, load)
            c = rates(t + h / 2, x + h / 2 * b, u, load)
            x = x + h / 6 * (a + 2 * b + 2 * c + rates(t + h, x + h * c, u, load))
    back = np.exp(1j * omega_1 * 200 * T)
    assert complex(*x[:2]) * back == pytest.approx(complex(run["i_ds"][200], run["i_qs"][200]), rel=1e-8)
    assert complex(*x[2:4]) * back == pytest.approx(complex(run["phi_dr"][200], run["phi_qr"][200]), rel=1e-8)
    assert x[4] == pytest.approx(float(run["omega"][200]), rel=1e-9)


def mirrored(turning):
    return turning.changed({
        "initial.omega": -60.0, "reference.omega": [-60.0, -80.0], "load.T_l": [0.0, -5.0],
        **{f"observers.{name}.initial.omega_hat": -55.0 for name in turning.observers},
    })


def test_the_other_direction_is_the_mirror_image(turning):
    names = ["baseline", "repaired"]
    one, other = simulate(turning.only(names)), simulate(mirrored(turning).only(names))
    for d, q in VECTORS:
        close(np.nan_to_num(other[d].values), np.nan_to_num(one[d].values), 1e-11)
        close(np.nan_to_num(other[q].values), -np.nan_to_num(one[q].values), 1e-11)
    for name, sign in (("omega", -1), ("omega_hat", -1), ("alpha_hat", 1), ("torque", -1)):
        close(np.nan_to_num(other[name].values), sign * np.nan_to_num(one[name].values), 1e-11)


def test_the_sign_in_11_breaks_the_mirror(turning):
    """Not a wish: with (11) as printed the estimate is lost at negative speed."""
    longer = {"simulation.duration": 1.0}
    right = simulate(turning.changed(longer).only(["consistent_12"]))
    wrong = simulate(mirrored(turning).changed(longer).only(["consistent_12"]))
    assert abs(float(right["omega_hat"][0, -1] - right["omega"][-1])) < 1.0
    assert abs(float(wrong["omega_hat"][0, -1] - wrong["omega"][-1])) > 50.0


def test_other_units_of_current_and_voltage(turning):
    """Currents in units of 8 A and voltages in units of 2 V: powers of two, so that rounding is the same as well."""
    amperes, volts = 8.0, 2.0
    ohms, machine = volts / amperes, turning.machine
    gain = {"g": amperes**2, "K_p": amperes**2, "h": amperes**2, "l_3": 1 / ohms, "l_4": 1 / ohms}
    units = {"i": 1 / amperes, "z": 1 / amperes, "xi": 1 / amperes, "phi": 1 / volts}
    changes = {f"machine.{name}": getattr(machine, name) / ohms for name in ("R_s", "R_r", "L_m", "L_s", "L_r")}
    changes |= {"machine.J": machine.J / (volts * amperes), "machine.B": machine.B / (volts * amperes),
                "load.T_l": [0.0, 5.0 / (volts * amperes)], "drive.flux": turning.drive.flux / volts,
                "drive.voltage_limit": turning.drive.voltage_limit / volts,
                "drive.current_limit": turning.drive.current_limit / amperes}
    for name, value in turning.data["initial"].items():
        changes[f"initial.{name}"] = value * units.get(name.split("_")[0], 1.0)
    for name, settings in turning.observers.items():
        for key, value in settings.gains.items():
            changes[f"observers.{name}.gains.{key}"] = value * gain.get(key, 1.0)
        for key, value in settings.initial.items():
            changes[f"observers.{name}.initial.{key}"] = value * units.get(key.split("_")[0], 1.0)
    one, other = simulate(turning), simulate(turning.changed(changes))
    for name in SCALARS[:1] + SCALARS[2:]:
        close(np.nan_to_num(other[name].values), np.nan_to_num(one[name].values), 1e-12)
    close(np.nan_to_num(other["i_ds_hat"].values) * amperes, np.nan_to_num(one["i_ds_hat"].values), 1e-12)
    close(other["phi_dr"].values * volts, one["phi_dr"].values, 1e-12)


def test_q_is_conserved(paper):
    """q = k_3 z~ - j kappa s xi~ of the repaired observer, over 60 s and four speeds."""
    study = paper.only(["repaired"]).changed({"observers.repaired.initial.z_1_hat": 20.0})
    run, beta = simulate(study), study.machine.beta
    gains = study.observers["repaired"].gains
    z = run["i_ds"].values + 1j * run["i_qs"].values + beta * (run["phi_dr"].values + 1j * run["phi_qr"].values)
    z_tilde = z - (run["z_1_hat"][0].values + 1j * run["z_2_hat"][0].values)
    xi_tilde = z - (run["xi_1_hat"][0].values + 1j * run["xi_2_hat"][0].values)
    q = gains["k_3"] * z_tilde - 1j * gains["kappa"] * xi_tilde
    assert np.max(np.abs(q - q[0])) < 1e-12 * gains["k_3"] * np.max(np.abs(z))
    assert np.ptp(np.abs(z_tilde)) > 1.0, "the errors themselves do move"


def test_the_machine_agrees_with_motulator(turning):
    study = turning.only([]).changed({"initial.phi_dr": 0.0, "initial.i_ds": 0.0, "simulation.substeps": 8})
    run = simulate(study)
    current, omega, moment = oracle_motulator.run(
        study.machine, run["u_ds"].values + 1j * run["u_qs"].values, run["T_l"].values, study.simulation.sample_time, 60.0)
    close(run["i_ds"].values + 1j * run["i_qs"].values, current, 1e-8)
    close(run["omega"].values, omega, 1e-9)
    close(run["torque"].values, moment, 1e-8)
