"""A path over the top of everything, or past one side of it: the straight line, moved that way past what it crosses."""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.arrays import order_of
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.norm import distance
from skyverse.space.obstacles import Space
from skyverse.space.world import point_free, segment_free

STATIONS = 48
"""Places on a blocked leg at which it is asked how far the leg must be moved."""
FEW_STATIONS = 8
"""The same on a short leg."""
SHORT_LEG = 0.1
"""The share of the straight line below which a leg is short."""
MAX_ROUNDS = 12
"""How often legs that are still blocked are refined at most."""
MAX_PLACES = 4096
"""Places of the path at most, also those that are dropped later."""
LIFT_BISECTIONS = 12
"""How often the interval between a blocked and a free distance is halved."""
LIFT_STEP = 1e-3
"""The first step aside from a blocked place, as a share of the bounds' extent or of the straight line."""
STEP_GROWTH = 1.3
"""By which factor each step aside is longer than the one before."""
UP = np.array([0.0, 0.0, 1.0])


@kernel
def half_plane_path(space: Space, start: Floats, goal: Floats, side: Floats, most: float) -> Floats:
    """Return a free path (k, 3) between two free points in the half-plane on one side of their straight line.

    Where the side, (3,) of length 1, is up, the path is the shortest one over all places that were found to be free: a
    concave line of heights over the straight line. It is empty if none is found, or none shorter than `most` metres.
    """
    at, height = np.empty(MAX_PLACES), np.empty(MAX_PLACES)  # shares of the straight line, metres beside it
    at[0], height[0], at[1], height[1] = 0.0, 0.0, 1.0, 0.0
    count = 2
    lifts = np.empty(STATIONS + 2)
    a, b = np.empty(3), np.empty(3)
    for _ in range(MAX_ROUNDS):
        count = _keep_upper_hull(at, height, count)
        legs = count - 1
        if not _length(start, goal, side, at, height, count) < most:
            break
        done = True
        for k in range(legs):
            _write_place(start, goal, side, at[k], height[k], a)
            _write_place(start, goal, side, at[k + 1], height[k + 1], b)
            if segment_free(space, a, b):
                continue
            done = False
            blocked = False
            stations = STATIONS if at[k + 1] - at[k] > SHORT_LEG else FEW_STATIONS
            for s in range(stations + 2):
                share = s / (stations + 1)
                up = height[k] + share * (height[k + 1] - height[k])
                _write_place(start, goal, side, at[k] + share * (at[k + 1] - at[k]), up, b)
                lifts[s] = _lift(space, b, side)
                if lifts[s] == np.inf:
                    return np.empty((0, 3))
                blocked |= lifts[s] > 0.0
            if not blocked:  # something thin stands between two stations: lift the leg's middle
                lifts[stations // 2] = LIFT_STEP * distance(start, goal)
            for s in range(1, stations + 1):
                lift = max(lifts[s - 1], lifts[s], lifts[s + 1])
                if lift > 0.0 and count < MAX_PLACES:
                    share = s / (stations + 1)
                    at[count] = at[k] + share * (at[k + 1] - at[k])
                    height[count] = height[k] + share * (height[k + 1] - height[k]) + lift
                    count += 1
        if done:
            path = np.empty((count, 3))
            for k in range(count):
                _write_place(start, goal, side, at[k], height[k], path[k])
            return path
    return np.empty((0, 3))


@inner
def _length(start: Floats, goal: Floats, side: Floats, at: Floats, height: Floats, count: int) -> float:
    """Return the length of the path over the first `count` places, metres."""
    a, b = np.empty(3), np.empty(3)
    total = 0.0
    for k in range(count - 1):
        _write_place(start, goal, side, at[k], height[k], a)
        _write_place(start, goal, side, at[k + 1], height[k + 1], b)
        total += distance(a, b)
    return total


@inner
def _write_place(start: Floats, goal: Floats, side: Floats, share: float, height: float, p: Floats) -> None:
    """Write into `p` the point a share of the straight line on, and `height` metres beside it."""
    for axis in range(3):
        p[axis] = start[axis] + share * (goal[axis] - start[axis]) + height * side[axis]


@inner
def _lift(space: Space, p: Floats, side: Floats) -> float:
    """Return about how many metres a point must be moved to that side to be free; infinite if it leaves the bounds."""
    if point_free(space, p):
        return 0.0
    q = np.empty(3)
    most, step = np.inf, 0.0
    for axis in range(3):
        if side[axis] != 0.0:
            face = space.high[axis] if side[axis] > 0.0 else space.low[axis]
            most = min(most, (face - p[axis]) / side[axis])
            step += LIFT_STEP * abs(side[axis]) * (space.high[axis] - space.low[axis])
    inside, outside = 0.0, min(step, most)
    while not _free_at(space, p, side, outside, q):
        if outside >= most:
            return np.inf
        inside = outside
        step *= STEP_GROWTH
        outside = min(outside + step, most)
    for _ in range(LIFT_BISECTIONS):
        middle = 0.5 * (inside + outside)
        if _free_at(space, p, side, middle, q):
            outside = middle
        else:
            inside = middle
    return outside


@inner
def _free_at(space: Space, p: Floats, side: Floats, metres: float, q: Floats) -> bool:
    """Write into `q` the point so many metres from `p` to that side; tell whether it is free."""
    for axis in range(3):
        q[axis] = p[axis] + metres * side[axis]
    return point_free(space, q)


@inner
def _keep_upper_hull(at: Floats, height: Floats, count: int) -> int:
    """Keep, in place and in order, the places on the upper convex hull of the first `count`; return how many."""
    order = order_of(at[:count])
    x, y = at[:count][order], height[:count][order]
    kept = 0
    for i in range(count):
        if kept and x[i] == at[kept - 1]:
            if y[i] <= height[kept - 1]:
                continue
            kept -= 1
        while kept > 1:
            rise, run = height[kept - 1] - height[kept - 2], at[kept - 1] - at[kept - 2]
            if rise * (x[i] - at[kept - 2]) > (y[i] - height[kept - 2]) * run:
                break
            kept -= 1
        at[kept], height[kept] = x[i], y[i]
        kept += 1
    return kept
