"""A first path: A* over the cells of free space. It finds none only where none exists."""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.arrays import put
from skyverse.numerics.heap import make_heap, pop, push
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance
from skyverse.space.cells import Cells, cell_of, neighbours


@inner
def cell_astar(cells: Cells, start: Floats, goal: Floats) -> tuple[Floats, int]:
    """Return a path from start to goal, (k, 3) metres, empty where none exists, and how many cells were expanded.

    Each leg stays in one cell, which is convex and free.
    """
    source, target = cell_of(cells, start), cell_of(cells, goal)
    nothing = np.empty((0, 3))
    if source < 0 or target < 0:
        return nothing, 0
    count = len(cells.axis)
    price = np.full(count, np.inf)
    done = np.zeros(count, np.bool_)
    came = np.empty(count, np.int64)
    entry = np.empty((count, 3))
    found = np.empty(count, np.int64)
    price[source] = 0.0
    came[source] = -1
    put(entry, source, start)
    heap = push(make_heap(256), 0.0, source)
    expanded = 0
    q = np.empty(3)
    while heap.size[0]:
        _, cell = pop(heap)
        if done[cell]:
            continue
        done[cell] = True
        expanded += 1
        if cell == target:
            break
        p = entry[cell]
        for k in range(neighbours(cells, cell, found)):
            beyond = found[k]
            if done[beyond]:
                continue
            _write_crossing(cells, cell, beyond, p, goal, q)
            along = price[cell] + distance(p, q)
            if along < price[beyond]:
                price[beyond] = along
                came[beyond] = cell
                put(entry, beyond, q)
                heap = push(heap, along + distance(q, goal), beyond)
    if not done[target]:
        return nothing, expanded
    length = 2
    cell = target
    while came[cell] >= 0:
        cell = came[cell]
        length += 1
    path = np.empty((length, 3))
    put(path, length - 1, goal)
    cell = target
    for i in range(length - 2, -1, -1):
        put(path, i, entry[cell])
        cell = came[cell]
    return path, expanded


@inner
def _write_crossing(cells: Cells, cell: int, beyond: int, p: Floats, goal: Floats, q: Floats) -> None:
    """Write into `q` where to pass from one cell into the next: near the straight line from `p` to the goal."""
    share = 0.0
    for axis in range(3):
        low = max(cells.low[cell, axis], cells.low[beyond, axis])
        high = min(cells.high[cell, axis], cells.high[beyond, axis])
        if low == high and (goal[axis] - p[axis]) * (low - p[axis]) > 0.0:
            share = min(1.0, (low - p[axis]) / (goal[axis] - p[axis]))
    for axis in range(3):
        low = max(cells.low[cell, axis], cells.low[beyond, axis])
        high = min(cells.high[cell, axis], cells.high[beyond, axis])
        q[axis] = min(max(p[axis] + share * (goal[axis] - p[axis]), low), high)
