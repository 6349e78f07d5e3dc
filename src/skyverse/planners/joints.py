"""Small moves of a path of straight legs: they change its joints, in place, and return how many points it has then.

Ends stay. Where a move does not apply, or there is no room for another joint, nothing changes.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.cost import Rates
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners.straight import Course
from skyverse.space import ground
from skyverse.space.solids import Solids

_CHANCES = np.cumsum(np.array([4.0, 1.0, 1.0, 0.5, 0.7, 1.0, 1.0, 1.0]))
"""Of nudge, insert, drop, smooth, level, shift, detour and dodge: shares that an experiment found good, added up."""


@kernel
def small_move(course: Course, rng: np.random.Generator, path: Floats, n: int, reach: float) -> int:
    """Do one of the moves below, drawn at random; `reach` is the share of the bounds that it may go."""
    if n == 2:
        return insert(course, rng, path, n, reach) if rng.random() < 0.5 else dodge(course, rng, path, n)
    kind = np.searchsorted(_CHANCES, rng.random() * _CHANCES[-1], side="right")
    if kind == 0:
        return nudge(course, rng, path, n, reach)
    if kind == 1:
        return insert(course, rng, path, n, reach)
    if kind == 2:
        return drop(rng, path, n)
    if kind == 3:
        return smooth(rng, path, n)
    if kind == 4:
        return level(course, rng, path, n)
    if kind == 5:
        return shift(course, rng, path, n, reach)
    if kind == 6:
        return detour(course, rng, path, n, reach)
    return dodge(course, rng, path, n)


@inner
def nudge(course: Course, rng: np.random.Generator, path: Floats, n: int, reach: float) -> int:
    """Move one joint: across, up or down, or both."""
    j = 1 + int(rng.random() * (n - 2))
    _push(course, rng, path[j], reach, int(rng.random() * 3))
    return n


@inner
def _push(course: Course, rng: np.random.Generator, point: Floats, reach: float, how: int) -> None:
    low, high = course.space.low, course.space.high
    for axis in range(3):
        if how == 2 or (axis == 2) == (how == 1):
            point[axis] += reach * (high[axis] - low[axis]) * rng.standard_normal()
    hold(course, point)


@inner
def insert(course: Course, rng: np.random.Generator, path: Floats, n: int, reach: float) -> int:
    """Put a joint into one leg, and move it."""
    leg = int(rng.random() * (n - 1))
    share = rng.random()
    if not _open(path, n, leg + 1):
        return n
    for axis in range(3):
        path[leg + 1, axis] = path[leg, axis] + share * (path[leg + 2, axis] - path[leg, axis])
    _push(course, rng, path[leg + 1], reach, 2)
    return n + 1


@inner
def _open(path: Floats, n: int, at: int) -> bool:
    """Make room for a point at a place."""
    if n == len(path):
        return False
    for i in range(n, at, -1):
        for axis in range(3):
            path[i, axis] = path[i - 1, axis]
    return True


@inner
def drop(rng: np.random.Generator, path: Floats, n: int) -> int:
    """Fly straight past one joint, or several in a row."""
    first = 1 + int(rng.random() * (n - 2))
    count = 1 if rng.random() < 0.7 else 1 + int(rng.random() * (n - 1 - first))
    for i in range(first, n - count):
        for axis in range(3):
            path[i, axis] = path[i + count, axis]
    return n - count


@inner
def smooth(rng: np.random.Generator, path: Floats, n: int) -> int:
    """Draw one joint towards the straight line between its neighbours."""
    j = 1 + int(rng.random() * (n - 2))
    before, after = math.sqrt(((path[j] - path[j - 1]) ** 2).sum()), math.sqrt(((path[j + 1] - path[j]) ** 2).sum())
    if before + after > 0.0:
        share, pull = before / (before + after), rng.random()
        for axis in range(3):
            on_line = path[j - 1, axis] + share * (path[j + 1, axis] - path[j - 1, axis])
            path[j, axis] += pull * (on_line - path[j, axis])
    return n


@inner
def level(course: Course, rng: np.random.Generator, path: Floats, n: int) -> int:
    """Bring the altitude of a stretch of joints into the band, or to that of a neighbour, or on the way between two."""
    first = 1 + int(rng.random() * (n - 2))
    last = first + int(rng.random() * rng.random() * (n - 1 - first))
    how = int(rng.random() * 3)
    z = path[first - 1, 2] if rng.random() < 0.5 else path[last + 1, 2]
    into = how == 0 and course.rates.altitude > 0.0
    height = rng.random() if into else 0.0
    for j in range(first, last + 1):
        if into:
            z = in_band(course.rates, height, path[j])
        if how == 2:
            share = (j - first + 1) / (last - first + 2)
            z = path[first - 1, 2] + share * (path[last + 1, 2] - path[first - 1, 2])
        path[j, 2] = z
        hold(course, path[j])
    return n


@inner
def shift(course: Course, rng: np.random.Generator, path: Floats, n: int, reach: float) -> int:
    """Move a stretch of joints by the same way."""
    first = 1 + int(rng.random() * (n - 2))
    last = first + int(rng.random() * (n - 1 - first))
    way = np.zeros(3)
    how = int(rng.random() * 3)
    for axis in range(3):
        if how == 2 or (axis == 2) == (how == 1):
            way[axis] = reach * (course.space.high[axis] - course.space.low[axis]) * rng.standard_normal()
    for j in range(first, last + 1):
        for axis in range(3):
            path[j, axis] += way[axis]
        hold(course, path[j])
    return n


@inner
def dodge(course: Course, rng: np.random.Generator, path: Floats, n: int) -> int:
    """Lead a leg past a corner of an obstacle or zone: put a joint there, or move the one that is next to it."""
    place = np.empty(3)
    leg = int(rng.random() * (n - 1))
    share = rng.random()
    for axis in range(3):
        place[axis] = path[leg, axis] + share * (path[leg + 1, axis] - path[leg, axis])
    if not beside(course, rng, place):
        return n
    if n > 2 and (n == len(path) or rng.random() < 0.5):
        j = min(max(leg + int(rng.random() * 2), 1), n - 2)
    elif _open(path, n, leg + 1):
        j = leg + 1
        n += 1
    else:
        return n
    for axis in range(3):
        path[j, axis] = place[axis]
    hold(course, path[j])
    return n


@inner
def beside(course: Course, rng: np.random.Generator, place: Floats) -> bool:
    """Replace a place by one just outside an obstacle or zone drawn at random, at its altitude or just above or below.

    Returns
    -------
    bool
        Whether there is any.
    """
    space, rates = course.space, course.rates
    boxes, obstacles = len(space.boxes), len(space.boxes) + len(space.solids.kind)
    if obstacles + len(rates.order) == 0:
        return False
    pick = int(rng.random() * (obstacles + len(rates.order)))
    over = rng.random() < 0.2
    room = 1e-3 * (1.0 + 30.0 * rng.random() ** 4) * max(space.high[0] - space.low[0], space.high[1] - space.low[1])
    growth = 0.0 if pick >= obstacles else space.clearance
    solids = rates.zones if pick >= obstacles else space.solids
    i = pick if pick < boxes else pick - boxes if pick < obstacles else rates.order[pick - obstacles]
    bounds = space.boxes if pick < boxes else solids.bounds
    if over:
        place[2] = bounds[i, 2] - growth - room if rng.random() < 0.3 else bounds[i, 5] + growth + room
    elif pick < boxes:
        _aside(bounds, i, rng, growth + room, place)
    else:
        _around(solids, i, rng, growth + room, place)
    return True


@inner
def _aside(bounds: Floats, i: int, rng: np.random.Generator, room: float, place: Floats) -> None:
    place[0] = bounds[i, 0] - room if rng.random() < 0.5 else bounds[i, 3] + room
    place[1] = bounds[i, 1] - room if rng.random() < 0.5 else bounds[i, 4] + room


@inner
def _around(solids: Solids, i: int, rng: np.random.Generator, room: float, place: Floats) -> None:
    """Move a place to one of a prism's corners, or beside a cylinder or sphere, or a box."""
    first, count = solids.kind[i, 1], solids.kind[i, 2] - solids.kind[i, 1]
    if count:
        x = solids.edges[first : first + count, 0].mean()
        y = solids.edges[first : first + count, 1].mean()
        corner = solids.edges[first + int(rng.random() * count)]
        far = math.sqrt((corner[0] - x) ** 2 + (corner[1] - y) ** 2)
        stretch = 1.0 + room / far if far > 0.0 else 1.0
        place[0], place[1] = x + stretch * (corner[0] - x), y + stretch * (corner[1] - y)
    elif solids.round[i, 3] > 0.0:  # on the side where it is, or anywhere about
        x, y, radius = solids.round[i, 0], solids.round[i, 1], solids.round[i, 3]
        angle = math.atan2(place[1] - y, place[0] - x)
        angle = angle + rng.standard_normal() if rng.random() < 0.7 else 2.0 * math.pi * rng.random()
        place[0] = x + (radius * (1.0 + 0.1 * rng.random()) + room) * math.cos(angle)
        place[1] = y + (radius * (1.0 + 0.1 * rng.random()) + room) * math.sin(angle)
    else:
        _aside(solids.bounds, i, rng, room, place)


@inner
def in_band(rates: Rates, share: float, p: Floats) -> float:
    """Return the z at a share of the band of altitudes, over a place."""
    floor = ground.height(rates.ground, p[0], p[1]) if rates.above else 0.0
    return floor + rates.low + share * (rates.high - rates.low)


@inner
def detour(course: Course, rng: np.random.Generator, path: Floats, n: int, reach: float) -> int:
    """Lead a stretch through one via-point: beside a threat, or near where it went."""
    a = int(rng.random() * (n - 1))
    b = a + 1 + int(rng.random() * (n - 1 - a))
    if b == a + 1:
        if not _open(path, n, b):
            return n
        n += 1
        b += 1
    via, share = path[a + 1], rng.random()
    for axis in range(3):
        via[axis] = path[a, axis] + share * (path[b, axis] - path[a, axis])
    if rng.random() < 0.5:
        beside(course, rng, via)
    else:
        _push(course, rng, via, reach, int(rng.random() * 3))
    if course.rates.altitude > 0.0 and rng.random() < 0.3:
        via[2] = in_band(course.rates, rng.random(), via)
    hold(course, via)
    gone = b - a - 2
    for i in range(b, n if gone else b):
        for axis in range(3):
            path[i - gone, axis] = path[i, axis]
    return n - gone


@inner
def hold(course: Course, point: Floats) -> None:
    """Bring a point back into the bounds."""
    for axis in range(3):
        point[axis] = min(max(point[axis], course.space.low[axis]), course.space.high[axis])
