"""A second route to a run: the plain definitions, called as they are, between samples by DOP853 at a tight tolerance."""

import numpy as np
from scipy.integrate import solve_ivp

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.plant import plant
from imo_analysis.simulation import drive


def closed_loop(study, samples):
    """States of the machine and of each observer at the samples 0 .. samples - 1, as ``{name: array}``; measured feedback."""
    machine, T = study.machine, study.simulation.sample_time
    p = machine.plant_parameters
    d = (T, study.drive.current_bandwidth, study.drive.flux_bandwidth, study.drive.speed_bandwidth,
         study.drive.voltage_limit, study.drive.current_limit, 0.05 * study.drive.flux)
    observers = {name: (OBSERVERS[s.kind], study.observer_machine(name).observer_parameters, s.gain_values)
                 for name, s in study.observers.items()}
    parts = [np.array([getattr(study.initial, name) for name in ("i_ds", "i_qs", "phi_dr", "phi_qr", "omega")])]
    parts += [np.array(s.initial_values) for s in study.observers.values()]
    edges = np.cumsum([0] + [len(part) for part in parts])
    y = np.concatenate(parts)
    flux = (study.initial.phi_dr, study.initial.phi_qr)
    flow = plant(tuple(y[:5]), (0.0, 0.0), 0.0, 0.0, p)[2:4]
    state = (0.0, 0.0, 0.0)
    kept = []
    for k in range(samples):
        kept.append(y.copy())
        t = k * T
        omega_ref = [v for at, v in zip(study.reference.time, study.reference.omega, strict=True) if at <= t + 1e-9][-1]
        T_l = [v for at, v in zip(study.load_torque.time, study.load_torque.T_l, strict=True) if at <= t + 1e-9][-1]
        i = (y[0], y[1])
        u, state = drive.control(state, i, y[4], flux, omega_ref, study.drive.flux, p, d)
        flux, flow = drive.flux_model(flux, flow, i, y[4], T, p)
        direction = 1.0 if y[4] >= 0 else -1.0

        def rates(_, y, u=u, T_l=T_l, direction=direction):
            x = tuple(y[:5])
            found = [*plant(x, u, 0.0, T_l + machine.B * x[4] / machine.n_p, p)]
            for n, (observer, parameters, gains) in enumerate(observers.values(), 1):
                found += observer.rates(tuple(y[edges[n] : edges[n + 1]]), x[:2], u, direction, parameters, gains)
            return found

        y = solve_ivp(rates, (0.0, T), y, method="DOP853", rtol=1e-12, atol=1e-11).y[:, -1]
    kept = np.array(kept)
    return {name: kept[:, edges[n] : edges[n + 1]] for n, name in enumerate(["machine", *observers])}
