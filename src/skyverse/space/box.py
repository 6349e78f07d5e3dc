"""Boxes as one shape of the world: ``boxes`` is (n, 6) metres, min corner then max corner, not yet grown.

A shape is a file like this one: holds, meets, gap, touch. The world's index asks those of its shapes that are near.
"""

import math

import numpy as np
from numpy.typing import NDArray

from skyverse.kernel import kernel
from skyverse.result import Floats

Ints = NDArray[np.int64]

TOLERANCE = 1e-9
"""Metres that a point may lie inside a grown obstacle, or outside the bounds, through rounding."""


@kernel
def holds(boxes: Floats, i: int, growth: float, x: float, y: float, z: float) -> bool:
    """Tell whether the interior of box i, grown by `growth`, holds the point."""
    margin = growth - TOLERANCE
    return (
        boxes[i, 0] - margin < x < boxes[i, 3] + margin
        and boxes[i, 1] - margin < y < boxes[i, 4] + margin
        and boxes[i, 2] - margin < z < boxes[i, 5] + margin
    )


@kernel
def meets(boxes: Floats, i: int, growth: float, a: Floats, b: Floats) -> bool:
    """Tell whether the segment a-b meets the interior of box i, grown by `growth` (slab method, exact)."""
    margin = growth - TOLERANCE
    enter = 0.0
    leave = 1.0
    for axis in range(3):
        low = boxes[i, axis] - margin
        high = boxes[i, axis + 3] + margin
        d = b[axis] - a[axis]
        if d == 0.0:
            if a[axis] <= low or a[axis] >= high:
                return False
        else:
            t1 = (low - a[axis]) / d
            t2 = (high - a[axis]) / d
            enter = max(enter, min(t1, t2))
            leave = min(leave, max(t1, t2))
            if enter > leave:
                return False
    return enter < leave or holds(boxes, i, growth, a[0], a[1], a[2])


@kernel
def gap(boxes: Floats, i: int, x: float, y: float, z: float) -> float:
    """Return the Euclidean distance to box i as given, negative inside."""
    dx = max(boxes[i, 0] - x, x - boxes[i, 3])
    dy = max(boxes[i, 1] - y, y - boxes[i, 4])
    dz = max(boxes[i, 2] - z, z - boxes[i, 5])
    outside = math.sqrt(max(dx, 0.0) ** 2 + max(dy, 0.0) ** 2 + max(dz, 0.0) ** 2)
    return outside if outside > 0.0 else max(dx, dy, dz)


@kernel
def touch(boxes: Floats, growth: float, origin: Floats, step: Floats, shape: Ints, touched: NDArray[np.uint8]) -> None:
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
