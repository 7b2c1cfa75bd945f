"""The change of coordinates (5), its inverse, and the flux that the paper reconstructs below (11)."""


def to_z(i_ds, i_qs, phi_dr, phi_qr, beta):
    """``(z_1, z_2)`` of (5): i + beta phi, which is the stator flux over sigma."""
    return i_ds + beta * phi_dr, i_qs + beta * phi_qr


def from_z(i_ds, i_qs, z_1, z_2, beta):
    """``(phi_dr, phi_qr)``, the inverse of (5)."""
    return (z_1 - i_ds) / beta, (z_2 - i_qs) / beta


def reconstructed_flux(i_ds, i_qs, z_1_hat, z_2_hat, xi_1_hat, xi_2_hat, alpha_hat, omega_hat, beta):
    """``(phi_dr_hat, phi_qr_hat)`` below (11): [(alpha - j omega)^-1 (alpha xi - j omega z) - i] / beta, all estimates."""
    first = alpha_hat * xi_1_hat + omega_hat * z_2_hat
    second = alpha_hat * xi_2_hat - omega_hat * z_1_hat
    determinant = alpha_hat * alpha_hat + omega_hat * omega_hat
    return (
        ((alpha_hat * first - omega_hat * second) / determinant - i_ds) / beta,
        ((omega_hat * first + alpha_hat * second) / determinant - i_qs) / beta,
    )
