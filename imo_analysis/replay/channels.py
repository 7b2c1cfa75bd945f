"""Which channel of a record is dead, reversed or scaled: seen from voltages and currents alone, whatever the machine.

Two signs. Where one of two channels is dead, what they stand for moves along a line while all else turns. Where three phases
were recorded, the sum of the voltages holds an offset, harmonics of order three and the carrier of an inverter, but never
follows the turning voltage, unless one phase is not like the others. The sum of the currents is zero altogether.
"""

from __future__ import annotations

import math

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.replay.logs import Samples

SUM = 0.1  # how far the mean of three phases may follow a phase; one phase that is 30 % too large gives this much
_LINE, _TURNS = 0.98, 0.7  # |sum of x^2| over the sum of |x|^2: 1 on a line, 0 on a circle


def check_channels(stretch: Samples, path: str) -> None:
    """Refuse a stretch in which a channel cannot be what it is taken for.

    Parameters
    ----------
    stretch : Samples
        Of the record, with at least half a turn of the voltages or of the currents in it.
    path : str
        The file, for error texts.

    Raises
    ------
    InputError
        With the phase, where it shows.
    """
    u, i = stretch.u_ds + 1j * stretch.u_qs, stretch.i_ds + 1j * stretch.i_qs
    for name, flat, turning, other in (("voltages", u, i, "currents"), ("currents", i, u, "voltages")):
        if _flatness(flat) > _LINE and _flatness(turning) < _TURNS:
            raise InputError(f"{path}: the {name} swing along one line while the {other} turn: {_dead(flat)}; check its "
                             "column. --trust runs it all the same")
    if stretch.u_zero is not None:
        share, phase = follows(stretch.u_zero, u)
        if share > SUM:
            raise InputError(
                f"{path}: the sum of the three phase voltages follows the voltage of phase {phase} ({share:.2g} of it; only an "
                f"offset or harmonics can be in it): that phase is dead, reversed, scaled otherwise or another column. To use "
                f"the two others: --column u_{phase}=none"
            )


def follows(total: np.ndarray, x: np.ndarray) -> tuple[float, str]:
    """How far the mean of three phases, a third of ``total``, follows their space vector ``x``, and whose error it would be."""
    sides = np.column_stack([x.real, x.imag, np.ones(len(x))])
    (along_d, along_q, _), *_ = np.linalg.lstsq(sides, total / 3, rcond=1e-12)
    axes = 2 * math.pi / 3 * np.arange(3)
    phase = int(np.argmax(np.abs(along_d * np.cos(axes) + along_q * np.sin(axes))))
    return math.hypot(along_d, along_q), "abc"[phase]


def _flatness(x: np.ndarray) -> float:
    return float(abs((x * x).sum()) / max((np.abs(x) ** 2).sum(), 1e-300))


def _dead(x: np.ndarray) -> str:
    """Which phase or axis never moves, from the line that the others leave."""
    angle = math.degrees(np.angle((x * x).sum())) / 2 % 180
    across = {90.0: "phase a or the alpha axis is dead", 30.0: "phase b is dead", 150.0: "phase c is dead",
              0.0: "the beta axis is dead, or phases b and c are the same"}
    near = min(across, key=lambda line: abs((angle - line + 90) % 180 - 90))
    return across[near] if abs((angle - near + 90) % 180 - 90) < 5 else "one of their channels is dead"
