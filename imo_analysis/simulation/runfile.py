"""Runs in files: NetCDF (.nc), CSV (.csv) and Parquet (.parquet), each with its study and versions, whole or not at all.

In tables (CSV, Parquet) a row is a time and an estimate's column is named ``omega_hat[observer]``. CSV begins with a line
``# {...}``: the attributes as JSON.
"""

from __future__ import annotations

import json
import re
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.files import replacing
from imo_analysis.simulation.labelled import Labelled

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

SCHEMA = "imo-run/1"
_COLUMN = re.compile(r"(\w+)\[(.+)\]")


def save_run(run: Labelled | xr.Dataset, path: str | Path) -> None:
    """Write a run; the ending of the name says how.

    Parameters
    ----------
    run : xarray.Dataset
        From `simulate`.
    path : str or pathlib.Path
        Ends in .nc, .csv or .parquet.

    Raises
    ------
    InputError
        If the ending is not known or the file cannot be written.
    """
    write = _choose(path, {".nc": write_netcdf, ".csv": _write_csv, ".parquet": _write_parquet})
    with replacing(path) as beside:
        write(run, beside)


def load_run(path: str | Path) -> xr.Dataset:
    """Read a run back into memory.

    Parameters
    ----------
    path : str or pathlib.Path
        Ends in .nc, .csv or .parquet.

    Raises
    ------
    InputError
        If there is no such file or it is not a run.
    """
    read = _choose(path, {".nc": _read_netcdf, ".csv": _read_csv, ".parquet": _read_parquet})
    if not Path(path).is_file():
        raise InputError(f"cannot read {path}: {'it is not a file' if Path(path).exists() else 'there is no such file'}")
    try:
        run = read(Path(path))
    except (OSError, ValueError, KeyError, TypeError, RuntimeError, UnicodeDecodeError) as error:
        reason = str(error).strip().splitlines() or [type(error).__name__]
        raise InputError(f"{path} is not a run that can be read ({reason[0][:120]}); make one: imo simulate --out") from None
    schema = run.attrs.get("schema")
    if schema != SCHEMA or "time" not in run.dims or not ({"omega", "omega_hat"} & set(run.data_vars)):
        raise InputError(f"{path} is not a run: its schema is {schema!r}, not {SCHEMA!r}; make one with: imo simulate --out")
    return run


def check_name(path: str | Path) -> None:
    """Refuse a name whose ending `save_run` does not know."""
    _choose(path, {".nc": None, ".csv": None, ".parquet": None})


def _choose(path: str | Path, ways: dict[str, Any]) -> Any:
    ending = Path(path).suffix.lower()
    if ending not in ways:
        raise InputError(f"{path}: the ending {ending!r} is not known; use one of: {', '.join(ways)}")
    if ending == ".parquet":
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise InputError(f"{path}: Parquet needs pyarrow: pip install 'imo-analysis[parquet]'; or write .nc") from None
    return ways[ending]


def write_netcdf(data: Labelled | xr.Dataset, path: Path) -> None:
    """Write any data set of numbers and text as NetCDF 4, attributes of numbers and text included."""
    # xarray's own writer imports dask where that is installed, which takes longer than the whole simulation; and HDF5 crashes
    # the process when the disk is full, so that it writes to memory and the bytes go to the file in one piece
    import io

    import h5netcdf

    parts = Labelled.of(data)
    memory = io.BytesIO()
    with h5netcdf.File(memory, "w") as file:
        for name, (dimensions, values, attributes) in {**parts.coordinates, **parts.variables}.items():
            for dimension, size in zip(dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.dimensions[dimension] = size
            text = values.dtype.kind in "UO"
            variable = file.create_variable(
                name, dimensions, dtype=h5netcdf.core.h5py.string_dtype() if text else values.dtype,
                data=values.astype(object) if text else values,
            )
            variable.attrs.update(attributes)
        file.attrs.update(parts.attrs)
        beside = [name for name in parts.coordinates if name not in file.dimensions]
        if beside:  # by this attribute readers tell coordinates from data
            file.attrs["coordinates"] = " ".join(beside)
    path.write_bytes(memory.getbuffer())


def _read_netcdf(path: Path) -> xr.Dataset:
    import xarray as xr

    with xr.open_dataset(path, engine="h5netcdf") as run:
        return run.load()


def _frame(run: Labelled) -> pd.DataFrame:
    import pandas as pd

    columns = {"time": run["time"]}
    for name, (dimensions, values, _) in run.variables.items():
        if "observer" in dimensions:
            columns |= {f"{name}[{observer}]": row for observer, row in zip(run["observer"], values, strict=True)}
        else:
            columns[name] = values
    return pd.DataFrame(columns)


def _head(run: Labelled) -> str:
    """All attributes, those of the variables included, as one line of JSON."""
    variables = {name: attributes for name, (_, _, attributes) in {**run.coordinates, **run.variables}.items()}
    attrs = {name: value.item() if isinstance(value, np.generic) else value for name, value in run.attrs.items()}
    return json.dumps({"attrs": attrs, "variables": variables, "observers": [str(name) for name in run["observer"]]})


def _unframe(columns: dict[str, Any], head: str) -> xr.Dataset:
    import xarray as xr

    known = json.loads(head)
    observers, attributes = known["observers"], known["variables"]
    single: dict[str, Any] = {}
    each: dict[str, dict[str, Any]] = {}
    for column, values in columns.items():
        match = _COLUMN.fullmatch(column)
        if match:
            each.setdefault(match[1], {})[match[2]] = values
        elif column != "time":
            single[column] = ("time", values, attributes.get(column, {}))
    for name, rows in each.items():
        single[name] = (("observer", "time"), np.array([rows[observer] for observer in observers]), attributes.get(name, {}))
    coordinates = {"time": ("time", columns["time"], attributes.get("time", {})), "observer": observers}
    return xr.Dataset(single, coords=coordinates, attrs=known["attrs"])


def _write_csv(data: Labelled | xr.Dataset, path: Path) -> None:
    run = Labelled.of(data)
    with open(path, "w", encoding="utf-8", newline="\n") as file:
        file.write(f"# {_head(run)}\n")
        _frame(run).to_csv(file, index=False, lineterminator="\n", na_rep="nan")


def _read_csv(path: Path) -> xr.Dataset:
    with open(path, encoding="utf-8") as file:
        head = file.readline()
        if not head.startswith("# {"):
            raise ValueError("its first line is not '# {...}'; for a recorded log use: imo replay")
        names = file.readline().rstrip("\n").split(",")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # a run that diverged at once has no rows
            rows = np.loadtxt(file, delimiter=",", ndmin=2).reshape(-1, len(names))
    return _unframe({name: rows[:, n] for n, name in enumerate(names)}, head[2:])


def _write_parquet(data: Labelled | xr.Dataset, path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    run = Labelled.of(data)
    table = pa.Table.from_pandas(_frame(run), preserve_index=False)
    pq.write_table(table.replace_schema_metadata({"imo_run": _head(run)}), path)


def _read_parquet(path: Path) -> xr.Dataset:
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    metadata = table.schema.metadata or {}
    if b"imo_run" not in metadata:
        raise ValueError("it has no 'imo_run' in its metadata")
    return _unframe({name: table[name].to_numpy() for name in table.column_names}, metadata[b"imo_run"].decode())


