"""The rows of a study in one SQLite file. Each row is stored as a whole or not at all, whenever the process ends."""

import sqlite3
import time
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import astuple, fields
from html import escape
from pathlib import Path
from typing import Any, Self
from zlib import compress, decompress

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError
from skyverse.lab.row import COLUMN_TYPES, LABELS, Row, export_rows
from skyverse.model.result import History
from skyverse.model.short_lines import as_lines, counted

MAX_WAIT_S = 60.0  # for another process that writes the same file
_APPLICATION = 0x736B7976  # "skyv"
_SQL_TYPES: dict[Any, str] = {
    str: "TEXT NOT NULL",
    bool: "INTEGER NOT NULL",
    int: "INTEGER NOT NULL",
    int | None: "INTEGER",
    float: "REAL NOT NULL",
    float | None: "REAL",
    History: "BLOB NOT NULL",
}
_FIELDS = {field.name: field.type for field in fields(Row)}
_JOINS = " ".join(f"JOIN labels AS {k}s ON {k}s.kind = '{k}' AND {k}s.label = runs.{k}" for k in LABELS)
_ORDER = ", ".join([*(f"{k}s.place" for k in LABELS), "runs.seed"])


class Rows:
    """The rows of a study, kept in a file; a context manager that closes the file.

    Rows are returned in the study's order of scenarios, planners and budgets, and then by seed. Other processes may
    read the file while a study writes it.

    Parameters
    ----------
    path
        A SQLite file, which is created if it does not exist.

    Raises
    ------
    InputError
        If the file cannot be opened, or is not a database of rows.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            self._file = sqlite3.connect(self.path, isolation_level=None, timeout=MAX_WAIT_S)
        except sqlite3.Error as error:
            raise InputError(f"{self.path}: cannot be opened: {error}") from None
        try:
            self._write_ahead()
            self._file.execute("PRAGMA synchronous = NORMAL")
            self._begin()
        except sqlite3.Error as error:
            self._file.close()
            raise InputError(f"{self.path}: expected a database of rows, but it cannot be used: {error}") from None
        except InputError:
            self._file.close()
            raise

    def _write_ahead(self) -> None:
        """Let others read while rows are written; SQLite does not wait by itself if another process begins as well."""
        deadline = time.monotonic() + MAX_WAIT_S
        while True:
            try:
                self._file.execute("PRAGMA journal_mode = WAL")
                return
            except sqlite3.OperationalError as error:
                if error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() > deadline:
                    raise
            time.sleep(0.01)

    def _begin(self) -> None:
        with self._file:
            self._file.execute("BEGIN IMMEDIATE")
            (made_by,) = self._file.execute("PRAGMA application_id").fetchone()
            (tables,) = self._file.execute("SELECT count(*) FROM sqlite_master").fetchone()
            if made_by == _APPLICATION:
                found = [name for _, name, *_ in self._file.execute("PRAGMA table_info(runs)")]
                if found != ["key", *_FIELDS]:
                    raise InputError(
                        f"{self.path}: expected a database of rows, found rows of another version of skyverse"
                    )
                return
            if tables or made_by:
                raise InputError(f"{self.path}: expected a database of rows, found another application's database")
            for statement in self._tables():
                self._file.execute(statement)

    def _tables(self) -> tuple[str, ...]:
        columns = ", ".join(f"{name} {_SQL_TYPES[kind]}" for name, kind in _FIELDS.items())
        return (
            f"CREATE TABLE runs (key TEXT PRIMARY KEY, {columns}, UNIQUE ({', '.join(LABELS)}, seed))",
            "CREATE TABLE labels (place INTEGER PRIMARY KEY, kind TEXT NOT NULL, label TEXT NOT NULL, "
            "UNIQUE (kind, label))",
            f"PRAGMA application_id = {_APPLICATION}",
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, _: object, error: object, __: object) -> None:
        self.close()
        if isinstance(error, sqlite3.DatabaseError | zlib.error):
            raise InputError(f"{self.path}: expected a database of rows, but it is damaged: {error}") from None

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __len__(self) -> int:
        (count,) = self._file.execute("SELECT count(*) FROM runs").fetchone()
        return int(count)

    def __repr__(self) -> str:
        labels = ((kind, self.labels(kind)) for kind in LABELS)
        known = [f"{counted(len(some), kind)}: {', '.join(some)}" for kind, some in labels if some]
        return as_lines(f"Rows: {counted(len(self), 'run')} in {self.path}", *known)

    def _repr_html_(self) -> str:
        """Return what notebooks show: a line for each planner on each scenario under each budget."""
        heads = (*LABELS, "runs", "success", "mean cost", "seconds")
        columns = ", ".join(f"runs.{kind}" for kind in LABELS)
        statement = f"SELECT {columns}, count(*), avg(success), avg(cost), avg(seconds) FROM runs {_JOINS} "
        found = self._file.execute(f"{statement} GROUP BY {columns} ORDER BY {_ORDER}")
        lines = [heads, *((*row[:4], *(f"{value:.4g}" for value in row[4:])) for row in found)]
        cells = ("".join(f"<td>{escape(str(cell))}</td>" for cell in line) for line in lines)
        return f"<table>{''.join(f'<tr>{line}</tr>' for line in cells)}</table>"

    def __iter__(self) -> Iterator[Row]:
        with closing(self._find(tuple(_FIELDS), {})) as found:
            for values in found:
                known = dict(zip(_FIELDS, values, strict=True))
                yield Row(**known | {"success": bool(known["success"]), "history": _unpacked(known["history"])})

    def expect(self, kind: str, labels: Iterable[str]) -> None:
        """Set the order in which labels are returned; labels that are known already keep their place."""
        rows = [(kind, label) for label in labels]
        with self._file:
            self._file.execute("BEGIN IMMEDIATE")
            self._file.executemany("INSERT OR IGNORE INTO labels (kind, label) VALUES (?, ?)", rows)

    def add(self, row: Row, key: str) -> None:
        """Add the row of a finished run, in one transaction.

        Raises
        ------
        InputError
            If the file has a row of that run already.
        """
        values = (key, *(vars(row) | {"history": _packed(row.history)}).values())
        labels = [(kind, getattr(row, kind)) for kind in LABELS]
        try:
            with self._file:
                self._file.execute("BEGIN IMMEDIATE")
                self._file.executemany("INSERT OR IGNORE INTO labels (kind, label) VALUES (?, ?)", labels)
                self._file.execute(f"INSERT INTO runs VALUES ({', '.join('?' * len(values))})", values)
        except sqlite3.IntegrityError:
            run = ", ".join([*(label for _, label in labels), f"seed {row.seed}"])
            raise InputError(f"{self.path}: holds the run {run} already; does another process write here?") from None

    def done(self) -> set[str]:
        """Return the keys of the finished runs."""
        return {key for (key,) in self._file.execute("SELECT key FROM runs")}

    def key(self, *run: str | int) -> str | None:
        """Return the key of the finished run with these labels and seed, or ``None`` if there is none."""
        where = " AND ".join(f"{name} = ?" for name in (*LABELS, "seed"))
        found = self._file.execute(f"SELECT key FROM runs WHERE {where}", run).fetchone()
        return None if found is None else str(found[0])

    def labels(self, kind: str) -> list[str]:
        """Return the labels of the finished runs, in the study's order."""
        if kind not in LABELS:
            raise ValueError(f"labels are of {', '.join(LABELS)}, not of {kind!r}")
        statement = f"SELECT label FROM labels WHERE kind = ? AND label IN (SELECT {kind} FROM runs) ORDER BY place"
        return [label for (label,) in self._file.execute(statement, (kind,))]

    def select(self, columns: Sequence[str], **where: object) -> dict[str, NDArray[Any]]:
        """Return columns, (n,) each, of the rows whose fields have the values in `where`; ``None`` becomes nan."""
        with closing(self._find(columns, where)) as found:
            rows = list(found)
        table = zip(*rows, strict=True) if rows else ([] for _ in columns)
        return {name: np.array(list(v), dtype=COLUMN_TYPES[name]) for name, v in zip(columns, table, strict=True)}

    def histories(self, **where: object) -> Iterator[History]:
        """Yield the histories of the rows that `select` returns, in the same order, reading one at a time."""
        with closing(self._find(("history",), where)) as found:
            for (history,) in found:
                yield _unpacked(history)

    def export(self, path: str | Path) -> list[Path]:
        """Write the rows as ``.csv`` or ``.parquet``, and their histories to a second file; return both paths."""
        return export_rows(self, path)

    def _find(self, columns: Sequence[str], where: dict[str, object]) -> sqlite3.Cursor:
        unknown = [name for name in (*columns, *where) if name not in _FIELDS]
        if unknown or not columns:
            raise ValueError(f"expected columns among {', '.join(COLUMN_TYPES)}, found {', '.join(unknown) or 'none'}")
        names = ", ".join(f"runs.{name}" for name in columns)
        test = " AND ".join(f"runs.{name} IS ?" for name in where) or "1"
        values = [value.item() if isinstance(value, np.generic) else value for value in where.values()]
        statement = f"SELECT {names} FROM runs {_JOINS} WHERE {test} ORDER BY {_ORDER}"
        return self._file.execute(statement, values)


def _packed(history: History) -> bytes:
    """Return a history in few bytes."""
    cost, *counts = astuple(history)
    columns = [cost.astype("<f8"), *(count.astype("<i8") for count in counts)]
    return bytes([len(columns)]) + compress(b"".join(column.tobytes() for column in columns), 1)


def _unpacked(blob: bytes) -> History:
    cost, *counts = np.split(np.frombuffer(decompress(blob[1:]), "<i8"), blob[0])
    return History(cost.view("<f8"), *counts)
