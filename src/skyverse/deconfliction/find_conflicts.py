"""Find which UAVs of a fleet come too close to each other, and when: every pair, at every instant."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.deconfliction.curves import (
    Curves,
    Schedule,
    TimedCurve,
    curve_duration,
    make_curves,
    piece_at,
    piece_between,
    position_at,
    stay_at_start,
)
from skyverse.deconfliction.pair_conflicts import conflict_spans, is_given, nearness_at_ends
from skyverse.errors import InputError, require_kind
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import strayed_share
from skyverse.model.verdict import Conflict
from skyverse.numerics.arrays import order_of
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import MIN_HORIZON, SEPARATION_FORGIVEN

SLICE = 0.25
"""Seconds of a slice of time: pairs whose bounding boxes are far apart in every slice need no closer look."""
MAX_SLICES = 4096
"""Slices of a mission at most; those of a mission that lasts longer than 17 minutes are longer."""


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
    end = last_arrival(curves, schedule, absent)
    wide, tall = (axes.max(axis=1, initial=0.0) for axes in (semi_axis_xy, semi_axis_z))
    for a, b in close_pairs(curves, schedule, wide, tall, end):
        xy, z = float(semi_axis_xy[a, b]), float(semi_axis_z[a, b])
        one, other = TimedCurve(a, departure[a], 1.0), TimedCurve(b, departure[b], 1.0)
        spans = conflict_spans(curves, one, other, xy, z, max(end, MIN_HORIZON), False)
        begins, ends = nearness_at_ends(curves, a, b, xy, z)
        if absent[a] or absent[b]:
            ends = np.inf
        untrimmed = (xy + SEPARATION_FORGIVEN, xy + SEPARATION_FORGIVEN, z + SEPARATION_FORGIVEN)
        for span in spans:
            since, until, when, _ = span.tolist()
            given = is_given(span, begins, ends, end)
            here, there = position_at(curves, a, when - departure[a]), position_at(curves, b, when - departure[b])
            x, y, height = ((here + there) / 2).tolist()
            near = math.hypot(*((here - there) / untrimmed))
            pair = (int(a), int(b))
            found.append(Conflict(pair, since, min(until, end), min(when, end), near, (x, y, height), bool(given)))
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


def last_arrival(curves: Curves, schedule: Schedule, absent: NDArray[np.bool_]) -> float:
    """Return when the last of the UAVs that fly arrives, seconds; 0 if none flies."""
    ends = [
        departure + scale * curve_duration(curves, c)
        for c, departure, scale, none in zip(*(column.tolist() for column in schedule), absent, strict=True)
        if not none
    ]
    return float(max(ends, default=0.0))


@kernel
def close_pairs(curves: Curves, schedule: Schedule, semi_axis_xy: Floats, semi_axis_z: Floats, end: float) -> Ints:
    """Return the pairs (m, 2) of flights that may be in conflict: their boxes are too close in some slice of time.

    In each slice the flights' bounding boxes are sorted along x and swept.
    """
    n = len(schedule.curve)
    slices = min(max(int(np.ceil(end / SLICE)), 1), MAX_SLICES)
    near = np.zeros((n, n), np.bool_)
    low, high = np.empty((n, 3)), np.empty((n, 3))
    for s in range(slices):
        since, until = end * s / slices, end * (s + 1) / slices
        for i in range(n):
            _bounding_box(curves, schedule, i, since, until, low[i], high[i])
        order = order_of(low[:, 0].copy())
        largest = semi_axis_xy.max() if n > 0 else 0.0
        for p in range(n):
            i = order[p]
            for q in range(p + 1, n):
                j = order[q]
                if low[j, 0] - high[i, 0] > largest:
                    break
                xy, z = max(semi_axis_xy[i], semi_axis_xy[j]), max(semi_axis_z[i], semi_axis_z[j])
                if (
                    xy > 0.0
                    and low[j, 0] - high[i, 0] < xy
                    and low[j, 1] - high[i, 1] < xy
                    and low[i, 1] - high[j, 1] < xy
                    and low[j, 2] - high[i, 2] < z
                    and low[i, 2] - high[j, 2] < z
                ):
                    near[min(i, j), max(i, j)] = True
    found = np.empty((near.sum(), 2), np.int64)
    count = 0
    for i in range(n):
        for j in range(i + 1, n):
            if near[i, j]:
                found[count, 0], found[count, 1] = i, j
                count += 1
    return found


@inner
def _bounding_box(
    curves: Curves, schedule: Schedule, i: int, since: float, until: float, low: Floats, high: Floats
) -> None:
    """Write the corners of a box around flight i during a slice of time."""
    c, at, scale = schedule.curve[i], schedule.departure[i], schedule.time_scale[i]
    u, v = max((since - at) / scale, 0.0), min((until - at) / scale, curve_duration(curves, c))
    here = position_at(curves, c, min(max(u, 0.0), curve_duration(curves, c)))
    for axis in range(3):
        low[axis] = high[axis] = here[axis]
    if v <= u:
        return
    for k in range(piece_at(curves, c, u), piece_at(curves, c, v) + 1):
        if k < curves.first[c + 1]:
            rows = piece_between(curves, k, max(u, curves.begin[k]), min(v, curves.begin[k] + curves.duration[k]))
            for row in rows:
                for axis in range(3):
                    low[axis] = min(low[axis], row[axis])
                    high[axis] = max(high[axis], row[axis])
