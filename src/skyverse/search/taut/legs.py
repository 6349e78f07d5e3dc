"""Legs between two intervals of edges: how long they are at least, and whether obstacles block them all.

A leg leads from a point x metres from the middle of interval i, along its edge, to a point y metres from the middle of
interval j. Its length is a convex function of x and y, so that it is nowhere below any of its tangents.

Intervals lie `SIGHT_MARGIN` farther from their boxes than paths must. So that no path that makes use of this falls
short of a bound, every length counts as `NEARER_GAIN` less.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, inner_query
from skyverse.numerics.tolerances import NEARER_GAIN, SURFACE_DEPTH
from skyverse.search.taut.edge_geometry import beside_faces
from skyverse.space import box
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space
from skyverse.space.tree import FIRST, SKIP, STOP

SOME_FREE, ALL_FREE, ALL_BLOCKED = 0, 1, 2
"""What is known of the legs between two intervals; of the first, that they are not proven to be all blocked."""


class Intervals(NamedTuple):
    """Intervals of edges; the first two are the start and the goal, which are points.

    Attributes
    ----------
    middle
        (n, 3) metres.
    half
        (n,) metres: half the length.
    axis
        (n,) the axis that each is parallel to, -1 for a point.
    piece
        (n,) the piece of an edge that it is part of, -1 for none.
    blocker
        (n,) the box that last blocked all legs to another interval, which is likely to block others; -1 for none.
    """

    middle: Floats
    half: Floats
    axis: Ints
    piece: Ints
    blocker: Ints


@inner_query
def middle_leg(intervals: Intervals, i: int, j: int) -> tuple[float, float, float]:
    """Bound the leg between the middles, and return its direction's components along the edges of i and j."""
    middle, axis = intervals.middle, intervals.axis
    dx, dy, dz = middle[j, 0] - middle[i, 0], middle[j, 1] - middle[i, 1], middle[j, 2] - middle[i, 2]
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    along_i = along_j = 0.0
    if length > 0.0:
        if axis[i] >= 0:
            along_i = (middle[j, axis[i]] - middle[i, axis[i]]) / length
        if axis[j] >= 0:
            along_j = (middle[j, axis[j]] - middle[i, axis[j]]) / length
    return length - NEARER_GAIN, along_i, along_j


@inner_query
def least_distance(intervals: Intervals, i: int, j: int) -> float:
    """Bound the length of the shortest leg between two intervals, metres."""
    total = 0.0
    for axis in range(3):
        gap = abs(intervals.middle[i, axis] - intervals.middle[j, axis])
        if intervals.axis[i] == axis:
            gap -= intervals.half[i]
        if intervals.axis[j] == axis:
            gap -= intervals.half[j]
        total += max(gap, 0.0) ** 2
    return max(np.sqrt(total) - NEARER_GAIN, 0.0)  # a leg of negative length would be taken to and fro for ever


@inner_query
def quick_leg_bound(intervals: Intervals, i: int, j: int, slope_i: float, slope_j: float) -> float:
    """Bound slope_i x + length + slope_j y over all legs from below: by the tangent at the middles."""
    length, along_i, along_j = middle_leg(intervals, i, j)
    return length - intervals.half[i] * abs(slope_i - along_i) - intervals.half[j] * abs(slope_j + along_j)


@inner_query
def leg_bound(intervals: Intervals, i: int, j: int, slope_i: float, slope_j: float) -> float:
    """Bound slope_i x + length + slope_j y over all legs from below.

    The bound is the greatest of three: the tangent at the middles, the tangent near where the sum is least, and the
    least length with the least of the other two terms.
    """
    middle, half, axis = intervals.middle, intervals.half, intervals.axis
    least = least_distance(intervals, i, j) - half[i] * abs(slope_i) - half[j] * abs(slope_j)
    least = max(least, quick_leg_bound(intervals, i, j, slope_i, slope_j))
    y = _best_place(intervals, j, i, 0.0, slope_j)
    x = _best_place(intervals, i, j, y, slope_i)
    length, along_i, along_j = 0.0, 0.0, 0.0
    for k in range(3):
        d = middle[j, k] - middle[i, k] + (y if axis[j] == k else 0.0) - (x if axis[i] == k else 0.0)
        length += d * d
        along_i += d if axis[i] == k else 0.0
        along_j += d if axis[j] == k else 0.0
    length = np.sqrt(length)
    if length == 0.0:
        return least
    rise_i, rise_j = slope_i - along_i / length, slope_j + along_j / length
    tangent = length - NEARER_GAIN + slope_i * x + slope_j * y
    tangent -= rise_i * x + abs(rise_i) * half[i] + rise_j * y + abs(rise_j) * half[j]
    return max(least, tangent)


@inner_query
def _best_place(intervals: Intervals, j: int, i: int, x: float, slope: float) -> float:
    """Return where on interval j, metres from its middle, length + slope y is least for legs from place x of i.

    With the distance r from that place to the line of j's edge, and d to go along it, y is d - slope r / sqrt(1 -
    slope^2), or the nearer end of the interval.
    """
    middle, half, axis = intervals.middle, intervals.half, intervals.axis
    if axis[j] < 0:
        return 0.0
    away, along = 0.0, 0.0
    for k in range(3):
        d = middle[i, k] - middle[j, k] + (x if axis[i] == k else 0.0)
        if axis[j] == k:
            along = d
        else:
            away += d * d
    if abs(slope) >= 1.0:
        return -half[j] if slope > 0.0 else half[j]
    return min(max(along - slope * np.sqrt(away / (1.0 - slope * slope)), -half[j]), half[j])


@inner_query
def faces_beside(intervals: Intervals, edges: Edges, i: int, j: int) -> int:
    """Return beside which faces of interval i's edge some point of interval j lies, 3 for a point i."""
    if intervals.axis[i] < 0:
        return 3
    e = intervals.piece[i]
    b, c = (intervals.axis[i] + 1) % 3, (intervals.axis[i] + 2) % 3
    half_b = intervals.half[j] if intervals.axis[j] == b else 0.0
    half_c = intervals.half[j] if intervals.axis[j] == c else 0.0
    rb = edges.side[e, 0] * (intervals.middle[j, b] - intervals.middle[i, b])
    rc = edges.side[e, 1] * (intervals.middle[j, c] - intervals.middle[i, c])
    return beside_faces(rb - half_b, rb + half_b, rc - half_c, rc + half_c)


@inner
def legs_free(space: Space, intervals: Intervals, i: int, j: int) -> int:
    """Tell what is known of all legs between two intervals: `SOME_FREE`, `ALL_FREE` or `ALL_BLOCKED` by one box."""
    r = box.ray(intervals.middle[i], intervals.middle[j])
    for k in (intervals.blocker[i], intervals.blocker[j]):
        if k >= 0 and _blocks_all(space, k, intervals, i, j, r):
            return ALL_BLOCKED
    reach = space.clearance + max(intervals.half[i], intervals.half[j])
    known = ALL_FREE
    node = 0
    while node < len(space.tree.links):
        if not box.meets(space.tree.bounds, node, reach, r):
            node = space.tree.links[node, SKIP]
            continue
        for k in range(space.tree.links[node, FIRST], space.tree.links[node, STOP]):
            if box.meets(space.boxes, k, reach, r):
                known = SOME_FREE
                if _blocks_all(space, k, intervals, i, j, r):
                    intervals.blocker[i] = intervals.blocker[j] = k
                    return ALL_BLOCKED
        node += 1
    return known


@inner_query
def _blocks_all(space: Space, k: int, intervals: Intervals, i: int, j: int, r: box.Ray) -> bool:
    """Tell whether it is proven that box k blocks all legs between two intervals; the ray joins their middles."""
    return box.meets(space.boxes, k, space.clearance, r) and (
        _at_one_share(space, k, intervals, i, j) or _in_one_plane(space, k, intervals, i, j)
    )


@inner_query
def _end(intervals: Intervals, i: int, side: int, axis: int) -> float:
    """Return a coordinate of the lower end (side 0) or the upper end (side 1) of an interval, metres."""
    along = intervals.half[i] if intervals.axis[i] == axis else 0.0
    return intervals.middle[i, axis] + (along if side else -along)


@inner_query
def _at_one_share(space: Space, k: int, intervals: Intervals, i: int, j: int) -> bool:
    """Tell whether the four legs between the ends of two intervals are in box k at one and the same share of the leg.

    Then all legs are: at that share, the points of all legs are mixtures of those four.
    """
    margin = space.clearance - SURFACE_DEPTH
    enter, leave = 0.0, 1.0
    for corner in range(4):
        for axis in range(3):
            p = _end(intervals, i, corner & 1, axis)
            d = _end(intervals, j, corner >> 1, axis) - p
            low, high = space.boxes[k, axis] - margin, space.boxes[k, axis + 3] + margin
            if d == 0.0:
                if p <= low or p >= high:
                    return False
            else:
                enter = max(enter, min((low - p) / d, (high - p) / d))
                leave = min(leave, max((low - p) / d, (high - p) / d))
        if enter >= leave:
            return False
    return True


@inner_query
def _in_one_plane(space: Space, k: int, intervals: Intervals, i: int, j: int) -> bool:
    """Tell whether the four legs between the ends of two intervals cross a middle plane of box k inside the box.

    Then all legs do: the plane cuts the hull of both intervals in the hull of those four points.
    """
    margin = space.clearance - SURFACE_DEPTH
    for axis in range(3):
        plane = 0.5 * (space.boxes[k, axis] + space.boxes[k, axis + 3])
        apart = 0
        for side in range(2):
            apart += 1 if _end(intervals, i, side, axis) < plane else -1
            apart -= 1 if _end(intervals, j, side, axis) < plane else -1
        inside = abs(apart) == 4
        for corner in range(4):
            p, q = _end(intervals, i, corner & 1, axis), _end(intervals, j, corner >> 1, axis)
            for other in range(3):
                if inside and other != axis:
                    a, b = _end(intervals, i, corner & 1, other), _end(intervals, j, corner >> 1, other)
                    at = a + (b - a) * (plane - p) / (q - p)
                    inside = space.boxes[k, other] - margin < at < space.boxes[k, other + 3] + margin
        if inside:
            return True
    return False
