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
# # 7. Barbalat's step
#
# With a repair, $\dot V \le -c_0 |\tilde i|^2$, $c_0 = k_1 + R_s/\sigma$. That bounds all errors in $V$. It does not
# yet say that $\tilde i$ vanishes: a derivative can be negative and tend to zero. Three steps close the gap.
#
# ## 1. The integral is finite
#
# $c_0 \int_0^t |\tilde i|^2 d\tau \le V(0) - V(t) \le V(0)$. So the integral is at most $V(0)/c_0$. (18) multiplies
# where it should divide, which the units show at once: A$^2$ s on the left, A$^2$/s on the right.

# %%
import sympy

from imo_analysis.derivation_tools import TurningFlux, errors_at, follow, settled, show
from imo_analysis.equations import lyapunov, repaired
from imo_analysis.machine import PRESETS

settled("bounded-from-16", "eq18.integral")

# %% [markdown]
# ## 2. The integrand does not change fast
#
# $\frac{d}{dt}|\tilde i|^2$ consists of products of bounded signals, by the currents' rows of (12): the errors are
# bounded by $V$, the machine's currents and fluxes by assumption, so $|\tilde i|^2$ is Lipschitz with some constant
# $M$.

# %%
settled("barbalat-step")

# %% [markdown]
# ## 3. Then it tends to zero
#
# Let $f \ge 0$ be Lipschitz with $M$ and reach the height $e$ at some time. Its graph then holds a triangle of height
# $e$ and base $e/M$:

# %%
e, M, t = sympy.symbols("e M t", positive=True)
area = sympy.integrate(e - M * t, (t, 0, e / M))
show("Area that each such time adds:", area)
assert sympy.cancel(area - e**2 / (2 * M)) == 0

# %% [markdown]
# If $f$ reached $e$ again and again, at times at least $e/M$ apart, its integral would grow by $e^2/2M$ each time and
# have no limit. So from some time on $f < e$, for every $e > 0$. That is Barbalat's lemma for Lipschitz functions;
# uniform continuity does in general what $M$ does here (Khalil, Lemma 8.2). The lemma needs $[0, \infty)$, where the
# paper has $[0, \infty]$.

# %%
settled("lemma-IV.1", "proposition-IV.2")

# %% [markdown]
# ## On a run
#
# The repaired observer, along the trajectory of chapter 6, for 40 ms: the integral stays below its bound.

# %%
machine = PRESETS["table-iii-printed-alpha"]
plant = TurningFlux(machine, omega=100.0, stator_frequency=105.0, flux=0.5307)
k_1, kappa, k_3, g, K_p = 300.0, 50.0, 100.0, 1.0, 100.0
_, i, _, _ = plant.at(0.0)
step = 1e-4
start, gains = (i.real, i.imag, 0, 0, 0, 0, 6.6, 40.0), (k_1, kappa, k_3, g, K_p, 0.05, 0.01)
path = follow(repaired.repaired, start, plant, gains, 1, duration=0.04, step=step)
squares = []
for time, x in path:
    errors = errors_at(plant, time, x)
    squares.append(errors["i_ds_tilde"] ** 2 + errors["i_qs_tilde"] ** 2)
integral = step * (sum(squares) - (squares[0] + squares[-1]) / 2)
V_0 = lyapunov.with_direction(
    **errors_at(plant, 0.0, start), alpha=machine.alpha, omega=plant.omega, direction=1, kappa=kappa, k_3=k_3, g=g, K_p=K_p)
limit = V_0 / (k_1 + machine.R_s / machine.sigma)
print(f"integral of |i_tilde|^2 over 40 ms: {integral:.3f} A^2 s, bound V(0)/(k_1 + R_s/sigma) = {limit:.3f} A^2 s")
assert 0 < integral < limit
