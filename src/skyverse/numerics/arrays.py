"""Rows of arrays, written number by number: each assignment to a slice would take numba a second to compile."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, inner_query


@inner_query
def put(rows: Floats, i: int, row: Floats) -> None:
    """Write row i."""
    for column in range(len(row)):
        rows[i, column] = row[column]


@inner_query
def put_all(rows: Floats, i: int, others: Floats) -> None:
    """Write rows i, i + 1 ..."""
    for k in range(len(others)):
        for column in range(others.shape[1]):
            rows[i + k, column] = others[k, column]


@inner_query
def put_box(boxes: Floats, i: int, low: Floats, high: Floats) -> None:
    """Write box i, between two corners."""
    for axis in range(3):
        boxes[i, axis], boxes[i, axis + 3] = low[axis], high[axis]


@inner
def towards(a: Floats, b: Floats, share: float) -> Floats:
    """Return the point after a share of the way from a to b, (3,)."""
    point = np.empty(3)
    for axis in range(3):
        point[axis] = a[axis] + share * (b[axis] - a[axis])
    return point


@inner
def twice(rows: NDArray[Any]) -> NDArray[Any]:
    """Return rows in an array twice as long."""
    longer = np.empty((2 * len(rows), rows.shape[1]), rows.dtype)
    for i in range(len(rows)):
        for column in range(rows.shape[1]):
            longer[i, column] = rows[i, column]
    return longer


@inner
def twice_line(numbers: NDArray[Any]) -> NDArray[Any]:
    """Return numbers in an array twice as long."""
    longer = np.empty(2 * len(numbers), numbers.dtype)
    for i in range(len(numbers)):
        longer[i] = numbers[i]
    return longer


@inner
def order_of(keys: Floats) -> Ints:
    """Return which number is the least, which the next ...; one sort for all, since numba takes seconds for each."""
    return np.argsort(keys)
