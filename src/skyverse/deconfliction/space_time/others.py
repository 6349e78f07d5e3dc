"""The flights that are already placed, as a search in space and time asks when they are near a place or a leg.

Time is cut into equal slices, and for each the boxes are kept that the flights do not leave during it. Only where these
are too near do the flights' own trees of boxes decide, down to their leaves.

From this follow the safe intervals in which a UAV may hover at a place. Movers are followed in steps in which the
distance that is left cannot be used up.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.deconfliction.curve_store import SweptCurves
from skyverse.deconfliction.curves import Schedule, curve_duration
from skyverse.deconfliction.space_time.leg_profiles import PEAK, SECONDS, StraightLeg, share_flown
from skyverse.numerics.arrays import order_of
from skyverse.numerics.kernel import by_reference, inner, inner_query, kernel
from skyverse.numerics.tolerances import MOVER_MARGIN
from skyverse.space.timed_shapes import MovingShapes, gap_at

HOVER_STEP = 0.01
"""Seconds by which time goes on at least where the UAV hovers."""
LEG_STEP = 0.002
"""Seconds by which time goes on at least while it flies a leg."""


@inner_query
def near_until(
    shapes: MovingShapes, m: int, place: Floats, now: float, more: float, moved: Floats
) -> tuple[bool, float]:
    """Return whether mover m may be too near to a place at an instant, and until when that surely does not change.

    `more` is how much farther than it must the UAV is to be, metres.
    """
    gap, rate = gap_at(shapes, m, now, place, moved) - MOVER_MARGIN - more, shapes.rate[m]
    if now < shapes.active[m, 0]:
        return False, shapes.active[m, 0]
    if now > shapes.active[m, 1]:
        return False, np.inf
    if rate <= 0.0:
        return gap < 0.0, np.nextafter(shapes.active[m, 1], np.inf)
    step = max(abs(gap) / rate, HOVER_STEP)
    return gap < rate * HOVER_STEP, min(now + step, np.nextafter(shapes.active[m, 1], np.inf))


@inner_query
def leg_kept_off(shapes: MovingShapes, leg: StraightLeg, departure: float, horizon: float, room: Floats) -> float:
    """Return by how many seconds a leg must depart later because of a mover that it meets; 0 if it meets none.

    Where it meets one, the mover must have gone from the place at which the UAV would be then. `room` is
    (7, 3) metres to work in.
    """
    here, moved = room[5], room[6]
    arrival = departure + leg.profile[SECONDS]
    for m in range(len(shapes.kind)):
        speed = shapes.rate[m] + leg.profile[PEAK]
        now, until = max(departure, shapes.active[m, 0]), min(arrival, shapes.active[m, 1])
        while now <= until:
            share = share_flown(leg.profile, now - departure)
            for axis in range(3):
                here[axis] = leg.place[axis] + share * leg.way[axis]
            gap = gap_at(shapes, m, now, here, moved) - MOVER_MARGIN
            if gap < speed * LEG_STEP:
                gone = now + HOVER_STEP
                near, after = near_until(shapes, m, here, gone, speed * LEG_STEP, moved)
                while near and gone < horizon:
                    gone = after
                    near, after = near_until(shapes, m, here, gone, speed * LEG_STEP, moved)
                return np.inf if near else gone - now
            now += gap / speed
    return 0.0


SLICE = 0.25
"""Seconds of a slice."""
MAX_SLICES = 2048
"""Slices at most; those of a mission that lasts longer are longer."""
FINEST = 0.01
"""Seconds of a leg that are taken together at most, where it comes near to a flight."""
LEAST_LATER = 0.02
"""Seconds by which a departure is tried later at least."""


@by_reference
class Others(NamedTuple):
    """The flights of n UAVs that another UAV must stay clear of.

    Attributes
    ----------
    boxes
        (k, 6) of the trees of all curves; see `SweptCurves`.
    base, leaves
        (n,) where each flight's tree begins, and how many leaves it has.
    departure, seconds
        (n,) when each departs, and how long it takes.
    movers
        The movers, and the zones with active times.
    horizon
        Seconds into the mission from which on movers do not count any more.
    semi_axes
        (n, 2) horizontal and vertical semi-axis of the ellipsoid to keep out of, metres; none of them is 0.
    slice_seconds
        How long a slice of time lasts.
    slices
        (m, n, 6) boxes that hold the flights during each slice. The last slice lasts for ever.
    """

    boxes: Floats
    base: Ints
    leaves: Ints
    departure: Floats
    seconds: Floats
    movers: MovingShapes
    horizon: float
    semi_axes: Floats
    slice_seconds: float
    slices: Floats


def make_others(
    swept: SweptCurves, schedule: Schedule, semi_axes: Floats, movers: MovingShapes, horizon: float
) -> Others:
    """Return the flights of a schedule for searches; see `Others`."""
    seconds = np.array([curve_duration(swept.curves, c) for c in schedule.curve.tolist()]) * schedule.time_scale
    end = float((schedule.departure + seconds).max(initial=0.0))
    count = min(max(math.ceil(end / SLICE), 1), MAX_SLICES)
    length = max(end / count, SLICE)
    slices = np.empty((count + 1, len(seconds), 6))
    slices[..., :3], slices[..., 3:] = np.inf, -np.inf
    base, leaves = swept.base[schedule.curve], swept.leaves[schedule.curve]
    departure = schedule.departure
    others = Others(swept.boxes, base, leaves, departure, seconds, movers, horizon, semi_axes, length, slices)
    _fill_slices(others)
    return others


@kernel
def _fill_slices(others: Others) -> None:
    """Write the boxes that the flights do not leave during each slice."""
    slices = others.slices
    count = len(slices) - 1
    for p in range(len(others.base)):
        base, leaves = others.base[p], others.leaves[p]
        begin, step = others.departure[p], others.seconds[p] / leaves
        for s in range(slice_of(others, begin) + 1):  # it waits at its start
            _enclose(slices, s, p, others.boxes, base)
        for leaf in range(leaves):
            since, until = begin + leaf * step, begin + (leaf + 1) * step
            for s in range(slice_of(others, since), slice_of(others, until) + 1):
                _enclose(slices, s, p, others.boxes, base + leaves + leaf)
        for s in range(slice_of(others, begin + others.seconds[p]), count + 1):
            _enclose(slices, s, p, others.boxes, base + 2 * leaves)


@inner
def _enclose(slices: Floats, s: int, p: int, boxes: Floats, row: int) -> None:
    for axis in range(3):
        slices[s, p, axis] = min(slices[s, p, axis], boxes[row, axis])
        slices[s, p, 3 + axis] = max(slices[s, p, 3 + axis], boxes[row, 3 + axis])


@inner_query
def slice_of(others: Others, t: float) -> int:
    """Return the number of the slice that holds an instant."""
    return min(max(int(t / others.slice_seconds), 0), len(others.slices) - 1)


@inner_query
def too_near(others: Others, p: int, box: Floats, low: Floats, high: Floats) -> bool:
    """Tell whether a box, (6,), in which flight p is, comes too near to the box with corners (3,), metres."""
    xy, z = others.semi_axes[p, 0], others.semi_axes[p, 1]
    x = max(max(low[0] - box[3], box[0] - high[0]), 0.0) / xy
    if x >= 1.0:
        return False
    y = max(max(low[1] - box[4], box[1] - high[1]), 0.0) / xy
    up = max(max(low[2] - box[5], box[2] - high[2]), 0.0) / z
    return x * x + y * y + up * up < 1.0


@inner_query
def leaf_at(others: Others, p: int, t: float) -> tuple[int, float]:
    """Return the row of the box that flight p is in just after an instant, and until when."""
    base, leaves = others.base[p], others.leaves[p]
    begin, seconds = others.departure[p], others.seconds[p]
    if t < begin:
        return base, begin
    if t >= begin + seconds:
        return base + 2 * leaves, np.inf
    leaf = min(int((t - begin) / seconds * leaves), leaves - 1)
    until = begin + (leaf + 1) * seconds / leaves
    if until <= t:  # by rounding
        leaf, until = leaf + 1, begin + (leaf + 2) * seconds / leaves
    return base + (leaves + leaf if leaf < leaves else 2 * leaves), until


@inner_query
def first_too_near(
    others: Others, p: int, leg: StraightLeg, departure: float, since: float, until: float, room: Floats
) -> float:
    """Return the first instant within a span at which a leg comes too near to flight p; infinite if there is none."""
    low, high = room[3], room[4]
    now, longest = since, until - since
    while now < until:
        row, after = leaf_at(others, p, now)
        after = min(after, min(now + longest, until))
        leg_box(leg, departure, now, after, low, high)
        if not too_near(others, p, others.boxes[row], low, high):
            now, longest = after, 2.0 * longest
        elif after - now > FINEST:
            longest = 0.5 * (after - now)
        else:
            return now
    return np.inf


@inner_query
def leg_box(leg: StraightLeg, departure: float, since: float, until: float, low: Floats, high: Floats) -> None:
    """Write the corners of the box that holds a leg between two instants."""
    a, b = share_flown(leg.profile, since - departure), share_flown(leg.profile, until - departure)
    for axis in range(3):
        one, other = leg.place[axis] + a * leg.way[axis], leg.place[axis] + b * leg.way[axis]
        low[axis], high[axis] = min(one, other), max(one, other)


@inner_query
def gone_from(others: Others, p: int, place: Floats, since: float) -> float:
    """Return from when on flight p, which is too near to a place at an instant, is not any more; perhaps never."""
    now = since
    while now < np.inf:
        row, after = leaf_at(others, p, now)
        if not too_near(others, p, others.boxes[row], place, place):
            return now
        now = after
    return np.inf


@inner_query
def earliest_leg(others: Others, leg: StraightLeg, since: float, until: float, room: Floats) -> float:
    """Return the earliest departure within a span of a leg that comes too near to nobody; infinite if there is none.

    Where a leg comes too near to a flight, the UAV would be at a place at that instant from which the flight must have
    gone. All departures are left out with which the UAV is at that place before. `room` is (7, 3) metres to work in.
    """
    n = len(others.base)
    low, high, met = room[0], room[1], room[2]
    departure = since
    while departure <= until and departure < np.inf:
        arrival = departure + leg.profile[SECONDS]
        first, last = slice_of(others, departure), slice_of(others, arrival)
        later = departure
        for s in range(first, last + 1):
            begin = max(s * others.slice_seconds, departure)
            end = arrival if s == last else min((s + 1) * others.slice_seconds, arrival)
            leg_box(leg, departure, begin, end, low, high)
            for p in range(n):
                if not too_near(others, p, others.slices[s, p], low, high):
                    continue
                instant = first_too_near(others, p, leg, departure, begin, end, room)
                if instant == np.inf:
                    continue
                row, after = leaf_at(others, p, instant)
                middle = instant + 0.5 * min(FINEST, min(after, end) - instant)
                share = share_flown(leg.profile, middle - departure)
                for axis in range(3):
                    met[axis] = leg.place[axis] + share * leg.way[axis]
                rests = row == others.base[p] or row == others.base[p] + 2 * others.leaves[p]
                gone = after if rests else gone_from(others, p, met, middle)
                later = max(later, max(departure + gone - middle, departure + LEAST_LATER))
            if later > departure:
                break
        if later == departure:
            later += leg_kept_off(others.movers, leg, departure, others.horizon, room)
        if later == departure:
            return departure
        departure = later
    return np.inf


MOST_SPANS = 512
"""Spans in which flights come too near to one place that are told apart; with more, the place is never safe."""


@inner
def safe_intervals(others: Others, place: Floats, shortest: float) -> Floats:
    """Return the intervals (k, 2), seconds, in which nobody comes too near to a place; the last may be infinite.

    Intervals that are shorter than `shortest` are left out.
    """
    spans = np.empty((MOST_SPANS, 2))
    count = _near_spans(others, place, spans, np.empty(3))
    if count < 0:
        return np.empty((0, 2))
    order = order_of(spans[:count, 0].copy())
    found = np.empty((count + 1, 2))
    kept, now = 0, 0.0
    for k in range(count):
        since, until = spans[order[k], 0], spans[order[k], 1]
        if since - now > shortest:
            found[kept, 0], found[kept, 1] = now, since
            kept += 1
        now = max(now, until)
    if now < np.inf:
        found[kept, 0], found[kept, 1] = now, np.inf
        kept += 1
    return found[:kept]


@inner_query
def _near_spans(others: Others, place: Floats, spans: Floats, moved: Floats) -> int:
    """Write the spans in which anybody comes too near to a place, and return how many there are; -1 if too many."""
    count = 0
    final = len(others.slices) - 1
    for p in range(len(others.base)):
        opened = False
        for s in range(final + 1):
            if not too_near(others, p, others.slices[s, p], place, place):
                continue
            now = s * others.slice_seconds
            until = (s + 1) * others.slice_seconds if s < final else np.inf
            while now < until:
                row, after = leaf_at(others, p, now)
                after = min(after, until)
                if too_near(others, p, others.boxes[row], place, place):
                    if opened and spans[count - 1, 1] >= now:
                        spans[count - 1, 1] = after
                    elif count == MOST_SPANS:
                        return -1
                    else:
                        spans[count, 0], spans[count, 1] = now, after
                        count += 1
                        opened = True
                now = after
    for m in range(len(others.movers.kind)):
        now = 0.0
        while now < others.horizon:
            near, after = near_until(others.movers, m, place, now, 0.0, moved)
            if near and count > 0 and spans[count - 1, 1] == now:
                spans[count - 1, 1] = after
            elif near:
                if count == MOST_SPANS:
                    return -1
                spans[count, 0], spans[count, 1] = now, after
                count += 1
            now = after
    return count
