"""The error dynamics of an observer as numbers: `control.StateSpace` with named states, or batches of system matrices.

The matrices come from `imo_analysis.pencils.jacobian`; this file supplies the numbers: machine, gains, speed, and for the
full linearisation a steady operating point of the machine (1).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.equations import across, parameters, plant, supervised, transformation
from imo_analysis.equations.catalogue import PARAMETERS, RUNNING_GRAM
from imo_analysis.errors import InputError
from imo_analysis.machine import InductionMachine
from imo_analysis.notation import symbol
from imo_analysis.pencils.jacobian import Jacobian, Kind, jacobian, known_observer

if TYPE_CHECKING:
    import control

Gains = Mapping[str, float] | Sequence[float]
MACHINE_FIELDS = ("R_s", "R_r", "L_m", "L_s", "L_r")


@dataclass(frozen=True)
class OperatingPoint:
    """A steady state of the machine: constant speed, slip and rotor flux magnitude. Floats, or arrays that broadcast.

    Attributes
    ----------
    omega : float or array
        Electrical rotor speed in rad/s.
    flux : float or array
        Magnitude of the rotor flux in Wb.
    slip : float or array
        Slip frequency in rad/s; the flux turns at ``omega + slip``.
    """

    omega: Any
    flux: Any
    slip: Any = 0.0

    def quantities(self, p: Sequence[Any]) -> dict[str, Any]:
        """Currents, fluxes, z and voltages of the steady state, in the frame of the flux (phi_qr = 0), by name.

        ``p`` is ``(R_s, L_m, sigma, beta, alpha)``. The rows of (1) are affine in the currents and the voltages, so each is
        solved for from the value at zero.

        Parameters
        ----------
        p : machine parameters
            With R_s, L_m, sigma, beta and alpha in SI units.
        """
        _, L_m, sigma, beta, alpha = p
        frame = self.omega + self.slip
        machine = (*p, 0.0, 0.0, 1.0)
        no_current = plant.plant((0.0, 0.0, self.flux, 0.0, self.omega), (0.0, 0.0), frame, 0.0, machine)
        i_ds, i_qs = (-row / (alpha * L_m) for row in no_current[2:4])
        no_voltage = plant.plant((i_ds, i_qs, self.flux, 0.0, self.omega), (0.0, 0.0), frame, 0.0, machine)
        u_ds, u_qs = (-row * sigma for row in no_voltage[:2])
        z_1, z_2 = transformation.to_z(i_ds, i_qs, self.flux, 0.0, beta)
        return {"i_ds": i_ds, "i_qs": i_qs, "phi_dr": self.flux, "phi_qr": 0.0, "z_1": z_1, "z_2": z_2, "xi_1": z_1,
                "xi_2": z_2, "u_ds": u_ds, "u_qs": u_qs, "omega": self.omega, "stator_frequency": frame}


def gain_values(name: str, gains: Gains, needed: Sequence[str] | None = None) -> dict[str, float]:
    """Gains by name, checked.

    Parameters
    ----------
    name : str
        The observer.
    gains : mapping or sequence
        By name, or in the order of the catalogue.
    needed : sequence of str, optional
        Names that must be there; all of the observer's where left out.

    Raises
    ------
    InputError
        If one is unknown, missing or not finite.
    """
    observer = known_observer(name)
    if not isinstance(gains, Mapping):
        if len(gains) != len(observer.gains):
            wanted = ", ".join(observer.gains)
            raise InputError(f"gains of {observer.name} must be {len(observer.gains)} numbers ({wanted}), not {len(gains)}")
        gains = dict(zip(observer.gains, gains, strict=True))
    for gain, value in gains.items():
        if gain not in observer.gains:
            raise InputError(f"gain {gain!r} is not known for {observer.name}; it has: {', '.join(observer.gains)}")
        if not np.all(np.isfinite(value)):
            raise InputError(f"gain {gain} = {value} of {observer.name} must be finite")
    missing = [gain for gain in (observer.gains if needed is None else needed) if gain not in gains]
    if missing:
        raise InputError(f"gains of {observer.name} are missing: {', '.join(missing)}")
    return dict(gains)


def machine_parameters(machine: InductionMachine, changes: Mapping[str, Any]) -> dict[str, Any]:
    """``R_s, L_m, sigma, beta, alpha`` by name, with machine fields or these parameters replaced, also by arrays.

    Raises
    ------
    InputError
        If a replaced inductance, resistance or parameter is one that no machine can have.
    """
    field = {name: np.asarray(changes.get(name, getattr(machine, name)), dtype=float) for name in MACHINE_FIELDS}
    for name, value in field.items():
        _positive(name, value)
    sigma = parameters.leakage(field["L_s"], field["L_m"], field["L_r"])
    if np.any(sigma <= 0):
        worst = np.unravel_index(np.argmin(sigma), sigma.shape)
        L_m, L_s, L_r = (np.broadcast_to(field[name], sigma.shape)[worst] for name in ("L_m", "L_s", "L_r"))
        raise InputError(f"L_m = {L_m:.6g} H must be below sqrt(L_s L_r) = {np.sqrt(L_s * L_r):.6g} H at every point; "
                         f"there L_s = {L_s:.6g} H, L_r = {L_r:.6g} H")
    values = {"R_s": field["R_s"], "L_m": field["L_m"], "sigma": sigma,
              "beta": parameters.coupling(field["L_m"], sigma, field["L_r"]),
              "alpha": parameters.rotor_rate(field["R_r"], field["L_r"])}
    given = {name: np.asarray(value, dtype=float) for name, value in changes.items() if name in PARAMETERS}
    for name, value in given.items():
        _positive(name, value)
    return values | given


def _positive(name: str, value: np.ndarray) -> None:
    bad = value[~(np.isfinite(value) & (value > 0))]
    if bad.size:
        raise InputError(f"{name} = {bad.flat[0]:.6g} {symbol(name).unit} must be above 0 and finite at every point")


def arguments(
    derived: Jacobian,
    machine: InductionMachine,
    gains: Gains,
    point: OperatingPoint,
    changes: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Every number that a Jacobian needs, by name.

    ``changes`` replaces machine fields (R_s, R_r, L_m, L_s, L_r), parameters (sigma, beta, alpha), gains, or omega, slip and
    flux of the operating point, by floats or by arrays that broadcast. The direction of rotation is the sign of omega, and
    +1 at standstill.
    """
    observer = known_observer(derived.observer)
    changes = dict(changes or {})
    known = {*MACHINE_FIELDS, *PARAMETERS, *observer.gains, "omega", "slip", "flux"}
    if unknown := sorted(set(changes) - known):
        raise InputError(f"{unknown[0]!r} is not a parameter of {observer.name}; choose one of: {', '.join(sorted(known))}")
    needed = [gain for gain in observer.gains if gain in derived.arguments and gain not in changes]
    point = replace(point, **{name: changes[name] for name in ("omega", "slip", "flux") if name in changes})
    omega = np.asarray(point.omega, dtype=float)
    if not (np.isfinite(np.sum(omega)) or np.all(np.isfinite(omega))):  # the sum settles it without an array of truths
        raise InputError(f"omega = {point.omega} must be finite, in rad/s")
    values = machine_parameters(machine, changes)
    if derived.kind == "full":
        flux = np.asarray(np.nan if point.flux is None else point.flux, dtype=float)
        if not np.all(np.isfinite(flux) & (flux > 0)):
            raise InputError(f"flux = {point.flux} Wb of the operating point must be above 0")
        if not np.all(np.isfinite(np.asarray(point.slip, dtype=float))):
            raise InputError(f"slip = {point.slip} rad/s of the operating point must be finite")
        point = replace(point, omega=omega)
        values |= point.quantities([values[name] for name in PARAMETERS])
    values |= gain_values(derived.observer, gains, needed)
    values |= {name: value for name, value in changes.items() if name in observer.gains}
    if derived.kind == "full" and set(RUNNING_GRAM) & set(observer.states):
        values |= means_at_rest(values)
    values["omega"] = omega
    if "direction" in derived.arguments:
        values["direction"] = np.where(omega < 0, -1.0, 1.0)
    if "alpha_l" in derived.arguments and np.any(values["alpha"] <= values["alpha_l"]):
        raise InputError(
            f"alpha_l = {values['alpha_l']} /s must be below alpha = {values['alpha']} /s: at or below it the projection (10) "
            "has a kink and no linearisation"
        )
    return values


def means_at_rest(values: Mapping[str, Any]) -> dict[str, Any]:
    """The filters of the supervised observer where all estimates are right, in the frame of the flux.

    Their rows are affine in what they filter, so each is solved for from its values at zero and one.
    """
    eta, frame = values["eta"], values["stator_frequency"]
    x = (values["i_ds"], values["i_qs"], values["z_1"], values["z_2"], values["xi_1"], values["xi_2"])
    v_1, v_2 = across.directions(x, values["L_m"], values["beta"])
    still = (0.0, 0.0)
    forced = supervised.running_gram(v_1, v_2, (*still, *still), 0.0, eta)
    leak = supervised.running_gram(still, still, (1.0, 0.0, *still), 0.0, eta)[0]
    means = [(forced[k] + 1j * forced[k + 1]) / (1j * frame - leak) for k in (0, 2)]
    turning = tuple(part for mean in means for part in (np.real(mean), np.imag(mean)))
    drive = supervised.running_gram(v_1, v_2, turning, 0.0, eta)[4]
    leak = supervised.running_gram(still, still, (*still, *still), 1.0, eta)[4]
    return dict(zip(RUNNING_GRAM, (*turning, -drive / leak), strict=True))


def frozen_matrix(
    machine: InductionMachine, name: str, gains: Gains, omega: Any, changes: Mapping[str, Any] | None = None
) -> np.ndarray:
    """System matrices of the frozen-speed error dynamics, shape ``omega.shape + (n, n)``, in 1/s.

    Parameters
    ----------
    machine : InductionMachine
        As the observer believes it to be: at frozen speed its errors do not depend on the true machine.
    name : str
        The observer, as in the catalogue.
    gains : mapping or sequence of float
        Those that the pencil uses must be there (the adaptation gains need not).
    omega : float or array
        Electrical speed in rad/s.
    changes : mapping, optional
        Machine fields, parameters or gains to replace; see `arguments`.
    """
    derived = jacobian(name, "frozen")
    return derived.system_matrix(arguments(derived, machine, gains, OperatingPoint(omega, None), changes))


def full_matrix(machine: InductionMachine, name: str, gains: Gains, point: OperatingPoint) -> np.ndarray:
    """System matrices of the full linearisation about operating points, shape ``(..., n, n)``, in 1/s."""
    derived = jacobian(name, "full")
    return derived.system_matrix(arguments(derived, machine, gains, point))


def frozen_pencil(machine: InductionMachine, name: str, gains: Gains, omega: float) -> control.StateSpace:
    """The error dynamics at a frozen speed as a `control.StateSpace` with named states, inputs and outputs.

    States are the errors (``i_ds_tilde`` ...), inputs the noise on the measured currents (A) and the error of the voltages
    that the observer is told (V), outputs the states and the error of the reconstructed rotor flux (Wb).

    Parameters
    ----------
    machine : InductionMachine
        The machine that the observer believes in.
    name : str
        Observer, by its name in the catalogue.
    gains : mapping of str to float
        Gains by name, in SI units.
    omega : float
        Electrical speed in rad/s.
    """
    return _state_space(jacobian(name, "frozen"), machine, gains, OperatingPoint(float(omega), None))


def full_pencil(machine: InductionMachine, name: str, gains: Gains, point: OperatingPoint) -> control.StateSpace:
    """The linearisation with the adaptation of speed and alpha, about a steady operating point, in the frame of the flux.

    As `frozen_pencil`, with the states ``omega_tilde`` and, where the observer adapts it, ``alpha_tilde``, and with the rates
    of the true speed and alpha as inputs. What of it never settles is taken out by `imo_analysis.pencils.settling`, for norms,
    step responses and margins.

    Parameters
    ----------
    machine : InductionMachine
        The machine that the observer believes in.
    name : str
        Observer, by its name in the catalogue.
    gains : mapping of str to float
        Gains by name, in SI units.
    point : OperatingPoint
        The steady state.
    """
    return _state_space(jacobian(name, "full"), machine, gains, point)


def _state_space(derived: Jacobian, machine: InductionMachine, gains: Gains, point: OperatingPoint) -> control.StateSpace:
    import control

    whole = derived.evaluate(arguments(derived, machine, gains, point))
    if whole.ndim != 2:
        raise InputError("a state space takes one operating point; use frozen_matrix or full_matrix for many")
    n = len(derived.states)
    return control.ss(
        whole[:n, :n], whole[:n, n:], whole[n:, :n], whole[n:, n:],
        states=list(derived.states), inputs=list(derived.inputs), outputs=list(derived.outputs),
        name=f"{known_observer(derived.observer).name}_{derived.kind}", remove_useless_states=False,
    )


def poles(matrices: np.ndarray) -> np.ndarray:
    """Eigenvalues of a batch of matrices, shape ``(..., n)``, complex, each set sorted by real then imaginary part.

    NaN where an entry of a matrix has overflowed.
    """
    matrices = np.asarray(matrices)
    there = np.all(np.isfinite(matrices), axis=(-1, -2))
    if np.all(there):
        return np.sort(np.linalg.eigvals(matrices).astype(complex, copy=False), axis=-1)
    eigenvalues = np.full(matrices.shape[:-1], np.nan, dtype=complex)
    eigenvalues[there] = np.linalg.eigvals(matrices[there])
    return np.sort(eigenvalues, axis=-1)


def poles_at(
    machine: InductionMachine,
    name: str,
    gains: Gains,
    point: OperatingPoint,
    kind: Kind = "frozen",
    changes: Mapping[str, Any] | None = None,
) -> np.ndarray:
    """Poles of either kind at one or many operating points, shape ``(..., n)``, in 1/s. ``frozen`` uses the speed alone."""
    derived = jacobian(name, kind)
    return poles(derived.system_matrix(arguments(derived, machine, gains, point, changes)))
