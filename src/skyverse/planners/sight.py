"""Lines of sight that no seam lets through, and paths pulled tight along them."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import SAMPLED_CONVERGED, SHORTER, SURFACE_DEPTH
from skyverse.space.world import Space, segment_free

FINEST = 1.0 / 64.0
"""The smallest share of its reach by which `pull_tight` moves a corner, and of a leg that it cuts off."""


def without_seams(space: Space) -> Space:
    """Return the space with closed obstacles: `segment_free` then refuses a segment that only touches one.

    The world's obstacles are open, so that what touches them is safe, and a segment could slip between two that touch
    each other. The lattice's obstacles are closed: each of its moves is a line of sight here.
    """
    return space._replace(clearance=space.clearance + 2.0 * SURFACE_DEPTH)


@kernel
def pull_tight(space: Space, reach: float, path: Floats) -> Floats:
    """Return a path (k, 3) of straight legs with the same ends as `path` (n, 3), and never a longer one.

    Corners go where their neighbours see each other, slide to where the path is shorter, at most `reach` metres an
    axis at first and ever smaller shares of it later, and are cut off, which leaves two for one; all again while it
    helps.
    """
    path = path.copy()
    count = len(path)
    before = math.inf
    while count > 2:
        count = _drop(space, path, count)
        share = 1.0
        while share >= FINEST:
            moved = False
            for i in range(1, count - 1):
                moved |= _slide(space, share * reach, path, i)
            if moved:
                count = _drop(space, path, count)
            else:
                share /= 2.0
        now = length_of(path, count)
        if now > before * (1.0 - SAMPLED_CONVERGED):
            break
        before = now
        path, count = _cut(space, path, count)
    return path[:count].copy()


@inner
def _drop(space: Space, path: Floats, count: int) -> int:
    """Drop, in place, each corner whose neighbours see each other; return how many rows are left."""
    kept = 1
    for i in range(1, count):
        if i == count - 1 or not segment_free(space, path[kept - 1], path[i + 1]):
            for axis in range(3):
                path[kept, axis] = path[i, axis]
            kept += 1
    return kept


@inner
def _slide(space: Space, reach: float, path: Floats, i: int) -> bool:
    """Move corner i to the first of 26 places around it that makes the path shorter; tell whether one does."""
    before, after = path[i - 1], path[i + 1]
    place = np.empty(3)
    shorter = (far(before, path[i]) + far(path[i], after)) * (1.0 - SHORTER)
    for code in range(27):
        place[0] = path[i, 0] + (code // 9 - 1) * reach
        place[1] = path[i, 1] + (code // 3 % 3 - 1) * reach
        place[2] = path[i, 2] + (code % 3 - 1) * reach
        if (
            far(before, place) + far(place, after) < shorter
            and segment_free(space, before, place)
            and segment_free(space, place, after)
        ):
            for axis in range(3):
                path[i, axis] = place[axis]
            return True
    return False


@inner
def _cut(space: Space, path: Floats, count: int) -> tuple[Floats, int]:
    """Return a path with each corner cut off as far out as its legs see each other, and how many rows it has."""
    cut = np.empty((2 * count - 2, 3))
    cut[0] = path[0]
    last = 0
    for i in range(1, count - 1):
        share = 0.5
        while share >= FINEST:
            for axis in range(3):
                cut[last + 1, axis] = path[i, axis] + share * (cut[last, axis] - path[i, axis])
                cut[last + 2, axis] = path[i, axis] + share * (path[i + 1, axis] - path[i, axis])
            if segment_free(space, cut[last + 1], cut[last + 2]):
                break
            share /= 2.0
        if share >= FINEST:
            last += 2
        else:
            last += 1
            cut[last] = path[i]
    cut[last + 1] = path[count - 1]
    return cut, last + 2


@inner
def far(a: Floats, b: Floats) -> float:
    """Return the metres between two places (3,)."""
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@kernel
def length_of(path: Floats, count: int) -> float:
    """Return the length of the first `count` rows of a path (n, 3), metres."""
    total = 0.0
    for i in range(1, count):
        total += far(path[i - 1], path[i])
    return total
