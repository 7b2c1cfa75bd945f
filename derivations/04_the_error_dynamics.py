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
# # 4. The error dynamics
#
# True minus estimate: (6) minus (8). Nothing is left to choice here, so (12) can be computed and laid beside the print.

# %%
import sympy

from imo_analysis.derivation_tools import settled, show, symbols
from imo_analysis.equations import adaptive, plant
from imo_analysis.ledger.expression import evaluate, parse_relation
from imo_analysis.paper.contents import item

p = symbols("R_s L_m sigma beta alpha")
i, z, u, omega = symbols("i_ds i_qs"), symbols("z_1 z_2"), symbols("u_ds u_qs"), symbols("omega")[0]
which = ("i_ds", "i_qs", "z_1", "z_2", "xi_1", "xi_2", "alpha", "omega")
hats = dict(zip(which, symbols(" ".join(f"{one}_hat" for one in which)), strict=True))
tildes = dict(zip(which, symbols(" ".join(f"{one}_tilde" for one in which)), strict=True))
gains = symbols("k_1 k_2 k_3 g K_p alpha_l delta")

true = plant.plant_z((*i, *z), u, omega, 0, p)
true = (*true, *true[2:])
rates = adaptive.adaptive(tuple(hats.values()), i, u, p, gains, adaptive.feedback_consistent_12(
    tildes["i_ds"], tildes["i_qs"], gains[1], hats["omega"]), 1)

# %% [markdown]
# A product of a parameter and a state splits in one of two ways, e.g. $\omega z - \hat\omega\hat z = \omega\tilde z +
# \tilde\omega\hat z$. The printed rows keep estimates next to the parameter errors. To compare, estimates become true
# values minus errors on both sides:

# %%
base = {"i_ds": i[0], "i_qs": i[1], "z_1": z[0], "z_2": z[1], "xi_1": z[0], "xi_2": z[1], "alpha": p[4], "omega": omega}
in_errors = {hats[one]: base[one] - tildes[one] for one in which}
names = {str(one): one for one in (*i, *z, *u, *p, omega, *hats.values(), *tildes.values(), *gains)}
differences = {}
for number, row in enumerate(item("eq12").rows):
    printed = evaluate(parse_relation(row.text).right, names, lambda v: sympy.Rational(v.numerator, v.denominator))
    derived = true[number] - rates[number]
    differences[row.name] = sympy.factor(sympy.expand((printed - derived).subs(in_errors)))
    show(f"row {row.name}: printed minus derived", differences[row.name])

# %% [markdown]
# One row differs. In the q row two signs are those of the d row: the print has $-\tilde\omega\hat i_{ds} - \omega\tilde
# i_{ds}$ where both are plus. The slip is harmless: (14) and $A^*$ of (20) have the right signs, so nothing was built
# on it.

# %%
assert [name for name, value in differences.items() if value != 0] == ["i_qs"]
expected = -2 * (tildes["omega"] * hats["i_ds"] + omega * tildes["i_ds"])
assert sympy.expand(differences["i_qs"] - expected.subs(in_errors)) == 0
settled("eq12.")

# %% [markdown]
# In complex shorthand, with $v_1 = \hat\xi - (1 + \beta L_m) i$ and $v_2 = -j(\hat z - \hat i)$:
#
# $$\dot{\tilde i} = \left(-k_1 - \tfrac{R_s}{\sigma} + j\omega\right)\tilde i
# + \alpha\tilde\xi - j\omega\tilde z + v_1\tilde\alpha + v_2\tilde\omega$$
#
# $\tilde z$ and $\tilde\xi$ enter in one combination only, $w = \alpha\tilde\xi - j\omega\tilde z$. This line is the
# key to chapters 6 and 8.

# %%
settled("eq9.rho", "eq11.first")
