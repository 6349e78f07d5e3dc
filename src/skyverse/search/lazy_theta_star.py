"""Lazy Theta*: a path of straight legs between nodes of a lattice, not bound to the lattice's moves."""

import math

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Ints
from skyverse.numerics.heap import make_heap, pop, push
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.norm import distance
from skyverse.space.lattice import Grid, position, write_position
from skyverse.space.obstacles import Space
from skyverse.space.world import segment_free

_SEEN = 1
_CLOSED = 2


def lazy_theta_star(
    grid: Grid, space: Space, source: int, goal: int, most: float, weight: float = 1.0
) -> tuple[Ints, int]:
    """Search from one node to another for a path shorter than `most` metres.

    A node takes over the parent of the node from which it is reached. Whether that parent sees it is checked only when
    the node itself is expanded: if not, the best of its expanded neighbours becomes its parent. The goal is the next
    node if the source sees it.

    The node with the least sum of the length to it and `weight` times the straight line left to the goal is expanded
    first. With a weight above 1 far fewer nodes are expanded, and the path may be a little longer.

    Returns
    -------
    corners
        (n,) nodes, each seen from the one before; none if no such path was found.
    expanded
        How many nodes were expanded.

    References
    ----------
    A. Nash, S. Koenig, C. Tovey, "Lazy Theta*: Any-Angle Path Planning and Path Length Analysis in 3D" (AAAI 2010).
    """
    unseen = np.zeros(len(grid.exits), np.uint8)  # a kernel would clear all of them, numpy those that are read
    corners, expanded = _expand(grid, space, unseen, source, goal, most, weight)
    return corners, int(expanded)


@kernel
def _expand(
    grid: Grid, space: Space, flags: NDArray[np.uint8], source: int, goal: int, most: float, weight: float
) -> tuple[Ints, int]:
    """Do the search of `lazy_theta_star` with a flag for each node, (nodes,), which are 0."""
    here, above, beside, target = position(grid, source), np.empty(3), np.empty(3), position(grid, goal)
    if distance(here, target) < most and segment_free(space, here, target):
        return np.array([source, goal]), 1
    parent = np.empty(len(grid.exits), np.int64)
    g = np.empty(len(grid.exits), np.float64)
    steps = grid.moves * grid.step
    parent[source], g[source], flags[source] = source, 0.0, _SEEN
    heap = push(make_heap(1024), 0.0, source)
    expanded = 0
    while heap.size[0]:
        _, node = pop(heap)
        if flags[node] == _CLOSED:
            continue
        expanded += 1
        exits = grid.exits[node]
        write_position(grid, node, here)
        write_position(grid, parent[node], above)
        if node != source and not segment_free(space, above, here):
            g[node] = math.inf
            for m in range(len(grid.offsets)):
                beyond = node + grid.offsets[m]
                if (exits >> m) & 1 and flags[beyond] == _CLOSED:
                    length = g[beyond] + math.sqrt(steps[m, 0] ** 2 + steps[m, 1] ** 2 + steps[m, 2] ** 2)
                    if length < g[node]:
                        parent[node], g[node] = beyond, length
            write_position(grid, parent[node], above)
        flags[node] = _CLOSED
        if node == goal:
            break
        up = parent[node]
        for m in range(len(grid.offsets)):
            beyond = node + grid.offsets[m]
            if not (exits >> m) & 1 or flags[beyond] == _CLOSED:
                continue
            for axis in range(3):
                beside[axis] = here[axis] + steps[m, axis]
            length = g[up] + distance(above, beside)
            if flags[beyond] == _SEEN and length >= g[beyond]:
                continue
            parent[beyond], g[beyond], flags[beyond] = up, length, _SEEN
            left = distance(beside, target)
            if length + left < most:
                heap = push(heap, length + weight * left, beyond)
    if flags[goal] != _CLOSED:
        return np.empty(0, np.int64), expanded
    return _corners(parent, source, goal), expanded


@inner
def _corners(parent: Ints, source: int, goal: int) -> Ints:
    """Return the nodes from the source to the goal, each the next one's parent."""
    count = 1
    node = goal
    while node != source:
        node = parent[node]
        count += 1
    corners = np.empty(count, np.int64)
    for i in range(count - 1, -1, -1):
        corners[i] = goal
        goal = parent[goal]
    return corners
