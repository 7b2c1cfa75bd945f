"""Every definition of ``equations/`` a second time, in complex numbers x = x_d + j x_q: the oracle that d/q forms must meet.

Written from vector equations, not from the d/q rows. Arithmetic is exact (fractions), but for means over a period, which are
sums of floats. Used to kill mutants of the definitions and in the tests; nothing else is computed from it. A new definition
needs a `Form` here: `definition_mutants` reports one that has none.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from random import Random
from typing import Any

from imo_analysis.ledger.form import Form
from imo_analysis.ledger.gauss import Gauss, J, cross, dot

# ------------------------------------------------------------------------------------------- parameters, machine


def _plant(x: Any, u: Any, omega_1: Any, T_l: Any, p: Any) -> Any:
    R_s, L_m, sigma, beta, alpha, mu, n_p, inertia = p
    i, phi, omega = Gauss(*x[:2]), Gauss(*x[2:4]), x[4]
    rotor = Gauss(alpha, -omega)
    return (
        i * -(R_s / sigma + alpha * beta * L_m) - J * omega_1 * i + rotor * phi * beta + Gauss(*u) / sigma,
        -(rotor * phi) - J * omega_1 * phi + i * (alpha * L_m),
        mu * cross(phi, i) - n_p / inertia * T_l,
    )


def _plant_z(x: Any, u: Any, omega: Any, omega_1: Any, p: Any) -> Any:
    R_s, L_m, sigma, beta, alpha = p[:5]
    i, z = Gauss(*x[:2]), Gauss(*x[2:])
    stator = (Gauss(*u) - i * R_s) / sigma
    flux = z - i  # beta phi
    return (stator - i * (alpha * beta * L_m) + Gauss(alpha, -omega) * flux - J * omega_1 * i, stator - J * omega_1 * z)


# ------------------------------------------------------------------------------------------- observers


def _full(x: Any, i: Any, u: Any, p: Any, gains: Any, feedback: Gauss, sign: Any) -> Any:
    R_s, L_m, sigma, beta, _ = p
    k_1, _, k_3, g, K_p, alpha_l, delta = gains
    i_hat, z_hat, xi_hat, alpha_hat, omega_hat = Gauss(*x[:2]), Gauss(*x[2:4]), Gauss(*x[4:6]), x[6], x[7]
    current, voltage = Gauss(*i), Gauss(*u)
    error = current - i_hat
    stator = (voltage - current * R_s) / sigma
    direction = xi_hat - current * (1 + beta * L_m)
    return (
        (voltage - i_hat * R_s) / sigma + direction * alpha_hat + J * omega_hat * (i_hat - z_hat) + error * k_1,
        stator + feedback, stator + error * k_3,
        _projection(g * dot(error, direction), alpha_hat, alpha_l, delta),
        K_p * sign * cross(i_hat - z_hat, error),
    )


def _z_feedback(which: str, error: Gauss, k: Any, w: Any) -> Gauss:
    factor = {"printed_7": -k * w, "printed_L": -k * w, "consistent_12": k * w}[which]
    return error.conjugate() * factor if which == "printed_7" else J * error * factor


def _feedback(which: str) -> Callable[..., Any]:
    def form(a: Any, b: Any, k: Any, w: Any) -> Gauss:
        return _z_feedback(which, Gauss(a, b), k, w)

    return form


def _adaptive(which: str) -> Callable[..., Any]:
    def form(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
        error = Gauss(*i) - Gauss(*x[:2])
        return _full(x, i, u, p, gains, _z_feedback(which, error, gains[1], x[7]), direction)

    return form


def _repaired(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
    return _full(x, i, u, p, gains, J * (Gauss(*i) - Gauss(*x[:2])) * (gains[1] * direction), 1)


def _quiet(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
    R_s, L_m, sigma, beta, _ = p
    k_1, kappa, k_3, g, K_p, alpha_l, delta = gains
    i_hat, z_hat, current = Gauss(*x[:2]), Gauss(*x[2:4]), Gauss(*i)
    error, regressor = current - i_hat, Gauss(*x[4:6]) - i_hat * (1 + beta * L_m)
    stator = (Gauss(*u) - current * R_s) / sigma
    return (
        (Gauss(*u) - i_hat * R_s) / sigma + regressor * x[6] + J * x[7] * (i_hat - z_hat) + error * k_1,
        stator + J * error * kappa * direction, stator + error * k_3,
        _projection(g * dot(error, regressor), x[6], alpha_l, delta),
        K_p * cross(i_hat - z_hat, error),
    )


def _share(v_1: Gauss, v_2: Gauss) -> Any:
    return dot(v_1, v_2) / (dot(v_2, v_2) + 1)


def _directions(x: Any, L_m: Any, beta: Any) -> tuple[Gauss, Gauss]:
    i_hat = Gauss(*x[:2])
    return Gauss(*x[4:6]) - i_hat * (1 + L_m * beta), J * (i_hat - Gauss(*x[2:4]))


def _gated(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any, opening: Any) -> Any:
    """The alpha law sees the part of v_1 that is orthogonal to v_2 (with a floor of 1 A^2); the speed takes over the rest."""
    current, z, xi, _, speed = _quiet(x, i, u, direction, p, gains)
    v_1, v_2 = _directions(x, p[1], p[3])
    across = v_1 - v_2 * _share(v_1, v_2)
    alpha_rate = opening * _projection(gains[3] * dot(Gauss(*i) - Gauss(*x[:2]), across), x[6], gains[5], gains[6])
    return current, z, xi, alpha_rate, speed - _share(v_1, v_2) * alpha_rate


def _across(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
    return _gated(x, i, u, direction, p, gains, 1)


def _gate(excited: Any, S_0: Any) -> Any:
    return 1 / (1 + (S_0 / excited) ** 4)


def _running_gram(v_1: Any, v_2: Any, means: Any, excited: Any, eta: Any) -> Any:
    """|d_1 - c d_2|^2 by Pythagoras."""
    d_1, d_2 = Gauss(*v_1) - Gauss(*means[:2]), Gauss(*v_2) - Gauss(*means[2:])
    c = _share(d_1, d_2)
    left = dot(d_1, d_1) - 2 * c * dot(d_1, d_2) + c * c * dot(d_2, d_2)
    return d_1 * eta, d_2 * eta, eta * (left - excited)


def _supervised(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
    v_1, v_2 = ((one.re, one.im) for one in _directions(x, p[1], p[3]))
    return (*_gated(x[:8], i, u, direction, p, gains[:7], _gate(x[12], gains[8])),
            _running_gram(v_1, v_2, x[8:12], x[12], gains[7]))


def _known_alpha(x: Any, i: Any, u: Any, p: Any, gains: Any, feedback: Gauss, sign: Any) -> Any:
    R_s, L_m, sigma, beta, alpha = p
    k_1, _, K_p = gains
    i_hat, z_hat, current = Gauss(*x[:2]), Gauss(*x[2:4]), Gauss(*i)
    error = current - i_hat
    return (
        (Gauss(*u) - i_hat * R_s) / sigma - current * (alpha * (1 + beta * L_m)) + Gauss(alpha, -x[4]) * z_hat
        + J * x[4] * i_hat + error * k_1,
        (Gauss(*u) - current * R_s) / sigma + feedback,
        K_p * sign * cross(i_hat - z_hat, error),
    )


def _luenberger(which: str) -> Callable[..., Any]:
    def form(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
        error = Gauss(*i) - Gauss(*x[:2])
        return _known_alpha(x, i, u, p, gains, _z_feedback(which, error, gains[1], x[4]), direction)

    return form


def _baseline(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
    R_s, L_m, sigma, beta, alpha = p
    i_hat, phi_hat = Gauss(*x[:2]), Gauss(*x[2:4])
    error = Gauss(*i) - i_hat
    rotor = Gauss(alpha, -x[4]) * phi_hat
    return (
        (Gauss(*u) - i_hat * (R_s + sigma * alpha * beta * L_m)) / sigma + rotor * beta + Gauss(gains[0], gains[1]) * error,
        i_hat * (alpha * L_m) - rotor + Gauss(gains[2], gains[3]) * error,
        gains[4] * beta * cross(error, phi_hat),
    )


def _k_times(k: Any, omega_hat: Any, p: Any) -> tuple[Gauss, Gauss]:
    """The gain that the sum and the product of the poles ask for: k times, and k^2 times, those of the machine's matrix."""
    R_s, L_m, sigma, beta, alpha = p
    rotor = Gauss(alpha, -omega_hat)
    current = R_s / sigma + alpha * beta * L_m
    own = rotor * current - rotor * (beta * alpha * L_m)  # the determinant of the machine's matrix
    l_i = (rotor + current) * (k - 1)
    return l_i, own * (k * k - 1) / (rotor * beta) - l_i / beta


def _baseline_scheduled(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
    l_i, l_phi = _k_times(gains[0], x[4], p)
    return _baseline(x, i, u, direction, p, (l_i.re, l_i.im, l_phi.re, l_phi.im, gains[1]))


def _resistance_rate(x: Any, i: Any, h_s: Any) -> Any:
    i_hat = Gauss(*x[:2])
    return h_s * (dot(i_hat, i_hat) - dot(Gauss(*i), i_hat))


def _baseline_resistance(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
    """The voltage across the added resistance is taken from the voltage that the baseline is told."""
    left = Gauss(*u) - Gauss(*x[:2]) * x[5]
    return (*_baseline(x, i, (left.re, left.im), direction, p, gains), _resistance_rate(x, i, gains[5]))


def _power_across(x: Any, p: Any) -> Any:
    """phi x i times phi x (rate of phi): |phi|^2 times the frequency with which the flux turns."""
    i_hat, phi_hat = Gauss(*x[:2]), Gauss(*x[2:4])
    return cross(phi_hat, i_hat) * cross(phi_hat, Gauss(-p[4], x[4]) * phi_hat + i_hat * (p[4] * p[1]))


def _baseline_turned(x: Any, i: Any, u: Any, direction: Any, p: Any, gains: Any) -> Any:
    *others, adaptation = _baseline_resistance(x, i, u, direction, p, gains[:6])
    power = _power_across(x, p)
    return (*others, adaptation * power / (gains[6] + max(power, -power)))


def _layer(alpha_hat: Any, alpha_l: Any, delta: Any) -> Any:
    return (alpha_l - alpha_hat) * (alpha_l + alpha_hat) / (delta * (2 * alpha_l - delta))


def _projection(rho: Any, alpha_hat: Any, alpha_l: Any, delta: Any) -> Any:
    p = _layer(alpha_hat, alpha_l, delta)
    return rho if p <= 0 or rho >= 0 else (1 - p) * rho


def _flux(i_d: Any, i_q: Any, z_1: Any, z_2: Any, xi_1: Any, xi_2: Any, alpha: Any, omega: Any, beta: Any) -> Gauss:
    w = Gauss(xi_1, xi_2) * alpha - J * omega * Gauss(z_1, z_2)
    return (w / Gauss(alpha, -omega) - Gauss(i_d, i_q)) / beta


# ------------------------------------------------------------------------------------------- Lyapunov, excitation


def _square(re: Any, im: Any) -> Any:
    return dot(Gauss(re, im), Gauss(re, im))


def _corrected_13(i_d: Any, i_q: Any, z_1: Any, z_2: Any, xi_1: Any, xi_2: Any, a: Any, w: Any, alpha: Any, omega: Any,
                  omega_hat: Any, k_2: Any, k_3: Any, g: Any, K_p: Any) -> Any:
    return (_square(i_d, i_q) + omega / omega_hat / k_2 * _square(z_1, z_2) + alpha / k_3 * _square(xi_1, xi_2)
            + a * a / g + w * w / K_p) / 2


def _with_direction(i_d: Any, i_q: Any, z_1: Any, z_2: Any, xi_1: Any, xi_2: Any, a: Any, w: Any, alpha: Any, omega: Any,
                    s: Any, kappa: Any, k_3: Any, g: Any, K_p: Any) -> Any:
    return (_square(i_d, i_q) + s * omega / kappa * _square(z_1, z_2) + alpha / k_3 * _square(xi_1, xi_2)
            + a * a / g + w * w / K_p) / 2


def _reduced_v(i_d: Any, i_q: Any, w_1: Any, w_2: Any, a: Any, w: Any, c: Any, g: Any, K_p: Any) -> Any:
    return (_square(i_d, i_q) + _square(w_1, w_2) / c + a * a / g + w * w / K_p) / 2


def _regressor(rows: Callable[..., list[Gauss]]) -> Callable[..., Any]:
    """The two real rows of a list of complex columns."""
    def form(i: Any, i_hat: Any, z_hat: Any, xi_hat: Any, alpha: Any, omega: Any, beta: Any, L_m: Any) -> Any:
        v_1 = Gauss(*xi_hat) - Gauss(*i) * (1 + beta * L_m)
        v_2 = -J * (Gauss(*z_hat) - Gauss(*i_hat))
        columns = rows(v_1, v_2, alpha, omega)
        return tuple(one.re for one in columns), tuple(one.im for one in columns)

    return form


def _six(v_1: Gauss, v_2: Gauss, alpha: Any, omega: Any) -> list[Gauss]:
    """alpha xi_tilde - j omega z_tilde + v_1 alpha_tilde + v_2 omega_tilde, column by column."""
    return [Gauss(alpha), J * alpha, -J * omega, -J * J * omega, v_1, v_2]


# ------------------------------------------------------------------------------------------- steady states


def _mean(of: Callable[[float], float], samples: int = 240) -> float:
    """Mean over a period; for these smooth periodic functions the plain average converges geometrically."""
    return sum(of(2 * math.pi * n / samples) for n in range(samples)) / samples


def _moment(a: Callable[[float], complex], b: Callable[[float], complex], angle: float) -> float:
    return (a(angle).conjugate() * b(angle)).real


def _gram(psi: Any, depth: Any, frequency: Any, slip: Callable[[float], float], alpha: Any, beta: Any) -> Any:
    def flux(angle: float) -> complex:
        return complex(psi) * (1 + depth * math.cos(angle))

    def v_1(angle: float) -> complex:
        rate = -float(psi * depth * frequency) * math.sin(angle)
        return -float(beta / alpha) * (rate + 1j * slip(angle) * flux(angle))

    def v_2(angle: float) -> complex:
        return -1j * float(beta) * flux(angle)

    return tuple(_mean(partial(_moment, a, b)) for a, b in ((v_1, v_1), (v_1, v_2), (v_2, v_2)))


def _gram_slip(psi: Any, depth: Any, frequency: Any, slip: Any, alpha: Any, beta: Any) -> Any:
    return _gram(psi, depth, frequency, lambda t: float(slip), alpha, beta)


def _gram_torque(psi: Any, depth: Any, root: Any, frequency: Any, slip: Any, alpha: Any, beta: Any) -> Any:
    return _gram(psi, depth, frequency, lambda t: float(slip) / (1 + float(depth) * math.cos(t)) ** 2, alpha, beta)


def _gram_arguments(random: Random) -> tuple[Any, ...]:
    depth, root = random.choice(((Fraction(3, 5), Fraction(4, 5)), (Fraction(5, 13), Fraction(12, 13))))
    psi, frequency, slip, alpha, beta = (Fraction(random.randint(2, 30), random.randint(2, 9)) for _ in range(5))
    return psi, depth, root, frequency, slip, alpha, beta


def _information(psi: Any, beta: Any, stator_frequency: Any, duration: Any, cosine: Any) -> float:
    """Schur complement of [[T, 0, a], [0, T, b], [a, b, c]] with v_2 turning at the stator frequency."""
    angle, size = float(stator_frequency * duration), float(beta * psi)
    a = size * math.sin(angle) / float(stator_frequency)
    b = size * (1 - math.cos(angle)) / float(stator_frequency)
    return size**2 * float(duration) - (a * a + b * b) / float(duration)


def _information_arguments(random: Random) -> tuple[Any, ...]:
    psi, beta, frequency, duration = (Fraction(random.randint(2, 30), random.randint(2, 9)) for _ in range(4))
    return psi, beta, frequency, duration, math.cos(frequency * duration)


def _answer(nu: Any, omega: Any, alpha: Any, damping: Any, beta: Any, L_m: Any) -> Any:
    """Determinant of the machine's matrix at j nu."""
    rotor = Gauss(alpha, -omega)
    return (J * nu + damping + alpha * beta * L_m) * (J * nu + rotor) - rotor * (alpha * beta * L_m)


def _forcing(nu: Any, omega: Any, alpha: Any, beta: Any, L_m: Any, sigma: Any) -> Any:
    """Cramer's numerators for a flux of 1: what each parameter forces in the current and in the flux row."""
    rotor = Gauss(alpha, -omega)
    current = (J * nu + rotor) / (alpha * L_m)

    def numerator(in_current: Any, in_flux: Any) -> Any:
        return (J * nu + rotor) * in_current + rotor * beta * in_flux

    by_alpha = current * L_m - 1
    return numerator(by_alpha * -beta, by_alpha), numerator(J * -beta, J), numerator(current * -1 / sigma, Gauss(0))


def _balance(alpha_hat: Any, omega_hat: Any, xi: Any, z: Any, slip: Any, alpha: Any, gains: Any) -> Any:
    g, K_p, k_3, kappa_s = gains
    ratio = slip / alpha
    return (alpha_hat / g - ratio * omega_hat / K_p) - (_square(*xi) / k_3 - ratio * _square(*z) / kappa_s) / 2


def _step(step: Any, bandwidth: Any, limit: Any) -> Any:
    """Full acceleration until the error is limit/bandwidth, then its decay, over u = exp(-bandwidth t) by trapezes."""
    ramp = limit**2 * (step / limit - 1 / bandwidth)
    trapezes = sum((Fraction(n, 8) + Fraction(n + 1, 8)) / 16 for n in range(8))
    return ramp + limit**2 / bandwidth * trapezes


def _forgetting(n: Any, strength: Any, decay: Any, memory: Any) -> Any:
    """A term of 1F2(1/2; 1/2 + r_1, 1/2 + r_2; -strength/4) over the one before, r_1 + r_2 = decay/2 and r_1 r_2 = memory/4."""
    half = n - Fraction(1, 2)
    return half / (half * half + half * decay / 2 + memory / 4) / n * -(strength / 4)


def _adjoint(n: Any, term: Any, w: Any, v_0: Any) -> Any:
    """From p_a backwards: p_i = p_a'/v_0 and p_w = p_i/(rate of p_w), rates of exp(w t) x^n being (2 n - 1) w downwards."""
    rate = -2 * n * w
    return rate / v_0 * term, rate / v_0 * term / (-rate - w), term


def _rest(alpha_hat: Any, z: Any, omega: Any, slip: Any, alpha: Any) -> Any:
    omega_hat = omega + slip * (1 - alpha_hat / alpha)
    return omega_hat, J * omega_hat * Gauss(*z) / alpha_hat


_OBSERVER = (8, 2, 2, 0, 5, 7)
_SEVEN = (5, 2, 2, 0, 5, 3)
_ROWS = (2, 2, 2, 2, 0, 0, 0, 0)
_CONVENTIONS = ("printed_7", "printed_L", "consistent_12")

FORMS: tuple[Form, ...] = (
    Form("parameters", "leakage", (0, 0, 0), lambda L_s, L_m, L_r: L_s - L_m**2 / L_r),
    Form("parameters", "rotor_rate", (0, 0), lambda R_r, L_r: 1 / (L_r / R_r)),
    Form("parameters", "coupling", (0, 0, 0), lambda L_m, sigma, L_r: L_m / L_r / sigma),
    Form("parameters", "current_decay", (0,) * 5,
         lambda R_s, L_m, sigma, alpha, beta: (R_s + sigma * alpha * beta * L_m) / sigma),
    Form("parameters", "torque_gain", (0,) * 4,
         lambda n_p, L_m, L_r, inertia: Fraction(3, 2) * n_p**2 * L_m / L_r / inertia),
    Form("plant", "plant", (5, 2, 0, 0, 8), _plant),
    Form("plant", "plant_z", (4, 2, 0, 0, 5), _plant_z),
    Form("plant", "torque", (4, 0, 0, 0),
         lambda x, n_p, L_m, L_r: Fraction(3, 2) * n_p * L_m / L_r * cross(Gauss(*x[2:]), Gauss(*x[:2]))),
    Form("transformation", "to_z", (0,) * 5, lambda a, b, c, d, beta: Gauss(a, b) + Gauss(c, d) * beta),
    Form("transformation", "from_z", (0,) * 5, lambda a, b, c, d, beta: (Gauss(c, d) - Gauss(a, b)) / beta),
    Form("transformation", "reconstructed_flux", (0,) * 9, _flux),
    Form("projection", "positive_part", (0,), lambda v: max(v, Fraction(0))),
    Form("projection", "layer", (0, 0, 0), _layer),
    Form("projection", "projection", (0,) * 4, _projection),
    *(Form("feedback", f"feedback_{which}", (0,) * 4, _feedback(which)) for which in _CONVENTIONS),
    Form("adaptive", "alpha_signal", (2, 2, 2, 0, 0),
         lambda e, i, xi, beta, L_m: dot(Gauss(*e), Gauss(*xi) - Gauss(*i) * (1 + beta * L_m))),
    Form("adaptive", "speed_signal", (2, 2, 2), lambda e, i_hat, z_hat: cross(Gauss(*i_hat) - Gauss(*z_hat), Gauss(*e))),
    Form("adaptive", "adaptive", (8, 2, 2, 5, 7, 2, 0), lambda x, i, u, p, k, f, s: _full(x, i, u, p, k, Gauss(*f), s)),
    *(Form("adaptive", which, _OBSERVER, _adaptive(which)) for which in _CONVENTIONS),
    Form("repaired", "repaired", _OBSERVER, _repaired),
    Form("quiet", "quiet", _OBSERVER, _quiet),
    Form("across", "directions", (6, 0, 0), _directions),
    Form("across", "share", (2, 2), lambda v_1, v_2: _share(Gauss(*v_1), Gauss(*v_2))),
    Form("across", "across", _OBSERVER, _across),
    Form("supervised", "gate", (0, 0), _gate),
    Form("supervised", "running_gram", (2, 2, 4, 0, 0), _running_gram),
    Form("supervised", "supervised", (13, 2, 2, 0, 5, 9), _supervised),
    Form("luenberger", "luenberger", (5, 2, 2, 5, 3, 2, 0),
         lambda x, i, u, p, k, f, s: _known_alpha(x, i, u, p, k, Gauss(*f), s)),
    *(Form("luenberger", f"luenberger_{which}", _SEVEN, _luenberger(which)) for which in _CONVENTIONS),
    Form("baseline", "baseline", (5, 2, 2, 0, 5, 5), _baseline),
    Form("scheduled", "proportional_gain", (0, 0, 5), _k_times),
    Form("scheduled", "baseline_scheduled", (5, 2, 2, 0, 5, 2), _baseline_scheduled),
    Form("resistance", "gain_of_rate", (0,) * 5,
         lambda rate, sigma, decay, L_m, flux: rate / ((flux / L_m) ** 2 / (sigma * decay))),
    Form("resistance", "resistance_rate", (5, 2, 0), _resistance_rate),
    Form("resistance", "baseline_resistance", (6, 2, 2, 0, 5, 6), _baseline_resistance),
    Form("resistance", "power_across", (5, 5), _power_across),
    Form("resistance", "power_of_slip", (0,) * 5, lambda w, slip, alpha, L_m, flux: flux**3 * w * (flux / L_m) * slip / alpha),
    Form("resistance", "baseline_turned", (6, 2, 2, 0, 5, 7), _baseline_turned),
    Form("lyapunov", "corrected_13", (0,) * 15, _corrected_13),
    Form("lyapunov", "with_direction", (0,) * 15, _with_direction),
    Form("lyapunov", "reduced", (0,) * 9, _reduced_v),
    Form("lyapunov", "observable", (0,) * 6,
         lambda z_1, z_2, x_1, x_2, alpha, omega: Gauss(x_1, x_2) * alpha - J * omega * Gauss(z_1, z_2)),
    Form("lyapunov", "conserved", (0,) * 7,
         lambda z_1, z_2, x_1, x_2, kappa, k_3, s: Gauss(z_1, z_2) * k_3 - J * kappa * s * Gauss(x_1, x_2)),
    Form("excitation", "alpha_direction", (2, 2, 0, 0),
         lambda i, xi, beta, L_m: Gauss(*xi) - Gauss(*i) * (1 + beta * L_m)),
    Form("excitation", "speed_direction", (2, 2), lambda i_hat, z_hat: -J * (Gauss(*z_hat) - Gauss(*i_hat))),
    Form("excitation", "corrected_19", _ROWS, _regressor(_six)),
    Form("excitation", "printed_19", _ROWS,
         _regressor(lambda v_1, v_2, alpha, omega: [*_six(v_1, v_2, alpha, omega)[:5], v_2.conjugate()])),
    Form("excitation", "reduced", _ROWS, _regressor(lambda v_1, v_2, alpha, omega: [Gauss(1), J, v_1, v_2])),
    Form("drift", "balance", (0, 0, 2, 2, 0, 0, 4), _balance),
    Form("drift", "drift_rate", (0,) * 4, lambda slip, alpha, g, K_p: slip / alpha / (K_p / g)),
    Form("drift", "drift_of_acceleration", (0,) * 7,
         lambda square, load, psi, L_m, mu, g, K_p: g * L_m * (square + load) / (K_p * mu * psi**2)),
    Form("drift", "square_integral_of_step", (0, 0, 0), _step),
    Form("drift", "rest", (0, 2, 0, 0, 0), _rest),
    Form("drift", "forgetting_ratio", (0,) * 4, _forgetting),
    Form("drift", "adjoint_term", (0,) * 4, _adjoint),
    Form("steady_state", "current_of_flux", (0,) * 5,
         lambda psi, rate, slip, alpha, L_m: (Gauss(rate, slip * psi) / alpha + psi) / L_m),
    Form("steady_state", "regressors_of_flux", (0,) * 5,
         lambda psi, rate, slip, alpha, beta: (Gauss(rate, slip * psi) * -beta / alpha, -J * beta * psi)),
    Form("steady_state", "gram_constant_slip", (0,) * 6, _gram_slip),
    Form("steady_state", "gram_constant_torque", (0,) * 7, _gram_torque, _gram_arguments),
    Form("steady_state", "determinant", (3,), lambda g: -cross(Gauss(g[1], g[2]), Gauss(g[0], g[1]))),
    Form("steady_state", "slip_of_torque", (0,) * 5,
         lambda torque, psi, n_p, L_r, alpha: torque / (Fraction(3, 2) * n_p * psi**2 / (alpha * L_r))),
    Form("steady_state", "torque_at_zero_frequency", (0,) * 4,
         lambda omega, psi, n_p, R_r: -(psi**2) * omega * Fraction(3, 2) * n_p / R_r),
    Form("steady_state", "answer_of_line", (0,) * 6, _answer),
    Form("steady_state", "forcing_of_line", (0,) * 6, _forcing),
    Form("steady_state", "speed_information", (0,) * 5, _information, _information_arguments),
)
