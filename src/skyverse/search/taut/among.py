"""Ways among shapes of any kind: over the lattice, over the top and past the sides, pulled tight."""

import itertools
import math
from collections.abc import Callable

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.tolerances import MERGE_CONVERGED, SLOPE_MARGIN, STRAIGHT_ENOUGH, SURFACE_DEPTH
from skyverse.search.taut.bends import distance
from skyverse.search.taut.lazy import lazy_theta_star
from skyverse.search.taut.over import past
from skyverse.search.taut.pull import pull, slacken
from skyverse.search.taut.tighten import length_of
from skyverse.space.lattice import Grid, position, positions
from skyverse.space.world import Space, point_free, segment_free

SPARE = 0.1
"""Ways past one side that are longer than the shortest by more than this share are left as they are."""
AGAIN = 4
"""How often a way is slackened and pulled tight again, at most."""

Route = Callable[[], tuple[Ints, int]]


def beyond_boxes(space: Space) -> bool:
    """Tell whether there are other obstacles than boxes: solids, or the ground."""
    return len(space.solids.kind) > 0 or space.ground.heights.size > 0


def way_among(
    space: Space, grid: Grid, ends: tuple[Floats, Floats], nodes: tuple[int, int], route: Route
) -> tuple[Floats, int]:
    """Return a way (k, 3) between two free points, empty if none was found, and the lattice nodes expanded for it.

    Parameters
    ----------
    space
        Any.
    grid
        A lattice over it.
    ends
        Start and goal, (3,) metres each.
    nodes
        The lattice nodes that stand for them, -1 for none.
    route
        Of the lattice's own shortest routes from node to node: the nodes of one, none where there is none, and how many
        were expanded.
    """
    if segment_free(space, *ends):
        return np.stack(ends), 0
    roomy = space._replace(clearance=space.clearance + SLOPE_MARGIN)
    closed = space._replace(clearance=space.clearance + 2.0 * SURFACE_DEPTH)
    first, last = (_with_room(space, roomy, end) for end in ends)
    best, least = np.empty((0, 3)), np.inf
    thrown: list[Floats] = []
    most = np.inf
    if first is not None and last is not None:
        for side in _sides(first, last):
            way = past(roomy, first, last, side, most)
            if len(way):
                thrown.append(way)
                most = min(most, (1.0 + SPARE) * length_of(way))
    for way in sorted(thrown, key=length_of):
        if length_of(way) <= most:
            way = _ended(space, _tight(roomy, way), ends)
            if length_of(way) < least:
                best, least = way, length_of(way)
    if min(nodes) < 0 or least < (1.0 + STRAIGHT_ENOUGH) * distance(*ends):
        return best, 0
    slack = distance(ends[0], position(grid, nodes[0])) + distance(ends[1], position(grid, nodes[1]))
    slack += 4.0 * float(grid.step.max())  # what is gained when it is pulled tight
    corners, expanded = lazy_theta_star(grid, closed, *nodes, least + slack)
    shortest, more = route()
    for found in (corners, shortest):
        if not len(found):
            continue
        places = positions(grid, found)
        for tight, begin, end in ((roomy, first, last), (closed, *ends), (space, *ends)):
            if begin is None or end is None:
                continue
            way = np.vstack([begin, places, end])
            way = way[np.r_[True, np.any(np.diff(way, axis=0) != 0.0, axis=1)]]
            if all(segment_free(tight, a, b) for a, b in itertools.pairwise(way)):
                way = _ended(space, _tight(tight, way), ends)
                if length_of(way) < least:
                    best, least = way, length_of(way)
                break
    return best, expanded + more


def _sides(start: Floats, goal: Floats) -> list[Floats]:
    """Return eight sides (3,) of a straight line, up first."""
    east, north = goal[:2] - start[:2]
    flat = math.hypot(east, north)
    left = np.array([-north, east, 0.0]) / flat if flat > 0.0 else np.array([1.0, 0.0, 0.0])
    up = np.array([0.0, 0.0, 1.0]) if flat > 0.0 else np.array([0.0, 1.0, 0.0])
    return [math.cos(turn) * up + math.sin(turn) * left for turn in np.arange(8) * (math.pi / 4.0)]


def _tight(space: Space, way: Floats) -> Floats:
    """Pull a way tight, and again with few bends for many while that helps."""
    best = pull(space, way)
    for _ in range(AGAIN):
        way = pull(space, slacken(space, best))
        gain = length_of(best) - length_of(way)
        best = way if gain > 0.0 else best
        if gain < MERGE_CONVERGED * length_of(best):
            break
    return best


def _with_room(space: Space, roomy: Space, point: Floats) -> Floats | None:
    """Return a free point as it is, or one beside it with a hair of room, in a straight free line."""
    if point_free(roomy, point):
        return point
    for far in (2.0, 8.0, 32.0):
        for x, y, z in ((0, 0, 1), *itertools.product((0, 1, -1), repeat=3)):
            beside = point + far * SLOPE_MARGIN * np.array([x, y, z], dtype=np.float64)
            if point_free(roomy, beside) and segment_free(space, point, beside):
                return beside
    return None


def _ended(space: Space, way: Floats, ends: tuple[Floats, Floats]) -> Floats:
    """Return a way from its true start to its true goal."""
    whole = np.vstack([ends[0], way, ends[1]])
    whole = whole[np.r_[True, np.any(np.diff(whole, axis=0) != 0.0, axis=1)]]
    for end, near, next_ in ((0, 1, 2), (-1, -2, -3)):  # the points with room, where they are not needed
        close = len(whole) > 2 and distance(whole[near], whole[end]) < 100.0 * SLOPE_MARGIN
        if close and segment_free(space, whole[end], whole[next_]):
            whole = np.delete(whole, near, axis=0)
    return whole
