"""When a motion first comes too near to movers, of how much of what they may do it is clear, and how long legs are not.

A motion is followed in steps in which the distance that is left from a mover cannot be used up, since both have a top
speed; so what is passed over is proven clear. Where these would be too short, a longer step is taken, and what it
passes over counts as a contact unless the distances at both of its ends show that it is none.

A flight along straight legs is a guess by planners of what will be flown: it is at rest at both ends, and changes its
speed as fast as its acceleration allows. Where it turns by an angle A it is no faster than lets it turn within r
metres before and after the bend, half of the shorter leg but at most `REACH`: its velocity v changes by 2 v sin(A/2)
within 2 r / v seconds, so that v^2 = a r / sin(A/2).
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import by_reference, inner_query, kernel
from skyverse.numerics.norm import norm
from skyverse.numerics.tolerances import MOVER_MARGIN, SHORTEST_STEP
from skyverse.space.timed_shapes import MovingShapes, gap_at, gap_in_doubts

LEAST_STEP = 1e-3
"""Seconds by which a flight is followed at least: its time in contact is exact to this at each beginning and end."""
REACH = 2.0
"""Metres from a bend within which a flight turns at most."""


@by_reference
class FlownLegs(NamedTuple):
    """Memory for the straight legs that are flown along a path.

    Attributes
    ----------
    corners, lengths
        (n, 3) metres: where the flight turns, with its ends; and (n,) metres: the leg that leads there.
    speeds, instants
        (n,) m/s and seconds after the departure, at each of them.
    place, moved
        (3,) metres: places of the UAV and of a mover.
    """

    corners: Floats
    lengths: Floats
    speeds: Floats
    instants: Floats
    place: Floats
    moved: Floats


def flown_legs(capacity: int) -> FlownLegs:
    """Return memory for legs between at most so many corners."""
    lengths, speeds, instants = np.empty((3, capacity))
    return FlownLegs(np.empty((capacity, 3)), lengths, speeds, instants, np.empty(3), np.empty(3))


@inner_query
def seconds_in_contact(
    shapes: MovingShapes, legs: FlownLegs, count: int, speed: float, acceleration: float, departs: float, stays: float
) -> float:
    """Return for how many seconds a flight is too near to movers, added up over them.

    Parameters
    ----------
    shapes
        The movers.
    legs, count
        The legs, of which the corners are given, no two in a row at one place, and how many corners they have.
    speed, acceleration
        That the flight does not exceed, m/s and m/s^2.
    departs
        When it departs, seconds.
    stays
        Seconds for which the UAV must stay clear where it has arrived.
    """
    _schedule(legs, count, speed, acceleration)
    seconds = legs.instants[count - 1]
    total = 0.0
    for m in range(len(shapes.kind)):
        now, end = max(departs, shapes.active[m, 0]), min(departs + seconds + stays, shapes.active[m, 1])
        k = 0
        while now < end:
            while k < count - 1 and legs.instants[k + 1] <= now - departs:
                k += 1
            _write_place(legs, k, count, now - departs - legs.instants[k], speed, acceleration)
            gap = gap_at(shapes, m, now, legs.place, legs.moved) - MOVER_MARGIN
            rate = shapes.rate[m] + (speed if k < count - 1 else 0.0)
            after = end
            if abs(gap) < rate * (end - now):
                after = min(now + max(abs(gap) / rate, LEAST_STEP), end)
            if gap < 0.0:
                total += after - now
            now = after
    return total


@inner_query
def _schedule(legs: FlownLegs, count: int, speed: float, acceleration: float) -> None:
    """Set lengths, speeds and instants of legs from their corners."""
    corners, lengths, speeds, instants = legs.corners, legs.lengths, legs.speeds, legs.instants
    lengths[0] = speeds[0] = instants[0] = speeds[count - 1] = 0.0
    for i in range(1, count):
        a, b = corners[i - 1], corners[i]
        lengths[i] = norm(b[0] - a[0], b[1] - a[1], b[2] - a[2])
    for i in range(1, count - 1):
        a, b, c = corners[i - 1], corners[i], corners[i + 1]
        before, after = lengths[i], lengths[i + 1]
        half = 0.5 * norm(  # sin(A/2), of unit vectors along both legs
            (c[0] - b[0]) / after - (b[0] - a[0]) / before,
            (c[1] - b[1]) / after - (b[1] - a[1]) / before,
            (c[2] - b[2]) / after - (b[2] - a[2]) / before,
        )
        reach = min(0.5 * min(before, after), REACH)
        speeds[i] = speed if acceleration * reach >= half * speed * speed else math.sqrt(acceleration * reach / half)
    for i in range(1, count):
        speeds[i] = min(speeds[i], math.sqrt(speeds[i - 1] ** 2 + 2.0 * acceleration * lengths[i]))
    for i in range(count - 2, -1, -1):
        speeds[i] = min(speeds[i], math.sqrt(speeds[i + 1] ** 2 + 2.0 * acceleration * lengths[i + 1]))
    for i in range(1, count):
        begin, end = speeds[i - 1], speeds[i]
        peak = _peak(begin, end, lengths[i], speed, acceleration)
        ramps = (2.0 * peak * peak - begin * begin - end * end) / (2.0 * acceleration)
        instants[i] = instants[i - 1] + (2.0 * peak - begin - end) / acceleration + (lengths[i] - ramps) / peak


@inner_query
def _peak(begin: float, end: float, length: float, speed: float, acceleration: float) -> float:
    """Return the largest speed on a leg, m/s, from the speeds at its beginning and its end."""
    return min(speed, math.sqrt(acceleration * length + 0.5 * (begin * begin + end * end)))


@inner_query
def _write_place(legs: FlownLegs, k: int, count: int, t: float, speed: float, acceleration: float) -> None:
    """Write where a flight is t seconds after it has passed corner k."""
    share, ahead = 0.0, min(k + 1, count - 1)
    if ahead > k:
        begin, end, length = legs.speeds[k], legs.speeds[ahead], legs.lengths[ahead]
        peak = _peak(begin, end, length, speed, acceleration)
        left = legs.instants[ahead] - legs.instants[k] - t
        if left < (peak - end) / acceleration:
            share = 1.0 - left * (end + 0.5 * acceleration * left) / length
        else:
            ramp = min(t, (peak - begin) / acceleration)
            share = (ramp * (begin + 0.5 * acceleration * ramp) + peak * (t - ramp)) / length
    for axis in range(3):
        a, b = legs.corners[k, axis], legs.corners[ahead, axis]
        legs.place[axis] = a + min(max(share, 0.0), 1.0) * (b - a)


SAMPLE = 0.05
"""Seconds between the instants at which it is looked at how near to movers a motion is."""
MOST_SAMPLES = 400
"""How many such instants there are at most."""


@inner_query
def _place(knots: Floats, rows: Floats, k: int, t: float, out: Floats) -> int:
    """Write the position at an instant, from piece k on, (3,) metres; return the piece."""
    while k < len(rows) - 1 and knots[k + 1] <= t:
        k += 1
    local = min(max(t, knots[0]), knots[len(rows)]) - knots[k]
    for axis in range(3):
        value = 0.0
        for j in range(rows.shape[1] - 1, -1, -1):
            value = value * local + rows[k, j, axis]
        out[axis] = value
    return k


@kernel
def first_contact(
    shapes: MovingShapes, knots: Floats, rows: Floats, speed: float, begin: float, until: float
) -> tuple[int, float]:
    """Return the mover that a motion first comes too near to, and the instant; -1 and infinity if there is none.

    Parameters
    ----------
    shapes
        The movers, n of them.
    knots, rows
        (m + 1,) seconds and (m, degree + 1, 3) metres, as a trajectory has them; the UAV stays where it ends.
    speed
        That the motion nowhere exceeds, m/s.
    begin, until
        Seconds between which it is looked for.
    """
    place, moved = np.empty(3), np.empty(3)
    who, first = -1, math.inf
    for m in range(len(shapes.kind)):
        now, k, end = max(begin, shapes.active[m, 0]), 0, min(min(until, first), shapes.active[m, 1])
        owed = 0.0  # what the gaps at both ends of a step that was too long must add up to
        while now <= end:
            k = _place(knots, rows, k, now, place)
            gap = gap_at(shapes, m, now, place, moved) - MOVER_MARGIN
            if gap < owed:
                who, first = m, now
                break
            if now >= end:
                break
            flies = now < knots[len(rows)]
            rate = shapes.rate[m] + (speed if flies else 0.0)
            step = max(gap / rate, SHORTEST_STEP) if rate > 0.0 else until
            later = min(now + step, max(knots[len(rows)], now + SHORTEST_STEP) if flies else end, end)
            owed = max(rate * (later - now) - gap, 0.0)
            now = later
    return who, first


@kernel
def share_avoided(shapes: MovingShapes, knots: Floats, rows: Floats, begin: float, until: float) -> tuple[float, float]:
    """Return the share of movers' doubts that a motion is clear of between two instants, and how much is missing.

    The first is 1 if it is clear of all of them; see `gap_in_doubts`. The second is what is missing from 1, summed up
    over time, seconds. Both are found by samples, and so are no proof. See `first_contact`.
    """
    place, moved = np.empty(3), np.empty(3)
    least, missing, k = 1.0, 0.0, 0
    count = min(math.ceil((until - begin) / SAMPLE), MOST_SAMPLES)
    for i in range(count + 1):
        now = begin + (until - begin) * i / max(count, 1)
        k = _place(knots, rows, k, now, place)
        for m in range(len(shapes.kind)):
            share = gap_in_doubts(shapes, m, now, place, moved)
            least = min(least, share)
            missing += max(1.0 - share, 0.0)
    return least, missing * (until - begin) / (count + 1)
