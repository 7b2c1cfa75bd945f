"""The smooth projection (10), written without a branch so that one definition serves symbols, lanes and floats."""


def positive_part(v):
    """max(v, 0)."""
    return (v + abs(v)) / 2


def layer(alpha_hat, alpha_l, delta):
    """p(alpha_hat) of (10): 0 at alpha_l, 1 at alpha_l - delta."""
    return (alpha_l * alpha_l - alpha_hat * alpha_hat) / (2 * delta * alpha_l - delta * delta)


def projection(rho, alpha_hat, alpha_l, delta):
    """Proj(rho, alpha_hat) of (10).

    rho where p <= 0 or rho >= 0, and (1 - p) rho otherwise. It keeps alpha_hat above alpha_l - delta, which is less than
    the alpha_l that the text promises.
    """
    return rho + positive_part(layer(alpha_hat, alpha_l, delta)) * positive_part(-rho)
