"""How well the observers did over a record, added up while it passes by, in memory that does not grow with it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from imo_analysis.replay.estimate import Estimates, Runner
from imo_analysis.replay.survey import Survey

_BINS = 1000
SETTLED = 0.02  # share of the largest speed within which the error counts as settled, ...
STAYED = 0.1  # ... if it stays there to the end for this part of the record or more: an oscillation passes through zero too


class Tally:
    """Sums of errors in a thousand stretches of the record.

    Parameters
    ----------
    survey : Survey
        Of the record.
    observers : sequence of Runner
        As they run.
    """

    def __init__(self, survey: Survey, observers: Sequence[Runner]) -> None:
        self.survey = survey
        self.observers = observers
        self.bins = min(_BINS, survey.rows)
        self.samples = np.zeros(self.bins)
        # per observer and stretch: sum and sum of squares of the speed error, its largest size, and of the current error
        self.sums = np.zeros((5, len(observers), self.bins))
        self.last = np.full((3, len(observers)), np.nan)

    def add(self, block: Estimates) -> None:
        """Take the next block."""
        values = block.values
        place = (block.first + np.arange(len(values["time"]))) * self.bins // self.survey.rows
        self.samples += np.bincount(place, minlength=self.bins)
        starts = np.flatnonzero(np.diff(place, prepend=-1))
        current = values["i_ds_meas"] ** 2 + values["i_qs_meas"] ** 2
        for n in range(len(self.observers)):
            miss = (values["i_ds_meas"] - values["i_ds_hat"][n]) ** 2 + (values["i_qs_meas"] - values["i_qs_hat"][n]) ** 2
            self.sums[3, n] += np.bincount(place, miss, self.bins)
            self.sums[4, n] += np.bincount(place, current, self.bins)
            if "omega" in values:
                error = values["omega_hat"][n] - values["omega"]
                self.sums[0, n] += np.bincount(place, error, self.bins)
                self.sums[1, n] += np.bincount(place, error * error, self.bins)
                self.sums[2, n, place[starts]] = np.maximum(
                    self.sums[2, n, place[starts]], np.maximum.reduceat(np.abs(error), starts)
                )
        self.last[0], self.last[1] = values["omega_hat"][:, -1], values["alpha_hat"][:, -1]
        self.last[2] = np.hypot(values["phi_dr_hat"][:, -1], values["phi_qr_hat"][:, -1])

    def results(self, after: float | None = None) -> dict[str, dict[str, Any]]:
        """What came out, by observer.

        Parameters
        ----------
        after : float, optional
            Errors count from this time on, in s from the start of the record; from where they settled if not
            given, and over the second half if they did not.

        Returns
        -------
        dict
            By observer: ``lost_at`` (s or None), ``settled_at`` (s from the start, None where it did not stay, by `SETTLED` and
            `STAYED`, or no speed is known),
            ``counted_from`` (s), ``speed_error_rms``, ``_std``, ``_mean``, ``_peak``, and ``_smoothed``: the deviation of means
            over a thousandth of the record (rad/s, None without a speed),
            ``current_error_share`` (RMS over RMS), and the last ``omega_hat``, ``alpha_hat``, ``flux_hat``.
        """
        T = self.survey.sample_time
        edge = self.survey.time_of(np.ceil(np.arange(self.bins + 1) * self.survey.rows / self.bins).astype(np.int64))
        found = {}
        for n, runner in enumerate(self.observers):
            total, squares, peak, miss, current = self.sums[:, n]
            speed = not math.isnan(self.survey.peak_speed)
            outside = np.flatnonzero(~(peak <= SETTLED * self.survey.peak_speed)) if speed else np.array([], dtype=int)
            first = int(outside[-1]) + 1 if len(outside) else 0
            settled = speed and runner.lost < 0 and self.bins - first >= STAYED * self.bins
            begin = first if settled else self.bins // 2
            if after is not None:
                begin = int(np.searchsorted(edge, after - 0.5 * T))
            counted = slice(begin, None)
            count = float(self.samples[counted].sum())
            errors = dict.fromkeys(("rms", "std", "mean", "peak", "smoothed"))
            if speed and runner.lost < 0 and count:
                mean, square = total[counted].sum() / count, squares[counted].sum() / count
                errors = {"rms": math.sqrt(square), "std": math.sqrt(max(square - mean * mean, 0.0)), "mean": mean,
                          "peak": float(peak[counted].max()),
                          "smoothed": float((total[counted] / self.samples[counted]).std())}
            whole = float(current[counted].sum())
            found[runner.name] = {
                "lost_at": self.survey.start + float(self.survey.time_of(runner.lost)) if runner.lost >= 0 else None,
                "settled_at": float(edge[first]) if settled else None,
                "counted_from": float(edge[begin]) if begin < self.bins else None,
                **{f"speed_error_{key}": value for key, value in errors.items()},
                "current_error_share": math.sqrt(float(miss[counted].sum()) / whole) if whole and runner.lost < 0 else None,
                "omega_hat": float(self.last[0, n]), "alpha_hat": float(self.last[1, n]), "flux_hat": float(self.last[2, n]),
                "gains": runner.gains, "substeps": runner.substeps,
            }
        return found
