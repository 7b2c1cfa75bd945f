# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     name: python3
# ---

# %% [markdown]
# # 2. The transformation
#
# The speed is unknown, and in (1) it multiplies the fluxes, which are unknown too, in the currents' rows and in the fluxes'
# rows. After the change of coordinates (5) it stands in the currents' rows alone. That is what the observer lives on.

# %%
import sympy

from imo_analysis.derivation_tools import settled, show, symbols
from imo_analysis.equations import plant, transformation

R_s, L_m, sigma, beta, alpha = p = symbols("R_s L_m sigma beta alpha")
i_ds, i_qs, phi_dr, phi_qr, omega, omega_1 = symbols("i_ds i_qs phi_dr phi_qr omega omega_1")
u = symbols("u_ds u_qs")
z = symbols("z_1 z_2")
mu, n_p, J, T_l = symbols("mu n_p J T_l")

# %% [markdown]
# ## From (1) to (6)
#
# The rate of $z = i + \beta\phi$ is the rate of $i$ plus $\beta$ times that of $\phi$. Written in $i$ and $z$:

# %%
rates = plant.plant((i_ds, i_qs, phi_dr, phi_qr, omega), u, omega_1, T_l, (*p, mu, n_p, J))
flux = transformation.from_z(i_ds, i_qs, *z, beta)
in_z = {phi_dr: flux[0], phi_qr: flux[1]}
z_rates = [sympy.expand(sympy.expand((rates[k] + beta * rates[k + 2]).subs(in_z))) for k in (0, 1)]
show("The rates of z, in any frame:", *z_rates)

# %% [markdown]
# Two terms stay besides those of (6): $\omega_1 z_2$ and $-\omega_1 z_1$. In the stationary frame they vanish, and then
# the rates of $z$ are known from measurements alone. In any other frame they need $z$ itself. The definition
# `equations.plant.plant_z` has them:

# %%
defined = plant.plant_z((i_ds, i_qs, *z), u, omega, omega_1, p)
derived = (rates[0].subs(in_z), rates[1].subs(in_z), *z_rates)
assert all(sympy.cancel(a - b) == 0 for a, b in zip(defined, derived, strict=True))
settled("eq6.")

# %% [markdown]
# ## Back to the flux
#
# $\phi = (z - i)/\beta$ inverts (5). The paper reconstructs the flux in another way, from both copies of $z$: $\hat\phi
# = \frac1\beta \left[ (\hat\alpha - j\hat\omega)^{-1} (\hat\alpha \hat\xi - j \hat\omega \hat z) - i \right]$. With
# exact estimates the two agree, but with $\hat\alpha = \alpha$, $\hat\omega = \omega$ the second needs less: only that
# $w = \alpha\tilde\xi - j\omega\tilde z$ vanishes, not that $\tilde z$ and $\tilde\xi$ do.

# %%
z_tilde, xi_tilde = symbols("z_1_tilde z_2_tilde"), symbols("xi_1_tilde xi_2_tilde")
z_hat = [a - b for a, b in zip(z, z_tilde, strict=True)]
xi_hat = [a - b for a, b in zip(z, xi_tilde, strict=True)]
estimate = transformation.reconstructed_flux(i_ds, i_qs, *z_hat, *xi_hat, alpha, omega, beta)
error = [sympy.cancel(a - b) for a, b in zip(flux, estimate, strict=True)]
show("The error of the reconstructed flux:", *error)
w = (alpha * xi_tilde[0] + omega * z_tilde[1], alpha * xi_tilde[1] - omega * z_tilde[0])
assert sympy.cancel(beta * (alpha * error[0] + omega * error[1]) - w[0]) == 0
assert sympy.cancel(beta * (alpha * error[1] - omega * error[0]) - w[1]) == 0
print("It is (alpha - j omega)^-1 w / beta. Chapter 8 shows that w is all that can be made to vanish.")
settled("eq11.flux_d", "eq11.second")
