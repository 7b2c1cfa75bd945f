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
# # 8. Excitation: what can be found, and what never moves
#
# Zero current error is not zero error. The paper asks for persistent excitation of a 2x6 matrix $B^*$, (19). For
# constant $\omega$ and $\alpha$ that can never be had.

# %%
import numpy as np
import sympy

from imo_analysis.derivation_tools import TurningFlux, errors_at, follow, settled, show, symbols
from imo_analysis.equations import excitation, lyapunov, repaired
from imo_analysis.machine import PRESETS

alpha, omega, beta, L_m = symbols("alpha omega beta L_m")
i, i_hat = symbols("i_ds i_qs"), symbols("i_ds_hat i_qs_hat")
z_hat, xi_hat = symbols("z_1_hat z_2_hat"), symbols("xi_1_hat xi_2_hat")
B = sympy.Matrix(excitation.corrected_19(i, i_hat, z_hat, xi_hat, alpha, omega, beta, L_m))
show("B*, with the sign of its last entry put right:", B)
blind = [sympy.Matrix([0, omega, alpha, 0, 0, 0]), sympy.Matrix([-omega, 0, 0, alpha, 0, 0])]
for direction in blind:
    assert sympy.simplify(B * direction) == sympy.zeros(2, 1)
print("Two constant directions of (xi, z, alpha, omega) that B* sends to zero at every time, whatever the signals do:")
show("", *(one.T for one in blind))
settled("eq19.", "eq20.")

# %% [markdown]
# In complex shorthand they are $\alpha\tilde\xi = j\omega\tilde z$: the kernel of $w = \alpha\tilde\xi - j\omega\tilde
# z$. And the observer never moves along them: with the repaired feedback $q = k_3\tilde z - j\kappa s\tilde\xi$ is
# conserved, because both rates are multiples of $\tilde i$. So $(\tilde z, \tilde\xi)$ splits into a part that is seen
# and a part that stands still:
#
# $$\tilde z = (\alpha q + j\kappa s w)/c, \qquad \tilde\xi = (k_3 w + j\omega q)/c, \qquad c = \alpha k_3 + \kappa s\omega.$$
#
# The right condition is 4x4: excitation of $[I, v_1, v_2]$ for $(w, \tilde\alpha, \tilde\omega)$.

# %%
settled("proposition-IV.3", "proposition-IV.4", "eq21.", "eq23.bound")

# %% [markdown]
# ## What a steady state leaves unknown
#
# Without errors $v_1 = \beta(\phi - L_m i)$ and $v_2 = -j\beta\phi$. The rotor's equation gives $\phi - L_m i =
# (j\omega\phi - \dot\phi)/\alpha$, so with $\dot\phi = j\omega_s\phi$: $v_1 = \frac{\omega_s - \omega}{\alpha} v_2$.
# One direction instead of two: $\alpha$ and $\omega$ cannot both be found, and $\hat\alpha$ stops where it happens to
# be. Only a changing magnitude of the flux, or a changing slip, tells them apart.

# %%
settled("alpha-final")


def levels(depth, stator_frequency=105.0, omega_m=100.0):
    """Eigenvalues of the Gram matrix of [I, v_1, v_2] over 0.5 s, each column scaled by its mean square."""
    machine = PRESETS["table-iii-printed-alpha"]
    plant = TurningFlux(machine, omega_m, stator_frequency, 0.5307, depth, 20.0)
    gram, count = np.zeros((4, 4)), 1000
    for t in np.arange(count) * (0.5 / count):
        _, current, stator, _ = plant.at(float(t))
        v_1 = excitation.alpha_direction((current.real, current.imag), (stator.real, stator.imag), machine.beta, machine.L_m)
        v_2 = excitation.speed_direction((current.real, current.imag), (stator.real, stator.imag))
        row = np.array([[1, 0, v_1[0], v_2[0]], [0, 1, v_1[1], v_2[1]]])
        gram += row.T @ row / count
    scale = np.sqrt(np.diag(gram))
    return np.linalg.eigvalsh(gram / np.outer(scale, scale))


steady, modulated = levels(0.0), levels(0.1)
still = levels(0.0, stator_frequency=0.0, omega_m=-5.0)
print("constant flux, 105 rad/s:      ", np.array2string(steady, precision=4, suppress_small=True))
print("flux modulated by 10 % :       ", np.array2string(modulated, precision=4, suppress_small=True))
print("constant flux, zero frequency: ", np.array2string(still, precision=4, suppress_small=True))
assert steady[0] < 1e-9 < 1e-3 < steady[1] and modulated[0] > 1e-3 and still[1] < 1e-9

# %% [markdown]
# ## On a run
#
# The repaired observer with a wrong start of everything. After a while the current error and $w$ have died out along
# what is excited, $\tilde z$ and $\tilde\xi$ have not, and $q$ is where it was.

# %%
machine = PRESETS["table-iii-printed-alpha"]
plant = TurningFlux(machine, 100.0, 105.0, 0.5307, 0.2, 40.0)
gains = (300.0, 50.0, 100.0, 1.0, 100.0, 0.05, 0.01)
_, current, stator, _ = plant.at(0.0)
start = (current.real, current.imag, 0.9 * stator.real, 0.9 * stator.imag, 0.95 * stator.real, 0.95 * stator.imag, 9.0, 90.0)
path = follow(repaired.repaired, start, plant, gains, 1, duration=0.6, step=5e-4)
print("   t/s   |i~|/A  |z~|/A  |xi~|/A  |w|/(A/s)  q_1/(A/s)  q_2/(A/s)")
kept, seen = [], []
for t, x in path[:: len(path) // 6]:
    e = errors_at(plant, t, x)
    z, xi = (e["z_1_tilde"], e["z_2_tilde"]), (e["xi_1_tilde"], e["xi_2_tilde"])
    w = lyapunov.observable(*z, *xi, machine.alpha, plant.omega)
    q = lyapunov.conserved(*z, *xi, gains[1], gains[2], 1)
    kept.append(q)
    seen.append(float(np.hypot(*w)))
    current = np.hypot(e["i_ds_tilde"], e["i_qs_tilde"])
    print(f"{t:6.2f} {current:8.4f} {np.hypot(*z):7.3f} {np.hypot(*xi):8.3f} {seen[-1]:10.3f} {q[0]:10.4f} {q[1]:10.4f}")
assert np.allclose(kept, kept[0], rtol=0, atol=1e-6 * np.hypot(*kept[0]))
assert seen[-1] < 0.05 * seen[0]
