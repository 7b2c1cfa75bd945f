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
# # 6. What breaks, and the repairs
#
# The moving weight of $\tilde z$ adds $-\frac{\omega\dot{\hat\omega}}{2 k_2 \hat\omega^2}|\tilde z|^2$ to $\dot V$. The
# text drops it with a word on the sign operator. But $\dot{\hat\omega}$ goes up and down: by (11) it is $K_p$ times a
# signal without a sign.
#
# ## A state, by hand
#
# All parameters and gains 1, $\omega = \hat\omega = 1$, $\tilde i = (1, 0)$, $\tilde z = (4, 0)$, $z_2 = \hat z_2 =
# -1$, everything else 0. Then the signal of (11) is $\hat z_2 \tilde i_{ds} = -1$, and

# %%
from fractions import Fraction

from imo_analysis.derivation_tools import TurningFlux, errors_at, follow, settled
from imo_analysis.equations import adaptive, lyapunov, repaired
from imo_analysis.ledger.claims.situations import BREAKS_16, lyapunov_13
from imo_analysis.machine import PRESETS

point = {name: Fraction(value) for name, value in BREAKS_16.items()}
values = lyapunov_13().values(point)
bound = -(point["k_1"] + point["R_s"] / point["sigma"]) * (point["i_ds_tilde"] ** 2 + point["i_qs_tilde"] ** 2)
print(f"omega_hat' = {values['omega_hat_dot']}, V' = {values['V_dot']}, and (16) allows {bound}")
assert values["V_dot"] == 6 and bound == -2
settled("sign-operator.inequality", "eq16.bound", "eq17.integral")

# %% [markdown]
# ## A trajectory
#
# Table III's machine at a constant 100 rad/s (electrical), flux 0.5307 Wb, slip 5 rad/s: currents, $z$ and voltages in
# closed form. The observer starts from zero $\hat z$, $\hat\xi$, from $\hat\omega = 40$ rad/s and $\hat\alpha = 6.6$
# /s, with gains that run. All that the proof asks for is given: $\omega$ constant, $\omega\hat\omega > 0$, the feedback
# of (12), the corrected $V$.

# %%
machine = PRESETS["table-iii-printed-alpha"]
plant = TurningFlux(machine, omega=100.0, stator_frequency=105.0, flux=0.5307)
gains = (300.0, 50.0, 100.0, 1.0, 100.0, 0.05, 0.01)
_, i, z, _ = plant.at(0.0)
start = (i.real, i.imag, 0.0, 0.0, 0.0, 0.0, 6.6, 40.0)
common = {"alpha": machine.alpha, "omega": plant.omega, "k_3": gains[2], "g": gains[3], "K_p": gains[4]}


def largest_rise(levels):
    """The most that a sequence rises above an earlier value."""
    lowest, rise = levels[0], 0.0
    for level in levels:
        lowest = min(lowest, level)
        rise = max(rise, level - lowest)
    return rise


printed_gain = follow(adaptive.consistent_12, start, plant, gains, 1, duration=0.01, step=5e-5)
V = [lyapunov.corrected_13(**errors_at(plant, t, x), omega_hat=x[7], k_2=gains[1], **common) for t, x in printed_gain]
top = max(range(len(V)), key=V.__getitem__)
when = 1e3 * printed_gain[top][0]
print(f"printed gain k_2 omega_hat: V(0) = {V[0]:.1f} A^2, V = {V[top]:.1f} A^2 at {when:.2f} ms: it has grown")
assert V[top] > V[0] + 20

with_direction = follow(repaired.repaired, start, plant, gains, 1, duration=0.01, step=5e-5)
V = [lyapunov.with_direction(**errors_at(plant, t, x), direction=1, kappa=gains[1], **common) for t, x in with_direction]
print(f"repair 2, same start: V(0) = {V[0]:.1f} A^2, V(10 ms) = {V[-1]:.1f} A^2, largest rise {largest_rise(V):.1e} A^2")
assert largest_rise(V) == 0.0

# %% [markdown]
# The same on the simulated drive, with its own current control: `imo simulate --scenario lyapunov --out run.nc`. There V goes
# beyond twenty times V(0) within 15 ms, because $\hat\omega$ comes near zero.

# %% [markdown]
# ## Repairs
#
# | | z loop | V | bound on V' | cost |
# |---|---|---|---|---|
# | 1 | none | $\tilde i, w, \tilde\alpha, \tilde\omega$ | exact | damping of $w$ by $\alpha k_3$ alone |
# | 2 | $\kappa s$ | (13) with $\lvert\omega\rvert/2\kappa$ | exact | the direction must be known |
# | 3 | $\kappa(t) s$ that never falls | as 2 | holds | the gain stays up |
# | 4 | $k_2\hat\omega$ as printed | as 1 | third-order rest | local, under excitation |
# | 5 | $\kappa(t) s$, up and down | as 1 | $V \le V(0) e^F$, $F$: falls of $\ln c$ | not for $\hat\omega$ as schedule |
# | 6 | $\kappa s$, $s$ wrong at low speed | as 5 | exact | $c = \alpha k_3 + \kappa s\omega > 0$ |
#
# Repairs 1, 5 and 6 rest on one remark of chapter 4: the currents see $\tilde z$ and $\tilde\xi$ through $w =
# \alpha\tilde\xi - j\omega\tilde z$ only. With $\tilde z' = -j\kappa s\tilde i$ and $\tilde\xi' = -k_3\tilde i$,
#
# $$\dot w = -(\alpha k_3 + \kappa s\omega)\,\tilde i = -c\,\tilde i,$$
#
# and $V_w = \tfrac12|\tilde i|^2 + \tfrac{1}{2c}|w|^2 + \tfrac{1}{2g}\tilde\alpha^2 + \tfrac{1}{2K_p}\tilde\omega^2$
# has $\dot V_w = -(k_1 + R_s/\sigma)|\tilde i|^2 - \frac{\dot c}{2c^2}|w|^2$. No $\hat\omega$ in it, no sign condition
# but $c > 0$.

# %%
settled("repair-1", "repair-2", "repair-3", "repair-4", "repair-5", "repair-6", "proposition-IV.2")
limit = machine.alpha * gains[2] / gains[1]
print(f"With these gains a wrong direction does not touch the bound below alpha k_3 / kappa = {limit:.1f} rad/s.")

# %% [markdown]
# A check of repair 6: start with the wrong direction at 15 rad/s, and the bound still holds.

# %%
slow = TurningFlux(machine, omega=15.0, stator_frequency=20.0, flux=0.5307)
path = follow(repaired.repaired, start, slow, gains, -1, duration=0.01, step=5e-5)
levels = []
for t, x in path:
    e = errors_at(slow, t, x)
    w = lyapunov.observable(e["z_1_tilde"], e["z_2_tilde"], e["xi_1_tilde"], e["xi_2_tilde"], machine.alpha, slow.omega)
    levels.append(lyapunov.reduced(e["i_ds_tilde"], e["i_qs_tilde"], *w, e["alpha_tilde"], e["omega_tilde"],
                                   machine.alpha * gains[2] - gains[1] * slow.omega, gains[3], gains[4]))
print(f"wrong direction at 15 rad/s: V_w(0) = {levels[0]:.1f} A^2, V_w(10 ms) = {levels[-1]:.1f} A^2, "
      f"largest rise {largest_rise(levels):.1e} A^2")
assert largest_rise(levels) == 0.0
