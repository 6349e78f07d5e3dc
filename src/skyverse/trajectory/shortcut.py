"""Fewer waypoints: nodes on a straight line go, and so does whatever a straight line can skip."""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import kernel, writable
from skyverse.numerics.tolerances import COLLINEAR, SEAM_MARGIN
from skyverse.space.world import Space, World, segment_free


def drop_collinear(path: Floats) -> Floats:
    """Return the waypoints (k, 3) of a path (n, 3) without repeated points and those on a straight way ahead."""
    path = np.asarray(path, dtype=np.float64)
    if len(path) < 2:
        return path
    path = path[np.r_[True, np.any(np.diff(path, axis=0) != 0.0, axis=1)]]
    steps = np.diff(path, axis=0)
    across = np.linalg.norm(np.cross(steps[:-1], steps[1:]), axis=1)
    lengths = np.linalg.norm(steps, axis=1)
    turns = across > COLLINEAR * lengths[:-1] * lengths[1:]
    back = np.sum(steps[:-1] * steps[1:], axis=1) < 0.0
    return path[np.r_[True, turns | back, True][: len(path)]]


def shortcut(world: World, waypoints: Floats) -> Floats:
    """Return (k, 3) of the waypoints (n, 3): from each on to the farthest that is in line of sight (exact test).

    A line of sight has a hair of room: it does not slip through the seam of obstacles that touch.
    """
    waypoints = writable(waypoints)
    roomy = world.space._replace(clearance=world.space.clearance + SEAM_MARGIN)
    return waypoints[_farthest_in_sight(roomy, waypoints)]


@kernel
def _farthest_in_sight(space: Space, waypoints: Floats) -> np.ndarray:
    kept = np.zeros(len(waypoints), np.bool_)
    at = 0
    kept[0] = True
    while at < len(waypoints) - 1:
        ahead = len(waypoints) - 1
        while ahead > at + 1 and not segment_free(space, waypoints[at], waypoints[ahead]):
            ahead -= 1
        kept[ahead] = True
        at = ahead
    return kept
