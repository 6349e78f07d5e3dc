"""Small random moves of a path of straight legs: each changes its joints in point and returns its new number of points.

The ends stay where they are. A move that does not apply, or that would need more joints than there is room for, changes
nothing.
"""

import math

import numpy as np
from numpy.random import Generator

from skyverse._typing import Floats
from skyverse.cost import Rates
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners.straight_legs import StraightTask
from skyverse.space import ground
from skyverse.space.solids import Solids

_CUMULATIVE_CHANCES = np.cumsum(np.array([4.0, 1.0, 1.0, 0.5, 0.7, 1.0, 1.0, 1.0]))
"""The chances of nudge, insert, drop, smooth, level, shift, detour and dodge, added up; an experiment chose them."""


@kernel
def small_move(task: StraightTask, rng: Generator, path: Floats, n: int, reach: float) -> int:
    """Do one of the moves below, chosen at random; `reach` is its typical length as a share of the bounds' extent."""
    if n == 2:
        return insert(task, rng, path, n, reach) if rng.random() < 0.5 else dodge(task, rng, path, n)
    kind = np.searchsorted(_CUMULATIVE_CHANCES, rng.random() * _CUMULATIVE_CHANCES[-1], side="right")
    if kind == 0:
        return nudge(task, rng, path, n, reach)
    if kind == 1:
        return insert(task, rng, path, n, reach)
    if kind == 2:
        return drop(rng, path, n)
    if kind == 3:
        return smooth(rng, path, n)
    if kind == 4:
        return level(task, rng, path, n)
    if kind == 5:
        return shift(task, rng, path, n, reach)
    if kind == 6:
        return detour(task, rng, path, n, reach)
    return dodge(task, rng, path, n)


@inner
def nudge(task: StraightTask, rng: Generator, path: Floats, n: int, reach: float) -> int:
    """Move one joint horizontally, vertically or both."""
    j = 1 + int(rng.random() * (n - 2))
    _perturb(task, rng, path[j], reach, int(rng.random() * 3))
    return n


@inner
def _perturb(task: StraightTask, rng: Generator, point: Floats, reach: float, how: int) -> None:
    """Move a point by a normally distributed step: horizontally (0), vertically (1) or both (2)."""
    low, high = task.space.low, task.space.high
    for axis in range(3):
        if how == 2 or (axis == 2) == (how == 1):
            point[axis] += reach * (high[axis] - low[axis]) * rng.standard_normal()
    clamp_to_bounds(task, point)


@inner
def insert(task: StraightTask, rng: Generator, path: Floats, n: int, reach: float) -> int:
    """Insert a joint into one leg, and move it."""
    leg = int(rng.random() * (n - 1))
    share = rng.random()
    if not _make_room(path, n, leg + 1):
        return n
    for axis in range(3):
        path[leg + 1, axis] = path[leg, axis] + share * (path[leg + 2, axis] - path[leg, axis])
    _perturb(task, rng, path[leg + 1], reach, 2)
    return n + 1


@inner
def _make_room(path: Floats, n: int, at: int) -> bool:
    """Shift the points of a path from index `at` on by one, unless the path is full; tell whether there was room."""
    if n == len(path):
        return False
    for i in range(n, at, -1):
        for axis in range(3):
            path[i, axis] = path[i - 1, axis]
    return True


@inner
def drop(rng: Generator, path: Floats, n: int) -> int:
    """Remove one joint, or several in a row."""
    first = 1 + int(rng.random() * (n - 2))
    count = 1 if rng.random() < 0.7 else 1 + int(rng.random() * (n - 1 - first))
    for i in range(first, n - count):
        for axis in range(3):
            path[i, axis] = path[i + count, axis]
    return n - count


@inner
def smooth(rng: Generator, path: Floats, n: int) -> int:
    """Move one joint towards the straight line between its neighbours."""
    j = 1 + int(rng.random() * (n - 2))
    before, after = math.sqrt(((path[j] - path[j - 1]) ** 2).sum()), math.sqrt(((path[j + 1] - path[j]) ** 2).sum())
    if before + after > 0.0:
        share, weight = before / (before + after), rng.random()
        for axis in range(3):
            on_line = path[j - 1, axis] + share * (path[j + 1, axis] - path[j - 1, axis])
            path[j, axis] += weight * (on_line - path[j, axis])
    return n


@inner
def level(task: StraightTask, rng: Generator, path: Floats, n: int) -> int:
    """Change the altitude of consecutive joints: into the band, to a neighbour's, or between both neighbours'."""
    first = 1 + int(rng.random() * (n - 2))
    last = first + int(rng.random() * rng.random() * (n - 1 - first))
    how = int(rng.random() * 3)
    z = path[first - 1, 2] if rng.random() < 0.5 else path[last + 1, 2]
    into = how == 0 and task.rates.altitude > 0.0
    height = rng.random() if into else 0.0
    for j in range(first, last + 1):
        if into:
            z = altitude_in_band(task.rates, height, path[j])
        if how == 2:
            share = (j - first + 1) / (last - first + 2)
            z = path[first - 1, 2] + share * (path[last + 1, 2] - path[first - 1, 2])
        path[j, 2] = z
        clamp_to_bounds(task, path[j])
    return n


@inner
def shift(task: StraightTask, rng: Generator, path: Floats, n: int, reach: float) -> int:
    """Move consecutive joints by the same vector."""
    first = 1 + int(rng.random() * (n - 2))
    last = first + int(rng.random() * (n - 1 - first))
    vector = np.zeros(3)
    how = int(rng.random() * 3)
    for axis in range(3):
        if how == 2 or (axis == 2) == (how == 1):
            vector[axis] = reach * (task.space.high[axis] - task.space.low[axis]) * rng.standard_normal()
    for j in range(first, last + 1):
        for axis in range(3):
            path[j, axis] += vector[axis]
        clamp_to_bounds(task, path[j])
    return n


@inner
def dodge(task: StraightTask, rng: Generator, path: Floats, n: int) -> int:
    """Lead a leg past an obstacle or zone: insert a joint just outside of it, or move a joint next to the leg there."""
    point = np.empty(3)
    leg = int(rng.random() * (n - 1))
    share = rng.random()
    for axis in range(3):
        point[axis] = path[leg, axis] + share * (path[leg + 1, axis] - path[leg, axis])
    if not move_beside_threat(task, rng, point):
        return n
    if n > 2 and (n == len(path) or rng.random() < 0.5):
        j = min(max(leg + int(rng.random() * 2), 1), n - 2)
    elif _make_room(path, n, leg + 1):
        j = leg + 1
        n += 1
    else:
        return n
    for axis in range(3):
        path[j, axis] = point[axis]
    clamp_to_bounds(task, path[j])
    return n


@inner
def move_beside_threat(task: StraightTask, rng: Generator, point: Floats) -> bool:
    """Move a point to just outside a random obstacle or zone: beside it at the same altitude, or above or below it.

    Returns
    -------
    bool
        Whether there is any obstacle or zone.
    """
    space, rates = task.space, task.rates
    boxes, obstacles = len(space.boxes), len(space.boxes) + len(space.solids.kind)
    if obstacles + len(rates.order) == 0:
        return False
    pick = int(rng.random() * (obstacles + len(rates.order)))
    over = rng.random() < 0.2
    gap = 1e-3 * (1.0 + 30.0 * rng.random() ** 4) * max(space.high[0] - space.low[0], space.high[1] - space.low[1])
    growth = 0.0 if pick >= obstacles else space.clearance
    solids = rates.zones if pick >= obstacles else space.solids
    i = pick if pick < boxes else pick - boxes if pick < obstacles else rates.order[pick - obstacles]
    bounds = space.boxes if pick < boxes else solids.bounds
    if over:
        point[2] = bounds[i, 2] - growth - gap if rng.random() < 0.3 else bounds[i, 5] + growth + gap
    elif pick < boxes:
        _move_beside_box(bounds, i, rng, growth + gap, point)
    else:
        _move_beside_solid(solids, i, rng, growth + gap, point)
    return True


@inner
def _move_beside_box(bounds: Floats, i: int, rng: Generator, gap: float, point: Floats) -> None:
    """Move a point beside a random vertical edge of a box, `gap` metres outside of it on both horizontal axes."""
    point[0] = bounds[i, 0] - gap if rng.random() < 0.5 else bounds[i, 3] + gap
    point[1] = bounds[i, 1] - gap if rng.random() < 0.5 else bounds[i, 4] + gap


@inner
def _move_beside_solid(solids: Solids, i: int, rng: Generator, gap: float, point: Floats) -> None:
    """Move a point beside a corner of a prism, a cylinder, a sphere or another solid's box, `gap` metres outside."""
    first, count = solids.kind[i, 1], solids.kind[i, 2] - solids.kind[i, 1]
    if count:
        x = solids.edges[first : first + count, 0].mean()
        y = solids.edges[first : first + count, 1].mean()
        corner = solids.edges[first + int(rng.random() * count)]
        far = math.sqrt((corner[0] - x) ** 2 + (corner[1] - y) ** 2)
        stretch = 1.0 + gap / far if far > 0.0 else 1.0
        point[0], point[1] = x + stretch * (corner[0] - x), y + stretch * (corner[1] - y)
    elif solids.round[i, 3] > 0.0:  # mostly on the side where the point is
        x, y, radius = solids.round[i, 0], solids.round[i, 1], solids.round[i, 3]
        angle = math.atan2(point[1] - y, point[0] - x)
        angle = angle + rng.standard_normal() if rng.random() < 0.7 else 2.0 * math.pi * rng.random()
        point[0] = x + (radius * (1.0 + 0.1 * rng.random()) + gap) * math.cos(angle)
        point[1] = y + (radius * (1.0 + 0.1 * rng.random()) + gap) * math.sin(angle)
    else:
        _move_beside_box(solids.bounds, i, rng, gap, point)


@inner
def altitude_in_band(rates: Rates, share: float, p: Floats) -> float:
    """Return the z at a share, 0 to 1, of the objective's band of altitudes over a point."""
    floor = ground.height(rates.ground, p[0], p[1]) if rates.above else 0.0
    return floor + rates.low + share * (rates.high - rates.low)


@inner
def detour(task: StraightTask, rng: Generator, path: Floats, n: int, reach: float) -> int:
    """Lead a stretch of the path through one via-point, beside a threat or near where the stretch was."""
    a = int(rng.random() * (n - 1))
    b = a + 1 + int(rng.random() * (n - 1 - a))
    if b == a + 1:
        if not _make_room(path, n, b):
            return n
        n += 1
        b += 1
    via, share = path[a + 1], rng.random()
    for axis in range(3):
        via[axis] = path[a, axis] + share * (path[b, axis] - path[a, axis])
    if rng.random() < 0.5:
        move_beside_threat(task, rng, via)
    else:
        _perturb(task, rng, via, reach, int(rng.random() * 3))
    if task.rates.altitude > 0.0 and rng.random() < 0.3:
        via[2] = altitude_in_band(task.rates, rng.random(), via)
    clamp_to_bounds(task, via)
    removed = b - a - 2
    for i in range(b, n if removed else b):
        for axis in range(3):
            path[i - removed, axis] = path[i, axis]
    return n - removed


@inner
def clamp_to_bounds(task: StraightTask, point: Floats) -> None:
    """Move a point outside the bounds to the nearest one inside."""
    for axis in range(3):
        point[axis] = min(max(point[axis], task.space.low[axis]), task.space.high[axis])
