"""motulator beside us: its simulation of our task, drive for drive and state for state, and of its own sensorless drive.

`same_task` gives motulator's environment (its machine, its converter, its loop around `solve_ivp`) the drive of
`imo_analysis.simulation.drive` as the control system, and the observer as one more subsystem of the model. `own_drive` is
motulator's sensorless control of the same machine.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.contenders import KIND, Task
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.machine import InductionMachine
from imo_analysis.simulation import drive
from imo_analysis.simulation.loaded_machine import direction_of
from imo_analysis.simulation.run import drive_parameters
from imo_analysis.study import Study

_U_DC = 700.0


def _parameters(machine: InductionMachine) -> Any:
    from motulator.drive.utils import InductionMachineInvGammaPars

    form = machine.inverse_gamma()
    return InductionMachineInvGammaPars(n_p=machine.n_p, R_s=form["R_s"], R_R=form["R_R"], L_sgm=form["L_sgm"],
                                        L_M=form["L_M"])


def _with_observer(mdl: Any, task: Task) -> Any:
    """The model with the observer of the task beside its machine, fed with the machine's current and the voltage."""
    from motulator.common.model import Subsystem

    names = OBSERVERS[KIND].states
    p, gains = task.study.machine.observer_parameters, task.study.observers[KIND].gain_values

    class Observer(Subsystem):
        def __init__(self) -> None:
            super().__init__()
            self.state = SimpleNamespace(**dict(zip(names, map(complex, task.y), strict=True)))
            self.sol_states = SimpleNamespace(**{name: [] for name in names})

        def rhs(self) -> list[float]:
            x = tuple(value.real for value in vars(self.state).values())
            i, u = complex(mdl.machine.out.i_ss), complex(mdl.converter.out.u_cs)
            direction = direction_of(mdl.mechanics.out.w_M.real)
            return list(OBSERVERS[KIND].rates(x, (i.real, i.imag), (u.real, u.imag), direction, p, gains))

    mdl.subsystems.append(Observer())
    return mdl


def _model(machine: InductionMachine) -> Any:
    from motulator.drive import model
    from motulator.drive.utils import InductionMachinePars

    own = InductionMachinePars.from_inv_gamma_model_pars(_parameters(machine))
    return model.Drive(model.VoltageSourceConverter(u_dc=_U_DC), model.InductionMachine(own),
                       model.StiffMechanicalSystem(J=machine.J, B_L=machine.B))


class _OurDrive:
    """The drive of the task, as a control system of motulator."""

    def __init__(self, task: Task) -> None:
        self.task, self.sample, self.p, self.d = task, 0, task.study.machine.plant_parameters, drive_parameters(task.study)
        self.control, self.flux, self.flow = tuple(task.c[:3]), tuple(task.c[3:5]), tuple(task.c[5:7])

    def __call__(self, mdl: Any) -> tuple[float, Any]:
        from motulator.common.utils import abc2complex, complex2abc

        task, k = self.task, min(self.sample, self.task.samples - 1)
        T, measured = task.study.simulation.sample_time, complex(abc2complex(mdl.machine.meas_currents()))
        i, omega = (measured.real, measured.imag), float(np.real(mdl.mechanics.meas_speed())) * task.study.machine.n_p
        u, self.control = drive.control(self.control, i, omega, self.flux, task.inputs[0, k], task.inputs[1, k], self.p, self.d)
        self.flux, self.flow = drive.flux_model(self.flux, self.flow, i, omega, T, self.p)
        self.sample += 1
        return T, complex2abc(complex(*u)) / _U_DC

    def post_process(self) -> None:
        """Nothing is kept."""


def same_task(task: Task, rtol: float | None = None) -> np.ndarray:
    """The 13 states at the end of the task, without load, in motulator's simulation.

    With ``rtol`` its solver is DOP853 at that tolerance in place of the RK45 at 1e-3 that it takes.
    """
    from motulator.common.model import _simulation as inside
    from motulator.common.model._simulation import Delay
    from motulator.drive.model import Simulation

    assert not np.any(task.inputs[2])
    machine = task.study.machine
    turns = machine.L_s / machine.L_m
    mdl, control = _with_observer(_model(machine), task), _OurDrive(task)
    mdl.delay = Delay(0)
    i, phi = complex(task.x[0], task.x[1]), complex(task.x[2], task.x[3])
    stator = machine.L_s * i + machine.L_m * (phi - machine.L_m * i) / machine.L_r
    mdl.machine.state.psi_ss, mdl.machine.state.psi_rs = stator, turns * phi
    mdl.mechanics.state.w_M = task.x[4] / machine.n_p
    solver = inside.solve_ivp

    def tight(rates: Any, span: Any, start: Any, **_: Any) -> Any:
        return solver(rates, span, start, method="DOP853", rtol=rtol, atol=rtol)

    with patch.object(inside, "solve_ivp", tight if rtol else solver):
        Simulation(mdl, control).simulate(t_stop=(task.samples - 0.5) * task.study.simulation.sample_time)
    mdl.set_states([values[-1] for part in mdl.subsystems for values in vars(part.sol_states).values()])
    i, phi = complex(mdl.machine.i_ss), complex(mdl.machine.state.psi_rs) / turns
    return np.array([i.real, i.imag, phi.real, phi.imag, mdl.mechanics.state.w_M.real * machine.n_p,
                     *(value.real for value in vars(mdl.subsystems[-1].state).values())])


def own_drive(seconds: float) -> float:
    """motulator's own sensorless vector control of the same machine at 10 kHz: its way, not our trajectory; final speed."""
    from motulator.drive import model
    from motulator.drive.control import im

    machine = Study.paper().machine
    parameters = _parameters(machine)
    plant = _model(machine)
    reference = im.CurrentReferenceCfg(parameters, max_i_s=60.0)
    loop = im.CurrentVectorControl(parameters, reference, J=machine.J, T_s=1e-4, sensorless=True)
    loop.ref.w_m = lambda t: 20.0 if t < seconds / 5 else 40.0
    simulation = model.Simulation(plant, loop)
    simulation.simulate(t_stop=seconds)
    return float(plant.data.mechanics.w_M[-1]) if hasattr(plant, "data") else float(plant.mechanics.data.w_M[-1])
