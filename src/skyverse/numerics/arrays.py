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
    """Write other rows into row i and those that follow."""
    for k in range(len(others)):
        for column in range(others.shape[1]):
            rows[i + k, column] = others[k, column]


@inner_query
def put_box(boxes: Floats, i: int, low: Floats, high: Floats) -> None:
    """Write box i, which lies between two corners (3,)."""
    for axis in range(3):
        boxes[i, axis], boxes[i, axis + 3] = low[axis], high[axis]


@inner
def towards(a: Floats, b: Floats, share: float) -> Floats:
    """Return the point (3,) that lies a share of the segment a-b from a."""
    point = np.empty(3)
    for axis in range(3):
        point[axis] = a[axis] + share * (b[axis] - a[axis])
    return point


@inner
def doubled(rows: NDArray[Any]) -> NDArray[Any]:
    """Return numbers (n,), or rows (n, k), in an array twice as long; the second half is not set."""
    longer = np.empty((2 * len(rows), *rows.shape[1:]), rows.dtype)
    old, new = rows.reshape(-1), longer.reshape(-1)
    for i in range(len(old)):
        new[i] = old[i]
    return longer


@inner
def order_of(keys: Floats) -> Ints:
    """Return the indices that sort the numbers; all kernels share this one sort, which takes seconds to compile."""
    return np.argsort(keys)
