"""Gains for a wanted decay and damping at every speed of a range: the tuning that the paper leaves as future work.

At frozen speed the adaptive observer with the z feedback of (12), and the repaired one, have besides two poles at zero the
roots of ``s^2 + (a - j omega) s + D`` and their conjugates, with ``a = R_s/sigma + k_1`` and D real: ``alpha k_3 + k_2
omega^2``, or ``alpha k_3 + kappa abs(omega)``. Shifting s by the decay delta, Routh's criterion for complex coefficients says
that all of them decay faster than delta exactly when ``b = a - 2 delta > 0`` and

    D > delta (delta + b) (1 + omega^2 / b^2).

With equality at every speed, which k_2 allows, the roots are ``-delta (1 + j omega / b)`` and ``-(delta + b) (1 - j omega /
b)``: the decay is delta at every speed and in both directions, and both have the damping ``1 / sqrt(1 + omega^2 / b^2)``. So

    b = omega_max damping / sqrt(1 - damping^2)
    k_1 = 2 delta + b - R_s/sigma,    k_3 = delta (delta + b) / alpha,    k_2 = delta (delta + b) / b^2

is the rule, and it needs no search. kappa abs(omega) can only lie above the parabola over a range (the chord does), and then
the damping decides b. The baseline (2)-(3) with l_2 = l_4 = 0, the constant gains that treat both directions alike, has
``D = (alpha - j omega) X`` with a = gamma + l_1 + alpha and X = R_s/sigma + l_1 + beta l_3; the criterion then is linear in
omega^2, so that the ends of the range decide. From standstill to an unbounded speed it asks ``alpha X > delta (delta + b)``
and ``X < delta + b``, which no decay above alpha meets. There b and X are searched for.

The rule is about the frozen-speed poles; the two poles at zero stay whatever the gains are. Gains of the adaptation, and gains
from wished times of the whole observer, are `imo_analysis.tuning`'s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np

from imo_analysis.equations.own import shown
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.pencils.error import OperatingPoint, frozen_matrix, poles
from imo_analysis.pencils.sweep import evaluator

TUNABLE = ("baseline", "consistent_12", "repaired")
_FASTEST = 1e6  # 1/s: a wish that needs faster poles than this is refused


@dataclass(frozen=True)
class Tuning:
    """Gains and what they give.

    Attributes
    ----------
    observer : str
        Its name in the catalogue.
    gains : dict of str to float
        The gains that the frozen-speed poles depend on; the adaptation's are not among them.
    decay : float
        Slowest decay over the range in 1/s, computed from the observer's own pencil.
    damping : float
        Least damping ratio over the range.
    fastest : float
        Largest magnitude of a pole over the range in rad/s: what the sampling rate and the noise have to bear.
    """

    observer: str
    gains: dict[str, float]
    decay: float
    damping: float
    fastest: float


def tune(
    machine: InductionMachine, observer: str, decay: float, damping: float, omega_max: float, omega_min: float = 0.0
) -> Tuning:
    """The smallest gains with which all frozen-speed poles have the decay and the damping over a range of speeds.

    Parameters
    ----------
    machine : InductionMachine
        As the observer believes it to be.
    observer : str
        ``consistent_12``, ``repaired`` or ``baseline``.
    decay : float
        Wanted decay in 1/s: settling to 2 % takes about 4 / decay.
    damping : float
        Wanted damping ratio, above 0 and below 1.
    omega_max, omega_min : float
        The range of abs(omega) in rad/s; both directions of rotation.

    Returns
    -------
    Tuning
        With decay and damping checked on the observer's own pencil, not taken from the rule.

    Raises
    ------
    InputError
        If the wish is not one (signs, NaN), or no gains of this kind meet it.
    """
    if observer not in TUNABLE:
        raise InputError(f"observer = {shown(observer)!r} has no tuning rule; choose one of: {', '.join(TUNABLE)}")
    if not (isfinite(decay) and decay > 0):
        raise InputError(f"decay = {decay} must be above 0 /s")
    if not 0 < damping < 1:
        raise InputError(f"damping = {damping} must lie between 0 and 1")
    if not (isfinite(omega_max) and 0 <= omega_min < omega_max):
        raise InputError(f"the range of speeds {omega_min} .. {omega_max} rad/s must be 0 <= omega_min < omega_max")
    rho = machine.R_s / machine.sigma
    least = max(omega_max * damping / sqrt(1 - damping * damping), rho - 2 * decay)  # k_1 is not made negative
    if observer == "baseline":
        least = 0.05 * decay  # there a larger b can also cost damping
    choose: dict[str, Callable[[float], dict[str, float] | None]] = {
        "consistent_12": lambda b: _adaptive(machine, decay, b),
        "repaired": lambda b: _repaired(machine, decay, b, omega_min, omega_max),
        "baseline": lambda b: _baseline(machine, decay, b, omega_min, omega_max),
    }

    def meets(b: float) -> Tuning | None:
        gains = choose[observer](b)
        if gains is None:
            return None
        found = achieved(machine, observer, gains, omega_min, omega_max)
        return found if found.decay >= decay * (1 - 1e-9) and found.damping >= damping * (1 - 1e-9) else None

    low = high = least
    best = meets(high)
    while best is None or 2 * decay + high > _FASTEST:
        low, high = high, 1.3 * high
        if 2 * decay + high > _FASTEST:
            raise InputError(
                f"no constant gains of {observer} were found for decay {decay:g} /s and damping {damping:g} over {omega_min:g} "
                f".. {omega_max:g} rad/s; ask for less of either"
            )
        best = meets(high)
    for _ in range(40 if high > least else 0):
        middle = 0.5 * (low + high)
        found = meets(middle)
        if found is None:
            low = middle
        else:
            high, best = middle, found
    return best


def achieved(
    machine: InductionMachine, observer: str, gains: dict[str, float], omega_min: float, omega_max: float, points: int = 401
) -> Tuning:
    """Decay, damping and fastest pole over a range of speeds in both directions, from the observer's own pencil.

    Parameters
    ----------
    machine : InductionMachine
        The machine that the observer believes in.
    observer : str
        Observer, by its name in the catalogue.
    gains : mapping of str to float
        Gains by name, in SI units.
    omega_min, omega_max : float
        Range of the speed's magnitude in rad/s.
    points : int
        How many speeds.
    """
    speeds = np.linspace(omega_min, omega_max, points)
    both = np.concatenate([-speeds[::-1], speeds])
    found = evaluator(machine, observer, gains, "omega", OperatingPoint(0.0, None), "frozen").moving(both)
    size = np.abs(found)
    ratio = np.divide(-found.real, size, out=np.zeros_like(size), where=size > 0)
    return Tuning(observer, gains, float(-found.real.max()), float(ratio.min()), float(size.max()))


def _adaptive(machine: InductionMachine, decay: float, b: float) -> dict[str, float]:
    """The rule, exact at every speed."""
    strength = decay * (decay + b)
    return {"k_1": 2 * decay + b - machine.R_s / machine.sigma, "k_2": strength / (b * b), "k_3": strength / machine.alpha}


def _repaired(machine: InductionMachine, decay: float, b: float, low: float, high: float) -> dict[str, float]:
    """The chord over the range of the parabola that the rule asks for."""
    strength = decay * (decay + b)
    constant = max(strength * (1 - low * high / (b * b)), 0.0)
    kappa = (strength * (1 + high * high / (b * b)) - constant) / high
    return {"k_1": 2 * decay + b - machine.R_s / machine.sigma, "kappa": kappa, "k_3": constant / machine.alpha}


def _baseline(machine: InductionMachine, decay: float, b: float, low: float, high: float) -> dict[str, float] | None:
    """Of the X that meet Routh's criterion at both ends of the range the one with most damping; None where there is none."""
    alpha = machine.alpha
    # D_re > delta (delta + b) at the lower end bounds X from below; (X - delta)^2 < b^2 alpha X / high^2 + b X from above
    X = np.geomspace(1e-3 * decay, 10 * (decay + b) * (1 + decay / alpha), 240)
    meets = np.ones_like(X, dtype=bool)
    for w in (low, high):
        meets &= b * b * (alpha * X - decay * (decay + b)) + b * w * w * (X - decay) - w * w * (X - decay) ** 2 >= 0
    X = X[meets]
    if len(X) == 0:
        return None
    l_1 = 2 * decay + b - machine.gamma - alpha
    l_3 = (X - machine.R_s / machine.sigma - l_1) / machine.beta
    speeds = np.linspace(low, high, 25)
    found = poles(frozen_matrix(machine, "baseline", {"l_1": l_1, "l_2": 0.0, "l_4": 0.0}, speeds, {"l_3": l_3[:, None]}))
    best = int(np.argmax((-found.real / np.abs(found)).min(axis=(1, 2))))
    return {"l_1": l_1, "l_2": 0.0, "l_3": float(l_3[best]), "l_4": 0.0}
