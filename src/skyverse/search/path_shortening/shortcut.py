"""Drop waypoints: those on a straight line, those that a line of sight skips, those whose neighbours see each other.

A line of sight is a segment that `segment_free` accepts.
"""

import numpy as np

from skyverse._typing import Bools, Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import COLLINEAR
from skyverse.space.obstacles import Space
from skyverse.space.world import segment_free


def drop_repeated(path: Floats) -> Floats:
    """Return a path (n, 3) without the waypoints that equal the one before them, (k, 3)."""
    return np.asarray(path[np.r_[True, np.any(np.diff(path, axis=0) != 0.0, axis=1)]])


def drop_collinear(path: Floats) -> Floats:
    """Return the waypoints (k, 3) of a path (n, 3) at which it turns, and its ends; repeated waypoints are left out."""
    path = np.asarray(path, dtype=np.float64)
    if len(path) < 2:
        return path
    path = drop_repeated(path)
    steps = np.diff(path, axis=0)
    across = np.linalg.norm(np.cross(steps[:-1], steps[1:]), axis=1)
    lengths = np.linalg.norm(steps, axis=1)
    turns = across > COLLINEAR * lengths[:-1] * lengths[1:]
    back = np.sum(steps[:-1] * steps[1:], axis=1) < 0.0
    return path[np.r_[True, turns | back, True][: len(path)]]


@kernel
def shortcut(space: Space, path: Floats) -> Floats:
    """Return some of a path's waypoints (n, 3): from each one, the next is the farthest ahead that it sees, (k, 3)."""
    kept = np.zeros(len(path), np.bool_)
    kept[0] = True
    i = 0
    while i < len(path) - 1:
        ahead = len(path) - 1
        while ahead > i + 1 and not segment_free(space, path[i], path[ahead]):
            ahead -= 1
        kept[ahead] = True
        i = ahead
    return path[kept]


@inner
def drop_redundant(space: Space, path: Floats) -> tuple[Floats, Bools]:
    """Drop each bend whose neighbours see each other, from the path's start on.

    Returns
    -------
    path
        (k, 3) what is left of it.
    kept
        (n,) which of the given waypoints are left.
    """
    kept = np.ones(len(path), np.bool_)
    last = 0
    for i in range(1, len(path) - 1):
        if segment_free(space, path[last], path[i + 1]):
            kept[i] = False
        else:
            last = i
    return path[kept], kept
