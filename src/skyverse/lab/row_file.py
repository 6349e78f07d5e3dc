"""Rows of one kind in one SQLite file. Each row is stored as a whole or not at all, whenever the process ends."""

import sqlite3
import time
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import fields
from pathlib import Path
from typing import Any, ClassVar, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError
from skyverse.lab.columns import column_types, definitions, restored, stored

R = TypeVar("R")

MAX_WAIT_S = 60.0  # for another process that writes the same file
_APPLICATION = 0x736B7976  # "skyv"


class RowFile(Generic[R]):
    """The rows of a study, kept in a file; a context manager that closes the file.

    Rows are returned in the study's order of labels, and then by seed. Other processes may read the file while a study
    writes it.

    Parameters
    ----------
    path
        A SQLite file, which is created if it does not exist.

    Attributes
    ----------
    kind
        The dataclass of the rows.
    label_kinds
        Those of its fields that are labels; with the field ``seed`` they identify a run.

    Raises
    ------
    InputError
        If the file cannot be opened, or is not a database of such rows.
    """

    kind: ClassVar[type]
    label_kinds: ClassVar[tuple[str, ...]]

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._types = column_types(self.kind)
        joins = (f"JOIN labels AS {k}s ON {k}s.kind = '{k}' AND {k}s.label = runs.{k}" for k in self.label_kinds)
        self._joins = " ".join(joins)
        self._order = ", ".join([*(f"{k}s.place" for k in self.label_kinds), "runs.seed"])
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
                if found != ["key", *(field.name for field in fields(self.kind))]:
                    raise InputError(
                        f"{self.path}: expected a database of rows, found rows of another kind of study, or of another "
                        "version of skyverse"
                    )
                return
            if tables or made_by:
                raise InputError(f"{self.path}: expected a database of rows, found another application's database")
            for statement in self._tables():
                self._file.execute(statement)

    def _tables(self) -> tuple[str, ...]:
        run = ", ".join((*self.label_kinds, "seed"))
        return (
            f"CREATE TABLE runs (key TEXT PRIMARY KEY, {definitions(self.kind)}, UNIQUE ({run}))",
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

    def __iter__(self) -> Iterator[R]:
        names = ", ".join(f"runs.{field.name}" for field in fields(self.kind))
        statement = f"SELECT {names} FROM runs {self._joins} ORDER BY {self._order}"
        with closing(self._file.execute(statement)) as found:
            for values in found:
                yield self.kind(**restored(self.kind, values))

    def expect(self, kind: str, labels: Iterable[str]) -> None:
        """Set the order in which labels are returned; labels that are known already keep their place."""
        rows = [(kind, label) for label in labels]
        with self._file:
            self._file.execute("BEGIN IMMEDIATE")
            self._file.executemany("INSERT OR IGNORE INTO labels (kind, label) VALUES (?, ?)", rows)

    def add(self, row: R, key: str) -> None:
        """Add the row of a finished run, in one transaction.

        Raises
        ------
        InputError
            If the file has a row of that run already.
        """
        values = (key, *stored(row))
        labels = [(kind, getattr(row, kind)) for kind in self.label_kinds]
        try:
            with self._file:
                self._file.execute("BEGIN IMMEDIATE")
                self._file.executemany("INSERT OR IGNORE INTO labels (kind, label) VALUES (?, ?)", labels)
                self._file.execute(f"INSERT INTO runs VALUES ({', '.join('?' * len(values))})", values)
        except sqlite3.IntegrityError:
            run = ", ".join([*(label for _, label in labels), f"seed {getattr(row, 'seed', None)}"])
            raise InputError(f"{self.path}: holds the run {run} already; does another process write here?") from None

    def done(self) -> set[str]:
        """Return the keys of the finished runs."""
        return {key for (key,) in self._file.execute("SELECT key FROM runs")}

    def key(self, *run: str | int) -> str | None:
        """Return the key of the finished run with these labels and seed, or ``None`` if there is none."""
        where = " AND ".join(f"{name} = ?" for name in (*self.label_kinds, "seed"))
        found = self._file.execute(f"SELECT key FROM runs WHERE {where}", run).fetchone()
        return None if found is None else str(found[0])

    def labels(self, kind: str) -> list[str]:
        """Return the labels of the finished runs, in the study's order."""
        if kind not in self.label_kinds:
            raise ValueError(f"labels are of {', '.join(self.label_kinds)}, not of {kind!r}")
        statement = f"SELECT label FROM labels WHERE kind = ? AND label IN (SELECT {kind} FROM runs) ORDER BY place"
        return [label for (label,) in self._file.execute(statement, (kind,))]

    def select(self, columns: Sequence[str], **where: object) -> dict[str, NDArray[Any]]:
        """Return columns, (n,) each, of the rows whose fields have the values in `where`; ``None`` becomes nan."""
        with closing(self._find(columns, where)) as found:
            rows = list(found)
        table = zip(*rows, strict=True) if rows else ([] for _ in columns)
        return {name: np.array(list(v), dtype=self._types[name]) for name, v in zip(columns, table, strict=True)}

    def _find(self, columns: Sequence[str], where: dict[str, object]) -> sqlite3.Cursor:
        known = [field.name for field in fields(self.kind)]
        unknown = [name for name in (*columns, *where) if name not in known]
        if unknown or not columns:
            raise ValueError(f"expected columns among {', '.join(self._types)}, found {', '.join(unknown) or 'none'}")
        names = ", ".join(f"runs.{name}" for name in columns)
        test = " AND ".join(f"runs.{name} IS ?" for name in where) or "1"
        values = [value.item() if isinstance(value, np.generic) else value for value in where.values()]
        statement = f"SELECT {names} FROM runs {self._joins} WHERE {test} ORDER BY {self._order}"
        return self._file.execute(statement, values)
