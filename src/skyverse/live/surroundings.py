"""What a UAV in flight keeps clear of: what stands still, what was seen to move, and the motions of other UAVs."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.course import Course
from skyverse.live.guidance import Way
from skyverse.live.planned_motion import Planned
from skyverse.model.kept_ellipsoid import kept_ellipsoid
from skyverse.model.mover import Doubt, Ellipsoid, Mover
from skyverse.model.mover_motions import PolynomialMotion
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box, Cylinder, Prism, Shape, Sphere, Voxels
from skyverse.model.temporary_zones import told_zone
from skyverse.numerics.tolerances import LIMIT_MARGIN
from skyverse.space.moving_shapes import MovingShapes, moving_shapes
from skyverse.space.timed_shapes import STANDING, TimedShape, timed_shapes
from skyverse.space.voxels import boxes_of
from skyverse.space.world import World
from skyverse.trajectory.limits import Limits, limits_of


class Surroundings(NamedTuple):
    """What a UAV keeps clear of, and what it can do.

    Attributes
    ----------
    limits
        Its own.
    world
        What stands still.
    shapes
        What moves, n shapes.
    names
        How sentences call each of these.
    needs
        (n,) metres that must be kept from the middle of each, about, at the middle of the horizon.
    guidance, planned
        The way that it would fly if nothing moved, and the mission's trajectory, ``None`` if it flies another way.
    uavs
        The index of the first shape that is another UAV; all that follow are.
    """

    limits: Limits
    world: World
    shapes: MovingShapes
    names: tuple[str, ...]
    needs: Floats
    guidance: Way
    planned: Planned | None
    uavs: int


def surroundings(
    scenario: Scenario,
    uav: int,
    world: World,
    guidance: Way,
    planned: Planned | None,
    seen: Sequence[Mover],
    entered: Sequence[Shape],
    others: Mapping[int, Course],
    instant: float,
) -> Surroundings:
    """Return what a UAV keeps clear of.

    Parameters
    ----------
    scenario
        With the movers and zones whose times are known.
    uav
        Its index.
    world, guidance, planned
        What stands still, the way that it would fly if nothing moved, and the mission's trajectory if it can fly that.
    seen
        Movers that were seen, with all that they may do.
    entered
        Obstacles that were seen when a UAV was too near to them already.
    others
        What other UAVs fly.
    instant
        The middle of the horizon, seconds into the mission.
    """
    vehicle = scenario.uavs[uav]
    known = timed_shapes(scenario)
    names = [f"mover {mover.name!r}" for mover in scenario.movers]
    names += [told_zone(scenario, one.zone) for one in known if one.zone >= 0]
    known += [TimedShape(mover.shape, mover.motion, mover.doubt, scenario.clearance) for mover in seen]
    names += [f"mover {mover.name!r}" for mover in seen]
    known += [TimedShape(part, STANDING, Doubt(), scenario.clearance) for one in entered for part in _parts(one)]
    names += ["a new obstacle" + (f" ({one.name!r})" if one.name else "") for one in entered for _ in _parts(one)]
    uavs = len(known)
    for other, course in others.items():
        across, above = kept_ellipsoid(vehicle, scenario.uavs[other])
        if across > 0.0:
            motion = course.motion
            moves = PolynomialMotion(knots=tuple(motion.knots), coefficients=motion.coefficients.tolist())
            shape = Ellipsoid(centre=(0, 0, 0), semi_axis_xy=across, semi_axis_z=above)
            known.append(TimedShape(shape, moves, Doubt(), 0.0))
            names.append(scenario.uavs[other].name)
    needs = np.array([_need(one, instant) for one in known])
    shapes = moving_shapes(known, vehicle.tracking_error)
    return Surroundings(limits_of(vehicle, -LIMIT_MARGIN), world, shapes, tuple(names), needs, guidance, planned, uavs)


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
