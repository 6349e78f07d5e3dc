"""What a UAV in flight keeps clear of: what stands still, what was seen to move, and the motions of other UAVs.

If a UAV is found where it may not be, `way_back` gives motions that lead it back to where nothing is too near.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.mover import Doubt, Mover
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Shape
from skyverse.model.timed_shapes import STANDING, TimedShape, told_zone
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError, kept_ellipsoid
from skyverse.numerics.tolerances import LIMIT_EASE
from skyverse.space.contact import first_contact, share_avoided
from skyverse.space.moving_ellipsoids import MovingEllipsoid, with_ellipsoids
from skyverse.space.speed_zones import first_too_fast
from skyverse.space.timed_shapes import MovingShapes, moving_shapes, timed_parts
from skyverse.space.voxels import parts_of
from skyverse.space.world import World
from skyverse.trajectory.limits import Limits
from skyverse.trajectory.proof import clear_pieces


class Span(NamedTuple):
    """The instants that matter, seconds into the mission.

    Attributes
    ----------
    now, join
        Now, and when a new motion can begin.
    until
        Until when it is proven.
    apart
        Until when it is proven to keep its distance from other UAVs, no earlier than `until`.
    """

    now: float
    join: float
    until: float
    apart: float


class FirstContact(NamedTuple):
    """What a motion first comes too near to: when, infinite if never, and which mover, -1 for what stands still."""

    instant: float = math.inf
    mover: int = -1


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
    """What a UAV keeps clear of, what it can do, and how long may be searched for that.

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
    span
        The instants that matter.
    motions, deadline
        How many motions are made at most, and the reading of `time.perf_counter` after which no more are made.
    """

    limits: Limits
    world: World
    moving: Moving
    uavs: int
    span: Span
    motions: int
    deadline: float

    def contact(self, motion: Trajectory, begin: float, until: float, fastest: float = 0.0) -> FirstContact:
        """Return what moves that a motion first comes too near to between two instants; see `first_contact`.

        `fastest` is the greatest speed of one that breaks the limits, m/s.
        """
        if begin > until:
            return FirstContact()
        fastest = max(self.limits.speed * (1.0 + LIMIT_EASE), fastest)
        knots, rows = motion.knots.copy(), motion.coefficients.copy()
        mover, instant = first_contact(self.moving.shapes, knots, rows, fastest, begin, until)
        return FirstContact(instant, mover)

    def danger(self, motion: Trajectory) -> tuple[float, float]:
        """Return the share of movers' doubts that a motion avoids from `span.join` on, less than 0, and the seconds.

        Both are less for a motion that is less dangerous; see `share_avoided`.
        """
        knots, rows = motion.knots.copy(), motion.coefficients.copy()
        share, missing = share_avoided(self.moving.shapes, knots, rows, self.span.join, self.span.apart)
        return -share, missing

    def barred(self, motion: Trajectory) -> float:
        """Return from when on it is not proven that a motion is clear of what stands still, and slow enough in zones.

        That is the beginning of a piece, or an instant at which it is too fast; infinite if all of it is proven.
        """
        clear = clear_pieces(self.world.space, np.diff(motion.knots), motion.coefficients.copy())
        instant = math.inf if clear.all() else float(motion.knots[np.argmin(clear)])
        zones = self.world.speed_zones
        too_fast = first_too_fast(zones, motion) if zones and len(motion.coefficients) else None
        return instant if too_fast is None else min(instant, too_fast)


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
    known = timed_parts(scenario)
    names = [f"mover {mover.name!r}" for mover in scenario.movers]
    names += [told_zone(scenario, one.zone) for one in known if one.zone >= 0]
    known += [TimedShape(mover.shape, mover.motion, mover.doubt, scenario.clearance) for mover in seen]
    names += [f"mover {mover.name!r}" for mover in seen]
    known += [TimedShape(part, STANDING, Doubt(), scenario.clearance) for one in entered for part in parts_of(one)]
    names += ["a new obstacle" + (f" ({one.name!r})" if one.name else "") for one in entered for _ in parts_of(one)]
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


def _speed_if_too_fast(motion: Trajectory, limit: float) -> float:
    """Return a bound of a motion's speed if a piece begins above a limit, as after a gust; else 0."""
    rows = motion.coefficients[:, 1:]
    if not rows.shape[1] or np.linalg.norm(rows[:, 0], axis=1).max() <= limit:
        return 0.0
    powers, seconds = np.arange(rows.shape[1]), np.diff(motion.knots)[:, None]
    return float(np.max((np.linalg.norm(rows, axis=2) * (powers + 1.0) * seconds**powers).sum(axis=1)))


def _need(one: TimedShape, t: float) -> float:
    """Return about how far from the middle of a shape a UAV must be at an instant, metres."""
    low, high = extent(one.shape)
    size = 0.5 * float((high - low).max())
    return size + one.keep + float(one.doubt.at(t)[0])


SAMPLES = 8
"""Instants of each piece at which it is looked at how near to obstacles and bounds it leads."""
NEARER = 0.01
"""Metres by which a UAV may come nearer to an obstacle, or farther out of bounds, than it is."""


def way_back(world: World, motion: Trajectory) -> tuple[float, float]:
    """Return how a motion leads to where it is clear of what stands still, and slow enough in zones.

    Returns
    -------
    seconds
        After which it is so for good, infinite if it never is.
    missing
        Metres that it lacks where it ends: infinite if it first leads nearer to obstacles or farther out of bounds, or
        ends no nearer to where it is clear.
    """
    if not len(motion.coefficients):
        return math.inf, math.inf
    knots, durations = motion.knots - motion.start, np.diff(motion.knots)
    clear = clear_pieces(world.space, durations, motion.coefficients.copy())
    slow = _seconds_too_fast(world, motion)
    if clear.all():
        return slow, 0.0
    count = len(clear) - int(np.argmin(clear[::-1]))  # pieces up to the last one that is not clear
    steps = np.arange(SAMPLES + 1) / SAMPLES
    t = (motion.knots[:count, None] + durations[:count, None] * steps).ravel()
    places = motion.at(t).position
    inside = np.minimum(places - world.space.low, world.space.high - places).min(axis=1)
    before = missing = 0.0
    for left, need in ((world.distance(places), world.space.clearance), (inside, 0.0)):
        if left.min() < min(left[0], need) - NEARER:
            return math.inf, math.inf
        before, missing = before + max(need - left[0], 0.0), missing + max(need - left[-1], 0.0)
    if clear[-1]:
        return max(float(knots[count]), slow), 0.0
    return math.inf, missing if missing < before - NEARER else math.inf


def _seconds_too_fast(world: World, motion: Trajectory) -> float:
    """Return the seconds after which it is last seen that a motion is too fast for a zone; 0 if it is not."""
    if not world.speed_zones:
        return 0.0
    t = np.unique(np.linspace(motion.knots[:-1], motion.knots[1:], SAMPLES + 1))
    places, velocities, _ = motion.at(t)
    speeds, last = np.linalg.norm(velocities, axis=1), 0.0
    for now, place, speed in zip(t.tolist(), places, speeds.tolist(), strict=True):
        if any(speed > zone.max_speed * (1.0 + LIMIT_EASE) and zone.holds(place) for zone in world.speed_zones):
            last = now - motion.start
    return last
