"""From start to target among boxes: a first path, tightened, and the length that no path beats."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put, put_all
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.norm import distance, length_of
from skyverse.numerics.tolerances import BEND_GAIN, LENGTH_ROUNDING, OPTIMALITY_GAP, SEAM_MARGIN
from skyverse.search.taut.cell_astar import cell_astar
from skyverse.search.taut.lower_bound import lower_bound
from skyverse.search.taut.tighten import tighten
from skyverse.space import tree
from skyverse.space.cells import Cells
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space, in_bounds, with_margin
from skyverse.space.world import segment_free

MAX_STEPS_OUT = 6
"""How often a point is moved past the face of a box before it counts as shut in."""


class TautPath(NamedTuple):
    """What a search for a shortest path among boxes found.

    Attributes
    ----------
    path
        (k, 3) metres; empty if there is none.
    shut_in
        Which end is shut in: 0 for none, 1 for the start, 2 for the goal.
    spent
        (2,) the searches made, and the states that they expanded.
    """

    path: Floats
    shut_in: int
    spent: Ints


@kernel
def taut_path(space: Space, cells: Cells, edges: Edges, start: Floats, goal: Floats) -> TautPath:
    """Return a path from start to goal that no window of it can shorten."""
    spent = np.zeros(2, np.int64)
    nothing = np.empty((0, 3))
    sight = with_margin(space, SEAM_MARGIN)
    first, out = _step_out(space, start)
    if not out:
        return TautPath(nothing, 1, spent)
    last, out = _step_out(space, goal)
    if not out:
        return TautPath(nothing, 2, spent)
    path, expanded = cell_astar(cells, first, last)
    spent[0] += 1
    spent[1] += expanded
    if len(path) == 0:
        return TautPath(path, 0, spent)
    path = tighten(sight, edges, path, spent)
    whole = np.empty((len(path) + 2, 3))
    put(whole, 0, start)
    put_all(whole, 1, path)
    put(whole, len(path) + 1, goal)
    if segment_free(sight, first, last) and segment_free(space, start, goal):
        return TautPath(whole[:: len(whole) - 1].copy(), 0, spent)
    kept = np.ones(len(whole), np.bool_)
    if distance(start, whole[1]) == 0.0 or segment_free(space, whole[0], whole[2]):
        kept[1] = False
    if distance(whole[-2], goal) == 0.0 or (kept[len(whole) - 3] and segment_free(space, whole[-3], whole[-1])):
        kept[-2] = False
    return TautPath(whole[kept], 0, spent)


@kernel
def least_length(space: Space, edges: Edges, start: Floats, goal: Floats, path: Floats, most: int) -> float:
    """Return a length that no path from start to goal beats, given one path, for at most so many states expanded."""
    length = length_of(path)
    straight = distance(start, goal)
    if most == 0 or len(path) < 3:
        return straight
    sight = with_margin(space, SEAM_MARGIN)
    least, _ = lower_bound(sight, edges, start, goal, length * (1.0 + LENGTH_ROUNDING), OPTIMALITY_GAP, most)
    # edges lie two seam margins off the obstacles: on that scale a path could gain a little at each of its bends
    return min(max(straight, least - BEND_GAIN * len(path)), length)


@inner
def _step_out(space: Space, p: Floats) -> tuple[Floats, bool]:
    """Step from a free point to one three seam margins off all boxes, and tell whether that succeeded.

    Each step goes past the nearest face of a box that is too near, and is at most eight seam margins long.
    """
    growth = space.clearance + 3.0 * SEAM_MARGIN
    q = p.copy()
    for _ in range(MAX_STEPS_OUT):
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
