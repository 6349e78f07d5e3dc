"""Whether a leg of an aeroplane's way is clear of all obstacles."""

import math

import numpy as np

from skyverse.numerics.kernel import inner
from skyverse.numerics.tolerances import ARC_DEVIATION, SURFACE_DEPTH
from skyverse.space import box
from skyverse.space.obstacles import Space, boxes_near, shapes_crossed
from skyverse.trajectory.dubins_leg import DubinsLeg, height_gained, leg_curvature, leg_marks, pose_on_leg

CLEAR, BLOCKED, BLOCKED_AT_ANY_HEIGHT, UNDECIDED = range(4)
MAX_DEPTH = 64
"""How often a stretch is halved at most, each time one of the halves again."""


@inner
def leg_clear(space: Space, leg: DubinsLeg) -> int:
    """Tell whether a leg is clear: `CLEAR`, `BLOCKED`, or `BLOCKED_AT_ANY_HEIGHT`, however it climbs.

    Each stretch of constant curvature is tested by its chord and by how far it can leave the chord, and halved until
    that decides. An arc that comes within `ARC_DEVIATION` of an obstacle may count as blocked. Stretches whose test is
    quick are tested first.
    """
    marks = leg_marks(leg)
    for first in (True, False):
        for k in range(len(marks) - 1):
            middle = 0.5 * (marks[k] + marks[k + 1])
            curved = abs(leg_curvature(leg, middle))
            on_ramp = height_gained(leg.climb, middle)[4] != 0.0
            climbing = 1.5 * abs(leg.climb.slope) / leg.climb.ramp if on_ramp else 0.0
            straight = curved == 0.0 and climbing == 0.0
            if first and not straight:
                verdict = _judge_at_once(space, leg, middle, middle, 0.0, 0.0)
            elif first == straight:
                verdict = _judge(space, leg, marks[k], marks[k + 1], curved, climbing)
            else:
                continue
            if verdict != CLEAR:
                return verdict
    return CLEAR


@inner
def _judge(space: Space, leg: DubinsLeg, begin: float, end: float, curved: float, climbing: float) -> int:
    """Judge a stretch of constant curvature, halving it where it is undecided."""
    ends = np.empty(MAX_DEPTH)
    ends[0] = end
    waiting = 1
    while waiting:
        end = ends[waiting - 1]
        verdict = _judge_at_once(space, leg, begin, end, curved, climbing)
        if verdict == CLEAR:
            begin = end
            waiting -= 1
        elif verdict == UNDECIDED and waiting < len(ends):
            ends[waiting] = 0.5 * (begin + end)
            waiting += 1
        else:
            return verdict
    return CLEAR


@inner
def _judge_at_once(space: Space, leg: DubinsLeg, begin: float, end: float, curved: float, climbing: float) -> int:
    """Judge a stretch by its chord, and return `UNDECIDED` where that does not decide.

    Parameters
    ----------
    space
        With the obstacles.
    leg
        Of which it is a stretch.
    begin, end
        Metres of way.
    curved, climbing
        Bounds on its curvature seen from above and on the rate of its slope, 1/m.
    """
    x, y, z, heading = pose_on_leg(leg, begin)
    x1, y1, z1, heading1 = pose_on_leg(leg, end)
    a, b = np.array([x, y, z]), np.array([x1, y1, z1])
    square = 0.125 * (end - begin) ** 2
    aside, off = square * curved, square * climbing
    low, high = np.minimum(a, b), np.maximum(a, b)  # z is monotone; so are x and y, but for turns through their axis
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
            return BLOCKED_AT_ANY_HEIGHT if axis < 2 else BLOCKED
    refused = UNDECIDED if max(aside, off) > ARC_DEVIATION else BLOCKED
    for axis in range(2):
        if low[axis] < space.low[axis] - SURFACE_DEPTH or high[axis] > space.high[axis] + SURFACE_DEPTH:
            return refused
    verdict = CLEAR
    swollen = np.empty((1, 6))
    for i in boxes_near(space, -SURFACE_DEPTH, low, high):
        for axis in range(3):
            extra = aside if axis < 2 else off
            swollen[0, axis] = space.boxes[i, axis] - extra
            swollen[0, axis + 3] = space.boxes[i, axis + 3] + extra
        if box.meets(swollen, 0, space.clearance, box.ray(a, b)):
            verdict = refused
            if refused == BLOCKED or box.holds(space.boxes, i, space.clearance, x1, y1, z1):
                return BLOCKED_AT_ANY_HEIGHT if _at_all_heights(space, leg, i) else BLOCKED
    if verdict == CLEAR and shapes_crossed(space, 0.0, math.sqrt(aside * aside + off * off), a, b):
        return BLOCKED if shapes_crossed(space, 0.0, 0.0, b, b) else refused
    return verdict


@inner
def _at_all_heights(space: Space, leg: DubinsLeg, i: int) -> bool:
    """Tell whether box i blocks all heights between the two levels of a leg."""
    top = leg.z + leg.climb.slope * (leg.climb.ramp + leg.climb.hold)
    growth = space.clearance - SURFACE_DEPTH
    return space.boxes[i, 2] - growth < min(leg.z, top) and max(leg.z, top) < space.boxes[i, 5] + growth
