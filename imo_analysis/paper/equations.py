"""The numbered equations (1)-(23) as the paper prints them, row by row, slips included.

Frame and suffixes as in `notation`. Two damages of the scan run through many rows and are repaired without a further word:
the letter i under a tilde is often read as t, and a hat or tilde over a Greek letter is sometimes set in bold. Everything
else that the scan loses or changes is said in ``scan``. (8)-(13) and (14)-(23) follow in `equations_observer` and
`equations_stability`.
"""

from __future__ import annotations

from imo_analysis.paper.item import Item, Row

EQUATIONS_MODEL: tuple[Item, ...] = (
    Item(
        "eq1", "(1)", "Section II-A", "The machine in a frame that turns at omega_1.",
        (
            Row("i_ds", "i_ds_dot = -gamma*i_ds + omega_1*i_qs + beta*(alpha*phi_dr + omega*phi_qr) + u_ds/sigma"),
            Row("i_qs", "i_qs_dot = -gamma*i_qs - omega_1*i_ds + beta*(alpha*phi_qr - omega*phi_dr) + u_qs/sigma"),
            Row("phi_dr", "phi_dr_dot = -alpha*phi_dr + (omega_1 - omega)*phi_qr + alpha*L_m*i_ds"),
            Row("phi_qr", "phi_qr_dot = -alpha*phi_qr - (omega_1 - omega)*phi_dr + alpha*L_m*i_qs"),
            Row("omega", "omega_dot = mu*(phi_dr*i_qs - phi_qr*i_ds) - T_l/J"),
        ),
    ),
    Item(
        "eq2", "(2)", "Section II-B", "The machine with the speed as a parameter, in matrix form, omega_1 = 0.",
        (
            Row("A.1", "i_ds_dot = -gamma*i_ds + alpha*beta*phi_dr + beta*omega*phi_qr + u_ds/sigma"),
            Row("A.2", "i_qs_dot = -gamma*i_qs - beta*omega*phi_dr + alpha*beta*phi_qr + u_qs/sigma"),
            Row("A.3", "phi_dr_dot = alpha*L_m*i_ds - alpha*phi_dr - omega*phi_qr"),
            Row("A.4", "phi_qr_dot = alpha*L_m*i_qs + omega*phi_dr - alpha*phi_qr"),
            Row("B", latex=r"B' = \begin{bmatrix} \frac{1}{\sigma} & 0 \\ 0 & \frac{1}{\sigma} \\ 0 & 0 \\ 0 & 0 "
            r"\end{bmatrix}^T"),
            Row("C", latex=r"C' = \begin{bmatrix} 1 & 0 \\ 0 & 1 \\ 0 & 0 \\ 0 & 0 \end{bmatrix}^T"),
        ),
    ),
    Item(
        "eq3", "(3)", "Section II-B", "The baseline observer: a copy of (2) at the estimated speed with an output feedback L.",
        (Row("observer", latex=r"\text{(not in the scan)}", scan="The display is lost. The text around it names L, the "
        "estimate "
             "of x' and A' at the estimated speed, so a copy of (2) with L (y - y_hat) is the natural reading."),),
    ),
    Item(
        "eq4", "(4)", "Section II-B", "The speed law of the baseline observer.",
        (Row("omega_hat", "omega_hat_dot = h*beta*(i_ds_tilde*phi_qr_hat - i_qs_tilde*phi_dr_hat)"),),
    ),
    Item(
        "eq5", "(5)", "Section III-A", "The new coordinates.",
        (Row("z_1", "z_1 = i_ds + beta*phi_dr"), Row("z_2", "z_2 = i_qs + beta*phi_qr")),
    ),
    Item(
        "eq6", "(6)", "Section III-A", "The machine in the new coordinates.",
        (
            Row("i_ds", "i_ds_dot = -R_s/sigma*i_ds - alpha*(1 + beta*L_m)*i_ds - omega*i_qs + alpha*z_1 + omega*z_2"
                " + u_ds/sigma"),
            Row("i_qs", "i_qs_dot = -R_s/sigma*i_qs - alpha*(1 + beta*L_m)*i_qs + omega*i_ds + alpha*z_2 - omega*z_1"
                " + u_qs/sigma"),
            Row("z_1", "z_1_dot = -R_s/sigma*i_ds + u_ds/sigma"),
            Row("z_2", "z_2_dot = -R_s/sigma*i_qs + u_qs/sigma"),
        ),
    ),
    Item(
        "eq7", "(7)", "Section III-A", "The Luenberger observer with known alpha.",
        (
            Row("i_ds", "i_ds_hat_dot = -R_s/sigma*i_ds_hat - alpha*(1 + beta*L_m)*i_ds - omega_hat*i_qs_hat + alpha*z_1_hat"
                " + omega_hat*z_2_hat + k_1*(i_ds - i_ds_hat) + u_ds/sigma",
                scan="The dot over i_hat on the left is read as a second hat; as in the row below it is a dot."),
            Row("i_qs", "i_qs_hat_dot = -R_s/sigma*i_qs_hat - alpha*(1 + beta*L_m)*i_qs + omega_hat*i_ds_hat + alpha*z_2_hat"
                " - omega_hat*z_1_hat + k_1*(i_qs - i_qs_hat) + u_qs/sigma"),
            Row("z_1", "z_1_hat_dot = -R_s/sigma*i_ds - k_2*omega_hat*(i_ds - i_ds_hat) + u_ds/sigma"),
            Row("z_2", "z_2_hat_dot = -R_s/sigma*i_qs + k_2*omega_hat*(i_qs - i_qs_hat) + u_qs/sigma"),
        ),
    ),
)
