"""Departure delays that are forbidden to a flight because of another one.

A flight that departs at d is at the point of its curve with local time tau when the mission's time is
``t = d + scale tau``. Where that point is too close to where another flight is at t, departing at
``d = t - scale tau`` is forbidden. Branch and bound over pairs of boxes of both curves' trees finds all forbidden
delays among the multiples of `TICK`, and a few more, since boxes are a little larger than what they enclose.

The delays that are still free are kept in an array, a disjoint-set forest with path halving: delay number i is free if
``free[i] == i``, and otherwise ``free[i]`` is a later delay from which to look on. Its last entry is always free, and
says that there is none left.

Two flights that start, or end, closer than their separation are in a conflict that is given, and no delay can avoid it.
Yet they may come no nearer to each other than their starts and targets are, and this rules out most delays at once:
while one waits, or has arrived, the other one flies past it at known instants (`forbid_at_rest`).
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.deconfliction.curve_store import SweptCurves
from skyverse.deconfliction.curves import Curves, TimedCurve, curve_duration
from skyverse.deconfliction.find_conflicts import ARRIVED, FLYING, WAITING, conflict_spans, nearness_at_ends
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import MIN_CONFLICT, SAME_NEARNESS, TICK_INDEX

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


class Sweep(NamedTuple):
    """The volume that a flight sweeps, as a tree of boxes, and when it does.

    Attributes
    ----------
    boxes, base, last
        As in `SweptCurves`: its tree begins at row `base`, and at row `last` is the point where it ends.
    leaves
        The number of nodes on the lowest level that is looked at, a power of 2.
    departure, seconds
        When it departs, and how long it takes.
    """

    boxes: Floats
    base: int
    last: int
    leaves: int
    departure: float
    seconds: float


@inner
def sweep_of(swept: SweptCurves, flight: TimedCurve, coarse: int) -> Sweep:
    """Return the volume that a flight sweeps; so many leaves of its tree are taken together."""
    base, leaves = swept.base[flight.curve], swept.leaves[flight.curve]
    seconds = flight.time_scale * curve_duration(swept.curves, flight.curve)
    return Sweep(swept.boxes, base, base + 2 * leaves, max(leaves // coarse, 1), flight.departure, seconds)


@inner
def forbid_departures(other: Sweep, own: Sweep, semi_axes: tuple[float, float], free: Ints) -> None:
    """Forbid the departures with which a flight would come too close to another one.

    Parameters
    ----------
    other, own
        The other flight, and the one that is to depart, whose own departure is 0.
    semi_axes
        Horizontal and vertical semi-axis that count between the two, metres.
    free
        (m + 1,) as from `free_departures`; changed in place.
    """
    for mine in (WAITING, FLYING, ARRIVED):
        for theirs in (WAITING, FLYING, ARRIVED):
            both_rest = mine == theirs != FLYING  # at the starts, or at the targets, which no delay changes
            if not both_rest and not (theirs == WAITING and other.departure <= 0.0):
                _forbid_parts(other, theirs, own, mine, semi_axes, free)


@inner
def _part(flight: Sweep, phase: int) -> tuple[int, int, float, float]:
    """Return where the tree of a part of a flight begins, its leaves, and from when until when the part lasts."""
    end = flight.departure + flight.seconds
    if phase == WAITING:
        return flight.base - 1, 1, -np.inf, flight.departure
    if phase == ARRIVED:
        return flight.last - 1, 1, end, np.inf
    return flight.base, flight.leaves, flight.departure, end


@inner
def _forbid_parts(a: Sweep, phase_a: int, b: Sweep, phase_b: int, semi_axes: tuple[float, float], free: Ints) -> None:
    """Forbid the delays of b at which b comes too close to a while both are in these phases.

    A pair of boxes is decided when no two points in them are too close, or all are, or when both are leaves; otherwise
    the one that lasts longer is replaced by its halves.
    """
    base_a, leaves_a, begin_a, end_a = _part(a, phase_a)
    base_b, leaves_b, begin_b, end_b = _part(b, phase_b)
    boxes_a, boxes_b = a.boxes, b.boxes
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


@inner
def nearness_allowed(curves: Curves, a: int, b: int, semi_axis_xy: float, semi_axis_z: float) -> float:
    """Return the nearness below which two curves are in conflict, however near their starts and targets are given."""
    begins, ends = nearness_at_ends(curves, a, b, semi_axis_xy, semi_axis_z)
    least = min(begins, ends)
    return max(least - 2.0 * SAME_NEARNESS, 0.0) if least < 1.0 else 1.0


@kernel
def forbid_at_rest(
    curves: Curves, other: TimedCurve, c: int, scale: float, semi_axis_xy: float, semi_axis_z: float, free: Ints
) -> None:
    """Forbid the departures with which one of two flights passes the other, which is at rest, too closely.

    Parameters
    ----------
    curves
        The curves that are flown.
    other
        The other flight.
    c, scale
        The curve of the flight that is to depart, and how many times as long it takes.
    semi_axis_xy, semi_axis_z
        Of the ellipsoid, metres.
    free
        As from `free_departures`; changed in place.
    """
    allowed = nearness_allowed(curves, other.curve, c, semi_axis_xy, semi_axis_z)
    if allowed <= 0.0:
        return  # at one place nobody can come any nearer
    xy, z = allowed * semi_axis_xy, allowed * semi_axis_z
    seconds, theirs = scale * curve_duration(curves, c), other.time_scale * curve_duration(curves, other.curve)
    arrival = other.departure + theirs
    waiting = TimedCurve(c, arrival + 1.0, scale)
    spans = conflict_spans(curves, other, waiting, xy, z, arrival + 0.5, True)
    if len(spans) > 0:  # the other one passes the start: the flight must have departed by then
        _forbid(free, spans[0, 0] + MIN_CONFLICT, np.inf)
    arrived = TimedCurve(c, -seconds - 1.0, scale)
    spans = conflict_spans(curves, other, arrived, xy, z, arrival + 0.5, False)
    if len(spans) > 0:  # the other one passes the target, or waits or stays near it: the flight must arrive later
        since = spans[len(spans) - 1, 1]
        _forbid(free, 0.0, np.inf if since >= arrival + 0.5 else since - seconds - MIN_CONFLICT)
    own = TimedCurve(c, 0.0, scale)
    resting = TimedCurve(other.curve, seconds + 1.0, other.time_scale)
    spans = conflict_spans(curves, resting, own, xy, z, seconds + 0.5, True)
    if len(spans) > 0:  # the flight passes the other one's start, which must have departed by then
        _forbid(free, 0.0, other.departure - spans[0, 0] - MIN_CONFLICT)
    rested = TimedCurve(other.curve, -theirs - 1.0, other.time_scale)
    spans = conflict_spans(curves, rested, own, xy, z, seconds + 0.5, False)
    if len(spans) > 0:  # the flight passes the other one's target, where nobody may be yet
        _forbid(free, arrival - spans[len(spans) - 1, 1] + MIN_CONFLICT, np.inf)


@inner
def _forbid(free: Ints, since: float, until: float) -> None:
    """Forbid the delays from `since` to `until`, seconds."""
    last = len(free) - 2
    first = max(math.ceil(since / TICK), 0)
    final = last if until >= last * TICK else math.floor(until / TICK)
    for k in range(first, final + 1):
        free[k] = max(free[k], k + 1)
