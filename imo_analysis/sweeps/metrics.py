"""What a sweep says of each run: the numbers, their units, and how they follow from a batch's summary or from a whole run."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.excitation import alpha_direction, speed_direction
from imo_analysis.simulation.kernel import PLANT_STATES
from imo_analysis.simulation.labelled import Labelled
from imo_analysis.study import Study
from imo_analysis.sweeps.batch import Summary
from imo_analysis.sweeps.tally import OBSERVER, REGRESSOR

Array = NDArray[np.float64]

# name -> (unit, meaning), one number for each run and observer
METRICS = {
    "holds": ("1", "1 where the speed error stays within the band during the last part of the window, 0 where not"),
    "diverged_at": ("s", "time at which the observer or the machine left all bounds; NaN if it did not"),
    "settling_time": ("s", "time from the start of the window until the speed error stays within the band; NaN if it does not"),
    "speed_rms": ("rad/s", "root mean square of the speed error in the window, electrical, until divergence"),
    "speed_peak": ("rad/s", "largest size of the speed error in the window, electrical, until divergence"),
    "flux_rms": ("Wb", "root mean square of the length of the rotor flux error in the window, until divergence"),
    "flux_peak": ("Wb", "largest length of the rotor flux error in the window, until divergence"),
    "omega_error_end": ("rad/s", "true minus estimated speed at the end of the run, electrical"),
    "alpha_hat_end": ("1/s", "estimate of alpha at the end of the run; NaN for observers without one"),
    "excitation": ("1", "smallest eigenvalue of the mean Gram matrix of [I, v_1, v_2] over the window, with v in units of the "
                        "root mean square of v_2; NaN for observers without z and xi"),
}


def window_of(study: Study) -> tuple[int, int]:
    """First sample of a study's sweep window, and the one after its last."""
    T, samples = study.simulation.sample_time, study.simulation.samples
    last = samples if study.sweep.stop is None else min(samples, round(study.sweep.stop / T) + 1)
    return round(study.sweep.start / T), last


def metrics(study: Study, summary: Summary) -> dict[str, Array]:
    """`METRICS` of a batch, each of shape (observers of the study in its order, machines)."""
    T, every = study.simulation.sample_time, study.simulation.record_every
    first, last = summary.window
    results = {name: np.full((len(study.observers), len(summary.machine_lost)), np.nan) for name in METRICS}
    for n, name in enumerate(study.observers):
        kept = {entry: summary.tallies[f"{name}/{entry}"] for entry in (*OBSERVER, *REGRESSOR)
                if f"{name}/{entry}" in summary.tallies}
        lost = kept["lost"]
        well = lost < 0
        end = np.where(well, last, np.clip(lost, first, last))
        records = np.ceil(end / every) - math.ceil(first / every)
        final = (math.ceil(last / every) - 1) * every
        settling = np.where(well & (kept["outside"] < final), (np.maximum(kept["outside"] + every, first) - first) * T, np.nan)
        with np.errstate(all="ignore"):
            found = {
                "holds": (settling <= (last - first) * T - study.sweep.hold).astype(float),
                "diverged_at": np.where(well, np.nan, lost * T),
                "settling_time": settling,
                "speed_rms": np.sqrt(kept["speed_square"] / records),
                "speed_peak": np.where(records > 0, kept["speed_peak"], np.nan),
                "flux_rms": np.sqrt(kept["flux_square"] / records),
                "flux_peak": np.where(records > 0, np.sqrt(kept["flux_peak"]), np.nan),
                "omega_error_end": np.where(well, summary.ends["omega"] - summary.ends[f"{name}/omega_hat"], np.nan),
            }
            if f"{name}/alpha_hat" in summary.ends:
                found["alpha_hat_end"] = np.where(well, summary.ends[f"{name}/alpha_hat"], np.nan)
            if "v_22" in kept:
                found["excitation"] = _level(kept, records)
        for key, value in found.items():
            results[key][n] = value
    return results


def _level(kept: dict[str, Array], records: Array) -> Array:
    """Smallest eigenvalue of the scaled mean Gram matrix."""
    scale = np.sqrt(kept["v_22"] / records)
    gram = np.zeros((len(records), 4, 4))
    gram[:, 0, 0] = gram[:, 1, 1] = 1.0
    for column, v in ((2, "v_1"), (3, "v_2")):
        for row, axis in enumerate("dq"):
            gram[:, row, column] = gram[:, column, row] = kept[f"{v}{axis}"] / records / scale
    gram[:, 2, 2] = kept["v_11"] / records / scale**2
    gram[:, 2, 3] = gram[:, 3, 2] = kept["v_12"] / records / scale**2
    gram[:, 3, 3] = 1.0
    defined = np.asarray(np.isfinite(gram).all(axis=(1, 2)))
    return np.where(defined, np.maximum(np.linalg.eigvalsh(np.where(defined[:, None, None], gram, 0.0))[:, 0], 0.0), np.nan)


def summed(study: Study, run: Labelled, window: tuple[int, int]) -> Summary:
    """The summary that a batch of one would give, from a whole run: the slow way, for what `lanes` does not know.

    The end of the run is its last record here, not the state after its last sample.
    """
    every, band = study.simulation.record_every, study.sweep.band
    number = np.arange(len(run["omega"])) * every
    machine_lost = float(number[-1] + every) if number[-1] + every < study.simulation.samples else -1.0
    tallies: dict[str, Array] = {}
    for n, name in enumerate(study.observers):
        unknown = np.flatnonzero(np.isnan(run["omega_hat"][n]))
        gone = float(number[unknown[0]]) if unknown.size else machine_lost
        inside = (number >= window[0]) & (number < window[1])
        well = inside & ((number < gone) | (gone < 0))
        speed = np.abs(run["omega"] - run["omega_hat"][n])
        flux = (run["phi_dr"] - run["phi_dr_hat"][n]) ** 2 + (run["phi_qr"] - run["phi_qr_hat"][n]) ** 2
        outside = number[inside & ~(speed <= band)]
        found = {"lost": gone, "speed_square": np.sum(speed[well] ** 2), "speed_peak": np.max(speed[well], initial=0.0),
                 "speed_sum": np.sum((run["omega"] - run["omega_hat"][n])[well]),
                 "flux_square": np.sum(flux[well]), "flux_peak": np.max(flux[well], initial=0.0),
                 "outside": float(outside[-1]) if outside.size else -1.0}
        if "xi_1_hat" in OBSERVERS[study.observers[name].kind].states:
            believed = study.observer_machine(name)
            i = (run["i_ds_meas"], run["i_qs_meas"])
            hat = {key: (run[f"{key}{a}_hat"][n], run[f"{key}{b}_hat"][n])
                   for key, a, b in (("i_", "ds", "qs"), ("z_", "1", "2"), ("xi_", "1", "2"))}
            one = [v[well] for v in alpha_direction(i, hat["xi_"], believed.beta, believed.L_m)]
            two = [v[well] for v in speed_direction(hat["i_"], hat["z_"])]
            found |= {"v_1d": one[0].sum(), "v_1q": one[1].sum(), "v_2d": two[0].sum(), "v_2q": two[1].sum(),
                      "v_11": (one[0] ** 2 + one[1] ** 2).sum(), "v_12": (one[0] * two[0] + one[1] * two[1]).sum(),
                      "v_22": (two[0] ** 2 + two[1] ** 2).sum()}
        tallies |= {f"{name}/{key}": np.array([float(value)]) for key, value in found.items()}
    ends = {name: run[name][-1:] for name in PLANT_STATES}
    for n, name in enumerate(study.observers):
        ends |= {f"{name}/{state}": run[state][n, -1:] for state in OBSERVERS[study.observers[name].kind].states}
    return Summary(list(study.observers), window, np.array([machine_lost]), tallies, ends)
