"""Whether a study is about the paper's machine: then, and only then, Tables II and III say something about it."""

from __future__ import annotations

from imo_analysis.machine import PRESETS, InductionMachine

_TABLE_III = ("n_p", "R_s", "R_r", "L_m", "L_s", "L_r", "J")


def is_paper(machine: InductionMachine) -> bool:
    """Whether the parameters are those of a preset, whatever the machine is called; friction, which Table III lacks, aside."""
    return any(all(getattr(machine, name) == getattr(one, name) for name in _TABLE_III) for one in PRESETS.values())
