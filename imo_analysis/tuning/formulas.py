"""The formulas of the rule of thumb: plain functions that `imo_analysis.tuning.rule` computes with and that write themselves.

``t_s``, ``t_r`` and ``t_l`` the wished settling time of the speed estimate, recovery time of everything
else (the flux above all) and lag behind accelerations, all in s; zeta a damping; and a_0 the decay of the current error that is
there without feedback, R_s/sigma or gamma + alpha (`imo_analysis.tuning.loops.least_current`). What the loops mean is said in
`imo_analysis.tuning.loops`, why they are chosen so in `imo_analysis.tuning.rule`.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from imo_analysis.equations.drift import drift_of_acceleration
from imo_analysis.replay.gains import resistance_gain, resistance_power

SETTLED = 4.6  # time constants: a second-order system is within 2 % after 4, and what w adds wants more
BASELINE_DAMPING = 0.55  # of the baseline, whatever is asked: what a speed error leaves in its flux grows with the damping
FAR = 22  # times the largest speed: how fast the baseline's speed loop must be for little to be left in the flux
SCHEDULED_K = 1.1  # more feedback of Kubota's kind loses the speed where the machine brakes
SCHEDULED_FAR = 5  # times the largest speed
ALPHA_DRIFT = 0.02  # of alpha, for a step by `ALPHA_STEP` of the range of speeds
ALPHA_STEP = 0.4


def adaptive_speed(zeta: Any, t_s: Any, t_r: Any, t_l: Any, omega_min: Any, omega_max: Any, a_0: Any,
                   largest: Any = max) -> Any:
    """omega_n of an adaptive observer, in rad/s."""
    return largest(SETTLED / (zeta * t_s), 500 * zeta * (1 + omega_max / omega_min) / t_r, 2 * zeta / t_l, a_0 / (2 * zeta))


def adaptive_feedback(a: Any, t_r: Any, omega_min: Any) -> Any:
    """D_0 and D_1 of an adaptive observer: D = D_0 + D_1 |omega| is 8 a / t_r at the lowest speed."""
    constant = 4 * a / t_r
    return constant, constant / omega_min


def printed_feedback(a: Any, t_r: Any, omega_max: Any) -> Any:
    """D_0 and k_2 of consistent_12: k_2 omega^2 is nothing at the lowest speed, and much of it is unstable at the highest."""
    return 8 * a / t_r, 2 * a / (5 * t_r * omega_max**2)


def baseline_speed(zeta: Any, t_s: Any, t_l: Any, omega_max: Any, a_0: Any, largest: Any = max) -> Any:
    """omega_n of the baseline with constant gains, in rad/s."""
    return largest(SETTLED / (zeta * t_s), FAR * omega_max, 2 * zeta / t_l, a_0 / (2 * zeta))


def baseline_feedback(a: Any, alpha: Any) -> Any:
    """D_0 = alpha X of the baseline, X = a / 2: its frozen flux poles then turn at half the speed."""
    return alpha * a / 2


def scheduled_loops(gamma: Any, alpha: Any, omega_max: Any) -> Any:
    """omega_n and a of the baseline with Kubota's scheduled gain, in rad/s and 1/s."""
    return SCHEDULED_FAR * omega_max, SCHEDULED_K * (gamma + alpha)


def alpha_gain(alpha: Any, flux: Any, L_m: Any, mu: Any, K_p: Any, step: Any, bandwidth: Any) -> Any:
    """g, with which a first-order step of the speed moves alpha_hat by `ALPHA_DRIFT` of alpha."""
    return ALPHA_DRIFT * alpha * K_p / drift_of_acceleration(step * step * bandwidth / 2, 0, flux, L_m, mu, 1, 1)


def noise_density(omega_n: Any, a: Any, D: Any, omega: Any, beta: Any, flux: Any, R_s: Any, sigma: Any,
                  gamma: Any, alpha: Any, root: Any) -> Any:
    """Deviation of the speed estimate in rad/s for noise of density 1 A^2 s on the currents, at a speed.

    The first term is what the speed loop lets through, the second what R_s/sigma times that noise has left in w.
    """
    loop = omega_n**2 * (omega_n**2 + (gamma + alpha) ** 2) / (2 * a)
    return root(loop + (omega * R_s / sigma) ** 2 * a / D) / (beta * flux)


_NAMES = {
    "omega_n": r"\omega_n", "a": "a", "a_0": "a_0", "t_s": "t_s", "t_r": "t_r", "t_l": "t_l", "zeta": r"\zeta",
    "omega_min": r"\omega_{\min}", "omega_max": r"\omega_{\max}", "D": "D", "omega": r"\omega", "flux": r"{\left|\phi\right|}",
    "beta": r"\beta", "alpha": r"\alpha", "gamma": r"\gamma", "sigma": r"\sigma", "mu": r"\mu", "R_s": "R_s", "L_m": "L_m",
    "K_p": "K_p", "k_3": "k_3", "step": r"{\left(\Delta\omega\right)}", "bandwidth": r"\omega_{\mathrm{drive}}"}


def written() -> list[tuple[str, list[str]]]:
    """The rule as LaTeX, by what it is for: every line is a function of this module, or `gains_of`, run on symbols.

    Returns
    -------
    list of (str, list of str)
        What the lines are for, and the lines.
    """
    import sympy

    from imo_analysis.tuning.loops import Loops, gains_of

    s = SimpleNamespace(**{name: sympy.Symbol(latex, positive=True) for name, latex in _NAMES.items()})
    machine: Any = SimpleNamespace(beta=s.beta, R_s=s.R_s, sigma=s.sigma, gamma=s.gamma, alpha=s.alpha)

    def largest(*words: Any) -> Any:
        return sympy.Max(*words, evaluate=False)

    def line(left: str, right: Any) -> str:
        return f"{left} = {sympy.latex(right)}"

    def gains(kind: str, loops: Loops, *names: str) -> list[str]:
        found = gains_of(machine, kind, s.flux, loops, s.omega_max)
        shown = {"kappa": r"\kappa"}
        return [line(shown.get(name, name), sympy.cancel(found[name]) if name == "k" else found[name]) for name in names]

    constant, rising = adaptive_feedback(s.a, s.t_r, s.omega_min)
    adaptive = Loops(s.omega_n, s.a, constant, rising)
    D_0, k_2 = printed_feedback(s.a, s.t_r, s.omega_max)
    base = Loops(s.omega_n, s.a, baseline_feedback(s.a, s.alpha), 0)
    scheduled_n, scheduled_a = scheduled_loops(s.gamma, s.alpha, s.omega_max)
    g = alpha_gain(s.alpha, s.flux, s.L_m, s.mu, s.K_p, s.step, s.bandwidth)
    noise = noise_density(s.omega_n, s.a, s.D, s.omega, s.beta, s.flux, s.R_s, s.sigma, s.gamma, s.alpha, sympy.sqrt)
    return [
        ("the adaptive observers", [
            line(r"\omega_n", adaptive_speed(s.zeta, s.t_s, s.t_r, s.t_l, s.omega_min, s.omega_max, s.a_0, largest)),
            line("a", 2 * s.zeta * s.omega_n),
            *gains("repaired", adaptive, "K_p", "k_1", "k_3", "kappa"), line("g", g)]),
        ("quiet, across and supervised the same, but", gains("quiet", adaptive, "k_1")),
        ("consistent_12 the same, but", [*gains("consistent_12", Loops(s.omega_n, s.a, D_0, k_2 * s.omega_max), "k_3", "k_2")]),
        ("the noise $n_\\omega$ of their speed estimate, for white noise of deviation $n$ on the currents, sampled every $T$", [
            r"n_\omega = n \sqrt{T}\; " + sympy.latex(noise), line("D", constant + rising * s.omega)]),
        ("the baseline with constant gains", [
            line(r"\omega_n", baseline_speed(s.zeta, s.t_s, s.t_l, s.omega_max, s.a_0, largest)),
            line("a", 2 * s.zeta * s.omega_n), line(r"\zeta", sympy.Float(BASELINE_DAMPING, 3)),
            *gains("baseline", base, "h", "l_1", "l_3"), "l_2 = l_4 = 0"]),
        ("the baseline that adapts $R_s$ the same, and", [line("h_s", resistance_gain(s.alpha, s.sigma, s.a, s.L_m, s.flux))]),
        ("that which turns its law round the same, and", [line("P_0", resistance_power(s.alpha, s.L_m, s.flux))]),
        ("the baseline with Kubota's scheduled gain", [
            line(r"\omega_n", scheduled_n),
            *gains("baseline_scheduled", Loops(s.omega_n, scheduled_a, 0, 0), "k", "h")]),
    ]
