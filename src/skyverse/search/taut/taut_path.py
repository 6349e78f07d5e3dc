"""From start to target among boxes: a first path, tightened, and the length that no path beats."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put, put_all
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.norm import distance, length_of
from skyverse.numerics.tolerances import OTHER_WAY_WORTH, SIGHT_MARGIN
from skyverse.search.taut.cell_astar import cell_astar
from skyverse.search.taut.plane_bound import plane_bound
from skyverse.search.taut.shortest_way import shortest_way
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

    About `most` pairs of intervals of edges are looked at, for other ways round and for that length; with 0, no other
    ways are sought, and it is that of the straight line.
    """
    spent = np.zeros(2, np.int64)
    nothing = np.empty((0, 3))
    straight = distance(start, goal)
    sight = with_margin(space, SIGHT_MARGIN)
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
    least = distance(first, last)
    if most > 0 and len(path) > 2:
        path, least = _shortest(sight, edges, path, most, spent)
    whole = _between_ends(space, sight, start, path, goal)
    aside = distance(start, first) + distance(last, goal)
    return TautPath(whole, min(max(straight, least - aside), length_of(whole)), 0, spent)


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
def _shortest(sight: Space, edges: Edges, path: Floats, most: int, spent: Ints) -> tuple[Floats, float]:
    """Return a path as short as a given one, perhaps another way round, and a length that none beats."""
    plane, way = plane_bound(sight, path[0], path[-1], length_of(path))
    if len(way):
        way = tighten(sight, edges, way, spent)
        if length_of(way) < length_of(path):
            path = way
    if plane * (1.0 + OTHER_WAY_WORTH) >= length_of(path):
        return path, plane
    return shortest_way(sight, edges, path, plane, most, spent)


@inner
def _step_out(space: Space, p: Floats) -> tuple[Floats, bool]:
    """Step from a free point to one three margins off all boxes, and tell whether that succeeded.

    Each step goes past the nearest face of a box that is too near, and is at most eight margins long.
    """
    growth = space.clearance + 3.0 * SIGHT_MARGIN
    q = p.copy()
    for _ in range(MAX_STEPS_OUT):
        i = tree.containing(space.tree, space.boxes, growth, q[0], q[1], q[2])
        if i < 0:
            return q, in_bounds(space, q) and segment_free(space, p, q)
        least, at, side = np.inf, 0.0, -1
        for face in range(6):
            axis = face % 3
            to = space.boxes[i, face] + (growth + SIGHT_MARGIN) * (1.0 if face > 2 else -1.0)
            if abs(to - q[axis]) < least and space.low[axis] <= to <= space.high[axis]:
                least, at, side = abs(to - q[axis]), to, axis
        if side < 0 or least > 8.0 * SIGHT_MARGIN:
            return q, False
        q[side] = at
    return q, False
