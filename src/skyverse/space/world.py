"""A scenario's space compiled to arrays: which points and segments are free, and how far away obstacles are."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box, Terrain, Voxels
from skyverse.numerics.kernel import by_reference, inner_query, kernel, query, writable
from skyverse.numerics.tolerances import SURFACE_DEPTH
from skyverse.space import ground, solids, tree
from skyverse.space.closed_above import ABOVE_BOUNDS, numbered_shapes
from skyverse.space.ground import Ground
from skyverse.space.solids import Solids
from skyverse.space.tree import Tree
from skyverse.space.voxels import merged, seamless


@by_reference
class Space(NamedTuple):
    """What kernels know of a world; what a world does not have is an empty array, so that there is one type for all.

    Attributes
    ----------
    low, high
        (3,) metres: the bounds.
    boxes
        (n, 6) metres, in the order of `tree`: obstacles that are boxes, and voxels merged into boxes.
    clearance
        Metres to keep from every obstacle.
    tree
        The index over `boxes`.
    solids
        Cylinders, spheres and prisms.
    ground
        The terrain.
    ceiling
        What is too high above the terrain, upside down: a ground whose heights are the negative z of the ceiling. It
        is met by points and segments whose z is negated.
    """

    low: Floats
    high: Floats
    boxes: Floats
    clearance: float
    tree: Tree
    solids: Solids
    ground: Ground
    ceiling: Ground


@query
def in_bounds(space: Space, p: Floats) -> bool:
    """Tell whether a point lies in the closed bounds."""
    inside = True
    for axis in range(3):
        inside &= space.low[axis] - SURFACE_DEPTH <= p[axis] <= space.high[axis] + SURFACE_DEPTH  # False for NaN
    return inside


@inner_query
def inside_obstacle(space: Space, growth: float, p: Floats) -> bool:
    """Tell whether the interior of some obstacle, grown by `growth`, holds a point.

    The ground is raised by `growth` and by what its own clearance exceeds the scenario's, and the ceiling is lowered by
    what `growth` exceeds the clearance.
    """
    return (
        tree.containing(space.tree, space.boxes, growth, p[0], p[1], p[2]) >= 0
        or solids.containing(space.solids, growth, p[0], p[1], p[2]) >= 0
        or p[2] < ground.height(space.ground, p[0], p[1]) + growth + space.ground.extra - SURFACE_DEPTH
        or above_ceiling(space, growth - SURFACE_DEPTH, p)
    )


@inner_query
def above_ceiling(space: Space, growth: float, p: Floats) -> bool:
    """Tell whether a point is above the ceiling, lowered by what `growth` exceeds the clearance."""
    return -p[2] < ground.height(space.ceiling, p[0], p[1]) + growth + space.ceiling.extra


@query
def terrain_crossed(space: Space, growth: float, dev: float, a: Floats, b: Floats) -> bool:
    """Tell whether what is within `dev` of a segment may reach below the raised ground or above the lowered ceiling.

    The answer is exact for a `dev` of 0; see `skyverse.space.ground.crossed`.
    """
    return ground.crossed(space.ground, growth + space.ground.extra, dev, a, b, 1.0) or ground.crossed(
        space.ceiling, growth + space.ceiling.extra, dev, a, b, -1.0
    )


@query
def crosses(space: Space, growth: float, a: Floats, b: Floats) -> bool:
    """Tell exactly whether a segment meets the interior of some obstacle, grown by `growth`."""
    return (
        tree.crossed(space.tree, space.boxes, growth, a, b) >= 0
        or solids.crossed(space.solids, growth, a, b) >= 0
        or terrain_crossed(space, growth, 0.0, a, b)
    )


@query
def terrain_reaches(space: Space, growth: float, low: Floats, high: Floats) -> bool:
    """Tell whether the raised ground or the lowered ceiling reaches into the open box between two corners."""
    floor = low[2] - growth - space.ground.extra + SURFACE_DEPTH
    if ground.highest(space.ground, floor, low[0], low[1], high[0], high[1]) > floor:
        return True
    floor = -high[2] - growth - space.ceiling.extra + SURFACE_DEPTH
    return ground.highest(space.ceiling, floor, low[0], low[1], high[0], high[1]) > floor


@inner_query
def obstacle_distance(space: Space, p: Floats) -> float:
    """Return the metres to the nearest obstacle as given, or down to the ground if that is less; negative inside."""
    nearest = min(
        tree.distance(space.tree, space.boxes, p[0], p[1], p[2]), p[2] - ground.height(space.ground, p[0], p[1])
    )
    return solids.distance(space.solids, nearest, p[0], p[1], p[2])


@query
def point_free(space: Space, p: Floats) -> bool:
    """Tell whether a point is in bounds and outside every grown obstacle."""
    return in_bounds(space, p) and not inside_obstacle(space, space.clearance, p)


@query
def segment_free(space: Space, a: Floats, b: Floats) -> bool:
    """Tell whether a whole segment is in bounds and outside every grown obstacle."""
    return in_bounds(space, a) and in_bounds(space, b) and not crosses(space, space.clearance, a, b)


@query
def path_free(space: Space, path: Floats) -> bool:
    """Tell whether all legs of a path (k, 3) are free."""
    i = 1
    while i < len(path) and segment_free(space, path[i - 1], path[i]):
        i += 1
    return i >= len(path)


def only_boxes(space: Space) -> bool:
    """Tell whether all obstacles are boxes, with voxels among them: no other shape, and no ground."""
    return len(space.solids.kind) == 0 and space.ground.heights.size == 0


@kernel
def with_margin(space: Space, margin: float) -> Space:
    """Return the space with so many metres added to its clearance."""
    return Space(
        space.low,
        space.high,
        space.boxes,
        space.clearance + margin,
        space.tree,
        space.solids,
        space.ground,
        space.ceiling,
    )


def without_seams(space: Space) -> Space:
    """Return the space with closed obstacles: `segment_free` then refuses a segment that only touches one.

    The world's obstacles are open, so that what touches them is safe, and a segment could slip between two that touch
    each other. The lattice's obstacles are closed: each of its moves is a line of sight here.
    """
    return with_margin(space, 2.0 * SURFACE_DEPTH)


@kernel
def _points_free(space: Space, points: Floats) -> NDArray[np.bool_]:
    """Tell for each of (m, 3) points whether it is free, (m,)."""
    free = np.empty(len(points), np.bool_)
    for i in range(len(points)):
        free[i] = point_free(space, points[i])
    return free


@kernel
def _segments_free(space: Space, starts: Floats, ends: Floats) -> NDArray[np.bool_]:
    """Tell for each of m segments whether it is free, (m,)."""
    free = np.empty(len(starts), np.bool_)
    for i in range(len(starts)):
        free[i] = segment_free(space, starts[i], ends[i])
    return free


@kernel
def _first_crossing(space: Space, growth: float, starts: Floats, ends: Floats) -> int:
    """Return the first of m segments that meets an obstacle grown by `growth`, or -1."""
    for i in range(len(starts)):
        if crosses(space, growth, starts[i], ends[i]):
            return i
    return -1


@kernel
def _distances(space: Space, points: Floats) -> Floats:
    """Return `obstacle_distance` of each of (m, 3) points, (m,)."""
    distances = np.empty(len(points))
    for i in range(len(points)):
        distances[i] = obstacle_distance(space, points[i])
    return distances


class World:
    """Safe space: the scenario's bounds without its obstacles, each grown by the clearance on every side.

    A point on the surface of a grown obstacle, or on the bounds, is safe.

    Parameters
    ----------
    scenario
        The scenario whose space is compiled.
    """

    def __init__(self, scenario: Scenario) -> None:
        blocks, boxes, others, shapes = [np.zeros((0, 6))], [0], [], []
        # without clearance, the seams between boxes that only touch would be open
        filled = merged if scenario.clearance > SURFACE_DEPTH else seamless
        top = scenario.bounds.max[2] + ABOVE_BOUNDS
        for number, obstacle in numbered_shapes(scenario.obstacles, top):
            if isinstance(obstacle, Box | Voxels):
                rows = np.array([[*obstacle.min, *obstacle.max]]) if isinstance(obstacle, Box) else filled(obstacle)
                blocks.append(rows)
                boxes += [number] * len(rows)
            else:
                shapes.append(obstacle)
                others.append(number)
        table = np.concatenate(blocks, dtype=np.float64)
        index, order = tree.build(table)
        round_, rank = solids.make_solids(shapes)
        self._boxes = np.array(boxes[1:], dtype=np.int64)[order]
        self._solids = np.array(others, dtype=np.int64)[rank]
        self._obstacles, self._max_height = scenario.obstacles, scenario.max_height
        self.space = Space(
            low=np.array(scenario.bounds.min),
            high=np.array(scenario.bounds.max),
            boxes=table[order],
            clearance=float(scenario.clearance),
            tree=index,
            solids=round_,
            ground=ground.make_ground(scenario.terrain, float(scenario.ground_clearance - scenario.clearance)),
            ceiling=ground.make_ground(_upside_down_ceiling(scenario), -float(scenario.clearance)),
        )

    def free(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Tell for each of (m, 3) points in metres whether it is safe; (m,) booleans."""
        return _points_free(self.space, _rows(points))

    def segments_free(self, starts: ArrayLike, ends: ArrayLike, *, margin: float = 0.0) -> NDArray[np.bool_]:
        """Tell for each of m segments between (m, 3) and (m, 3) whether all of it is safe; (m,) booleans.

        `margin` is added to the clearance from obstacles and from the ground, metres.
        """
        a, b = _rows(starts), _rows(ends)
        if len(a) != len(b):
            raise ValueError(f"as many ends as starts are needed, got {len(b)} ends and {len(a)} starts")
        return _segments_free(with_margin(self.space, margin) if margin else self.space, a, b)

    def first_crossing(self, starts: ArrayLike, ends: ArrayLike, margin: float = 0.0) -> int | None:
        """Return the first of m segments between (m, 3) and (m, 3) that meets an obstacle or the ground, or ``None``.

        The clearance counts, and `margin` metres beside it; the bounds do not.
        """
        found = _first_crossing(self.space, self.space.clearance + margin, _rows(starts), _rows(ends))
        return found if found >= 0 else None

    def distance(self, points: ArrayLike) -> Floats:
        """Return for each of (m, 3) points the metres to the nearest obstacle, or above ground if that is less.

        Obstacles count as given, without clearance. The distance to them is Euclidean, that to the ground is vertical;
        inside it is negative.
        """
        return _distances(self.space, _rows(points))

    def why_unsafe(self, point: ArrayLike) -> str | None:
        """Return a sentence's end that says why a point is unsafe, or ``None`` if it is safe."""
        p = _rows(point)[0]
        if not in_bounds(self.space, p):
            low, high = (", ".join(f"{v:g}" for v in side) for side in (self.space.low, self.space.high))
            return f"lies outside the bounds ({low}) to ({high})"
        found = self.blocker(p)
        if found is not None:
            return f"lies inside {self.named(found)} grown by the clearance of {self.space.clearance:g} m"
        margin = self.space.clearance + self.space.ground.extra
        above = p[2] - ground.height(self.space.ground, p[0], p[1])
        if above < margin - SURFACE_DEPTH:
            return f"lies {above:g} m above ground, but {margin:g} m are required"
        if above_ceiling(self.space, self.space.clearance - SURFACE_DEPTH, p):
            return f"lies {above:g} m above ground, above the ceiling of {self._max_height:g} m"
        return None

    def blocker(self, point: ArrayLike) -> int | None:
        """Return which of the scenario's obstacles, grown by the clearance, holds a point, or ``None``."""
        x, y, z = _rows(point)[0]
        found = tree.containing(self.space.tree, self.space.boxes, self.space.clearance, x, y, z)
        if found >= 0:
            return int(self._boxes[found])
        found = solids.containing(self.space.solids, self.space.clearance, x, y, z)
        return int(self._solids[found]) if found >= 0 else None

    def named(self, number: int) -> str:
        """Describe an obstacle: its number in the scenario, and its name and kind where it has them."""
        obstacle = self._obstacles[number]
        known = [repr(obstacle.name)] * bool(obstacle.name) + [str(obstacle.kind)] * bool(obstacle.kind)
        return f"obstacles[{number}]" + (f" ({', '.join(known)})" if known else "")


def _upside_down_ceiling(scenario: Scenario) -> Terrain | None:
    """Return the ceiling above the terrain as a terrain of negative z, or ``None`` if there is none."""
    if scenario.terrain is None or scenario.max_height is None:
        return None
    return scenario.terrain.model_copy(update={"heights": -(scenario.terrain.heights + scenario.max_height)})


def _rows(points: ArrayLike) -> Floats:
    """Return points as (m, 3) numbers that kernels take."""
    rows = np.atleast_2d(writable(points))
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise ValueError(f"points are rows of x, y, z, but the array has shape {np.shape(points)}")
    return rows
