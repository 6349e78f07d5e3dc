"""Places where a cheap path may bend: beside, over and under obstacles and zones that are near the straight line."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.cost import Rates
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.norm import distance
from skyverse.space import ground
from skyverse.space.obstacles import Space, in_bounds
from skyverse.space.solids import Solids
from skyverse.space.world import point_free

AROUND = 6
"""How many places there are around a cylinder or a sphere, and at most around a prism."""


@kernel
def bend_points(space: Space, rates: Rates, start: Floats, goal: Floats, gap: float, most: int) -> Floats:
    """Return places (k, 3), metres, where a path from start to goal may bend.

    Parameters
    ----------
    space, rates
        The obstacles, and the zones that have a price.
    start, goal
        (3,) metres.
    gap
        How far from obstacles, grown by the clearance, and from zones the places are, metres.
    most
        About how many places there are at most: obstacles and zones are taken in the order of the way by them.
    """
    boxes, solids, zones = len(space.boxes), len(space.solids.kind), len(rates.zones.kind)
    by_way = np.empty(boxes + solids + zones)
    middle = np.empty(3)
    for i in range(len(by_way)):
        low_high = _bounds(space, rates, i)
        for axis in range(3):
            middle[axis] = min(max((start[axis] + goal[axis]) / 2, low_high[axis]), low_high[axis + 3])
        by_way[i] = distance(start, middle) + distance(middle, goal)
    found = np.empty((most + 3 * (AROUND + 1), 3))
    count = 0
    for i in np.argsort(by_way):
        if count >= most:
            break
        if i < boxes + solids:
            growth, group, k = space.clearance + gap, space.solids, i - boxes
        else:
            growth, group, k = gap, rates.zones, i - boxes - solids
        bounds = _bounds(space, rates, i)
        around = _columns_around(bounds, group, k, growth)
        for j in range(len(around)):
            x, y = around[j, 0], around[j, 1]
            beside = j < len(around) - 1
            for level in range(0 if beside else 1, 3):
                place = found[count]
                place[0], place[1] = x, y
                if level == 0:
                    place[2] = usual_altitude(rates, start, goal, x, y, 0.5)
                else:
                    place[2] = bounds[5] + growth if level == 1 else bounds[2] - growth
                if in_bounds(space, place) and point_free(space, place):
                    count += 1
    return found[:count].copy()


@inner
def _bounds(space: Space, rates: Rates, i: int) -> Floats:
    """Return the corners (6,) of the box around an obstacle or zone: boxes, other obstacles and zones in a row."""
    boxes, solids = len(space.boxes), len(space.solids.kind)
    if i < boxes:
        return space.boxes[i]
    if i < boxes + solids:
        return space.solids.bounds[i - boxes]
    return rates.zones.bounds[i - boxes - solids]


@inner
def _columns_around(bounds: Floats, solids: Solids, k: int, growth: float) -> Floats:
    """Return x and y of places around one obstacle or zone, grown by so many metres, and of its middle, (n, 2)."""
    x, y = (bounds[0] + bounds[3]) / 2, (bounds[1] + bounds[4]) / 2
    first = corners = 0
    radius = 0.0
    if k >= 0:
        first, corners = solids.kind[k, 1], solids.kind[k, 2] - solids.kind[k, 1]
        radius = solids.round[k, 3]
    sides = min(corners, AROUND) if corners else AROUND if radius > 0.0 else 4
    columns = np.empty((sides + 1, 2))
    columns[sides, 0], columns[sides, 1] = x, y
    for side in range(sides):
        if corners:
            corner = solids.edges[first + side * corners // sides]
            px, py = corner[0] - x, corner[1] - y
            far = math.sqrt(px * px + py * py)
            stretch = 1.0 + growth / far if far > 0.0 else 1.0
            columns[side, 0], columns[side, 1] = x + stretch * px, y + stretch * py
        elif radius > 0.0:
            angle = 2.0 * math.pi * side / sides
            far = (radius + growth) / math.cos(math.pi / sides)
            columns[side, 0], columns[side, 1] = x + far * math.cos(angle), y + far * math.sin(angle)
        else:
            columns[side, 0] = bounds[0] - growth if side % 2 else bounds[3] + growth
            columns[side, 1] = bounds[1] - growth if side < 2 else bounds[4] + growth
    return columns


@inner
def usual_altitude(rates: Rates, start: Floats, goal: Floats, x: float, y: float, share_up: float) -> float:
    """Return z of the middle of the altitude band above a point, or else of the line from start to goal beside it."""
    if rates.altitude > 0.0:
        floor = ground.height(rates.ground, x, y) if rates.above else 0.0
        return floor + rates.low + share_up * (rates.high - rates.low)
    dx, dy = goal[0] - start[0], goal[1] - start[1]
    square = dx * dx + dy * dy
    share = ((x - start[0]) * dx + (y - start[1]) * dy) / square if square > 0.0 else 0.0
    return start[2] + min(max(share, 0.0), 1.0) * (goal[2] - start[2])
