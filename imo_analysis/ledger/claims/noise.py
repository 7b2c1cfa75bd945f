"""What current noise does to the alpha law (9), and two observers: one whose law does not square it, one that stops in time.

These statements are ours. The mean over a noise n that is as likely as its opposite is half the sum of the values at n and -n.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from imo_analysis.equations import across, adaptive, lyapunov, quiet
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.situations import ERRORS, with_function
from imo_analysis.ledger.expression import Name, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS, FULL, GAINS, MACHINE, VOLTAGES, errors

ITEM = "Noise (ours)"
BOUND = "-(k_1 + R_s/sigma + alpha*(1 + beta*L_m))*(i_ds_tilde**2 + i_qs_tilde**2)"
_UNITS = {"n_1": "A", "n_2": "A", "mean_signal": "A^2", "quiet_signal": "A^2", "signal": "A^2", "speed_mean": "A^2",
          "speed_free": "A^2", "quiet_free": "A^2", "c": "1", "c_dot": "1/s"}


@cache
def noisy() -> Setting:
    """The signals of (9) and (11) with noise (n_1, n_2) on the measured current, averaged over n and -n."""
    n = names("n_1 n_2")
    i_hat, z_hat, xi_hat = names("i_ds_hat i_qs_hat"), names("z_1_hat z_2_hat"), names("xi_1_hat xi_2_hat")
    beta, L_m = names("beta L_m")

    def at(sign: int) -> tuple[Any, Any, Any]:
        i = (CURRENTS[0] + sign * n[0], CURRENTS[1] + sign * n[1])
        error = (i[0] - i_hat[0], i[1] - i_hat[1])
        return (adaptive.alpha_signal(error, i, xi_hat, beta, L_m), adaptive.alpha_signal(error, i_hat, xi_hat, beta, L_m),
                adaptive.speed_signal(error, i_hat, z_hat))

    free, plus, minus = at(0), at(1), at(-1)
    defined = {
        "signal": free[0], "quiet_free": free[1], "speed_free": free[2],
        "mean_signal": (plus[0] + minus[0]) / 2, "quiet_signal": (plus[1] + minus[1]) / 2,
        "speed_mean": (plus[2] + minus[2]) / 2,
    }
    return setting("noisy_current", "the adaptation signals with noise on the measured current", defined, units=_UNITS)


def _without_layer(rho: Any, alpha_hat: Any, alpha_l: Any, delta: Any) -> Any:
    """The projection (10) away from its layer."""
    return rho


_REPAIRED_GAINS = (GAINS[0], Name("kappa"), *GAINS[2:])


@contextmanager
def instead(module: Any, **functions: Any) -> Iterator[None]:
    """Call other functions of these names in a module of definitions, while its rates are traced."""
    whole = {name: getattr(module, name) for name in functions}
    vars(module).update(functions)
    try:
        yield
    finally:
        vars(module).update(whole)


def free_share(v_1: Any, v_2: Any) -> Any:
    """c as a free name: what is proved then holds for any."""
    return Name("c")


def rates_without_layer(module: Any, function: Any, state: Any = FULL, gains: Any = _REPAIRED_GAINS) -> dict[str, Any]:
    """The rates of an observer with the projection of its alpha law, called in ``module``, away from its layer."""
    with instead(module, projection=_without_layer):
        row = function(state, CURRENTS, VOLTAGES, Name("direction"), MACHINE, gains)
    return {f"{name.name}_dot": rate for name, rate in zip(state, row, strict=True)}


_POSITIVE = ("R_s > 0", "L_m > 0", "k_1 > 0", "k_3 > 0", "kappa > 0", "g > 0", "K_p > 0", "alpha > 0")


@cache
def quiet_errors() -> Setting:
    """`errors` of the observer `quiet`, with V of the repaired observer and its rate; away from the projection's layer."""
    base = errors("repaired")
    defined = {**base.definitions, **rates_without_layer(quiet, quiet.quiet)}
    defined |= with_function(lyapunov.with_direction, ERRORS)
    text = "the machine (6) and the observer with i_hat beside alpha_hat, omega and alpha constant"
    return setting("quiet_errors", text, defined, (*base.hypotheses, *_POSITIVE), base.cases)


def _weighted(i_ds_tilde: Any, i_qs_tilde: Any, z_1_tilde: Any, z_2_tilde: Any, xi_1_tilde: Any, xi_2_tilde: Any,
              alpha_tilde: Any, omega_tilde: Any, alpha: Any, omega: Any, direction: Any, kappa: Any, k_3: Any, g: Any,
              K_p: Any, c: Any) -> Any:
    """V of the repaired observer with omega_tilde + c alpha_tilde in place of omega_tilde."""
    return lyapunov.with_direction(i_ds_tilde, i_qs_tilde, z_1_tilde, z_2_tilde, xi_1_tilde, xi_2_tilde, alpha_tilde,
                                   omega_tilde + c * alpha_tilde, alpha, omega, direction, kappa, k_3, g, K_p)


@cache
def across_errors() -> Setting:
    """`errors` of the observer `across`; its share c and the rate c_dot are left free."""
    base = errors("repaired")
    with instead(across, share=free_share):
        defined = {**base.definitions, **rates_without_layer(across, across.across)}
    defined |= with_function(_weighted, (*ERRORS, "c"))
    text = "the machine (6) and the observer whose alpha law is across v_2, omega and alpha constant"
    return setting("across_errors", text, defined, (*base.hypotheses, *_POSITIVE), base.cases, _UNITS)


CLAIMS = [
    Claim(
        id="noise.bias", item=ITEM, title="current noise drives alpha_hat down",
        expected=Verdict.HOLDS, setting=noisy(),
        prose="(9) multiplies the noise of the measured current with itself: its mean is lower by (1 + beta L_m) |n|^2, "
              "so that alpha_hat drifts at -2 g (1 + beta L_m) times the variance of the noise on each axis. (11) has none.",
        printed=("mean_signal = signal - (1 + beta*L_m)*(n_1**2 + n_2**2)", "speed_mean = speed_free"),
        assumptions=("noise without correlation in time, as likely as its opposite",),
    ),
    Claim(
        id="noise.quiet", item=ITEM, title="with i_hat beside alpha_hat the square of the noise drops out and the proof stands",
        expected=Verdict.HOLDS, setting=quiet_errors(),
        prose="V of the repaired observer falls as V' = -(k_1 + R_s/sigma + alpha (1 + beta L_m)) |i_tilde|^2 for constant "
              "omega of either sign, whatever omega_hat does.",
        printed=(f"V_dot = {BOUND}",),
        checks=(Algebra("evidence", "the mean of its alpha signal", ("quiet_signal = quiet_free",), setting=noisy()),),
    ),
    Claim(
        id="noise.across", item=ITEM, title="adapting alpha_hat across v_2 only keeps the proof",
        expected=Verdict.HOLDS, setting=across_errors(),
        prose="With omega_tilde + c alpha_tilde in the place of omega_tilde, V' = -(k_1 + R_s/sigma + alpha (1 + beta L_m)) "
              "|i_tilde|^2 + (omega_tilde + c alpha_tilde) alpha_tilde c'/K_p, whatever c is. With c = v_1.v_2 / (|v_2|^2 + 1 "
              "A^2), c is constant while flux and slip are, and V falls.",
        printed=(f"V_dot = {BOUND} + (omega_tilde + c*alpha_tilde)*alpha_tilde*c_dot/K_p",),
    ),
]
