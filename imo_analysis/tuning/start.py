"""The paper's study rewritten for another machine: gains by the rule of thumb, and levels that this machine can bear.

The paper's flux, currents, torques and gains mean nothing to a motor of another size. Here the gains come from
`imo_analysis.tuning.rule`; currents go with the magnetising current, torques with flux times that, voltages with the flux, and
what stores energy with the inertia. Speeds and times stay. Comments about what the paper's machine does are left out.

Where no flux is given it is estimated from the inductance and the inertia, as typical for standard four-pole motors: the power
grows as J^0.83 and the magnetising reactance per unit as the power^0.2. That is within a fifth of the rated flux of the presets
(a test holds it to that); a name plate knows better.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

from imo_analysis.errors import InputError
from imo_analysis.machine import PRESETS, InductionMachine
from imo_analysis.study import Study, paper_text
from imo_analysis.tuning.rule import Times, rule_gains

# what the paper's [tuning] wishes, with the reserve of `imo_analysis.tuning.wish`
TIMES = Times(settling=0.015, recovery=1.875, omega_max=150.0, lag=0.00075)
_PAPER, _PAPER_FLUX = PRESETS["table-iii-printed-alpha"], 0.5307
_NETWORK = 100 * math.pi  # rad/s
_KINDS = ("printed_7", "printed_L")  # not to be tuned: they take what consistent_12 has
_K_2 = 50.0  # the paper's; k_2 = 0 would make all three feedbacks one
# full lines of comment that hold for any machine
_GENERAL = ("# Numbers are SI", "# Speeds are elec", "# The machine at time 0", "# What else", "# errors =", "# Overlays",
            "# imo sweep", "# likely", "# a number of", "#   draws", "#   grids", "# imo tune", "# what the observers may",
            "# speed_noise", "# speed_error")
_NUMBER = r"-?\d+\.?\d*(?:e-?\d+)?"


@dataclass(frozen=True)
class Levels:
    """Sizes relative to the paper's, by the keys of a study that go with them."""

    flux: float
    current: float
    stator: float
    torque: float
    inertia: float
    alpha: float

    def of(self) -> dict[str, float]:
        """Factor for each key."""
        keys = {
            "flux": self.flux, "phi_dr": self.flux, "phi_dr_hat": self.flux, "knee": self.flux, "voltage_limit": self.flux,
            "dc_link": self.flux, "i_ds": self.current, "i_ds_hat": self.current, "current_limit": self.current,
            "current_noise": self.current, "current_offset": self.current, "current_resolution": self.current,
            "z_1_hat": self.stator, "xi_1_hat": self.stator, "T_l": self.torque, "torque": self.torque, "coulomb": self.torque,
            "stiffness": self.inertia, "damping": self.inertia, "machine.B": self.inertia, "J": self.inertia,
            "alpha_hat": self.alpha,
        }
        return keys


def typical_flux(machine: InductionMachine) -> float:
    """Rated rotor flux in Wb of a standard motor with this inductance and inertia; see the head of this file."""
    power = 2200.0 * (machine.J / 0.015) ** 0.83
    reactance = 1.8 * (power / 2200.0) ** 0.2
    return math.sqrt(power * machine.L_s / (reactance * _NETWORK))


def study_text(machine: InductionMachine, flux: float | None = None) -> str:
    """The study as commented TOML, checked with all its scenarios.

    Parameters
    ----------
    machine : InductionMachine
        Any.
    flux : float, optional
        Magnitude of the rotor flux in Wb; `typical_flux` where left out.

    Raises
    ------
    InputError
        If the flux is not one, or the machine cannot be used.
    """
    estimated = flux is None
    flux = typical_flux(machine) if flux is None else flux
    if not (math.isfinite(flux) and flux > 0):
        raise InputError(f"flux = {flux:g} Wb must be above 0 Wb")
    current, stator = flux / machine.L_m, flux / machine.L_m + machine.beta * flux
    of_paper = _PAPER_FLUX / _PAPER.L_m
    torque = machine.n_p * machine.L_m / machine.L_r * flux * current
    levels = Levels(
        flux / _PAPER_FLUX, current / of_paper, stator / (of_paper + _PAPER.beta * _PAPER_FLUX),
        torque / (_PAPER.n_p * _PAPER.L_m / _PAPER.L_r * _PAPER_FLUX * of_paper), machine.J / _PAPER.J,
        machine.alpha / _PAPER.alpha)
    before, rest = paper_text().split("[machine]\n")
    _, rest = rest.split("[simulation]\n", 1)
    source = ("estimated from L_s and J as typical (imo_analysis.tuning.start), for want of a name plate" if estimated
              else "as given")
    head = [
        "# The study of the paper for another machine, written by imo study --init. Check it against the motor's name plate:",
        f"# the flux is {flux:.4g} Wb, {source};",
        "# currents, torques and voltages are the paper's, scaled to it.",
        "# Gains by the rule of thumb (imo_analysis.tuning.rule): speed estimate settled in "
        f"{1e3 * TIMES.settling:g} ms, flux in {TIMES.recovery:g} s,",
        f"# damping {TIMES.damping:g}. imo tune FILE looks for better ones.",
        *(line for line in before.splitlines() if line.startswith(_GENERAL)), "", f'title = "{_title(machine)}"', "",
    ]
    text = "\n".join(head) + f"\n{machine.to_toml()}\n[simulation]\n" + _rewritten(rest, machine, flux, levels.of())
    Study.from_toml(text, "the study with this machine")
    return text


def _title(machine: InductionMachine) -> str:
    name = re.sub(r'[^\w +.,-]', " ", machine.name).strip()
    return name if name and name != "unnamed" else "another machine"


def _rewritten(text: str, machine: InductionMachine, flux: float, factors: dict[str, float]) -> str:
    """Line by line: numbers under scaled keys, gains of every kind; comments about the paper's machine left out."""
    keys = "|".join(re.escape(key) for key in factors)
    scaled = re.compile(rf"(?<![\w.])((?:\w+\.)*)({keys}) = (\[[^\]]*\]|{_NUMBER})")
    lines, table, kind = [], "", ""
    for line in text.splitlines():
        if line.startswith("#"):
            if line.startswith(_GENERAL):
                lines.append(line)
            continue
        if line.startswith("["):
            table, kind = line.strip("[] "), ""
        if found := re.match(r'kind = "(\w+)"', line):
            kind = found[1]
        if re.match(r"observers\.\w+\.gains = ", line):
            continue  # overlays of the paper's gains
        if line.startswith("gains = "):
            lines.append(f"gains = {_gains(kind, machine, flux)}")
            continue
        code, hash_, comment = line.partition("#")
        if "Table III" in comment or "+-60 A" in comment:
            comment = " Wb" if "flux" in code else " A"
        if table.startswith("scenarios"):  # titles and captions
            code = re.sub(r"(?<=[ -])(\d+) N m", lambda match: f"{float(match[1]) * factors['T_l']:.3g} N m", code)
            code = code.replace("alpha_hat from 6.6", f"alpha_hat from {6.6 * factors['alpha_hat']:.3g}")
        if not table.startswith(("sweep", "reference")) and not (table == "tuning" and code.startswith("damping")):
            code = scaled.sub(lambda match: f"{match[1]}{match[2]} = {_times(match[3], factors[match[2]])}", code)
        lines.append((code + hash_ + comment).rstrip())
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)) + "\n"


def _times(numbers: str, factor: float) -> str:
    return re.sub(_NUMBER, lambda match: repr(float(f"{float(match[0]) * factor:.5g}")), numbers)


def _gains(kind: str, machine: InductionMachine, flux: float) -> str:
    gains: dict[str, Any] = rule_gains(machine, "consistent_12" if kind in _KINDS else kind, flux, TIMES)
    if kind in _KINDS:
        gains["k_2"] = _K_2
    return "{ " + ", ".join(f"{name} = {float(f'{value:.5g}')!r}" for name, value in gains.items()) + " }"
