"""(6): the machine in the coordinates of (5)."""

from imo_analysis.ledger.claim import Claim, Verdict
from imo_analysis.ledger.settings import machine

_ROWS = (
    "i_ds_dot = -R_s/sigma*i_ds - alpha*(1 + beta*L_m)*i_ds - omega*i_qs + alpha*z_1 + omega*z_2 + u_ds/sigma",
    "i_qs_dot = -R_s/sigma*i_qs - alpha*(1 + beta*L_m)*i_qs + omega*i_ds + alpha*z_2 - omega*z_1 + u_qs/sigma",
    "z_1_dot = -R_s/sigma*i_ds + u_ds/sigma",
    "z_2_dot = -R_s/sigma*i_qs + u_qs/sigma",
)
_NAMES = ("d-axis current", "q-axis current", "first z", "second z")

CLAIMS = [
    Claim(
        id=f"eq06.row{number}", item="(6)", title=f"the {name} row follows from (1) and (5)", expected=Verdict.HOLDS,
        setting=machine(), printed=row, assumptions=("stationary frame, omega_1 = 0",),
    )
    for number, (row, name) in enumerate(zip(_ROWS, _NAMES, strict=True), 1)
]
