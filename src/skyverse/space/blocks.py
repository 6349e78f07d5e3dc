"""Which blocks of the lattice are touched by boxes, by other solids and by the ground.

A block is a point, an edge, a face or a cell of the lattice. Bit ``e = ex + 2 ey + 4 ez`` of ``touched[i, j, k]``
stands for the block from node (i, j, k) to node (i + ex, j + ey, k + ez). A move is safe if its block is not touched,
so a wall thinner than a step cannot be missed.

What a solid fills of a column of blocks lies between two altitudes. So the columns that it touches are found on the map
first, and then from which block up to which it fills them.
"""

import math

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import BLOCK_CONTACT
from skyverse.space import ground as terrain
from skyverse.space import polygon
from skyverse.space.ground import Ground
from skyverse.space.solids import PRISM, SPHERE, Solids

Blocks = NDArray[np.uint8]


@kernel
def mark_boxes(boxes: Floats, growth: float, origin: Floats, step: Floats, shape: Ints, touched: Blocks) -> None:
    """Mark the blocks that a closed box, grown by `growth`, touches."""
    first = np.empty(3, np.int64)
    last = np.empty(3, np.int64)
    for b in range(boxes.shape[0]):
        for e in range(8):
            for axis in range(3):
                reach = (e >> axis) & 1
                low = (boxes[b, axis] - growth - origin[axis]) / step[axis]
                high = (boxes[b, axis + 3] + growth - origin[axis]) / step[axis]
                first[axis] = max(0, math.ceil(low - reach - BLOCK_CONTACT))
                last[axis] = min(shape[axis] - 1 - reach, math.floor(high + BLOCK_CONTACT))
            for i in range(first[0], last[0] + 1):
                for j in range(first[1], last[1] + 1):
                    for k in range(first[2], last[2] + 1):
                        touched[i, j, k] |= 1 << e


@kernel
def mark_solids(solids: Solids, growth: float, origin: Floats, step: Floats, shape: Ints, touched: Blocks) -> None:
    """Mark the blocks that a closed solid, grown by `growth`, touches."""
    for s in range(len(solids.bounds)):
        i0, i1 = _range(solids.bounds[s, 0] - growth, solids.bounds[s, 3] + growth, origin[0], step[0], shape[0], 1)
        j0, j1 = _range(solids.bounds[s, 1] - growth, solids.bounds[s, 4] + growth, origin[1], step[1], shape[1], 1)
        if i1 < i0 or j1 < j0:
            continue
        if solids.kind[s, 0] == SPHERE:
            _mark_sphere(solids.round[s], growth, origin, step, shape, touched)
            continue
        columns = np.zeros((i1 - i0 + 1, j1 - j0 + 1), np.uint8)
        if solids.kind[s, 0] == PRISM:
            _prism_columns(solids, s, growth + BLOCK_CONTACT, origin, step, i0, j0, columns)
        else:
            _disc_columns(solids.round[s], growth + BLOCK_CONTACT, origin, step, i0, j0, columns)
        for up in range(2):
            low, high = solids.bounds[s, 2] - growth, solids.bounds[s, 5] + growth
            k0, k1 = _range(low, high, origin[2], step[2], shape[2], up)
            k1 = min(k1, shape[2] - 1 - up)
            for i in range(i0, i1 + 1):
                for j in range(j0, j1 + 1):
                    bits = _within(columns[i - i0, j - j0], i, j, shape) << (4 * up)
                    if bits:
                        for k in range(k0, k1 + 1):
                            touched[i, j, k] |= bits


@inner
def _range(low: float, high: float, origin: float, step: float, nodes: int, reach: int) -> tuple[int, int]:
    """Return the first and the last node whose block, `reach` steps long, meets an interval."""
    first = math.ceil((low - origin) / step - reach - BLOCK_CONTACT)
    last = math.floor((high - origin) / step + BLOCK_CONTACT)
    return max(0, min(first, nodes)), min(nodes - 1, max(last, -1))


@inner
def _within(bits: int, i: int, j: int, shape: Ints) -> int:
    """Return the bits of those blocks of a column that do not reach beyond the lattice's last nodes."""
    if i == shape[0] - 1:
        bits &= 5
    if j == shape[1] - 1:
        bits &= 3
    return bits


@inner
def _disc_columns(
    round_: Floats, growth: float, origin: Floats, step: Floats, i0: int, j0: int, columns: Blocks
) -> None:
    """Mark by bit ``ex + 2 ey`` the rectangles that a disc touches, each from node (i0 + i, j0 + j) on."""
    reach = (round_[3] + growth) ** 2
    for i in range(columns.shape[0]):
        x = origin[0] + (i0 + i) * step[0]
        for j in range(columns.shape[1]):
            y = origin[1] + (j0 + j) * step[1]
            for e in range(4):
                dx = max(x - round_[0], round_[0] - x - (e & 1) * step[0], 0.0)
                dy = max(y - round_[1], round_[1] - y - (e >> 1) * step[1], 0.0)
                if dx * dx + dy * dy <= reach:
                    columns[i, j] |= 1 << e


@inner
def _mark_sphere(round_: Floats, growth: float, origin: Floats, step: Floats, shape: Ints, touched: Blocks) -> None:
    """Mark the blocks that a closed sphere, grown by `growth`, touches."""
    reach = round_[3] + growth + BLOCK_CONTACT
    i0, i1 = _range(round_[0] - reach, round_[0] + reach, origin[0], step[0], shape[0], 1)
    j0, j1 = _range(round_[1] - reach, round_[1] + reach, origin[1], step[1], shape[1], 1)
    columns = np.zeros((1, 1), np.uint8)
    for i in range(i0, i1 + 1):
        x = origin[0] + i * step[0]
        for j in range(j0, j1 + 1):
            y = origin[1] + j * step[1]
            for e in range(4):
                dx = max(x - round_[0], round_[0] - x - (e & 1) * step[0], 0.0)
                dy = max(y - round_[1], round_[1] - y - (e >> 1) * step[1], 0.0)
                half = reach * reach - dx * dx - dy * dy
                columns[0, 0] = 1 << e
                bits = _within(columns[0, 0], i, j, shape)
                if half < 0.0 or not bits:
                    continue
                half = math.sqrt(half)
                for up in range(2):
                    k0, k1 = _range(round_[2] - half, round_[2] + half, origin[2], step[2], shape[2], up)
                    for k in range(k0, min(k1, shape[2] - 1 - up) + 1):
                        touched[i, j, k] |= bits << (4 * up)


@inner
def _prism_columns(
    solids: Solids, s: int, growth: float, origin: Floats, step: Floats, i0: int, j0: int, columns: Blocks
) -> None:
    """Mark by bit ``ex + 2 ey`` the rectangles that a grown polygon touches, each from node (i0 + i, j0 + j) on.

    Rectangles near an edge are found edge by edge and row by row; the others are inside if their first node is.
    """
    rows, lines = columns.shape
    x0, y0 = origin[0] + i0 * step[0], origin[1] + j0 * step[1]
    squared = growth * growth
    odd = np.zeros((rows, lines), np.uint8)
    for e in range(solids.kind[s, 1], solids.kind[s, 2]):
        ax, ay, bx, by = solids.edges[e, 0], solids.edges[e, 1], solids.edges[e, 2], solids.edges[e, 3]
        j_first, j_last = _range(min(ay, by) - growth, max(ay, by) + growth, y0, step[1], lines, 1)
        for j in range(j_first, j_last + 1):
            y = y0 + j * step[1]
            # the part of the edge that passes this row, with half a circle beyond either end
            begin, end = 0.0, 1.0
            if by != ay:
                one, other = (y - growth - ay) / (by - ay), (y + step[1] + growth - ay) / (by - ay)
                begin, end = max(0.0, min(one, other)), min(1.0, max(one, other))
            left, right = ax + begin * (bx - ax), ax + end * (bx - ax)
            i_first, i_last = _range(min(left, right) - growth, max(left, right) + growth, x0, step[0], rows, 1)
            for i in range(i_first, i_last + 1):
                x = x0 + i * step[0]
                for f in range(4):
                    if not (columns[i, j] >> f) & 1:
                        apart = polygon.to_rectangle(
                            ax, ay, bx, by, x, y, x + (f & 1) * step[0], y + (f >> 1) * step[1]
                        )
                        if apart <= squared:
                            columns[i, j] |= 1 << f
            if (ay > y) != (by > y):  # the edge is to the left of the nodes beyond it
                beyond = math.floor((ax + (y - ay) / (by - ay) * (bx - ax) - x0) / step[0]) + 1
                if beyond < rows:
                    odd[max(beyond, 0), j] ^= 1
    for j in range(lines):
        inside = 0
        for i in range(rows):
            inside ^= odd[i, j]
            if inside:
                columns[i, j] = 15


@kernel
def mark_ground(ground: Ground, growth: float, origin: Floats, step: Floats, shape: Ints, touched: Blocks) -> None:
    """Mark the blocks that are not wholly higher above the ground than required."""
    if len(ground.heights) == 0:
        return
    tops = _greatest_heights(ground, origin, step, shape)
    margin = growth + ground.extra
    for i in range(shape[0]):
        for j in range(shape[1]):
            for e in range(4):
                if tops[e, i, j] > -math.inf:
                    last = math.floor((tops[e, i, j] + margin - origin[2]) / step[2] + BLOCK_CONTACT)
                    for k in range(min(last, shape[2] - 1) + 1):
                        touched[i, j, k] |= (17 if k < shape[2] - 1 else 1) << e


@kernel
def mark_ceiling(ceiling: Ground, growth: float, origin: Floats, step: Floats, shape: Ints, touched: Blocks) -> None:
    """Mark the blocks that are not wholly below the ceiling, a ground upside down; see `Space.ceiling`."""
    if len(ceiling.heights) == 0:
        return
    tops = _greatest_heights(ceiling, origin, step, shape)
    margin = growth + ceiling.extra
    for i in range(shape[0]):
        for j in range(shape[1]):
            for e in range(4):
                if tops[e, i, j] > -math.inf:
                    first = math.ceil((-(tops[e, i, j] + margin) - origin[2]) / step[2] - BLOCK_CONTACT)
                    for k in range(max(first, 0), shape[2]):
                        touched[i, j, k] |= 1 << e
                    for k in range(max(first - 1, 0), shape[2] - 1):
                        touched[i, j, k] |= 16 << e


@inner
def _greatest_heights(ground: Ground, origin: Floats, step: Floats, shape: Ints) -> Floats:
    """Return the ground's greatest z at nodes, along sides in x, along sides in y, and in rectangles, (4, nx, ny).

    It is minus infinity where there is no such block. Within a rectangle the ground is highest on one of the
    rectangle's sides, or at one of the terrain's given heights; along a side it is highest at one of the side's ends,
    or where the side passes from one of the terrain's cells to the next.
    """
    nx, ny = shape[0], shape[1]
    tops = np.full((4, nx, ny), -math.inf)
    for i in range(nx):
        x = origin[0] + i * step[0]
        for j in range(ny):
            y = origin[1] + j * step[1]
            tops[0, i, j] = terrain.height(ground, x, y)
            if i + 1 < nx:
                tops[1, i, j] = _highest_along(ground, 0, x, x + step[0], y)
            if j + 1 < ny:
                tops[2, i, j] = _highest_along(ground, 1, y, y + step[1], x)
    for j in range(ny):
        for i in range(nx - 1):
            tops[1, i, j] = max(tops[1, i, j], tops[0, i, j], tops[0, i + 1, j])
    for i in range(nx):
        for j in range(ny - 1):
            tops[2, i, j] = max(tops[2, i, j], tops[0, i, j], tops[0, i, j + 1])
    for i in range(nx - 1):
        a0, a1 = _between(ground, 0, origin[0] + i * step[0], origin[0] + (i + 1) * step[0])
        for j in range(ny - 1):
            top = max(max(tops[1, i, j], tops[1, i, j + 1]), max(tops[2, i, j], tops[2, i + 1, j]))
            b0, b1 = _between(ground, 1, origin[1] + j * step[1], origin[1] + (j + 1) * step[1])
            for a in range(a0, a1 + 1):
                for b in range(b0, b1 + 1):
                    top = max(top, ground.heights[a, b])
            tops[3, i, j] = top
    return tops


@inner
def _between(ground: Ground, axis: int, low: float, high: float) -> tuple[int, int]:
    """Return the first and the last row or column of heights between two coordinates."""
    first = math.ceil((low - ground.origin[axis]) / ground.step[axis])
    last = math.floor((high - ground.origin[axis]) / ground.step[axis])
    return max(first, 0), min(last, ground.heights.shape[axis] - 1)


@inner
def _highest_along(ground: Ground, axis: int, low: float, high: float, other: float) -> float:
    """Return the ground's greatest z where a line along an axis, between two coordinates, meets the heights' grid."""
    highest = -math.inf
    first, last = _between(ground, axis, low, high)
    for n in range(first, last + 1):
        at = ground.origin[axis] + n * ground.step[axis]
        highest = max(highest, terrain.height(ground, at, other) if axis == 0 else terrain.height(ground, other, at))
    return highest
