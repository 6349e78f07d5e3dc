"""A leg of an aeroplane's way: a Dubins path seen from above, and one climb or descent between two levels.

Where a leg is too short for its climb, full turns are flown at its first or its last turn (M. Owen, R. W. Beard,
T. W. McLain, "Implementing Dubins Airplane Paths on Fixed-Wing UAVs", 2015: "high altitude").

Along a ramp of r metres the slope of a climb rises as ``slope (3 u^2 - 2 u^3)`` with ``u = s / r`` after s metres, so
that the vertical acceleration does not jump; it is held, and falls to 0 again. All lengths are metres of way seen from
above.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import MIN_FLOWN
from skyverse.trajectory.dubins import curvature, pose

ALL_ALONG, AT_BEGINNING, AT_END = range(3)
"""Where along a leg its climb is flown; these are the profiles of a climb."""


class Climb(NamedTuple):
    """A change of height, level before and after.

    Attributes
    ----------
    begin
        The level way before it, metres.
    ramp
        The length of each of its two ramps, metres.
    hold
        The length at constant slope between the ramps, metres.
    slope
        Metres of height for each metre of way, negative for a descent.
    """

    begin: float
    ramp: float
    hold: float
    slope: float


@inner
def climb_length(rise: float, slope: float, rate: float) -> float:
    """Return the metres of way that a change of height takes at least.

    Parameters
    ----------
    rise
        The change of height, metres.
    slope
        The steepest slope.
    rate
        The largest change of the slope for each metre of way, 1/m.
    """
    if abs(rise) <= MIN_FLOWN:
        return 0.0
    ramp, hold = _steepest(abs(rise), slope, rate)
    return 2.0 * ramp + hold


@inner
def _steepest(rise: float, slope: float, rate: float) -> tuple[float, float]:
    """Return ramp and hold of the shortest climb, metres; see `climb_length`."""
    slope = min(slope, math.sqrt(rise * rate / 1.5))
    ramp = 1.5 * slope / rate
    return ramp, max(0.0, rise / slope - ramp)


@inner
def climb_along(rise: float, length: float, slope: float, rate: float, profile: int) -> Climb:
    """Return a change of height within a leg that is long enough for it, by a profile; see `climb_length`."""
    if abs(rise) <= MIN_FLOWN:
        return Climb(0.0, 0.0, 0.0, 0.0)
    up = abs(rise)
    if profile == ALL_ALONG:
        gentle = 2.0 * up / (length + math.sqrt(max(0.0, length * length - 6.0 * up / rate)))
        ramp = 1.5 * gentle / rate
        hold = max(0.0, length - 2.0 * ramp)
    else:
        ramp, hold = _steepest(up, slope, rate)
    begin = max(0.0, length - 2.0 * ramp - hold) if profile == AT_END else 0.0
    return Climb(begin, ramp, hold, rise / (ramp + hold))


@inner
def height_gained(climb: Climb, s: float) -> tuple[float, float, float, float, float]:
    """Return the height gained after s metres of way, and its first four derivatives by the way.

    Where a derivative jumps, its value is the one just after.
    """
    s -= climb.begin
    ramp, hold, slope = climb.ramp, climb.hold, climb.slope
    if s < 0.0 or slope == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    if s >= 2.0 * ramp + hold:
        return slope * (ramp + hold), 0.0, 0.0, 0.0, 0.0
    if ramp <= s < ramp + hold:
        return slope * (0.5 * ramp + s - ramp), slope, 0.0, 0.0, 0.0
    rising = s < ramp
    u = s / ramp if rising else (2.0 * ramp + hold - s) / ramp  # the second ramp is the first one backwards
    direction = 1.0 if rising else -1.0
    gained = slope * ramp * u * u * u * (1.0 - 0.5 * u)
    return (
        gained if rising else slope * (ramp + hold) - gained,
        slope * u * u * (3.0 - 2.0 * u),
        direction * slope * 6.0 * u * (1.0 - u) / ramp,
        slope * (6.0 - 12.0 * u) / (ramp * ramp),
        -direction * 12.0 * slope / (ramp * ramp * ramp),
    )


MAX_ARC = math.pi / 12.0
"""Radians that one polynomial turns at most: it leaves its arc by 2e-12 radii, and its velocity differs by 1e-10."""
LEG_DEGREE = 7
"""Of the polynomials."""


class DubinsLeg(NamedTuple):
    """A Dubins path with a climb; level at both ends.

    Attributes
    ----------
    x, y, z, heading
        The pose at its beginning, metres and radians.
    word
        The number of its Dubins word.
    a, b, c
        The lengths of the word's three letters, metres.
    radius
        Of its turns, metres.
    climb
        Along it.
    """

    x: float
    y: float
    z: float
    heading: float
    word: int
    a: float
    b: float
    c: float
    radius: float
    climb: Climb


@inner
def pose_on_leg(leg: DubinsLeg, s: float) -> tuple[float, float, float, float]:
    """Return x, y, z and heading after s metres of way."""
    x, y, heading = pose(leg.x, leg.y, leg.heading, leg.word, leg.a, leg.b, leg.radius, s)
    return x, y, leg.z + height_gained(leg.climb, s)[0], heading


@inner
def leg_marks(leg: DubinsLeg) -> Floats:
    """Return the metres of way, in rising order, at which a leg's letters and the parts of its climb begin and end."""
    climb = leg.climb
    marks = np.empty(8)
    length = leg.a + leg.b + leg.c
    marks[0], marks[1], marks[2], marks[3] = 0.0, leg.a, leg.a + leg.b, length
    marks[4] = climb.begin
    marks[5] = climb.begin + climb.ramp
    marks[6] = marks[5] + climb.hold
    marks[7] = marks[6] + climb.ramp
    marks = np.sort(np.minimum(marks, length))
    count = 1
    for mark in marks[1:]:
        if mark > marks[count - 1] + MIN_FLOWN:
            marks[count] = mark
            count += 1
    marks[count - 1] = length
    return marks[:count]


@inner
def leg_curvature(leg: DubinsLeg, s: float) -> float:
    """Return the signed curvature seen from above after s metres of way, 1/m, positive to the left."""
    letter = 0 if s < leg.a else 1 if s < leg.a + leg.b else 2
    return curvature(leg.word, letter, leg.radius)


@kernel
def leg_pieces(leg: DubinsLeg, speed: float, most: float) -> tuple[Floats, Floats]:
    """Return durations (n,) and power-basis coefficients (n, 8, 3) of a leg flown at a horizontal speed.

    Each arc is replaced by Taylor polynomials about their middles, which turn by `most` radians at most, and are then
    shifted to the beginning of the piece.
    """
    marks = leg_marks(leg)
    counts = np.empty(len(marks) - 1, np.int64)
    for k in range(len(counts)):
        bend = abs(leg_curvature(leg, 0.5 * (marks[k] + marks[k + 1])))
        counts[k] = max(1, math.ceil(bend * (marks[k + 1] - marks[k]) / most))
    durations = np.empty(counts.sum())
    pieces = np.zeros((len(durations), LEG_DEGREE + 1, 3))
    at = 0
    for k in range(len(counts)):
        span = (marks[k + 1] - marks[k]) / counts[k]
        for part in range(counts[k]):
            half = 0.5 * span
            middle = marks[k] + (part + 0.5) * span
            x, y, _, heading = pose_on_leg(leg, middle)
            bend = leg_curvature(leg, middle)
            about = np.zeros((LEG_DEGREE + 1, 3))  # coefficients by powers of the metres of way from the middle
            about[0, 0], about[0, 1] = x, y
            scale = 1.0
            for j in range(1, LEG_DEGREE + 1):
                scale = 1.0 / j if j == 1 else scale * bend / j
                about[j, 0] = scale * math.cos(heading + 0.5 * math.pi * (j - 1))
                about[j, 1] = scale * math.sin(heading + 0.5 * math.pi * (j - 1))
            gained = height_gained(leg.climb, middle)
            factor = 1.0
            for j in range(5):
                about[j, 2] = gained[j] / factor
                factor *= j + 1
            about[0, 2] += leg.z
            for low in range(LEG_DEGREE):  # Horner's scheme shifts the polynomial to the beginning
                for j in range(LEG_DEGREE - 1, low - 1, -1):
                    about[j] -= half * about[j + 1]
            power = 1.0
            for j in range(LEG_DEGREE + 1):
                pieces[at, j] = about[j] * power
                power *= speed
            durations[at] = span / speed
            at += 1
    return durations, pieces
