"""A length that no path beats, from the obstacles that are as high, as wide or as deep as the space.

A path's projection along an axis avoids the projections of all boxes that reach through the space along that axis. So
it is at least as long as the shortest path among these rectangles, which is found exactly: it bends at their corners
alone. Downtown, where most buildings reach the ceiling, little is lost.
"""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.arrays import put
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance
from skyverse.numerics.tolerances import BEND_GAIN, LENGTH_ROUNDING, SEAM_MARGIN
from skyverse.search.taut.edge_geometry import spheroid_bounds
from skyverse.search.taut.edge_search import BendPoints, search_edges
from skyverse.space import tree
from skyverse.space.edges import make_edges
from skyverse.space.obstacles import Space

MAX_BOXES = 2000
"""Boxes that reach through the space at most; where there are more, no bound is sought."""
MAX_EXPANDED = 4000
"""States that a search may expand."""


@inner
def plane_bound(space: Space, start: Floats, goal: Floats, length: float) -> float:
    """Return a length that no path from start to goal beats, given that of a path that is known, metres.

    The space counts `SEAM_MARGIN` more than the clearance.
    """
    bound = distance(start, goal)
    low, high = spheroid_bounds(start, goal, length)
    near = tree.touching(space.tree, space.boxes, space.clearance, low, high)
    for axis in range(3):
        bottom, top = max(low[axis], space.low[axis]), min(high[axis], space.high[axis])
        boxes, count = np.empty((len(near), 6)), 0
        for i in near:
            if space.boxes[i, axis] - space.clearance <= bottom and space.boxes[i, axis + 3] + space.clearance >= top:
                put(boxes, count, space.boxes[i])
                boxes[count, axis], boxes[count, axis + 3] = space.low[axis], space.high[axis]
                count += 1
        if 0 < count <= MAX_BOXES:
            bound = max(bound, _in_plane(space, boxes[:count].copy(), axis, start, goal, length))
    return bound


@inner
def _in_plane(space: Space, boxes: Floats, axis: int, start: Floats, goal: Floats, length: float) -> float:
    """Return a bound from boxes that reach through the space along an axis; 0 if none is found."""
    index, order = tree.build(boxes)
    sorted_boxes = np.empty_like(boxes)
    for k in range(len(boxes)):
        put(sorted_boxes, k, boxes[order[k]])
    through = Space(
        space.low, space.high, sorted_boxes, space.clearance, index, space.solids, space.ground, space.ceiling
    )
    corners = make_edges(through, space.clearance + SEAM_MARGIN)
    at, edge = np.empty((len(corners.ends) + 2, 3)), np.full(len(corners.ends) + 2, -1)
    put(at, 0, start)
    put(at, 1, goal)
    n = 2
    for e in range(len(corners.ends)):
        if corners.axis[e] == axis:
            put(at, n, corners.ends[e, :3])
            edge[n] = e
            n += 1
    for i in range(n):
        at[i, axis] = 0.5 * (space.low[axis] + space.high[axis])
    along = abs(goal[axis] - start[axis])
    most = np.sqrt(max((length * (1.0 + LENGTH_ROUNDING)) ** 2 - along**2, 0.0))
    found = search_edges(through, corners, BendPoints(at[:n], edge[:n]), most, MAX_EXPANDED)
    if len(found.points) == 0:
        return 0.0
    # corners lie two seam margins off the boxes: on that scale a path could gain a little at each of its bends
    return np.sqrt(max(found.length - BEND_GAIN * len(found.points), 0.0) ** 2 + along**2)
