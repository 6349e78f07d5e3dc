"""Ways among shapes of any kind: over the lattice and over the top, each pulled tight, the shorter taken."""

import itertools

import numpy as np

from skyverse.result import Floats
from skyverse.space.box import TOLERANCE
from skyverse.space.lattice import Grid, position, positions
from skyverse.space.world import Space, point_free, segment_free
from skyverse.taut.bends import distance
from skyverse.taut.lazy import lazy_theta_star
from skyverse.taut.over import over_the_top
from skyverse.taut.pull import pull
from skyverse.taut.tighten import length_of

HAIR = 1e-5
"""Metres of room that bends keep beside the clearance: what touches a slope exactly is hard to prove."""


def beyond_boxes(space: Space) -> bool:
    """Tell whether there are other obstacles than boxes: solids, or the ground."""
    return len(space.solids.kind) > 0 or space.ground.heights.size > 0


def way_among(space: Space, grid: Grid, ends: tuple[Floats, Floats], nodes: tuple[int, int]) -> tuple[Floats, int]:
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
    """
    if segment_free(space, *ends):
        return np.stack(ends), 0
    roomy = space._replace(clearance=space.clearance + HAIR)
    closed = space._replace(clearance=space.clearance + 2.0 * TOLERANCE)
    first, last = (_with_room(space, roomy, end) for end in ends)
    best, least = np.empty((0, 3)), np.inf
    over = np.empty((0, 3)) if first is None or last is None else over_the_top(roomy, first, last)
    if len(over):
        best = _ended(space, pull(roomy, over), ends)
        least = length_of(best)
    if min(nodes) < 0:
        return best, 0
    slack = distance(ends[0], position(grid, nodes[0])) + distance(ends[1], position(grid, nodes[1]))
    slack += 4.0 * float(grid.step.max())  # what is gained when it is pulled tight
    corners, expanded = lazy_theta_star(grid, closed, *nodes, least + slack)
    if len(corners):
        places = positions(grid, corners)
        for tight, begin, end in ((roomy, first, last), (closed, *ends), (space, *ends)):
            if begin is None or end is None:
                continue
            way = np.vstack([begin, places, end])
            way = way[np.r_[True, np.any(np.diff(way, axis=0) != 0.0, axis=1)]]
            if all(segment_free(tight, a, b) for a, b in itertools.pairwise(way)):
                way = _ended(space, pull(tight, way), ends)
                if length_of(way) < least:
                    best = way
                break
    return best, expanded


def _with_room(space: Space, roomy: Space, point: Floats) -> Floats | None:
    """Return a free point as it is, or one beside it with a hair of room, in a straight free line."""
    if point_free(roomy, point):
        return point
    for far in (2.0, 8.0, 32.0):
        for x, y, z in ((0, 0, 1), *itertools.product((0, 1, -1), repeat=3)):
            beside = point + far * HAIR * np.array([x, y, z], dtype=np.float64)
            if point_free(roomy, beside) and segment_free(space, point, beside):
                return beside
    return None


def _ended(space: Space, way: Floats, ends: tuple[Floats, Floats]) -> Floats:
    """Return a way from its true start to its true goal."""
    whole = np.vstack([ends[0], way, ends[1]])
    whole = whole[np.r_[True, np.any(np.diff(whole, axis=0) != 0.0, axis=1)]]
    for end, near, past in ((0, 1, 2), (-1, -2, -3)):  # the points with room, where they are not needed
        close = len(whole) > 2 and distance(whole[near], whole[end]) < 100.0 * HAIR
        if close and segment_free(space, whole[end], whole[past]):
            whole = np.delete(whole, near, axis=0)
    return whole
