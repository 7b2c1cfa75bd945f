"""The regressors of the conditions, and the units in which errors are counted so that eigenvalues mean something."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imo_analysis.equations import excitation as equations
from imo_analysis.errors import InputError
from imo_analysis.excitation.signals import Block, Signals

Array = NDArray[np.float64]
BLOCK_SAMPLES = 1 << 16
_STILL = 1e-12  # of a signal's size: what counts as no movement


@dataclass(frozen=True)
class Condition:
    """A regressor and the names of the errors that its columns belong to."""

    name: str
    title: str
    rows: Callable[..., Any]
    states: tuple[str, ...]

    def of(self, block: Block, machine: Any) -> Any:
        """The rows of the regressor for a block of signals."""
        beta, L_m = machine.beta, machine.L_m
        with np.errstate(invalid="ignore"):  # infinity in a log
            return self.rows(block.i, block.i_hat, block.z_hat, block.xi_hat, block.alpha, block.omega, beta, L_m)


_SIX = ("xi_1_hat", "xi_2_hat", "z_1_hat", "z_2_hat", "alpha_hat", "omega_hat")
CONDITIONS = {
    c.name: c
    for c in (
        Condition("printed_19", "(19) as printed", equations.printed_19, _SIX),
        Condition("corrected_19", "(19) with the sign of (12)", equations.corrected_19, _SIX),
        Condition("reduced", "reduced condition on [I, v_1, v_2]", equations.reduced, ("w_1", "w_2", "alpha_hat", "omega_hat")),
    )
}


@dataclass(frozen=True)
class Scale:
    """Units in which errors are counted: ``current`` (A) for xi and z, ``rate`` (1/s) for alpha and omega, their product for w.

    The default comes from the signals: ``current`` is the rms of v_2 = -j (z_hat - i_hat), the flux seen as a current, and
    ``rate`` the rms of |alpha - j omega|. alpha and omega share a unit on purpose: scaling each column to unit size would
    hide exactly the losses that are looked for.
    """

    current: float
    rate: float

    def of(self, condition: Condition) -> Array:
        """The factor of each column, so that B diag(factor) has entries without unit near 1."""
        if condition.name == "reduced":
            return np.array([1.0, 1.0, 1 / self.current, 1 / self.current])
        return np.array([1 / self.rate] * 4 + [1 / self.current] * 2)

    def describe(self) -> str:
        """In a line."""
        return f"xi, z in units of {self.current:.4g} A; alpha, omega in units of {self.rate:.4g} 1/s"


NO_SCALE = Scale(1.0, 1.0)


@dataclass(frozen=True)
class Survey:
    """What one pass over a run's signals finds.

    Attributes
    ----------
    current, rate : float
        rms of v_2 in A, and of |alpha - j omega| in 1/s.
    alpha_direction : float
        rms of v_1 in A.
    still : bool
        Whether currents and estimates stand still throughout.
    nan, infinite : bool
        Whether there are such values.
    """

    current: float
    rate: float
    alpha_direction: float
    still: bool
    nan: bool
    infinite: bool

    @property
    def scale(self) -> Scale:
        """The default `Scale`; a magnitude that is zero counts as 1."""
        return Scale(self.current or 1.0, self.rate or 1.0)


def survey(signals: Signals) -> Survey:
    """One pass over a run.

    Raises
    ------
    InputError
        If there is nothing finite, or values are too large to square.
    """
    squares, used = np.zeros(3), 0
    low, high = np.full(8, math.inf), np.full(8, -math.inf)
    nan = infinite = False
    for block in signals.blocks(BLOCK_SAMPLES):
        alpha, omega = (np.broadcast_to(np.asarray(one, float), block.omega.shape) for one in (block.alpha, block.omega))
        moving = np.array([*block.i, *block.i_hat, *block.z_hat, *block.xi_hat])
        with np.errstate(over="ignore", invalid="ignore"):
            v_1 = equations.alpha_direction(block.i, block.xi_hat, signals.machine.beta, signals.machine.L_m)
            v_2 = equations.speed_direction(block.i_hat, block.z_hat)
            each = np.array([a * a + b * b for a, b in (v_2, (alpha, omega), v_1)])
        whole = np.vstack([moving, alpha, omega])
        nan = nan or bool(np.isnan(whole).any())
        infinite = infinite or bool(np.isinf(whole).any())
        good = np.isfinite(whole).all(axis=0)
        if good.any():
            squares += each[:, good].sum(axis=1)
            low, high = np.minimum(low, moving[:, good].min(axis=1)), np.maximum(high, moving[:, good].max(axis=1))
        used += int(good.sum())
    if not used:
        raise InputError(f"the signals of {signals.observer!r} hold no sample without NaN or infinity; nothing can be said")
    if not np.isfinite(squares).all():
        raise InputError(f"the signals of {signals.observer!r} are too large to square; the observer has diverged")
    current, rate, other = np.sqrt(squares / used)
    still = bool((high - low <= _STILL * np.maximum(np.abs(high), np.abs(low))).all())
    return Survey(float(current), float(rate), float(other), still, nan, infinite)
