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
# # 5. The Lyapunov function and its derivative
#
# The idea of (13): give each error a weight such that everything but the damping of the currents cancels. The weights
# are not free. Take $V = \tfrac12|\tilde i|^2 + \tfrac{p_z}{2}|\tilde z|^2 + \tfrac{p_\xi}{2}|\tilde\xi|^2 + \dots$ and
# look at what has to cancel.

# %%
import sympy

from imo_analysis.derivation_tools import settled, show, symbols
from imo_analysis.equations import lyapunov, projection
from imo_analysis.ledger.dual import rate_along

names = ("i_ds_tilde i_qs_tilde z_1_tilde z_2_tilde xi_1_tilde xi_2_tilde alpha_tilde omega_tilde alpha omega omega_hat "
         "k_2 k_3 g K_p")
v = dict(zip(names.split(), symbols(names), strict=True))
i_d, i_q, z_1, z_2, xi_1, xi_2 = (v[one] for one in names.split()[:6])
p_z, p_xi = sympy.symbols("p_z p_xi", positive=True)

# %% [markdown]
# The currents' rows of (12) bring $\alpha\tilde\xi - j\omega\tilde z$; the rates of $\tilde z$ and $\tilde\xi$ are
# multiples of $\tilde i$.

# %%
w = lyapunov.observable(z_1, z_2, xi_1, xi_2, v["alpha"], v["omega"])
from_currents = i_d * w[0] + i_q * w[1]
z_rate = (v["k_2"] * v["omega_hat"] * i_q, -v["k_2"] * v["omega_hat"] * i_d)
xi_rate = (-v["k_3"] * i_d, -v["k_3"] * i_q)
cross = from_currents + p_z * (z_1 * z_rate[0] + z_2 * z_rate[1]) + p_xi * (xi_1 * xi_rate[0] + xi_2 * xi_rate[1])
weights = sympy.solve([sympy.expand(cross).coeff(z_2 * i_d), sympy.expand(cross).coeff(xi_1 * i_d)], [p_z, p_xi], dict=True)[0]
show("The weights that cancel all cross terms:", weights)
assert sympy.cancel(cross.subs(weights)) == 0
assert weights[p_z] == v["omega"] / (v["k_2"] * v["omega_hat"]) and weights[p_xi] == v["alpha"] / v["k_3"]

# %% [markdown]
# So $p_\xi = \alpha/k_3$, and (13) prints $\alpha/k_2$: with it, (13) has no unit and the terms do not cancel. And $p_z
# = \omega/(k_2\hat\omega)$ is no constant. It must be positive, so $\omega$ and $\hat\omega$ must have one sign, and
# when $\hat\omega$ moves, it moves too. With the two other feedbacks of chapter 3 there is no weight at all:

# %%
for name, other in (("(7)", (v["k_2"] * v["omega_hat"] * i_d, -v["k_2"] * v["omega_hat"] * i_q)),
                    ("L(omega_hat)", (-v["k_2"] * v["omega_hat"] * i_q, v["k_2"] * v["omega_hat"] * i_d))):
    rest = sympy.expand(from_currents + p_z * (z_1 * other[0] + z_2 * other[1]))
    unknown = [rest.coeff(z_2).coeff(i_d), rest.coeff(z_1).coeff(i_q), rest.coeff(z_1).coeff(i_d), rest.coeff(z_2).coeff(i_q)]
    solutions = sympy.solve([one for one in unknown if one != 0], p_z, dict=True)
    positive = [one for one in solutions if (one[p_z] * v["k_2"] * v["omega_hat"] / v["omega"]).is_positive]
    show(f"{name}: weights that cancel, positive for omega omega_hat > 0:", positive)
    assert not positive
settled("eq13.V", "eq15.")

# %% [markdown]
# ## The derivative, whole
#
# By dual numbers, with the rates left as names: this is $\dot V$, and its second term is the one that matters.

# %%
moving = [one for one in v if one.endswith("_tilde")] + ["omega_hat"]
rates = {one: sympy.Symbol(f"{one}_dot") for one in moving}
V_dot = rate_along(lyapunov.corrected_13, v, rates)
gain = V_dot.diff(rates["omega_hat"]) * rates["omega_hat"]
show("What the moving weight adds:", sympy.factor(gain))
target = -v["omega"] * rates["omega_hat"] / (2 * v["k_2"] * v["omega_hat"] ** 2) * (z_1**2 + z_2**2)
assert sympy.cancel(gain - target) == 0
settled("eq14.")

# %% [markdown]
# ## The alpha terms and the projection
#
# Away from its bound, (9) cancels the terms of $\tilde\alpha$. In the layer, the projection of a signal $\rho < 0$
# takes off $p\rho$, which leaves $\tilde\alpha\, p\, \rho / g \le 0$ as long as $\alpha \ge \hat\alpha$ there: as long
# as $\alpha_l \le \alpha$. The layer ends at $\alpha_l - \delta$, and that is where $\hat\alpha$ stops, not at
# $\alpha_l$.

# %%
alpha_l, delta, rho = symbols("alpha_l delta rho")
show("p at alpha_l and at alpha_l - delta:", projection.layer(alpha_l, alpha_l, delta),
     sympy.cancel(projection.layer(alpha_l - delta, alpha_l, delta)))
assert sympy.cancel(projection.layer(alpha_l - delta, alpha_l, delta)) == 1
settled("eq10.", "projection-keeps-bound", "projection-inequality.inequality")
