"""What the z and xi loops keep between them, in each of the paper's three conventions; ours.

Both loops are driven by the current errors alone, so two combinations of z_tilde and xi_tilde are not driven at all: with
omega_hat held they are conserved, and errors along them stay for ever. With omega_hat moving only their rates balance.
"""

from __future__ import annotations

from imo_analysis.ledger.claim import Claim, Verdict
from imo_analysis.ledger.settings import errors

ITEM = "Excitation (ours)"
_BALANCE = {
    "printed_7": ("k_3*z_1_tilde_dot = -k_2*omega_hat*xi_1_tilde_dot", "k_3*z_2_tilde_dot = k_2*omega_hat*xi_2_tilde_dot"),
    "printed_L": ("k_3*z_1_tilde_dot = k_2*omega_hat*xi_2_tilde_dot", "k_3*z_2_tilde_dot = -k_2*omega_hat*xi_1_tilde_dot"),
    "consistent_12": ("k_3*z_1_tilde_dot = -k_2*omega_hat*xi_2_tilde_dot", "k_3*z_2_tilde_dot = k_2*omega_hat*xi_1_tilde_dot"),
}
_WHERE = {"printed_7": "(7) and (8)", "printed_L": "L(omega_hat)", "consistent_12": "(12)"}

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
]
