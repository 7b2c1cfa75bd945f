"""Second routes to linearisations and resting states: complex steps through the plain definitions, and scalar root finding.

Nothing here uses sympy, `imo_analysis.pencils` or `imo_analysis.simulation`. The machine's steady state is solved for in the
complex shorthand; errors, frame and signs are put together anew.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from imo_analysis.equations.catalogue import OBSERVERS, PARAMETERS, RUNNING_GRAM
from imo_analysis.equations.plant import plant_z

STEP = 1e-30
SCALARS = ("alpha_hat", "omega_hat", "R_s_shift", "S")


def steady(p: dict[str, float], omega: float, flux: float, slip: float) -> dict[str, complex]:
    """Current, z and voltage of the machine with its rotor flux along the real axis, in complex shorthand."""
    frame = omega + slip
    i = flux * (1 + 1j * slip / p["alpha"]) / p["L_m"]
    z = i + p["beta"] * flux
    u = p["R_s"] * i + 1j * frame * p["sigma"] * z  # z is the stator flux over sigma
    return {"i": i, "z": z, "u": u, "phi": complex(flux), "frame": complex(frame)}


def rates_in_frame(name: str, p: dict[str, float], gains: dict[str, float], x: Any, i: Any, u: Any, frame: float,
                   direction: float) -> np.ndarray:
    """Rates of all estimates, in the order of the catalogue, in a frame that turns."""
    observer = OBSERVERS[name]
    rates = np.array(observer.rates(tuple(x), tuple(i), tuple(u), direction, tuple(p[key] for key in PARAMETERS),
                                    tuple(gains[gain] for gain in observer.gains)))
    vectors = [k for k, state in enumerate(observer.states) if state not in SCALARS]
    for d, q in zip(vectors[::2], vectors[1::2], strict=True):
        rates[d] += frame * x[q]
        rates[q] -= frame * x[d]
    return rates


def truth(name: str, p: dict[str, float], gains: dict[str, float], omega: float, flux: float, slip: float) -> dict[str, Any]:
    """Estimates, currents and voltages where every estimate is right, in the frame of the flux."""
    at = steady(p, omega, flux, slip)
    vector = {"i": at["i"], "z": at["z"], "xi": at["z"], "phi": at["phi"]}
    values = {"alpha_hat": p["alpha"], "omega_hat": omega, "R_s_shift": 0.0}
    for label, number in vector.items():
        first, second = {"i": ("i_ds", "i_qs"), "phi": ("phi_dr", "phi_qr")}.get(label, (f"{label}_1", f"{label}_2"))
        values |= {f"{first}_hat": number.real, f"{second}_hat": number.imag}
    if RUNNING_GRAM[0] in OBSERVERS[name].states:
        values |= _means_at_rest(p, gains, at, omega, slip)
    x = [values[state] for state in OBSERVERS[name].states]
    return {"x": x, "i": (at["i"].real, at["i"].imag), "u": (at["u"].real, at["u"].imag), "frame": at["frame"].real}


def _means_at_rest(p: dict[str, float], gains: dict[str, float], at: dict[str, complex], omega: float, slip: float
                   ) -> dict[str, float]:
    """The supervisor's filters of turning regressors: low-pass filters of a constant, seen from the turning frame."""
    frame, eta = omega + slip, gains["eta"]
    v_2 = -1j * p["beta"] * at["phi"]
    v_1 = slip / p["alpha"] * v_2
    m_1, m_2 = (eta * v / (eta + 1j * frame) for v in (v_1, v_2))
    d_1, d_2 = v_1 - m_1, v_2 - m_2
    r = d_1 - (d_1 * d_2.conjugate()).real / (abs(d_2) ** 2 + 1) * d_2
    return dict(zip(RUNNING_GRAM, (m_1.real, m_1.imag, m_2.real, m_2.imag, abs(r) ** 2), strict=True))


def full(name: str, p: dict[str, float], gains: dict[str, float], omega: float, flux: float, slip: float) -> np.ndarray:
    """The system matrix with all adaptation, at the truth: plant rates do not depend on the errors."""
    at = truth(name, p, gains, omega, flux, slip)
    return at_estimates(name, p, gains, at["x"], at["i"], at["u"], at["frame"], -1.0 if omega < 0 else 1.0)


def at_estimates(name: str, p: dict[str, float], gains: dict[str, float], x: Any, i: Any, u: Any, frame: float,
                 direction: float) -> np.ndarray:
    """Jacobian of the rates by the estimates at any estimates; the same as that of the errors' rates by the errors."""
    n = len(x)
    A = np.empty((n, n))
    for k in range(n):
        moved = np.array(x, dtype=complex)
        moved[k] += STEP * 1j
        A[:, k] = rates_in_frame(name, p, gains, moved, i, u, frame, direction).imag / STEP
    return A


def frozen(name: str, p: dict[str, float], gains: dict[str, float], omega: float) -> np.ndarray:
    """The system matrix with omega_hat and alpha_hat held right, by complex steps of plant minus observer at a random state.

    The errors' rates must not depend on that state, so that it is taken at random.
    """
    observer = OBSERVERS[name]
    random = np.random.default_rng(3)
    i, z, u = random.normal(size=(3, 2))
    phi = (z - i) / p["beta"]
    true = {"i_ds": i[0], "i_qs": i[1], "z_1": z[0], "z_2": z[1], "xi_1": z[0], "xi_2": z[1], "phi_dr": phi[0],
            "phi_qr": phi[1], "alpha": p["alpha"], "omega": omega, "R_s_shift": 0.0} | dict.fromkeys(RUNNING_GRAM, 0.0)
    kept = [state for state in observer.states if state not in (*SCALARS, *RUNNING_GRAM)]
    z_rates = plant_z((*i, *z), tuple(u), omega, 0.0, tuple(p[key] for key in PARAMETERS))
    machine = {"i_ds": z_rates[0], "i_qs": z_rates[1], "z_1": z_rates[2], "z_2": z_rates[3], "xi_1": z_rates[2],
               "xi_2": z_rates[3], "phi_dr": (z_rates[2] - z_rates[0]) / p["beta"],
               "phi_qr": (z_rates[3] - z_rates[1]) / p["beta"]}
    A = np.empty((len(kept), len(kept)))
    for k, error in enumerate(kept):
        x = np.array([true[state.removesuffix("_hat")] for state in observer.states], dtype=complex)
        x[observer.states.index(error)] -= STEP * 1j  # estimate = true - error
        rates = dict(zip(observer.states, rates_in_frame(name, p, gains, x, i, u, 0.0, -1.0 if omega < 0 else 1.0),
                         strict=True))
        A[:, k] = [np.imag(machine[row.removesuffix("_hat")] - rates[row]) / STEP for row in kept]
    return A


def resting_speed(name: str, true: dict[str, float], believed: dict[str, float], gains: dict[str, float], omega: float,
                  flux: float, slip: float, reach: float) -> float:
    """omega_hat of the resting observer nearest to omega, by a scalar root: given omega_hat, all else is linear.

    ``reach`` in rad/s is how far from omega it is looked for. alpha_hat is held at what is believed.
    """
    from scipy.optimize import brentq

    at = steady(true, omega, flux, slip)
    observer = OBSERVERS[name]
    i, u, frame = (at["i"].real, at["i"].imag), (at["u"].real, at["u"].imag), at["frame"].real
    direction = -1.0 if omega < 0 else 1.0
    vectors = [k for k, state in enumerate(observer.states) if state not in SCALARS and state not in RUNNING_GRAM]
    law = observer.states.index("omega_hat")

    def drive(omega_hat: float) -> float:
        def rates(part: np.ndarray) -> np.ndarray:
            x = np.zeros(len(observer.states))
            x[vectors] = part
            x[law] = omega_hat
            if "alpha_hat" in observer.states:
                x[observer.states.index("alpha_hat")] = believed["alpha"]
            return rates_in_frame(name, believed, {**gains, "g": 0.0}, x, i, u, frame, direction)

        offset = rates(np.zeros(len(vectors)))[vectors]
        slope = np.stack([rates(unit)[vectors] - offset for unit in np.eye(len(vectors))], axis=1)
        return float(rates(np.linalg.solve(slope, -offset))[law])

    grid = np.linspace(-reach, reach, 401)
    values = [drive(omega + shift) for shift in grid]
    brackets = [k for k in range(400) if values[k] * values[k + 1] < 0]
    roots = [brentq(drive, omega + grid[k], omega + grid[k + 1], xtol=1e-13, rtol=1e-14) for k in brackets]
    return min(roots, key=lambda root: abs(root - omega)) if roots else float("nan")
