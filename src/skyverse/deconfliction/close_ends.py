"""Departure delays that are hopeless because two flights start, or end, closer than their separation.

Such a pair is in a conflict that is given, and no delay can avoid it. Yet the two may come no nearer to each other than
their starts and targets are, and this rules out most delays at once. While a UAV waits at its start, the other one
flies past it at known instants, and so does each while the other waits, or has arrived. Only the delays that are left
need an exact test.
"""

import math

import numpy as np

from skyverse._typing import Ints
from skyverse.deconfliction.curves import Curves, TimedCurve, curve_duration
from skyverse.deconfliction.forbidden_departures import TICK
from skyverse.deconfliction.pair_conflicts import conflict_spans, nearness_at_ends
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import MIN_CONFLICT, SAME_NEARNESS


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
