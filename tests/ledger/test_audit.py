"""The audit of an observer of one's own, and the shipped one of Kubota and Matsuse."""

from fractions import Fraction
from random import Random
from typing import Any

import numpy as np
import pytest

from imo_analysis.equations import baseline, plant
from imo_analysis.errors import InputError
from imo_analysis.ledger.audit import audit, error_setting, trace, with_lyapunov
from imo_analysis.ledger.book import subject
from imo_analysis.ledger.claim import Claim, Verdict
from imo_analysis.ledger.expression import evaluate
from imo_analysis.ledger.subjects import kubota

UNITS = {"x": "A", "a": "1/s", "u": "A/s", "k": "1/s", "g": "1/(A^2 s^2)"}


def _plant(x: Any, u: Any, a: Any) -> dict[str, Any]:
    return {"x": -a * x + u}


def _observer(x: Any, x_hat: Any, u: Any, a_hat: Any, k: Any, g: Any) -> dict[str, Any]:
    return {"x": -a_hat * x_hat + u + k * (x - x_hat), "a": -g * (x - x_hat) * x_hat}


def _candidate(x_tilde: Any, a_tilde: Any, g: Any) -> Any:
    return x_tilde**2 / 2 + a_tilde**2 / (2 * g)


WHERE = with_lyapunov(
    error_setting("mine", "a first-order system", _plant, _observer, ("g > 0", "k > 0", "a > 0"), units=UNITS),
    _candidate, unit="A^2")


def test_an_audit_from_plain_functions() -> None:
    claims = [
        Claim("error", "(1)", "error dynamics", Verdict.HOLDS, WHERE,
              printed="x_tilde_dot = -(a + k)*x_tilde - a_tilde*x_hat"),
        Claim("v", "(2)", "derivative", Verdict.CORRECTED, WHERE, printed="V_dot = -k*x_tilde**2",
              corrected="V_dot = -(a + k)*x_tilde**2", edit="the plant damps too"),
        Claim("bound", "(3)", "bound", Verdict.HOLDS, WHERE, printed="V_dot <= -k*x_tilde**2", squares=(("a", "x_tilde"),)),
    ]
    result = audit(claims)
    assert result.ok and [str(e.verdict) for e in result.entries] == ["holds", "holds after correction", "holds"]
    assert result.mutants.tried > 50 and result.mutants.missed == []
    assert "the plant damps too" in result.text()


def test_an_audit_finds_the_wrong_adaptation_law() -> None:
    def wrong(x: Any, x_hat: Any, u: Any, a_hat: Any, k: Any, g: Any) -> dict[str, Any]:
        return {**_observer(x, x_hat, u, a_hat, k, g), "a": g * (x - x_hat) * x_hat}

    where = with_lyapunov(error_setting("wrong", "", _plant, wrong, ("g > 0", "k > 0"), units=UNITS), _candidate, unit="A^2")
    entry = audit([Claim("v", "", "", Verdict.FAILS, where, printed="V_dot = -(a + k)*x_tilde**2")]).entries[0]
    assert entry.ok and entry.findings[0].detail["residual"] != "0"


def test_a_function_that_is_not_algebra_is_refused() -> None:
    with pytest.raises(InputError, match="cannot be traced"):
        trace(lambda x: np.sqrt(x) if x > 0 else 0)


def test_kubota_is_settled_whole() -> None:
    claims = subject("kubota")
    result = audit(claims)
    assert result.ok
    assert {e.claim.id: str(e.verdict) for e in result.entries}["kubota.negative"] == "fails"


def test_kubota_v_rises_in_a_second_route_by_differences() -> None:
    """V along a tiny exact Euler step of machine and observer, without dual numbers: it rises where the ledger says."""
    values = {name: Fraction(value) for name, value in kubota._GROWS.items()}
    p = tuple(values[name] for name in ("R_s", "L_m", "sigma", "beta", "alpha"))
    l_3 = values["alpha"] * values["L_m"] + values["alpha"] * values["beta"] / values["c"]
    l_4 = values["beta"] * values["omega"] / values["c"]
    true = [values[name] for name in ("i_ds", "i_qs", "phi_dr", "phi_qr", "omega")]
    tilde = [values[f"{name}_tilde"] for name in ("i_ds", "i_qs", "phi_dr", "phi_qr", "omega")]
    hat = [a - b for a, b in zip(true, tilde, strict=True)]
    i, u = tuple(true[:2]), (values["u_ds"], values.get("u_qs", Fraction(0)))
    true_rate = [*plant.plant(tuple(true), u, 0, 0, (*p, 0, 1, Fraction(1)))[:4], 0]
    hat_rate = baseline.baseline(tuple(hat), i, u, 1, p, (values["l_1"], values["l_2"], l_3, l_4, values["h"]))
    step = Fraction(1, 10**6)
    after = [a + step * (b - c) for a, b, c in zip(tilde, true_rate, hat_rate, strict=True)]
    slope = (kubota.candidate(*after, values["c"], values["h"]) - kubota.candidate(*tilde, values["c"], values["h"])) / step
    assert abs(slope - 1) < Fraction(1, 10**4)


def test_the_baseline_and_the_plant_are_the_definitions_themselves() -> None:
    random = Random(6)
    rows = kubota.GENERAL.definitions
    values = {name: Fraction(random.randint(1, 9)) for name in (
        "i_ds_hat", "i_qs_hat", "phi_dr_hat", "phi_qr_hat", "omega_hat", "i_ds", "i_qs", "u_ds", "u_qs", "R_s", "L_m", "sigma",
        "beta", "alpha", "l_1", "l_2", "l_3", "l_4", "h")}
    direct = baseline.baseline(
        tuple(values[n] for n in ("i_ds_hat", "i_qs_hat", "phi_dr_hat", "phi_qr_hat", "omega_hat")),
        (values["i_ds"], values["i_qs"]), (values["u_ds"], values["u_qs"]), 1,
        tuple(values[n] for n in ("R_s", "L_m", "sigma", "beta", "alpha")),
        tuple(values[n] for n in ("l_1", "l_2", "l_3", "l_4", "h")))
    assert evaluate(rows["phi_qr_hat_dot"], values) == direct[3] and evaluate(rows["omega_hat_dot"], values) == direct[4]
