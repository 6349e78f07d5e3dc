"""A scenario's space compiled to arrays: which points and segments are free, how far obstacles are."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skyverse.kernel import kernel
from skyverse.result import Floats
from skyverse.scenario import Scenario
from skyverse.shapes import Box
from skyverse.space import box, tree
from skyverse.space.tree import Tree

ROOM = 1e-7
"""A hair of room, metres: touching obstacles leave none between them, so that no line of sight slips through a seam.

Lines of sight keep one beside the clearance, edges at which paths bend lie two off, and passages are three wide on
either side: so whatever passage there is has edges to bend at, and each edge lines of sight to it.
"""


class Space(NamedTuple):
    """What the kernels see: bounds (3,) each, the obstacles in the index's order, and the growth in metres."""

    low: Floats
    high: Floats
    boxes: Floats
    clearance: float
    tree: Tree


@kernel
def in_bounds(space: Space, p: Floats) -> bool:
    """Tell whether a point lies in the closed bounds."""
    inside = True
    for axis in range(3):
        inside &= space.low[axis] - box.TOLERANCE <= p[axis] <= space.high[axis] + box.TOLERANCE  # False for NaN
    return inside


@kernel
def point_free(space: Space, p: Floats) -> bool:
    """Tell whether a point is in bounds and outside every grown obstacle."""
    return in_bounds(space, p) and tree.containing(space.tree, space.boxes, space.clearance, p[0], p[1], p[2]) < 0


@kernel
def segment_free(space: Space, a: Floats, b: Floats) -> bool:
    """Tell whether a whole segment is in bounds and outside every grown obstacle."""
    return (
        in_bounds(space, a) and in_bounds(space, b) and tree.crossed(space.tree, space.boxes, space.clearance, a, b) < 0
    )


@kernel
def _points_free(space: Space, points: Floats) -> NDArray[np.bool_]:
    free = np.empty(len(points), np.bool_)
    for i in range(len(points)):
        free[i] = point_free(space, points[i])
    return free


@kernel
def _segments_free(space: Space, starts: Floats, ends: Floats) -> NDArray[np.bool_]:
    free = np.empty(len(starts), np.bool_)
    for i in range(len(starts)):
        free[i] = segment_free(space, starts[i], ends[i])
    return free


@kernel
def _distances(space: Space, points: Floats) -> Floats:
    distances = np.empty(len(points))
    for i in range(len(points)):
        distances[i] = tree.distance(space.tree, space.boxes, points[i, 0], points[i, 1], points[i, 2])
    return distances


class World:
    """Safe space: the scenario's bounds without its obstacles, each grown by the clearance on every side.

    A point on the surface of a grown obstacle, or on the bounds, is safe.

    Parameters
    ----------
    scenario
        Whose space to compile.
    """

    def __init__(self, scenario: Scenario) -> None:
        boxes = np.array(
            [[*b.min, *b.max] for b in scenario.obstacles if isinstance(b, Box)], dtype=np.float64
        ).reshape(-1, 6)
        index, self._order = tree.build(boxes)
        self.space = Space(
            low=np.array(scenario.bounds.min),
            high=np.array(scenario.bounds.max),
            boxes=boxes[self._order],
            clearance=scenario.clearance,
            tree=index,
        )

    def free(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Tell for each of (m, 3) points in metres whether it is safe; (m,) booleans."""
        return _points_free(self.space, _rows(points))

    def segments_free(self, starts: ArrayLike, ends: ArrayLike) -> NDArray[np.bool_]:
        """Tell for each of m segments between (m, 3) and (m, 3) whether all of it is safe; (m,) booleans."""
        a, b = _rows(starts), _rows(ends)
        if len(a) != len(b):
            raise ValueError(f"as many ends as starts are needed, got {len(b)} ends and {len(a)} starts")
        return _segments_free(self.space, a, b)

    def distance(self, points: ArrayLike) -> Floats:
        """Return for each of (m, 3) points the Euclidean metres to the nearest obstacle as given; negative inside."""
        return _distances(self.space, _rows(points))

    def why_unsafe(self, point: ArrayLike) -> str | None:
        """Say in words why a point is unsafe, or return ``None``."""
        p = _rows(point)[0]
        if not in_bounds(self.space, p):
            low, high = (", ".join(f"{v:g}" for v in side) for side in (self.space.low, self.space.high))
            return f"lies outside the bounds ({low}) to ({high})"
        found = tree.containing(self.space.tree, self.space.boxes, self.space.clearance, p[0], p[1], p[2])
        if found >= 0:
            return f"lies inside obstacles[{self._order[found]}] grown by the clearance of {self.space.clearance:g} m"
        return None


def _rows(points: ArrayLike) -> Floats:
    rows = np.atleast_2d(np.ascontiguousarray(points, dtype=np.float64))
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise ValueError(f"points are rows of x, y, z, but the array has shape {np.shape(points)}")
    return rows
