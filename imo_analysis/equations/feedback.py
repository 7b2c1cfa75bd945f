"""The feedback of the z loop, which the paper prints in three ways that contradict each other, and the repair.

Each takes the current errors, k_2 and the factor ``w``, and returns what is added to ``(z_1_hat', z_2_hat')``. The paper's
factor is omega_hat; the repaired observer's is the direction of rotation.
"""


def feedback_printed_7(i_ds_tilde, i_qs_tilde, k_2, w):
    """As in (7) and in the expanded (8)."""
    return -k_2 * w * i_ds_tilde, k_2 * w * i_qs_tilde


def feedback_printed_L(i_ds_tilde, i_qs_tilde, k_2, w):
    """As in the matrix L(omega_hat) of (8)."""
    return k_2 * w * i_qs_tilde, -k_2 * w * i_ds_tilde


def feedback_consistent_12(i_ds_tilde, i_qs_tilde, k_2, w):
    """As (12) needs it: the only one of the three for which the terms of (14) cancel."""
    return -k_2 * w * i_qs_tilde, k_2 * w * i_ds_tilde
