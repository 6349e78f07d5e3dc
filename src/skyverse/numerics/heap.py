"""A binary heap of entries, which are numbers, in two arrays; the entry with the least key comes first."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse.numerics.arrays import doubled
from skyverse.numerics.kernel import inner, inner_query


class Heap(NamedTuple):
    """The keys and entries, (capacity,) each, and how many there are, (1,)."""

    key: NDArray[np.float64]
    entry: NDArray[np.int64]
    size: NDArray[np.int64]


@inner
def make_heap(capacity: int) -> Heap:
    """Return an empty heap."""
    return Heap(np.empty(capacity), np.empty(capacity, np.int64), np.zeros(1, np.int64))


@inner
def push(heap: Heap, key: float, entry: int) -> Heap:
    """Add an entry; return the heap, which has larger arrays if it was full."""
    n = heap.size[0]
    if n == len(heap.key):
        heap = Heap(doubled(heap.key), doubled(heap.entry), heap.size)
    i = n
    while i > 0:
        parent = (i - 1) >> 1
        if heap.key[parent] <= key:
            break
        _write(heap, i, heap.key[parent], heap.entry[parent])
        i = parent
    _write(heap, i, key, entry)
    heap.size[0] = n + 1
    return heap


@inner
def pop(heap: Heap) -> tuple[float, int]:
    """Remove the entry with the least key; return key and entry."""
    n = heap.size[0] - 1
    least, entry = heap.key[0], heap.entry[0]
    key, last = heap.key[n], heap.entry[n]
    heap.size[0] = n
    i = 0
    while 2 * i + 1 < n:
        child = 2 * i + 1
        if child + 1 < n and heap.key[child + 1] < heap.key[child]:
            child += 1
        if heap.key[child] >= key:
            break
        _write(heap, i, heap.key[child], heap.entry[child])
        i = child
    _write(heap, i, key, last)
    return least, entry


@inner_query
def _write(heap: Heap, i: int, key: float, entry: int) -> None:
    """Write one place of the heap."""
    heap.key[i] = key
    heap.entry[i] = entry
