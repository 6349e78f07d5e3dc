"""The way over the top, or past one side: the straight line, moved that way past all that it crosses."""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.search.taut.bends import distance
from skyverse.space.world import Space, point_free, segment_free

STATIONS = 48
"""Places of a leg that is blocked where it is lifted ..."""
FEW = 8
"""... of a short one, ..."""
SHORT = 0.1
"""... which takes less than this share of the way."""
ROUNDS = 12
"""How often what is still blocked is looked at more finely."""
MOST = 4096
"""Places at most."""
UP = np.array([0.0, 0.0, 1.0])


@kernel
def past(space: Space, start: Floats, goal: Floats, side: Floats, most: float) -> Floats:
    """Return a free way (k, 3) between two free points in the half-plane on one side, empty if none was found.

    It is the least concave one past places that were found free: a string pulled tight over the tops, where the side,
    (3,) of length 1, is up. Ways of `most` metres and more are not looked for.
    """
    at, height = np.empty(MOST), np.empty(MOST)  # shares of the way across, metres beside the straight line
    at[0], height[0], at[1], height[1] = 0.0, 0.0, 1.0, 0.0
    count = 2
    lifts = np.empty(STATIONS + 2)
    a, b = np.empty(3), np.empty(3)
    for _ in range(ROUNDS):
        count = _hull(at, height, count)
        legs = count - 1
        if not _length(start, goal, side, at, height, count) < most:
            break
        done = True
        for k in range(legs):
            _place(start, goal, side, at[k], height[k], a)
            _place(start, goal, side, at[k + 1], height[k + 1], b)
            if segment_free(space, a, b):
                continue
            done = False
            blocked = False
            stations = STATIONS if at[k + 1] - at[k] > SHORT else FEW
            for s in range(stations + 2):
                share = s / (stations + 1)
                up = height[k] + share * (height[k + 1] - height[k])
                _place(start, goal, side, at[k] + share * (at[k + 1] - at[k]), up, b)
                lifts[s] = _lift(space, b, side)
                if lifts[s] == np.inf:
                    return np.empty((0, 3))
                blocked |= lifts[s] > 0.0
            if not blocked:  # something thin: over its middle, then
                lifts[stations // 2] = 1e-3 * distance(start, goal)
            for s in range(1, stations + 1):
                lift = max(lifts[s - 1], lifts[s], lifts[s + 1])
                if lift > 0.0 and count < MOST:
                    share = s / (stations + 1)
                    at[count] = at[k] + share * (at[k + 1] - at[k])
                    height[count] = height[k] + share * (height[k + 1] - height[k]) + lift
                    count += 1
        if done:
            way = np.empty((count, 3))
            for k in range(count):
                _place(start, goal, side, at[k], height[k], way[k])
            return way
    return np.empty((0, 3))


@inner
def _length(start: Floats, goal: Floats, side: Floats, at: Floats, height: Floats, count: int) -> float:
    a, b = np.empty(3), np.empty(3)
    total = 0.0
    for k in range(count - 1):
        _place(start, goal, side, at[k], height[k], a)
        _place(start, goal, side, at[k + 1], height[k + 1], b)
        total += distance(a, b)
    return total


@inner
def _place(start: Floats, goal: Floats, side: Floats, share: float, height: float, p: Floats) -> None:
    for axis in range(3):
        p[axis] = start[axis] + share * (goal[axis] - start[axis]) + height * side[axis]


@inner
def _lift(space: Space, p: Floats, side: Floats) -> float:
    """Return by how much a point must be moved to be free, about; infinite where nothing on that side is."""
    if point_free(space, p):
        return 0.0
    q = np.empty(3)
    most, step = np.inf, 0.0
    for axis in range(3):
        if side[axis] != 0.0:
            face = space.high[axis] if side[axis] > 0.0 else space.low[axis]
            most = min(most, (face - p[axis]) / side[axis])
            step += 1e-3 * abs(side[axis]) * (space.high[axis] - space.low[axis])
    inside, outside = 0.0, min(step, most)
    while not _free_at(space, p, side, outside, q):
        if outside >= most:
            return np.inf
        inside = outside
        step *= 1.3
        outside = min(outside + step, most)
    for _ in range(12):
        middle = 0.5 * (inside + outside)
        if _free_at(space, p, side, middle, q):
            outside = middle
        else:
            inside = middle
    return outside


@inner
def _free_at(space: Space, p: Floats, side: Floats, far: float, q: Floats) -> bool:
    """Tell whether the place so far from p is free; it is written into q."""
    for axis in range(3):
        q[axis] = p[axis] + far * side[axis]
    return point_free(space, q)


@inner
def _hull(at: Floats, height: Floats, count: int) -> int:
    """Leave of places, in place, those on the concave line over all of them, in order; return how many."""
    order = np.argsort(at[:count])
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
