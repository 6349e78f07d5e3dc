"""The columns of a kind of rows: the numpy type of each field, and how it is kept in SQLite."""

from dataclasses import astuple, fields
from typing import Any
from zlib import compress, decompress

import numpy as np

from skyverse.model.result import History

_NUMPY_TYPES: dict[Any, type] = {str: np.str_, bool: np.bool_, int: np.int64}
_SQL_TYPES: dict[Any, str] = {
    str: "TEXT NOT NULL",
    bool: "INTEGER NOT NULL",
    int: "INTEGER NOT NULL",
    float: "REAL NOT NULL",
    float | None: "REAL",
    History: "BLOB NOT NULL",
}


def column_types(row: type) -> dict[str, type]:
    """Return the numpy type of each field of a kind of rows, a dataclass, apart from histories."""
    found = [field for field in fields(row) if field.type is not History]
    return {field.name: _NUMPY_TYPES.get(field.type, np.float64) for field in found}


def definitions(row: type) -> str:
    """Return the definitions of a kind of rows' columns in SQL."""
    return ", ".join(f"{field.name} {_SQL_TYPES[field.type]}" for field in fields(row))


def stored(row: Any) -> tuple[Any, ...]:
    """Return the values of a row's fields as SQLite keeps them."""
    values = (getattr(row, field.name) for field in fields(row))
    return tuple(packed(value) if isinstance(value, History) else value for value in values)


def restored(row: type, values: tuple[Any, ...]) -> dict[str, Any]:
    """Return the fields of a kind of rows from the values that SQLite has kept."""
    known = {}
    for field, value in zip(fields(row), values, strict=True):
        known[field.name] = unpacked(value) if field.type is History else bool(value) if field.type is bool else value
    return known


def packed(history: History) -> bytes:
    """Return a history in few bytes."""
    cost, *counts = astuple(history)
    columns = [cost.astype("<f8"), *(count.astype("<i8") for count in counts)]
    return bytes([len(columns)]) + compress(b"".join(column.tobytes() for column in columns), 1)


def unpacked(blob: bytes) -> History:
    """Return the history that `packed` has made bytes of."""
    cost, *counts = np.split(np.frombuffer(decompress(blob[1:]), "<i8"), blob[0])
    return History(cost.view("<f8"), *counts)
