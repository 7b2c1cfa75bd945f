"""Why alpha_hat stops where it does: predicted from the study before any simulation, and followed along a run.

While the flux builds up, its magnitude moves and alpha is identifiable: alpha_hat comes near the truth. From then on the flux
is constant, v_1 = (slip/alpha) v_2, and alpha_hat moves only as d alpha_hat = (g/K_p) (slip/alpha) d omega_hat (claim
``resting.drift``). Slip is torque, so without load every change of speed, up or down, raises alpha_hat by

    (g / K_p) (L_m / (mu psi^2)) int omega' omega_hat' dt,

with omega_hat' = omega' but for the time by which the estimate follows (`imo_analysis.excitation.following`).

At constant slip the repaired observer conserves `equations.drift.balance` and q = k_3 z_tilde - j kappa s xi_tilde; with the
family of rest states (three numbers) they fix where a disturbance ends.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from imo_analysis.equations import drift, lyapunov
from imo_analysis.errors import InputError
from imo_analysis.excitation.following import seen_share
from imo_analysis.machine import InductionMachine

if TYPE_CHECKING:
    from imo_analysis.study import Study

Pair = tuple[float, float]


def steady_slip(run: xr.Dataset, machine: InductionMachine) -> xr.DataArray:
    """Slip of the rotor flux over time in rad/s, alpha L_m (phi x i) / |phi|^2; NaN without flux."""
    cross = run["phi_dr"] * run["i_qs"] - run["phi_qr"] * run["i_ds"]
    square = run["phi_dr"] ** 2 + run["phi_qr"] ** 2
    slip = machine.alpha * machine.L_m * cross / square.where(square > 0)
    return slip.assign_attrs(units="rad/s", long_name="slip of the rotor flux")


def drift_along(run: xr.Dataset, machine: InductionMachine, g: float, K_p: float, start: float) -> xr.DataArray:
    """The drift of alpha_hat since ``start``, (g/K_p) int (slip/alpha) d omega, from the motion alone.

    Parameters
    ----------
    run : xarray.Dataset
        A run; only the plant's own signals are used.
    machine : InductionMachine
    g, K_p : float
        Gains of (9) and (11).
    start : float
        A time in s from which the flux magnitude is constant.

    Returns
    -------
    xarray.DataArray
        Over the times from ``start``, in 1/s.
    """
    late = run.sel(time=slice(start, None))
    if late.sizes["time"] < 2:
        raise InputError(f"start = {start:g} s leaves fewer than two samples of the run; take an earlier time")
    ratio = drift.drift_rate(steady_slip(late, machine).values, machine.alpha, g, K_p)
    steps = (ratio[1:] + ratio[:-1]) / 2 * np.diff(late["omega"].values)
    return xr.DataArray(np.concatenate([[0.0], np.cumsum(steps)]), coords={"time": late["time"].values}, dims="time",
                        attrs={"units": "1/s", "long_name": "drift of alpha_hat that the motion makes"})


@dataclass(frozen=True)
class SpeedStep:
    """A change of speed and the drift that it will make.

    Attributes
    ----------
    time, before, after : float
        When (s), from and to which electrical speed (rad/s).
    drift : float
        Of alpha_hat, in 1/s.
    alpha_hat : float
        Predicted after the step, in 1/s.
    """

    time: float
    before: float
    after: float
    drift: float
    alpha_hat: float


def predict_steps(study: Study, observer: str, alpha_hat: float | None = None) -> list[SpeedStep]:
    """alpha_hat after every speed step of a study, before simulating it.

    The speed loop answers with its bandwidth, up to the acceleration that the current limit leaves; the flux is at its
    reference. The first reference (the start) is taken to identify alpha, for there the flux builds up.

    Parameters
    ----------
    study : Study
        With a reference of steps and a constant load.
    observer : str
        Name of an adaptive observer in the study.
    alpha_hat : float, optional
        Value after the start, in 1/s; the true alpha if not given.

    Raises
    ------
    InputError
        If the reference is not of steps, the load is not constant, the flux is modulated, or the observer has no g and K_p.
    """
    machine, drive = study.machine, study.drive
    if study.reference.shape != "steps" or len(set(study.load_torque.T_l)) > 1:
        raise InputError('the drift is predicted for speed steps at constant load; set reference.shape = "steps" and one T_l')
    if drive.flux_modulation:
        raise InputError("the drift is predicted for constant flux; set drive.flux_modulation = 0")
    gains = study.observers[observer].gains if observer in study.observers else {}
    if not {"g", "K_p"} <= set(gains):
        raise InputError(f"{observer!r} is not an adaptive observer of the study; it has no gains g and K_p")
    current = machine.alpha if alpha_hat is None else alpha_hat
    found = []
    speeds = study.reference.omega
    for time, before, after in zip(study.reference.time[1:], speeds[:-1], speeds[1:], strict=True):
        change = drift_of_step(study, gains, before, after, study.load_torque.T_l[0], observer)
        current += change
        found.append(SpeedStep(time, before, after, change, current))
    return found


def drift_of_step(study: Study, gains: Mapping[str, float], before: float, after: float, load: float,
                  observer: str = "") -> float:
    """What a step of the speed reference adds to alpha_hat, in 1/s, at constant flux.

    Parameters
    ----------
    study : Study
        Gives machine and drive.
    gains : mapping
        g and K_p.
    before, after : float
        Electrical speeds in rad/s.
    load : float
        Torque in N m.
    observer : str
        Whose estimate of the speed is counted instead of the speed, as it follows (`following.seen_share`), where the drive's
        current does not limit the step; none if not given.

    Raises
    ------
    InputError
        If the drive's current does not even magnetise the machine.
    """
    machine, drive = study.machine, study.drive
    magnetizing = drive.flux / machine.L_m
    if magnetizing >= drive.current_limit:
        raise InputError(f"drive.current_limit = {drive.current_limit:g} A must be above the magnetising {magnetizing:.3g} A")
    step, braking = after - before, load * machine.n_p / machine.J
    if not step:
        return 0.0
    torque_limit = machine.mu * drive.flux * math.sqrt(drive.current_limit**2 - magnetizing**2)
    first = drive.speed_bandwidth * abs(step)
    limit = min(torque_limit - math.copysign(1.0, step) * braking, first)
    square = drift.square_integral_of_step(abs(step), drive.speed_bandwidth, limit)
    if observer and limit == first:
        square *= seen_share(study, observer, before, after)
    return float(drift.drift_of_acceleration(square, braking * step, drive.flux, machine.L_m, machine.mu, gains["g"],
                                             gains["K_p"]))


def explain(run: xr.Dataset, study: Study, observer: str, start: float) -> xr.Dataset:
    """alpha_hat along a run beside what the motion predicts from ``start`` on, and the error of the reconstructed flux.

    Parameters
    ----------
    run : xarray.Dataset
    study : Study
        The one of the run.
    observer : str
        An adaptive observer.
    start : float
        Time in s after which the flux magnitude is constant; the prediction starts from alpha_hat there.

    Returns
    -------
    xarray.Dataset
        ``alpha_hat``, ``alpha`` and ``flux_error`` (Wb) over ``time``; ``predicted`` over ``late``; ``step_alpha_hat`` over
        ``step_time``: `predict_steps` from the true alpha, which needs no run.
    """
    one = run.sel(observer=observer)
    gains = study.observers[observer].gains
    moved = drift_along(run, study.machine, gains["g"], gains["K_p"], start)
    first = float(one["alpha_hat"].sel(time=start, method="nearest"))
    flux_error = np.hypot((one["phi_dr_hat"] - run["phi_dr"]).values, (one["phi_qr_hat"] - run["phi_qr"]).values)
    steps = predict_steps(study, observer)
    data = xr.Dataset(
        {
            "alpha_hat": ("time", one["alpha_hat"].values), "flux_error": ("time", flux_error),
            "predicted": ("late", first + moved.values), "step_alpha_hat": ("step_time", [s.alpha_hat for s in steps]),
        },
        coords={"time": run["time"].values, "late": moved["time"].values, "step_time": [s.time for s in steps]},
        attrs={"observer": observer, "alpha": study.machine.alpha, "start": start},
    )
    for name, unit, meaning in (
        ("alpha_hat", "1/s", "estimate of alpha"), ("flux_error", "Wb", "magnitude of the error of the reconstructed flux"),
        ("predicted", "1/s", "alpha_hat at the start of the prediction plus (g/K_p) int (slip/alpha) d omega"),
        ("step_alpha_hat", "1/s", "alpha_hat after each step, predicted from the study alone"),
        ("time", "s", "time"), ("late", "s", "time"), ("step_time", "s", "time of the step"),
    ):
        data[name].attrs.update(units=unit, long_name=meaning)
    return data


@dataclass(frozen=True)
class Rest:
    """A rest state: estimates in 1/s and rad/s, errors of the two copies of z in A."""

    alpha_hat: float
    omega_hat: float
    xi_tilde: Pair
    z_tilde: Pair


def conserved(alpha_hat: float, omega_hat: float, xi_tilde: Pair, z_tilde: Pair, slip: float, alpha: float,
              gains: Sequence[float]) -> tuple[float, float, float]:
    """``(balance, q_1, q_2)`` of the repaired observer; ``gains`` is ``(g, K_p, k_3, kappa s)``."""
    k_3, kappa_s = gains[2], gains[3]
    q = lyapunov.conserved(*z_tilde, *xi_tilde, kappa_s, k_3, 1)
    return float(drift.balance(alpha_hat, omega_hat, xi_tilde, z_tilde, slip, alpha, gains)), float(q[0]), float(q[1])


def predict_rest(alpha_hat: float, omega_hat: float, xi_tilde: Pair, z_tilde: Pair, *, omega: float, slip: float, alpha: float,
                 gains: Sequence[float]) -> Rest:
    """Where the repaired observer comes to rest at constant flux, speed and slip, from what it conserves.

    Parameters
    ----------
    alpha_hat, omega_hat : float
        At the start, in 1/s and rad/s; the current error is small against what it will become, or zero.
    xi_tilde, z_tilde : pair of float
        Errors at the start, in A.
    omega, slip, alpha : float
        True speed, slip and alpha.
    gains : sequence
        ``(g, K_p, k_3, kappa s)``, kappa not zero.

    Raises
    ------
    InputError
        If no rest state with alpha_hat > 0 has these conserved values.
    """
    from scipy.optimize import brentq

    target, q_1, q_2 = conserved(alpha_hat, omega_hat, xi_tilde, z_tilde, slip, alpha, gains)
    k_3, kappa_s = gains[2], gains[3]

    def state(value: float) -> Rest:
        speed = omega + slip / alpha * (alpha - value)
        factor = k_3 + kappa_s * speed / value  # q = factor z_tilde on the family
        z = (q_1 / factor, q_2 / factor)
        speed, xi = drift.rest(value, z, omega, slip, alpha)
        return Rest(value, speed, xi, z)

    def miss(value: float) -> float:
        rest = state(value)
        return conserved(value, rest.omega_hat, rest.xi_tilde, rest.z_tilde, slip, alpha, gains)[0] - target

    for width in (1.05, 1.3, 2.0, 5.0, 20.0):
        low, high = alpha_hat / width, alpha_hat * width
        if miss(low) * miss(high) <= 0:
            return state(float(brentq(miss, low, high, xtol=1e-13, rtol=1e-14)))
    raise InputError("no rest state with alpha_hat > 0 has these conserved values")
