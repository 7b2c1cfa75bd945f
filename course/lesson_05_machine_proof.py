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
# # Lesson 5. Reading a proof with a machine
#
# **Goals.** Know what it means that a formula "holds": exactly, under which hypotheses, by which route. Read an entry of
# the ledger. Produce the two kinds of evidence yourself: a sum of squares, and a counterexample that can be checked by
# hand.
#
# **Needs.** Lesson 4. No computer algebra.
#
# **Time.** About 20 minutes.

# %%
import random
from fractions import Fraction

from imo_analysis.course_tools import check, entry, expected
from imo_analysis.derivation_tools import settled
from imo_analysis.ledger.claim import Claim, Verdict
from imo_analysis.ledger.claims.situations import lyapunov_13
from imo_analysis.ledger.expression import evaluate, parse_relation
from imo_analysis.ledger.kernels import kernel
from imo_analysis.ledger.mutants import try_mutants
from imo_analysis.ledger.question import Question
from imo_analysis.ledger.setting import setting
from imo_analysis.ledger.settings import errors
from imo_analysis.paper.contents import row

# %% [markdown]
# ## Why not simply put numbers in?
#
# A tempting test of an identity: draw random numbers, compute both sides, compare to, say, six digits. Here is an
# identity with one coefficient off by one part in $10^9$:

# %%
wrong = parse_relation("(z_1 + z_2)**2 = z_1**2 + 2*z_1*z_2 + (1 + 1/10**9)*z_2**2")

# %% [markdown]
# **Write down what you expect.** Of 1000 random float tests with a relative tolerance of $10^{-6}$, how many reject it?

# %%
my_rejections = ...

# %%
generator = random.Random(1)
rejections = 0
for _ in range(1000):
    point = {name: generator.uniform(-10, 10) for name in ("z_1", "z_2")}
    left, right = (evaluate(side, point, float) for side in (wrong.left, wrong.right))
    rejections += abs(left - right) > 1e-6 * (abs(left) + 1)
expected(my_rejections, rejections)
exactly = kernel("flint").answer([Question("wrong", setting("plain", "no more"), wrong, "identity")])[0]
print("the exact kernel accepts it:", exactly)
assert rejections == 0 and not exactly

# %% [markdown]
# A tolerance hides what is smaller than itself. In a paper's formulas errors are not that small, but a sign in a term
# that happens to be small at the drawn points is just as invisible. Exact arithmetic has no tolerance: both sides become
# fractions of polynomials with rational coefficients, and they are equal or they are not.
#
# ## What a claim consists of
#
# A formula alone is nothing to prove. It needs a **setting**: what is defined by what, and under which hypotheses. In the
# setting of the error dynamics every estimate is defined as true minus error and every rate is a row of a *definition*,
# the same function that the simulator compiles:

# %%
where = errors("consistent_12")
print(where.text)
print("z_2_hat         is", where.definitions["z_2_hat"])
print("xi_1_tilde_dot  is", where.definitions["xi_1_tilde_dot"])
print("hypotheses:", "; ".join(map(str, where.hypotheses)))

# %% [markdown]
# So nobody derives (12) here. Its printed rows are *compared* with what the definitions say. One of the current's two
# rows differs. As printed:

# %%
print(row("eq12.i_qs").text)

# %% [markdown]
# ### Exercise 5.1: how wrong is it?
#
# The right row is the imaginary part of $\dot{\tilde i}$ in lesson 4. Give **printed minus right**, as a formula in the
# errors, the estimates and `omega`.

# %%
answer_5_1 = ...
check("5.1", answer_5_1)

# %% [markdown]
# <details><summary>Solution 5.1</summary>
#
# Two terms have minus for plus, so each counts twice. Note the products: $\tilde\omega\hat i_{ds} + \omega\tilde i_{ds}$
# is also $\omega i_{ds} - \hat\omega\hat i_{ds}$. The check accepts both.
#
# ```python
# answer_5_1 = "-2*(omega_tilde*i_ds_hat + omega*i_ds_tilde)"
# ```
#
# </details>
#
# Now let the ledger say it:

# %%
entry("eq12.i_qs")

# %% [markdown]
# Read it from the top: verdict, what is printed, what is right with the difference marked, the setting and its
# hypotheses, whose slip it is, the findings, the units, and which kernels agreed (a third, Coq, can be asked for: `imo
# derive --kernel all`). The finding on the printed row ends with *left minus right*, which is the negative of your
# answer in other letters, and has a point at which it is not zero.
#
# Harmless: (14) and $A^*$ of (20) have the right signs, so nothing was built on it. Telling harmless from harmful slips
# is half of reading a paper.
#
# ## Inequalities: show the squares
#
# Identities are decided by arithmetic. For an inequality one shows **why**: the difference of the sides as a sum $\sum
# w_k\, b_k^2$ with weights that are seen to be positive. Anyone can expand it; nobody has to trust how it was found.
#
# ### Exercise 5.2: a certificate
#
# For $k_1 > 0$ show that $\quad k_1\,\tilde i_{ds}^2 + 2 w_1\,\tilde i_{ds} + \frac{2}{k_1} w_1^2 \ge 0.\quad$ Answer
# with a list of pairs, weight and base, as text: `[("...", "..."), ("...", "...")]`. Names: `k_1`, `i_ds_tilde`, `w_1`.
# Complete the square.

# %%
answer_5_2 = ...
check("5.2", answer_5_2)

# %% [markdown]
# <details><summary>Solution 5.2</summary>
#
# $k_1\left(\tilde i_{ds} + w_1/k_1\right)^2$ uses up one of the two $w_1^2/k_1$; the other one is left over.
#
# ```python
# answer_5_2 = [("k_1", "i_ds_tilde + w_1/k_1"), ("1/k_1", "w_1")]
# ```
#
# </details>
#
# ## "Fails" means: here is a point
#
# (16) claims $\dot V \le -(k_1 + R_s/\sigma)|\tilde i|^2$. Lesson 4 found a term that may spoil it. To *refute* it, one
# state is enough, in numbers that can be checked with pencil and paper. Take all parameters, gains, $\omega$ and the
# direction as 1, all errors and signals as 0, and change a few. What the setting then says, exactly:

# %%
base = {**dict.fromkeys(("R_s", "L_m", "sigma", "beta", "alpha", "k_1", "k_2", "k_3", "g", "K_p", "omega", "direction"), 1),
        **dict.fromkeys(("i_ds_tilde", "i_qs_tilde", "z_1_tilde", "z_2_tilde", "xi_1_tilde", "xi_2_tilde", "alpha_tilde",
                         "omega_tilde", "i_ds", "i_qs", "z_1", "z_2", "u_ds", "u_qs"), 0)}


def at(**changes):
    """Values of V', of the bound in (16) and of the rate of omega_hat at a state."""
    point = {name: Fraction(value) for name, value in {**base, **changes}.items()}
    values = lyapunov_13().values(point)
    bound = -(point["k_1"] + point["R_s"] / point["sigma"]) * (point["i_ds_tilde"] ** 2 + point["i_qs_tilde"] ** 2)
    return {"V_dot": str(values["V_dot"]), "bound": str(bound), "omega_hat_dot": str(values["omega_hat_dot"])}


print(at(i_ds_tilde=1))
print(at(i_ds_tilde=1, z_2=1))

# %% [markdown]
# With 1 A of current error the bound is met with equality. Now break it. You need $\dot{\hat\omega} < 0$, that is a
# negative signal in (11), and a $\tilde z$ that is not zero.
#
# ### Exercise 5.3: a counterexample
#
# Give the changes as a dictionary, such as `{"i_ds_tilde": 1, "z_2": 1}`. Only errors and signals may change (the zeros
# in `base` except the voltages), by integers or fractions. Use `at(**answer_5_3)` to look.

# %%
answer_5_3 = ...
check("5.3", answer_5_3)

# %% [markdown]
# <details><summary>Solution 5.3</summary>
#
# $\hat z_2 = z_2 - \tilde z_2$ negative together with $\tilde i_{ds} = 1$ makes the signal of (11) negative; a $\tilde
# z_1$ then brings $-\frac{\omega\dot{\hat\omega}}{2k_2\hat\omega^2}\tilde z_1^2 = +\tfrac12\cdot 16$.
#
# ```python
# answer_5_3 = {"i_ds_tilde": 1, "z_1_tilde": 4, "z_2": -1}
# ```
#
# </details>
#
# ## Who checks the checker? Mutants
#
# A check that always says yes proves nothing. So every claim that holds is also run on **mutants**: each sign,
# coefficient, index and hat changed in turn. The kernels must reject every mutant that is not equal to the original:

# %%
law = Claim("mine", "(lesson)", "the xi row of (12)", Verdict.HOLDS, errors("consistent_12"),
            printed="xi_1_tilde_dot = -k_3*(i_ds - i_ds_hat)")
report = try_mutants([law], ("flint",))
print(report.text().partition(" (")[0])
assert report.ok

# %% [markdown]
# ### Exercise 5.4: be the judge
#
# Before you look: which verdict do these get? `"eq6.z_1"` (the rate of $z_1$), `"eq12.i_qs"` (above), `"eq16.bound"` (the
# bound on $\dot V$). Each is one of `"holds"` (as printed), `"holds after correction"` (after a small edit that can be
# named), `"fails"` (and no small edit saves it), `"not determined by the text"` (what is printed leaves it open). Answer with a
# dictionary from id to verdict.

# %%
answer_5_4 = ...
check("5.4", answer_5_4)

# %% [markdown]
# <details><summary>Solution 5.4</summary>
#
# At your point (16) is false by a term that has no sign at all. Writing that term into it would make it true, and it
# would no longer be a bound.
#
# ```python
# answer_5_4 = {"eq6.z_1": "holds", "eq12.i_qs": "holds after correction", "eq16.bound": "fails"}
# ```
#
# </details>

# %%
settled("eq6.z_1", "eq16.bound", "repair-2")

# %% [markdown]
# ## What to take along
#
# * A claim is formula, definitions and hypotheses. Leave one out and there is nothing to prove.
# * True inequalities come with their squares, false ones with a point. Both can be checked without the machine that found
#   them.
# * Float agreement is evidence, never proof. And a check that cannot fail is none.
