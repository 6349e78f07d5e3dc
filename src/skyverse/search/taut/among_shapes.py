"""Paths among shapes of any kind: over the lattice, over the top and past the sides, then shortened."""

import itertools
import math
from collections.abc import Callable

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.norm import distance, length_of
from skyverse.numerics.tolerances import MERGE_CONVERGED, SLOPE_MARGIN, STRAIGHT_ENOUGH
from skyverse.search.lazy_theta_star import lazy_theta_star
from skyverse.search.path_shortening.merge_bends import merge_bends
from skyverse.search.path_shortening.shortcut import drop_repeated
from skyverse.search.path_shortening.shorten import shorten
from skyverse.search.taut.half_plane import half_plane_path
from skyverse.space.lattice import Grid, position, positions
from skyverse.space.obstacles import Space, with_margin
from skyverse.space.world import path_free, point_free, segment_free

SPARE_LENGTH = 0.1
"""Paths past one side that are longer than the shortest by more than this share are not shortened."""
MAX_MERGES = 4
"""How often bends are merged and the path is shortened again at most."""
SIDES = 8
"""Sides of the straight line past which paths are tried."""


def path_among_shapes(
    space: Space,
    grid: Grid,
    ends: tuple[Floats, Floats],
    nodes: tuple[int, int],
    lattice_path: Callable[[], tuple[Ints, int]],
) -> tuple[Floats, int]:
    """Return a path (k, 3) between two free points, empty if none was found, and the lattice nodes expanded for it.

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
    lattice_path
        Finds a shortest path on the lattice between these nodes: its nodes, none where there is none, and how many were
        expanded.
    """
    if segment_free(space, *ends):
        return np.stack(ends), 0
    spaced = with_margin(space, SLOPE_MARGIN)
    first, last = (_spaced_end(space, spaced, end) for end in ends)
    best, least = np.empty((0, 3)), np.inf
    tried: list[Floats] = []
    most = np.inf
    if first is not None and last is not None:
        for side in _sides(first, last):
            path = half_plane_path(spaced, first, last, side, most)
            if len(path):
                tried.append(path)
                most = min(most, (1.0 + SPARE_LENGTH) * length_of(path))
    for path in sorted(tried, key=length_of):
        if length_of(path) <= most:
            path = _between_ends(space, _shortest_nearby(spaced, path), ends)
            if length_of(path) < least:
                best, least = path, length_of(path)
    if min(nodes) < 0 or least < (1.0 + STRAIGHT_ENOUGH) * distance(*ends):
        return best, 0
    slack = distance(ends[0], position(grid, nodes[0])) + distance(ends[1], position(grid, nodes[1]))
    slack += 4.0 * float(grid.step.max())  # what a lattice path may gain when it is shortened
    corners, expanded = lazy_theta_star(grid, space, *nodes, least + slack)
    shortest, more = lattice_path()
    for found in (corners, shortest):
        if not len(found):
            continue
        places = positions(grid, found)
        for free, begin, end in ((spaced, first, last), (space, *ends)):
            if begin is None or end is None:
                continue
            path = drop_repeated(np.vstack([begin, places, end]))
            if path_free(free, path):
                path = _between_ends(space, _shortest_nearby(free, path), ends)
                if length_of(path) < least:
                    best, least = path, length_of(path)
                break
    return best, expanded + more


def _sides(start: Floats, goal: Floats) -> list[Floats]:
    """Return eight sides of a straight line, (3,) unit vectors across it; the first one is up."""
    east, north = goal[:2] - start[:2]
    flat = math.hypot(east, north)
    left = np.array([-north, east, 0.0]) / flat if flat > 0.0 else np.array([1.0, 0.0, 0.0])
    up = np.array([0.0, 0.0, 1.0]) if flat > 0.0 else np.array([0.0, 1.0, 0.0])
    return [math.cos(turn) * up + math.sin(turn) * left for turn in np.arange(SIDES) * (2.0 * math.pi / SIDES)]


def _shortest_nearby(space: Space, path: Floats) -> Floats:
    """Shorten a free path, then merge its bends and shorten it again while that helps."""
    best = shorten(space, path)
    for _ in range(MAX_MERGES):
        path = shorten(space, merge_bends(space, best))
        gain = length_of(best) - length_of(path)
        best = path if gain > 0.0 else best
        if gain < MERGE_CONVERGED * length_of(best):
            break
    return best


def _spaced_end(space: Space, spaced: Space, point: Floats) -> Floats | None:
    """Return an end that is free with the slope margin as it is, else such a point beside it that it sees, or none."""
    if point_free(spaced, point):
        return point
    for margins in (2.0, 8.0, 32.0):
        for x, y, z in ((0, 0, 1), *itertools.product((0, 1, -1), repeat=3)):
            beside = point + margins * SLOPE_MARGIN * np.array([x, y, z], dtype=np.float64)
            if point_free(spaced, beside) and segment_free(space, point, beside):
                return beside
    return None


def _between_ends(space: Space, path: Floats, ends: tuple[Floats, Floats]) -> Floats:
    """Return a path from its true start to its true goal, without the points beside these where they are not needed."""
    whole = drop_repeated(np.vstack([ends[0], path, ends[1]]))
    for end, near, next_ in ((0, 1, 2), (-1, -2, -3)):
        close = len(whole) > 2 and distance(whole[near], whole[end]) < 100.0 * SLOPE_MARGIN
        if close and segment_free(space, whole[end], whole[next_]):
            whole = np.delete(whole, near, axis=0)
    return whole
