"""The regressor B* of the persistency-of-excitation condition (19), as printed and as (12) needs it, and the reduced one.

Columns of B* belong to the errors (xi_1, xi_2, z_1, z_2, alpha, omega), its rows to the d and q currents; ``alpha`` and
``omega`` are the values that stand in it (the proposition means the true ones). The print has varphi for omega.
"""


def alpha_direction(i, xi_hat, beta, L_m):
    """``v_1``, the effect of alpha_tilde on the current rows: xi_hat - (1 + beta L_m) i, in A."""
    return xi_hat[0] - (1 + beta * L_m) * i[0], xi_hat[1] - (1 + beta * L_m) * i[1]


def speed_direction(i_hat, z_hat):
    """``v_2``, the effect of omega_tilde on the current rows: -j (z_hat - i_hat), in A."""
    return z_hat[1] - i_hat[1], i_hat[0] - z_hat[0]


def printed_19(i, i_hat, z_hat, xi_hat, alpha, omega, beta, L_m):
    """The two rows of B* as printed: the last entry of the second row has the sign of the first row's."""
    v_1 = alpha_direction(i, xi_hat, beta, L_m)
    return (
        (alpha, 0, 0, omega, v_1[0], z_hat[1] - i_hat[1]),
        (0, alpha, -omega, 0, v_1[1], z_hat[0] - i_hat[0]),
    )


def corrected_19(i, i_hat, z_hat, xi_hat, alpha, omega, beta, L_m):
    """The two rows of B* that follow from (6) and (8)."""
    v_1 = alpha_direction(i, xi_hat, beta, L_m)
    v_2 = speed_direction(i_hat, z_hat)
    return (alpha, 0, 0, omega, v_1[0], v_2[0]), (0, alpha, -omega, 0, v_1[1], v_2[1])


def reduced(i, i_hat, z_hat, xi_hat, alpha, omega, beta, L_m):
    """The two rows of [I, v_1, v_2], for the errors (w_1, w_2, alpha, omega) with w = alpha xi_tilde - j omega z_tilde.

    ``alpha`` and ``omega`` are not used; they are there so that the three regressors are called alike.
    """
    v_1 = alpha_direction(i, xi_hat, beta, L_m)
    v_2 = speed_direction(i_hat, z_hat)
    return (1, 0, v_1[0], v_2[0]), (0, 1, v_1[1], v_2[1])
