"""Free space cut exactly into cells, which are boxes: a search over them finds a path, or proves that there is none.

It is a binary space partition: cells are cut along faces of grown obstacles until each is free, or inside one of them.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import doubled, order_of, put
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.space.obstacles import Space


@by_reference
class Cells(NamedTuple):
    """The partition as a tree; node 0 is the whole.

    Attributes
    ----------
    low, high
        (m, 3) metres.
    axis
        (m,) the axis across which a node is cut; `FREE` for a free cell, `SHUT` for one inside an obstacle.
    cut
        (m,) where it is cut, metres.
    below
        (m,) the child below the cut; the child above the cut is the next node.
    depth
        The depth of the tree.
    """

    low: Floats
    high: Floats
    axis: Ints
    cut: Floats
    below: Ints
    depth: int


FREE, SHUT = -1, -2
"""What `Cells.axis` holds for cells that are not cut: those that are free, and those inside an obstacle."""


@kernel
def make_cells(space: Space, growth: float) -> Cells:
    """Cut a world's bounds along the faces of its boxes grown by `growth`."""
    n = len(space.boxes)
    lows, highs = np.empty((n, 3)), np.empty((n, 3))
    for i in range(n):
        for axis in range(3):
            lows[i, axis], highs[i, axis] = space.boxes[i, axis] - growth, space.boxes[i, axis + 3] + growth
    size = 64
    low, high = np.empty((size, 3)), np.empty((size, 3))
    axes, cuts, below = np.empty(size, np.int64), np.empty(size), np.zeros(size, np.int64)
    put(low, 0, space.low)
    put(high, 0, space.high)
    count = 1
    lists = np.empty(4 * n + 64, np.int64)  # the boxes that reach into each of the waiting nodes
    waiting = np.empty((64, 4), np.int64)  # a node, its range of `lists`, and its level
    deepest = 0
    reach = 0
    for i in range(n):
        if _reaches(lows, highs, i, low[0], high[0]):
            lists[reach] = i
            reach += 1
    waiting[0, 0], waiting[0, 1], waiting[0, 2], waiting[0, 3] = 0, 0, reach, 0
    depth = 1
    faces = np.empty(2 * n)
    while depth:
        depth -= 1
        node, first, stop, level = waiting[depth, 0], waiting[depth, 1], waiting[depth, 2], waiting[depth, 3]
        deepest = max(deepest, level)
        axes[node] = FREE if first == stop else -3
        for k in range(first, stop):
            i = lists[k]
            if _holds(lows, highs, i, low[node], high[node]):
                axes[node] = SHUT
                break
        if axes[node] != -3:
            continue
        axis, cut = _best_cut(lows, highs, lists[first:stop], low[node], high[node], faces)
        if count + 2 > size:
            low, high = doubled(low), doubled(high)
            axes, cuts, below = doubled(axes), doubled(cuts), doubled(below)
            size *= 2
        axes[node], cuts[node], below[node] = axis, cut, count
        for child in (count, count + 1):
            put(low, child, low[node])
            put(high, child, high[node])
        high[count, axis] = cut
        low[count + 1, axis] = cut
        if stop + 2 * (stop - first) > len(lists):
            lists = doubled(lists)
        if depth + 2 > len(waiting):
            waiting = doubled(waiting)
        top = stop
        for child in (count + 1, count):  # the child taken next is put last: its list may be overwritten
            begin = top
            for k in range(first, stop):
                if _reaches(lows, highs, lists[k], low[child], high[child]):
                    lists[top] = lists[k]
                    top += 1
            waiting[depth, 0], waiting[depth, 1], waiting[depth, 2], waiting[depth, 3] = child, begin, top, level + 1
            depth += 1
        count += 2
    low, high, axes, cuts, below = low[:count], high[:count], axes[:count], cuts[:count], below[:count]
    return Cells(low.copy(), high.copy(), axes.copy(), cuts.copy(), below.copy(), deepest)


@inner
def _best_cut(lows: Floats, highs: Floats, some: Ints, low: Floats, high: Floats, faces: Floats) -> tuple[int, float]:
    """Choose an axis and a place to cut: few boxes are cut in two, and as many lie on one side as on the other."""
    best_axis, best_cut, least = 0, 0.0, np.inf
    for axis in range(3):
        count = 0
        for i in some:
            for face in (lows[i, axis], highs[i, axis]):
                if low[axis] < face < high[axis]:
                    faces[count] = face
                    count += 1
        if count > 12:
            order = order_of(faces[:count])
            low_third, middle, high_third = order[count // 3], order[count // 2], order[2 * count // 3]
            faces[0], faces[1], faces[2] = faces[low_third], faces[middle], faces[high_third]
            count = 3
        for f in range(count):
            cut = faces[f]
            below = above = 0
            for i in some:
                below += lows[i, axis] < cut
                above += highs[i, axis] > cut
            price = below + above + 0.5 * abs(below - above)
            if price < least:
                best_axis, best_cut, least = axis, cut, price
    return best_axis, best_cut


@inner
def _holds(lows: Floats, highs: Floats, i: int, low: Floats, high: Floats) -> bool:
    """Tell whether grown box i holds all of a cell."""
    hold = True
    for axis in range(3):
        hold &= lows[i, axis] <= low[axis] and highs[i, axis] >= high[axis]
    return hold


@inner
def _reaches(lows: Floats, highs: Floats, i: int, low: Floats, high: Floats) -> bool:
    """Tell whether grown box i reaches into a cell."""
    meet = True
    for axis in range(3):
        meet &= lows[i, axis] < high[axis] and highs[i, axis] > low[axis]
    return meet


@inner
def cell_of(cells: Cells, p: Floats) -> int:
    """Return a free cell that holds a point, or has it on its surface; -1 if none does."""
    waiting = np.empty(cells.depth + 2, np.int64)
    waiting[0] = 0
    depth = 1
    while depth:
        depth -= 1
        node = waiting[depth]
        axis = cells.axis[node]
        if axis == FREE:
            return node
        if axis >= 0:
            if p[axis] <= cells.cut[node]:
                waiting[depth] = cells.below[node]
                depth += 1
            if p[axis] >= cells.cut[node]:
                waiting[depth] = cells.below[node] + 1
                depth += 1
    return -1


@inner
def neighbours(cells: Cells, cell: int, found: Ints) -> int:
    """Write into `found` the free cells that share a part of a face with a cell; return how many there are."""
    waiting = np.empty(cells.depth + 2, np.int64)
    count = 0
    low, high = cells.low[cell], cells.high[cell]
    for face in range(6):
        across, up = face >> 1, face & 1
        plane = high[across] if up else low[across]
        waiting[0] = 0
        depth = 1
        while depth:
            depth -= 1
            node = waiting[depth]
            axis = cells.axis[node]
            if axis == FREE:
                if (cells.low[node, across] if up else cells.high[node, across]) == plane and count < len(found):
                    found[count] = node
                    count += 1
            elif axis == across:
                go_up = cells.cut[node] < plane or (cells.cut[node] == plane and up)
                waiting[depth] = cells.below[node] + (1 if go_up else 0)
                depth += 1
            elif axis >= 0:
                if low[axis] < cells.cut[node]:
                    waiting[depth] = cells.below[node]
                    depth += 1
                if high[axis] > cells.cut[node]:
                    waiting[depth] = cells.below[node] + 1
                    depth += 1
    return count
