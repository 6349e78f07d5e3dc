"""Departure delays that are forbidden to a flight because of another one.

A flight that departs at d is at the point of its curve with local time tau when the mission's time is
``t = d + scale tau``. Where that point is too close to where another flight is at t, departing at
``d = t - scale tau`` is forbidden. Branch and bound over pairs of boxes of both curves' trees finds all forbidden
delays among the multiples of `TICK`, and a few more, since boxes are a little larger than what they enclose.

The delays that are still free are kept in an array, a disjoint-set forest with path halving: delay number i is free if
``free[i] == i``, and otherwise ``free[i]`` is a later delay from which to look on. Its last entry is always free, and
says that there is none left.
"""

import math

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.deconfliction.curves import Curves, TimedCurve, curve_duration
from skyverse.deconfliction.swept_volume_tree import SweptVolumeTrees
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import TICK_INDEX

TICK = 0.02
"""Seconds between the departure delays that are considered."""


@kernel
def free_departures(latest: float, since: float = 0.0) -> Ints:
    """Return the delays 0, `TICK`, 2 `TICK` and so on up to the latest, of which those before `since` are forbidden."""
    free = np.arange(max(math.floor(latest / TICK + TICK_INDEX), -1) + 2)
    early = min(max(math.ceil(since / TICK - TICK_INDEX), 0), len(free) - 1)
    for i in range(early):
        free[i] += 1
    return free


@inner
def next_free(free: Ints, i: int) -> int:
    """Return the least number of a free delay from i on; the entries on the way then lead there in half the steps."""
    while free[i] != i:
        free[i] = free[free[i]]
        i = free[i]
    return i


@inner
def forbid_departures(
    curves: Curves,
    trees: SweptVolumeTrees,
    other: TimedCurve,
    semi_axes: tuple[float, float],
    boxes: Floats,
    base: int,
    leaves: int,
    seconds: float,
    coarse: int,
    free: Ints,
) -> None:
    """Forbid the departures with which a flight would come too close to another one.

    Parameters
    ----------
    curves, trees
        With those of the other flight.
    other
        The other flight.
    semi_axes
        Horizontal and vertical semi-axis that count between the two, metres.
    boxes, base, leaves, seconds
        The flight's tree, and how long it takes.
    coarse
        How many leaves of the other's tree are taken together.
    free
        (m + 1,) as from `free_departures`; changed in place.
    """
    c = other.curve
    begin = other.departure
    end = begin + other.time_scale * curve_duration(curves, c)
    base_other, leaves_other = trees.base[c], trees.leaves[c]
    fewer = max(leaves_other // coarse, 1)
    theirs = trees.boxes
    last = base_other + 2 * leaves_other - 1
    for phase in range(3):  # before it departs, in flight, after it has arrived
        if phase == 0:
            my_base, my_leaves, since, until = base - 1, 1, -np.inf, 0.0
        elif phase == 1:
            my_base, my_leaves, since, until = base, leaves, 0.0, seconds
        else:
            my_base, my_leaves, since, until = base + 2 * leaves - 1, 1, seconds, np.inf
        if phase < 2:
            _forbid_parts(theirs, last, 1, end, np.inf, boxes, my_base, my_leaves, since, until, semi_axes, free)
        _forbid_parts(theirs, base_other, fewer, begin, end, boxes, my_base, my_leaves, since, until, semi_axes, free)
        if phase > 0 and begin > 0.0:
            _forbid_parts(
                theirs, base_other - 1, 1, 0.0, begin, boxes, my_base, my_leaves, since, until, semi_axes, free
            )


@inner
def _forbid_parts(
    boxes_a: Floats,
    base_a: int,
    leaves_a: int,
    begin_a: float,
    end_a: float,
    boxes_b: Floats,
    base_b: int,
    leaves_b: int,
    begin_b: float,
    end_b: float,
    semi_axes: tuple[float, float],
    free: Ints,
) -> None:
    """Forbid the delays of b at which parts of a and b, flown between these instants, come too close.

    The times of a are seconds into the mission, those of b seconds after its departure. A pair of boxes is decided when
    no two points in them are too close, or all are, or when both are leaves; otherwise the one that lasts longer is
    replaced by its halves.
    """
    nodes = np.empty((128, 2), np.int64)
    times = np.empty((128, 4))
    nodes[0, 0], nodes[0, 1] = 1, 1
    times[0, 0], times[0, 1], times[0, 2], times[0, 3] = begin_a, end_a, begin_b, end_b
    size = 1
    last = len(free) - 2
    while size > 0:
        size -= 1
        i, j = nodes[size, 0], nodes[size, 1]
        a0, a1, b0, b1 = times[size, 0], times[size, 1], times[size, 2], times[size, 3]
        least, most = (a0 - b1) / TICK, (a1 - b0) / TICK
        if most < 0.0 or least > last:
            continue
        first = 0 if least <= 0.0 else math.ceil(least - TICK_INDEX)
        final = last if most >= last else math.floor(most + TICK_INDEX)
        if next_free(free, first) > final:
            continue
        p, q = base_a + i, base_b + j
        nearest, farthest = 0.0, 0.0
        for axis in range(3):
            semi_axis = semi_axes[0] if axis < 2 else semi_axes[1]
            ahead = boxes_b[q, axis] - boxes_a[p, 3 + axis]
            behind = boxes_a[p, axis] - boxes_b[q, 3 + axis]
            gap = max(ahead, behind, 0.0) / semi_axis
            span = max(-ahead, -behind) / semi_axis
            nearest += gap * gap
            farthest += span * span
        if nearest >= 1.0:
            continue
        whole_a, whole_b = i >= leaves_a, j >= leaves_b
        if farthest < 1.0 or (whole_a and whole_b):
            k = next_free(free, first)
            while k <= final:
                free[k] = k + 1
                k = next_free(free, k)
            continue
        if not whole_a and (whole_b or a1 - a0 >= b1 - b0):
            middle = (a0 + a1) / 2
            for half in range(2):
                nodes[size, 0], nodes[size, 1] = 2 * i + 1 - half, j
                times[size, 0], times[size, 1] = (middle, a1) if half == 0 else (a0, middle)
                times[size, 2], times[size, 3] = b0, b1
                size += 1
        else:
            middle = (b0 + b1) / 2
            for half in range(2):
                nodes[size, 0], nodes[size, 1] = i, 2 * j + half
                times[size, 0], times[size, 1] = a0, a1
                times[size, 2], times[size, 3] = (b0, middle) if half == 0 else (middle, b1)
                size += 1
