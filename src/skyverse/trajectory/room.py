"""Room for a corridor: a path drawn off the shapes that it touches.

Free boxes stand upright. Along a slope, or a wall that no axis follows, those that keep to a taut path would have to be
tiny; a little farther off they need not be.
"""

import itertools

import numpy as np

from skyverse._typing import Floats
from skyverse.search.taut.half_plane import UP, half_plane_path
from skyverse.space.world import Space, World, point_free, segment_free

_TRIES = 6
"""How often legs that are still too near are drawn off farther."""
_FARTHER = 1.7
_BESIDE = np.array(
    sorted((d for d in itertools.product((0.0, 1.0, -1.0), repeat=3) if any(d)), key=lambda d: (-d[2], np.abs(d).sum()))
)
"""Ways off from an end that is too near to something, the one straight up first."""


def with_room(world: World, path: Floats, room: float) -> Floats | None:
    """Return a free path (k, 3) like a given one (n, 3), but so many metres farther off all but at its ends.

    Bends go outwards. An end that is too near is left, and come back to, by the shortest way. ``None`` where that does
    not do.
    """
    space = world.space
    roomy = space._replace(clearance=space.clearance + room)
    begin, end = _off(space, roomy, path[0], room), _off(space, roomy, path[-1], room)
    inner = path[1:-1].copy()
    if len(inner):
        before, after = path[:-2], path[2:]
        to, onward = (np.linalg.norm(inner - other, axis=1)[:, None] for other in (before, after))
        outward = inner - (before * onward + after * to) / np.maximum(to + onward, 1e-12)
        outward /= np.maximum(np.linalg.norm(outward, axis=1)[:, None], 1e-12)
    else:
        outward = inner
    far = np.full(len(inner), 1.2 * room)
    for _ in range(_TRIES):
        moved = np.clip(inner + far[:, None] * outward, space.low, space.high)
        whole = np.vstack([path[0] if begin is None else begin, moved, path[-1] if end is None else end])
        near = [False] * (len(whole) - 1)
        for k, (a, b) in enumerate(itertools.pairwise(whole)):
            at_end = (k == 0 and begin is None) or (k == len(whole) - 2 and end is None)
            near[k] = not segment_free(space if at_end else roomy, a, b)
        if not any(near):
            break
        for k, is_near in enumerate(near):
            if is_near:
                far[max(k - 1, 0) : k + 1] *= _FARTHER
    rows = [whole[:1]]
    for k, (a, b) in enumerate(itertools.pairwise(whole)):
        if near[k]:
            over = (
                half_plane_path(roomy, a, b, UP, np.inf) if point_free(roomy, a) and point_free(roomy, b) else whole[:0]
            )
            if not len(over):
                return None
            rows.append(over[1:-1])
        rows.append(b[None])
    whole = np.vstack([path[:1], *rows, path[-1:]])
    return np.asarray(whole[np.r_[True, np.any(np.diff(whole, axis=0) != 0.0, axis=1)]])


def _off(space: Space, roomy: Space, point: Floats, room: float) -> Floats | None:
    """Return a point with room, in a straight free line from one that may be without."""
    if point_free(roomy, point):
        return point
    for far in (1.1, 1.6, 2.5):
        for way in _BESIDE:
            beside = point + far * room * way
            if point_free(roomy, beside) and segment_free(space, point, beside):
                return np.asarray(beside)
    return None
