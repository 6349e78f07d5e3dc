"""A leg of an aeroplane's way: a Dubins path seen from above, and one climb or descent between two levels.

The heights follow a slope that rises from 0 as ``3 u^2 - 2 u^3``, is held, and falls to 0 again; so the vertical
acceleration does not jump. Where a leg is too short for its climb, full turns are flown at its first or its last turn
(M. Owen, R. W. Beard, T. W. McLain, "Implementing Dubins Airplane Paths on Fixed-Wing UAVs", 2015: "high altitude").
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import SURFACE_DEPTH
from skyverse.space import box, ground, solids, tree
from skyverse.space.world import Space
from skyverse.trajectory.dubins import curvature, pose

_BRIEF = 1e-9
"""Metres of way, and of height, that are passed over: they would be lost in rounding."""
_TIGHT = 1e-3
"""Metres that an arc may seem nearer to an obstacle than it is."""
_ARC = math.pi / 12.0
"""The most that one polynomial turns: then it leaves its arc by 2e-12 radii, and its velocity by 1e-10 of it."""
DEGREE = 7
CLEAR, BLOCKED, SHUT, _UNSURE = range(4)


class Climb(NamedTuple):
    """A change of height: after `begin` metres of way a ramp of `ramp` metres, `hold` metres at `slope`, a ramp."""

    begin: float
    ramp: float
    hold: float
    slope: float


class Leg(NamedTuple):
    """From a pose by a Dubins word, whose three letters are a, b, c metres long, while climbing; level at both ends."""

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
def climb_length(rise: float, slope: float, bend: float) -> float:
    """Return the metres of way that a change of height takes at least, with a steepest slope and its greatest rate."""
    if abs(rise) <= _BRIEF:
        return 0.0
    ramp, hold = _steepest(abs(rise), slope, bend)
    return 2.0 * ramp + hold


@inner
def _steepest(rise: float, slope: float, bend: float) -> tuple[float, float]:
    slope = min(slope, math.sqrt(rise * bend / 1.5))
    ramp = 1.5 * slope / bend
    return ramp, max(0.0, rise / slope - ramp)


@inner
def climb_along(rise: float, length: float, slope: float, bend: float, profile: int) -> Climb:
    """Spread a change of height over a leg of a length that suffices: 0 all along, 1 at its beginning, 2 at its end."""
    if abs(rise) <= _BRIEF:
        return Climb(0.0, 0.0, 0.0, 0.0)
    up = abs(rise)
    if profile == 0:
        gentle = 2.0 * up / (length + math.sqrt(max(0.0, length * length - 6.0 * up / bend)))
        ramp = 1.5 * gentle / bend
        hold = max(0.0, length - 2.0 * ramp)
    else:
        ramp, hold = _steepest(up, slope, bend)
    begin = max(0.0, length - 2.0 * ramp - hold) if profile == 2 else 0.0
    return Climb(begin, ramp, hold, rise / (ramp + hold))


@inner
def _height(climb: Climb, s: float) -> tuple[float, float, float, float, float]:
    """Return height gained and its first four derivatives by the way, after s metres; at a knot, of what comes next."""
    s -= climb.begin
    ramp, hold, slope = climb.ramp, climb.hold, climb.slope
    if s < 0.0 or slope == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    if s >= 2.0 * ramp + hold:
        return slope * (ramp + hold), 0.0, 0.0, 0.0, 0.0
    if ramp <= s < ramp + hold:
        return slope * (0.5 * ramp + s - ramp), slope, 0.0, 0.0, 0.0
    rising = s < ramp
    u = s / ramp if rising else (2.0 * ramp + hold - s) / ramp  # the end is the beginning backwards
    way = 1.0 if rising else -1.0
    gained = slope * ramp * u * u * u * (1.0 - 0.5 * u)
    return (
        gained if rising else slope * (ramp + hold) - gained,
        slope * u * u * (3.0 - 2.0 * u),
        way * slope * 6.0 * u * (1.0 - u) / ramp,
        slope * (6.0 - 12.0 * u) / (ramp * ramp),
        -way * 12.0 * slope / (ramp * ramp * ramp),
    )


@inner
def place(leg: Leg, s: float) -> tuple[float, float, float, float]:
    """Return x, y, z and heading after s metres of way."""
    x, y, heading = pose(leg.x, leg.y, leg.heading, leg.word, leg.a, leg.b, leg.radius, s)
    return x, y, leg.z + _height(leg.climb, s)[0], heading


@inner
def _marks(leg: Leg) -> Floats:
    """Return the metres of way at which a leg's turns and climb begin and end, rising."""
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
        if mark > marks[count - 1] + _BRIEF:
            marks[count] = mark
            count += 1
    marks[count - 1] = length
    return marks[:count]


@inner
def _bend(leg: Leg, s: float) -> float:
    letter = 0 if s < leg.a else 1 if s < leg.a + leg.b else 2
    return curvature(leg.word, letter, leg.radius)


@inner
def leg_clear(space: Space, leg: Leg) -> int:
    """Tell whether a leg is safe: `CLEAR`, `BLOCKED`, or `SHUT`, blocked however it climbs.

    Each stretch is tested by its chord and how far it can leave it, and halved until that decides. An arc that comes
    within `_TIGHT` of an obstacle may be refused. What is quickly tested is tested first.
    """
    marks = _marks(leg)
    for first in (True, False):
        for k in range(len(marks) - 1):
            middle = 0.5 * (marks[k] + marks[k + 1])
            curved = abs(_bend(leg, middle))
            climbing = 1.5 * abs(leg.climb.slope) / leg.climb.ramp if _height(leg.climb, middle)[4] != 0.0 else 0.0
            straight = curved == 0.0 and climbing == 0.0
            if first and not straight:
                verdict = _stretch(space, leg, middle, middle, 0.0, 0.0)
            elif first == straight:
                verdict = _halved(space, leg, marks[k], marks[k + 1], curved, climbing)
            else:
                continue
            if verdict != CLEAR:
                return verdict
    return CLEAR


@inner
def _halved(space: Space, leg: Leg, begin: float, end: float, curved: float, climbing: float) -> int:
    """Judge a stretch of constant curvature."""
    ends = np.empty(64)
    ends[0] = end
    waiting = 1
    while waiting:
        end = ends[waiting - 1]
        verdict = _stretch(space, leg, begin, end, curved, climbing)
        if verdict == CLEAR:
            begin = end
            waiting -= 1
        elif verdict == _UNSURE and waiting < len(ends):
            ends[waiting] = 0.5 * (begin + end)
            waiting += 1
        else:
            return verdict
    return CLEAR


@inner
def _stretch(space: Space, leg: Leg, begin: float, end: float, curved: float, climbing: float) -> int:
    """Judge a stretch at once, if it can be."""
    x, y, z, heading = place(leg, begin)
    x1, y1, z1, heading1 = place(leg, end)
    a, b = np.array([x, y, z]), np.array([x1, y1, z1])
    square = 0.125 * (end - begin) ** 2
    aside, off = square * curved, square * climbing
    low, high = np.minimum(a, b), np.maximum(a, b)  # z is monotone; so are x and y unless it turns through their axis
    wide = abs(heading1 - heading) >= 0.5 * math.pi
    if curved and (wide or math.cos(heading) * math.cos(heading1) <= 0.0):
        low[0] -= aside
        high[0] += aside
    if curved and (wide or math.sin(heading) * math.sin(heading1) <= 0.0):
        low[1] -= aside
        high[1] += aside
    for axis in range(3):
        least, most = space.low[axis] - SURFACE_DEPTH, space.high[axis] + SURFACE_DEPTH
        if not (least <= a[axis] <= most and least <= b[axis] <= most):
            return SHUT if axis < 2 else BLOCKED
    refused = _UNSURE if max(aside, off) > _TIGHT else BLOCKED
    for axis in range(2):
        if low[axis] < space.low[axis] - SURFACE_DEPTH or high[axis] > space.high[axis] + SURFACE_DEPTH:
            return refused
    verdict = CLEAR
    swollen = np.empty((1, 6))
    for i in tree.touching(space.tree, space.boxes, space.clearance - SURFACE_DEPTH, low, high):
        for axis in range(3):
            extra = aside if axis < 2 else off
            swollen[0, axis] = space.boxes[i, axis] - extra
            swollen[0, axis + 3] = space.boxes[i, axis + 3] + extra
        if box.meets(swollen, 0, space.clearance, box.ray(a, b)):
            verdict = refused
            if refused == BLOCKED or box.holds(space.boxes, i, space.clearance, x1, y1, z1):
                return SHUT if _at_all_heights(space, leg, i) else BLOCKED
    if verdict == CLEAR and _crosses_shapes(space, math.sqrt(aside * aside + off * off), a, b):
        return BLOCKED if _crosses_shapes(space, 0.0, b, b) else refused
    return verdict


@inner
def _crosses_shapes(space: Space, off: float, a: Floats, b: Floats) -> bool:
    """Tell whether something other than a box comes nearer to a chord than is safe so many metres off it."""
    return solids.crossed(space.solids, space.clearance + off, a, b) >= 0 or ground.crossed(
        space.ground, space.clearance + space.ground.extra, off, a, b
    )


@inner
def _at_all_heights(space: Space, leg: Leg, i: int) -> bool:
    top = leg.z + leg.climb.slope * (leg.climb.ramp + leg.climb.hold)
    growth = space.clearance - SURFACE_DEPTH
    return space.boxes[i, 2] - growth < min(leg.z, top) and max(leg.z, top) < space.boxes[i, 5] + growth


@kernel
def leg_pieces(leg: Leg, speed: float) -> tuple[Floats, Floats]:
    """Return durations (n,) and power-basis coefficients (n, 8, 3) of a leg flown at a horizontal speed.

    Each arc is its Taylor polynomial about its middle, about its beginning written out.
    """
    marks = _marks(leg)
    counts = np.empty(len(marks) - 1, np.int64)
    for k in range(len(counts)):
        bend = abs(_bend(leg, 0.5 * (marks[k] + marks[k + 1])))
        counts[k] = max(1, math.ceil(bend * (marks[k + 1] - marks[k]) / _ARC))
    durations = np.empty(counts.sum())
    pieces = np.zeros((len(durations), DEGREE + 1, 3))
    at = 0
    for k in range(len(counts)):
        span = (marks[k + 1] - marks[k]) / counts[k]
        for part in range(counts[k]):
            half = 0.5 * span
            middle = marks[k] + (part + 0.5) * span
            x, y, _, heading = place(leg, middle)
            bend = _bend(leg, middle)
            about = np.zeros((DEGREE + 1, 3))  # by metres from the middle
            about[0, 0], about[0, 1] = x, y
            scale = 1.0
            for j in range(1, DEGREE + 1):
                scale = 1.0 / j if j == 1 else scale * bend / j
                about[j, 0] = scale * math.cos(heading + 0.5 * math.pi * (j - 1))
                about[j, 1] = scale * math.sin(heading + 0.5 * math.pi * (j - 1))
            gained = _height(leg.climb, middle)
            factor = 1.0
            for j in range(5):
                about[j, 2] = gained[j] / factor
                factor *= j + 1
            about[0, 2] += leg.z
            for low in range(DEGREE):  # Horner's shift to the beginning
                for j in range(DEGREE - 1, low - 1, -1):
                    about[j] -= half * about[j + 1]
            power = 1.0
            for j in range(DEGREE + 1):
                pieces[at, j] = about[j] * power
                power *= speed
            durations[at] = span / speed
            at += 1
    return durations, pieces
