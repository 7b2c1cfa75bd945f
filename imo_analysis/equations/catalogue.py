"""Every observer under its name: rates, states, gains and flux, so that the other rooms need not know them one by one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from imo_analysis.equations import across, adaptive, baseline, luenberger, quiet, repaired, scheduled, supervised
from imo_analysis.equations.transformation import from_z, reconstructed_flux

_FULL = ("i_ds_hat", "i_qs_hat", "z_1_hat", "z_2_hat", "xi_1_hat", "xi_2_hat", "alpha_hat", "omega_hat")
RUNNING_GRAM = ("m_1d", "m_1q", "m_2d", "m_2q", "S")
_GAINS = ("k_1", "k_2", "k_3", "g", "K_p", "alpha_l", "delta")
PARAMETERS = ("R_s", "L_m", "sigma", "beta", "alpha")


def _flux_adaptive(x: Any, i: Any, beta: Any) -> Any:
    return reconstructed_flux(i[0], i[1], x[2], x[3], x[4], x[5], x[6], x[7], beta)


def _flux_luenberger(x: Any, i: Any, beta: Any) -> Any:
    return from_z(x[0], x[1], x[2], x[3], beta)


def _flux_baseline(x: Any, i: Any, beta: Any) -> Any:
    return x[2], x[3]


@dataclass(frozen=True)
class Observer:
    """An observer of the family.

    Attributes
    ----------
    name : str
        The name used in studies and data sets.
    rates : callable
        ``rates(x, i, u, direction, p, gains)``; ``p`` in the order of `PARAMETERS`.
    states, gains : tuple of str
        Names, in the order of ``x`` and ``gains``.
    flux : callable
        ``flux(x, i, beta)``, the estimated rotor flux.
    source : str
        Where the paper prints it.
    meaning : str
        In a line.
    needs_direction : bool
        Whether it must be told the direction of rotation.
    """

    name: str
    rates: Callable[..., Any]
    states: tuple[str, ...]
    gains: tuple[str, ...]
    flux: Callable[..., Any]
    source: str
    meaning: str
    needs_direction: bool


OBSERVERS: dict[str, Observer] = {
    o.name: o
    for o in (
        Observer("baseline", baseline.baseline,
                 ("i_ds_hat", "i_qs_hat", "phi_dr_hat", "phi_qr_hat", "omega_hat"), ("l_1", "l_2", "l_3", "l_4", "h"),
                 _flux_baseline, "(2)-(4)", "adaptive full-order observer of Kubota and Matsuse", False),
        Observer("baseline_scheduled", scheduled.baseline_scheduled,
                 ("i_ds_hat", "i_qs_hat", "phi_dr_hat", "phi_qr_hat", "omega_hat"), ("k", "h"),
                 _flux_baseline, "Kubota 1993", "the baseline with Kubota's gain, scheduled on its own speed", False),
        *(
            Observer(f"luenberger_{name}", rates,
                     ("i_ds_hat", "i_qs_hat", "z_1_hat", "z_2_hat", "omega_hat"), ("k_1", "k_2", "K_p"),
                     _flux_luenberger, "(7), (11)", f"Luenberger observer with known alpha, z feedback of {where}", True)
            for name, rates, where in (
                ("printed_7", luenberger.luenberger_printed_7, "(7)"),
                ("printed_L", luenberger.luenberger_printed_L, "L(omega_hat)"),
                ("consistent_12", luenberger.luenberger_consistent_12, "(12)"),
            )
        ),
        *(
            Observer(name, rates, _FULL, _GAINS, _flux_adaptive, "(8)-(11)", f"adaptive observer, z feedback of {where}", True)
            for name, rates, where in (
                ("printed_7", adaptive.printed_7, "(7) and (8)"),
                ("printed_L", adaptive.printed_L, "L(omega_hat)"),
                ("consistent_12", adaptive.consistent_12, "(12)"),
            )
        ),
        Observer("repaired", repaired.repaired, _FULL, ("k_1", "kappa", *_GAINS[2:]), _flux_adaptive,
                 "ours", "adaptive observer with the sign moved from (11) into the z loop", True),
        Observer("quiet", quiet.quiet, _FULL, ("k_1", "kappa", *_GAINS[2:]), _flux_adaptive,
                 "ours", "the repaired observer, with alpha_hat that current noise does not drive", True),
        Observer("across", across.across, _FULL, ("k_1", "kappa", *_GAINS[2:]), _flux_adaptive,
                 "ours", "the quiet observer, whose alpha_hat rests while the flux is constant", True),
        Observer("supervised", supervised.supervised, (*_FULL, *RUNNING_GRAM), ("k_1", "kappa", *_GAINS[2:], "eta", "S_0"),
                 _flux_adaptive, "ours", "the observer across, whose alpha_hat rests while excitation is lost", True),
    )
}
