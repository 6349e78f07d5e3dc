"""What an aeroplane is flying: along a reference, and from some instant on a loiter."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.aeroplane_legs import LEFT, LEVEL, RIGHT, flown_leg, turn
from skyverse.live.course import parted, spliced
from skyverse.live.planned_motion import followed
from skyverse.model.elementary import arctan2
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import MIN_PIECE
from skyverse.trajectory.pose_search import Agility


class Flying(NamedTuple):
    """What an aeroplane can do: its agility by metres of way, and its horizontal speed, m/s."""

    agility: Agility
    speed: float

    @property
    def radius(self) -> float:
        """Its least turn radius, metres."""
        return float(self.agility.radii[0])


class Reference(NamedTuple):
    """A curve that is followed.

    Attributes
    ----------
    motion
        The curve, by seconds into the mission.
    joins
        The instant from which it is on the planned trajectory, to its end at the target; infinite if it never is.
    later
        How much later it is there than planned, seconds.
    """

    motion: Trajectory
    joins: float = math.inf
    later: float = 0.0


@dataclass(frozen=True)
class AeroplaneCourse:
    """What an aeroplane is flying.

    Attributes
    ----------
    flown
        The motions flown before `motion` begins, one after another.
    motion
        From some instant before now, or from its departure, to the end of a full turn, or of the reference.
    reference, leaves
        What it follows, ``None`` if nothing, and the instant at which it leaves that and begins to loiter; infinite if
        it stays where it is.
    """

    flown: tuple[Trajectory, ...]
    motion: Trajectory
    reference: Reference | None
    leaves: float

    @property
    def arrival(self) -> float | None:
        """The instant at which it passes its target, seconds; ``None`` if it loiters before."""
        reference = self.reference
        if reference is None or reference.joins == math.inf or self.leaves < reference.motion.end:
            return None
        return reference.motion.end

    @property
    def stands(self) -> bool:
        """Whether it stays where it is."""
        return self.reference is None and self.leaves == math.inf

    @property
    def lands(self) -> bool:
        """Whether it ends where its reference does."""
        return self.arrival is not None and self.motion.end <= self.leaves + MIN_PIECE

    def planned_until(self, t: float) -> float:
        """Return the instant of the planned trajectory up to which it is flown at an instant; -inf if it is not."""
        reference, t = self.reference, min(t, self.leaves)
        return -math.inf if reference is None or t < reference.joins else t - reference.later

    def since(self, now: float) -> "AeroplaneCourse":
        """Return the same course, of which the pieces that end before now are counted as flown."""
        past, motion = parted(self.motion, now)
        return self if past is None else replace(self, flown=(*self.flown, past), motion=motion)

    def joined(self, motion: Trajectory, reference: Reference | None, leaves: float) -> "AeroplaneCourse":
        """Return the course that leaves this one for a motion when that begins."""
        whole = spliced(self.motion, motion.start, np.diff(motion.knots), motion.coefficients)
        return AeroplaneCourse(self.flown, whole, reference, leaves)

    def lasting(self, until: float, able: Flying) -> "AeroplaneCourse":
        """Return the same course, with as many more full turns as it takes to fly until an instant."""
        motion = self.motion
        if motion.end >= until or self.lands or self.stands:
            return self
        (place,), (velocity,), (acceleration,) = motion.at([motion.end])
        side = LEFT if velocity[0] * acceleration[1] >= velocity[1] * acceleration[0] else RIGHT
        more = loiter(pose_of(place, velocity), side, until - motion.end, able)
        return replace(self, motion=spliced(motion, motion.end, *more))


def pose_of(place: Floats, velocity: Floats) -> Floats:
    """Return x, y, z, heading and rate of climb, (5,), from a place and a velocity, (3,) each."""
    return np.array([*place, math.atan2(velocity[1], velocity[0]), velocity[2]])


def poses_at(motion: Trajectory, instants: Floats) -> Floats:
    """Return x, y, z, heading and rate of climb at instants (n,) of a motion, or its nearest end, (n, 5)."""
    place, velocity, _ = motion.at(np.clip(instants, motion.start, motion.end))
    return np.column_stack([place, arctan2(velocity[:, 1], velocity[:, 0]), velocity[:, 2]])


def pose_at(motion: Trajectory, t: float) -> Floats:
    """Return the same at one instant, (5,)."""
    return poses_at(motion, np.array([t]))[0]


def timed(begin: float, durations: Floats, rows: Floats) -> Trajectory:
    """Return the motion that begins at an instant, of pieces (m,) seconds and (m, k, 3) metres."""
    return Trajectory(begin + np.append(0.0, np.cumsum(durations)), rows, form="dubins")


def part_of(motion: Trajectory, begin: float, end: float) -> Trajectory:
    """Return what is flown of a motion between two instants, with the stay before it begins."""
    return timed(begin, *followed(motion, begin, end))


def loiter(pose: Floats, side: int, seconds: float, able: Flying) -> tuple[Floats, Floats]:
    """Return the pieces of a circle to a side from a pose, which take so many seconds at least.

    Where the aeroplane climbs, the climb fades out first; whole turns follow that are level.
    """
    fades = abs(float(pose[4])) / (able.agility.rate * able.speed)  # metres
    turns = max(1, math.ceil((seconds * able.speed - fades) / (2.0 * math.pi * able.radius)))
    leg = turn(pose, side, 2.0 * math.pi * turns + fades / able.radius, 0.0, LEVEL, able.agility, able.speed)
    return flown_leg(leg, float(pose[4]), 0.0, able.agility, able.speed)
