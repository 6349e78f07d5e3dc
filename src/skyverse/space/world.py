"""Which points and segments of a scenario's space are free, and how far away obstacles are."""

from copy import copy
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skyverse._typing import Floats
from skyverse.errors import InputError, require_kind
from skyverse.model.pad import error_about_pads
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extruded
from skyverse.model.shapes import Box, Terrain, Voxels
from skyverse.model.uav import TrackingError
from skyverse.numerics.kernel import kernel, query, writable
from skyverse.numerics.tolerances import CLEARANCE_EASE, SURFACE_DEPTH
from skyverse.space import ground, solids, tree
from skyverse.space.obstacles import (
    Space,
    above_ceiling,
    crosses,
    in_bounds,
    obstacle_distance,
)
from skyverse.space.speed_zones import SpeedZone, make_speed_zones
from skyverse.space.tracking_error import NO_ERROR, inner_bounds, is_wall_within, raised, reach, taller, wider
from skyverse.space.voxels import merged


@query
def point_free(space: Space, p: Floats) -> bool:
    """Tell whether a point is in bounds and keeps the clearance; see `segment_free`."""
    return segment_free(space, p, p)


@query
def segment_free(space: Space, a: Floats, b: Floats) -> bool:
    """Tell whether a whole segment is in bounds and keeps the clearance, both of which it may touch."""
    return in_bounds(space, a) and in_bounds(space, b) and not crosses(space, 0.0, a, b)


@query
def path_free(space: Space, path: Floats) -> bool:
    """Tell whether all legs of a path (k, 3) are free."""
    i = 1
    while i < len(path) and segment_free(space, path[i - 1], path[i]):
        i += 1
    return i >= len(path)


BESIDE = 1.0
"""Metres: what is farther from a vertical line, beside what must be kept, is not in `World.without_support`."""


@kernel
def _points_free(space: Space, points: Floats) -> NDArray[np.bool_]:
    """Tell for each of (m, 3) points whether it is free, (m,)."""
    free = np.empty(len(points), np.bool_)
    for i in range(len(points)):
        free[i] = point_free(space, points[i])
    return free


@kernel
def _segments_free(space: Space, margin: float, starts: Floats, ends: Floats) -> NDArray[np.bool_]:
    """Tell for each of m segments whether it is in bounds, and keeps the clearance and a margin, (m,)."""
    free = np.empty(len(starts), np.bool_)
    for i in range(len(starts)):
        a, b = starts[i], ends[i]
        free[i] = in_bounds(space, a) and in_bounds(space, b) and not crosses(space, margin, a, b)
    return free


@kernel
def _first_crossing(space: Space, margin: float, starts: Floats, ends: Floats) -> int:
    """Return the first of m segments that comes nearer to an obstacle than the clearance and a margin, or -1."""
    for i in range(len(starts)):
        if crosses(space, margin, starts[i], ends[i]):
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
    """Safe space: what is in the scenario's bounds and keeps the clearance, less half a micrometre, from all else.

    A point that keeps just the clearance, or lies on the bounds, is safe.

    Parameters
    ----------
    scenario
        The scenario whose space is compiled.
    error
        How far a UAV may stray from its nominal position. A nominal position is safe if all that are within this error
        of it are safe.

    Attributes
    ----------
    space
        What kernels know of it.
    scenario, error
        As given.
    low, high
        (3,) metres: the scenario's bounds, in which the lattice lies. Those of the space are narrower by the error.
    """

    def __init__(self, scenario: Scenario, error: TrackingError = NO_ERROR) -> None:
        require_kind(scenario, Scenario, "scenario")
        blocks, boxes, others, shapes = [np.zeros((0, 6))], [0], [], []
        top = scenario.bounds.max[2]
        for number, obstacle in enumerate(scenario.obstacles):
            for shape in extruded(obstacle, top):
                if isinstance(shape, Box | Voxels):
                    rows = np.array([[*shape.min, *shape.max]]) if isinstance(shape, Box) else merged(shape)
                    blocks.append(rows)
                    boxes += [number] * len(rows)
                else:
                    shapes.append(shape)
                    others.append(number)
        table = np.concatenate(blocks, dtype=np.float64)
        table[:, [2, 5]] += np.array([-1.0, 1.0]) * taller(error)
        index, order = tree.build(table)
        round_, rank = solids.make_solids(shapes, error)
        self._boxes = np.array(boxes[1:], dtype=np.int64)[order]
        self._solids = np.array(others, dtype=np.int64)[rank]
        self._shapes = [shapes[k] for k in rank]
        self.scenario, self.error = scenario, error
        growth = reach(float(scenario.clearance), error)
        self.low, self.high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
        low, high = inner_bounds(self.low, self.high, error)
        floor, ceiling = raised(scenario.terrain, error), raised(_upside_down_ceiling(scenario), error)
        self.space = Space(
            low=low,
            high=high,
            boxes=table[order],
            clearance=growth - CLEARANCE_EASE,
            tree=index,
            solids=round_,
            ground=ground.make_ground(floor, float(scenario.ground_clearance - growth)),
            ceiling=ground.make_ground(ceiling, -growth),
        )

    def without_support(self, place: ArrayLike, highest: float, reach: float = BESIDE) -> "World":
        """Return the world of the vertical line through a place, without what a UAV stands on there.

        It has neither the bounds' floor less the error, nor obstacles that end, as given, no higher than z =
        `highest` and are solid, nor the ground, unless that `is_steep_about` the place. Of all other obstacles it has
        those that the line meets if they are grown by `reach` metres more.

        Parameters
        ----------
        place
            (3,) metres.
        highest, reach
            Metres.
        """
        space, error = self.space, self.error
        xy, grown = _rows(place)[0, :2], space.clearance + reach
        is_sphere = space.solids.kind[:, 0] == solids.SPHERE
        lifts = np.where(is_sphere, wider(error), taller(error))
        tops = space.boxes[:, 5] - taller(error), space.solids.bounds[:, 5] - lifts
        boxes, others = (
            np.flatnonzero((table[:, :2] - grown <= xy).all(1) & (xy <= table[:, 3:5] + grown).all(1))
            for table in (space.boxes, space.solids.bounds)
        )
        boxes, others = (
            np.array(
                [k for k in near if top[k] > highest or not self.scenario.obstacles[number[k]].solid], dtype=np.int64
            )
            for near, top, number in zip((boxes, others), tops, (self._boxes, self._solids), strict=True)
        )
        table = space.boxes[boxes]
        index, order = tree.build(table)
        shapes = [self._shapes[k] for k in others]
        round_, rank = solids.make_solids(shapes, error)
        low = np.array([*space.low[:2], self.low[2]])
        floor = space.ground if self.is_steep_about(place) else ground.make_ground(None)
        found = copy(self)
        found._boxes, found._solids = self._boxes[boxes][order], self._solids[others][rank]
        found._shapes = [shapes[k] for k in rank]
        found.space = space._replace(low=low, boxes=table[order], tree=index, solids=round_, ground=floor)
        return found

    @cached_property
    def speed_zones(self) -> tuple[SpeedZone, ...]:
        """The zones with a speed limit, as they are for a nominal position."""
        return make_speed_zones(self.scenario, self.error)

    @property
    def clearance(self) -> float:
        """Metres that are kept from obstacles, beside the error."""
        return self.scenario.clearance

    @cached_property
    def about_pads(self) -> "World":
        """The world of the axes of pads: what keeps clear in it keeps the error from the pads."""
        error = error_about_pads(self.scenario, self.error)
        return self if error == self.error else World(self.scenario, error)

    def is_steep_about(self, place: ArrayLike) -> bool:
        """Tell whether the ground is steeper than 45 degrees somewhere within the horizontal error of a place (3,)."""
        return is_wall_within(self.scenario.terrain, _rows(place)[0, :2], self.error.horizontal)

    def least_height(self, place: ArrayLike) -> float:
        """Return the least z above a place, (3,) metres, that keeps clear of the ground; minus infinity without any."""
        (x, y, _), space = _rows(place)[0], self.space
        return float(ground.height(space.ground, x, y) + space.clearance + CLEARANCE_EASE + space.ground.extra)

    def free(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Tell for each of (m, 3) points in metres whether it is safe; (m,) booleans."""
        return _points_free(self.space, _rows(points))

    def segments_free(self, starts: ArrayLike, ends: ArrayLike, *, margin: float = 0.0) -> NDArray[np.bool_]:
        """Tell for each of m segments between (m, 3) and (m, 3) whether all of it is safe; (m,) booleans.

        `margin` is added to the clearance from obstacles and from the ground, metres.
        """
        a, b = _rows(starts), _rows(ends)
        if len(a) != len(b):
            raise InputError(f"as many ends as starts are needed, got {len(b)} ends and {len(a)} starts")
        return _segments_free(self.space, margin, a, b)

    def first_crossing(self, starts: ArrayLike, ends: ArrayLike, margin: float = 0.0) -> int | None:
        """Return the first of m segments between (m, 3) and (m, 3) that meets an obstacle or the ground, or ``None``.

        The clearance counts, and `margin` metres beside it; the bounds do not.
        """
        found = _first_crossing(self.space, margin, _rows(starts), _rows(ends))
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
        straying = ""
        if self.error != NO_ERROR:
            aside, up = self.error.horizontal, self.error.vertical
            straying = f" and the tracking error of {aside:g} m horizontally and {up:g} m vertically"
        if not in_bounds(self.space, p):
            low, high = (", ".join(f"{v:g}" for v in side) for side in (self.low, self.high))
            if np.all(p >= self.low) and np.all(p <= self.high):
                return f"lies too near the bounds, ({low}) to ({high}), for the{straying.removeprefix(' and the')}"
            return f"lies outside the bounds ({low}) to ({high})"
        found = self.blocker(p)
        if found is not None:
            clearance = f"the clearance of {self.scenario.clearance:g} m"
            return f"lies inside {self.named(found)} grown by {clearance}{straying}"
        margin = self.space.clearance + CLEARANCE_EASE + self.space.ground.extra
        above = p[2] - ground.height(self.space.ground, p[0], p[1])
        counting = ", counting the tracking error" if straying else ""
        if self.scenario.terrain is not None:
            level = float(self.scenario.terrain.height(p[:2]))
            required = margin + ground.height(self.space.ground, p[0], p[1]) - level
            most = -ground.height(self.space.ceiling, p[0], p[1]) - level
            if most < required - CLEARANCE_EASE:
                room = f"the ceiling is {most:.4g} m above the ground, and {required:.4g} m above it are required"
                return f"lies where no height keeps both: {room}{counting}"
        if above < margin - CLEARANCE_EASE - SURFACE_DEPTH:
            return f"lies {above:g} m above ground{counting}, but {margin:g} m are required"
        if above_ceiling(self.space, -SURFACE_DEPTH, p):
            assert self.scenario.terrain is not None
            above = p[2] - float(self.scenario.terrain.lowest_ground.height(p[:2]))
            at = "reaches" if straying else f"lies {above:g} m above ground,"
            return f"{at} above the ceiling of {self.scenario.max_height:g} m{counting}"
        return None

    def blocker(self, point: ArrayLike, margin: float = 0.0) -> int | None:
        """Return which of the scenario's obstacles, grown by the clearance, holds a point, or ``None``.

        `margin` is added to the clearance, metres.
        """
        x, y, z = _rows(point)[0]
        reach = self.space.clearance + margin
        found = tree.containing(self.space.tree, self.space.boxes, reach, x, y, z)
        if found >= 0:
            return int(self._boxes[found])
        found = solids.containing(self.space.solids, reach, x, y, z)
        return int(self._solids[found]) if found >= 0 else None

    def way_out_above(self, point: ArrayLike) -> float | None:
        """Return the z at which what makes a point unsafe ends above it, or ``None`` if that does not end.

        Something else may make the place there unsafe.
        """
        x, y, z = p = _rows(point)[0]
        space, whole = self.space, self.space.clearance + CLEARANCE_EASE
        box_ = tree.containing(space.tree, space.boxes, space.clearance, x, y, z)
        if box_ >= 0:
            return float(space.boxes[box_, 5] + whole)
        solid = solids.containing(space.solids, space.clearance, x, y, z)
        if solid >= 0:
            return solids.top_above(space.solids, solid, whole, x, y)
        floor = max(float(space.low[2]), self.least_height(p))
        return floor if p[2] < floor - CLEARANCE_EASE else None

    def named(self, number: int) -> str:
        """Describe an obstacle: its number in the scenario, and its name and kind where it has them."""
        obstacle = self.scenario.obstacles[number]
        known = [repr(obstacle.name)] * bool(obstacle.name) + [str(obstacle.kind)] * bool(obstacle.kind)
        return f"obstacles[{number}]" + (f" ({', '.join(known)})" if known else "")


def _upside_down_ceiling(scenario: Scenario) -> Terrain | None:
    """Return the ceiling above the terrain as a terrain of negative z, or ``None`` if there is none."""
    if scenario.terrain is None or scenario.max_height is None:
        return None
    below = scenario.terrain.lowest_ground
    return derived(below, heights=-(below.heights + scenario.max_height))


def _rows(points: ArrayLike) -> Floats:
    """Return points as (m, 3) numbers that kernels take."""
    rows = np.atleast_2d(writable(points))
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise InputError(f"points are rows of x, y, z, but the array has shape {np.shape(points)}")
    return rows
