"""Which UAVs come too close, and when: every pair, at every instant."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.deconfliction.curves import (
    FORGIVEN,
    Curves,
    Placed,
    length,
    make_curves,
    piece_at,
    place,
    standing,
    stretch,
)
from skyverse.deconfliction.meeting import is_given, meetings, near_at_ends
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Conflict
from skyverse.numerics.kernel import inner, kernel

SLICE = 0.25
"""Seconds: for so long UAVs that are nowhere near each other need no closer look."""
MOST_SLICES = 4096


def find_conflicts(scenario: Scenario, trajectories: Sequence[Trajectory | None]) -> tuple[Conflict, ...]:
    """Find all pairs of UAVs that come closer than their separation, in continuous time.

    The relative position of two UAVs is a polynomial between knots; where it enters the ellipsoid is found by cutting
    its Bernstein form in two until nothing is in doubt. A pair that comes too close only for less than a microsecond
    may be named though it does not; none is missed that comes 1e-6 m too close.

    Parameters
    ----------
    scenario
        Whose UAVs and separations.
    trajectories
        One for each UAV; it stands at its start before, and where it ended afterwards. Without one (``None``) it
        stands at its start.

    Returns
    -------
    tuple of Conflict
        By instant: one for each span of time in which a pair is too close. Spans end with the last arrival.

    Raises
    ------
    ValueError
        If there is not one entry for each UAV.
    """
    uavs = scenario.uavs
    if len(trajectories) != len(uavs):
        raise ValueError(f"{len(uavs)} UAVs need as many trajectories (or None), not {len(trajectories)}")
    flown = [standing(uav) if t is None else t for uav, t in zip(uavs, trajectories, strict=True)]
    curves = make_curves(flown)
    absent = np.array([t is None for t in trajectories], dtype=np.bool_)
    at = np.array([0.0 if none else t.start for none, t in zip(absent, flown, strict=True)])
    placed = Placed(np.arange(len(uavs)), at, np.ones(len(uavs)))
    wide, tall = semi_axes(scenario)
    found = []
    end = last_arrival(curves, placed, absent)
    for a, b in close_pairs(curves, placed, wide, tall, end):
        w, t = max(wide[a], wide[b]), max(tall[a], tall[b])
        spans = meetings(curves, a, at[a], 1.0, b, at[b], 1.0, w, t, max(end, 1e-3), False)
        begins, ends = near_at_ends(curves, a, b, w, t)
        if absent[a] or absent[b]:
            ends = np.inf
        true = (w + FORGIVEN, w + FORGIVEN, t + FORGIVEN)
        for span in spans:
            since, until, when, _ = span.tolist()
            given = is_given(span, begins, ends, end)
            one, other = place(curves, a, when - at[a]), place(curves, b, when - at[b])
            x, y, z = ((one + other) / 2).tolist()
            near = float(np.linalg.norm((one - other) / true))
            found.append(
                Conflict((int(a), int(b)), since, min(until, end), min(when, end), near, (x, y, z), bool(given))
            )
    return tuple(sorted(found, key=lambda conflict: (conflict.begin, conflict.uavs)))


def semi_axes(scenario: Scenario) -> tuple[Floats, Floats]:
    """Return what UAVs keep free of others, horizontally and vertically, (n,) metres each, less what is forgiven."""
    axes = np.array([uav.ellipsoid for uav in scenario.uavs]).reshape(-1, 2)
    wide, tall = np.maximum(axes - FORGIVEN, axes / 2).T
    return np.ascontiguousarray(wide), np.ascontiguousarray(tall)


def last_arrival(curves: Curves, placed: Placed, absent: NDArray[np.bool_]) -> float:
    """Return when the last of those who fly arrives, 0 if none does."""
    ends = [
        at + scale * length(curves, c)
        for c, at, scale, none in zip(*(column.tolist() for column in placed), absent, strict=True)
        if not none
    ]
    return float(max(ends, default=0.0))


@kernel
def close_pairs(curves: Curves, placed: Placed, wide: Floats, tall: Floats, end: float) -> Ints:
    """Return the pairs (m, 2) whose boxes, a slice of time after the other, come too close: all that may conflict."""
    n = len(placed.curve)
    slices = min(max(int(np.ceil(end / SLICE)), 1), MOST_SLICES)
    near = np.zeros((n, n), np.bool_)
    low, high = np.empty((n, 3)), np.empty((n, 3))
    for s in range(slices):
        since, until = end * s / slices, end * (s + 1) / slices
        for i in range(n):
            _box(curves, placed, i, since, until, low[i], high[i])
        order = np.argsort(low[:, 0])
        widest = wide.max() if n > 0 else 0.0
        for p in range(n):
            i = order[p]
            for q in range(p + 1, n):
                j = order[q]
                if low[j, 0] - high[i, 0] > widest:
                    break
                room, rise = max(wide[i], wide[j]), max(tall[i], tall[j])
                if (
                    room > 0.0
                    and low[j, 0] - high[i, 0] < room
                    and low[j, 1] - high[i, 1] < room
                    and low[i, 1] - high[j, 1] < room
                    and low[j, 2] - high[i, 2] < rise
                    and low[i, 2] - high[j, 2] < rise
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
def _box(curves: Curves, placed: Placed, i: int, since: float, until: float, low: Floats, high: Floats) -> None:
    """Put a box around flight i in a slice of time."""
    c, at, scale = placed.curve[i], placed.at[i], placed.scale[i]
    u, v = max((since - at) / scale, 0.0), min((until - at) / scale, length(curves, c))
    here = place(curves, c, min(max(u, 0.0), length(curves, c)))
    for axis in range(3):
        low[axis] = high[axis] = here[axis]
    if v <= u:
        return
    for k in range(piece_at(curves, c, u), piece_at(curves, c, v) + 1):
        if k < curves.first[c + 1]:
            rows = stretch(curves, k, max(u, curves.begin[k]), min(v, curves.begin[k] + curves.duration[k]))
            for row in rows:
                for axis in range(3):
                    low[axis] = min(low[axis], row[axis])
                    high[axis] = max(high[axis], row[axis])
