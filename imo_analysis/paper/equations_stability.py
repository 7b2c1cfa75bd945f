"""The numbered equations (14)-(23) as printed: the derivative of V and what is concluded from it."""

from __future__ import annotations

from imo_analysis.paper.item import Item, Row

_BRACE = "The names under the braces are partly unreadable; "

EQUATIONS_STABILITY: tuple[Item, ...] = (
    Item(
        "eq14", "(14)", "Section IV-A", "The derivative of V, term by term (each row is one term of the sum).",
        (
            Row("current", "term_current = -(k_1 + R_s/sigma)*(i_ds_tilde**2 + i_qs_tilde**2)"),
            Row("gain", "term_gain = -omega_dot/omega_hat**2*omega/(2*k_2)*(z_1_tilde**2 + z_2_tilde**2)"),
            Row("rho_1", "term_rho_1 = i_ds_tilde*alpha_tilde*(xi_1_hat - (1 + beta*L_m)*i_ds)"
                " + i_qs_tilde*alpha_tilde*(xi_2_hat - (1 + beta*L_m)*i_ds)"),
            Row("rho_2", "term_rho_2 = alpha*i_ds_tilde*xi_1_tilde + i_ds_tilde*omega*z_2_tilde + alpha*i_qs_tilde*xi_2_tilde"
                " - i_qs_tilde*omega*z_1_tilde"),
            Row("rho_3", "term_rho_3 = -omega_tilde*i_qs_hat*i_ds_tilde + omega_tilde*i_ds_hat*i_qs_tilde"
                " + omega_tilde*z_2_hat*i_ds_tilde - omega_tilde*z_1_hat*i_qs_tilde",
                scan=_BRACE + "the first minus stands before the brace, at a break of the line; read as the sign of the "
                "first term, as (11) and (12) have it."),
            Row("z", "term_z = omega/(k_2*omega_hat)*(z_1*z_1_dot + z_2*z_2_dot)",
                scan=_BRACE + "in (15) the same term carries a tilde under the dot, so the tilde there may be lost in the "
                "scan."),
            Row("xi", "term_xi = alpha/k_3*(xi_1*xi_1_dot + xi_2*xi_2_dot)",
                scan=_BRACE + "the factor is unreadable and taken from (15)."),
            Row("alpha", "term_alpha = alpha_tilde*alpha_dot/g", scan="A tilde under the dot may be lost in the scan."),
            Row("omega", "term_omega = omega_tilde*omega_dot/g", scan="A tilde under the dot may be lost in the scan; 1/g "
            "is clear."),
        ),
    ),
    Item(
        "eq15", "(15)", "Section IV-A", "The z and xi terms cancel rho_2.",
        (
            Row("z", "omega/(k_2*omega_hat)*(z_1*z_1_tilde_dot + z_2*z_2_tilde_dot)"
                " = -i_ds_tilde*omega*z_2_tilde + i_qs_tilde*omega*z_1_tilde",
                scan="No tilde is seen on the first factors z_1 and z_2."),
            Row("xi", "alpha/k_3*(xi_1*xi_1_tilde_dot + xi_2*xi_2_tilde_dot)"
                " = -alpha*i_ds_tilde*xi_1_tilde - alpha*i_qs_tilde*xi_2_tilde",
                scan="No tilde is seen on the first factors xi_1 and xi_2."),
        ),
    ),
    Item(
        "eq16", "(16)", "Section IV-A", "The bound on the derivative of V.",
        (Row("bound", "V_dot <= -(k_1 + R_s/sigma)*(i_ds_tilde**2 + i_qs_tilde**2)"),),
    ),
    Item(
        "eq17", "(17)", "Section IV-A", "The bound (16), integrated.",
        (Row("integral", latex=r"-\int_0^t \dot V \,d\tau \ge \left(k_1 + \frac{R_s}{\sigma}\right)"
             r"\int_0^t (\tilde i_{ds}^2 + \tilde i_{qs}^2)\, d\tau"),),
    ),
    Item(
        "eq18", "(18)", "Section IV-A", "A bound on the integral of the squared current error.",
        (Row("integral", latex=r"\int_0^t (\tilde i_{ds}^2 + \tilde i_{qs}^2)\, d\tau \le"
             r"\left(k_1 + \frac{R_s}{\sigma}\right) V(0)"),),
    ),
    Item(
        "eq19", "(19)", "Section IV-A", "The persistency-of-excitation condition and its matrix B*.",
        (
            Row("condition", latex=r"\int_t^{t+T} B^{*T}(\tau) B^*(\tau)\, d\tau \ge m I_{6 \times 6}"),
            Row("B.1", latex=r"\begin{bmatrix} \alpha & 0 & 0 & \varphi & \hat\xi_1 - (1 + \beta L_m) i_{ds} &"
                r"\hat z_2 - \hat i_{qs} \end{bmatrix}", scan="varphi appears where (12) has omega; the paper's or the "
                "scan's."),
            Row("B.2", latex=r"\begin{bmatrix} 0 & \alpha & -\varphi & 0 & \hat\xi_2 - (1 + \beta L_m) i_{qs} &"
                r"\hat z_1 - \hat i_{ds} \end{bmatrix}", scan="varphi as above."),
        ),
    ),
    Item(
        "eq20", "(20)", "Section IV-A", "The error dynamics in compact form.",
        (
            Row("S", latex=r"\dot S = A^* S + B^* Z", scan="The dot over S is not seen; (21) prints it."),
            Row("Z", latex=r"\dot Z = D^* S"),
            Row("A", latex=r"A^* = \begin{bmatrix} -\frac{R_s}{\sigma} - k_1 & -\omega \\ \omega & -\frac{R_s}{\sigma} - k_1"
                r"\end{bmatrix}"),
        ),
    ),
    Item(
        "eq21", "(21)", "Section IV-B", "The compact error dynamics when the speed varies.",
        (
            Row("S", latex=r"\dot S = A^* S + B^* Z"),
            Row("Z", latex=r"\dot Z = D^* S + E^* \dot\omega"),
            Row("E", latex=r"E^* = \begin{bmatrix} 0 & 0 & 0 & 0 & 1 \end{bmatrix}^T"),
        ),
    ),
    Item(
        "eq22", "(22)", "Section IV-B", "The assumed bound on the acceleration.",
        (Row("bound", latex=r"\| \dot\omega \|_\infty \le M_1 < \infty"),),
    ),
    Item(
        "eq23", "(23)", "Section IV-B", "The concluded bound on the speed error.",
        (Row("bound", latex=r"\| \tilde\omega(t) \| \le K_1 \| \tilde\omega(0) \| + K_2, \quad t \ge 0"),),
    ),
)
