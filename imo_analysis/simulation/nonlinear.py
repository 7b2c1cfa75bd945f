"""The machine and the observers as python-control's nonlinear systems, for everything that python-control can do with them.

The same definitions as everywhere, called as they are. Thousands of times slower than `simulation.run`.
"""

from __future__ import annotations

from typing import Any

import control as ct

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.plant import torque
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.simulation.kernel import PLANT_STATES
from imo_analysis.simulation.loaded_machine import direction_of, machine_rates


def machine_system(machine: InductionMachine) -> Any:
    """The machine (1) in the stationary frame.

    Parameters
    ----------
    machine : InductionMachine

    Returns
    -------
    control.NonlinearIOSystem
        Inputs ``u_ds, u_qs`` (V) and ``T_l`` (N m); states ``i_ds, i_qs, phi_dr, phi_qr, omega``; outputs the states and
        ``torque`` (N m).
    """
    friction = machine.B / machine.n_p

    def update(t: float, x: Any, u: Any, params: Any) -> Any:
        return machine_rates(tuple(x), (u[0], u[1]), u[2], machine.plant_parameters, friction)

    def output(t: float, x: Any, u: Any, params: Any) -> Any:
        return (*x, torque(tuple(x), machine.n_p, machine.L_m, machine.L_r))

    return ct.nlsys(update, output, inputs=["u_ds", "u_qs", "T_l"], states=list(PLANT_STATES),
                    outputs=[*PLANT_STATES, "torque"], name="machine")


def observer_system(kind: str, machine: InductionMachine, gains: dict[str, float]) -> Any:
    """An observer of the catalogue.

    Parameters
    ----------
    kind : str
        Its name in `equations.catalogue.OBSERVERS`, or a file as `equations.own.located` gives it.
    machine : InductionMachine
        The machine as the observer believes it to be.
    gains : dict of str to float
        All gains of that kind.

    Returns
    -------
    control.NonlinearIOSystem
        Inputs ``i_ds, i_qs`` (A), ``u_ds, u_qs`` (V) and ``omega``, of which the observer is told no more than the
        direction, and only if it needs it; states and outputs the estimates, outputs also ``phi_dr_hat, phi_qr_hat`` (Wb).

    Raises
    ------
    InputError
        If there is no such kind, or a gain is missing or too many.
    """
    observer = OBSERVERS[kind]
    if set(gains) != set(observer.gains):
        raise InputError(f"gains of {observer.name} must be {', '.join(observer.gains)}, not {', '.join(gains) or 'none'}")
    values = tuple(float(gains[name]) for name in observer.gains)
    parameters = machine.observer_parameters
    flux = tuple(name for name in ("phi_dr_hat", "phi_qr_hat") if name not in observer.states)

    def update(t: float, x: Any, u: Any, params: Any) -> Any:
        return observer.rates(tuple(x), (u[0], u[1]), (u[2], u[3]), direction_of(u[4]), parameters, values)

    def output(t: float, x: Any, u: Any, params: Any) -> Any:
        return (*x, *(observer.flux(tuple(x), (u[0], u[1]), machine.beta) if flux else ()))

    return ct.nlsys(update, output, inputs=["i_ds", "i_qs", "u_ds", "u_qs", "omega"], states=list(observer.states),
                    outputs=[*observer.states, *flux], name=observer.name)
