"""(12): the error dynamics, row by row, derived from (6) and (8)."""

from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.settings import errors

_D = ("i_ds_tilde_dot = -(R_s/sigma + k_1)*i_ds_tilde - alpha_tilde*(1 + beta*L_m)*i_ds - omega_tilde*i_qs_hat - omega*i_qs_tilde"
      " + alpha*xi_1_tilde + alpha_tilde*xi_1_hat + omega*z_2_tilde + omega_tilde*z_2_hat")
_Q = ("i_qs_tilde_dot = -(R_s/sigma + k_1)*i_qs_tilde - alpha_tilde*(1 + beta*L_m)*i_qs {} omega_tilde*i_ds_hat {} omega*i_ds_tilde"
      " + alpha*xi_2_tilde + alpha_tilde*xi_2_hat - omega*z_1_tilde - omega_tilde*z_1_hat")

CLAIMS = [
    Claim(id="eq12.row1", item="(12)", title="rate of the d-axis current error", expected=Verdict.HOLDS,
          setting=errors(), printed=_D),
    Claim(id="eq12.row2", item="(12)", title="rate of the q-axis current error", expected=Verdict.CORRECTED,
          setting=errors(), printed=_Q.format("-", "-"), corrected=_Q.format("+", "+"),
          edit="the signs of omega_tilde i_ds_hat and of omega i_ds_tilde are plus", origin="paper",
          why="a scan does not turn two plus signs into minus signs in one row; the d-axis row was copied",
          consequences=("eq14",)),
    Claim(id="eq12.row3", item="(12)", title="rate of the first z error", expected=Verdict.CORRECTED,
          setting=errors("printed_7"),
          printed="z_1_tilde_dot = k_2*omega_hat*i_qs_tilde",
          prose="(12) is said to follow from (6) and (8).",
          checks=(Algebra("corrected", "with the z feedback that (12) needs in (8), it does",
                          ("z_1_tilde_dot = k_2*omega_hat*i_qs_tilde",), setting=errors()),
                  Algebra("evidence", "what the expanded (8) gives instead",
                          ("z_1_tilde_dot = k_2*omega_hat*i_ds_tilde",))),
          edit="in (8), the feedback of z_1_hat is -k_2 omega_hat i_qs_tilde", origin="paper",
          why="(7), the expanded (8) and L(omega_hat) print three patterns, of which none gives (12)"),
]
