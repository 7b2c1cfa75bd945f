"""Why alpha_hat stops where it does: predicted from the study before any simulation, and followed along a run.

While the flux builds up, its magnitude moves and alpha is identifiable: alpha_hat comes near the truth, and where it lands is
predicted by `imo_analysis.excitation.landing`. From then on the flux is constant, v_1 = (slip/alpha) v_2, and alpha_hat moves
only as d alpha_hat = (g/K_p) (slip/alpha) d omega_hat (claim ``resting.drift``). Slip is torque, so without load every change
of speed, up or down, raises alpha_hat by

    (g / K_p) (L_m / (mu psi^2)) int omega' omega_hat' dt,

with omega_hat' = omega' but for the time by which the estimate follows (`imo_analysis.excitation.following`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from imo_analysis.equations import drift
from imo_analysis.equations.transformation import to_z
from imo_analysis.errors import InputError
from imo_analysis.excitation.following import seen_share
from imo_analysis.excitation.landing import landing
from imo_analysis.machine import InductionMachine

if TYPE_CHECKING:
    from imo_analysis.study import Study


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
    reference. Before the first step alpha_hat is where the start leaves it (`landing.landing`).

    Parameters
    ----------
    study : Study
        With a reference of steps and a constant load.
    observer : str
        Name of an adaptive observer in the study.
    alpha_hat : float, optional
        Value before the first step, in 1/s; where the start lands if not given.

    Raises
    ------
    InputError
        If the reference is not of steps, the load is not constant, the flux is modulated, the observer has no g and K_p, or it
        lands nowhere.
    """
    drive = study.drive
    if study.reference.shape != "steps" or len(set(study.load_torque.T_l)) > 1:
        raise InputError('the drift is predicted for speed steps at constant load; set reference.shape = "steps" and one T_l')
    if drive.flux_modulation:
        raise InputError("the drift is predicted for constant flux; set drive.flux_modulation = 0")
    gains = study.observers[observer].gains if observer in study.observers else {}
    if not {"g", "K_p"} <= set(gains):
        raise InputError(f"{observer!r} is not an adaptive observer of the study; it has no gains g and K_p")
    current = landing(study, observer).alpha_hat if alpha_hat is None else alpha_hat
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
        ``alpha_hat`` and the errors ``flux_error`` (Wb) and ``xi_error`` (A) over ``time``; ``predicted`` over ``late``;
        ``step_alpha_hat`` over ``step_time``: the landing, then `predict_steps`, which need no run. Attributes: ``alpha`` and
        what the landing is made of, ``from_error``, ``from_motion`` (1/s), and the predicted ``landing_xi_error`` (A).
    """
    one = run.sel(observer=observer)
    gains = study.observers[observer].gains
    moved = drift_along(run, study.machine, gains["g"], gains["K_p"], start)
    first = float(one["alpha_hat"].sel(time=start, method="nearest"))
    flux_error = np.hypot((one["phi_dr_hat"] - run["phi_dr"]).values, (one["phi_qr_hat"] - run["phi_qr"]).values)
    z = to_z(run["i_ds"], run["i_qs"], run["phi_dr"], run["phi_qr"], study.machine.beta)
    xi_error = np.hypot((z[0] - one["xi_1_hat"]).values, (z[1] - one["xi_2_hat"]).values)
    landed = landing(study, observer)
    steps = predict_steps(study, observer, landed.alpha_hat)
    marks = [(landed.time, landed.alpha_hat), *((step.time, step.alpha_hat) for step in steps)]
    data = xr.Dataset(
        {
            "alpha_hat": ("time", one["alpha_hat"].values), "flux_error": ("time", flux_error),
            "xi_error": ("time", xi_error), "predicted": ("late", first + moved.values),
            "step_alpha_hat": ("step_time", [value for _, value in marks]),
        },
        coords={"time": run["time"].values, "late": moved["time"].values, "step_time": [time for time, _ in marks]},
        attrs={"observer": observer, "alpha": study.machine.alpha, "start": start, "from_error": landed.from_error,
               "from_motion": landed.from_motion, "landing_xi_error": math.hypot(*landed.rest.xi_tilde)},
    )
    for name, unit, meaning in (
        ("alpha_hat", "1/s", "estimate of alpha"), ("flux_error", "Wb", "magnitude of the error of the reconstructed flux"),
        ("xi_error", "A", "magnitude of the error of xi_hat"),
        ("predicted", "1/s", "alpha_hat at the start of the prediction plus (g/K_p) int (slip/alpha) d omega"),
        ("step_alpha_hat", "1/s", "alpha_hat after the start and after each step, predicted from the study alone"),
        ("time", "s", "time"), ("late", "s", "time"), ("step_time", "s", "time of the landing and of each step"),
    ):
        data[name].attrs.update(units=unit, long_name=meaning)
    return data
