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


@dataclass(frozen=True)
class Condition:
    """A regressor and the names of the errors that its columns belong to."""

    name: str
    title: str
    rows: Callable[..., Any]
    states: tuple[str, ...]

    def of(self, block: Block, machine: Any) -> Any:
        """The rows of the regressor for a block of signals."""
        return self.rows(block.i, block.i_hat, block.z_hat, block.xi_hat, block.alpha, block.omega, machine.beta, machine.L_m)


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


def natural_scale(signals: Signals) -> Scale:
    """The default `Scale` of a run, from one pass over it; a magnitude that is zero counts as 1."""
    current = rate = 0.0
    used = 0
    for block in signals.blocks(BLOCK_SAMPLES):
        v_2 = equations.speed_direction(block.i_hat, block.z_hat)
        square = v_2[0] * v_2[0] + v_2[1] * v_2[1]
        other = np.broadcast_to(np.asarray(block.alpha * block.alpha + block.omega * block.omega), square.shape)
        good = np.isfinite(square) & np.isfinite(other)
        current += float(square[good].sum())
        rate += float(other[good].sum())
        used += int(good.sum())
    if not used:
        raise InputError(f"the signals of {signals.observer!r} hold no sample without NaN; nothing can be said")
    if not (math.isfinite(current) and math.isfinite(rate)):
        raise InputError(f"the signals of {signals.observer!r} are too large to square; the observer has diverged")
    return Scale(math.sqrt(current / used) or 1.0, math.sqrt(rate / used) or 1.0)
