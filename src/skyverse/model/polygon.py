"""Polygons: whether their outlines touch or cross, and whether a point is inside; exact except for rounding."""

from bisect import bisect_right

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats

Outline = tuple[tuple[float, float], ...]
"""The corners of an outline, x and y in metres, the first not repeated."""
Edge = tuple[float, float, float, float]
"""x and y of the first end, x and y of the second."""
EdgeNumber = tuple[int, int]
"""The number of the outline, and that of the edge in it."""


def edges_that_meet(rings: list[Outline]) -> tuple[EdgeNumber, EdgeNumber] | None:
    """Return two edges that meet, each as the numbers of its outline and of the edge in it, or ``None``.

    Two consecutive edges of an outline share a corner, and count as meeting only where one folds back onto the other.
    The search sweeps along x or y, whichever compares fewer edges: every edge is compared with those that begin after
    it and before it ends. Of several pairs that meet, the one is told that the sweep finds first.
    """
    edges = [(*a, *b) for ring in rings for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)]
    numbers = [(number, edge) for number, ring in enumerate(rings) for edge in range(len(ring))]
    sweeps = []
    for axis in range(2):
        low = [min(edge[axis], edge[axis + 2]) for edge in edges]
        high = [max(edge[axis], edge[axis + 2]) for edge in edges]
        begins = sorted(low)
        sweeps.append((sum(bisect_right(begins, end) for end in high), low, high))
    (_, low, high), (_, near, far) = sorted(sweeps, key=lambda sweep: sweep[0])
    order = sorted(range(len(edges)), key=low.__getitem__)
    for position, i in enumerate(order, 1):
        for k in range(position, len(order)):
            j = order[k]
            if low[j] > high[i]:
                break
            if near[j] <= far[i] and near[i] <= far[j] and _meet(edges[i], edges[j], numbers[i], numbers[j], rings):
                first, second = sorted((i, j))
                return numbers[first], numbers[second]
    return None


def _meet(one: Edge, other: Edge, number: EdgeNumber, another: EdgeNumber, rings: list[Outline]) -> bool:
    """Tell whether two edges whose bounding boxes overlap meet, or fold back where one follows the other."""
    ring, size = number[0], len(rings[number[0]])
    if ring == another[0]:
        if (number[1] + 1) % size == another[1]:
            return _folds_back(one, other)
        if (another[1] + 1) % size == number[1]:
            return _folds_back(other, one)
    return _side(one, *other[:2]) * _side(one, *other[2:]) <= 0 and _side(other, *one[:2]) * _side(other, *one[2:]) <= 0


def _folds_back(edge: Edge, following: Edge) -> bool:
    """Tell whether the edge that follows another one folds back onto it."""
    onward = (edge[2] - edge[0]) * (following[2] - following[0]) + (edge[3] - edge[1]) * (following[3] - following[1])
    return _side(edge, *following[2:]) == 0 and not onward > 0


def _side(edge: Edge, x: float, y: float) -> int:
    """Return on which side of an edge a point is: 1 left, -1 right, 0 on its line or too close to tell."""
    turn = (edge[2] - edge[0]) * (y - edge[1]) - (edge[3] - edge[1]) * (x - edge[0])
    return (turn > 0) - (turn < 0)


def is_inside(point: tuple[float, float], ring: Outline) -> bool:
    """Tell whether a point is inside an outline: a ray along x crosses the outline an odd number of times."""
    odd = False
    for (ax, ay), (bx, by) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if (ay > point[1]) != (by > point[1]):
            odd ^= (point[1] - ay) / (by - ay) * (bx - ax) + ax > point[0]
    return odd


def are_inside(points: Floats, ring: Outline) -> NDArray[np.bool_]:
    """Tell of many points (n, 2) whether they are inside an outline, (n,)."""
    x, y = points.T
    odd = np.zeros(len(points), dtype=np.bool_)
    for (ax, ay), (bx, by) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if ay != by:
            odd ^= ((ay > y) != (by > y)) & ((y - ay) / (by - ay) * (bx - ax) + ax > x)
    return odd
