"""The part of an error dynamics that settles, so that python-control's norms, margins and step responses are finite.

Three directions of the adaptive observers never settle, and each is taken out by a change of coordinates that is exact, not by
a tolerance:

- What the currents do not see of z and xi. Only w = alpha xi_tilde - j omega z_tilde acts (`lyapunov.observable`), so that w
  is kept in place of the two; the offset that is left out stays for ever (a pole at minus j times the stator frequency in the
  turning frame), yet reaches no current, no speed, no alpha and no flux. It keeps q = k_3 z_tilde - j kappa s xi_tilde company:
  the noise moves q in a random walk, so that z_hat and xi_hat have no variance at rest, while omega_hat has.
- alpha against omega. At constant flux both laws follow one signal, so that alpha_tilde - r omega_tilde keeps its value
  whatever the noise does, with r = d alpha_hat / d omega_hat. With ``alpha="adapted"`` that value is zero and alpha_hat
  follows omega_hat; with ``alpha="held"`` alpha_hat does not move, and ``alpha_tilde`` is an input.
- The filters of the supervised observer, which at constant flux act on nothing.

What is left can still fail to settle, and then for a reason of its own: the observer is unstable. At zero stator frequency
nothing determines omega_hat, so that a full linearisation has nothing there that settles, and is refused.

Examples
--------
How the noise of the measured currents reaches the speed estimate of the repaired observer, at 60 rad/s and a slip of 3 rad/s:

>>> import control, numpy as np
>>> from imo_analysis.machine import PRESETS
>>> from imo_analysis.pencils.error import OperatingPoint
>>> from imo_analysis.pencils.settling import settling_pencil, speed_loop
>>> gains = dict(k_1=300, kappa=50, k_3=100, g=1, K_p=100, alpha_l=0.05, delta=0.01)
>>> point = OperatingPoint(omega=60.0, flux=0.5307, slip=3.0)
>>> system = settling_pencil(PRESETS["table-iii-printed-alpha"], "repaired", gains, point)
>>> noise = system["omega_tilde", ["i_ds_noise", "i_qs_noise"]]
>>> density = control.norm(noise, 2)
>>> print(f"white noise of 1 mA/sqrt(Hz) makes {density / 1000:.3f} rad/s")
white noise of 1 mA/sqrt(Hz) makes 0.564 rad/s

A sampled current holds its noise for a period T, which makes a density of sqrt(T) times its deviation. As Bode plot,
and where it peaks:

>>> sampled = control.norm(control.sample_system(noise, 1e-4), 2)
>>> print(f"10 mA at 10 kHz make {0.01 * sampled:.4f} rad/s; the density says {0.01 * 1e-4**0.5 * density:.4f} rad/s")
10 mA at 10 kHz make 0.0563 rad/s; the density says 0.0564 rad/s
>>> response = control.frequency_response(noise, np.geomspace(1, 1e4, 2001))
>>> figure = response.plot()
>>> along, across = response.frequency[np.argmax(response.magnitude[0], axis=-1)]
>>> print(f"from noise along the flux it peaks at {along:.0f} rad/s, across the flux at {across:.0f} rad/s")
from noise along the flux it peaks at 64 rad/s, across the flux at 1637 rad/s

The loop of the speed adaptation, opened at omega_hat, and how the estimate follows a speed that accelerates:

>>> held = settling_pencil(PRESETS["table-iii-printed-alpha"], "repaired", gains, point, alpha="held")
>>> gain, phase, _, _, crossover, _ = control.stability_margins(speed_loop(held), epsw=1e-3)
>>> print(f"gain margin {gain:.3g}, phase margin {phase:.1f} degrees at {crossover:.0f} rad/s")
gain margin inf, phase margin 15.3 degrees at 1609 rad/s
>>> time, error = control.step_response(held["omega_tilde", "omega_dot"], np.linspace(0, 2, 2001))
>>> print(f"100 rad/s^2 leave {100 * error[-1]:.4f} rad/s")
100 rad/s^2 leave 0.0167 rad/s
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from imo_analysis.equations import lyapunov
from imo_analysis.equations.catalogue import RUNNING_GRAM
from imo_analysis.equations.own import shown
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.pencils.error import Gains, OperatingPoint, frozen_pencil, full_pencil, gain_values
from imo_analysis.pencils.jacobian import Kind, known_observer
from imo_analysis.pencils.operating import STANDING, STANDSTILL

if TYPE_CHECKING:
    import control

Alpha = Literal["adapted", "held"]
_HIDDEN = ("z_1_tilde", "z_2_tilde", "xi_1_tilde", "xi_2_tilde", *(f"{state}_tilde" for state in RUNNING_GRAM))
_W = ("w_1_tilde", "w_2_tilde")


def settling_pencil(
    machine: InductionMachine,
    name: str,
    gains: Gains,
    point: OperatingPoint,
    kind: Kind = "full",
    alpha: Alpha = "adapted",
) -> control.StateSpace:
    """The part that settles of `frozen_pencil` or `full_pencil`, as a `control.StateSpace` with named signals.

    Parameters
    ----------
    machine : InductionMachine
    name : str
        The observer, as in the catalogue.
    gains : mapping or sequence of float
    point : OperatingPoint
        One steady state; a frozen linearisation uses its speed alone.
    kind : str
        ``frozen`` or ``full``.
    alpha : str
        What alpha_hat does: ``adapted`` (it follows omega_hat; only the noise and the voltage error are inputs then, for a
        change of the true speed or alpha moves the balance that the two keep) or ``held`` (``alpha_tilde`` in 1/s is an
        input). Observers that do not estimate alpha are the same either way.

    Returns
    -------
    control.StateSpace
        States and outputs of the pencil without those of z and xi, for which ``w_1_tilde, w_2_tilde`` (A/s) stand. Observers
        without xi keep theirs.

    Raises
    ------
    InputError
        As `frozen_pencil` and `full_pencil`; with alpha adapted but K_p = 0, where omega_hat does not move; and for a full
        linearisation at zero stator frequency.
    """
    import control

    if alpha not in ("adapted", "held"):
        raise InputError(f'alpha = {alpha!r} is not known; choose "adapted" or "held"')
    if kind == "full" and abs(point.omega + point.slip) <= STANDING:
        raise InputError(f"{shown(name)} at omega = {point.omega:g} rad/s and slip = {point.slip:g} rad/s: the {STANDSTILL}, "
                         "and it does not settle; choose a point where omega + slip is not zero")
    if kind == "full" and alpha == "held" and {"g", "alpha_hat"} <= {*known_observer(name).gains, *known_observer(name).states}:
        gains = {**gain_values(name, gains), "g": 0.0}  # without it the laws of some push omega_hat for alpha_hat's sake
    whole = full_pencil(machine, name, gains, point) if kind == "full" else frozen_pencil(machine, name, gains, point.omega)
    if "xi_1_hat" not in known_observer(name).states:
        return whole
    states, inputs = list(whole.state_labels), list(whole.input_labels)
    outputs = [*(label for label in whole.output_labels if label not in _HIDDEN), *_W]
    kept = [label for label in states if label not in (*_HIDDEN, "alpha_tilde")]
    new = [*kept, *_W]
    # into gives the new states of the old ones, back old states that have these new ones, with z_tilde = 0
    into, back = np.zeros((len(new), len(states))), np.zeros((len(states), len(new)))
    for label in kept:
        into[new.index(label), states.index(label)] = back[states.index(label), new.index(label)] = 1
    observed = [lyapunov.observable(z_1, z_2, xi_1, xi_2, machine.alpha, point.omega) for z_1, z_2, xi_1, xi_2 in np.eye(4)]
    into[-2:, [states.index(label) for label in _HIDDEN[:4]]] = np.transpose(observed)
    for xi, w in zip(_HIDDEN[2:4], _W, strict=True):
        back[states.index(xi), new.index(w)] = 1 / machine.alpha
    if kind == "full" and alpha == "adapted":
        back[states.index("alpha_tilde"), new.index("omega_tilde")] = _share(whole.A, states)
        inputs = [label for label in inputs if label not in ("alpha_dot", "omega_dot")]
    B, C, D = whole.B, whole.C, whole.D
    if kind == "full" and alpha == "held":
        column = states.index("alpha_tilde")
        B, D = np.column_stack([B, whole.A[:, column]]), np.column_stack([D, C[:, column]])
        inputs = [label for label in inputs if label != "alpha_dot"] + ["alpha_tilde"]
    driven = [[*whole.input_labels, "alpha_tilde"].index(label) for label in inputs]
    seen = [whole.output_labels.index(label) for label in outputs[:-2]]
    return control.ss(
        into @ whole.A @ back, (into @ B)[:, driven], np.concatenate([C[seen] @ back, np.eye(len(new))[-2:]]),
        np.concatenate([D[seen][:, driven], np.zeros((2, len(driven)))]),
        states=new, inputs=inputs, outputs=outputs, name=f"{known_observer(name).name}_{kind}_settling",
        remove_useless_states=False)


def _share(A: np.ndarray, states: list[str]) -> float:
    """d alpha_hat / d omega_hat: the rows of the two laws are multiples of one another while the flux is constant."""
    law, other = A[states.index("omega_tilde")], A[states.index("alpha_tilde")]
    k = int(np.argmax(np.abs(law)))
    if law[k] == 0:
        raise InputError('K_p = 0 holds omega_hat, so that alpha_hat cannot follow it; take kind="frozen" or alpha="held"')
    return float(other[k] / law[k])


def speed_loop(system: control.StateSpace) -> control.StateSpace:
    """The loop of the speed adaptation, opened at omega_hat: the transfer function L with poles of the system where 1 + L = 0.

    Parameters
    ----------
    system : control.StateSpace
        A linearisation with the state ``omega_tilde``, such as `settling_pencil` gives.

    Raises
    ------
    InputError
        If it has no such state.

    Notes
    -----
    Far above its poles the loop falls with the square of the frequency and its phase tends to -180 degrees. Where it nears
    them from above there is no crossing, but rounding may make one: ``control.stability_margins`` then gives a gain margin
    of 1e12 or more, in place of infinity.
    """
    import control

    states = list(system.state_labels)
    if "omega_tilde" not in states:
        raise InputError('the speed loop needs the state omega_tilde; take a pencil of kind="full"')
    k = states.index("omega_tilde")
    rest = [n for n in range(len(states)) if n != k]
    A = system.A.copy()
    A[:, k] = 0.0  # what omega_hat did now comes in from outside
    C = np.zeros((1, len(states)))
    C[0, k] = -1.0
    order = [*rest, k]
    return control.ss(A[np.ix_(order, order)], system.A[order, k][:, None], C[:, order], 0.0,
                      states=[states[n] for n in order], inputs=["omega_tilde_in"], outputs=["omega_tilde_out"],
                      name=f"{system.name}_speed_loop", remove_useless_states=False)
