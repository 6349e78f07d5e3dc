"""What is known of one run of a study: one row, and rows exported to CSV or Parquet, with their histories beside."""

import csv
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from skyverse.atomic import whole_file
from skyverse.errors import InputError
from skyverse.extras import require_libraries
from skyverse.model.result import History


@dataclass(frozen=True)
class Row:
    """One run: a planner on a scenario, with one budget and one seed, or a mission flown among movers.

    Attributes
    ----------
    scenario, planner, budget, seed
        Three labels and a number that identify the run in its study. The budget is that of each UAV's search; of a
        flight it is the time after which it is given up. The label of a scenario with movers names these as well, and
        the planner of a flight is its replanning policy.
    status
        The worst of the UAVs' statuses; ``"not planned"`` where no UAV has a target. Of a flight ``"arrived"`` if all
        UAVs have come to rest at their targets, else ``"not arrived"``.
    success
        Whether every UAV that has a target reached it, and of a flight also whether the referee found nothing wrong.
    cost
        The sum over the UAVs, in the objective's unit. Of a flight the seconds after which the last UAV arrived,
        infinite without success.
    fuel, divergence, end
        Terms of the cost, summed over the UAVs; ``None`` for a flight.
    bound, gap
        The sum of the exact optima, or the least seconds that a flight can take in hindsight, and ``cost / bound - 1``
        of a success; ``None`` where unknown.
    generated_paths, generated_nodes, evaluations, iterations, seconds
        Effort, summed over the UAVs; the seconds are those of the search alone, without compilation.
    stopped_by
        The names of the stop rules that ended the UAVs' searches; empty for a flight.
    verdict
        What the referee found wrong, in sentences, with a flight among the movers as they truly moved; empty where it
        found nothing.
    settings, versions
        The planner with all its parameters; skyverse, Python, numpy, numba and platform.
    history
        Best cost and effort at each improvement and after each iteration; of several UAVs their sums, after each
        iteration, where a search that has ended keeps its last values. Empty for a flight.
    flown_seconds, flown_length, least_length
        Of a flight: when the last UAV arrived or the flight was given up; metres flown by all UAVs, and a proven lower
        bound of them. ``None``, as all that follows, where nothing was flown.
    contacts, least_gap
        Pairs of a UAV and a mover that came nearer to one another than the clearance; the least distance of a UAV from
        a mover beyond the clearance, metres; below 0 it was too near.
    replans, unproven
        Answers to observations, for all UAVs, and those of them that had no proven way out.
    milliseconds, milliseconds_99, milliseconds_worst
        One answer took: the median, the 99th percentile and the most.
    """

    scenario: str
    planner: str
    budget: str
    seed: int
    status: str
    success: bool
    cost: float
    fuel: float | None
    divergence: float | None
    end: float | None
    bound: float | None
    gap: float | None
    generated_paths: int
    generated_nodes: int
    evaluations: int
    iterations: int
    seconds: float
    stopped_by: str
    verdict: str
    settings: str
    versions: str
    history: History
    flown_seconds: float | None = None
    flown_length: float | None = None
    least_length: float | None = None
    contacts: int | None = None
    least_gap: float | None = None
    replans: int | None = None
    unproven: int | None = None
    milliseconds: float | None = None
    milliseconds_99: float | None = None
    milliseconds_worst: float | None = None


LABELS = ("scenario", "planner", "budget")
"""The columns of labels; with the seed they identify a run."""
_NUMPY_TYPES: dict[Any, type] = {str: np.str_, bool: np.bool_, int: np.int64}
COLUMN_TYPES = {
    field.name: _NUMPY_TYPES.get(field.type, np.float64) for field in fields(Row) if field.type is not History
}
"""The numpy type of each field of a row except its history; ``None`` in a field of numbers becomes nan."""
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
    if suffix == ".parquet":
        require_libraries(str(path), "pyarrow")


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
