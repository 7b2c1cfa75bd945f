"""The numbered equations (8)-(13) as printed: the adaptive observer, its adaptation laws, its error dynamics, V."""

from __future__ import annotations

from imo_analysis.paper.item import Item, Row

_MATRIX_L = (
    r"L(\hat\omega) = \begin{bmatrix} k_1 & 0 & 0 & -k_2 \hat\omega & k_3 & 0 \\"
    r" 0 & k_1 & k_2 \hat\omega & 0 & 0 & k_3 \end{bmatrix}^T"
)

EQUATIONS_OBSERVER: tuple[Item, ...] = (
    Item(
        "eq8", "(8)", "Section III-B", "The adaptive observer, expanded and in matrix form.",
        (
            Row("i_ds", "i_ds_hat_dot = -R_s/sigma*i_ds_hat - alpha_hat*(1 + beta*L_m)*i_ds - omega_hat*i_qs_hat"
                " + alpha_hat*xi_1_hat + omega_hat*z_2_hat + k_1*(i_ds - i_ds_hat) + u_ds/sigma"),
            Row("i_qs", "i_qs_hat_dot = -R_s/sigma*i_qs_hat - alpha_hat*(1 + beta*L_m)*i_qs + omega_hat*i_ds_hat"
                " + alpha_hat*xi_2_hat - omega_hat*z_1_hat + k_1*(i_qs - i_qs_hat) + u_qs/sigma"),
            Row("z_1", "z_1_hat_dot = -R_s/sigma*i_ds - k_2*omega_hat*(i_ds - i_ds_hat) + u_ds/sigma"),
            Row("z_2", "z_2_hat_dot = -R_s/sigma*i_qs + k_2*omega_hat*(i_qs - i_qs_hat) + u_qs/sigma"),
            Row("xi_1", "xi_1_hat_dot = -R_s/sigma*i_ds + k_3*(i_ds - i_ds_hat) + u_ds/sigma"),
            Row("xi_2", "xi_2_hat_dot = -R_s/sigma*i_qs + k_3*(i_qs - i_qs_hat) + u_qs/sigma"),
            Row("matrix", latex=r"\dot{\hat x} = A(\hat\omega) \hat x + B u + L(\hat\omega) (y - \hat y), \quad \hat y = "
            r"C \hat x",
                scan="The matrices A(omega_hat) and B are lost; they are said to be given."),
            Row("L", latex=_MATRIX_L),
            Row("C", latex=r"C = \begin{bmatrix} 1 & 0 \\ 0 & 1 \\ 0 & 0 \\ 0 & 0 \\ 0 & 0 \\ 0 & 0 \end{bmatrix}^T"),
        ),
    ),
    Item(
        "eq9", "(9)", "Section III-B", "The adaptation of alpha: the projection of rho, rho being g times the bracket.",
        (Row("rho", "rho = g*(i_ds_tilde*(xi_1_hat - (1 + beta*L_m)*i_ds) + i_qs_tilde*(xi_2_hat - (1 + beta*L_m)*i_qs))"),),
    ),
    Item(
        "eq10", "(10)", "Section III-B", "The projection, by cases, and its layer function p.",
        (
            Row("layer", "p = (alpha_l**2 - alpha_hat**2)/(2*delta*alpha_l - delta**2)"),
            Row("cases", latex=r"\mathrm{Proj}\{\rho, \hat\alpha\} = \begin{cases} \rho & p \le 0 \\"
                r" \rho & p \ge 0,\ \rho \ge 0 \\ (1 - p) \rho & \text{otherwise} \end{cases}"),
        ),
    ),
    Item(
        "eq11", "(11)", "Section III-B", "The adaptation of the speed, in currents and z (first line) and in fluxes "
        "(second line).",
        (
            Row("first", "omega_hat_dot = K_p*direction*(-i_qs_hat*i_ds_tilde + i_ds_hat*i_qs_tilde + z_2_hat*i_ds_tilde"
                " - z_1_hat*i_qs_tilde)",
                scan="The left side shows omega with a dot and no hat; the sentence before calls it the law for the estimate. "
                "Proj appears here with one argument, so its second one and its bounds are not told; read as the identity. "
                "direction stands for Sign(omega)."),
            Row("second", "omega_hat_dot = K_p*direction*beta*(i_ds_tilde*phi_qr_hat - i_qs_tilde*phi_dr_hat)"),
            Row("flux_d", latex=r"\begin{bmatrix} \hat\phi_{dr} \\ \hat\phi_{qr} \end{bmatrix} = \frac{1}{\beta}"
                r"\begin{bmatrix} \hat\alpha & \hat\omega \\ -\hat\omega & \hat\alpha \end{bmatrix}^{-1}"
                r"\begin{bmatrix} \hat\alpha \hat\xi_1 + \hat\omega \hat z_2 \\ \hat\alpha \hat\xi_2 - \hat\omega \hat z_1"
                r"\end{bmatrix} - \frac{1}{\beta} \begin{bmatrix} i_{ds} \\ i_{qs} \end{bmatrix}"),
        ),
    ),
    Item(
        "eq12", "(12)", "Section IV-A", "The error dynamics.",
        (
            Row("i_ds", "i_ds_tilde_dot = -(R_s/sigma + k_1)*i_ds_tilde - alpha_tilde*(1 + beta*L_m)*i_ds - "
            "omega_tilde*i_qs_hat"
                " - omega*i_qs_tilde + alpha*xi_1_tilde + alpha_tilde*xi_1_hat + omega*z_2_tilde + omega_tilde*z_2_hat"),
            Row("i_qs", "i_qs_tilde_dot = -(R_s/sigma + k_1)*i_qs_tilde - alpha_tilde*(1 + beta*L_m)*i_qs - "
            "omega_tilde*i_ds_hat"
                " - omega*i_ds_tilde + alpha*xi_2_tilde + alpha_tilde*xi_2_hat - omega*z_1_tilde - omega_tilde*z_1_hat"),
            Row("z_1", "z_1_tilde_dot = k_2*omega_hat*i_qs_tilde"),
            Row("z_2", "z_2_tilde_dot = -k_2*omega_hat*i_ds_tilde"),
            Row("xi_1", "xi_1_tilde_dot = -k_3*i_ds_tilde"),
            Row("xi_2", "xi_2_tilde_dot = -k_3*i_qs_tilde"),
        ),
    ),
    Item(
        "eq13", "(13)", "Section IV-A", "The Lyapunov function.",
        (Row("V", "V = (i_ds_tilde**2 + i_qs_tilde**2)/2 + omega/(2*k_2*omega_hat)*(z_1_tilde**2 + z_2_tilde**2)"
             " + alpha/(2*k_2)*(xi_1_tilde**2 + xi_2_tilde**2) + alpha_tilde**2/(2*g) + omega_tilde**2/(2*K_p)"),),
    ),
)
