"""A length that no path beats, and a path, from the obstacles that are as high, as wide or as deep as the space.

A path's projection along an axis avoids the projections of all boxes that reach through the space along that axis. So
it is at least as long as the shortest path among these rectangles, which is found exactly: it bends at their corners
alone. Downtown, where most buildings reach the ceiling, little is lost, and where no other box is in its way, the
shortest path among the rectangles, drawn evenly along the axis, is that of the space.
"""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.arrays import put
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance
from skyverse.numerics.tolerances import BOUND_ROUNDING, LENGTH_ROUNDING, NEARER_GAIN, SIGHT_MARGIN
from skyverse.search.taut.edge_geometry import move_off, spheroid_bounds
from skyverse.search.taut.edge_search import BendPoints, search_edges
from skyverse.space import tree
from skyverse.space.edges import make_edges
from skyverse.space.obstacles import Space, boxes_near
from skyverse.space.world import path_free

MAX_BOXES = 2000
"""Boxes that reach through the space at most; where there are more, no bound is sought."""
BELOW_TOP = 3.0 * SIGHT_MARGIN
"""Metres below the space's upper side at which a path leads along it."""
MAX_EXPANDED = 4000
"""States that a search may expand."""


@inner
def plane_bound(space: Space, start: Floats, goal: Floats, length: float) -> tuple[float, Floats]:
    """Return a length that no path from start to goal beats, given that of a path that is known, metres, and a path.

    The space counts `SIGHT_MARGIN` more than the clearance. The path, (k, 3) metres, is empty where there is none that
    is free.
    """
    bound, way = distance(start, goal), np.empty((0, 3))
    low, high = spheroid_bounds(start, goal, length)
    near = boxes_near(space, 0.0, low, high)
    for axis in range(3):
        bottom, top = max(low[axis], space.low[axis]), min(high[axis], space.high[axis])
        boxes, count = np.empty((len(near), 6)), 0
        for i in near:
            if space.boxes[i, axis] - space.clearance <= bottom and space.boxes[i, axis + 3] + space.clearance >= top:
                put(boxes, count, space.boxes[i])
                boxes[count, axis], boxes[count, axis + 3] = space.low[axis], space.high[axis]
                count += 1
        if 0 < count <= MAX_BOXES:
            least, corners = _in_plane(space, boxes[:count].copy(), axis, start, goal, length)
            if least > bound:
                bound, way = least, _along_axis(space, corners, axis)
    return bound, way


@inner
def _in_plane(
    space: Space, boxes: Floats, axis: int, start: Floats, goal: Floats, length: float
) -> tuple[float, Floats]:
    """Return a bound from boxes that reach through the space along an axis, 0 if none is found, and start, bends, goal.

    The bends' coordinates on the axis are of no meaning.
    """
    index, order = tree.build(boxes)
    sorted_boxes = np.empty_like(boxes)
    for k in range(len(boxes)):
        put(sorted_boxes, k, boxes[order[k]])
    through = Space(
        space.low, space.high, sorted_boxes, space.clearance, index, space.solids, space.ground, space.ceiling
    )
    corners = make_edges(through, space.clearance + SIGHT_MARGIN)
    at, edge = np.empty((len(corners.ends) + 2, 3)), np.full(len(corners.ends) + 2, -1)
    put(at, 0, start)
    put(at, 1, goal)
    n = 2
    for e in range(len(corners.ends)):
        if corners.axis[e] == axis:
            put(at, n, corners.ends[e, :3])
            move_off(corners, e, at[n], -SIGHT_MARGIN)
            edge[n] = e
            n += 1
    for i in range(n):
        at[i, axis] = 0.5 * (space.low[axis] + space.high[axis])
    along = abs(goal[axis] - start[axis])
    most = np.sqrt(max((length * (1.0 + LENGTH_ROUNDING)) ** 2 - along**2, 0.0))
    found = search_edges(through, corners, BendPoints(at[:n], edge[:n]), most, MAX_EXPANDED)
    if len(found.points) == 0:
        return 0.0, at[:0]
    nearer = (n - 1) * NEARER_GAIN  # a path over all corners, nearer to the boxes
    for i in range(2, n):
        move_off(corners, edge[i], at[i], SIGHT_MARGIN)
    put(at, 0, start)
    put(at, 1, goal)
    return np.sqrt(max(found.length - nearer - BOUND_ROUNDING, 0.0) ** 2 + along**2), at[found.points]


@inner
def _along_axis(space: Space, corners: Floats, axis: int) -> Floats:
    """Return a free path over corners (k, 3) in the plane: evenly along the axis, or else on its upper side.

    It is empty where both are blocked.
    """
    last = len(corners) - 1
    across = np.zeros(last + 1)
    for i in range(1, last + 1):
        square = 0.0
        for k in range(3):
            square += (corners[i, k] - corners[i - 1, k]) ** 2 if k != axis else 0.0
        across[i] = across[i - 1] + np.sqrt(square)
    for evenly in (True, False):
        for i in range(1, last):
            share = across[i] / across[last]
            even = corners[0, axis] + share * (corners[last, axis] - corners[0, axis])
            corners[i, axis] = even if evenly else space.high[axis] - BELOW_TOP
        if path_free(space, corners):
            return corners
    return corners[:0]
