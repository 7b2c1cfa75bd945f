"""Repairs of Proposition IV.2, ours: each with V, its exact derivative, its assumptions and what it costs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from imo_analysis.equations import lyapunov
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.situations import BOUND, constant_observable, repaired
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Name, parse
from imo_analysis.ledger.setting import Setting

_BOTH = ({"direction": 1}, {"direction": -1})
_STRENGTH = "alpha*k_3 + kappa*(direction*omega)"
_W = ("w_1_dot = -strength*i_ds_tilde", "w_2_dot = -strength*i_qs_tilde")
_KNOWN = (
    "omega and alpha constant",
    "alpha >= alpha_l (the projection then only helps, projection-inequality)",
    "for i_tilde -> 0 besides: i and phi of the machine bounded (Barbalat)",
)


def _repair(number: int, title: str, where: Setting, printed: str | Sequence[str], **more: Any) -> Claim:
    return Claim(
        id=f"repair-{number}",
        item=f"Repair {number} (ours)",
        title=title,
        expected=Verdict.HOLDS,
        setting=where,
        printed=printed,
        **more,
    )


def _no_z_gain() -> Setting:
    return constant_observable("repaired", "alpha*k_3", "no_z_gain", (), cases=tuple({**case, "kappa": 0} for case in _BOTH))


def _any_direction() -> Setting:
    return constant_observable("repaired", _STRENGTH, "any_direction", ("strength > 0",), cases=_BOTH)


def _moving(name: str, *hypotheses: str) -> Setting:
    return constant_observable(
        "repaired", _STRENGTH, name, ("strength > 0", *hypotheses), parse("direction*omega*kappa_dot"), _BOTH
    )


def _moving_conserved() -> Setting:
    """q = k_3 z_tilde - j kappa s xi_tilde while kappa moves; it is conserved no longer."""
    base = _moving("moving_gain_q")
    errors = ("z_1_tilde", "z_2_tilde", "xi_1_tilde", "xi_2_tilde")
    values = {name: Name(name) for name in (*errors, "kappa", "k_3", "direction")}
    rates = {name: Name(f"{name}_dot") for name in (*errors, "kappa")}
    defined: dict[str, Any] = {}
    for number, part in ((1, lambda **q: lyapunov.conserved(**q)[0]), (2, lambda **q: lyapunov.conserved(**q)[1])):
        defined |= {f"q_{number}": part(**values), f"q_{number}_dot": rate_along(part, values, rates)}
    return base.extended("moving_gain_q", definitions=defined, units={"q_1_dot": "A/s^2", "q_2_dot": "A/s^2"})


def _printed_gain() -> Setting:
    # The law without its sign is the printed one for direction = 1.
    return constant_observable(
        "consistent_12", "alpha*k_3 + k_2*omega**2", "printed_gain", ("k_2 > 0",), cases=({"direction": 1},)
    )


_POSITIVE = (
    ("1/2", "i_ds_tilde"),
    ("1/2", "i_qs_tilde"),
    ("direction*omega/(2*kappa)", "z_1_tilde"),
    ("direction*omega/(2*kappa)", "z_2_tilde"),
    ("alpha/(2*k_3)", "xi_1_tilde"),
    ("alpha/(2*k_3)", "xi_2_tilde"),
    ("1/(2*g)", "alpha_tilde"),
    ("1/(2*K_p)", "omega_tilde"),
)

CLAIMS: list[Claim] = [
    _repair(
        1,
        "no gain in the z loop",
        _no_z_gain(),
        f"V_dot = {BOUND}",
        prose="kappa = 0, no Sign in (11). V = |i|^2/2 + |w|^2/(2 alpha k_3) + alpha_tilde^2/(2 g) + omega_tilde^2/(2 "
        "K_p), with w = alpha "
        "xi_tilde - j omega z_tilde.",
        checks=(
            Algebra("evidence", "w answers to the current error through k_3 alone", _W),
            Algebra("evidence", "z_tilde stands still", ("z_1_tilde_dot = 0", "z_2_tilde_dot = 0")),
        ),
        assumptions=_KNOWN,
        note="No knowledge of the direction, any omega, zero included. z_tilde and xi_tilde = (w + j omega z_tilde) / "
        "alpha stay "
        "bounded. Cost: the observable errors die out with alpha k_3 alone. An offset in a measured voltage or current "
        "makes z_hat drift; with "
        "kappa > 0 it is q that drifts.",
    ),
    _repair(
        2,
        "the direction in the z loop",
        repaired(),
        f"V_dot = {BOUND}",
        prose="z_tilde' = kappa s (i_qs_tilde, -i_ds_tilde), s = sgn(omega), no Sign in (11). V as in (13) with "
        "|omega|/(2 kappa) and "
        "alpha/(2 k_3).",
        checks=(
            Algebra("evidence", "V is positive: a sum of squares with positive weights", ("V >= 0",), squares=_POSITIVE),
            Algebra("evidence", "q = k_3 z_tilde - j kappa s xi_tilde never changes", ("q_1_dot = 0", "q_2_dot = 0")),
        ),
        assumptions=("omega not zero, its sign known", *_KNOWN),
        note="Holds wherever omega_hat goes, whatever its sign. Cost: the direction must be known, and kappa does not "
        "grow with speed. k_1 is not in V and may follow anything, omega_hat included.",
    ),
    _repair(
        3,
        "a gain of the z loop that never falls",
        repaired("rising_gain", kappa_dot=True).extended("rising", hypotheses=("kappa_dot >= 0",)),
        f"V_dot <= {BOUND}",
        squares=(
            ("direction*omega*kappa_dot/(2*kappa**2)", "z_1_tilde"),
            ("direction*omega*kappa_dot/(2*kappa**2)", "z_2_tilde"),
        ),
        prose="Repair 2 with kappa(t) > 0 scheduled on any signal, as long as it never falls: its weight in V then never "
        "rises.",
        checks=(
            Algebra(
                "evidence",
                "the derivative, whichever way kappa moves",
                (f"V_dot = {BOUND} - direction*omega*kappa_dot/(2*kappa**2)*(z_1_tilde**2 + z_2_tilde**2)",),
            ),
        ),
        assumptions=("omega not zero, its sign known", "kappa differentiable, bounded, its rate at least zero", *_KNOWN),
        note="Cost: a gain raised for high speed stays raised. Repair 5 removes that.",
    ),
    _repair(
        4,
        "the printed gain k_2 omega_hat, near zero error",
        _printed_gain(),
        f"V_dot = {BOUND} + k_2*omega*omega_tilde*(w_1*i_ds_tilde + w_2*i_qs_tilde)/strength",
        prose="The feedback that (12) needs, with the printed k_2 omega_hat, no Sign in (11). V as in repair 1 with the "
        "strength alpha k_3 + "
        "k_2 omega^2 in place of alpha k_3.",
        checks=(
            Algebra(
                "evidence",
                "w' = -(alpha k_3 + k_2 omega omega_hat) i_tilde",
                (
                    "w_1_dot = -(alpha*k_3 + k_2*omega*omega_hat)*i_ds_tilde",
                    "w_2_dot = -(alpha*k_3 + k_2*omega*omega_hat)*i_qs_tilde",
                ),
            ),
        ),
        assumptions=(
            "[I, v_1, v_2] persistently exciting for the true signals, i, phi and u of the machine bounded",
            "initial errors (i, w, alpha, omega) and z_tilde small enough; z_tilde then moves by no more than the integral of "
            "|i_tilde|, so that the excitation lasts",
            *_KNOWN,
            "a system whose linear part is uniformly exponentially stable is so itself near zero (Khalil, Theorem 4.13)",
        ),
        note="What is left over is of third order: the linear part is the system of repair 2 with kappa |omega| = k_2 "
        "omega^2, exponentially "
        "stable under excitation (proposition-IV.3). Without excitation nothing damps w and omega_tilde against the "
        "third-order term, and "
        "no region is known. Cost: local, and only under excitation. Either sign of omega.",
    ),
    _repair(
        5,
        "a gain of the z loop that may rise and fall",
        _moving("falling_gain", "strength_dot <= 0"),
        f"V_dot <= {BOUND} - strength_dot/strength*V",
        squares=(
            *(("-strength_dot/(2*strength)", one) for one in ("i_ds_tilde", "i_qs_tilde")),
            ("-strength_dot/(2*g*strength)", "alpha_tilde"),
            ("-strength_dot/(2*K_p*strength)", "omega_tilde"),
        ),
        prose="kappa(t) follows any signal, for example the speed reference. V of the observable errors with the strength "
        "c = alpha k_3 + "
        "kappa s omega. While c falls this holds; while it rises, V' is at most the bound itself.",
        checks=(
            Algebra(
                "evidence",
                "the derivative, whichever way c moves",
                (f"V_dot = {BOUND} - strength_dot/(2*strength**2)*(w_1**2 + w_2**2)",),
                setting=_moving("any_gain"),
            ),
            Algebra(
                "evidence",
                "while c rises",
                (f"V_dot <= {BOUND}",),
                setting=_moving("rising_strength", "strength_dot >= 0"),
                squares=tuple(("strength_dot/(2*strength**2)", one) for one in ("w_1", "w_2")),
            ),
            Algebra("evidence", "w' = -c i_tilde, with the c of the moment", _W, setting=_moving("any_gain_w")),
            Algebra(
                "evidence",
                "q / c has the rate -j kappa' s k_3 w / c^2, so that it stays bounded when kappa has a finite variation, "
                "and with it and w "
                "so do z_tilde and xi_tilde, which V does not hold",
                (
                    "strength*q_1_dot - strength_dot*q_1 = kappa_dot*direction*k_3*w_2",
                    "strength*q_2_dot - strength_dot*q_2 = -kappa_dot*direction*k_3*w_1",
                ),
                setting=_moving_conserved(),
            ),
        ),
        assumptions=(
            "c > 0",
            "kappa differentiable and bounded, c bounded away from zero; the sum of all falls of ln c finite, as for a "
            "reference that "
            "changes finitely often",
            *_KNOWN,
        ),
        note="By Gronwall, V(t) <= V(0) exp(sum of the falls of ln c), and i_tilde stays square integrable: the rest as "
        "in the paper. Speed "
        "scheduling in both directions, which is what k_2 omega_hat was to give. Cost: not for a gain that follows "
        "omega_hat itself, whose "
        "variation is not known beforehand.",
    ),
    _repair(
        6,
        "a direction that may be wrong at low speed",
        _any_direction(),
        f"V_dot = {BOUND}",
        prose="Repair 2 with V of the observable errors: all that is needed is c = alpha k_3 + kappa s omega > 0. With "
        "the wrong s that is "
        "|omega| < alpha k_3 / kappa.",
        checks=(Algebra("evidence", "w' = -c i_tilde", _W),),
        assumptions=("alpha k_3 + kappa s omega > 0", *_KNOWN),
        note="z_tilde and xi_tilde follow from w and the conserved q (proposition-IV.3). With the gains that run here "
        "(alpha = 9.9354, k_3 = 100, kappa = 50) a wrong direction does no harm to the "
        "bound below 19.9 rad/s: "
        "the restriction of Remark III.1 is gone where it is said to bite. The direction may also be switched finitely "
        "often (repair 5).",
    ),
]
