"""From start to target among boxes: a first path, tightened, and the length that no path beats."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put, put_all
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.norm import distance, length_of
from skyverse.numerics.tolerances import BEND_GAIN, OTHER_WAY_WORTH, SEAM_MARGIN
from skyverse.search.taut.cell_astar import cell_astar
from skyverse.search.taut.lower_bound import lower_bound
from skyverse.search.taut.other_ways import shortest_way
from skyverse.search.taut.plane_bound import plane_bound
from skyverse.search.taut.shorten_window import local_space
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
    least
        Metres that no path beats.
    shut_in
        Which end is shut in: 0 for none, 1 for the start, 2 for the goal.
    spent
        (2,) the searches made, and the states that they expanded.
    """

    path: Floats
    least: float
    shut_in: int
    spent: Ints


@kernel
def taut_path(space: Space, cells: Cells, edges: Edges, start: Floats, goal: Floats, most: int) -> TautPath:
    """Return a path from start to goal that no window of it can shorten, and a length that no path beats.

    About `most` pairs of intervals of edges are looked at for the latter; with 0 it is that of the straight line. Where
    the two lengths differ, other ways round are sought.
    """
    spent = np.zeros(2, np.int64)
    nothing = np.empty((0, 3))
    straight = distance(start, goal)
    sight = with_margin(space, SEAM_MARGIN)
    first, out = _step_out(space, start)
    if not out:
        return TautPath(nothing, straight, 1, spent)
    last, out = _step_out(space, goal)
    if not out:
        return TautPath(nothing, straight, 2, spent)
    path, expanded = cell_astar(cells, first, last)
    spent[0] += 1
    spent[1] += expanded
    if len(path) == 0:
        return TautPath(path, straight, 0, spent)
    path = tighten(sight, edges, path, spent)
    whole = _between_ends(space, sight, start, path, goal)
    aside = distance(start, first) + distance(last, goal)
    least = max(straight, _least_length(sight, edges, path, most) - aside)
    if len(whole) > 2 and least * (1.0 + OTHER_WAY_WORTH) < length_of(whole):
        other = shortest_way(sight, edges, path, least, spent)
        if length_of(other) < length_of(path):
            whole = _between_ends(space, sight, start, other, goal)
    return TautPath(whole, min(least, length_of(whole)), 0, spent)


@inner
def _between_ends(space: Space, sight: Space, start: Floats, path: Floats, goal: Floats) -> Floats:
    """Return a path from its true start to its true goal, without the points beside these where they are not needed."""
    whole = np.empty((len(path) + 2, 3))
    put(whole, 0, start)
    put_all(whole, 1, path)
    put(whole, len(path) + 1, goal)
    if segment_free(sight, path[0], path[-1]) and segment_free(space, start, goal):
        return whole[:: len(whole) - 1].copy()
    kept = np.ones(len(whole), np.bool_)
    if distance(start, whole[1]) == 0.0 or segment_free(space, whole[0], whole[2]):
        kept[1] = False
    if distance(whole[-2], goal) == 0.0 or (kept[len(whole) - 3] and segment_free(space, whole[-3], whole[-1])):
        kept[-2] = False
    return whole[kept]


@inner
def _least_length(sight: Space, edges: Edges, path: Floats, most: int) -> float:
    """Return a length that no path between the ends of a given one beats, for about so many pairs looked at."""
    length, straight = length_of(path), distance(path[0], path[-1])
    if most == 0 or len(path) < 3:
        return straight
    plane = plane_bound(sight, path[0], path[-1], length)
    if plane * (1.0 + OTHER_WAY_WORTH) >= length:
        return min(plane, length)
    near, _ = local_space(sight, path)
    least = lower_bound(near, edges, path[0], path[-1], length, plane, most)
    # edges lie two seam margins off the obstacles: on that scale a path could gain a little at each of its bends
    return min(max(straight, plane, least - BEND_GAIN * len(path)), length)


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
