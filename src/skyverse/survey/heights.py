"""The altitudes along a strip: between what the photos need at least and at most, with as few bends as possible."""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner_query, kernel
from skyverse.numerics.tolerances import TUBE_ROUNDING


@kernel
def gentle(at: Floats, z: Floats, steepest: float, side: float) -> Floats:
    """Return the greatest heights (n,) nowhere above z that are nowhere steeper, or with a `side` of -1 the least.

    Parameters
    ----------
    at
        (n,) metres along the way, rising.
    z
        (n,) metres.
    steepest
        Metres of height a metre.
    side
        1 for the greatest below, -1 for the least above.
    """
    found = side * z
    for i in range(1, len(z)):
        found[i] = min(found[i], found[i - 1] + steepest * (at[i] - at[i - 1]))
    for i in range(len(z) - 2, -1, -1):
        found[i] = min(found[i], found[i + 1] + steepest * (at[i + 1] - at[i]))
    return side * found


def linked(points: Floats, at: Floats, high: Floats, steepest: float, least: float) -> Floats:
    """Return points (m, 2) of a polyline near a given one, none of whose links is shorter than `least` metres.

    It bends at places as far from each other as that, and is nowhere above heights (n,) at places (n,). A link that
    alone is shorter is less steep by as much.
    """
    if (np.diff(points[:, 0]) >= least).all():
        return points
    nodes = np.linspace(at[0], at[-1], max(int((at[-1] - at[0]) / least), 1) + 1)
    z = np.interp(nodes, points[:, 0], points[:, 1])
    z = gentle(nodes, z, steepest * min((nodes[1] - nodes[0]) / least, 1.0), 1.0)
    z -= max(float((np.interp(at, nodes, z) - high).max()), 0.0)
    bends = np.abs(np.diff(z, 2)) > TUBE_ROUNDING
    return np.column_stack([nodes, z])[np.r_[True, bends, True]]


@inner_query
def _cut(lines: Floats, count: int, at: float, most: float, side: float, cut: Floats) -> int:
    """Keep the lines with side * (z at a place) <= side * most; return how many corners the kept ones have.

    Lines are points of a convex polygon (n, 2): their slope, and their z at the place 0.
    """
    kept = 0
    for i in range(count):
        k = i - 1 if i > 0 else count - 1
        before = side * (lines[k, 1] + lines[k, 0] * at - most)
        here = side * (lines[i, 1] + lines[i, 0] * at - most)
        if (before > TUBE_ROUNDING) != (here > TUBE_ROUNDING) and before != here:
            share = min(max(before / (before - here), 0.0), 1.0)
            for axis in range(2):
                cut[kept, axis] = lines[k, axis] + share * (lines[i, axis] - lines[k, axis])
            kept += 1
        if here <= TUBE_ROUNDING:
            cut[kept, 0], cut[kept, 1] = lines[i, 0], lines[i, 1]
            kept += 1
    return kept


@inner_query
def _highest(lines: Floats, count: int, at: float, side: float) -> int:
    """Return the line that is highest at a place, or with a `side` of -1 the lowest."""
    best = 0
    for i in range(1, count):
        if side * (lines[i, 1] + lines[i, 0] * at) > side * (lines[best, 1] + lines[best, 0] * at):
            best = i
    return best


@kernel
def fewest_points(at: Floats, low: Floats, high: Floats, steepest: float) -> Floats:
    """Return the fewest points (m, 2) whose polyline is at each place between the least and the greatest height.

    Each link is a line through as many places as possible. Where no line goes on, all that is beyond is seen from the
    last part of the line that comes nearest to going on: from where it last touches the far side of the tube to where
    it leaves the tube. The next link begins there, wherever on that part suits it. So no polyline has fewer points:
    the greedy algorithm of Imai and Iri (1987), with all lines kept as a convex polygon of slopes and heights.

    Parameters
    ----------
    at
        (n,) metres along the way, rising.
    low, high
        (n,) metres: the least and the greatest z, such that a way between them that is nowhere too steep exists.
    steepest
        Metres of height a metre that the way may rise or fall at most.

    Returns
    -------
    Floats
        Along and z of each point, metres; empty where the limits leave no way.
    """
    n = len(at)
    points = np.empty((n + 2, 2))
    lines, cut, left = np.empty((2 * n + 12, 2)), np.empty((2 * n + 12, 2)), np.empty((2 * n + 12, 2))
    _start(lines, steepest, low[0], high[0])
    size, origin, first, links, j = 4, at[0], 0, 0, 1
    slope, height, begin, end = 0.0, 0.0, at[0], at[0]  # the line of the link before, and the part to begin from
    while True:
        while j < n:
            kept = _cut(lines, size, at[j] - origin, high[j], 1.0, cut)
            kept = _cut(cut, kept, at[j] - origin, low[j], -1.0, left)
            if kept == 0:
                break
            lines[:kept] = left[:kept]
            size, j = kept, j + 1
        where, side = (at[j] if j < n else 0.5 * (at[first] + at[n - 1])) - origin, 1.0
        best = _highest(lines, size, where, side)
        if j < n and lines[best, 1] + lines[best, 0] * where > low[j]:
            side = -1.0
            best = _highest(lines, size, where, side)
        old_slope, old_height = slope, height
        slope = lines[best, 0]
        height = lines[best, 1] + slope * (at[0] - origin)
        bend = at[0]
        if links > 0:
            turn = old_slope - slope
            bend = min(max(at[0] + (height - old_height) / turn, begin), end) if turn != 0.0 else end
        points[links, 0], points[links, 1] = bend, height + slope * (bend - at[0])
        links += 1
        if j == n:
            points[links, 0], points[links, 1] = at[n - 1], height + slope * (at[n - 1] - at[0])
            return points[: links + 1]
        touched, left_by = (high, low) if side > 0.0 else (low, high)
        for i in range(first, j):
            if side * (touched[i] - height - slope * (at[i] - at[0])) <= 10.0 * TUBE_ROUNDING:
                first = i
        begin = origin = at[first]
        inside = max(side * (height + slope * (at[j - 1] - at[0]) - left_by[j - 1]), 0.0)
        beyond = side * (left_by[j] - height - slope * (at[j] - at[0]))
        end = max(at[j - 1] + inside / (inside + beyond) * (at[j] - at[j - 1]), begin)
        edge = height + slope * (end - at[0])
        limit = touched[first]
        rise = steepest * (end - begin)
        _start(lines, steepest, min(limit, edge - rise), max(limit, edge + rise))
        size = _cut(lines, 4, 0.0, limit, side, cut)
        size = _cut(cut, size, end - origin, edge, -side, lines)
        for i in range(first + 1, j):
            size = _cut(lines, size, at[i] - origin, touched[i], side, cut)
            lines[:size] = cut[:size]
        if size == 0:
            return points[:0]


@inner_query
def _start(lines: Floats, steepest: float, low: float, high: float) -> None:
    """Set the first four lines: all that are between two heights at the place 0, and not too steep."""
    for i in range(4):
        lines[i, 0] = steepest if i in (1, 2) else -steepest
        lines[i, 1] = low if i < 2 else high
