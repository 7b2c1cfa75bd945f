"""One observer over recorded samples: RK4 between the samples, with voltage and current between them as they were recorded.

The text of the entry is generated for a kind, since numba unrolls tuples of a fixed length only. It holds no equation.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from imo_analysis import compile as compiler
from imo_analysis.equations.catalogue import OBSERVERS

_TEXT = """
@njit(cache=True, error_model="numpy", nogil=True)
def run(x_0, u_d, u_q, i_d, i_q, steps, substeps, direction, own, late, line_u, line_i, bound, p, g, out):
    x = ({x_0})
    done = len(steps)
    for k in range(len(steps)):
        parts = substeps[k]
        if parts == 0:
            a, b = i_d[k] * i_d[k + 1] + i_q[k] * i_q[k + 1], i_d[k] * i_q[k + 1] - i_q[k] * i_d[k + 1]
            size = (a * a + b * b) ** 0.5
            a, b = (a / size, b / size) if size > 0.0 else (1.0, 0.0)
            x = ({turned})
        h = steps[k] / max(parts, 1)
        a_d, a_q = (u_d[k + 1], u_q[k + 1]) if late else (u_d[k], u_q[k])
        b_d, b_q = line_u * (u_d[k + 1] - u_d[k]), line_u * (u_q[k + 1] - u_q[k])
        c_d, c_q = line_i * (i_d[k + 1] - i_d[k]), line_i * (i_q[k + 1] - i_q[k])
        s = (1.0 if x[{speed}] >= 0.0 else -1.0) if own else direction[k]
        for j in range(parts):
            f = j / parts
            i_1, u_1 = (i_d[k] + f * c_d, i_q[k] + f * c_q), (a_d + f * b_d, a_q + f * b_q)
            f = (j + 0.5) / parts
            i_2, u_2 = (i_d[k] + f * c_d, i_q[k] + f * c_q), (a_d + f * b_d, a_q + f * b_q)
            f = (j + 1.0) / parts
            i_3, u_3 = (i_d[k] + f * c_d, i_q[k] + f * c_q), (a_d + f * b_d, a_q + f * b_q)
            k_1 = rates(x, i_1, u_1, s, p, g)
            k_2 = rates(({half_1}), i_2, u_2, s, p, g)
            k_3 = rates(({half_2}), i_2, u_2, s, p, g)
            k_4 = rates(({whole_3}), i_3, u_3, s, p, g)
            x = ({step})
{store}
        if not {size} < bound:
            done = k
            break
{keep}
    return done
"""


@cache
def replay_kernel(kind: str) -> Any:
    """The compiled entry of an observer.

    ``run(x_0, u_d, u_q, i_d, i_q, steps, substeps, direction, own, late, line_u, line_i, bound, p, g, out)`` takes the state
    ``x_0`` at sample 0 through all steps and leaves the last one in it; ``out[k]`` is the state at sample k + 1. It returns
    the number of steps that were done: fewer where the sizes of the states add up to ``bound`` or are not numbers.

    Parameters of ``run``
    ---------------------
    u_d, u_q, i_d, i_q : ndarray, one more entry than steps
        Samples in V and A.
    steps : ndarray
        Time between samples in s; ``substeps`` (int) RK4 steps are taken in each. Where that is 0 nothing is known of what was
        between, and every vector of the state turns as far as the current that was recorded has turned; that is exact in a
        steady state, since the equations look the same from axes that are turned. Speed and alpha stay. A current of zero
        on either side tells of no turn: then all stays.
    direction : ndarray
        Direction of rotation from each sample on; not used where ``own``: then it is the sign of omega_hat.
    late : bool
        Take the voltage of a step from the sample at its end, not at its start.
    line_u, line_i : float
        1 to join the samples by straight lines, 0 to hold them.
    """
    return compiler.entry(source(kind), {"rates": OBSERVERS[kind].rates})


def source(kind: str) -> str:
    """The text of the entry of an observer."""
    states = OBSERVERS[kind].states
    each = range(len(states))

    def joined(form: str) -> str:
        return ", ".join(form.format(n=n) for n in each)

    turned = [f"x[{n}]" for n in each]
    for d, q in _vectors(states):
        turned[d], turned[q] = f"a * x[{d}] - b * x[{q}]", f"b * x[{d}] + a * x[{q}]"
    return _TEXT.format(
        turned=", ".join(turned),
        x_0=joined("x_0[{n}]"), speed=states.index("omega_hat"),
        half_1=joined("x[{n}] + h / 2 * k_1[{n}]"), half_2=joined("x[{n}] + h / 2 * k_2[{n}]"),
        whole_3=joined("x[{n}] + h * k_3[{n}]"),
        step=joined("x[{n}] + h / 6 * (k_1[{n}] + 2.0 * (k_2[{n}] + k_3[{n}]) + k_4[{n}])"),
        store="\n".join(f"        out[k, {n}] = x[{n}]" for n in each),
        size="(" + " + ".join(f"abs(x[{n}])" for n in each) + ")",
        keep="\n".join(f"    x_0[{n}] = x[{n}]" for n in each),
    )


def _vectors(states: tuple[str, ...]) -> list[tuple[int, int]]:
    """Places of the two components of each vector, by their names."""
    seconds = {name: _second(name) for name in states}
    return [(states.index(name), states.index(second)) for name, second in seconds.items() if second in states]


def _second(name: str) -> str:
    """What the second component of a vector would be called of which this is the first."""
    for d, q in (("_ds_", "_qs_"), ("_dr_", "_qr_"), ("_1_", "_2_")):
        if d in name:
            return name.replace(d, q)
    return name.removesuffix("d") + "q"
