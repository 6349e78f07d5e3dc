"""Bends close together replaced by one: the point at which the legs before and after them meet.

A shortest path round a cylinder has many bends close together, each of which would slow a UAV down. The legs before and
after some of them meet on the outside of the curve, where one bend takes the place of all.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats
from skyverse.numerics.tolerances import MIN_CROSS_PRODUCT
from skyverse.space.obstacles import Space
from skyverse.space.world import segment_free


class MovedWaypoints(NamedTuple):
    """Waypoints that may have taken the place of others.

    Attributes
    ----------
    points
        (n, 3) metres.
    moved
        (n,) how far the legs beside these are from the path at most, metres.
    """

    points: Floats
    moved: Floats


def merge_bends(space: Space, path: Floats, slow: Bools, most: float) -> MovedWaypoints:
    """Return waypoints of which as many in a row as possible are replaced by one.

    Parameters
    ----------
    space
        With the obstacles, of which legs are clear.
    path
        (n, 3) metres, whose legs are free.
    slow
        (n - 1,) whether each leg may vanish.
    most
        How far legs that take the place of others may be from the path, metres.
    """
    kept, spans = [path[0]], [(0, 0)]
    k = 1
    while k < len(path) - 1:
        last, end = k, k
        while end < len(path) - 2 and slow[end]:
            end += 1
        point = path[k]
        while end > last:
            middle = (last + end + 1) // 2
            found = _meeting(path, k, middle, most)
            if (
                found is not None
                and segment_free(space, kept[-1], found)
                and segment_free(space, found, path[middle + 1])
                and _farthest(kept[-1], found, path[spans[-1][0] : middle + 1]) <= most
                and _farthest(found, path[middle + 1], path[k : middle + 2]) <= most
            ):
                last, point = middle, found
            else:
                end = middle - 1
        kept.append(point)
        spans.append((k, last))
        k = last + 1
    points = np.vstack([*kept, path[-1]])
    return MovedWaypoints(points, _moved(points, path, [*spans, (len(path) - 1, len(path) - 1)]))


def _moved(points: Floats, path: Floats, spans: Sequence[tuple[int, int]]) -> Floats:
    """Return how far the legs beside each point are from a path at most, (k,) metres.

    The points, (k, 3), take the places of the waypoints from the first to the last in `spans`.
    """
    legs = np.zeros(len(points) - 1)
    for k, ((first, end), (begin, last)) in enumerate(pairwise(spans)):
        if first < end or begin < last:
            legs[k] = _farthest(points[k], points[k + 1], path[first : last + 1])
    return np.maximum(np.r_[0.0, legs], np.r_[legs, 0.0])


def _farthest(a: Floats, b: Floats, path: Floats) -> float:
    """Return a distance, metres, that no place between `a` and `b` is farther from a path (n, 3).

    The distance from one leg of the path is convex, so that it is largest at an end of any part of the way from `a` to
    `b`. The least of these over all legs bounds the part. Parts end beside the path's corners, where the nearest leg
    changes.
    """
    way, starts, ways = b - a, path[:-1], path[1:] - path[:-1]
    passed = np.sum((path - a) * way, axis=1) / max(float(np.sum(way**2)), np.finfo(float).tiny)
    shares = np.sort(np.r_[0.0, np.clip(passed, 0.0, 1.0), 1.0])
    places = (a + shares[:, None] * way)[:, None] - starts
    along = np.clip(np.sum(places * ways, axis=2) / np.sum(ways * ways, axis=1), 0.0, 1.0)
    off = places - along[:, :, None] * ways
    squares = np.sum(off * off, axis=2)
    return math.sqrt(np.maximum(squares[:-1], squares[1:]).min(axis=1).max())


def _meeting(path: Floats, first: int, last: int, most: float) -> Floats | None:
    """Return where the legs before waypoint `first` and after waypoint `last` meet.

    Where they pass each other it is moved outwards by the distance between them. ``None`` where they do not meet on the
    outside of a curve, or farther from the path than `most`.
    """
    before, after = path[first] - path[first - 1], path[last] - path[last + 1]
    gap = path[last] - path[first]
    mixed, squares = np.sum(before * after), (np.sum(before**2), np.sum(after**2))
    gained, lost = np.sum(before * gap), np.sum(after * gap)
    determinant = squares[0] * squares[1] - mixed * mixed
    if determinant <= MIN_CROSS_PRODUCT * squares[0] * squares[1]:
        return None
    on = (squares[1] * gained - mixed * lost) / determinant
    back = (mixed * gained - squares[0] * lost) / determinant
    if on < 0.0 or back < 0.0:
        return None
    ahead, behind = path[first] + on * before, path[last] + back * after
    meeting = 0.5 * (ahead + behind)
    starts, ways = path[first:last], np.diff(path[first : last + 1], axis=0)
    shares = np.clip(np.sum((meeting - starts) * ways, axis=1) / np.sum(ways * ways, axis=1), 0.0, 1.0)
    outward = meeting - starts - shares[:, None] * ways
    outward = outward[np.argmin(np.sum(outward * outward, axis=1))]
    away, apart = math.hypot(*outward), math.dist(ahead, behind)
    turns = np.diff(ways / np.linalg.norm(ways, axis=1)[:, None], axis=0)
    if away == 0.0 or away + apart > most or (np.sum(turns * outward, axis=1) > 0.0).any():
        return None
    return np.asarray(meeting + apart / away * outward)
