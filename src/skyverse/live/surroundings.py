"""What a UAV in flight keeps clear of: what stands still, what was seen to move, and the motions of other UAVs."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.choice import Span
from skyverse.model.kept_ellipsoid import kept_ellipsoid
from skyverse.model.mover import Doubt, Ellipsoid, Mover
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box, Cylinder, Prism, Shape, Sphere, Voxels
from skyverse.model.temporary_zones import told_zone
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LIMIT_EASE
from skyverse.space.moving_ellipsoids import MovingEllipsoid, with_ellipsoids
from skyverse.space.moving_shapes import MovingShapes, moving_shapes
from skyverse.space.timed_shapes import STANDING, TimedShape, timed_shapes
from skyverse.space.voxels import boxes_of
from skyverse.space.world import World
from skyverse.trajectory.limits import Limits
from skyverse.trajectory.proof import clear_pieces
from skyverse.trajectory.speed_in_zones import first_too_fast


class Moving(NamedTuple):
    """What moves and was seen or is known beforehand, the same for all UAVs with one tracking error.

    Attributes
    ----------
    shapes
        n shapes.
    names
        How sentences call each of these.
    needs
        (n,) metres that must be kept from the middle of each, about, at the middle of the horizon.
    """

    shapes: MovingShapes
    names: tuple[str, ...]
    needs: Floats


class Surroundings(NamedTuple):
    """What a UAV keeps clear of, and what it can do.

    Attributes
    ----------
    limits
        Its own.
    world
        What stands still.
    moving
        What moves, other UAVs after all else.
    uavs
        The index of the first shape that is another UAV.
    """

    limits: Limits
    world: World
    moving: Moving
    uavs: int


def all_moving(
    scenario: Scenario, seen: Sequence[Mover], entered: Sequence[Shape], error: TrackingError, span: Span
) -> Moving:
    """Return what moves up to the horizon, apart from UAVs.

    Parameters
    ----------
    scenario
        With the movers and zones whose times are known.
    seen
        Movers that were seen, with all that they may do.
    entered
        Obstacles that were seen when a UAV was too near to them already.
    error
        The tracking error of the UAVs that keep clear of all this.
    span
        The instants that matter.
    """
    known = timed_shapes(scenario)
    names = [f"mover {mover.name!r}" for mover in scenario.movers]
    names += [told_zone(scenario, one.zone) for one in known if one.zone >= 0]
    known += [TimedShape(mover.shape, mover.motion, mover.doubt, scenario.clearance) for mover in seen]
    names += [f"mover {mover.name!r}" for mover in seen]
    known += [TimedShape(part, STANDING, Doubt(), scenario.clearance) for one in entered for part in _parts(one)]
    names += ["a new obstacle" + (f" ({one.name!r})" if one.name else "") for one in entered for _ in _parts(one)]
    known = [one._replace(active=(one.active[0], min(one.active[1], span.until))) for one in known]
    needs = np.array([_need(one, 0.5 * (span.now + span.until)) for one in known])
    return Moving(moving_shapes(known, error), tuple(names), needs)


def with_others(moving: Moving, scenario: Scenario, uav: int, others: Mapping[int, Sequence[Trajectory]]) -> Moving:
    """Return what moves, and after it what a UAV must keep clear of about the motions of other UAVs."""
    ellipsoids, names = [], []
    for other, motion in ((other, motion) for other, motions in others.items() for motion in motions):
        across, above = kept_ellipsoid(scenario.uavs[uav], scenario.uavs[other])
        if across > 0.0:
            fastest = scenario.uavs[other].max_speed * (1.0 + LIMIT_EASE)
            fastest = max(fastest, _speed_if_too_fast(motion, fastest))
            ellipsoids.append(MovingEllipsoid(motion, across, above, fastest))
            names.append(scenario.uavs[other].name)
    needs = np.append(moving.needs, [max(one.semi_axis_xy, one.semi_axis_z) for one in ellipsoids])
    return Moving(with_ellipsoids(moving.shapes, ellipsoids), (*moving.names, *names), needs)


def barred(world: World, begin: float, durations: Floats, rows: Floats) -> float:
    """Return from when on it is not proven that a motion is clear of what stands still, and slow enough in zones.

    Parameters
    ----------
    world
        What stands still.
    begin
        The instant at which the motion begins, seconds.
    durations, rows
        Its pieces, of (m,) seconds, and their coefficients (m, k, 3), metres.

    Returns
    -------
    float
        The beginning of a piece, or an instant at which it is too fast; infinite if all of it is proven.
    """
    clear = clear_pieces(world.space, durations, rows)
    knots = begin + np.append(0.0, np.cumsum(durations))
    instant = math.inf if clear.all() else float(knots[np.argmin(clear)])
    too_fast = first_too_fast(world.speed_zones, Trajectory(knots, rows)) if world.speed_zones and len(rows) else None
    return instant if too_fast is None else min(instant, too_fast)


def _speed_if_too_fast(motion: Trajectory, limit: float) -> float:
    """Return a bound of a motion's speed if a piece begins above a limit, as after a gust; else 0."""
    rows = motion.coefficients[:, 1:]
    if not rows.shape[1] or np.linalg.norm(rows[:, 0], axis=1).max() <= limit:
        return 0.0
    powers, seconds = np.arange(rows.shape[1]), np.diff(motion.knots)[:, None]
    return float(np.max((np.linalg.norm(rows, axis=2) * (powers + 1.0) * seconds**powers).sum(axis=1)))


def _parts(obstacle: Shape) -> tuple[Shape, ...]:
    """Return the shapes that an obstacle consists of."""
    return tuple(boxes_of(obstacle)) if isinstance(obstacle, Voxels) else (obstacle,)


def _need(one: TimedShape, t: float) -> float:
    """Return about how far from the middle of a shape a UAV must be at an instant, metres."""
    shape, size = one.shape, 0.0
    if isinstance(shape, Ellipsoid):
        size = max(shape.semi_axis_xy, shape.semi_axis_z)
    elif isinstance(shape, Box | Cylinder | Sphere | Prism):
        low, high = extent(shape)
        size = 0.5 * float((high - low).max())
    return size + one.keep + float(one.doubt.at(t)[0])
