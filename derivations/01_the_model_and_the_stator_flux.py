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
# # 1. The model, and what z is
#
# Two coupled windings a phase, stator and rotor, give five equations, (1). Everything that follows rests on them, so they
# come first: from Kirchhoff's and Faraday's laws, with the parameters of Table I.

# %%
import sympy

from imo_analysis.derivation_tools import settled, show, symbols
from imo_analysis.equations import parameters, plant, transformation
from imo_analysis.machine import PRESETS

R_s, R_r, L_s, L_m, L_r, J = symbols("R_s R_r L_s L_m L_r J")
i_ds, i_qs, phi_dr, phi_qr, omega, omega_1 = symbols("i_ds i_qs phi_dr phi_qr omega omega_1")
u_ds, u_qs, T_l, n_p = symbols("u_ds u_qs T_l n_p")

# %% [markdown]
# ## Flux linkages
#
# With currents of stator and rotor $i_s, i_r$ in two-phase form, the linkages are $\psi_s = L_s i_s + L_m i_r$ and
# $\phi_r = L_r i_r + L_m i_s$. The rotor current is not measured; it goes out:

# %%
sigma = parameters.leakage(L_s, L_m, L_r)
i_dr = (phi_dr - L_m * i_ds) / L_r
psi_ds = L_s * i_ds + L_m * i_dr
show("The stator's linkage is sigma times the current plus the rotor's linkage times L_m / L_r:", sympy.expand(psi_ds))
assert sympy.cancel(psi_ds - (sigma * i_ds + L_m / L_r * phi_dr)) == 0

# %% [markdown]
# ## Voltages
#
# In a frame that turns at $\omega_1$: $\dot\psi_s = u_s - R_s i_s - j \omega_1 \psi_s$ for the stator, and $\dot\phi_r
# = -R_r i_r - j (\omega_1 - \omega) \phi_r$ for the rotor, which is shorted and turns at the electrical speed $\omega$.
# The definition `equations.plant.plant`, which the simulator compiles, must satisfy both when it is fed symbols:

# %%
alpha = parameters.rotor_rate(R_r, L_r)
beta = parameters.coupling(L_m, sigma, L_r)
mu = parameters.torque_gain(n_p, L_m, L_r, J)
state = (i_ds, i_qs, phi_dr, phi_qr, omega)
rates = plant.plant(state, (u_ds, u_qs), omega_1, T_l, (R_s, L_m, sigma, beta, alpha, mu, n_p, J))

psi_qs = sigma * i_qs + L_m / L_r * phi_qr
i_qr = (phi_qr - L_m * i_qs) / L_r
laws = (
    sigma * rates[0] + L_m / L_r * rates[2] - (u_ds - R_s * i_ds + omega_1 * psi_qs),
    sigma * rates[1] + L_m / L_r * rates[3] - (u_qs - R_s * i_qs - omega_1 * psi_ds),
    rates[2] - (-R_r * i_dr + (omega_1 - omega) * phi_qr),
    rates[3] - (-R_r * i_qr - (omega_1 - omega) * phi_dr),
)
assert all(sympy.cancel(law) == 0 for law in laws)
print("Both laws hold, row by row, for any omega_1. The printed rows are the same:")
settled("eq1.i_ds", "eq1.i_qs", "eq1.phi_dr", "eq1.phi_qr")

# %% [markdown]
# ## The shaft, and a slip in Table I
#
# Torque is $\tfrac32 n_p \tfrac{L_m}{L_r} (\phi_{dr} i_{qs} - \phi_{qr} i_{ds})$, and $\omega$ is $n_p$ times the speed
# of the shaft. So the electrical acceleration has $n_p^2/J$ in $\mu$ and $n_p$ at the load. Table I prints $\mu = 3 L_m
# / (2 L_r)$, a pure number, where (1) needs $1/(\mathrm{kg\,m^2})$.

# %%
torque = plant.torque(state, n_p, L_m, L_r)
assert sympy.cancel(rates[4] - n_p * (torque - T_l) / J) == 0
show("mu, as Newton's law has it:", mu)
settled("eq1.omega", "table1.")

# %% [markdown]
# ## What z is
#
# (5) defines $z = i + \beta \phi$ by its use. It is a quantity of its own: $\sigma z = \sigma i + (L_m/L_r) \phi$ is
# the stator's flux linkage. That is why its rate in (6) has neither $\alpha$ nor $\omega$ in it: it is the stator's
# voltage law.

# %%
z_1, z_2 = transformation.to_z(i_ds, i_qs, phi_dr, phi_qr, beta)
assert sympy.cancel(sigma * z_1 - psi_ds) == 0 and sympy.cancel(sigma * z_2 - psi_qs) == 0
settled("eq5.", "z-needs-measurements-only")

# %% [markdown]
# ## Numbers
#
# Table III's machine, twice: $R_r/L_r$ of its own resistances is 6.62 /s, and the printed $\alpha$ is one and a half
# times that.

# %%
for name, machine in PRESETS.items():
    print(f"{name}: sigma = {1e3 * machine.sigma:.4f} mH, alpha = {machine.alpha:.4f} /s, beta = {machine.beta:.2f} /H, "
          f"gamma = {machine.gamma:.2f} /s, mu = {machine.mu:.2f} /(kg m^2)")
settled("table3")
