"""Whether a study is about the paper's machine: then, and only then, Tables II and III say something about it."""

from __future__ import annotations

from imo_analysis.machine import PAPER_PRESETS, PRESETS, InductionMachine

_TABLE_III = ("n_p", "R_s", "R_r", "L_m", "L_s", "L_r", "J")


def is_paper(machine: InductionMachine) -> bool:
    """Whether the parameters are those of a preset of the paper's, whatever the name; Table III has no friction."""
    return any(all(getattr(machine, field) == getattr(PRESETS[name], field) for field in _TABLE_III) for name in PAPER_PRESETS)
