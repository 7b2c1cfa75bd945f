"""How far the rule of thumb is right: what it promises against the linearisation, over many machines, times and speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imo_analysis.machine import PRESETS, InductionMachine
from imo_analysis.pencils.error import OperatingPoint
from imo_analysis.tuning.rated import typical_flux
from imo_analysis.tuning.response import RECOVERY, response
from imo_analysis.tuning.rule import DAMPING, Times, rule_gains, rule_loops, rule_noise

if TYPE_CHECKING:
    import xarray as xr

LOW, HIGH = 0.13, 1.0  # of omega_max: where it is looked at
_DRAWN = ((5e-3, 50e-3), (0.5, 5.0), (7e-4, 7e-3), (60.0, 300.0))
SLIP = 0.35  # of the lowest speed: the largest slip, either sign


def machines(count: int, seed: int) -> list[InductionMachine]:
    """The presets with resistances, leakage, size and inertia drawn anew: each by up to a factor of two, log-evenly."""
    rng = np.random.default_rng(seed)
    names = list(PRESETS)
    found = []
    for n in range(count):
        one = PRESETS[names[n % len(names)]]
        r_s, r_r, size, leakage, inertia = 2.0 ** rng.uniform(-1, 1, 5)
        L_m = one.L_m * size
        found.append(InductionMachine(
            n_p=one.n_p, R_s=one.R_s * r_s, R_r=one.R_r * r_r, L_m=L_m, L_s=L_m + (one.L_s - one.L_m) * leakage * size,
            L_r=L_m + max(one.L_r - one.L_m, 0.01 * L_m) * leakage * size, J=one.J * inertia))
    return found


def rule_check(kind: str = "repaired", count: int = 200, seed: int = 1, damping: float = DAMPING) -> xr.Dataset:
    """What an observer with the gains of the rule does, over what the rule says.

    Parameters
    ----------
    kind : str
        One of the adaptive observers, or ``baseline``.
    count : int
        Machines; each with settling, recovery and lag drawn from 5 to 50 ms, 0.5 to 5 s, 0.7 to 7 ms, for speeds up to 60 to
        300 rad/s.
    seed : int
        Of all draws.
    damping : float
        zeta.

    Returns
    -------
    xarray.Dataset
        Dimension ``draw``: ``settling``, ``lag``, ``recovery``, measured over wished (1 or below is good); ``noise``, measured
        over promised, the worst of the speeds either way; and ``frequency``, the least stator frequency in units of 4 / t_r,
        and ``speed``, the largest speed in units of the current loop's decay a. Of the baseline, whose recovery cannot be
        wished for, ``recovery`` is in rotor time constants and ``frequency`` in units of alpha.
    """
    import xarray as xr

    rng = np.random.default_rng(seed + 1)
    names = ("settling", "lag", "recovery", "noise", "frequency", "speed")
    rows = []
    for machine in machines(count, seed):
        t_s, t_r, lag, top = (low * (high / low) ** rng.uniform() for low, high in _DRAWN)
        times = Times(float(t_s), float(t_r), float(LOW * top), float(top), damping, float(lag))
        flux = typical_flux(machine)
        low = LOW * top
        omega = np.geomspace(low, HIGH * top, 4)[:, None]
        slip = np.array([-SLIP, 0.0, SLIP]) * low
        found = response(machine, kind, rule_gains(machine, kind, flux, times), OperatingPoint(omega, flux, slip))
        promised = np.array([rule_noise(machine, kind, flux, times, float(w)) for w in omega[:, 0]])[:, None]
        ratio = (found.noise / promised).ravel()
        unit = 1 / machine.alpha if kind == "baseline" else t_r
        rows.append((found.settling.max() / t_s, found.lag.max() / lag, found.recovery.max() / unit,
                     ratio[np.argmax(np.abs(np.log(ratio)))],
                     (1 - SLIP) * low * (unit if kind == "baseline" else t_r / RECOVERY),
                     top / rule_loops(machine, kind, times).current))
    columns = np.array(rows, dtype=float).T
    return xr.Dataset({name: ("draw", column, {"units": "1"}) for name, column in zip(names, columns, strict=True)})
