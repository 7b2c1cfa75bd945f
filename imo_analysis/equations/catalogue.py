"""Every observer under its name: rates, states, gains and flux, so that the other rooms need not know them one by one."""

from __future__ import annotations

from typing import Any

from imo_analysis.equations import (
    across,
    adaptive,
    baseline,
    luenberger,
    own,
    quiet,
    repaired,
    resistance,
    scheduled,
    supervised,
)
from imo_analysis.equations.observer import PARAMETERS, Observer
from imo_analysis.equations.transformation import from_z, reconstructed_flux
from imo_analysis.errors import InputError

__all__ = ["OBSERVERS", "PARAMETERS", "RUNNING_GRAM", "Catalogue", "Observer"]

_FULL = ("i_ds_hat", "i_qs_hat", "z_1_hat", "z_2_hat", "xi_1_hat", "xi_2_hat", "alpha_hat", "omega_hat")
RUNNING_GRAM = ("m_1d", "m_1q", "m_2d", "m_2q", "S")
_GAINS = ("k_1", "k_2", "k_3", "g", "K_p", "alpha_l", "delta")


def _flux_adaptive(x: Any, i: Any, beta: Any) -> Any:
    return reconstructed_flux(i[0], i[1], x[2], x[3], x[4], x[5], x[6], x[7], beta)


def _flux_luenberger(x: Any, i: Any, beta: Any) -> Any:
    return from_z(x[0], x[1], x[2], x[3], beta)


def _flux_baseline(x: Any, i: Any, beta: Any) -> Any:
    return x[2], x[3]


class Catalogue(dict[str, Observer]):
    """Observers by name; one that is not here is looked for in a file of the user (`imo_analysis.equations.own`).

    Going through the catalogue gives the built-in ones alone.

    Raises
    ------
    InputError
        If a name is neither known nor a file from which an observer can be had.
    """

    def __missing__(self, kind: str) -> Observer:
        if not own.is_file(kind):
            raise InputError(f"observer = {kind!r} is not known; choose one of: {', '.join(self)}; or a file of your own, "
                             "mine.py")
        return own.load(kind, self)


OBSERVERS = Catalogue({
    o.name: o
    for o in (
        Observer("baseline", baseline.baseline,
                 ("i_ds_hat", "i_qs_hat", "phi_dr_hat", "phi_qr_hat", "omega_hat"), ("l_1", "l_2", "l_3", "l_4", "h"),
                 _flux_baseline, "(2)-(4)", "adaptive full-order observer of Kubota and Matsuse", False),
        Observer("baseline_scheduled", scheduled.baseline_scheduled,
                 ("i_ds_hat", "i_qs_hat", "phi_dr_hat", "phi_qr_hat", "omega_hat"), ("k", "h"),
                 _flux_baseline, "Kubota 1993", "the baseline with Kubota's gain, scheduled on its own speed", False),
        Observer("baseline_resistance", resistance.baseline_resistance,
                 ("i_ds_hat", "i_qs_hat", "phi_dr_hat", "phi_qr_hat", "omega_hat", "R_s_shift"),
                 ("l_1", "l_2", "l_3", "l_4", "h", "h_s"),
                 _flux_baseline, "not in the paper", "the baseline, which adapts the stator resistance as well", False),
        Observer("baseline_turned", resistance.baseline_turned,
                 ("i_ds_hat", "i_qs_hat", "phi_dr_hat", "phi_qr_hat", "omega_hat", "R_s_shift"),
                 ("l_1", "l_2", "l_3", "l_4", "h", "h_s", "P_0"),
                 _flux_baseline, "ours", "that one, whose law of the stator resistance turns round where it generates", False),
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
})
