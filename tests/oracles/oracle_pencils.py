"""Second routes to the error dynamics: exact dual numbers, and the characteristic polynomials derived by hand.

Nothing here uses sympy or `imo_analysis.pencils`. The dual numbers run the plain definitions with rational numbers; the
polynomials were worked out on paper in the complex shorthand x = x_d + j x_q.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np


class Dual:
    """value + slope * epsilon with epsilon^2 = 0, over rational numbers."""

    def __init__(self, value: Any, slope: Any = 0) -> None:
        self.value, self.slope = value, slope

    @staticmethod
    def of(x: Any) -> Dual:
        return x if isinstance(x, Dual) else Dual(x)

    def __add__(self, other: Any) -> Dual:
        other = Dual.of(other)
        return Dual(self.value + other.value, self.slope + other.slope)

    __radd__ = __add__

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.slope)

    def __sub__(self, other: Any) -> Dual:
        return self + -Dual.of(other)

    def __rsub__(self, other: Any) -> Dual:
        return -self + other

    def __mul__(self, other: Any) -> Dual:
        other = Dual.of(other)
        return Dual(self.value * other.value, self.value * other.slope + self.slope * other.value)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        other = Dual.of(other)
        slope = (self.slope * other.value - self.value * other.slope) / (other.value * other.value)
        return Dual(self.value / other.value, slope)

    def __rtruediv__(self, other: Any) -> Dual:
        return Dual.of(other) / self

    def __pow__(self, power: int) -> Dual:
        return self if power == 1 else self ** (power - 1) * self

    def __abs__(self) -> Dual:
        if self.value == 0:
            return Dual(Fraction(0))  # only met where the other factor of the product is zero too
        return self if self.value > 0 else -self


def columns(function: Any, at: list[Fraction]) -> list[list[Fraction]]:
    """Jacobian of ``function(list) -> sequence`` at rational numbers, row by row, exactly."""
    slopes = []
    for k in range(len(at)):
        seeded = [Dual(value, Fraction(int(n == k))) for n, value in enumerate(at)]
        slopes.append([Dual.of(row).slope for row in function(seeded)])
    return [list(row) for row in zip(*slopes, strict=True)]


def frozen_poles(name: str, p: dict[str, float], gains: dict[str, float], omega: float) -> np.ndarray:
    """Poles at frozen speed from polynomials derived by hand, conjugates included, zeros included."""
    R_s, L_m, sigma, beta, alpha = (p[key] for key in ("R_s", "L_m", "sigma", "beta", "alpha"))
    rho = R_s / sigma
    if name in ("baseline", "baseline_resistance", "baseline_turned"):  # R_s_shift is held
        total = rho + alpha * beta * L_m + gains["l_1"] + 1j * gains["l_2"] + alpha - 1j * omega
        product = (alpha - 1j * omega) * (
            rho + gains["l_1"] + 1j * gains["l_2"] + beta * (gains["l_3"] + 1j * gains["l_4"]))
        roots = np.roots([1.0, total, product])
        return np.concatenate([roots, roots.conj()])
    if name == "baseline_scheduled":
        machine = np.roots([1.0, rho + alpha * beta * L_m + alpha - 1j * omega, rho * (alpha - 1j * omega)])
        return gains["k"] * np.concatenate([machine, machine.conj()])
    a = rho + gains["k_1"]
    four = name.startswith("luenberger_")
    kind = name.removeprefix("luenberger_")
    if kind == "printed_7":
        # det((s^2 + a s + d_0) I - omega J s + S) with S symmetric, without trace, of determinant -e^2
        w = gains["k_2"] * omega
        if four:
            # rows: s^2 + a s - alpha w, -(omega s + omega w); omega s - omega w, s^2 + a s + alpha w, worked out
            return np.roots([1.0, 2 * a, a * a + omega**2, 0.0, -(w**2) * (alpha**2 + omega**2)])
        d = alpha * gains["k_3"]
        quartic = np.polyadd(np.polymul([1.0, a, d], [1.0, a, d]), [omega**2, 0.0, -(omega * w) ** 2])
        return np.concatenate([np.roots(quartic), [0.0, 0.0]])
    sign = {"printed_L": -1.0, "consistent_12": 1.0, "repaired": 1.0, "quiet": 1.0, "across": 1.0,
                "supervised": 1.0}[kind]
    w = gains["kappa"] * (1.0 if omega >= 0 else -1.0) if "kappa" in gains else gains["k_2"] * omega
    if kind in ("quiet", "across", "supervised"):
        a += alpha * (1 + beta * L_m)
    if four:
        roots = np.roots([1.0, a - 1j * omega, 1j * sign * w * (alpha - 1j * omega)])
        return np.concatenate([roots, roots.conj()])
    roots = np.roots([1.0, a - 1j * omega, alpha * gains["k_3"] + sign * w * omega])
    return np.concatenate([roots, roots.conj(), [0.0, 0.0]])
