"""What a record that a simulation wrote says of itself: how many of the drive's samples it holds, and how its observers began.

`imo_analysis.simulation.runfile` writes the attributes of a run, its study among them, as JSON into the first line of a CSV
file and into the metadata of a Parquet file. A record of a drive has none.
"""

from __future__ import annotations

import json
import tomllib
from dataclasses import dataclass


@dataclass(frozen=True)
class Origin:
    """The study of a simulated record, as far as replay needs it.

    Attributes
    ----------
    record_every : int
        One sample of the drive in so many is in the record.
    sample_time : float
        Of the drive, in s.
    begun : tuple of str
        Observers whose start the study gives.
    """

    record_every: int
    sample_time: float
    begun: tuple[str, ...]

    @property
    def thinned(self) -> str | None:
        """What is wrong with a record that lacks samples, and the fix; None for a whole one."""
        if self.record_every == 1:
            return None
        return (f"the record has one in {self.record_every} of the samples of its {1 / self.sample_time:.6g} Hz drive "
                "(simulation.record_every of its study): what the voltage did in between is lost, and the estimates suffer; "
                "simulate again with --every 1")


def origin_of(head: str) -> Origin | None:
    """The origin that a file's attributes tell, or None where they are those of no run.

    Parameters
    ----------
    head : str
        JSON, as a run's file has it; any text will do.
    """
    try:
        study = tomllib.loads(json.loads(head)["attrs"]["study"])
        simulation = study["simulation"]
        begun = tuple(name for name, one in study.get("observers", {}).items() if one.get("initial"))
        # 1e-4 s is the default of the study's table
        return Origin(int(simulation.get("record_every", 1)), float(simulation.get("sample_time", 1e-4)), begun)
    except (ValueError, KeyError, TypeError, AttributeError):
        return None
