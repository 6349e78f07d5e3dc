"""Legs of an aeroplane in flight, which climbs where they begin or where they end.

A leg's climb itself is level before and after (see `trajectory.climb`). Where the aeroplane climbs at w m/s at the
beginning, its height differs at first by ``-a (T - t)^2 / 2``, with ``T = |w| / |a|`` and the largest vertical
acceleration a, of the sign of w; the end is the beginning backwards. The leg's own climb lies in between, so that
slopes do not add up.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import MIN_FLOWN
from skyverse.trajectory.climb import Climb, climb_along, climb_length
from skyverse.trajectory.dubins import all_words
from skyverse.trajectory.dubins_leg import DubinsLeg, leg_pieces
from skyverse.trajectory.pose_search import Agility

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
