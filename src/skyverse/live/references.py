"""The curves that an aeroplane may follow from where it is: back to what was planned, and away."""

import math
from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.aeroplane_course import Flying, Reference, poses_at, timed
from skyverse.live.aeroplane_legs import FALLING, LEFT, LEVEL, RIGHT, RISING, flown_leg, leg_between, seconds_to, turn
from skyverse.live.course import of_one_degree
from skyverse.live.planned_motion import followed
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import LEG_END
from skyverse.trajectory.dubins import pose as pose_after
from skyverse.trajectory.dubins_leg import DubinsLeg

STEP, EVEN, WIDER = 0.5, 24, 1.2
"""Places to get back to the planned trajectory are so many turn radii apart; after so many, each gap is wider."""
MAX_PLACES = 48
"""How many such places are tried at most."""
ANGLES = (0.0, math.pi / 6, math.pi / 3, math.pi / 2, 2 * math.pi / 3, math.pi)
"""Radians by which an aeroplane turns away."""
STRAIGHTS = (0.0, 2.0)
"""How far it then flies straight on, in turn radii."""


class Ahead(NamedTuple):
    """Poses at which an aeroplane can get back to its planned trajectory.

    Attributes
    ----------
    motion
        The planned trajectory.
    instants, poses
        (n,) seconds on it, and (n, 5) x, y, z, heading and rate of climb.
    """

    motion: Trajectory
    instants: Floats
    poses: Floats

    def seconds_left(self, poses: Floats, able: Flying) -> Floats:
        """Return about how many seconds it takes at least to the target from poses (m, 5), by each place, (m, n)."""
        rest = self.motion.end - self.instants
        return np.asarray(seconds_to(poses, self.poses, able.agility, able.speed) + rest)


def places_ahead(motion: Trajectory, since: float, able: Flying) -> Ahead:
    """Return the poses of a planned trajectory from an instant of it on."""
    gaps = STEP * able.radius / able.speed * WIDER ** np.maximum(np.arange(MAX_PLACES) - EVEN, 0)
    instants = max(since, motion.start) + np.append(0.0, np.cumsum(gaps))
    instants = np.append(instants[instants < motion.end], motion.end)
    return Ahead(motion, instants, poses_at(motion, instants))


def back_to(ahead: Ahead, k: int, rank: int, begin: float, pose: Floats, able: Flying) -> Reference | None:
    """Return the reference from a pose (5,) at an instant that gets back to the k-th place ahead, and goes on there.

    `rank` counts the words of the way back from the shortest one on; ``None`` if there is no such way.
    """
    instant, to = float(ahead.instants[k]), ahead.poses[k]
    seconds, rest = followed(ahead.motion, instant, ahead.motion.end)
    off = (float(pose[3] - to[3]) + math.pi) % (2.0 * math.pi) - math.pi
    if max(np.abs(pose - to)[:3].max(), abs(off) * able.radius) <= LEG_END:  # it is there
        return Reference(timed(begin, seconds, rest), begin, begin - instant) if len(seconds) and not rank else None
    leg = leg_between(pose, to, able.agility, able.speed, rank)
    if leg.a + leg.b + leg.c == math.inf:
        return None
    durations, rows = flown_leg(leg, float(pose[4]), float(to[4]), able.agility, able.speed)
    if len(seconds):
        durations, rows = np.append(durations, seconds), np.concatenate(of_one_degree(rows, rest))
    motion = timed(begin, durations, rows)
    joins = float(motion.knots[len(durations) - len(seconds)])
    return Reference(motion, joins, joins - instant)


def turns_away(pose: Floats, able: Flying) -> Iterator[DubinsLeg]:
    """Yield legs from a pose (5,) that turn, go straight on, and rise or fall meanwhile."""
    for angle, side, straight, climbs in product(ANGLES, (LEFT, RIGHT), STRAIGHTS, (LEVEL, RISING, FALLING)):
        if angle > 0.0 or (straight > 0.0 and side == LEFT):
            yield turn(pose, side, angle, straight * able.radius, climbs, able.agility, able.speed)


def away_along(leg: DubinsLeg, begin: float, pose: Floats, able: Flying) -> Reference:
    """Return the reference from a pose (5,) at an instant along a leg of `turns_away`."""
    return Reference(timed(begin, *flown_leg(leg, float(pose[4]), 0.0, able.agility, able.speed)))


def end_of(leg: DubinsLeg) -> Floats:
    """Return about the pose (5,) in which a leg of `turns_away` ends, which is level."""
    x, y, heading = pose_after(leg.x, leg.y, leg.heading, leg.word, leg.a, leg.b, leg.radius, leg.a + leg.b)
    return np.array([x, y, leg.z + leg.climb.slope * (leg.climb.ramp + leg.climb.hold), heading, 0.0])
