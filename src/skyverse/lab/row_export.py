"""Rows exported to CSV or Parquet: one row for each run, and the histories in long form in a second file."""

import csv
import importlib.util
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from skyverse.atomic import whole_file
from skyverse.errors import InputError
from skyverse.lab.row import COLUMN_TYPES, LABELS, Row
from skyverse.model.result import History

HISTORY_COLUMNS = (*LABELS, "seed", *(field.name for field in fields(History)))
"""The columns of exported histories: a line for each improvement and the end of each iteration; 0 is the start."""

WriteLines = Callable[[Iterable[tuple[Any, ...]]], None]
_BATCH_LINES = 1000
"""The number of lines of a Parquet file that are collected in memory before they are written."""


def export_rows(rows: Iterable[Row], path: str | Path) -> list[Path]:
    """Write rows as ``NAME.csv`` or ``NAME.parquet``, and their histories as ``NAME-history`` with the same suffix.

    What a run has no value for is an empty field in CSV and null in Parquet.

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
    table_at = _csv_table if suffix == ".csv" else _parquet_table
    with (
        whole_file(path) as hidden,
        whole_file(beside) as hidden_beside,
        table_at(hidden, COLUMN_TYPES) as write_rows,
        table_at(hidden_beside, histories) as write_histories,
    ):
        for row in rows:
            write_rows([tuple(getattr(row, name) for name in COLUMN_TYPES)])
            write_histories(_lines(row))
    return [path, beside]


def refuse_export(path: Path) -> None:
    """Raise `InputError` if rows cannot be exported to `path`, so that this is known before a long study begins."""
    suffix = path.suffix.lower()
    if suffix not in (".csv", ".parquet"):
        raise InputError(f"{path}: rows are exported as .csv or .parquet, not as {suffix or 'no suffix'!r}")
    if suffix == ".parquet" and importlib.util.find_spec("pyarrow") is None:
        raise InputError(f'{path}: Parquet needs pyarrow: pip install "skyverse[parquet]"')


def _lines(row: Row) -> Iterator[tuple[Any, ...]]:
    run = tuple(getattr(row, name) for name in (*LABELS, "seed"))
    for values in zip(*(column.tolist() for column in vars(row.history).values()), strict=True):
        yield (*run, *values)


@contextmanager
def _csv_table(path: Path, columns: dict[str, type]) -> Iterator[WriteLines]:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        yield writer.writerows


@contextmanager
def _parquet_table(path: Path, columns: dict[str, type]) -> Iterator[WriteLines]:
    import pyarrow
    from pyarrow.parquet import ParquetWriter

    schema = pyarrow.schema([(name, pyarrow.from_numpy_dtype(kind)) for name, kind in columns.items()])
    waiting: list[tuple[Any, ...]] = []

    def write(lines: Iterable[tuple[Any, ...]], batch: int = _BATCH_LINES) -> None:
        waiting.extend(lines)
        if len(waiting) >= batch:
            table = [list(column) for column in zip(*waiting, strict=True)]
            writer.write_batch(pyarrow.record_batch(table, schema=schema))
            waiting.clear()

    with ParquetWriter(path, schema) as writer:
        yield write
        if waiting:
            write((), batch=1)
