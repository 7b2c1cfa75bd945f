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
# # Lesson 7. Persistence of excitation, and what cannot be known
#
# **Goals.** Say what a signal must do so that a parameter can be found. Compute a Gram matrix and read its small
# eigenvalues. Know the three things that no observer of this family finds: part of $(\tilde z, \tilde\xi)$, $\alpha$
# beside $\omega$ at constant flux, and anything at zero stator frequency.
#
# **Needs.** Lesson 4; eigenvalues of symmetric matrices.
#
# **Time.** About 25 minutes.

# %%
import numpy as np

from imo_analysis.course_tools import check, expected, rows, vary
from imo_analysis.derivation_tools import TurningFlux, errors_at, follow, settled
from imo_analysis.drawing import in_style, line, new_figure
from imo_analysis.equations import excitation, lyapunov, repaired, steady_state
from imo_analysis.ledger.expression import names
from imo_analysis.machine import PRESETS

machine = PRESETS["table-iii-printed-alpha"]

# %% [markdown]
# ## Two unknowns on one scale
#
# Put two weights on one pan of a balance and you learn their sum. However often you look, however exact the balance: only
# the sum. To learn both you must **change the proportion**. That is all that persistence of excitation means.
#
# Here the pan is the current error. Lesson 4: $\tilde\alpha$ pushes it along $v_1$ and $\tilde\omega$ along $v_2$, both
# arrows in the plane. Two arrows in different directions can be told apart at once. Two arrows on one line cannot,
# unless their proportion changes with time.
#
# The question is therefore geometric: **how do $v_1$ and $v_2$ lie?** With converged estimates they follow from the flux
# alone. In the frame of the flux (magnitude $\psi$, slip $\omega_{sl}$), from the definition:

# %%
v_1, v_2 = steady_state.regressors_of_flux(*names("psi psi_dot slip alpha beta"))
rows(("v_1d", "v_1q", "v_2d", "v_2q"), (*v_1, *v_2))

# %% [markdown]
# ### Exercise 7.1: the proportion
#
# The flux is constant, so $\dot\psi = 0$. Then $v_1 = c\,v_2$. Give $c$ as a formula in `slip` (for $\omega_{sl}$),
# `alpha`, `beta`, `psi`, as far as they are needed.

# %%
answer_7_1 = ...
check("7.1", answer_7_1)

# %% [markdown]
# <details><summary>Solution 7.1</summary>
#
# Both d components vanish; the ratio of the q components is slip over $\alpha$. With no load $c = 0$: $\alpha$ does not
# show at all (no rotor current, so its resistance is never asked).
#
# ```python
# answer_7_1 = "slip/alpha"
# ```
#
# </details>
#
# So at constant flux the current error sees only the sum $\tilde\omega + c\,\tilde\alpha$. It can be made zero with both
# errors there.
#
# ### Exercise 7.2: the price
#
# Constant flux, slip 5 rad/s, $\alpha$ = 9.9354 /s, and $\hat\alpha$ rests at 6.6 /s. The current error is zero. How
# large is the speed error $\tilde\omega = \omega - \hat\omega$, in rad/s, with its sign?

# %%
answer_7_2 = ...
check("7.2", answer_7_2)

# %% [markdown]
# <details><summary>Solution 7.2</summary>
#
# $\tilde\omega = -c\,\tilde\alpha$ with $\tilde\alpha = 9.9354 - 6.6$. The estimate is too high: believing in too little
# rotor resistance it expects too little slip.
#
# ```python
# answer_7_2 = -5 / machine.alpha * (machine.alpha - 6.6)
# ```
#
# </details>
#
# ## The Gram matrix
#
# The quantitative tool: stack the directions as columns, $M(t) = [\,I\;\; v_1\;\; v_2\,]$, and integrate $M^T M$ over a
# window. A small eigenvalue is a direction in which errors may lie unseen. The two columns of $I$ stand for $w =
# \alpha\tilde\xi - j\omega\tilde z$, all that the currents see of $\tilde z$ and $\tilde\xi$; $w$ is constant in the
# stationary frame, while $v_1$ and $v_2$ turn with the flux.
#
# **Write down what you expect.** Of four eigenvalues, how many are zero (a) with constant flux at 105 rad/s, (b) with the
# flux magnitude modulated by 10 %, (c) at zero stator frequency with constant flux?

# %%
my_zeros = (..., ..., ...)


# %%
def eigenvalues(depth, stator_frequency=105.0, omega=100.0, frequency=20.0):
    """Eigenvalues of the Gram matrix over 0.63 s, each column scaled to mean square 1."""
    plant = TurningFlux(machine, omega, stator_frequency, 0.5307, depth, frequency)
    gram, count = np.zeros((4, 4)), 600
    for t in np.arange(count) * (0.2 * np.pi / count):
        _, i, z, _ = plant.at(float(t))
        one = excitation.reduced((i.real, i.imag), (i.real, i.imag), (z.real, z.imag), (z.real, z.imag), machine.alpha, omega,
                                 machine.beta, machine.L_m)
        gram += np.array(one).T @ np.array(one) / count
    scale = np.sqrt(np.diag(gram))
    return np.abs(np.round(np.linalg.eigvalsh(gram / np.outer(scale, scale)), 12))


situations = {"constant flux": eigenvalues(0.0), "modulated by 10 %": eigenvalues(0.1),
              "zero stator frequency": eigenvalues(0.0, 0.0, -5.0)}
zeros = []
for guess, (name, values) in zip(my_zeros, situations.items(), strict=True):
    zeros.append(int(np.sum(values < 1e-9)))
    print(f"{name:22s} {np.array2string(values, precision=4, suppress_small=True)}")
    expected(guess, zeros[-1], "of four zero")
assert zeros == [1, 0, 2]

# %% [markdown]
# At zero stator frequency nothing turns: $v_2$ is a constant arrow like the columns of $I$, and even the speed hides
# behind $w$. This is the famous blind spot of every sensorless induction drive without signal injection.
#
# ## The paper's condition can never hold
#
# (19) asks the same of **six** columns, for $(\tilde\xi, \tilde z, \tilde\alpha, \tilde\omega)$:

# %%
B = excitation.corrected_19(names("i_ds i_qs"), names("i_ds_hat i_qs_hat"), names("z_1_hat z_2_hat"),
                            names("xi_1_hat xi_2_hat"), *names("alpha omega beta L_m"))
for n, row in enumerate(B):
    print(f"row {n + 1}: " + ",  ".join(map(str, row)))

# %% [markdown]
# The first four columns are constant. However wild the signals: those four columns have two rows, so they span a plane.
#
# ### Exercise 7.3: the best that can be had
#
# Take **random** signals, the richest there are, for many instants. What rank does the 6x6 Gram matrix reach (for
# constant $\alpha$ and $\omega$)? `excitation.corrected_19` takes numbers too; `np.linalg.matrix_rank` helps, or think.

# %%
answer_7_3 = ...
check("7.3", answer_7_3)

# %% [markdown]
# <details><summary>Solution 7.3</summary>
#
# Two dimensions from the first four columns, one each from $v_1$ and $v_2$. Two directions stay dark: $\alpha\tilde\xi =
# j\omega\tilde z$, where $w = 0$. So Proposition IV.3 is true of nothing.
#
# ```python
# generator = np.random.default_rng(1)
# stack = []
# for _ in range(50):
#     i, i_hat, z_hat, xi_hat = generator.normal(size=(4, 2))
#     stack += list(excitation.corrected_19(i, i_hat, z_hat, xi_hat, 10.0, 100.0, 300.0, 0.06))
# answer_7_3 = np.linalg.matrix_rank(np.array(stack))
# ```
#
# </details>

# %%
settled("proposition-IV.3")

# %% [markdown]
# Is that a disaster? No. The reconstructed flux below (11) needs $\tilde z$ and $\tilde\xi$ only through $w$. What is
# dark does not matter; what matters is seen. The right condition is the 4x4 one above.
#
# And the dark part stands still. With the repaired feedback $q = k_3\tilde z - j\kappa s\,\tilde\xi$ never changes, as
# both rates are multiples of $\tilde i$. On a run, with modulated flux:

# %%
plant = TurningFlux(machine, 100.0, 105.0, 0.5307, 0.2, 40.0)
_, i, z, _ = plant.at(0.0)
start = (i.real, i.imag, 0.9 * z.real, 0.9 * z.imag, 0.95 * z.real, 0.95 * z.imag, 9.0, 90.0)
gains = (300.0, 50.0, 100.0, 1.0, 100.0, 0.05, 0.01)  # k_1, kappa, k_3, g, K_p; alpha_l and delta of (10)
path = follow(repaired.repaired, start, plant, gains, 1, duration=0.5, step=5e-4)
print("  t (s)  |i~| (A)  |z~| (A)  |w| (A/s)   |q| (A/s)  alpha~ (1/s)")
kept, seen = [], []
for t, x in path[:: len(path) // 5]:
    e = errors_at(plant, t, x)
    states = (e["z_1_tilde"], e["z_2_tilde"], e["xi_1_tilde"], e["xi_2_tilde"])
    w = np.hypot(*lyapunov.observable(*states, machine.alpha, plant.omega))
    q = np.hypot(*lyapunov.conserved(*states, 50.0, 100.0, 1))
    print(f"{t:7.2f} {np.hypot(e['i_ds_tilde'], e['i_qs_tilde']):9.4f} {np.hypot(*states[:2]):9.3f} {w:10.2f} {q:11.4f} "
          f"{e['alpha_tilde']:12.4f}")
    kept.append(q)
    seen.append(w)
assert np.ptp(kept) < 1e-6 * kept[0] and seen[-1] < 0.1 * seen[0]

# %% [markdown]
# $|w|$ dies out, $|\tilde z|$ tends to a value that is not zero, $|q|$ does not move in four digits.
#
# ## Modulate the flux
#
# $v_1$ has a part along the flux, $-\beta\dot\psi/\alpha$, which $v_2$ never has. So **change the flux magnitude** and
# the arrows part. How far? Take $\sin^2$ of the mean angle between them, $\det G/(g_{11}g_{22})$ with the Gram matrix $G$
# of $v_1, v_2$: 0 on one line, 1 at right angles.


# %%
def apart(depth, frequency, slip=5.0):
    """det G / (g_11 g_22) of v_1 and v_2, flux modulated by depth cos(frequency t) at constant slip."""
    gram = steady_state.gram_constant_slip(0.5307, depth, frequency, slip, machine.alpha, machine.beta)
    return steady_state.determinant(gram) / (gram[0] * gram[2])

# %% jupyter={"source_hidden": true}
@in_style
def arrows(depth=0.1, frequency=20.0, slip=5.0):
    """Paths of v_1 and v_2 in the frame of the flux, and how far they are apart over the depth."""
    t = np.linspace(0, 2 * np.pi / frequency, 121)
    psi, rate = 0.5307 * (1 + depth * np.cos(frequency * t)), -0.5307 * depth * frequency * np.sin(frequency * t)
    one, two = steady_state.regressors_of_flux(psi, rate, slip, machine.alpha, machine.beta)
    figure, (left, right) = new_figure(1, 2, height=2.9)
    left.plot(one[0], one[1], label="$v_1$", **line(0).kwargs())
    left.plot(np.full_like(t, two[0]), two[1], label="$v_2$", **line(1).kwargs())
    left.plot(0, 0, "+", color="#1a1a1a")
    left.set(xlabel="along the flux (A)", ylabel="across the flux (A)")
    left.set_aspect("equal", adjustable="datalim")  # the angle is what matters
    left.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False)
    depths = np.linspace(0, 0.2, 41)
    right.plot(100 * depths, [apart(d, frequency, slip) for d in depths], **line(2).kwargs())
    right.plot(100 * depth, apart(depth, frequency, slip), "o", color="#1a1a1a")
    right.set(xlabel="depth of the modulation (%)", ylabel=r"$\sin^2$ of the angle", ylim=(0, 1))
    return figure


vary(arrows, depth=(0.0, 0.2, 0.01), frequency=(5.0, 60.0, 5.0), slip=(1.0, 20.0, 1.0))

# %% [markdown]
# ### Exercise 7.4: enough, but not too much
#
# At 5 rad/s of slip, reach $\sin^2 \ge 0.5$ with a depth of at most 0.15 and at most 60 rad/s (faster, the voltage runs
# out and the torque ripples). Answer with `{"depth": ..., "frequency": ...}`; try with `apart(depth, frequency)`.

# %%
answer_7_4 = ...
check("7.4", answer_7_4)

# %% [markdown]
# <details><summary>Solution 7.4</summary>
#
# The swing adds $(\text{depth}\cdot\Omega)^2/(2\alpha^2)$ to $g_{11}$, against $\omega_{sl}^2/\alpha^2$ from the slip:
# depth times frequency must be about $\sqrt2$ times the slip. Frequency is as good as depth.
#
# ```python
# answer_7_4 = {"depth": 0.15, "frequency": 55.0}
# ```
#
# </details>
#
# ## What to take along
#
# * Convergence of a parameter is a property of the *signals*, not of the observer.
# * A small eigenvalue of the Gram matrix names the errors that may stay. First ask whether they matter.
# * Constant flux: one number for two unknowns. Zero stator frequency: none. Only changing the operation helps, at a
#   price.
