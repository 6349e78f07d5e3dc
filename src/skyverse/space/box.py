"""Boxes as one shape of the world: ``boxes`` is (n, 6) metres, min corner then max corner, not yet grown.

A shape is a file like this one: contains, crosses, distance, touch. The world asks each of its shapes in turn.
"""

import math

import numpy as np

from skyverse.kernel import kernel
from skyverse.result import Floats

TOLERANCE = 1e-9
"""Metres that a point may lie inside a grown obstacle, or outside the bounds, through rounding."""


@kernel
def contains(boxes: Floats, growth: float, x: float, y: float, z: float) -> int:
    """Return the first box whose interior, grown by `growth`, holds the point, or -1."""
    margin = growth - TOLERANCE
    for i in range(boxes.shape[0]):
        if (
            boxes[i, 0] - margin < x < boxes[i, 3] + margin
            and boxes[i, 1] - margin < y < boxes[i, 4] + margin
            and boxes[i, 2] - margin < z < boxes[i, 5] + margin
        ):
            return i
    return -1


@kernel
def crosses(boxes: Floats, growth: float, a: Floats, b: Floats) -> int:
    """Return the first box whose interior, grown by `growth`, the segment a-b meets, or -1 (slab method, exact)."""
    margin = growth - TOLERANCE
    for i in range(boxes.shape[0]):
        enter = 0.0
        leave = 1.0
        for axis in range(3):
            low = boxes[i, axis] - margin
            high = boxes[i, axis + 3] + margin
            d = b[axis] - a[axis]
            if d == 0.0:
                if a[axis] <= low or a[axis] >= high:
                    leave = -1.0
            else:
                t1 = (low - a[axis]) / d
                t2 = (high - a[axis]) / d
                enter = max(enter, min(t1, t2))
                leave = min(leave, max(t1, t2))
        if enter < leave or (enter == leave and contains(boxes[i : i + 1], growth, a[0], a[1], a[2]) >= 0):
            return i
    return -1


@kernel
def distance(boxes: Floats, x: float, y: float, z: float) -> float:
    """Return the Euclidean distance to the nearest box as given, negative inside; infinite without boxes."""
    nearest = math.inf
    for i in range(boxes.shape[0]):
        dx = max(boxes[i, 0] - x, x - boxes[i, 3])
        dy = max(boxes[i, 1] - y, y - boxes[i, 4])
        dz = max(boxes[i, 2] - z, z - boxes[i, 5])
        outside = math.sqrt(max(dx, 0.0) ** 2 + max(dy, 0.0) ** 2 + max(dz, 0.0) ** 2)
        nearest = min(nearest, outside if outside > 0.0 else max(dx, dy, dz))
    return nearest


@kernel
def touch(boxes: Floats, growth: float, origin: Floats, step: Floats, shape: np.ndarray, touched: np.ndarray) -> None:
    """Mark the lattice's points, edges, faces and cells that a closed grown box touches.

    Bit ``e = ex + 2 ey + 4 ez`` of ``touched[i, j, k]`` stands for the block from node (i, j, k) to node
    (i + ex, j + ey, k + ez). A move is safe if its block is untouched, so a wall thinner than a step cannot be missed.
    """
    first = np.empty(3, np.int64)
    last = np.empty(3, np.int64)
    for b in range(boxes.shape[0]):
        for e in range(8):
            for axis in range(3):
                reach = (e >> axis) & 1
                low = (boxes[b, axis] - growth - origin[axis]) / step[axis]
                high = (boxes[b, axis + 3] + growth - origin[axis]) / step[axis]
                first[axis] = max(0, math.ceil(low - reach - 1e-9))
                last[axis] = min(shape[axis] - 1 - reach, math.floor(high + 1e-9))
            for i in range(first[0], last[0] + 1):
                for j in range(first[1], last[1] + 1):
                    for k in range(first[2], last[2] + 1):
                        touched[i, j, k] |= 1 << e
