"""Rows for other programs: CSV or Parquet, one row a run, and the histories beside it in long form."""

import csv
import importlib.util
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from skyverse.atomic import whole_file
from skyverse.errors import InputError
from skyverse.lab.row import Row
from skyverse.lab.rows import COLUMNS, RUN, TYPES, Rows

HISTORY = (*RUN, "iteration", "cost", "generated_paths", "generated_nodes", "evaluations")
"""The columns of an export's histories: one line for each run and each iteration, 0 being the start."""

_BATCH = 1000
"""Runs, or lines of histories, that are in memory at a time."""

Lines = Iterator[tuple[Any, ...]]


def export_rows(rows: Rows, path: str | Path) -> list[Path]:
    """Write rows as ``.csv`` or ``.parquet``, and their histories to a second file, ``NAME-history`` and the suffix.

    An unknown bound or gap is an empty field in CSV and null in Parquet.

    Raises
    ------
    InputError
        If the suffix is another one, the files cannot be written, or pyarrow is not installed.
    """
    path = Path(path)
    refuse_export(path)
    beside = path.with_name(f"{path.stem}-history{path.suffix}")
    suffix = path.suffix.lower()
    kinds = {name: kind for name, (_, kind) in TYPES.items()}
    histories = {name: kinds.get(name, np.int64) for name in HISTORY}
    with ExitStack() as stack:
        sheets: list[_Sheet] = []
        for file, columns in ((path, kinds), (beside, histories)):
            hidden = stack.enter_context(whole_file(file))
            sheet = _Csv(hidden, columns) if suffix == ".csv" else _Parquet(hidden, columns)
            sheets.append(stack.enter_context(closing(sheet)))
        for row in rows:
            sheets[0].write([tuple(getattr(row, name) for name in COLUMNS)])
            sheets[1].write(_lines(row))
    return [path, beside]


def refuse_export(path: Path) -> None:
    """Find out before a long study, not after it, that its rows cannot be exported so."""
    suffix = path.suffix.lower()
    if suffix not in (".csv", ".parquet"):
        raise InputError(f"{path}: rows are exported as .csv or .parquet, not as {suffix or 'no suffix'!r}")
    if suffix == ".parquet" and importlib.util.find_spec("pyarrow") is None:
        raise InputError(f'{path}: Parquet needs pyarrow: pip install "skyverse[parquet]"')


def _lines(row: Row) -> Lines:
    run = tuple(getattr(row, name) for name in RUN)
    history = row.history
    table = (history.cost, history.generated_paths, history.generated_nodes, history.evaluations)
    for iteration, values in enumerate(zip(*(column.tolist() for column in table), strict=True)):
        yield (*run, iteration, *values)


class _Sheet(Protocol):
    def write(self, lines: Iterable[tuple[Any, ...]], /) -> None: ...

    def close(self) -> None: ...


class _Csv:
    def __init__(self, path: Path, columns: dict[str, type]) -> None:
        self._file = path.open("w", encoding="utf-8", newline="")
        self._writer = csv.writer(self._file, lineterminator="\n")
        self._writer.writerow(columns)

    def write(self, lines: Iterable[tuple[Any, ...]]) -> None:
        self._writer.writerows(lines)

    def close(self) -> None:
        self._file.close()


class _Parquet:
    def __init__(self, path: Path, columns: dict[str, type]) -> None:
        import pyarrow
        from pyarrow.parquet import ParquetWriter

        kinds = {
            np.str_: pyarrow.string(),
            np.bool_: pyarrow.bool_(),
            np.int64: pyarrow.int64(),
            np.float64: pyarrow.float64(),
        }
        self._schema = pyarrow.schema([(name, kinds[kind]) for name, kind in columns.items()])
        self._batch = pyarrow.record_batch
        self._writer = ParquetWriter(path, self._schema)
        self._waiting: list[tuple[Any, ...]] = []

    def write(self, lines: Iterable[tuple[Any, ...]]) -> None:
        self._waiting.extend(lines)
        if len(self._waiting) >= _BATCH:
            self._flush()

    def _flush(self) -> None:
        columns = [list(column) for column in zip(*self._waiting, strict=True)]
        self._writer.write_batch(self._batch(columns, schema=self._schema))
        self._waiting = []

    def close(self) -> None:
        if self._waiting:
            self._flush()
        self._writer.close()
