"""Paths moved away from the obstacles that they touch, so that a corridor along them has few boxes.

The boxes of a corridor are parallel to the axes. Along a slope, or along a wall that is not, boxes around a path that
touches it would have to be tiny; a little farther away they need not be.
"""

import itertools

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.tolerances import MIN_NORM
from skyverse.search.taut.half_plane import UP, half_plane_path
from skyverse.space.obstacles import Space, with_margin
from skyverse.space.world import World, point_free, segment_free

FIRST_MOVE = 1.2
"""How far bends are moved at first, as a multiple of the distance that the path is to gain."""
FARTHER = 1.7
"""The factor by which the ends of legs that are still too near are moved farther in the next round."""
MAX_ROUNDS = 6
END_DISTANCES = (1.1, 1.6, 2.5)
"""Multiples of that distance at which a point beside an end that is too near is looked for."""
DIRECTIONS = np.array(
    sorted((d for d in itertools.product((0.0, 1.0, -1.0), repeat=3) if any(d)), key=lambda d: (-d[2], np.abs(d).sum()))
)
"""Directions from an end that is too near to an obstacle, straight up first."""


def inset_path(world: World, path: Floats, distance: float) -> Floats | None:
    """Return a free path (k, 3) like a given one (n, 3), but farther from all obstacles except at its ends.

    Bends are moved outwards. From an end that is too near, the path first leads to a point beside it.

    Parameters
    ----------
    world
        With the obstacles.
    path
        A free path, metres.
    distance
        How much farther from the obstacles the path is to be, metres.

    Returns
    -------
    (k, 3) or None
        ``None`` where legs are still too near after `MAX_ROUNDS` and cannot be led over what is below them.
    """
    space = world.space
    widened = with_margin(space, distance)
    begin, end = _point_beside(space, widened, path[0], distance), _point_beside(space, widened, path[-1], distance)
    inner = path[1:-1].copy()
    if len(inner):
        before, after = path[:-2], path[2:]
        to, onward = (np.linalg.norm(inner - other, axis=1)[:, None] for other in (before, after))
        outward = inner - (before * onward + after * to) / np.maximum(to + onward, MIN_NORM)
        outward /= np.maximum(np.linalg.norm(outward, axis=1)[:, None], MIN_NORM)
    else:
        outward = inner
    far = np.full(len(inner), FIRST_MOVE * distance)
    for _ in range(MAX_ROUNDS):
        moved = np.clip(inner + far[:, None] * outward, space.low, space.high)
        whole = np.vstack([path[0] if begin is None else begin, moved, path[-1] if end is None else end])
        near = [False] * (len(whole) - 1)
        for k, (a, b) in enumerate(itertools.pairwise(whole)):
            at_end = (k == 0 and begin is None) or (k == len(whole) - 2 and end is None)
            near[k] = not segment_free(space if at_end else widened, a, b)
        if not any(near):
            break
        for k, is_near in enumerate(near):
            if is_near:
                far[max(k - 1, 0) : k + 1] *= FARTHER
    rows = [whole[:1]]
    for k, (a, b) in enumerate(itertools.pairwise(whole)):
        if near[k]:
            both_free = point_free(widened, a) and point_free(widened, b)
            over = half_plane_path(widened, a, b, UP, np.inf) if both_free else whole[:0]
            if not len(over):
                return None
            rows.append(over[1:-1])
        rows.append(b[None])
    whole = np.vstack([path[:1], *rows, path[-1:]])
    return np.asarray(whole[np.r_[True, np.any(np.diff(whole, axis=0) != 0.0, axis=1)]])


def _point_beside(space: Space, widened: Space, point: Floats, distance: float) -> Floats | None:
    """Return a point that is far enough from all obstacles and in sight of a given one, or that one itself."""
    if point_free(widened, point):
        return point
    for far in END_DISTANCES:
        for way in DIRECTIONS:
            beside = point + far * distance * way
            if point_free(widened, beside) and segment_free(space, point, beside):
                return np.asarray(beside)
    return None
