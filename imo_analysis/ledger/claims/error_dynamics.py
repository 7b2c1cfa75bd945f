"""(12): the error dynamics, row by row, derived from (6) and (8)."""

from __future__ import annotations

from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.transcript import claim, printed, same
from imo_analysis.ledger.settings import errors

_WHY_Z = "(7), the expanded (8) and L(omega_hat) print three feedbacks of z, of which none gives these rows"
_FALL = ("eq15.z", "proposition-IV.2")


def _z_row(name: str, from_rows: str, from_matrix: str) -> Claim:
    return claim(
        f"eq12.{name}",
        f"rate of the error of {name}",
        Verdict.CORRECTED,
        errors("printed_7"),
        checks=(
            Algebra("corrected", "with the feedback that it needs in (8)", (printed(f"eq12.{name}"),), setting=errors()),
            Algebra("evidence", "what the expanded (8) gives instead", (from_rows,)),
            Algebra("evidence", "what the matrix L(omega_hat) gives instead", (from_matrix,), setting=errors("printed_L")),
        ),
        edit="in (8), -k_2 omega_hat i_qs_tilde in the row of z_1_hat and +k_2 omega_hat i_ds_tilde in that of z_2_hat",
        prose="(12) is said to follow from (6) and (8).",
        origin="paper",
        why=_WHY_Z,
        consequences=_FALL,
    )


CLAIMS: list[Claim] = [
    claim("eq12.i_ds", "rate of the d-axis current error", Verdict.HOLDS, errors()),
    claim(
        "eq12.i_qs",
        "rate of the q-axis current error",
        Verdict.CORRECTED,
        errors(),
        corrected=same("eq12.i_qs", "- omega_tilde*i_ds_hat - omega*i_ds_tilde", "+ omega_tilde*i_ds_hat + omega*i_ds_tilde"),
        edit="plus for minus before omega_tilde i_ds_hat and before omega i_ds_tilde",
        origin="paper",
        why="the two signs are those of the d-axis row; rho_3 of (14) and A* of (20) have them right, so nothing is built "
        "on it",
    ),
    _z_row("z_1", "z_1_tilde_dot = k_2*omega_hat*i_ds_tilde", "z_1_tilde_dot = -k_2*omega_hat*i_qs_tilde"),
    _z_row("z_2", "z_2_tilde_dot = -k_2*omega_hat*i_qs_tilde", "z_2_tilde_dot = k_2*omega_hat*i_ds_tilde"),
    claim("eq12.xi_1", "rate of the error of xi_1, counted from z_1", Verdict.HOLDS, errors()),
    claim("eq12.xi_2", "rate of the error of xi_2, counted from z_2", Verdict.HOLDS, errors()),
]
