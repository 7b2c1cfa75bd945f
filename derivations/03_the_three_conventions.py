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
# # 3. Three feedbacks of z, one observer
#
# The feedback of $\hat z$ is printed three times: in (7) and the expanded (8), in the matrix $L(\hat\omega)$, and in
# (12), where the errors of $z$ appear. With $\tilde i = i - \hat i$ and $w = k_2 \hat\omega$ they add to the rates of
# $(\hat z_1, \hat z_2)$:

# %%
import sympy

from imo_analysis.derivation_tools import settled, show, symbols
from imo_analysis.equations import adaptive, plant
from imo_analysis.equations.feedback import feedback_consistent_12, feedback_printed_7, feedback_printed_L

i_tilde = symbols("i_ds_tilde i_qs_tilde")
k_2, omega_hat = symbols("k_2 omega_hat")
for name, rule in (("(7), (8)", feedback_printed_7), ("L(omega_hat)", feedback_printed_L), ("(12)", feedback_consistent_12)):
    show(f"{name}:", *rule(*i_tilde, k_2, omega_hat))
assert feedback_printed_7(*i_tilde, k_2, omega_hat) != feedback_consistent_12(*i_tilde, k_2, omega_hat)

# %% [markdown]
# In complex shorthand the first is $-k_2\hat\omega\,\overline{\tilde i}$, the second $-j k_2 \hat\omega \tilde i$, the
# third $+j k_2 \hat\omega \tilde i$. The first is not even a rotation-invariant law: turn the frame by 90 degrees and
# it changes its sign.
#
# ## What each does at a frozen speed
#
# Take $\hat\omega = \omega$, $\hat\alpha = \alpha$ and let the adaptation rest. The error dynamics are then linear in
# $(\tilde i, \tilde z, \tilde\xi)$: six states. Their matrix comes from the same functions that the simulator compiles.

# %%
R_s, L_m, sigma, beta, alpha = p = symbols("R_s L_m sigma beta alpha")
omega, k_1, k_3, s = *symbols("omega k_1 k_3"), sympy.Symbol("s")
i, z, u = symbols("i_ds i_qs"), symbols("z_1 z_2"), symbols("u_ds u_qs")
errors = symbols("i_ds_tilde i_qs_tilde z_1_tilde z_2_tilde xi_1_tilde xi_2_tilde")
true = (*i, *z, *z)
true_rates = plant.plant_z((*i, *z), u, omega, 0, p)


def error_matrix(rule):
    """The matrix of the frozen error dynamics of an observer."""
    estimate = [a - b for a, b in zip(true, errors, strict=True)]
    gains = (k_1, k_2, k_3, 0, 0, sympy.Rational(1, 20), sympy.Rational(1, 100))
    rates = rule((*estimate, alpha, omega), i, u, 1, p, gains)
    moving = [sympy.expand(a - b) for a, b in zip((*true_rates, *true_rates[2:]), rates[:6], strict=True)]
    return sympy.Matrix(6, 6, lambda row, column: moving[row].coeff(errors[column]))


damping = sympy.Symbol("a", positive=True)
found = {}
for rule in (adaptive.printed_7, adaptive.printed_L, adaptive.consistent_12):
    name = rule.__name__
    matrix = error_matrix(rule).subs(k_1, damping - R_s / sigma)
    found[name] = sympy.factor(matrix.charpoly(s).as_expr())
    show(f"{name}, characteristic polynomial with a = k_1 + R_s/sigma:", found[name])

# %% [markdown]
# All three have a factor $s^2$: two eigenvalues at zero at every speed and for all gains (chapter 8 says why). What is
# left at $s = 0$ of the other factor decides: it must be positive, and for the two printed feedbacks it is not once
# $k_2\omega^2 > \alpha k_3$.

# %%
rest = {name: sympy.factor(sympy.cancel(value / s**2).subs(s, 0)) for name, value in found.items()}
show("Product of the other four eigenvalues:", *rest.values())
c = alpha * k_3
assert sympy.expand(rest["printed_7"] - (c**2 - (k_2 * omega**2) ** 2)) == 0
assert sympy.expand(rest["printed_L"] - (c - k_2 * omega**2) ** 2) == 0
assert sympy.expand(rest["consistent_12"] - (c + k_2 * omega**2) ** 2) == 0

# %% [markdown]
# For (7) the product is negative beyond that speed, so one eigenvalue is real and positive. For $L(\hat\omega)$ the
# complex form $s^2 + (a - j\omega) s + \alpha k_3 - k_2\omega^2$ has a root in the right half plane exactly then (a
# quadratic $s^2 + (a + jb)s + q$ with real $q$ is stable if and only if $a > 0$ and $q > 0$). For (12) the constant is
# a sum of positive terms.

# %%
speed = (9.9354 * 100 / 50) ** 0.5
print(f"With alpha = 9.9354 /s, k_3 = 100 /s, k_2 = 50 both printed forms lose stability above {speed:.2f} rad/s.")

# %% [markdown]
# Two exact solutions that grow as $e^t$, in rational numbers, are entries of the ledger. So is the smallest edit of
# each form.

# %%
settled("eq7.z_1", "eq7.z_2", "eq8.z_1", "eq8.z_2", "eq8.L", "eq8.matrix")
