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
# # Lesson 3. Luenberger, and why z
#
# **Goals.** See where the unknown speed sits in (1) and where it sits in (6). Know what $z$ is, what it buys, and what it
# costs. Judge the three feedbacks that the paper prints for it.
#
# **Needs.** Lessons 1 and 2.
#
# **Time.** About 20 minutes.

# %%
import numpy as np

from imo_analysis.course_tools import check, expected, rows, vary
from imo_analysis.derivation_tools import settled
from imo_analysis.drawing import LIMIT, TRUTH, in_style, line, new_figure
from imo_analysis.equations import feedback, luenberger, plant, transformation
from imo_analysis.ledger.expression import names
from imo_analysis.machine import PRESETS
from imo_analysis.pencils.error import frozen_matrix

machine = PRESETS["table-iii-printed-alpha"]

# %% [markdown]
# ## The trouble with the flux
#
# In (1) the unknown $\omega$ multiplies the unknown $\phi$, twice: in the current rows, where its effect is *seen*, and
# in the flux rows, where it is not. So a wrong speed also drives the flux estimate wrong, behind our back. Lyapunov
# arguments for the baseline observer break exactly there (`imo derive --subject kubota`).
#
# Wish: coordinates in which $\omega$ and $\alpha$ touch **only the rows that are measured**.
#
# Where does the flux row's speed term go? Compare the two rows of (1), in complex shorthand:
#
# $$ \dot i = \dots + \beta(\alpha - j\omega)\phi, \qquad \dot\phi = -(\alpha - j\omega)\phi + \alpha L_m i . $$
#
# The same term, times $\beta$ and with opposite sign. Add $\beta$ times the second to the first and it is gone. That sum
# is (5):

# %%
rows(("z_1", "z_2"), transformation.to_z(*names("i_ds i_qs phi_dr phi_qr beta")))

# %% [markdown]
# ### Exercise 3.1: the rate of z
#
# Add the rows. In the stationary frame, what is $\dot z_1$? A formula in the names of (1), such as `R_s`, `sigma`,
# `i_ds`, `phi_dr`, `u_ds`; use $\gamma = R_s/\sigma + \alpha\beta L_m$.

# %%
answer_3_1 = ...
check("3.1", answer_3_1)

# %% [markdown]
# <details><summary>Solution 3.1</summary>
#
# $\beta\,\alpha L_m i_{ds}$ from the flux row cancels $-\alpha\beta L_m i_{ds}$ in $-\gamma i_{ds}$, the flux terms
# cancel each other, and what stays is the stator's voltage law divided by $\sigma$.
#
# ```python
# answer_3_1 = "-R_s/sigma*i_ds + u_ds/sigma"
# ```
#
# </details>
#
# The definition agrees. All four rows of (6), $\omega$ and $\alpha$ in the first two only:

# %%
rows(("i_ds_dot", "i_qs_dot", "z_1_dot", "z_2_dot"),
     plant.plant_z(names("i_ds i_qs z_1 z_2"), names("u_ds u_qs"), *names("omega omega_1"), names("R_s L_m sigma beta alpha")))
settled("eq6.")

# %% [markdown]
# (The terms in $\omega_1$ vanish in the stationary frame. In any other the rate of $z$ needs $z$ itself.)
#
# ## What z is
#
# A quantity whose rate is $(u - R_s i)/\sigma$ must be the stator's flux linkage over $\sigma$. So it is: $\sigma z =
# \psi_s$. The oldest flux estimator there is, the *voltage model*, integrates just that. Its virtue: no speed, no rotor
# parameter. Its vice: it is a pure integrator, and nothing pulls an error back.
#
# **Write down what you expect.** $R_s$ in the observer is 5 % too large, as of a machine still cold; the motor draws 9 A
# at a stator frequency of 2 rad/s (just above standstill). Without any feedback $\hat z$ is then off by a rotating error.
# How large, in percent of $|z|$?

# %%
my_percent = ...  # %

# %%
current, stator_frequency = 9.0, 2.0
size = current * (1 + machine.beta * machine.L_m)  # z at constant flux and no load: i + beta L_m i
error = 0.05 * machine.R_s / machine.sigma * current / stator_frequency
expected(my_percent, 100 * error / size, "%")

# %% [markdown]
# The error of the rate, $0.05\,(R_s/\sigma)\,i$, turns at $\omega_s$, and integrating divides by $\omega_s$: at 100 rad/s
# the same mistake would be fifty times smaller. Low speed is where every voltage model fails. A constant offset is worse:
# it does not turn at all.
#
# ### Exercise 3.2: an offset
#
# A current sensor reads 20 mA too much on the d axis, always. At what rate, in A/s, does $\tilde z_1 = z_1 - \hat z_1$
# move without feedback? Mind the sign: $\dot{\hat z}_1$ uses the measured current.

# %%
answer_3_2 = ...
check("3.2", answer_3_2)

# %% [markdown]
# <details><summary>Solution 3.2</summary>
#
# $\dot{\hat z}_1 = -\frac{R_s}{\sigma}(i + 0.02\,\mathrm A) + \frac u\sigma$, so $\dot{\tilde z}_1 =
# +\frac{R_s}{\sigma}\, 0.02$ A. The estimate sinks, the error grows, for ever.
#
# ```python
# answer_3_2 = machine.R_s / machine.sigma * 0.02
# ```
#
# </details>
#
# ## Luenberger's correction
#
# So there must be feedback of $\tilde i$ into $\hat z$. (7) does that, with a gain that goes with the speed. What is
# added to the rates of $(\hat z_1, \hat z_2)$, in the three ways in which the paper prints it:

# %%
three = {"printed_7": feedback.feedback_printed_7, "printed_L": feedback.feedback_printed_L,
         "consistent_12": feedback.feedback_consistent_12}
for name, rule in three.items():
    print(f"{name}:")
    rows(("F_d", "F_q"), rule(*names("i_ds_tilde i_qs_tilde k_2 omega_hat")))

# %% [markdown]
# (7) and the expanded (8) have the first, the matrix $L(\hat\omega)$ the second, and the error dynamics (12) imply the
# third.
#
# ### Exercise 3.3: symmetry
#
# The machine has no preferred direction (lesson 2). So turning $\tilde i$ by 90° must turn the feedback by 90°. Which of
# `"printed_7"`, `"printed_L"`, `"consistent_12"` have this symmetry? Answer with a set. Test it by hand: under a turn by
# 90° $(i_d, i_q)$ becomes $(-i_q, i_d)$.

# %%
answer_3_3 = ...
check("3.3", answer_3_3)

# %% [markdown]
# <details><summary>Solution 3.3</summary>
#
# As a complex number the first is $-k_2\hat\omega\,\overline{\tilde i}$: a conjugate, which turns the other way. The
# second is $-jk_2\hat\omega\,\tilde i$, the third $+jk_2\hat\omega\,\tilde i$: multiplications, which commute with
# turning.
#
# ```python
# answer_3_3 = {"printed_L", "consistent_12"}
# ```
#
# </details>
#
# ## Which one is stable?
#
# With $\omega$ and $\alpha$ known the error dynamics are
#
# $$ \dot{\tilde i} = (-a + j\omega)\,\tilde i + (\alpha - j\omega)\,\tilde z, \qquad
# \dot{\tilde z} = -F\,\tilde i , $$
#
# with $a = k_1 + R_s/\sigma$ and $F = \pm j k_2\omega$ for the two that respect the symmetry. Why not $-\alpha(1 +
# \beta L_m)$ in the first bracket, as (6) has it? Because (7) uses the *measured* current in that term, so it drops out
# of the difference.
#
# ### Exercise 3.4: the product
#
# For the feedback of (12), $F = +jk_2\omega$. Give the product of the two complex poles as a pair of formulas, real part
# and imaginary part: `("...", "...")`.

# %%
answer_3_4 = ...
check("3.4", answer_3_4)

# %% [markdown]
# <details><summary>Solution 3.4</summary>
#
# The determinant of $\begin{bmatrix} -a + j\omega & \alpha - j\omega \\ -F & 0\end{bmatrix}$ is $(\alpha - j\omega) F =
# (\alpha - j\omega)\, j k_2\omega = k_2\omega^2 + j\alpha k_2\omega$. The real part is positive: a restoring force, the
# stronger the faster the machine turns. For $L(\hat\omega)$ both signs change, and the force drives away.
#
# ```python
# answer_3_4 = ("k_2*omega**2", "alpha*k_2*omega")
# ```
#
# </details>
#
# **Write down what you expect.** Of the three, which have all error poles in the left half plane at 100 rad/s with
# $k_1$ = 300 /s, $k_2$ = 50? How many of the three?

# %%
my_count = ...

# %%
stable = 0
for name in three:
    matrix = frozen_matrix(machine, f"luenberger_{name}", {"k_1": 300.0, "k_2": 50.0, "K_p": 0.0}, 100.0)
    largest = float(np.linalg.eigvals(matrix).real.max())
    stable += largest < 0
    print(f"{name:14s} largest real part {largest:8.1f} 1/s")
expected(my_count, stable, "of three")
assert stable == 1


# %% jupyter={"source_hidden": true}
@in_style
def decay(k_2=50.0, k_1=300.0):
    """The slowest decay over the speed for the three feedbacks."""
    speeds = np.linspace(-150, 150, 121)
    figure, axes = new_figure(height=3.0)
    for name in three:
        matrices = frozen_matrix(machine, f"luenberger_{name}", {"k_1": k_1, "k_2": k_2, "K_p": 0.0}, speeds)
        slowest = -np.linalg.eigvals(matrices).real.max(axis=-1)
        axes.plot(speeds, np.round(slowest, 6), label=name, **line(name).kwargs())
    axes.axhline(0, color=TRUTH.color, linewidth=0.8)
    axes.set(xlabel=r"speed $\omega$ (rad/s)", ylabel="slowest decay (1/s)")
    axes.annotate("stable above this line", (-148, 0), (0, 3), textcoords="offset points", fontsize=7.5, color=LIMIT.color)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)
    return figure


vary(decay, k_2=(0.0, 100.0, 5.0), k_1=(0.0, 600.0, 50.0))

# %% [markdown]
# Only one is stable, the one that (12) needs (the curves of the other two nearly coincide). At standstill even that one
# does not decay: its gain goes to zero with the speed, and the integrator is alone. Try $k_2 = 0$: all three coincide
# and nothing decays.
#
# The whole observer, with the right feedback. In its last row $s$ is the direction of rotation, the paper's
# $\mathrm{Sign}(\omega)$:

# %%
rows(("i_ds_hat_dot", "i_qs_hat_dot", "z_1_hat_dot", "z_2_hat_dot", "omega_hat_dot"),
     luenberger.luenberger_consistent_12(names("i_ds_hat i_qs_hat z_1_hat z_2_hat omega_hat"), names("i_ds i_qs"),
                                         names("u_ds u_qs"), *names("direction"), names("R_s L_m sigma beta alpha"),
                                         names("k_1 k_2 K_p")))

# %% [markdown]
# ## What to take along
#
# * $z = i + \beta\phi$ is the stator flux over $\sigma$. It moves the unknown $\omega$ and $\alpha$ into the measured
#   rows.
# * The price is an integrator: offsets drift, $R_s$ matters at low speed, and only feedback pulls back.
# * Symmetry is a free test: a feedback with a conjugate in it cannot be right. Signs need a second test, the poles.
# * Where the last row comes from, the law for $\hat\omega$, is the next lesson.
