"""Rows exported to CSV or Parquet: one row for each run, and the histories in long form in a second file."""

import csv
import importlib.util
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import numpy as np

from skyverse.atomic import whole_file
from skyverse.errors import InputError
from skyverse.lab.row import COLUMN_TYPES, RUN_COLUMNS, Row

HISTORY_COLUMNS = (*RUN_COLUMNS, "iteration", "cost", "generated_paths", "generated_nodes", "evaluations")
"""The columns of exported histories: one line for each run and each iteration; iteration 0 is the start."""

_BATCH_LINES = 1000
"""The number of lines of a Parquet file that are collected in memory before they are written."""


def export_rows(rows: Iterable[Row], path: str | Path) -> list[Path]:
    """Write rows as ``NAME.csv`` or ``NAME.parquet``, and their histories as ``NAME-history`` with the same suffix.

    An unknown bound or gap is an empty field in CSV and null in Parquet.

    Raises
    ------
    InputError
        For another suffix, or if the files cannot be written or pyarrow is not installed.
    """
    path = Path(path)
    refuse_export(path)
    beside = path.with_name(f"{path.stem}-history{path.suffix}")
    suffix = path.suffix.lower()
    histories = {name: COLUMN_TYPES.get(name, np.int64) for name in HISTORY_COLUMNS}
    with ExitStack() as stack:
        tables: list[_Csv | _Parquet] = []
        for file, columns in ((path, COLUMN_TYPES), (beside, histories)):
            hidden = stack.enter_context(whole_file(file))
            table = _Csv(hidden, columns) if suffix == ".csv" else _Parquet(hidden, columns)
            tables.append(stack.enter_context(closing(table)))
        for row in rows:
            tables[0].write([tuple(getattr(row, name) for name in COLUMN_TYPES)])
            tables[1].write(_lines(row))
    return [path, beside]


def refuse_export(path: Path) -> None:
    """Raise `InputError` if rows cannot be exported to `path`, so that this is known before a long study begins."""
    suffix = path.suffix.lower()
    if suffix not in (".csv", ".parquet"):
        raise InputError(f"{path}: rows are exported as .csv or .parquet, not as {suffix or 'no suffix'!r}")
    if suffix == ".parquet" and importlib.util.find_spec("pyarrow") is None:
        raise InputError(f'{path}: Parquet needs pyarrow: pip install "skyverse[parquet]"')


def _lines(row: Row) -> Iterator[tuple[Any, ...]]:
    run = tuple(getattr(row, name) for name in RUN_COLUMNS)
    history = row.history
    table = (history.cost, history.generated_paths, history.generated_nodes, history.evaluations)
    for iteration, values in enumerate(zip(*(column.tolist() for column in table), strict=True)):
        yield (*run, iteration, *values)


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

        self._schema = pyarrow.schema([(name, pyarrow.from_numpy_dtype(kind)) for name, kind in columns.items()])
        self._batch = pyarrow.record_batch
        self._writer = ParquetWriter(path, self._schema)
        self._waiting: list[tuple[Any, ...]] = []

    def write(self, lines: Iterable[tuple[Any, ...]]) -> None:
        self._waiting.extend(lines)
        if len(self._waiting) >= _BATCH_LINES:
            self._flush()

    def _flush(self) -> None:
        columns = [list(column) for column in zip(*self._waiting, strict=True)]
        self._writer.write_batch(self._batch(columns, schema=self._schema))
        self._waiting = []

    def close(self) -> None:
        if self._waiting:
            self._flush()
        self._writer.close()
