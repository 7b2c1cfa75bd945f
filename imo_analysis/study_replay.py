"""The table ``[replay]`` of a study or machine file: how a recorded log is read and run."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, ValidationError

from imo_analysis.errors import InputError
from imo_analysis.machine import readable
from imo_analysis.study_tables import Rate, Speed, Table


class Replay(Table):
    """``[replay]``: how a recorded log is read and run, for ``imo replay``.

    Attributes
    ----------
    observers : tuple of str
        Observers to run.
    columns : dict
        What a column is called in the log, where its name does not tell.
    units : dict
        The unit of a column in the log, where its name does not tell.
    rate : float, optional
        Samples a second in Hz, in place of the time column.
    voltage : str
        What a sample of the voltage stands for: `imo_analysis.replay.estimate.Treatment`.
    current : str
        What a sample of the current stands for: the same place.
    direction : str
        Where the direction of rotation comes from: the same place.
    gaps : str
        ``stop`` where samples are missing, or ``bridge``: go on behind them, see `imo_analysis.replay.kernel`.
    bandwidth : float, optional
        Of the speed loop in rad/s, from which gains follow.
    gains : dict of str to float
        Gains in place of those that the rule gives.
    initial : dict of str to float
        Estimates to begin with, in place of those that are chosen.
    """

    observers: tuple[str, ...] = ("repaired",)
    columns: dict[str, str] = Field(default={})
    units: dict[str, str] = Field(default={})
    rate: Rate | None = None
    voltage: Literal["linear", "held", "averaged"] = "linear"
    current: Literal["linear", "held"] = "linear"
    direction: Literal["measured", "estimated", "forward", "reverse"] | None = None
    gaps: Literal["stop", "bridge"] = "stop"
    bandwidth: Speed | None = None
    gains: dict[str, float] = Field(default={})
    initial: dict[str, float] = Field(default={})


def read_replay(values: Any, where: str) -> Replay:
    """The table ``[replay]`` of a file.

    Raises
    ------
    InputError
        If anything in it cannot be used; ``where`` names the file.
    """
    if not isinstance(values, dict):
        raise InputError(f"{where}: replay must be a table, [replay]")
    try:
        return Replay(**values)
    except ValidationError as error:
        raise InputError(readable(error, f"{where}: replay", Replay)) from None
