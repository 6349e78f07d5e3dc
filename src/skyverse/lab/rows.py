"""The rows of a study in one SQLite file: a row is there whole or not at all, whatever kills the process."""

import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import InputError
from skyverse.lab.row import Row
from skyverse.model.result import History, no_history

Kind = Literal["scenario", "planner", "budget"]
KINDS: tuple[Kind, ...] = ("scenario", "planner", "budget")
RUN = (*KINDS, "seed")
"""The columns that say which run a row is."""

_KINDS: dict[Any, tuple[str, type]] = {
    str: ("TEXT NOT NULL", np.str_),
    bool: ("INTEGER NOT NULL", np.bool_),
    int: ("INTEGER NOT NULL", np.int64),
    float: ("REAL NOT NULL", np.float64),
    float | None: ("REAL", np.float64),
}
TYPES = {f.name: _KINDS[f.type] for f in fields(Row) if f.name != "history"}
"""The type of each field of a row but its history: in SQLite, and in numpy."""

COLUMNS = tuple(TYPES)
"""What `Rows.select` knows: every field of a row but its history."""

_APPLICATION = 0x736B7976  # "skyv"
_TABLES = (
    f"CREATE TABLE runs (key TEXT PRIMARY KEY, {', '.join(f'{n} {t}' for n, (t, _) in TYPES.items())}, "
    f"history BLOB NOT NULL, UNIQUE ({', '.join(RUN)}))",
    "CREATE TABLE labels (place INTEGER PRIMARY KEY, kind TEXT NOT NULL, label TEXT NOT NULL, UNIQUE (kind, label))",
    f"PRAGMA application_id = {_APPLICATION}",
)
_JOINS = " ".join(f"JOIN labels AS {k}s ON {k}s.kind = '{k}' AND {k}s.label = runs.{k}" for k in KINDS)
_ORDER = ", ".join([*(f"{k}s.place" for k in KINDS), "runs.seed"])


class Rows:
    """The rows of a study; a context manager.

    Rows come scenario by scenario, planner by planner, budget by budget, in the study's order, and seed by seed.
    Others may read the file while a study writes it.

    Parameters
    ----------
    path
        A SQLite file, made if it is not there.

    Raises
    ------
    InputError
        If the file cannot be opened, or holds something else.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            self._file = sqlite3.connect(self.path, isolation_level=None, timeout=60.0)
        except sqlite3.Error as error:
            raise InputError(f"{self.path}: cannot be opened: {error}") from None
        try:
            self._file.execute("PRAGMA journal_mode = WAL")
            self._file.execute("PRAGMA synchronous = NORMAL")
            self._begin()
        except sqlite3.Error as error:
            self._file.close()
            raise InputError(f"{self.path}: expected a database of rows, but it cannot be used: {error}") from None
        except InputError:
            self._file.close()
            raise

    def _begin(self) -> None:
        self._file.execute("BEGIN IMMEDIATE")
        try:
            (made_by,) = self._file.execute("PRAGMA application_id").fetchone()
            (tables,) = self._file.execute("SELECT count(*) FROM sqlite_master").fetchone()
            if made_by == _APPLICATION:
                return
            if tables or made_by:
                raise InputError(f"{self.path}: expected a database of rows, found another application's database")
            for statement in _TABLES:
                self._file.execute(statement)
        finally:
            self._file.execute("COMMIT")

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

    def __iter__(self) -> Iterator[Row]:
        names = ", ".join(f"runs.{name}" for name in (*COLUMNS, "history"))
        with closing(self._file.execute(f"SELECT {names} FROM runs {_JOINS} ORDER BY {_ORDER}")) as found:
            for *values, history in found:
                row: dict[str, Any] = dict(zip(COLUMNS, values, strict=True))
                yield Row(**row | {"success": bool(row["success"]), "history": _unpack(history)})

    def expect(self, kind: Kind, labels: Iterable[str]) -> None:
        """Lay down the study's order of labels; those already known keep their place."""
        rows = [(kind, label) for label in labels]
        self._file.execute("BEGIN IMMEDIATE")
        self._file.executemany("INSERT OR IGNORE INTO labels (kind, label) VALUES (?, ?)", rows)
        self._file.execute("COMMIT")

    def add(self, row: Row, key: str) -> None:
        """Add a finished run's row, in one transaction.

        Raises
        ------
        InputError
            If that run is there already.
        """
        values = (key, *(getattr(row, name) for name in COLUMNS), _pack(row.history))
        self._file.execute("BEGIN IMMEDIATE")
        try:
            for kind in KINDS:
                label = getattr(row, kind)
                self._file.execute("INSERT OR IGNORE INTO labels (kind, label) VALUES (?, ?)", (kind, label))
            self._file.execute(f"INSERT INTO runs VALUES ({', '.join('?' * len(values))})", values)
        except sqlite3.IntegrityError:
            self._file.execute("ROLLBACK")
            run = f"{row.scenario}, {row.planner}, {row.budget}, seed {row.seed}"
            raise InputError(f"{self.path}: holds the run {run} already; does another process write here?") from None
        except BaseException:
            self._file.execute("ROLLBACK")
            raise
        self._file.execute("COMMIT")

    def done(self) -> set[str]:
        """Return the keys of the finished runs."""
        return {key for (key,) in self._file.execute("SELECT key FROM runs")}

    def key(self, scenario: str, planner: str, budget: str, seed: int) -> str | None:
        """Return the key of the finished run of these labels, or ``None``."""
        where = " AND ".join(f"{name} = ?" for name in RUN)
        found = self._file.execute(f"SELECT key FROM runs WHERE {where}", (scenario, planner, budget, seed)).fetchone()
        return None if found is None else str(found[0])

    def labels(self, kind: Kind) -> list[str]:
        """Return the labels of the finished runs, in the study's order."""
        if kind not in KINDS:
            raise ValueError(f"labels are of {', '.join(KINDS)}, not of {kind!r}")
        statement = f"SELECT label FROM labels WHERE kind = ? AND label IN (SELECT {kind} FROM runs) ORDER BY place"
        return [label for (label,) in self._file.execute(statement, (kind,))]

    def select(self, columns: Sequence[str], **where: object) -> dict[str, NDArray[Any]]:
        """Return columns of the rows whose fields have the values in `where`, (n,) each; ``None`` becomes nan."""
        with closing(self._find(columns, where)) as found:
            rows = list(found)
        table = zip(*rows, strict=True) if rows else ([] for _ in columns)
        return {name: np.array(list(v), dtype=TYPES[name][1]) for name, v in zip(columns, table, strict=True)}

    def histories(self, **where: object) -> Iterator[History]:
        """Yield the histories of the rows that `select` would find, one at a time, in the same order."""
        with closing(self._find(("history",), where)) as found:
            for (history,) in found:
                yield _unpack(history)

    def export(self, path: str | Path) -> list[Path]:
        """Write the rows as ``.csv`` or ``.parquet`` and their histories beside; see `skyverse.lab.export`."""
        from skyverse.lab.export import export_rows

        return export_rows(self, path)

    def _find(self, columns: Sequence[str], where: dict[str, object]) -> sqlite3.Cursor:
        unknown = [name for name in (*columns, *where) if name not in TYPES and name != "history"]
        if unknown or not columns:
            raise ValueError(f"expected columns among {', '.join(COLUMNS)}, found {', '.join(unknown) or 'none'}")
        names = ", ".join(f"runs.{name}" for name in columns)
        test = " AND ".join(f"runs.{name} IS ?" for name in where) or "1"
        values = [value.item() if isinstance(value, np.generic) else value for value in where.values()]
        return self._file.execute(f"SELECT {names} FROM runs {_JOINS} WHERE {test} ORDER BY {_ORDER}", values)


def _pack(history: History) -> bytes:
    columns = [values.astype("<f8" if k == 0 else "<i8").tobytes() for k, values in enumerate(astuple(history))]
    return zlib.compress(b"".join(columns), 1)


def _unpack(blob: bytes) -> History:
    data = zlib.decompress(blob)
    if not data:
        return no_history()
    quarter = len(data) // 4
    cost = np.frombuffer(data[:quarter], "<f8")
    return History(cost, *(np.frombuffer(data[k * quarter : (k + 1) * quarter], "<i8") for k in (1, 2, 3)))
