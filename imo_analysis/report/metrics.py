"""Numbers that describe a run: errors in a window around a speed step, and where the estimates end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr


BAND = 0.02  # of the change of speed in a window: within it an error counts as settled


@dataclass(frozen=True)
class StepResponse:
    """How one observer's speed estimate follows in a window.

    Attributes
    ----------
    observer : str
    peak : float
        Largest absolute speed error in rad/s.
    rms : float
        Root mean square of the speed error in rad/s.
    settled : float
        Time in s from the start of the window after which the error stays within ``band``; NaN if it never does.
    band : float
        `BAND` of the change of the true speed in the window, in rad/s.
    """

    observer: str
    peak: float
    rms: float
    settled: float
    band: float


def step_responses(run: xr.Dataset, window: tuple[float, float]) -> list[StepResponse]:
    """The response of every observer of a run in a window (first and last time, s)."""
    part = run.sel(time=slice(*window))
    time, omega = part["time"].values, part["omega"].values
    band = BAND * float(np.ptp(omega))
    results = []
    for name in part["observer"].values:
        error = np.abs(omega - part["omega_hat"].sel(observer=name).values)
        outside = np.flatnonzero(~(error <= band))
        if outside.size == 0:
            settled = 0.0
        elif outside[-1] == error.size - 1:
            settled = float("nan")
        else:
            settled = float(time[outside[-1] + 1] - time[0])
        results.append(StepResponse(str(name), float(np.max(error)), float(np.sqrt(np.mean(error**2))), settled, band))
    return results


@dataclass(frozen=True)
class Resting:
    """Where one observer's estimates stand at an instant: means over a short stretch before it, so that noise counts little.

    Attributes
    ----------
    observer : str
    time : float
        In s.
    omega, omega_hat, alpha_hat : float
        Speeds in rad/s, estimate of alpha in 1/s (NaN where the observer has none).
    flux_error : float
        Length of the flux error over the length of the flux.
    z_error, xi_error : float
        Lengths of z and xi errors over the length of z (NaN where the observer has none).
    rms : float
        Root mean square of the speed error in the stretch, in rad/s.
    wanted : float
        The speed in rad/s that a drive closed on this estimate was asked for; NaN for an estimate that only watches.
    """

    observer: str
    time: float
    omega: float
    omega_hat: float
    alpha_hat: float
    flux_error: float
    z_error: float
    xi_error: float
    rms: float = 0.0
    wanted: float = math.nan

    @property
    def error(self) -> float:
        """Mean error of the estimate in rad/s or, if that is larger, of the speed of the machine that it drives."""
        estimate, machine = self.omega - self.omega_hat, self.wanted - self.omega
        return machine if abs(machine) > abs(estimate) else estimate


def resting(run: xr.Dataset, beta: float, instant: float, stretch: float = 0.0, drives: bool = False) -> list[Resting]:
    """Every observer of a run at the last sample at or before an instant, and ``stretch`` before it (both in s).

    ``drives`` tells whether its estimate drives the machine.
    """
    until = run.sel(time=slice(None, instant))
    last = float(until["time"][-1])
    at = until.sel(time=slice(last - stretch, None))
    omega = at["omega"].values
    phi = at["phi_dr"].values + 1j * at["phi_qr"].values
    z = at["i_ds"].values + 1j * at["i_qs"].values + beta * phi

    def share(one: xr.Dataset, d: str, q: str, true: np.ndarray) -> float:
        return float(np.mean(np.abs(true - one[d].values - 1j * one[q].values) / np.abs(true)))

    results = []
    for name in run["observer"].values:
        one = at.sel(observer=name)
        hat = one["omega_hat"].values
        results.append(Resting(
            str(name), last, float(np.mean(omega)), float(np.mean(hat)), float(np.mean(one["alpha_hat"].values)),
            share(one, "phi_dr_hat", "phi_qr_hat", phi), share(one, "z_1_hat", "z_2_hat", z),
            share(one, "xi_1_hat", "xi_2_hat", z), float(np.sqrt(np.mean((omega - hat) ** 2))),
            float(np.mean(at["omega_ref"].values)) if drives else math.nan))
    return results
