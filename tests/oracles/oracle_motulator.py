"""The machine as the motulator project models it (Gamma form, complex fluxes), fed with held voltages."""

from types import SimpleNamespace

import numpy as np
from motulator.drive.model import InductionMachine as MotulatorMachine
from motulator.drive.utils import InductionMachineInvGammaPars, InductionMachinePars
from scipy.integrate import solve_ivp


def run(machine, u, T_l, T, omega_0=0.0):
    """Current (complex, A), speed (electrical rad/s) and torque (N m) at the samples, from standstill fluxes of zero."""
    form = machine.inverse_gamma()
    inverse_gamma = InductionMachineInvGammaPars(n_p=machine.n_p, R_s=form["R_s"], R_R=form["R_R"], L_sgm=form["L_sgm"],
                                                 L_M=form["L_M"])
    other = MotulatorMachine(InductionMachinePars.from_inv_gamma_model_pars(inverse_gamma))
    other.out = SimpleNamespace()
    other.inp = SimpleNamespace()

    def place(y):
        other.state.psi_ss, other.state.psi_rs = complex(y[0], y[1]), complex(y[2], y[3])
        other.set_outputs(0.0)

    def rates(_, y, voltage, load):
        place(y)
        other.inp.u_ss, other.inp.w_M = voltage, y[4]
        stator, rotor = other.rhs()
        return [stator.real, stator.imag, rotor.real, rotor.imag, (other.out.tau_M - load - machine.B * y[4]) / machine.J]

    y = np.array([0.0, 0.0, 0.0, 0.0, omega_0 / machine.n_p])
    kept = []
    for voltage, load in zip(u, T_l, strict=True):
        place(y)
        kept.append((other.out.i_ss, y[4] * machine.n_p, other.out.tau_M))
        y = solve_ivp(rates, (0.0, T), y, args=(voltage, load), method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    return tuple(np.array(column) for column in zip(*kept, strict=True))
