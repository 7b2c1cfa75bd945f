"""Signals of a machine with a prescribed rotor flux, by formula: no simulator, so that the room can be tested alone."""

import numpy as np
import xarray as xr

from imo_analysis.machine import preset

MACHINE = preset("table-iii-printed-alpha")


def motion(duration=2.0, step=1e-4, flux=0.5307, modulation=0.0, frequency=20.0, omega=100.0, slip=2.0, start=0.0):
    """The plant's signals for phi = flux (1 + modulation cos(frequency t)) exp(j (omega + slip) t) at constant omega.

    The current is what the rotor equation of (1) asks for: i = (phi' + (alpha - j omega) phi) / (alpha L_m).
    """
    t = start + np.arange(round(duration / step)) * step
    alpha, stator = MACHINE.alpha, omega + slip
    magnitude = flux * (1 + modulation * np.cos(frequency * t))
    rate = -flux * modulation * frequency * np.sin(frequency * t)
    turn = np.exp(1j * stator * t)
    phi = magnitude * turn
    i = ((rate + 1j * stator * magnitude) * turn + (alpha - 1j * omega) * phi) / (alpha * MACHINE.L_m)
    signals = {"i_ds": i.real, "i_qs": i.imag, "phi_dr": phi.real, "phi_qr": phi.imag, "omega": np.full(len(t), float(omega))}
    return xr.Dataset({name: ("time", values) for name, values in signals.items()}, coords={"time": t})


def observed(plant, alpha_hat=None, name="converged", xi_shift=0.0):
    """A run in the shape of the data contract: the plant with an observer whose errors are zero but for a shift of xi_hat."""
    beta = MACHINE.beta
    z_1, z_2 = plant.i_ds + beta * plant.phi_dr, plant.i_qs + beta * plant.phi_qr
    hats = {
        "i_ds_hat": plant.i_ds, "i_qs_hat": plant.i_qs, "z_1_hat": z_1, "z_2_hat": z_2, "xi_1_hat": z_1 + xi_shift,
        "xi_2_hat": z_2, "alpha_hat": 0 * z_1 + (MACHINE.alpha if alpha_hat is None else alpha_hat), "omega_hat": plant.omega,
    }
    run = plant.assign({name: (("observer", "time"), values.values[None]) for name, values in hats.items()})
    run = run.assign(i_ds_meas=plant.i_ds, i_qs_meas=plant.i_qs).assign_coords(observer=[name])
    return run.assign_attrs(study=MACHINE.to_toml(), schema="imo-run/1")
