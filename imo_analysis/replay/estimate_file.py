"""The result of a replay in a NetCDF file, written block by block, so that memory does not grow with the record."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.files import replacing
from imo_analysis.replay.estimate import Estimates, attributes
from imo_analysis.replay.logs import BLOCK


def write_estimates(
    blocks: Iterable[Estimates],
    path: str | Path,
    rows: int,
    observers: Sequence[str],
    attrs: Mapping[str, Any],
    every: int = 1,
    watch: Callable[[Estimates], None] | None = None,
) -> None:
    """Write estimates as they come, whole or not at all.

    Parameters
    ----------
    blocks : iterable of Estimates
        From `imo_analysis.replay.estimate.estimate`.
    path : str or Path
        A name that ends in ``.nc``.
    rows : int
        Samples in the record.
    observers : sequence of str
        Their names, in order.
    attrs : mapping
        From `imo_analysis.replay.estimate.provenance`.
    every : int
        Keep one sample in so many.
    watch : callable, optional
        Is shown every block, with all its samples.

    Raises
    ------
    InputError
        If the name has another ending or the file cannot be written.
    """
    import h5netcdf

    if Path(path).suffix.lower() != ".nc":
        raise InputError(f"{path}: replay writes NetCDF; end the name in .nc")
    if every < 1:
        raise InputError(f"every = {every} must be 1 or more")
    kept = math.ceil(rows / every)
    with replacing(path) as beside, h5netcdf.File(beside, "w") as file:
        file.dimensions = {"time": kept, "observer": len(observers)}
        names = file.create_variable("observer", ("observer",), dtype=h5netcdf.core.h5py.string_dtype(),
                                     data=np.array(observers, dtype=object))
        names.attrs["long_name"] = "observer"
        file.attrs.update(attrs)
        variables: dict[str, Any] = {}
        for block in blocks:
            part = slice(-block.first % every, None, every)
            at = math.ceil(block.first / every)
            for name, values in block.values.items():
                if name not in variables:
                    dims = ("time",) if values.ndim == 1 else ("observer", "time")
                    chunks = (min(kept, BLOCK),) if values.ndim == 1 else (1, min(kept, BLOCK))
                    variables[name] = file.create_variable(name, dims, dtype="f8", chunks=chunks)
                    variables[name].attrs.update(attributes(name))
                few = values[..., part]
                if few.shape[-1]:
                    variables[name][..., at : at + few.shape[-1]] = few
            if watch:
                watch(block)
