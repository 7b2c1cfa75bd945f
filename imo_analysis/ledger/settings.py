"""The settings of this paper's claims, traced from the plain definitions: the machine, an observer, and their difference.

Free names are the true state, the errors (tilde), parameters and gains; every estimate (hat) is defined as true minus
error, and every rate (dot) is a row of a definition. Nothing is typed in again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from imo_analysis.equations import adaptive, luenberger, parameters, plant, repaired, transformation
from imo_analysis.ledger.expression import Expr, Name, names
from imo_analysis.ledger.setting import Setting, setting

CURRENTS = names("i_ds i_qs")
VOLTAGES = names("u_ds u_qs")
Z = names("z_1 z_2")
MACHINE = names("R_s L_m sigma beta alpha")
FULL = names("i_ds_hat i_qs_hat z_1_hat z_2_hat xi_1_hat xi_2_hat alpha_hat omega_hat")
GAINS = names("k_1 k_2 k_3 g K_p alpha_l delta")
PHYSICAL = ("sigma > 0", "beta > 0", "R_s > 0", "L_m > 0", "alpha > 0")


@cache
def machine(omega_1: str = "0") -> Setting:
    """The machine (1): rates of currents, fluxes and speed, with gamma, mu and z as they are defined.

    ``omega_1`` is ``"0"`` for the stationary frame or ``"omega_1"`` for the general one.
    """
    frame: Any = 0 if omega_1 == "0" else Name(omega_1)
    flux = names("phi_dr phi_qr")
    z_1, z_2 = transformation.to_z(*(*CURRENTS, *flux, Name("beta")))
    rates = plant.plant((*CURRENTS, *flux, Name("omega")), VOLTAGES, frame, Name("T_l"), (*MACHINE, *names("mu n_p J")))
    z_rates = transformation.to_z(*names("i_ds_dot i_qs_dot phi_dr_dot phi_qr_dot beta"))
    defined: dict[str, Any] = {
        "gamma": parameters.current_decay(*names("R_s L_m sigma alpha beta")), "z_1": z_1, "z_2": z_2,
        **_rates(("i_ds", "i_qs", "phi_dr", "phi_qr", "omega"), rates), "z_1_dot": z_rates[0], "z_2_dot": z_rates[1],
    }
    where = "stationary frame" if omega_1 == "0" else "frame turning at omega_1"
    return setting(f"machine_{omega_1}", f"the machine (1), {where}", defined, ("sigma != 0", "beta != 0", "J != 0"))


def _rates(which: tuple[str, ...], rates: Any) -> dict[str, Expr]:
    return {f"{name}_dot": rate for name, rate in zip(which, rates, strict=True)}


def _errors(pairs: Mapping[str, str]) -> dict[str, Expr]:
    """Every estimate as true minus error."""
    return {f"{name}_hat": Name(true) - Name(f"{name}_tilde") for name, true in pairs.items()}


_FULL_TRUE = {"i_ds": "i_ds", "i_qs": "i_qs", "z_1": "z_1", "z_2": "z_2", "xi_1": "z_1", "xi_2": "z_2",
              "alpha": "alpha", "omega": "omega"}
_OBSERVERS: dict[str, tuple[Callable[..., Any], str]] = {
    "printed_7": (adaptive.printed_7, "the observer with the z feedback printed in (7) and in the expanded (8)"),
    "printed_L": (adaptive.printed_L, "the observer with the z feedback of the matrix L(omega_hat)"),
    "consistent_12": (adaptive.consistent_12, "the observer with the z feedback that (12) needs"),
    "repaired": (repaired.repaired, "the repaired observer"),
}


@cache
def errors(observer: str = "consistent_12") -> Setting:
    """The machine (6) and the observer (8)-(11) side by side, omega and alpha constant, away from the projection's layer.

    Defined: ``*_hat`` (true minus error), ``*_dot`` (machine), ``*_hat_dot`` (observer) and ``*_tilde_dot`` (their
    difference) of i_ds, i_qs, z_1, z_2, xi_1, xi_2, and of alpha and omega, whose true rates are zero; ``phi_dr`` and
    ``phi_qr``. ``direction`` is +1 or -1, a case each. The alpha law is taken without its projection (`projection.layer`
    at or below zero); the projection has its own claims.

    Parameters
    ----------
    observer : str
        ``consistent_12``, ``printed_7``, ``printed_L`` or ``repaired``.
    """
    rates, words = _OBSERVERS[observer]
    gains = (GAINS[0], Name("kappa"), *GAINS[2:]) if observer == "repaired" else GAINS
    row = rates(FULL, CURRENTS, VOLTAGES, Name("direction"), MACHINE, gains)
    currents_error = (CURRENTS[0] - FULL[0], CURRENTS[1] - FULL[1])
    alpha_law = Name("g") * adaptive.alpha_signal(currents_error, CURRENTS, FULL[4:6], Name("beta"), Name("L_m"))
    true = plant.plant_z((*CURRENTS, *Z), VOLTAGES, Name("omega"), 0, MACHINE)
    flux = transformation.from_z(*(*CURRENTS, *Z, Name("beta")))
    defined: dict[str, Any] = {
        **_errors(_FULL_TRUE), "phi_dr": flux[0], "phi_qr": flux[1],
        **_rates(("i_ds", "i_qs", "z_1", "z_2"), true), "xi_1_dot": true[2], "xi_2_dot": true[3],
        "alpha_dot": 0, "omega_dot": 0,
        **_rates(tuple(f"{name}_hat" for name in _FULL_TRUE), (*row[:6], alpha_law, row[7])),
    }
    defined |= {f"{name}_tilde_dot": Name(f"{name}_dot") - Name(f"{name}_hat_dot") for name in _FULL_TRUE}
    return setting(
        f"errors_{observer}", f"the machine (6) and {words}, omega and alpha constant", defined,
        ("sigma > 0", "beta > 0"), ({"direction": 1}, {"direction": -1}))


@cache
def luenberger_errors(convention: str = "consistent_12") -> Setting:
    """The machine (6) and the Luenberger observer (7) with known alpha, in one of the three z-feedback conventions."""
    rates = {"printed_7": luenberger.luenberger_printed_7, "printed_L": luenberger.luenberger_printed_L,
             "consistent_12": luenberger.luenberger_consistent_12}[convention]
    pairs = {name: name for name in ("i_ds", "i_qs", "z_1", "z_2", "omega")}
    row = rates((*FULL[:4], FULL[7]), CURRENTS, VOLTAGES, Name("direction"), MACHINE, names("k_1 k_2 K_p"))
    true = plant.plant_z((*CURRENTS, *Z), VOLTAGES, Name("omega"), 0, MACHINE)
    defined: dict[str, Any] = {
        **_errors(pairs), **_rates(("i_ds", "i_qs", "z_1", "z_2"), true), "omega_dot": 0,
        **_rates(tuple(f"{name}_hat" for name in pairs), row),
    }
    defined |= {f"{name}_tilde_dot": Name(f"{name}_dot") - Name(f"{name}_hat_dot") for name in pairs}
    return setting(f"luenberger_{convention}", "the machine (6) and the observer (7), omega constant", defined,
                   ("sigma > 0", "beta > 0"), ({"direction": 1}, {"direction": -1}))
