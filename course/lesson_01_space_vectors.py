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
# # Lesson 1. The machine and its space vectors
#
# **Goals.** See three phase currents as one arrow. Read the five equations (1) of the induction machine as physics. Keep
# three factors apart that spoil half of all first simulations: $\tfrac32$, the pole pairs, and $2\pi$.
#
# **Needs.** Complex numbers, Faraday's law. No control.
#
# **Time.** About 20 minutes. Run the cells in order; where you see `...`, write something.

# %%
import numpy as np

from imo_analysis.course_tools import check, expected, picture, rows, vary
from imo_analysis.drawing import LIMIT, TRUTH, in_style, line, new_figure
from imo_analysis.equations import plant, steady_state
from imo_analysis.ledger.expression import names
from imo_analysis.machine import PRESETS

machine = PRESETS["table-iii-printed-alpha"]

# %% [markdown]
# ## Three currents, one arrow
#
# The three stator windings sit 120° apart. Each makes a field along its own axis, in proportion to its current. The
# fields add as arrows do, so give each current its direction in the complex plane and add:
#
# $$ i = \tfrac23 \left( i_a + i_b\, e^{j 2\pi/3} + i_c\, e^{-j 2\pi/3} \right) = i_d + j\, i_q . $$
#
# That is the **space vector**. The factor $\tfrac23$ is a convention, *amplitude-invariant*: the arrow is as long as the
# peak of one phase current. (With $\sqrt{2/3}$ instead, power is invariant. Papers differ; this one uses $\tfrac23$, as
# the $\tfrac32$ in its torque shows.)
#
# **Write down what you expect.** The phases carry a balanced sine of 10 A peak, 50 Hz. What does the tip of the arrow
# draw? Then phase c is cut, and the other two carry $i_b = -i_a$, still 10 A peak. What does the tip draw now, and how
# long does the arrow get?

# %%
my_length = ...  # A, the longest that the arrow gets with phase c cut

# %%
angle = np.linspace(0, 2 * np.pi, 241)


def space_vector(a, b, c):
    """The arrow of three phase quantities, amplitude-invariant."""
    turn = np.exp(2j * np.pi / 3)
    return 2 / 3 * (a + b * turn + c / turn)


balanced = space_vector(*(10 * np.cos(angle - k * 2 * np.pi / 3) for k in range(3)))
two_phases = space_vector(10 * np.cos(angle), -10 * np.cos(angle), 0 * angle)
print(f"balanced: from {np.abs(balanced).min():.3g} A to {np.abs(balanced).max():.3g} A")
expected(my_length, float(np.abs(two_phases).max()), "A")

# %% jupyter={"source_hidden": true}
@in_style
def tips(imbalance=0.0, fifth=0.0, cut=False):
    """The tip of the current's arrow: phase c weaker by a share, a fifth harmonic in all phases; or phase c cut."""
    strength = (1.0, 1.0, 1.0 - imbalance)
    phases = [10 * k * np.cos(angle - n * 2 * np.pi / 3) + 10 * fifth * np.cos(5 * (angle - n * 2 * np.pi / 3))
              for n, k in enumerate(strength)]
    if cut:
        phases = [phases[0], -phases[0], 0 * angle]
    i = space_vector(*phases)
    figure, (left, right) = new_figure(1, 2, height=2.9)
    for n, (phase, name) in enumerate(zip(phases, "abc", strict=True)):
        left.plot(angle / np.pi, phase, label=f"$i_{name}$", **line(n).kwargs())
    left.set(xlabel=r"angle ($\pi$ rad)", ylabel="phase current (A)")
    left.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)
    right.plot(balanced.real, balanced.imag, label="balanced", **LIMIT.kwargs())
    right.plot(i.real, i.imag, label="these currents", **TRUTH.kwargs())
    right.set(xlabel="$i_d$ (A)", ylabel="$i_q$ (A)", aspect="equal", xlim=(-14, 14), ylim=(-14, 14))
    right.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False)
    return figure


vary(tips, imbalance=(0.0, 1.0, 0.1), fifth=(0.0, 0.2, 0.02))
picture(tips(cut=True), "The tip of the current's arrow with phase c cut: a straight line through the origin")

# %% [markdown]
# A balanced sine draws a circle. A weak phase (move the slider) squeezes it to an ellipse: the arrow pulses at twice
# the frequency, and so does the torque. A fifth harmonic (the other slider) turns backwards and makes corners. With one
# phase cut and $i_b = -i_a$ the tip runs on a straight line: two counter-rotating arrows of equal length. It reaches
# $2/\sqrt3$ times 10 A, as the two windings now pull 60° apart and together. Whoever looks at $i_d$ against $i_q$ on a
# scope sees all of that at a glance.
#
# ## Two windings, two laws
#
# In space vectors the machine is two coupled coils, a fixed one and one that turns. With flux linkages $\psi_s = L_s i +
# L_m i_r$ and $\phi = L_r i_r + L_m i$ (the rotor's), seen from the stator:
#
# * stator: $\dot\psi_s = u - R_s i$. Voltage, less the resistive drop, winds up flux.
# * rotor: $\dot\phi = -R_r i_r + j\omega\phi$. Its bars are shorted, so flux decays through $R_r$, and it is carried
#   round with the rotor at the **electrical** speed $\omega$: pole pairs times the shaft's.
#
# The rotor current is not measured. Eliminating it, and writing the stator row for the current, gives (1). Here it is,
# not typed in again but printed by the very function that the simulator compiles, fed with names in place of numbers:

# %%
left = ("i_ds_dot", "i_qs_dot", "phi_dr_dot", "phi_qr_dot", "omega_dot")
state = names("i_ds i_qs phi_dr phi_qr omega")
rows(left, plant.plant(state, names("u_ds u_qs"), *names("omega_1 T_l"), names("R_s L_m sigma beta alpha mu n_p J")))

# %% [markdown]
# $\omega_1$ is the speed of the frame from which we look. The paper stays in the stationary frame, $\omega_1 = 0$;
# looking along with the flux, currents and fluxes of a steady machine stand still. $T_l$ is the torque of the load, $J$
# the inertia. The letters, with the numbers of Table III:

# %%
for name, unit, meaning in (
    ("sigma", "H", "leakage inductance: what a fast voltage pulse sees"),
    ("alpha", "1/s", "how fast rotor flux dies out, R_r / L_r"),
    ("beta", "1/H", "how much current a weber of rotor flux is worth, L_m / (sigma L_r)"),
    ("gamma", "1/s", "how fast the current reacts, R_s / sigma + alpha beta L_m"),
    ("mu", "1/(kg m^2)", "electrical acceleration per flux times current, 3 n_p^2 L_m / (2 J L_r)"),
):
    print(f"{name:6s} = {getattr(machine, name):9.4g} {unit:10s} {meaning}")
print(f"time constants: current {1e3 / machine.gamma:.1f} ms, rotor flux {1e3 / machine.alpha:.0f} ms")

# %% [markdown]
# Two time scales, more than a decade apart. The current can be made to obey in milliseconds, the flux cannot. That is why
# drives hold the flux constant and make torque with current.
#
# (Table III contradicts itself: its $R_r$ = 0.41 ohm makes $\alpha$ = 6.6 /s, and it prints $\alpha$ = 9.9354 /s, half as
# much again. The lessons' machine has the printed $\alpha$; the observers will start from 6.6.)
#
# ### Exercise 1.1: the current that holds the flux
#
# Turn with the flux, so that it lies on the d axis and is constant, $\phi = \phi_{dr}$, $\phi_{qr} = 0$. The third row of
# (1) is then $0 = -\alpha\phi_{dr} + \alpha L_m i_{ds}$. Give $i_{ds}$ in A for the reference flux of Table III, 0.5307
# Wb.

# %%
answer_1_1 = ...
check("1.1", answer_1_1)

# %% [markdown]
# <details><summary>Solution 1.1</summary>
#
# $\alpha$ cancels: $i_{ds} = \phi / L_m$, about 8.8 A. The rotor resistance says how fast the flux comes, not how much
# there is.
#
# ```python
# answer_1_1 = 0.5307 / machine.L_m
# ```
#
# </details>
#
# ## How long until there is flux?
#
# **Write down what you expect.** The drive steps $i_{ds}$ from zero to that value. After how many seconds has the flux
# reached 95 %?

# %%
my_time = ...  # s


# %%
def flux_after_step(alpha):
    """Time and rotor flux after a step of the d current, by the rows of (1), the frame turning with the flux."""
    step, phi, path = 1e-3, 0.0, []
    p = (*machine.plant_parameters[:4], alpha, *machine.plant_parameters[5:])
    for _ in range(800):
        path.append(phi)
        current = 0.5307 / machine.L_m
        middle = phi + step / 2 * plant.plant((current, 0.0, phi, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0, p)[2]
        phi += step * plant.plant((current, 0.0, middle, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0, p)[2]
    return step * np.arange(800), np.array(path)


time, flux = flux_after_step(machine.alpha)
expected(my_time, float(time[np.argmax(flux > 0.95 * 0.5307)]), "s")

# %% jupyter={"source_hidden": true}
@in_style
def build_up(R_r=0.6):
    """Rotor flux after a step of the d current, for a rotor resistance in ohm."""
    figure, axes = new_figure(height=2.6)
    for n, (value, label) in enumerate(((R_r, f"$R_r$ = {R_r:.3g} ohm"), (0.41, "$R_r$ = 0.41 ohm, as Table III prints it"))):
        axes.plot(*flux_after_step(value / machine.L_r), label=label, **line(n).kwargs())
    axes.set(xlabel="time (s)", ylabel="rotor flux (Wb)", ylim=(0, 0.6))
    axes.legend(loc="lower right")
    return figure


vary(build_up, R_r=(0.2, 1.2, 0.05))

# %% [markdown]
# Three time constants, $3/\alpha$: three tenths of a second. Rotor resistance rises by half between a cold and a hot
# machine, so $\alpha$ is the parameter that wanders. The paper wants to estimate it while running; lesson 7 asks when one
# can.
#
# ## Torque and the factor 3/2
#
# Three phases carry power: $p = u_a i_a + u_b i_b + u_c i_c = \tfrac32\,\mathrm{Re}(u\, i^*)$ in amplitude-invariant
# vectors (no neutral wire). The $\tfrac32$ repays the $\tfrac23$. Torque is power over shaft speed, and a machine with
# $n_p$ pole pairs turns $n_p$ times slower than its field, so $n_p$ comes in as a gear does:

# %%
rows(("torque",), (plant.torque(names("i_ds i_qs phi_dr phi_qr"), *names("n_p L_m L_r")),))

# %% [markdown]
# ### Exercise 1.2: torque
#
# Flux 0.5307 Wb on the d axis and $i_{qs} = 10$ A. What is the torque in N m? `machine.n_p`, `machine.L_m`, `machine.L_r`
# are at hand.

# %%
answer_1_2 = ...
check("1.2", answer_1_2)

# %% [markdown]
# <details><summary>Solution 1.2</summary>
#
# $T_e = \tfrac32 n_p \tfrac{L_m}{L_r} \phi_{dr} i_{qs}$; with $\phi_{qr} = 0$ the other term is gone.
#
# ```python
# answer_1_2 = 1.5 * machine.n_p * machine.L_m / machine.L_r * 0.5307 * 10
# ```
#
# </details>
#
# ### Exercise 1.3: two speeds
#
# The nameplate says 1000 rpm at the shaft. What is $\omega$ of (1), in rad/s? (Table III has $n_p = 2$.)

# %%
answer_1_3 = ...
check("1.3", answer_1_3)

# %% [markdown]
# <details><summary>Solution 1.3</summary>
#
# A turn is $2\pi$ rad, a minute 60 s, and the electrical angle runs $n_p$ times as fast as the shaft.
#
# ```python
# answer_1_3 = machine.n_p * 1000 * 2 * np.pi / 60
# ```
#
# </details>
#
# ## Slip
#
# If the rotor ran as fast as the field, its flux would not change as the rotor sees it: no rotor current, no torque. The
# field must run ahead by the **slip** $\omega_{sl} = \omega_s - \omega$. In the frame of the flux the fourth row of (1)
# is $0 = -\omega_{sl}\,\phi_{dr} + \alpha L_m i_{qs}$.
#
# ### Exercise 1.4: the slip that a torque needs
#
# Eliminate $i_{qs}$ with the torque equation. Give the slip as a formula in `torque`, `phi_dr`, `alpha`, `L_r`, `n_p`, as
# text, for example `"alpha*L_m*i_qs/phi_dr"` (which is the step before). Any equivalent form will do.

# %%
answer_1_4 = ...
check("1.4", answer_1_4)

# %% [markdown]
# <details><summary>Solution 1.4</summary>
#
# $i_{qs} = \dfrac{2 L_r T_e}{3 n_p L_m \phi_{dr}}$, so $L_m$ cancels. Slip is what torque costs: it grows with the rotor
# resistance (in $\alpha$) and falls with the flux squared. Here is also why $\alpha$ and the speed are hard to tell
# apart: what one sees from outside is $\omega_s$, and $\omega = \omega_s - \omega_{sl}$ is wrong by as much as the slip
# is.
#
# ```python
# answer_1_4 = "2*alpha*L_r*torque/(3*n_p*phi_dr**2)"
# ```
#
# </details>

# %%
for torque in (0.0, 5.0, 10.0, 20.0):
    slip = steady_state.slip_of_torque(torque, 0.5307, machine.n_p, machine.L_r, machine.alpha)
    print(f"{torque:4.0f} N m: slip {slip:5.2f} rad/s, which is {slip / 100:.1%} of a speed of 100 rad/s")

# %% [markdown]
# ## What to take along
#
# * One arrow a quantity; a factor $\tfrac23$ going in, $\tfrac32$ coming out.
# * $\omega$ is electrical. Current is fast, flux is slow, $\alpha$ wanders.
# * Measured are the stator's current and voltage. Flux and speed are not, and in (1) they multiply each other. Lesson 3
#   is about that product.
