"""What one UAV may do among flights that are already placed: when it can depart, and with whom it is in conflict."""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.deconfliction.curve_store import SweptCurves, enclose_children
from skyverse.deconfliction.curves import Schedule, TimedCurve
from skyverse.deconfliction.find_conflicts import in_conflict
from skyverse.deconfliction.forbidden_departures import (
    TICK,
    Sweep,
    forbid_at_rest,
    forbid_departures,
    free_departures,
    nearness_allowed,
    next_free,
    sweep_of,
)
from skyverse.numerics.arrays import put
from skyverse.numerics.kernel import inner, kernel

STRIDE = 4
"""Ticks from one delay to the next where each is tested exactly, which takes long."""
TWO_LEAVES = 0.15
"""Metres, more than two leaves' boxes are wide: flights whose boxes are so much too close are too close themselves."""
MIN_SEMI_AXIS = 1e-3
"""Metres that are left of a semi-axis when `TWO_LEAVES` is taken off it."""
COARSE_LEAVES = 4
"""Leaves that are taken together where an estimate is enough."""
ESTIMATE_WINDOW = 0.5
"""Seconds after the earliest estimated arrival up to which later ones are estimated too."""


class Traffic(NamedTuple):
    """The flights that are already placed, as one UAV sees them; (n,) each.

    Attributes
    ----------
    schedule
        The flights.
    semi_axis_xy, semi_axis_z
        Of the ellipsoid that counts between each and the UAV, metres; 0 where none is kept free.
    close_ends
        Whether their starts or their targets are so near to the UAV's own that boxes are too coarse to decide.
    """

    schedule: Schedule
    semi_axis_xy: Floats
    semi_axis_z: Floats
    close_ends: Bools


@inner
def _flight(schedule: Schedule, p: int) -> TimedCurve:
    """Return flight number p of a schedule."""
    return TimedCurve(schedule.curve[p], schedule.departure[p], schedule.time_scale[p])


@kernel
def earliest_departure(swept: SweptCurves, traffic: Traffic, c: int, scale: float, free: Ints) -> float:
    """Return the least delay, seconds, at which a flight is in conflict with nobody; -1 if there is none.

    A conflict that is given by starts or targets forbids nothing. Boxes are too coarse for traffic with close ends.
    There they only forbid what comes closer than starts and targets are given, by `TWO_LEAVES`. Of the delays that
    these boxes and `forbid_at_rest` leave, every `STRIDE`-th is tested exactly.

    Parameters
    ----------
    swept
        The curves of all flights.
    traffic
        The other flights.
    c, scale
        The curve that is flown, and how many times as long it takes.
    free
        As from `free_departures`; changed in place.
    """
    schedule, semi_axis_xy, semi_axis_z, close_ends = traffic
    curves, own = swept.curves, sweep_of(swept, TimedCurve(c, 0.0, scale), 1)
    for p in range(len(schedule.curve)):
        xy, z = semi_axis_xy[p], semi_axis_z[p]
        if xy > 0.0 and next_free(free, 0) < len(free) - 1:
            other = _flight(schedule, p)
            theirs = sweep_of(swept, other, 1)
            if not close_ends[p]:
                forbid_departures(theirs, own, (xy, z), free)
                continue
            forbid_at_rest(curves, other, c, scale, xy, z, free)
            allowed = nearness_allowed(curves, other.curve, c, xy, z)
            smaller = max(allowed * xy - TWO_LEAVES, MIN_SEMI_AXIS), max(allowed * z - TWO_LEAVES, MIN_SEMI_AXIS)
            forbid_departures(theirs, own, smaller, free)
            arrived = math.ceil((theirs.departure + theirs.seconds) / TICK) + 1
            if arrived < len(free) - 1 and in_conflict(curves, other, TimedCurve(c, arrived * TICK, scale), xy, z):
                for k in range(arrived, len(free) - 1):  # the other does not move any more: later delays are alike
                    free[k] = max(free[k], k + 1)
    i = next_free(free, 0)
    while i < len(free) - 1:
        clear = True
        for p in range(len(schedule.curve)):
            if close_ends[p] and semi_axis_xy[p] > 0.0 and clear:
                tried = TimedCurve(c, i * TICK, scale)
                clear = not in_conflict(curves, _flight(schedule, p), tried, semi_axis_xy[p], semi_axis_z[p])
        if clear:
            return i * TICK
        i = next_free(free, min(i + STRIDE, len(free) - 1) if close_ends.any() else i + 1)
    return -1.0


@kernel
def estimate_detours(
    swept: SweptCurves,
    traffic: Traffic,
    c: int,
    offsets: Floats,
    ratios: Floats,
    share: float,
    since: float,
    latest: float,
) -> Floats:
    """Estimate when a flight would arrive if its curve were drawn aside, by each of m offsets; (m,) seconds.

    The boxes of the curve's tree are moved by a part of the offset: all of it after a share of the curve's time, and in
    proportion to the time from its beginning and to its end, so that both ends stay.

    Parameters
    ----------
    swept
        The curves of all flights.
    traffic
        The other flights.
    c
        The curve.
    offsets
        (m, 3) metres.
    ratios
        (m,) how many times as long the flight takes then.
    share
        Of the curve's time at which it is drawn aside the farthest.
    since
        The earliest departure, seconds.
    latest
        Arrivals that are later count as infinite, and so do those that are more than `ESTIMATE_WINDOW` later than the
        earliest one of the offsets before.
    """
    schedule, semi_axis_xy, semi_axis_z, close_ends = traffic
    own = sweep_of(swept, TimedCurve(c, 0.0, 1.0), COARSE_LEAVES)
    leaves = own.leaves
    planned = swept.boxes[own.base : own.base + 2 * leaves + 1]
    boxes = planned.copy()
    put(boxes, 2 * leaves, swept.boxes[own.last])
    arrivals = np.full(len(offsets), np.inf)
    for way in range(len(offsets)):
        for leaf in range(leaves):
            passed = (leaf + 0.5) / leaves
            part = passed / share if passed < share else (1.0 - passed) / (1.0 - share)
            for axis in range(6):
                boxes[leaves + leaf, axis] = planned[leaves + leaf, axis] + part * offsets[way, axis % 3]
        enclose_children(boxes, leaves)
        seconds = own.seconds * ratios[way]
        aside = Sweep(boxes, 0, 2 * leaves, leaves, 0.0, seconds)
        free = free_departures(latest - seconds, since)
        for p in range(len(schedule.curve)):
            if semi_axis_xy[p] > 0.0 and not close_ends[p] and next_free(free, 0) < len(free) - 1:
                other = sweep_of(swept, _flight(schedule, p), COARSE_LEAVES)
                forbid_departures(other, aside, (semi_axis_xy[p], semi_axis_z[p]), free)
        i = next_free(free, 0)
        if i < len(free) - 1:
            arrivals[way] = i * TICK + seconds
            latest = min(latest, arrivals[way] + ESTIMATE_WINDOW)
    return arrivals


@kernel
def conflicting_flights(swept: SweptCurves, traffic: Traffic, own: TimedCurve) -> np.ndarray:
    """Tell which flights of the traffic a flight is in conflict with, (n,) booleans."""
    schedule, semi_axis_xy, semi_axis_z, _ = traffic
    found = np.zeros(len(schedule.curve), np.bool_)
    sweep = sweep_of(swept, own, 1)
    for p in range(len(found)):
        xy, z = semi_axis_xy[p], semi_axis_z[p]
        if xy > 0.0:
            other = _flight(schedule, p)
            free = np.arange(2)  # the boxes decide quickly whether it may depart at 0; only otherwise test exactly
            if own.departure == 0.0:
                forbid_departures(sweep_of(swept, other, 1), sweep, (xy, z), free)
            if own.departure > 0.0 or free[0] > 0:
                found[p] = in_conflict(swept.curves, other, own, xy, z)
    return found
