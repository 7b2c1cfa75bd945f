"""A second route to a drive with everything on: complex fluxes, pulses from a carrier compared in time, DOP853 between edges.

Of the package it takes the control law, the observers' rates and the noise-free study; machine, saturation, shaft, friction,
inverter, delay and sensors are written again here.
"""

from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.simulation import drive

TURN = np.exp(2j * np.pi / 3 * np.arange(3))


def pulses(u, i, dc, period, dead):
    """(on, off) of each phase from a triangular carrier, each edge delayed where the dead time hands it to the diode."""
    v = np.real(u * TURN.conj())
    level = (v - (v.max() + v.min()) / 2) / dc
    found = []
    for value, current in zip(level, np.real(i * TURN.conj()), strict=True):
        # the carrier falls from +1/2 to -1/2 and rises again; the phase is high while the level is above it
        on, off = (0.5 - value) * period / 2, period - (0.5 - value) * period / 2
        found.append((on + (dead if current > 0 else 0), off + (dead if current < 0 else 0)))
    return found


def current_of(psi, phi, machine, curve):
    """Stator current of stator flux and rotor flux."""
    gamma = machine.gamma_form()
    k = machine.L_s / machine.L_m
    knee, power = curve
    return psi / gamma["L_s"] * (1 + (abs(psi) / knee) ** (2 * power)) + (psi - k * phi) / gamma["L_ell"]


def run(study, samples):
    """States at the samples: ``i``, ``phi``, ``psi`` (complex), ``omega``, ``omega_load``, and the first observer's."""
    machine, T, inverter, mechanics = study.machine, study.simulation.sample_time, study.inverter, study.mechanics
    gamma, k, n_p = machine.gamma_form(), machine.L_s / machine.L_m, machine.n_p
    curve = (study.saturation.knee, study.saturation.power)
    name = next(iter(study.observers))
    settings = study.observers[name]
    observer, believed = OBSERVERS[settings.kind], study.observer_machine(name).observer_parameters
    size = len(observer.states)
    J_load = mechanics.load_share * machine.J
    d = (T, study.drive.current_bandwidth, study.drive.flux_bandwidth, study.drive.speed_bandwidth,
         min(study.drive.voltage_limit, inverter.dc_link / np.sqrt(3)), study.drive.current_limit, 0.05 * study.drive.flux)
    p = study.drive_machine.plant_parameters
    phi, i = complex(study.initial.phi_dr, study.initial.phi_qr), complex(study.initial.i_ds, study.initial.i_qs)
    psi = machine.sigma * i + machine.L_m / machine.L_r * phi
    for _ in range(200):  # the stator flux that carries this current
        gap = current_of(psi, phi, machine, curve) - i
        psi -= gap * gamma["L_ell"] / 2
    omega = study.initial.omega
    y = np.array([psi.real, psi.imag, phi.real, phi.imag, omega, omega, 0.0, *settings.initial_values])
    flux, state, waiting = (phi.real, phi.imag), (0.0, 0.0, 0.0), 0j
    flow = drive.flux_rates(flux, (i.real, i.imag), omega, p)
    kept = []
    for n in range(samples):
        t = n * T
        omega_ref = float(np.interp(t, study.reference.time, study.reference.omega))
        T_l = float(np.interp(t, study.load_torque.time, study.load_torque.T_l))
        psi, phi = complex(y[0], y[1]), complex(y[2], y[3])
        i = current_of(psi, phi, machine, curve)
        kept.append((i, phi, psi, y[4], y[5], y[7:].copy()))
        step = study.sensors.current_resolution
        seen = [step * np.floor((g * value + o) / step + 0.5) for g, o, value in
                zip(study.sensors.current_gain, study.sensors.current_offset, (i.real, i.imag), strict=True)]
        asked, state = drive.control(state, tuple(seen), y[4], flux, omega_ref, study.drive.flux, p, d)
        flux, flow = drive.flux_model(flux, flow, tuple(seen), y[4], T, p)
        u, waiting = waiting, complex(*asked)
        edges = pulses(u, i, inverter.dc_link, T, inverter.dead_time)
        direction = 1.0 if omega_ref >= 0 else -1.0

        def rates(_, y, volts, u=u, T_l=T_l, seen=tuple(seen), direction=direction):
            psi, phi, omega, omega_load, twist = complex(y[0], y[1]), complex(y[2], y[3]), *y[4:7]
            i = current_of(psi, phi, machine, curve)
            i_rotor = (k * phi - psi) / gamma["L_ell"]
            shaft = mechanics.stiffness * twist + mechanics.damping * (omega - omega_load) / n_p
            dry = mechanics.coulomb * omega / np.hypot(omega, mechanics.coulomb_speed)
            moment = 1.5 * n_p * (psi.conjugate() * i).imag - shaft - dry - machine.B * omega / n_p
            psi_rate, phi_rate = volts - machine.R_s * i, 1j * omega * phi - gamma["R_r"] / k * i_rotor
            return [psi_rate.real, psi_rate.imag, phi_rate.real, phi_rate.imag, n_p * moment / (machine.J - J_load),
                    n_p * (shaft - T_l) / J_load, (omega - omega_load) / n_p,
                    *observer.rates(tuple(y[7 : 7 + size]), seen, (u.real, u.imag), direction, believed, settings.gain_values)]

        times = sorted({0.0, T, *(min(max(edge, 0.0), T) for pair in edges for edge in pair)})
        for begin, end in pairwise(times):
            middle = (begin + end) / 2
            high = np.array([inverter.dc_link * (on <= middle < off) for on, off in edges])
            volts = complex(2 / 3 * np.sum(high * TURN))
            y = solve_ivp(rates, (0.0, end - begin), y, args=(volts,), method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    return {key: np.array(column) for key, column in
            zip(("i", "phi", "psi", "omega", "omega_load", "observer"), zip(*kept, strict=True), strict=True)}
