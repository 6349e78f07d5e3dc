"""Legs of an aeroplane in flight, which climbs where they begin or where they end.

A leg's climb itself is level before and after (see `trajectory.dubins_leg`). Where the aeroplane climbs at w m/s at the
beginning, its height differs at first by ``-a (T - t)^2 / 2``, with ``T = |w| / |a|`` and the largest vertical
acceleration a, of the sign of w; the end is the beginning backwards. The leg's own climb lies in between, so that
slopes do not add up.

What an aeroplane is flying: along a reference, and from some instant on a loiter.

The curves that an aeroplane may follow from where it is: back to what was planned, and away.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.course import AnyCourse, part_of, spliced
from skyverse.live.course import timed as timed_as
from skyverse.model.arrays import arctan2
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import LEG_END, MIN_FLOWN, MIN_PIECE
from skyverse.space.agility import Agility
from skyverse.trajectory.dubins import all_words
from skyverse.trajectory.dubins import pose as pose_after
from skyverse.trajectory.dubins_leg import Climb, DubinsLeg, climb_along, climb_length, leg_pieces

FINEST_ARC = math.pi / 18.0
"""Radians that one polynomial turns at most: in half an hour of circles velocities jump by less than is let pass."""
LEVEL, RISING, FALLING = 0, 1, -1
"""How a turn and the straight line after it climb."""
LEFT, RIGHT = 0, 1
"""Sides to which an aeroplane turns; these are the words LSL and RSR."""


@inner
def _levelling(rate: float, agility: Agility, speed: float) -> tuple[float, float]:
    """Return the metres of way in which a rate of climb, m/s, fades out, and the height that is gained, metres."""
    vertical = agility.rate * speed * speed
    seconds = abs(rate) / vertical
    return seconds * speed, 0.5 * rate * seconds


@kernel
def leg_between(start: Floats, end: Floats, agility: Agility, speed: float, rank: int) -> DubinsLeg:
    """Return the leg between two poses, (5,) each: x, y, z, heading, and the rate of climb, m/s.

    `rank` counts the words from the shortest one on; without a word the lengths of the letters are infinite. Where the
    way is too short for the climb, full turns come first.
    """
    radius = agility.radii[0]
    words = all_words(start[0], start[1], start[3], end[0], end[1], end[3], radius)
    word = int(np.argsort(words.sum(axis=1))[rank])
    a, b, c = words[word, 0], words[word, 1], words[word, 2]
    first, gained = _levelling(start[4], agility, speed)
    last, missing = _levelling(end[4], agility, speed)
    low = start[2] + gained
    rise = end[2] - missing - low
    plain = a + b + c
    if plain == math.inf:
        return DubinsLeg(start[0], start[1], low, start[3], word, a, b, c, radius, Climb(0.0, 0.0, 0.0, 0.0))
    needed = climb_length(rise, agility.slope, agility.rate) + first + last
    around = 2.0 * math.pi * radius
    a += max(0.0, math.ceil((needed - plain) / around)) * around
    length = a + b + c - first - last
    climb = climb_along(rise, length, agility.slope, agility.rate, 0)
    if climb.slope == 0.0:
        climb = Climb(first, 0.0, length, 0.0)
    else:
        climb = Climb(first, climb.ramp, climb.hold, climb.slope)
    return DubinsLeg(start[0], start[1], low, start[3], word, a, b, c, radius, climb)


@kernel
def turn(
    start: Floats, side: int, angle: float, straight: float, climbs: int, agility: Agility, speed: float
) -> DubinsLeg:
    """Return the leg that turns by an angle, radians, to a side, and then leads straight on for some metres.

    `start` is a pose as in `leg_between`. The leg is level at its end; it rises or falls in between as much as it can.
    """
    radius = agility.radii[0]
    first, gained = _levelling(start[4], agility, speed)
    left = radius * angle + straight - first
    climb = Climb(first, 0.0, max(left, 0.0), 0.0)
    ramp = min(1.5 * agility.slope / agility.rate, 0.5 * left)
    if climbs != LEVEL and ramp > MIN_FLOWN:
        climb = Climb(first, ramp, left - 2.0 * ramp, climbs * min(agility.slope, ramp * agility.rate / 1.5))
    return DubinsLeg(
        start[0], start[1], start[2] + gained, start[3], side, radius * angle, straight, 0.0, radius, climb
    )


@kernel
def flown_leg(leg: DubinsLeg, first: float, last: float, agility: Agility, speed: float) -> tuple[Floats, Floats]:
    """Return durations (n,) and coefficients (n, 8, 3) of a leg, with its rates of climb at both ends, m/s."""
    durations, rows = leg_pieces(leg, speed, FINEST_ARC)
    whole, vertical = durations.sum(), agility.rate * speed * speed
    fades, begins = abs(first) / vertical, whole - abs(last) / vertical
    now = 0.0
    for k in range(len(durations)):
        middle = now + 0.5 * durations[k]
        if middle < fades:
            half, since = -0.5 * math.copysign(vertical, first), now - fades
        elif middle > begins:
            half, since = 0.5 * math.copysign(vertical, last), now - begins
        else:
            half, since = 0.0, 0.0
        rows[k, 0, 2] += half * since * since
        rows[k, 1, 2] += 2.0 * half * since
        rows[k, 2, 2] += half
        now += durations[k]
    return durations, rows


@kernel
def seconds_to(poses: Floats, ahead: Floats, agility: Agility, speed: float) -> Floats:
    """Return about how many seconds an aeroplane takes at least from poses to others, (m, n).

    Parameters
    ----------
    poses, ahead
        (m, 5) and (n, 5): x, y, z, heading and rate of climb each.
    """
    seconds = np.empty((len(poses), len(ahead)))
    for i in range(len(poses)):
        for k in range(len(ahead)):
            a, b = poses[i], ahead[k]
            words = all_words(a[0], a[1], a[3], b[0], b[1], b[3], agility.radii[0])
            way = math.inf
            for word in range(6):
                way = min(way, words[word, 0] + words[word, 1] + words[word, 2])
            needed = climb_length(b[2] - a[2], agility.slope, agility.rate)
            turns = max(0.0, math.ceil((needed - way) / (2.0 * math.pi * agility.radii[0])))
            seconds[i, k] = (way + turns * 2.0 * math.pi * agility.radii[0]) / speed
    return seconds


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
class AeroplaneCourse(AnyCourse):
    """What an aeroplane is flying, to the end of a full turn, or of the reference; before its departure it stands.

    Attributes
    ----------
    reference, leaves
        What it follows, ``None`` if nothing, and the instant at which it leaves that and begins to loiter; infinite if
        it stays where it is.
    """

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

    def joined(self, motion: Trajectory, reference: Reference | None, leaves: float) -> "AeroplaneCourse":
        """Return the course that leaves this one for a motion when that begins."""
        return AeroplaneCourse(self.flown, spliced(self.motion, motion), reference, leaves)

    def lasting(self, until: float, able: Flying) -> "AeroplaneCourse":
        """Return the same course, with as many more full turns as it takes to fly until an instant."""
        motion = self.motion
        if motion.end >= until or self.lands or self.stands:
            return self
        (place,), (velocity,), (acceleration,) = motion.at([motion.end])
        side = LEFT if velocity[0] * acceleration[1] >= velocity[1] * acceleration[0] else RIGHT
        more = loiter(motion.end, pose_of(place, velocity), side, until - motion.end, able)
        return replace(self, motion=spliced(motion, more))


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
    return timed_as(begin, durations, rows, "dubins")


def loiter(begin: float, pose: Floats, side: int, seconds: float, able: Flying) -> Trajectory:
    """Return the circle to a side from a pose at an instant, which takes so many seconds at least.

    Where the aeroplane climbs, the climb fades out first; whole turns follow that are level.
    """
    fades = abs(float(pose[4])) / (able.agility.rate * able.speed)  # metres
    turns = max(1, math.ceil((seconds * able.speed - fades) / (2.0 * math.pi * able.radius)))
    leg = turn(pose, side, 2.0 * math.pi * turns + fades / able.radius, 0.0, LEVEL, able.agility, able.speed)
    return leg_flown(begin, leg, pose, 0.0, able)


def leg_flown(begin: float, leg: DubinsLeg, pose: Floats, climb: float, able: Flying) -> Trajectory:
    """Return the motion along a leg from a pose (5,) at an instant, with the rate of climb at its end, m/s."""
    durations, rows = flown_leg(leg, float(pose[4]), climb, able.agility, able.speed)
    return timed(begin, durations, rows)


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
    rest = part_of(ahead.motion, instant, ahead.motion.end)
    goes_on = len(rest.coefficients) > 0
    off = (float(pose[3] - to[3]) + math.pi) % (2.0 * math.pi) - math.pi
    if max(np.abs(pose - to)[:3].max(), abs(off) * able.radius) <= LEG_END:  # it is there
        return Reference(rest.retimed(begin), begin, begin - instant) if goes_on and not rank else None
    leg = leg_between(pose, to, able.agility, able.speed, rank)
    if leg.a + leg.b + leg.c == math.inf:
        return None
    motion = leg_flown(begin, leg, pose, float(to[4]), able)
    joins = motion.end
    return Reference(spliced(motion, rest.retimed(joins)) if goes_on else motion, joins, joins - instant)


def turns_away(pose: Floats, able: Flying) -> Iterator[DubinsLeg]:
    """Yield legs from a pose (5,) that turn, go straight on, and rise or fall meanwhile."""
    for angle, side, straight, climbs in product(ANGLES, (LEFT, RIGHT), STRAIGHTS, (LEVEL, RISING, FALLING)):
        if angle > 0.0 or (straight > 0.0 and side == LEFT):
            yield turn(pose, side, angle, straight * able.radius, climbs, able.agility, able.speed)


def away_along(leg: DubinsLeg, begin: float, pose: Floats, able: Flying) -> Reference:
    """Return the reference from a pose (5,) at an instant along a leg of `turns_away`."""
    return Reference(leg_flown(begin, leg, pose, 0.0, able))


def end_of(leg: DubinsLeg) -> Floats:
    """Return about the pose (5,) in which a leg of `turns_away` ends, which is level."""
    x, y, heading = pose_after(leg.x, leg.y, leg.heading, leg.word, leg.a, leg.b, leg.radius, leg.a + leg.b)
    return np.array([x, y, leg.z + leg.climb.slope * (leg.climb.ramp + leg.climb.hold), heading, 0.0])
