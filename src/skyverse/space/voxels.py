"""Voxels as boxes: occupied cells that fill a box together become one box."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.model.shapes import Box, Shape, Voxels
from skyverse.numerics.arrays import doubled
from skyverse.numerics.kernel import inner, kernel


def merged(voxels: Voxels) -> Floats:
    """Return boxes (n, 6), metres, that fill what the occupied cells fill, and do not overlap."""
    cells = _merged(voxels.occupied.astype(np.uint8))
    origin, step = np.array(voxels.origin), np.array(voxels.step)
    return np.hstack((origin + cells[:, :3] * step, origin + cells[:, 3:] * step))


def parts_of(shape: Shape) -> Sequence[Shape]:
    """Return what a shape consists of: of voxels, boxes that fill what the occupied cells fill, with their risk."""
    if not isinstance(shape, Voxels):
        return (shape,)
    return [Box(min=tuple(row[:3]), max=tuple(row[3:]), risk=shape.risk) for row in merged(shape).tolist()]


@kernel
def _merged(left: NDArray[np.uint8]) -> Ints:
    """Return the first cell of each box and the one beyond its last, (n, 6); `left` is used up.

    From each cell that is left, in order, a box is extended as far as possible along z, then y, then x.
    """
    nx, ny, nz = left.shape
    found = np.empty((64, 6), np.int64)
    count = 0
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if not left[i, j, k]:
                    continue
                i1, j1, k1 = i + 1, j + 1, k + 1
                while k1 < nz and left[i, j, k1]:
                    k1 += 1
                while j1 < ny and _full(left, i, i1, j1, j1 + 1, k, k1):
                    j1 += 1
                while i1 < nx and _full(left, i1, i1 + 1, j, j1, k, k1):
                    i1 += 1
                if count == len(found):
                    found = doubled(found)
                found[count, 0], found[count, 1], found[count, 2] = i, j, k
                found[count, 3], found[count, 4], found[count, 5] = i1, j1, k1
                _take_out(left, found[count : count + 1])
                count += 1
    return found[:count].copy()


@kernel
def _take_out(left: NDArray[np.uint8], boxes: Ints) -> None:
    """Remove the cells of boxes (n, 6) from those that are left."""
    for n in range(len(boxes)):
        for x in range(boxes[n, 0], boxes[n, 3]):
            for y in range(boxes[n, 1], boxes[n, 4]):
                for z in range(boxes[n, 2], boxes[n, 5]):
                    left[x, y, z] = 0


@inner
def _full(left: NDArray[np.uint8], i: int, i1: int, j: int, j1: int, k: int, k1: int) -> bool:
    """Tell whether all cells from (i, j, k) up to before (i1, j1, k1) are left."""
    for x in range(i, i1):
        for y in range(j, j1):
            for z in range(k, k1):
                if not left[x, y, z]:
                    return False
    return True
