"""The ground: heights on a grid, bilinear in each cell, with a pyramid of the least and greatest heights of blocks.

The blocks of level 0 are the cells; a block of level L consists of two by two blocks of level L - 1. A query visits the
blocks in a fixed order, without a stack, and goes into those where the ground may be in the way.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.shapes import Terrain
from skyverse.numerics.kernel import by_reference, inner_query, query
from skyverse.numerics.tolerances import SURFACE_DEPTH, TERRAIN_RIM
from skyverse.space.slab import clip


@by_reference
class Ground(NamedTuple):
    """A terrain compiled; without one, all arrays are empty.

    Attributes
    ----------
    heights
        (nx, ny) z in metres.
    origin, step
        (2,) x, y in metres.
    extra
        Metres by which the ground's clearance exceeds the scenario's, by which the other obstacles are grown.
    slope
        The steepest slope anywhere, metres of height a metre.
    extremes
        (k, 2) metres: the least and the greatest height of every block, level after level from level 1.
    levels
        (top + 1, 3) for every level: where it begins in `extremes`, and how many rows and columns of blocks it has.
    """

    heights: Floats
    origin: Floats
    step: Floats
    extra: float
    slope: float
    extremes: Floats
    levels: Ints


def make_ground(terrain: Terrain | None, extra: float = 0.0) -> Ground:
    """Compile a terrain, or none."""
    if terrain is None:
        none = np.zeros(0)
        return Ground(np.zeros((0, 0)), none, none, 0.0, 0.0, np.zeros((0, 2)), np.zeros((0, 3), np.int64))
    heights = terrain.heights.copy()  # a copy that is not read-only: for other arrays kernels would be compiled anew
    rows, columns = (count - 1 for count in heights.shape)
    levels, total = [(0, rows, columns)], 0
    while rows * columns > 1:
        rows, columns = (rows + 1) // 2, (columns + 1) // 2
        levels.append((total, rows, columns))
        total += rows * columns
    extremes, rises = np.empty((total, 2)), np.zeros(2)
    fill_extremes(heights, np.array(levels, dtype=np.int64), extremes, rises)
    step = np.array(terrain.step)
    slope = math.hypot(*(rises / step))
    return Ground(heights, np.array(terrain.origin), step, extra, slope, extremes, np.array(levels, dtype=np.int64))


@query
def fill_extremes(heights: Floats, levels: Ints, extremes: Floats, rises: Floats) -> None:
    """Fill in `Ground.extremes`, and the greatest differences of neighbouring heights along x and along y, (2,)."""
    nx, ny = heights.shape
    for i in range(nx):
        for j in range(ny):
            if i > 0:
                rises[0] = max(rises[0], abs(heights[i, j] - heights[i - 1, j]))
            if j > 0:
                rises[1] = max(rises[1], abs(heights[i, j] - heights[i, j - 1]))
    for level in range(1, len(levels)):
        begin, rows, columns = levels[level]
        before, n, m = levels[level - 1]
        for i in range(rows):
            for j in range(columns):
                low, high = math.inf, -math.inf
                if level == 1:  # the corners of two by two cells
                    for k in range(2 * i, min(2 * i + 3, nx)):
                        for q in range(2 * j, min(2 * j + 3, ny)):
                            low, high = min(low, heights[k, q]), max(high, heights[k, q])
                else:
                    for k in range(2 * i, min(2 * i + 2, n)):
                        for q in range(2 * j, min(2 * j + 2, m)):
                            low = min(low, extremes[before + k * m + q, 0])
                            high = max(high, extremes[before + k * m + q, 1])
                extremes[begin + i * columns + j, 0], extremes[begin + i * columns + j, 1] = low, high


@inner_query
def _cell(ground: Ground, axis: int, at: float) -> tuple[int, float]:
    """Return the row or column of cells that holds a coordinate, -1 beyond the rim, and the share of it before that."""
    along = at - ground.origin[axis]
    cells = ground.heights.shape[axis] - 1
    if not -TERRAIN_RIM <= along <= cells * ground.step[axis] + TERRAIN_RIM:
        return -1, 0.0
    along /= ground.step[axis]
    i = min(max(math.floor(along), 0), cells - 1)
    return i, along - i


@inner_query
def bilinear(ground: Ground, i: int, j: int, u: float, v: float) -> float:
    """Return the ground's z in cell (i, j), at the shares u of its extent in x and v of its extent in y."""
    h = ground.heights
    return (h[i, j] * (1.0 - u) + h[i + 1, j] * u) * (1.0 - v) + (h[i, j + 1] * (1.0 - u) + h[i + 1, j + 1] * u) * v


@query
def height(ground: Ground, x: float, y: float) -> float:
    """Return the ground's z at a place; minus infinity beyond the terrain, or without one."""
    if len(ground.heights) == 0:
        return -math.inf
    i, u = _cell(ground, 0, x)
    j, v = _cell(ground, 1, y)
    return bilinear(ground, i, j, u, v) if i >= 0 and j >= 0 else -math.inf


@inner_query
def _side(ground: Ground, axis: int, level: int, block: int) -> tuple[float, float]:
    """Return where a block begins and ends along an axis."""
    cells = ground.heights.shape[axis] - 1
    first, last = block << level, min((block + 1) << level, cells)
    low, high = ground.origin[axis] + first * ground.step[axis], ground.origin[axis] + last * ground.step[axis]
    return low - TERRAIN_RIM if first == 0 else low, high + TERRAIN_RIM if last == cells else high


@inner_query
def _extreme(ground: Ground, level: int, i: int, j: int, greatest: bool) -> float:
    """Return the least or the greatest height of a block."""
    if level > 0:
        return ground.extremes[ground.levels[level, 0] + i * ground.levels[level, 2] + j, 1 if greatest else 0]
    h = ground.heights
    if greatest:
        return max(max(h[i, j], h[i + 1, j]), max(h[i, j + 1], h[i + 1, j + 1]))
    return min(min(h[i, j], h[i + 1, j]), min(h[i, j + 1], h[i + 1, j + 1]))


@inner_query
def _next(level: int, i: int, j: int, top: int) -> tuple[int, int, int]:
    """Return level, row and column of the block after a block and all in it; after the last, a level above `top`."""
    while level < top and i & 1 and j & 1:
        level, i, j = level + 1, i >> 1, j >> 1
    if level == top:
        return top + 1, 0, 0
    return (level, i - 1, j + 1) if i & 1 else (level, i + 1, j)


@query
def crossed(ground: Ground, margin: float, dev: float, a: Floats, b: Floats, up: float) -> bool:
    """Tell whether what is within `dev` of the segment a-b may come nearer than a margin above ground.

    `up` is 1, or -1 for a ground that is upside down, which is met by points whose z are negated.

    For a `dev` of 0 the answer is exact, by the least value of a quadratic in every cell. Otherwise the slope in each
    cell is bounded by its steepest, and the answer is never False where it should be True.
    """
    if len(ground.heights) == 0:
        return False
    margin -= SURFACE_DEPTH
    dx, dy, rise = b[0] - a[0], b[1] - a[1], up * (b[2] - a[2])
    top = len(ground.levels) - 1
    level, i, j = top, 0, 0
    while level <= top:
        if i < ground.levels[level, 1] and j < ground.levels[level, 2]:
            x0, x1 = _side(ground, 0, level, i)
            enter, leave = clip(x0 - dev, x1 + dev, a[0], dx, 0.0, 1.0)
            if enter <= leave:
                y0, y1 = _side(ground, 1, level, j)
                enter, leave = clip(y0 - dev, y1 + dev, a[1], dy, enter, leave)
            if enter <= leave:
                lowest = up * a[2] + min(enter * rise, leave * rise) - dev
                if lowest < _extreme(ground, level, i, j, True) + margin:
                    if level > 0:
                        level, i, j = level - 1, 2 * i, 2 * j
                        continue
                    if _least(ground, i, j, dev, a, b, (enter, leave), up) < margin:
                        return True
        level, i, j = _next(level, i, j, top)
    return False


@inner_query
def _least(
    ground: Ground, i: int, j: int, dev: float, a: Floats, b: Floats, shares: tuple[float, float], up: float
) -> float:
    """Return the least height of a segment above a cell's ground between two shares, less what `dev` may take away.

    With the share s between the two, the height is begin + (end - begin - curved) s + curved s^2.
    """
    enter, leave = shares
    sx, sy = ground.step[0], ground.step[1]
    u, v = (a[0] - ground.origin[0]) / sx - i, (a[1] - ground.origin[1]) / sy - j
    du, dv = (b[0] - a[0]) / sx, (b[1] - a[1]) / sy
    rise = up * (b[2] - a[2])
    h = ground.heights
    twist = h[i, j] + h[i + 1, j + 1] - h[i + 1, j] - h[i, j + 1]
    begin = up * a[2] + enter * rise - bilinear(ground, i, j, u + enter * du, v + enter * dv)
    end = up * a[2] + leave * rise - bilinear(ground, i, j, u + leave * du, v + leave * dv)
    curved = -twist * du * dv * (leave - enter) ** 2
    least = min(begin, end)
    if curved > 0.0:
        at = (begin + curved - end) / (2.0 * curved)
        if 0.0 < at < 1.0:
            least = min(least, begin - curved * at * at)
    if dev > 0.0:
        over_x, over_y = abs(twist) * dev / sy, abs(twist) * dev / sx
        along_x = max(abs(h[i + 1, j] - h[i, j]), abs(h[i + 1, j + 1] - h[i, j + 1])) + over_x
        along_y = max(abs(h[i, j + 1] - h[i, j]), abs(h[i + 1, j + 1] - h[i + 1, j])) + over_y
        least -= dev * math.sqrt(1.0 + (along_x / sx) ** 2 + (along_y / sy) ** 2)
    return least


@inner_query
def highest(ground: Ground, above: float, x0: float, y0: float, x1: float, y1: float) -> float:
    """Return exactly the ground's greatest z in a closed rectangle, or `above` if nothing there is higher."""
    if len(ground.heights) == 0:
        return above
    top = len(ground.levels) - 1
    level, i, j = top, 0, 0
    while level <= top:
        if i < ground.levels[level, 1] and j < ground.levels[level, 2]:
            left, right = _side(ground, 0, level, i)
            near, far = _side(ground, 1, level, j)
            if left <= x1 and x0 <= right and near <= y1 and y0 <= far:
                greatest = _extreme(ground, level, i, j, True)
                if greatest > above:
                    if x0 <= left and right <= x1 and y0 <= near and far <= y1:
                        above = greatest
                    elif level > 0:
                        level, i, j = level - 1, 2 * i, 2 * j
                        continue
                    else:
                        near, far = max(y0, near), min(y1, far)
                        above = max(above, _highest_in_cell(ground, i, j, max(x0, left), near, min(x1, right), far))
        level, i, j = _next(level, i, j, top)
    return above


@inner_query
def _highest_in_cell(ground: Ground, i: int, j: int, x0: float, y0: float, x1: float, y1: float) -> float:
    """Return the greatest z in a rectangle within a cell: at one of its corners."""
    u0, u1 = (x0 - ground.origin[0]) / ground.step[0] - i, (x1 - ground.origin[0]) / ground.step[0] - i
    v0, v1 = (y0 - ground.origin[1]) / ground.step[1] - j, (y1 - ground.origin[1]) / ground.step[1] - j
    one = max(bilinear(ground, i, j, u0, v0), bilinear(ground, i, j, u1, v0))
    return max(one, max(bilinear(ground, i, j, u0, v1), bilinear(ground, i, j, u1, v1)))
