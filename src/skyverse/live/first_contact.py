"""When a motion first comes too near to where movers may be, and how much of what they may do it is clear of.

A motion is followed in steps in which the distance that is left from a mover cannot be used up, since both have a top
speed; so what is passed over is proven clear. Where these would be too short, a longer step is taken, and what it
passes over counts as a contact unless the distances at both of its ends show that it is none.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner_query, kernel
from skyverse.numerics.tolerances import MOVER_MARGIN
from skyverse.space.moving_shapes import MovingShapes, gap_at, gap_in_doubts

SHORTEST_STEP = 1e-5
"""Seconds by which a motion is followed at least."""
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
