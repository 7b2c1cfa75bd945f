"""(9)-(11) and Remark III.1: the adaptation laws, the projection, the reconstructed flux."""

from __future__ import annotations

from functools import cache
from typing import Any

from imo_analysis.equations import projection, transformation
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.transcript import claim, printed, same
from imo_analysis.ledger.dual import rate_along
from imo_analysis.ledger.expression import Name, Number, Relation, as_expr, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import errors

HOLDS, CORRECTED = Verdict.HOLDS, Verdict.CORRECTED

_ZERO: dict[str, int] = {f"{one}_tilde": 0 for one in ("alpha", "omega")}
_LAYER = projection.layer(*names("alpha_hat alpha_l delta"))
_WIDTHS = ("delta > 0", "alpha_l - delta > 0", "2*delta*alpha_l - delta*delta > 0", "2*delta*alpha_l - delta**2 > 0")


def _projection(name: str, text: str, layer: str, rho: str) -> Setting:
    signs = [Relation(layer, _LAYER, Number(as_expr(0).value))] if layer else []  # type: ignore[attr-defined]
    return setting(
        name,
        text,
        {"p": _LAYER, "proj": projection.projection(*names("rho alpha_hat alpha_l delta"))},
        (*_WIDTHS, *signs, *([rho] if rho else [])),
        units={"p": "1", "proj": "1/s^2"},
    )


@cache
def at_the_bound() -> Setting:
    """The projection where alpha_hat is at alpha_l, at the end of its layer, and its two slopes at alpha_l."""
    a, d, rho = names("alpha_l delta rho")

    def inside(alpha_hat: Any, alpha_l: Any = a, delta: Any = d, rho: Any = rho) -> Any:
        return (1 - projection.layer(alpha_hat, alpha_l, delta)) * rho

    at = {"alpha_hat": a, "alpha_l": a, "delta": d, "rho": rho}

    return setting(
        "at_the_bound",
        "the projection of a rho < 0 at alpha_hat = alpha_l and at alpha_hat = alpha_l - delta",
        {
            "rate_at_bound": inside(a),
            "rate_at_end": inside(a - d),
            "slope_below": rate_along(inside, at, {"alpha_hat": 1}),
            "slope_above": 0,
            "value_below": inside(a),
            "value_above": rho,
        },
        (*_WIDTHS, "rho < 0", "alpha_l > 0"),
        units={"rate_at_bound": "1/s^2", "rate_at_end": "1/s^2", "slope_below": "1/s", "slope_above": "1/s"},
    )


def _with_flux(name: str, text: str, flux: tuple[Any, Any], *hypotheses: str) -> Setting:
    return errors().extended(name, text, {"phi_dr_hat": flux[0], "phi_qr_hat": flux[1]}, hypotheses)


@cache
def flux_from_z() -> Setting:
    """The flux estimate (z_hat - i_hat) / beta, by which the paper introduces z_hat."""
    return _with_flux(
        "flux_from_z",
        "the flux estimate (z_hat - i_hat) / beta",
        transformation.from_z(*names("i_ds_hat i_qs_hat z_1_hat z_2_hat beta")),
    )


@cache
def flux_reconstructed() -> Setting:
    """The flux estimate printed below (11)."""
    return _with_flux(
        "flux_reconstructed",
        "the flux estimate that is printed below (11)",
        transformation.reconstructed_flux(*names("i_ds i_qs z_1_hat z_2_hat xi_1_hat xi_2_hat alpha_hat omega_hat beta")),
        "alpha_hat*alpha_hat + omega_hat*omega_hat > 0",
    )


_KNOWN = {f"{one}_tilde": 0 for one in ("alpha", "omega", "xi_1", "xi_2", "z_1", "z_2")}
_SIGNAL = "(-i_qs_hat*i_ds_tilde + i_ds_hat*i_qs_tilde + z_2_hat*i_ds_tilde - z_1_hat*i_qs_tilde)"

CLAIMS: list[Claim] = [
    claim(
        "eq9.rho",
        "the signal that adapts alpha",
        HOLDS,
        errors().extended("alpha_law", definitions={"rho": Name("alpha_hat_dot")}, hypotheses=("g > 0",)),
        checks=(
            Algebra(
                "evidence",
                "it cancels what the error of alpha does to the current errors",
                (
                    "alpha_tilde*(i_ds_tilde*(xi_1_hat - (1 + beta*L_m)*i_ds) + i_qs_tilde*(xi_2_hat - (1 + beta*L_m)*i_qs))"
                    " + alpha_tilde*alpha_tilde_dot/g = 0",
                ),
            ),
        ),
        assumptions=("the projection does not act",),
    ),
    claim(
        "eq10.layer",
        "the layer function",
        HOLDS,
        _projection("layer", "the layer of the projection", "", ""),
        checks=(
            Algebra(
                "evidence",
                "it is 0 at alpha_l",
                ("p = 0",),
                setting=_projection("layer_0", "at alpha_l", "", "").extended(
                    "layer_begins", definitions={"p": projection.layer(*names("alpha_l alpha_l delta"))}
                ),
            ),
            Algebra(
                "evidence",
                "it is 1 at alpha_l - delta",
                ("p = 1",),
                setting=_projection("layer_1", "", "", "").extended(
                    "layer_ends", definitions={"p": projection.layer(Name("alpha_l") - Name("delta"), *names("alpha_l delta"))}
                ),
            ),
        ),
        assumptions=(
            "0 < delta < alpha_l, which is not printed: without it the denominator may vanish or the bound be negative",
        ),
    ),
    claim(
        "eq10.cases",
        "the projection by cases",
        HOLDS,
        _projection("projection", "the projection", "", ""),
        checks=(
            Algebra(
                "printed",
                "outside the layer",
                ("proj = rho",),
                setting=_projection("outside", "p <= 0, rho >= 0", "<=", "rho >= 0"),
            ),
            Algebra(
                "printed",
                "outside the layer, inwards",
                ("proj = rho",),
                setting=_projection("outside_in", "p <= 0, rho <= 0", "<=", "rho <= 0"),
            ),
            Algebra(
                "printed",
                "in the layer, outwards",
                ("proj = rho",),
                setting=_projection("outwards", "p >= 0, rho >= 0", ">=", "rho >= 0"),
            ),
            Algebra(
                "printed",
                "in the layer, inwards",
                ("proj = (1 - p)*rho",),
                setting=_projection("inwards", "p >= 0, rho <= 0", ">=", "rho <= 0"),
            ),
        ),
        note="The cases overlap at p = 0 and at rho = 0, where they agree; so the definition is sound.",
    ),
    claim(
        "projection-keeps-bound",
        "alpha_hat stays above alpha_l; the projection is smooth",
        CORRECTED,
        at_the_bound(),
        printed=("rate_at_bound >= 0", "slope_below = slope_above"),
        corrected=("rate_at_end = 0", "value_below = value_above"),
        edit="alpha_l - delta for alpha_l, and 'Lipschitz continuous' for 'smooth'",
        origin="paper",
        why="the layer begins at alpha_l: there a negative rho still passes undiminished",
        assumptions=("0 < delta < alpha_l", "alpha_hat starts at or above alpha_l - delta"),
        note="A Lipschitz right-hand side is all that the existence of solutions and the rest of the argument need.",
        consequences=("projection-inequality.inequality",),
    ),
    claim(
        "eq11.first",
        "the speed law",
        CORRECTED,
        errors("repaired"),
        corrected=same("eq11.first", "K_p*direction*", "K_p*"),
        edit="remove Sign(omega)",
        origin="paper",
        why="Sign(omega) is printed in both lines, explained below and defended in Remark III.1",
        prose="The law that cancels the speed error's terms in the derivative of V.",
        checks=(
            Algebra(
                "evidence",
                "without the sign, it cancels them for both directions",
                (f"omega_tilde*{_SIGNAL} + omega_tilde*omega_tilde_dot/K_p = 0",),
                setting=errors("repaired").extended("law", hypotheses=("K_p > 0",)),
            ),
            Algebra(
                "evidence",
                "as printed, for omega < 0, it doubles them",
                (f"omega_tilde*{_SIGNAL} + omega_tilde*omega_tilde_dot/K_p = 2*omega_tilde*{_SIGNAL}",),
                setting=errors().extended("law_backwards", hypotheses=("K_p > 0",), cases=({"direction": -1},)),
            ),
            Algebra(
                "evidence",
                "for omega > 0 the sign is 1 and the law is right",
                (printed("eq11.first"),),
                setting=errors("repaired").extended("law_forwards", cases=({"direction": 1},)),
            ),
        ),
        consequences=("remark-III.1", "sign-operator.inequality", "proposition-IV.2"),
    ),
    claim(
        "eq11.second",
        "the speed law in fluxes",
        CORRECTED,
        flux_reconstructed(),
        checks=(
            Algebra("corrected", "with phi_hat = (z_hat - i_hat) / beta", (printed("eq11.second"),), setting=flux_from_z()),
        ),
        edit="phi_hat = (z_hat - i_hat) / beta in this line, in place of the flux that is reconstructed below it",
        origin="paper",
        why="z_hat = i_hat + beta phi_hat is how the paper introduces z_hat; the flux below (11) is another estimate",
        note="The two estimates agree when all errors are zero. Sign(omega) is judged under the first line.",
    ),
    claim(
        "eq11.flux_d",
        "the reconstructed flux",
        HOLDS,
        flux_reconstructed(),
        checks=(
            Algebra(
                "printed",
                "with exact estimates it is the flux",
                ("phi_dr_hat = phi_dr", "phi_qr_hat = phi_qr"),
                setting=flux_reconstructed().extended(
                    "exact_estimates", cases=({**_KNOWN, "direction": 1},), hypotheses=("alpha*alpha + omega*omega > 0",)
                ),
            ),
            Algebra(
                "evidence",
                "with alpha and omega known, its error is that of w = alpha xi_tilde - j omega z_tilde alone: it needs "
                "neither z_tilde nor xi_tilde to vanish",
                (
                    "beta*(alpha*(phi_dr - phi_dr_hat) + omega*(phi_qr - phi_qr_hat)) = alpha*xi_1_tilde + omega*z_2_tilde",
                    "beta*(alpha*(phi_qr - phi_qr_hat) - omega*(phi_dr - phi_dr_hat)) = alpha*xi_2_tilde - omega*z_1_tilde",
                ),
                setting=flux_reconstructed().extended("known_parameters", cases=({**_ZERO, "direction": 1},)),
            ),
        ),
        assumptions=("alpha_hat and omega_hat are not both zero",),
    ),
    claim(
        "remark-III.1",
        "knowing the direction is no restriction at medium and high speed",
        CORRECTED,
        errors().extended("known_direction", hypotheses=("K_p > 0",), cases=({"direction": -1},)),
        printed=f"omega_tilde*{_SIGNAL} + omega_tilde*omega_tilde_dot/K_p = 0",
        edit="remove Sign(omega) from (11); the direction is then needed in the z loop alone, and not at all when that "
        "has no gain",
        checks=(
            Algebra(
                "corrected",
                "the law without the sign",
                (f"omega_tilde*{_SIGNAL} + omega_tilde*omega_tilde_dot/K_p = 0",),
                setting=errors("repaired").extended("law_both", hypotheses=("K_p > 0",)),
            ),
        ),
        prose="For a known negative direction the terms of the speed error cancel.",
        origin="paper",
        why="it follows from (11)",
        note="The known direction itself does the harm: backwards, at any speed, it reverses the law.",
    ),
]
