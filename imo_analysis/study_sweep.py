"""The table ``[sweep]`` of a study: which fields vary, how, and over what the runs are judged."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import Field, model_validator

from imo_analysis.study_tables import Seconds, Speed, Table


class Sweep(Table):
    """``[sweep]``: Monte Carlo and grids.

    Attributes
    ----------
    scenario : str
        Scenario of the study that the runs are made of; the study itself where left out.
    runs : int
        Random draws, for each point of the grid.
    seed : int
        Of the draws. Draw n is the same whatever ``runs`` is, and at every point of the grid.
    believe : str
        ``nominal``: the observers believe the study's machine, however the real one differs; ``own``: each observer knows the
        machine that it is connected to. Their own ``errors`` come on top.
    start : float
        From this time in s on the errors are taken.
    stop : float
        Until this time in s; to the end of the run where it is left out.
    band : float
        A speed error of no more than this, in rad/s, counts as none.
    hold : float
        An observer holds when its speed error stays within the band during at least this last part, in s, of that time.
    fields : dict
        For each dotted name of a number in the study one table: a grid ``values``, ``linspace``, ``geomspace``, or draws
        ``uniform``, ``log_uniform``, ``normal``, ``relative``.
    """

    scenario: str = ""
    runs: int = Field(default=1, ge=1, le=100_000_000)
    seed: int = Field(default=0, ge=0, lt=2**63)
    believe: Literal["nominal", "own"] = "nominal"
    start: Seconds = Field(default=0.0, ge=0)
    stop: Seconds | None = None
    band: Speed = Field(default=1.0, gt=0)
    hold: Seconds = Field(default=0.1, gt=0)
    fields_: dict[str, Any] = Field(default={}, alias="fields")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.stop is not None and self.stop <= self.start:
            raise ValueError(f"stop = {self.stop:g} s must be after start = {self.start:g} s")
        return self
