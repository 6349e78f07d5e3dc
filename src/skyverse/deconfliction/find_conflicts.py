"""Find which UAVs of a fleet come too close to each other, and when: every pair, at every instant.

Around each UAV an ellipsoid is kept free of others. The nearness of two flights a and b is their distance as a share of
its semi-axes; they are in conflict where it is below 1. Between knots its square is a polynomial of time,

    nearness^2 = ((x_a - x_b)^2 + (y_a - y_b)^2) / semi_axis_xy^2 + (z_a - z_b)^2 / semi_axis_z^2.

The polynomial lies between the least and the largest of its Bernstein coefficients. An interval on which all of them
are at least 1 is free of conflict, one on which all are below 1 is a conflict, and any other is halved until it is
no longer than `MIN_CONFLICT`, when it counts as a conflict. So no conflict is missed.
"""

import math
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.deconfliction.curves import (
    Curves,
    Schedule,
    TimedCurve,
    constant_piece,
    curve_duration,
    make_curves,
    piece_at,
    piece_between,
    position_at,
    stay_at_start,
)
from skyverse.errors import InputError, require_kind
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import strayed_share
from skyverse.model.verdict import Conflict
from skyverse.numerics.arrays import put
from skyverse.numerics.bernstein import halve, product
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import MIN_CONFLICT, MIN_HORIZON, SAME_NEARNESS, SEPARATION_FORGIVEN


def find_conflicts(scenario: Scenario, trajectories: Sequence[Trajectory | None]) -> tuple[Conflict, ...]:
    """Find all pairs of UAVs that come closer than their separation, in continuous time.

    The relative position of two UAVs is a polynomial between knots. The intervals in which it lies within the ellipsoid
    are found by halving its Bernstein form until nothing is undecided. A pair that comes too close for less than a
    microsecond may be reported although it does not; none is missed that comes too close by 1e-6 m.

    Parameters
    ----------
    scenario
        With the UAVs and their separations.
    trajectories
        One for each UAV, which waits at its start before and stays where it ended afterwards. A UAV without one
        (``None``) stays at its start.

    Returns
    -------
    tuple of Conflict
        In order of time: one for each span of time in which a pair is too close. Spans end with the last arrival.

    Raises
    ------
    ValueError
        If there is not one entry for each UAV.
    """
    require_kind(scenario, Scenario, "scenario")
    uavs = scenario.uavs
    if len(trajectories) != len(uavs):
        raise InputError(f"{len(uavs)} UAVs need as many trajectories (or None), not {len(trajectories)}")
    flown = [stay_at_start(uav) if t is None else t for uav, t in zip(uavs, trajectories, strict=True)]
    curves = make_curves(flown)
    absent = np.array([t is None for t in trajectories], dtype=np.bool_)
    departure = np.array([0.0 if none else t.start for none, t in zip(absent, flown, strict=True)])
    schedule = Schedule(np.arange(len(uavs)), departure, np.ones(len(uavs)))
    semi_axis_xy, semi_axis_z = semi_axes(scenario)
    found = []
    end = max((departure[k] + curve_duration(curves, k) for k in np.flatnonzero(~absent).tolist()), default=0.0)
    until = max(end, MIN_HORIZON)
    for a, b in pairs_in_conflict(curves, schedule, semi_axis_xy, semi_axis_z, until):
        xy, z = float(semi_axis_xy[a, b]), float(semi_axis_z[a, b])
        one, other = TimedCurve(a, departure[a], 1.0), TimedCurve(b, departure[b], 1.0)
        spans = conflict_spans(curves, one, other, xy, z, until, False)
        begins, ends = nearness_at_ends(curves, a, b, xy, z)
        if absent[a] or absent[b]:
            ends = np.inf
        untrimmed = (xy + SEPARATION_FORGIVEN, xy + SEPARATION_FORGIVEN, z + SEPARATION_FORGIVEN)
        for span in spans:
            since, ends_at, when, _ = span.tolist()
            given = is_given(span, begins, ends, end)
            here, there = position_at(curves, a, when - departure[a]), position_at(curves, b, when - departure[b])
            x, y, height = ((here + there) / 2).tolist()
            near = math.hypot(*((here - there) / untrimmed))
            pair = (int(a), int(b))
            found.append(Conflict(pair, since, min(ends_at, end), min(when, end), near, (x, y, height), bool(given)))
    return tuple(sorted(found, key=lambda conflict: (conflict.begin, conflict.uavs)))


def semi_axes(scenario: Scenario) -> tuple[Floats, Floats]:
    """Return the horizontal and vertical semi-axes of the ellipsoids that each two UAVs must keep out of.

    Of their separations the larger one counts, less what is tolerated. With tracking errors the ellipsoid is enlarged,
    so that UAVs keep the separation wherever they are within their errors. Two UAVs without a separation keep none.

    Returns
    -------
    tuple
        (n, n) metres each; of a pair, both are 0 where none is kept.
    """
    axes = np.array([uav.ellipsoid for uav in scenario.uavs]).reshape(-1, 2).T
    errors = np.array([(uav.tracking_error.horizontal, uav.tracking_error.vertical) for uav in scenario.uavs])
    xy, z = (np.maximum.outer(axis, axis) for axis in axes)
    aside, up = (np.add.outer(error, error) for error in errors.reshape(-1, 2).T)
    factor = 1.0 + strayed_share(xy, z, aside, up)
    xy, z = (np.maximum(axis * factor - SEPARATION_FORGIVEN, axis / 2) for axis in (xy, z))
    return xy, z


def ellipsoid_holds(gap: Floats, xy: Floats, z: Floats, share: float = 1.0) -> Bools:
    """Tell which gaps (..., 3), metres, lie within an ellipsoid, or within so many times its semi-axes."""
    square = gap**2
    held: Bools = (square[..., 0] + square[..., 1]) * z**2 + square[..., 2] * xy**2 < (share * xy * z) ** 2
    return held


@kernel
def pairs_in_conflict(curves: Curves, schedule: Schedule, xy: Floats, z: Floats, end: float) -> Ints:
    """Return the pairs (m, 2) of n flights that are in conflict up to an instant; semi-axes are (n, n) metres."""
    n = len(schedule.curve)
    found = np.empty((n * (n - 1) // 2, 2), np.int64)
    count = 0
    for i in range(n):
        one = TimedCurve(schedule.curve[i], schedule.departure[i], schedule.time_scale[i])
        for j in range(i + 1, n):
            other = TimedCurve(schedule.curve[j], schedule.departure[j], schedule.time_scale[j])
            if xy[i, j] > 0.0 and len(conflict_spans(curves, one, other, xy[i, j], z[i, j], end, True)) > 0:
                found[count, 0], found[count, 1] = i, j
                count += 1
    return found[:count]


MAX_SPANS = 64
"""Spans of conflict that are kept apart for one pair; further ones are joined to the last."""
SAMPLES = 8
"""Equal parts of an interval at whose ends the least nearness is looked for first."""
THIRDS = 30
"""Steps of the ternary search that follows."""

WAITING, FLYING, ARRIVED = range(3)


@inner
def nearness(a: Floats, b: Floats, semi_axis_xy: float, semi_axis_z: float) -> float:
    """Return the distance of two positions as a share of an ellipsoid's semi-axes; below 1 they are in conflict."""
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return math.sqrt((x * x + y * y) / (semi_axis_xy * semi_axis_xy) + z * z / (semi_axis_z * semi_axis_z))


@kernel
def conflict_spans(
    curves: Curves,
    one: TimedCurve,
    other: TimedCurve,
    semi_axis_xy: float,
    semi_axis_z: float,
    end: float,
    first_only: bool,
) -> Floats:
    """Return the spans of time within [0, end] in which two flights are in conflict.

    Parameters
    ----------
    curves
        The curves that are flown.
    one, other
        The two flights.
    semi_axis_xy, semi_axis_z
        Of the ellipsoid, metres.
    end
        Seconds into the mission.
    first_only
        Whether a part of the first span suffices. Its last two columns are then not filled in.

    Returns
    -------
    (n, 4)
        Begin and end of each span, when the two are nearest, all in seconds, and their squared nearness then.
    """
    spans = np.empty((MAX_SPANS, 4))
    count = 0
    now = 0.0
    while now < end:
        k, phase_one, until_one = _phase(curves, one, now)
        m, phase_other, until_other = _phase(curves, other, now)
        until = min(min(until_one, until_other), end)
        if _boxes_meet(curves, k, m, semi_axis_xy, semi_axis_z):
            a = _flown(curves, k, phase_one, one, now, until)
            b = _flown(curves, m, phase_other, other, now, until)
            square = _nearness_square(a, b, semi_axis_xy, semi_axis_z)
            count = _add_spans_below_one(square, now, until, spans, count, first_only)
            if first_only and count > 0:
                break
        now = until
    return spans[:count]


@inner
def _phase(curves: Curves, flight: TimedCurve, now: float) -> tuple[int, int, float]:
    """Return the piece that is flown just after `now`, the phase of the flight, and until when both hold."""
    c, at, scale = flight.curve, flight.departure, flight.time_scale
    local = (now - at) / scale
    last = curves.first[c + 1] - 1
    if now < at:
        return curves.first[c], WAITING, at
    k = piece_at(curves, c, local)
    finish = at + scale * (curves.begin[k] + curves.duration[k])
    while finish <= now and k < last:
        k += 1
        finish = at + scale * (curves.begin[k] + curves.duration[k])
    if finish <= now:
        return last, ARRIVED, np.inf
    return k, FLYING, finish


@inner
def _flown(curves: Curves, k: int, phase: int, flight: TimedCurve, now: float, until: float) -> Floats:
    """Return the Bernstein coefficients of a flight between two instants at which it is within piece k."""
    at, scale = flight.departure, flight.time_scale
    if phase == FLYING:
        return piece_between(curves, k, (now - at) / scale, (until - at) / scale)
    here = curves.rows[k, 0 if phase == WAITING else curves.rows.shape[1] - 1]
    return constant_piece(here, curves.rows.shape[1])


@inner
def _nearness_square(a: Floats, b: Floats, semi_axis_xy: float, semi_axis_z: float) -> Floats:
    """Return the Bernstein coefficients (2 n + 1, 1) of the squared nearness of two pieces of degree n."""
    n = len(a)
    gap, squares, square = np.empty(n), np.empty((3, 2 * n - 1)), np.empty((2 * n - 1, 1))
    for axis in range(3):
        for i in range(n):
            gap[i] = a[i, axis] - b[i, axis]
        put(squares, axis, product(gap, gap))
    for i in range(2 * n - 1):
        level = (squares[0, i] + squares[1, i]) / (semi_axis_xy * semi_axis_xy)
        square[i, 0] = level + squares[2, i] / (semi_axis_z * semi_axis_z)
    return square


@inner
def _boxes_meet(curves: Curves, k: int, m: int, semi_axis_xy: float, semi_axis_z: float) -> bool:
    """Tell whether the bounding boxes of two pieces are so near to each other that there may be a conflict."""
    square = 0.0
    for axis in range(3):
        gap = max(max(curves.low[k, axis] - curves.high[m, axis], curves.low[m, axis] - curves.high[k, axis]), 0.0)
        gap /= semi_axis_xy if axis < 2 else semi_axis_z
        square += gap * gap
    return square < 1.0


@inner
def _add_spans_below_one(square: Floats, begin: float, end: float, spans: Floats, count: int, first_only: bool) -> int:
    """Add the intervals on which a polynomial is below 1 to the spans, in order, and return how many there are.

    Intervals that follow each other within `MIN_CONFLICT` are joined.
    """
    waiting = [(square, begin, end)]
    while len(waiting) > 0:
        b, since, until = waiting.pop()
        if b.min() >= 1.0:
            continue
        if b.max() >= 1.0 and until - since > MIN_CONFLICT:
            left, right = halve(b)
            middle = (since + until) / 2
            waiting.append((right, middle, until))
            waiting.append((left, since, middle))
            continue
        if first_only:
            spans[0, 0], spans[0, 1] = since, until
            return 1
        share, least = _minimum(b)
        when = since + (until - since) * share
        if count > 0 and since - spans[count - 1, 1] <= MIN_CONFLICT:
            spans[count - 1, 1] = until
        elif count < MAX_SPANS:
            spans[count, 0], spans[count, 1], spans[count, 3] = since, until, np.inf
            count += 1
        else:
            spans[count - 1, 1] = until
        if least < spans[count - 1, 3]:
            spans[count - 1, 2], spans[count - 1, 3] = when, least
    return count


@inner
def _value(b: Floats, u: float) -> float:
    """Return the value of a polynomial after a share u of its interval (de Casteljau)."""
    c = b[:, 0].copy()
    for step in range(1, len(c)):
        for i in range(len(c) - step):
            c[i] = (1.0 - u) * c[i] + u * c[i + 1]
    return c[0]


@inner
def _minimum(b: Floats) -> tuple[float, float]:
    """Return where in its interval, as a share, a polynomial is least, and its value there: sampled, then refined."""
    best, at = np.inf, 0.0
    for i in range(SAMPLES + 1):
        value = _value(b, i / SAMPLES)
        if value < best:
            best, at = value, i / SAMPLES
    low, high = max(at - 1 / SAMPLES, 0.0), min(at + 1 / SAMPLES, 1.0)
    for _ in range(THIRDS):
        u, v = low + (high - low) / 3, high - (high - low) / 3
        if _value(b, u) < _value(b, v):
            high = v
        else:
            low = u
    value = _value(b, (low + high) / 2)
    return ((low + high) / 2, value) if value < best else (at, best)


@kernel
def nearness_at_ends(curves: Curves, a: int, b: int, semi_axis_xy: float, semi_axis_z: float) -> tuple[float, float]:
    """Return the nearness of the points where two curves begin, and of the points where they end."""
    begins = nearness(position_at(curves, a, 0.0), position_at(curves, b, 0.0), semi_axis_xy, semi_axis_z)
    end_a, end_b = position_at(curves, a, curve_duration(curves, a)), position_at(curves, b, curve_duration(curves, b))
    return begins, nearness(end_a, end_b, semi_axis_xy, semi_axis_z)


@kernel
def is_given(span: Floats, begins: float, ends: float, end: float) -> bool:
    """Tell whether a span of conflict follows from the given starts or targets, which nobody can change.

    It does where it begins with the mission, or lasts until its end, and the pair never comes nearer than it is there.

    Parameters
    ----------
    span
        (4,) as from `conflict_spans`.
    begins, ends
        The nearness of the pair's starts and of its targets; 1 or more where they are no conflict.
    end
        Until when the spans were looked for, seconds.
    """
    least = math.sqrt(max(span[3], 0.0)) + SAME_NEARNESS
    at_start = begins < 1.0 and span[0] <= 0.0 and least >= begins
    return at_start or (ends < 1.0 and span[1] >= end and least >= ends)


@inner
def in_conflict(curves: Curves, one: TimedCurve, other: TimedCurve, semi_axis_xy: float, semi_axis_z: float) -> bool:
    """Tell whether two flights are ever in a conflict that is not given by their starts or targets."""
    arrival_one = one.departure + one.time_scale * curve_duration(curves, one.curve)
    arrival_other = other.departure + other.time_scale * curve_duration(curves, other.curve)
    end = max(arrival_one, arrival_other) + 1.0
    begins, ends = nearness_at_ends(curves, one.curve, other.curve, semi_axis_xy, semi_axis_z)
    first_only = min(begins, ends) >= 1.0
    spans = conflict_spans(curves, one, other, semi_axis_xy, semi_axis_z, end, first_only)
    if first_only:
        return len(spans) > 0
    resolvable = 0
    for span in spans:
        resolvable += not is_given(span, begins, ends, end)
    return resolvable > 0
