"""What the z and xi loops keep between them, in each of the paper's three conventions; ours.

Both loops are driven by the current errors alone, so two combinations of z_tilde and xi_tilde are not driven at all: with
omega_hat held they are conserved, and errors along them stay for ever. With omega_hat moving only their rates balance.
"""

from __future__ import annotations

from imo_analysis.equations import across, lyapunov, plant, quiet, repaired, supervised
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.model import baseline_errors
from imo_analysis.ledger.claims.noise import free_share, instead
from imo_analysis.ledger.expression import Name, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS, FULL, GAINS, MACHINE, VOLTAGES, errors, luenberger_errors

ITEM = "Excitation (ours)"
_BALANCE = {
    "printed_7": ("k_3*z_1_tilde_dot = -k_2*omega_hat*xi_1_tilde_dot", "k_3*z_2_tilde_dot = k_2*omega_hat*xi_2_tilde_dot"),
    "printed_L": ("k_3*z_1_tilde_dot = k_2*omega_hat*xi_2_tilde_dot", "k_3*z_2_tilde_dot = -k_2*omega_hat*xi_1_tilde_dot"),
    "consistent_12": ("k_3*z_1_tilde_dot = -k_2*omega_hat*xi_2_tilde_dot", "k_3*z_2_tilde_dot = k_2*omega_hat*xi_1_tilde_dot"),
}
_WHERE = {"printed_7": "(7) and (8)", "printed_L": "L(omega_hat)", "consistent_12": "(12)"}


def _copies(kind: str, noisy: bool = False) -> Setting:
    """The rates of the z and xi errors in one of our observers, with q and its rate; kappa and the direction constant.

    ``noisy`` adds (n_1, n_2) to the measured current.
    """
    module = {"repaired": repaired, "quiet": quiet, "across": across, "supervised": supervised}[kind]
    gains = (GAINS[0], Name("kappa"), *GAINS[2:], *names("eta S_0"))
    state = (*FULL, *names("m_1d m_1q m_2d m_2q S"))
    size = 13 if kind == "supervised" else 8
    n = names("n_1 n_2")
    measured = (CURRENTS[0] + n[0], CURRENTS[1] + n[1]) if noisy else CURRENTS
    with instead(across, share=free_share), instead(supervised, share=free_share):
        row = getattr(module, kind)(state[:size], measured, VOLTAGES, Name("direction"), MACHINE,
                                    gains if kind == "supervised" else gains[:7])
    true = plant.plant_z((*CURRENTS, *names("z_1 z_2")), VOLTAGES, Name("omega"), 0, MACHINE)
    rates = {f"{name}_tilde_dot": true[2 + k % 2] - row[2 + k] for k, name in enumerate(("z_1", "z_2", "xi_1", "xi_2"))}
    q = lyapunov.conserved(*(Name(f"{one}_tilde_dot") for one in ("z_1", "z_2", "xi_1", "xi_2")),
                           *names("kappa k_3 direction"))
    text = f"the machine (6) and the observer `{kind}`, whatever omega, alpha and their estimates do"
    return setting(f"copies_{kind}{'_noisy' if noisy else ''}", text,
                   {**rates, "q_1_dot": q[0], "q_2_dot": q[1]}, ("sigma > 0",), ({"direction": 1}, {"direction": -1}),
                   {"q_1_dot": "A/s^2", "q_2_dot": "A/s^2", "m_1d": "A", "m_1q": "A", "m_2d": "A", "m_2q": "A", "S": "A^2",
                    "S_0": "A^2", "eta": "1/s", "c": "1", "n_1": "A", "n_2": "A"})


def _seen(convention: str) -> Setting:
    """The observer (7) with no current error and the speed right: what its z error does to the current."""
    base = luenberger_errors(convention)
    still = {"i_ds_tilde": 0, "i_qs_tilde": 0, "omega_tilde": 0}
    return setting(f"seen_{convention}", base.text + ", no current error and no speed error", {**still, **base.definitions},
                   (*base.hypotheses, "alpha > 0"), base.cases, base.units)


def _seen_by_the_baseline() -> Setting:
    """The baseline (2)-(4) with no current error and the speed right: what its flux error does to the current."""
    base = baseline_errors()
    still = {"i_ds_tilde": 0, "i_qs_tilde": 0, "omega_tilde": 0}
    return setting("seen_baseline", base.text + ", no current error and no speed error", {**base.definitions, **still},
                   (*base.hypotheses, "alpha > 0"), base.cases, base.units)


CLAIMS: list[Claim] = [
    Claim(
        id=f"excitation.kept_{convention}",
        item=ITEM,
        title=f"what the z and xi loops keep between them, with the z feedback of {where}",
        expected=Verdict.HOLDS,
        setting=errors(convention),
        printed=_BALANCE[convention],
        prose="Two combinations of z_tilde and xi_tilde are driven by nothing: with omega_hat held they are conserved. For the "
              "repaired observer q is conserved whatever omega_hat does (proposition-IV.3); the baseline has one copy of the "
              "flux and no such combination.",
    )
    for convention, where in _WHERE.items()
] + [
    Claim(
        id=f"excitation.kept_{kind}",
        item=ITEM,
        title=f"what the z and xi loops of `{kind}` conserve",
        expected=Verdict.HOLDS,
        setting=_copies(kind),
        printed=("q_1_dot = 0", "q_2_dot = 0"),
        prose="q = k_3 z_tilde - j kappa s xi_tilde stands still whatever the speed, alpha and their estimates do: errors "
              "along w = 0 stay for ever.",
    )
    for kind in ("repaired", "quiet", "across", "supervised")
] + [
    Claim(
        id="excitation.walk",
        item=ITEM,
        title="what is conserved without noise walks with it",
        expected=Verdict.HOLDS,
        setting=_copies("across", noisy=True),
        printed=("q_1_dot = R_s/sigma*(k_3*n_1 + kappa*direction*n_2)", "q_2_dot = R_s/sigma*(k_3*n_2 - kappa*direction*n_1)"),
        prose="Noise n on the measured current is integrated by q, with nothing to bring it back: q' = (R_s/sigma) (k_3 - j "
              "kappa s) n.",
        note="With white noise the offsets of z_hat and xi_hat that belong to q grow as the root of time. While the speed "
             "stands still no current shows them; when it changes w = 0 asks for others, and they reach alpha_hat.",
        checks=(
            Algebra("evidence", "the same for the repaired observer",
                    ("q_1_dot = R_s/sigma*(k_3*n_1 + kappa*direction*n_2)",
                     "q_2_dot = R_s/sigma*(k_3*n_2 - kappa*direction*n_1)"), setting=_copies("repaired", noisy=True)),
        ),
    ),
] + [
    Claim(
        id=f"excitation.kept_luenberger_{convention}",
        item=ITEM,
        title=f"with one copy of the flux nothing is conserved, with the z feedback of {where}",
        expected=Verdict.HOLDS,
        setting=_seen(convention),
        printed=("alpha*i_ds_tilde_dot - omega*i_qs_tilde_dot = (alpha**2 + omega**2)*z_1_tilde",
                 "alpha*i_qs_tilde_dot + omega*i_ds_tilde_dot = (alpha**2 + omega**2)*z_2_tilde"),
        prose="With known alpha and the speed right every z_tilde moves the current, so that no direction is hidden for good.",
    )
    for convention, where in _WHERE.items()
] + [
    Claim(
        id="excitation.kept_baseline",
        item=ITEM,
        title="the baseline conserves nothing",
        expected=Verdict.HOLDS,
        setting=_seen_by_the_baseline(),
        printed=("alpha*i_ds_tilde_dot - omega*i_qs_tilde_dot = beta*(alpha**2 + omega**2)*phi_dr_tilde",
                 "alpha*i_qs_tilde_dot + omega*i_ds_tilde_dot = beta*(alpha**2 + omega**2)*phi_qr_tilde"),
        prose="With the speed right every error of the flux moves the current, whatever the gains, Kubota's too.",
    ),
]
