"""Recorded logs, read in blocks of rows: CSV and Parquet, columns and units made out, stationary-frame SI quantities out.

Three-phase quantities become d/q ones by the amplitude-invariant Clarke transformation; a zero sequence drops out of it.
"""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from imo_analysis.errors import InputError
from imo_analysis.replay.columns import Column, choose
from imo_analysis.replay.origin import Origin, origin_of

BLOCK = 65_536
LEAST_ROWS = 50  # with fewer, neither noise nor flux can be told
_DELIMITERS = ",;\t"


@dataclass(frozen=True)
class Samples:
    """A block of a log in SI units; all arrays have one entry a sample.

    Attributes
    ----------
    first : int
        Row of the first sample in the file, from 0.
    time : numpy.ndarray
        s.
    u_ds, u_qs, i_ds, i_qs : numpy.ndarray
        V and A, stationary frame.
    omega : numpy.ndarray or None
        Measured speed, electrical rad/s.
    i_zero, u_zero : numpy.ndarray or None
        Sums of the three phase currents in A and voltages in V, where all three were recorded.
    """

    first: int
    time: np.ndarray
    u_ds: np.ndarray
    u_qs: np.ndarray
    i_ds: np.ndarray
    i_qs: np.ndarray
    omega: np.ndarray | None
    i_zero: np.ndarray | None
    u_zero: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.time)

    def part(self, which: slice | np.ndarray) -> Samples:
        """Some of the samples; ``first`` stays that of the block."""
        arrays = {one.name: getattr(self, one.name) for one in fields(self) if one.name != "first"}
        return replace(self, **{name: values[which] for name, values in arrays.items() if values is not None})


@dataclass(frozen=True)
class Log:
    """A log that was opened: its columns are known, its rows not yet read.

    Attributes
    ----------
    path : pathlib.Path
        The file.
    columns : tuple of Column
        What is read, in order.
    pole_pairs : int
        Multiplies a mechanical speed.
    rate : float or None
        Samples a second, where the user said it; the time column is then not used.
    """

    path: Path
    columns: tuple[Column, ...]
    pole_pairs: int
    rate: float | None = None
    _table: Any = field(default=None, repr=False)

    @classmethod
    def open(
        cls,
        path: str | Path,
        pole_pairs: int,
        columns: Mapping[str, str] | None = None,
        units: Mapping[str, str] | None = None,
        rate: float | None = None,
    ) -> Log:
        """Look at the head of the file and make out its columns.

        Parameters
        ----------
        path : str or Path
            A ``.parquet`` file, or text with a header line and comma, semicolon or tab between the columns.
        pole_pairs : int
            Of the machine, for a speed that is mechanical.
        columns, units : mapping, optional
            What the user says, as `imo_analysis.replay.columns.choose` takes it.
        rate : float, optional
            Samples a second in Hz, in place of the time column.

        Raises
        ------
        InputError
            If the file cannot be read, is no log, or lacks something.
        """
        path = Path(path)
        if rate is not None and not (math.isfinite(rate) and rate > 0):
            raise InputError(f"rate = {rate:g} Hz must be above 0 Hz")
        table: Any = _Parquet(path) if path.suffix.lower() in (".parquet", ".pq") else _Text(path)
        chosen = choose(table.header, columns or {}, units or {}, str(path), timed=rate is None)
        for column in chosen:
            if table.header.count(column.name) > 1:
                raise InputError(f"{path}: the column {column.name!r} is there twice; give every column a name of its own")
        return cls(path, tuple(chosen), pole_pairs, rate, table)

    @property
    def origin(self) -> Origin | None:
        """The study of a record that a simulation wrote."""
        return origin_of(self._table.head)

    @property
    def has_speed(self) -> bool:
        """Whether a speed was recorded."""
        return self.columns[-1].role.startswith("omega")

    def mapping(self) -> list[str]:
        """What was taken for what, a line a column."""
        lines = [column.text for column in self.columns]
        if self.rate is not None:
            lines.insert(0, f"time = row number / {self.rate:g} Hz")
        if self.has_speed:
            last = self.columns[-1]
            mechanical = f"shaft speed, times n_p = {self.pole_pairs}"
            lines[-1] += f" ({mechanical if last.role == 'omega_m' else 'electrical speed, taken as it is'})"
        return lines

    def blocks(self, rows: int = BLOCK) -> Iterator[Samples]:
        """The samples, ``rows`` at a time; only the last block is shorter.

        Parameters
        ----------
        rows : int
            Samples in a block.

        Raises
        ------
        InputError
            If a row is broken or a value is missing; the text has line, column and what is there.
        """
        first = 0
        for raw in _equal(self._table.read([column.name for column in self.columns]), rows):
            if not np.isfinite(raw).all():
                row, place = (int(k) for k in np.argwhere(~np.isfinite(raw))[0])
                self._table.blame(first + row, [self._table.header.index(self.columns[place].name)])
            yield self._samples(first, raw * np.array([column.factor for column in self.columns]))
            first += len(raw)
        if first < LEAST_ROWS:
            raise InputError(too_short(self.path, first))

    def place(self, row: int) -> str:
        """Where a row stands, for error texts.

        Parameters
        ----------
        row : int
            Number of the sample.
        """
        return str(self._table.place(row))

    def _samples(self, first: int, values: np.ndarray) -> Samples:
        by_role = {column.role: values[:, k] for k, column in enumerate(self.columns)}
        time = by_role["time"] if self.rate is None else (first + np.arange(len(values))) / self.rate
        omega = by_role.get("omega")
        if "omega_m" in by_role:
            omega = by_role["omega_m"] * self.pole_pairs
        sums = _sum(by_role, "i"), _sum(by_role, "u")
        return Samples(first, time, *_clarke(by_role, "u"), *_clarke(by_role, "i"), omega, *sums)


def _sum(by_role: Mapping[str, np.ndarray], letter: str) -> np.ndarray | None:
    roles = [f"{letter}_{phase}" for phase in "abc"]
    return by_role[roles[0]] + by_role[roles[1]] + by_role[roles[2]] if set(roles) <= by_role.keys() else None


def _clarke(by_role: Mapping[str, np.ndarray], letter: str) -> tuple[np.ndarray, np.ndarray]:
    """Stationary-frame components, amplitude-invariant, of whatever complete set was chosen."""
    has = {role[2:]: values for role, values in by_role.items() if role.startswith(letter + "_")}
    if "d" in has:
        return has["d"], has["q"]
    if not {"a", "b", "c"} & has.keys():
        return _clarke_lines(has)
    if len(has) == 2:
        missing = ({"a", "b", "c"} - has.keys()).pop()
        has[missing] = -np.sum(list(has.values()), axis=0)
    return (2 * has["a"] - has["b"] - has["c"]) / 3, (has["b"] - has["c"]) / math.sqrt(3)


def _clarke_lines(has: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Of two line-to-line voltages, or of three, whose sum, an error of measurement, drops out."""
    for missing in {"ab", "bc", "ca"} - has.keys():
        has = {**has, missing: -np.sum(list(has.values()), axis=0)}
    return (has["ab"] - has["ca"]) / 3, (2 * has["bc"] - has["ab"] - has["ca"]) / (3 * math.sqrt(3))


def too_short(path: Path, rows: int) -> str:
    """The text for a record with too few samples."""
    return f"{path}: {rows} row(s) of data are too short a record; it takes {LEAST_ROWS} samples or more"


def _equal(chunks: Iterator[np.ndarray], rows: int) -> Iterator[np.ndarray]:
    """The same rows in chunks of one size, however the reader cut them."""
    held: list[np.ndarray] = []
    count = 0
    for chunk in chunks:
        while len(chunk):
            take = min(rows - count, len(chunk))
            held.append(chunk[:take])
            chunk = chunk[take:]
            count += take
            if count == rows:
                yield np.concatenate(held)
                held, count = [], 0
    if count:
        yield np.concatenate(held)


class _Text:
    """Delimited text. Read by pyarrow where it is installed, else by numpy; the numbers are the same."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._open() as file:
            self.skip = 0
            self.head = ""
            for line in file:
                self.skip += 1
                if self.skip == 1 and line.startswith("# {"):
                    self.head = line[2:]
                if line.strip() and not line.lstrip().startswith("#"):
                    break
            else:
                raise InputError(f"{path} is empty; a log has a header line and rows of numbers")
            first_row = next(file, "")
        if "\0" in line or len(line) > 100_000:
            raise InputError(f"{path} is not a text file with columns; a log is CSV or Parquet")
        self.delimiter = max(_DELIMITERS, key=line.count)
        # as spreadsheets write where decimals have a comma
        self.decimal = "," if self.delimiter != "," and "," in first_row else "."
        self.header = [name.strip() for name in next(csv.reader([line], delimiter=self.delimiter))]
        if len(self.header) < 2:
            raise InputError(f"{path}: its first line has one column, {line.strip()[:60]!r}; a log has several, "
                             "with comma, semicolon or tab between them")
        if all(_number(name) is not None for name in self.header):
            raise InputError(f"{path}: the first line holds numbers, not names; put a header line above it")

    def _open(self) -> Any:
        try:
            return _Decoded(open(self.path, encoding="utf-8-sig", newline=""), self.path)
        except OSError as error:
            raise InputError(f"cannot read {self.path}: {error.strerror}") from None

    def read(self, names: list[str]) -> Iterator[np.ndarray]:
        wanted = [self.header.index(name) for name in names]
        yield from self._read_arrow(wanted) if find_spec("pyarrow") else self._read_numpy(wanted)

    def _read_arrow(self, wanted: list[int]) -> Iterator[np.ndarray]:
        import pyarrow as pa
        import pyarrow.csv as pc

        every = [f"c{k}" for k in range(len(self.header))]
        use = [every[k] for k in wanted]
        try:
            reader = pc.open_csv(
                self.path,
                read_options=pc.ReadOptions(use_threads=False, block_size=1 << 20, skip_rows=self.skip, column_names=every),
                parse_options=pc.ParseOptions(delimiter=self.delimiter),
                convert_options=pc.ConvertOptions(include_columns=use, column_types=dict.fromkeys(use, pa.float64()),
                                                  decimal_point=self.decimal),
            )
            for batch in reader:
                yield np.column_stack([column.to_numpy(zero_copy_only=False) for column in batch.columns])
        except pa.ArrowInvalid as error:
            if "Empty CSV" in str(error):
                return
            self.blame(0, wanted, str(error))

    def _read_numpy(self, wanted: list[int]) -> Iterator[np.ndarray]:
        with self._open() as file:
            rows = itertools.islice(file, self.skip, None)
            while lines := [line.replace(",", ".") if self.decimal == "," else line
                            for line in itertools.islice(rows, 16_384) if line.strip()]:
                if any(line.count(self.delimiter) != len(self.header) - 1 for line in lines):
                    self._check_cells()
                try:
                    yield np.loadtxt(lines, delimiter=self.delimiter, usecols=wanted, ndmin=2, comments=None)
                except ValueError as error:
                    self.blame(0, wanted, str(error))

    def _rows(self) -> Iterator[tuple[int, list[str]]]:
        """Line number and cells of every row of data."""
        with self._open() as file:
            for number, line in itertools.islice(enumerate(file, 1), self.skip, None):
                if line.strip():
                    yield number, next(csv.reader([line], delimiter=self.delimiter))

    def place(self, row: int) -> str:
        number, _ = next(itertools.islice(self._rows(), row, None))
        return f"{self.path} line {number}"

    def _check_cells(self) -> None:
        for number, cells in self._rows():
            self._check_count(number, cells)

    def _check_count(self, number: int, cells: list[str]) -> None:
        if len(cells) != len(self.header):
            why = ""
            if len(cells) > len(self.header) and self.delimiter == ",":
                why = "; are its decimals written with a comma? Write points, or put semicolons between the columns"
            raise InputError(f"{self.path} line {number}: {len(cells)} columns where the header has {len(self.header)}{why}")

    def blame(self, start: int, looked: list[int], otherwise: str = "") -> None:
        """Raise `InputError` for the first row from ``start`` that is broken in the columns looked at, with its line."""
        for number, cells in itertools.islice(self._rows(), start, None):
            self._check_count(number, cells)
            for k in looked:
                value = _number(cells[k].replace(self.decimal, "."))
                if value is None or not math.isfinite(value):
                    what = f"= {cells[k].strip()!r} is not a number" if cells[k].strip() else "is empty"
                    raise InputError(f"{self.path} line {number}: {self.header[k]} {what}; every sample must be there. "
                                     "Cut the record before or after it, or take out the lines without values and say "
                                     "--gaps bridge; --rate would hide such a gap")
        raise InputError(f"{self.path} cannot be read as columns of numbers: {otherwise.splitlines()[0] if otherwise else '?'}")


class _Decoded:
    """A text file whose lines raise `InputError` where they are not text."""

    def __init__(self, file: Any, path: Path) -> None:
        self._file, self._path = file, path

    def __enter__(self) -> Iterator[str]:
        return self._lines()

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def _lines(self) -> Iterator[str]:
        try:
            yield from self._file
        except UnicodeDecodeError:
            raise InputError(f"{self._path} is not a text file; a log is CSV or Parquet") from None


class _Parquet:
    """A Parquet file, row group by row group."""

    def __init__(self, path: Path) -> None:
        try:
            import pyarrow as pa
            import pyarrow.parquet as pq
        except ImportError:
            raise InputError(f"{path}: Parquet takes pyarrow; pip install pyarrow, or write the log as CSV") from None
        try:
            # buffering ahead would keep all row groups that were read
            self.file = pq.ParquetFile(path, pre_buffer=False)
        except OSError as error:
            raise InputError(f"cannot read {path}: {error.strerror or error}") from None
        except pa.ArrowInvalid:
            raise InputError(f"{path} is not a Parquet file") from None
        self.path = path
        self.header = list(self.file.schema_arrow.names)
        self.head = (self.file.schema_arrow.metadata or {}).get(b"imo_run", b"").decode()

    def read(self, names: list[str]) -> Iterator[np.ndarray]:
        import pyarrow as pa

        for name in names:
            kind = self.file.schema_arrow.field(name).type
            if not (pa.types.is_floating(kind) or pa.types.is_integer(kind)):
                raise InputError(f"{self.path}: column {name!r} holds {kind}, not numbers; convert it first")
        for batch in self.file.iter_batches(BLOCK, columns=names):
            yield np.column_stack([
                batch.column(name).cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False) for name in names
            ])

    def place(self, row: int) -> str:
        return f"{self.path} row {row + 1}"

    def blame(self, start: int, looked: list[int]) -> None:
        raise InputError(f"{self.path} row {start + 1}: {self.header[looked[0]]} has no finite value; every sample must be "
                         "there. Cut the record before or after it")


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
