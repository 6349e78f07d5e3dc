"""From start to target among boxes: a first way, tightened."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.arrays import put, put_all
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import BEND_GAIN, LENGTH_ROUNDING, OPTIMALITY_GAP, SEAM_MARGIN
from skyverse.search.taut.bends import distance
from skyverse.search.taut.bound import lower_bound
from skyverse.search.taut.passage import passage
from skyverse.search.taut.tighten import length_of, tighten, visible
from skyverse.space import tree
from skyverse.space.cells import Cells
from skyverse.space.edges import Edges
from skyverse.space.world import Space, in_bounds, segment_free


class Taut(NamedTuple):
    """A way (k, 3), empty if there is none; which end is shut in, 0 for none, 1 start, 2 goal; what it took.

    `spent` are the searches made and the states that they expanded.
    """

    way: Floats
    shut: int
    spent: np.ndarray


@kernel
def taut_way(space: Space, cells: Cells, edges: Edges, start: Floats, goal: Floats) -> Taut:
    """Return a way from start to goal that no window of it can shorten."""
    spent = np.zeros(2, np.int64)
    nothing = np.empty((0, 3))
    first, out = step_out(space, start)
    if not out:
        return Taut(nothing, 1, spent)
    last, out = step_out(space, goal)
    if not out:
        return Taut(nothing, 2, spent)
    way, expanded = passage(cells, first, last)
    spent[0] += 1
    spent[1] += expanded
    if len(way) == 0:
        return Taut(way, 0, spent)
    way = tighten(space, space.clearance + SEAM_MARGIN, edges, way, spent)
    whole = np.empty((len(way) + 2, 3))
    put(whole, 0, start)
    put_all(whole, 1, way)
    put(whole, len(way) + 1, goal)
    if visible(space, space.clearance + SEAM_MARGIN, first, last) and segment_free(space, start, goal):
        return Taut(whole[:: len(whole) - 1].copy(), 0, spent)
    kept = np.ones(len(whole), np.bool_)
    if distance(start, whole[1]) == 0.0 or segment_free(space, whole[0], whole[2]):
        kept[1] = False
    if distance(whole[-2], goal) == 0.0 or (kept[len(whole) - 3] and segment_free(space, whole[-3], whole[-1])):
        kept[-2] = False
    return Taut(whole[kept], 0, spent)


@kernel
def least_length(space: Space, edges: Edges, start: Floats, goal: Floats, way: Floats, most: int) -> float:
    """Return what no way from start to goal is shorter than, given one, for at most so many states expanded."""
    length = length_of(way)
    straight = distance(start, goal)
    if most == 0 or len(way) < 3:
        return straight
    known = length * (1.0 + LENGTH_ROUNDING)
    least, _ = lower_bound(space, space.clearance + SEAM_MARGIN, edges, start, goal, known, OPTIMALITY_GAP, most)
    # edges lie two hairs off the obstacles: on that scale a way could gain a little at each of its bends
    return min(max(straight, least - BEND_GAIN * len(way)), length)


@inner
def step_out(space: Space, p: Floats) -> tuple[Floats, bool]:
    """Step from a free point to one with room, a few times `SEAM_MARGIN` away at most; tell whether that succeeded."""
    growth = space.clearance + 3.0 * SEAM_MARGIN
    q = p.copy()
    for _ in range(6):
        i = tree.containing(space.tree, space.boxes, growth, q[0], q[1], q[2])
        if i < 0:
            return q, in_bounds(space, q) and segment_free(space, p, q)
        least, at, side = np.inf, 0.0, -1
        for face in range(6):
            axis = face % 3
            to = space.boxes[i, face] + (growth + SEAM_MARGIN) * (1.0 if face > 2 else -1.0)
            if abs(to - q[axis]) < least and space.low[axis] <= to <= space.high[axis]:
                least, at, side = abs(to - q[axis]), to, axis
        if side < 0 or least > 8.0 * SEAM_MARGIN:
            return q, False
        q[side] = at
    return q, False
