"""The way over the top: the straight line, lifted over all that it crosses."""

import numpy as np

from skyverse.kernel import kernel
from skyverse.result import Floats
from skyverse.space.world import Space, point_free, segment_free
from skyverse.taut.bends import distance

STATIONS = 48
"""Places of a leg that is blocked where it is lifted."""
ROUNDS = 12
"""How often what is still blocked is looked at more finely."""
MOST = 4096
"""Places at most."""


@kernel
def over_the_top(space: Space, start: Floats, goal: Floats) -> Floats:
    """Return a free way (k, 3) in the upright plane through two free points, empty if none was found.

    It is the least concave one over places that were found free: a string pulled tight over the tops.
    """
    at, height = np.empty(MOST), np.empty(MOST)  # shares of the way across, metres above the straight line
    at[0], height[0], at[1], height[1] = 0.0, 0.0, 1.0, 0.0
    count = 2
    lifts = np.empty(STATIONS + 2)
    a, b = np.empty(3), np.empty(3)
    for _ in range(ROUNDS):
        count = _hull(at, height, count)
        legs = count - 1
        done = True
        for k in range(legs):
            _place(start, goal, at[k], height[k], a)
            _place(start, goal, at[k + 1], height[k + 1], b)
            if segment_free(space, a, b):
                continue
            done = False
            blocked = False
            for s in range(STATIONS + 2):
                share = s / (STATIONS + 1)
                up = height[k] + share * (height[k + 1] - height[k])
                _place(start, goal, at[k] + share * (at[k + 1] - at[k]), up, b)
                lifts[s] = _lift(space, b)
                if lifts[s] == np.inf:
                    return np.empty((0, 3))
                blocked |= lifts[s] > 0.0
            if not blocked:  # something thin: over its middle, then
                lifts[STATIONS // 2] = 1e-3 * distance(start, goal)
            for s in range(1, STATIONS + 1):
                lift = max(lifts[s - 1], lifts[s], lifts[s + 1])
                if lift > 0.0 and count < MOST:
                    share = s / (STATIONS + 1)
                    at[count] = at[k] + share * (at[k + 1] - at[k])
                    height[count] = height[k] + share * (height[k + 1] - height[k]) + lift
                    count += 1
        if done:
            way = np.empty((count, 3))
            for k in range(count):
                _place(start, goal, at[k], height[k], way[k])
            return way
    return np.empty((0, 3))


@kernel
def _place(start: Floats, goal: Floats, share: float, height: float, p: Floats) -> None:
    for axis in range(3):
        p[axis] = start[axis] + share * (goal[axis] - start[axis])
    p[2] += height


@kernel
def _lift(space: Space, p: Floats) -> float:
    """Return by how much a point must be lifted to be free, about; infinite where nothing above it is."""
    if point_free(space, p):
        return 0.0
    q = p.copy()
    step = 1e-3 * (space.high[2] - space.low[2])
    inside, outside = 0.0, step
    while True:
        q[2] = min(p[2] + outside, space.high[2])
        if point_free(space, q):
            break
        if q[2] == space.high[2]:
            return np.inf
        inside = outside
        step *= 1.3
        outside += step
    outside = q[2] - p[2]
    for _ in range(12):
        middle = 0.5 * (inside + outside)
        q[2] = p[2] + middle
        if point_free(space, q):
            outside = middle
        else:
            inside = middle
    return outside


@kernel
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
