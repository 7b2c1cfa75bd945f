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
# # Lesson 2. From equations to a pencil
#
# **Goals.** Freeze the speed and see a linear system. Pair its four real states to two complex ones, and find its poles
# on paper. Get the same poles, and an observer's, from the definitions as a `control.StateSpace`.
#
# **Needs.** Lesson 1. Eigenvalues; what a Luenberger observer is: a copy of the plant, corrected by its output error.
#
# **Time.** About 20 minutes.

# %%
import numpy as np
import sympy

from imo_analysis.course_tools import check, expected, rows, vary
from imo_analysis.derivation_tools import show, symbols
from imo_analysis.equations import baseline, plant
from imo_analysis.ledger.expression import names
from imo_analysis.machine import PRESETS
from imo_analysis.pencils.error import frozen_matrix, frozen_pencil
from imo_analysis.pencils.setup import Setup
from imo_analysis.pencils.sweep import pole_sweep
from imo_analysis.study import Study

machine = PRESETS["table-iii-printed-alpha"]

# %% [markdown]
# ## Freeze the slow thing
#
# (1) is nonlinear in one way only: the speed multiplies fluxes. The shaft needs a tenth of a second to change its speed,
# the current a few milliseconds. So hold $\omega$ still, and what is left is linear. As $\omega$ is then a parameter, we
# get a family of systems, one for each speed: a **pencil**. It answers "how do errors die out while the speed stays as it
# is?", and nothing about what happens when the speed estimate itself moves. Keep that in mind; lesson 6 comes back to it.
#
# The matrix is the Jacobian of the definition, row by row:

# %%
R_s, L_m, sigma, beta, alpha = p = symbols("R_s L_m sigma beta alpha")
omega = symbols("omega")[0]
x = symbols("i_ds i_qs phi_dr phi_qr")
rates = plant.plant((*x, omega), (0, 0), 0, 0, (*p, 0, 1, 1))[:4]
A = sympy.ImmutableMatrix(4, 4, lambda row, column: sympy.expand(rates[row]).coeff(x[column]))
show("A'(omega) of (2):", A)

# %% [markdown]
# ## Four real states are two complex ones
#
# Look at the pattern: every 2x2 block is $\begin{bmatrix} a & -b \\ b & a \end{bmatrix}$, which is multiplication by $a +
# jb$. The machine has no preferred direction, so turning everything by an angle changes nothing, and such blocks are all
# that is allowed. Writing $i = i_d + j i_q$, $\phi = \phi_d + j\phi_q$ halves the size (sympy writes $i$ for $j$):

# %%
j = sympy.I
C = sympy.ImmutableMatrix(2, 2, lambda row, column: sympy.factor(A[2 * row, 2 * column] + j * A[2 * row + 1, 2 * column]))
show("The same as a 2x2 complex matrix:", C)
s = sympy.Symbol("s")
quadratic = C.charpoly(s).as_expr()
assert sympy.expand(quadratic * quadratic.subs(j, -j) - A.charpoly(s).as_expr()) == 0

# %% [markdown]
# The last line checks exactly that the 4x4 polynomial is the 2x2 one times its conjugate. So a complex root $\lambda$
# stands for a real pair $\lambda, \bar\lambda$. From now on: two complex poles, mirrored.
#
# A quadratic $s^2 - (\text{sum})\,s + \text{product}$ is best read by the sum and the product of its roots.
#
# ### Exercise 2.1: the sum
#
# Give the **real part** of the sum of the two complex poles, as a formula in `gamma`, `alpha` and whatever else you need.

# %%
answer_2_1 = ...
check("2.1", answer_2_1)

# %% [markdown]
# <details><summary>Solution 2.1</summary>
#
# The sum is the trace of the 2x2 matrix, $-\gamma - \alpha + j\omega$. The speed turns the poles, it does not damp them.
#
# ```python
# answer_2_1 = "-(gamma + alpha)"
# ```
#
# </details>
#
# ### Exercise 2.2: the product at standstill
#
# Give the product of the two poles at $\omega = 0$, simplified if you can. Use $\gamma = R_s/\sigma + \alpha\beta L_m$.

# %%
answer_2_2 = ...
check("2.2", answer_2_2)

# %% [markdown]
# <details><summary>Solution 2.2</summary>
#
# The determinant: $\gamma\alpha - \alpha\beta\,\alpha L_m$, and with $\gamma$ written out $\alpha\beta L_m$ cancels. Only
# the resistances damp: with $R_s = 0$ one pole would be at zero (a flux that nothing dissipates).
#
# ```python
# answer_2_2 = "alpha*R_s/sigma"
# ```
#
# </details>
#
# Both in one line, for any speed:

# %%
show("Characteristic polynomial of the machine at frozen speed:", sympy.collect(sympy.expand(quadratic), s))

# %% [markdown]
# ## Numbers
#
# **Write down what you expect.** One pole is fast and one is slow. Sum and product give both nearly without calculation:
# the fast one is about the sum, the slow one about product over sum. How many seconds does the slow one take, $1/|s|$, at
# standstill? (Then compare with the rotor's $1/\alpha$ = 0.1 s.)

# %%
my_time_constant = ...  # s

# %%
at_rest = np.array(A.subs(dict(zip((*p, omega), (*machine.observer_parameters, 0.0), strict=True))), dtype=float)
poles = np.sort(np.linalg.eigvals(at_rest))
print("poles at standstill (1/s):", np.round(poles, 2))
expected(my_time_constant, -1 / poles[-1], "s")

# %% [markdown]
# Slower than the rotor alone, because the stator's flux has to go as well, through $R_s$: with the stator shorted the
# flux is held from two sides.
#
# ### Exercise 2.3: the fast pole
#
# Now at 100 rad/s: what is the **real part of the fastest** pole, in 1/s? Compute it, from `A` as above or by hand from
# the quadratic.

# %%
answer_2_3 = ...
check("2.3", answer_2_3)

# %% [markdown]
# <details><summary>Solution 2.3</summary>
#
# ```python
# fast = np.array(A.subs(dict(zip((*p, omega), (*machine.observer_parameters, 100.0), strict=True))), dtype=float)
# answer_2_3 = np.linalg.eigvals(fast).real.min()
# ```
#
# Not quite $-(\gamma + \alpha)$: the slow pole has its share of the sum, a larger one than at standstill.
#
# </details>
#
# ## The error dynamics of an observer
#
# An observer is a copy of the machine, plus corrections that are multiples of $\tilde i = i - \hat i$. Error means **true
# minus estimate** throughout, marked by a tilde. Copy and machine share $A'(\omega)x + B'u$, so with the speed known
#
# $$ \dot{\tilde x} = \left( A'(\omega) - L\,C' \right) \tilde x . $$
#
# The input is gone; that is the point of copying. The baseline observer (2)-(4), of Kubota, Matsuse and Nakano, by its
# definition (its last row, with the gain $h$, adapts the speed; with the speed frozen it plays no part):

# %%
rows(("i_ds_hat_dot", "i_qs_hat_dot", "phi_dr_hat_dot", "phi_qr_hat_dot", "omega_hat_dot"),
     baseline.baseline(names("i_ds_hat i_qs_hat phi_dr_hat phi_qr_hat omega_hat"), names("i_ds i_qs"), names("u_ds u_qs"), 1,
                       names("R_s L_m sigma beta alpha"), names("l_1 l_2 l_3 l_4 h")))

# %% [markdown]
# Again nothing need be derived by hand. `frozen_pencil` differentiates plant minus observer and gives a
# `control.StateSpace` whose states carry the names of the errors:

# %%
gains = dict(Study.paper().observers["baseline"].gains)
print(gains)
pencil = frozen_pencil(machine, "baseline", gains, 100.0)
print(pencil.state_labels)
for pole in pencil.poles():
    print(f"    {pole:.1f}  1/s")

# %% [markdown]
# ### Exercise 2.4: damping
#
# The **damping ratio** of a pole is $-\mathrm{Re}\,s/|s|$: 1 does not swing at all, 0 swings for ever. What is the
# smallest damping ratio of this pencil at 100 rad/s? (`pencil.poles()` gives an array.)

# %%
answer_2_4 = ...
check("2.4", answer_2_4)

# %% [markdown]
# <details><summary>Solution 2.4</summary>
#
# ```python
# poles = pencil.poles()
# answer_2_4 = (-poles.real / np.abs(poles)).min()
# ```
#
# The slow pair. It is the flux error, which the rotor carries round, and which decays no faster than in the machine
# itself. What more $l_1$ does to it, the last cell of this lesson shows.
#
# </details>
#
# ## Turn the knobs
#
# The two complex poles over speeds from -150 to 150 rad/s, for the current gain $l_1$ (1/s) and the flux gain $l_3$
# (ohm). First move $l_1$: who moves? Then $l_3$.


# %% jupyter={"source_hidden": true}
def paths(l_1=161.8, l_3=0.0204):
    """Poles of the baseline's error dynamics over the speed."""
    values = {**gains, "l_1": l_1, "l_3": l_3}
    sweep = pole_sweep(Setup("baseline", machine, values), {"omega": np.linspace(-150, 150, 61)})
    return sweep.plot("plane", f"$l_1$ = {l_1:g} /s, $l_3$ = {l_3:g} ohm")


vary(paths, l_1=(0.0, 600.0, 20.0), l_3=(-2.0, 2.0, 0.1))

# %%
for l_1 in (0.0, 160.0, 320.0, 640.0):
    poles = np.linalg.eigvals(frozen_matrix(machine, "baseline", {**gains, "l_1": l_1}, 100.0))
    print(f"l_1 = {l_1:3.0f} /s: slowest decay at 100 rad/s {-poles.real.max():5.1f} 1/s")

# %% [markdown]
# ## What to take along
#
# * At frozen speed the machine is a complex 2x2 system; symmetry says so, and every observer worth its name keeps it.
# * Sum and product of the roots are read off the equations; they tell fast from slow without a computer.
# * Feedback of the current moves the current's pole; the flux error it makes even slower. The flux is only reached
#   through the coupling. A better choice of *states* can make that easier: next lesson.
