"""A safe corridor: free boxes along a path, each of which overlaps the next.

A box begins as the bounding box of the longest stretch of the path for which it is free, its seed. It is widened by the
reach, and every obstacle that is a box is cut off again by the face that leaves the widest box. Where obstacles of
other shapes or the ground reach into what is left, the box is grown anew from its seed, face by face, as far as it is
free.

The boxes are parallel to the axes. Along a slope, or along a wall that is not, boxes around a path that touches it
would have to be tiny; so there the path is first moved away from what it touches (`inset_path`).
"""

import itertools

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.arrays import order_of, towards
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import CORRIDOR_PROGRESS, MIN_NORM, MIN_OVERLAP, SURFACE_DEPTH, THIN_OVERLAP
from skyverse.search.taut.half_plane import UP, half_plane_path
from skyverse.space import box
from skyverse.space.obstacles import Space, boxes_near, shapes_reach, with_margin
from skyverse.space.tree import FIRST, SKIP, STOP
from skyverse.space.world import World, point_free, segment_free

MAX_BOXES = 400
"""Boxes of a corridor at most: a path that needs more is too intricate to be smoothed in seconds."""
BISECTIONS = 30
"""Halvings by which the part of a leg that still belongs to a box is found."""
SHRINKINGS = 20
"""How often a box between two others is halved until it is free."""
FACE_BISECTIONS = 6
"""Halvings by which the last free place of a face is found while a box grows."""
GROWTH_STAGES = (0.1, 0.3, 1.0)
"""Shares of the way to the largest box to which all faces grow, one stage after another."""
FACES_IN_TURN = (5, 0, 1, 3, 4, 2)
"""The order in which the faces of a box grow: up first, down last."""


@kernel
def grow_corridor(space: Space, path: Floats, reach: float, width: float, most: int = MAX_BOXES) -> Floats:
    """Return free boxes (m, 6) along a path (n, 3), metres; none if they do not overlap enough.

    Parameters
    ----------
    space
        With the obstacles, among which the path is free.
    reach
        How far a box may extend beyond its stretch of the path, metres.
    width
        How wide a stretch's bounding box may be across its longest side, metres.
    most
        Boxes at most.
    """
    boxes = np.empty((most, 6))
    count = 0
    leg, share = 0, 0.0  # where the path leaves the last box
    while leg < len(path) - 1:
        if count == most:
            return boxes[:0]
        begin = towards(path[leg], path[leg + 1], share)
        seed = _around(begin)
        at = leg
        while at < len(path) - 1:  # whole legs, then a part of one
            longer = _joined(seed, path[at + 1])
            if not (_across(longer) <= width and _is_free(space, longer)):
                break
            seed = longer
            at += 1
        if at < len(path) - 1:
            low, high = (share if at == leg else 0.0), 1.0
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                longer = _joined(seed, towards(path[at], path[at + 1], middle))
                if _across(longer) <= width and _is_free(space, longer):
                    low = middle
                else:
                    high = middle
            seed = _joined(seed, towards(path[at], path[at + 1], low))
        free = _cut_free(space, seed, reach)
        if count and _overlap(boxes[count - 1], free)[1] < THIN_OVERLAP and count < most - 1:
            joint = _between(space, boxes[count - 1], free, begin, reach)
            for k in range(6):
                boxes[count, k] = joint[k]
            count += 1
        for k in range(6):
            boxes[count, k] = free[k]
        count += 1
        further, how_far = _leaves(boxes[count - 1], path, leg)
        if further == leg and how_far <= share + CORRIDOR_PROGRESS:
            return boxes[:0]
        leg, share = further, how_far
    for i in range(count - 1):
        if _overlap(boxes[i], boxes[i + 1])[1] < MIN_OVERLAP:
            return boxes[:0]
    return boxes[:count]


@inner
def _overlap(a: Floats, b: Floats) -> tuple[int, float]:
    """Return the axis along which two boxes overlap least, and how much, metres."""
    axis, least = 0, np.inf
    for k in range(3):
        width = min(a[k + 3], b[k + 3]) - max(a[k], b[k])
        if width < least:
            axis, least = k, width
    return axis, least


@inner
def _between(space: Space, a: Floats, b: Floats, p: Floats, reach: float) -> Floats:
    """Return a free box through p that overlaps two boxes, which hardly do more than touch each other there."""
    axis, _ = _overlap(a, b)
    far = 1.0
    seed = _around(p)
    for _ in range(SHRINKINGS):
        seed = _around(p)
        seed[axis] = max(p[axis] - far, min(a[axis], b[axis]))
        seed[axis + 3] = min(p[axis] + far, max(a[axis + 3], b[axis + 3]))
        if _is_free(space, seed):
            break
        far *= 0.5
    return _cut_free(space, seed, reach)


@inner
def _around(p: Floats) -> Floats:
    """Return the box that is a single point."""
    b = np.empty(6)
    for axis in range(3):
        b[axis] = b[axis + 3] = p[axis]
    return b


@inner
def _joined(b: Floats, p: Floats) -> Floats:
    """Return the smallest box that holds a box and a point."""
    joined = b.copy()
    for axis in range(3):
        joined[axis], joined[axis + 3] = min(b[axis], p[axis]), max(b[axis + 3], p[axis])
    return joined


@inner
def _across(b: Floats) -> float:
    """Return the second longest side of a box."""
    x, y, z = b[3] - b[0], b[4] - b[1], b[5] - b[2]
    return max(min(x, y), min(max(x, y), z))


@inner
def _is_free(space: Space, b: Floats) -> bool:
    """Tell whether no grown obstacle reaches into the box."""
    node = 0
    index = space.tree
    growth = space.clearance - SURFACE_DEPTH
    while node < len(index.links):
        if not box.touches(index.bounds, node, growth, b[:3], b[3:]):
            node = index.links[node, SKIP]
            continue
        for i in range(index.links[node, FIRST], index.links[node, STOP]):
            if _reaches(space, i, b):
                return False
        node += 1
    return not shapes_reach(space, 0.0, b[:3], b[3:])


@inner
def _reaches(space: Space, i: int, b: Floats) -> bool:
    """Tell whether obstacle i, which is a box, reaches into the box when grown by the clearance."""
    growth = space.clearance - SURFACE_DEPTH
    meet = True
    for axis in range(3):
        meet &= space.boxes[i, axis] - growth < b[axis + 3] and space.boxes[i, axis + 3] + growth > b[axis]
    return meet


@inner
def _cut_free(space: Space, seed: Floats, reach: float) -> Floats:
    """Return a free box around a free one, its seed, that extends beyond it by the reach at most."""
    b = seed.copy()
    for axis in range(3):
        b[axis] = max(seed[axis] - reach, space.low[axis])
        b[axis + 3] = min(seed[axis + 3] + reach, space.high[axis])
    near = boxes_near(space, 0.0, b[:3], b[3:])
    gaps = np.empty(len(near))
    for k in range(len(near)):
        gaps[k] = 0.0
        for axis in range(3):
            outside = max(space.boxes[near[k], axis] - seed[axis + 3], seed[axis] - space.boxes[near[k], axis + 3])
            gaps[k] += max(outside, 0.0) ** 2
    for k in order_of(gaps):
        i = near[k]
        if not _reaches(space, i, b):
            continue
        best, best_face, best_place = -1.0, -1, 0.0
        for axis in range(3):
            width = b[axis + 3] - b[axis]
            low, high = space.boxes[i, axis] - space.clearance, space.boxes[i, axis + 3] + space.clearance
            if low >= seed[axis + 3] - SURFACE_DEPTH and (low - b[axis]) / width > best:
                best, best_face, best_place = (low - b[axis]) / width, axis + 3, max(low, seed[axis + 3])
            if high <= seed[axis] + SURFACE_DEPTH and (b[axis + 3] - high) / width > best:
                best, best_face, best_place = (b[axis + 3] - high) / width, axis, min(high, seed[axis])
        if best_face >= 0:
            b[best_face] = best_place
    return _grown(space, seed, b) if shapes_reach(space, 0.0, b[:3], b[3:]) else b


@inner
def _grown(space: Space, seed: Floats, most: Floats) -> Floats:
    """Return a free box grown from its seed towards a larger one, face by face, as far as no shape reaches into it."""
    b = seed.copy()
    stuck = np.zeros(6, np.bool_)
    before = 0.0
    for share in GROWTH_STAGES:
        for k in range(6):
            face = FACES_IN_TURN[k]
            if stuck[face]:
                continue
            far = most[face] - seed[face]
            b[face] = seed[face] + share * far
            if shapes_reach(space, 0.0, b[:3], b[3:]):
                stuck[face] = True
                inside, outside = before, share
                for _ in range(FACE_BISECTIONS):
                    middle = 0.5 * (inside + outside)
                    b[face] = seed[face] + middle * far
                    if shapes_reach(space, 0.0, b[:3], b[3:]):
                        outside = middle
                    else:
                        inside = middle
                b[face] = seed[face] + inside * far
        before = share
    return b


@inner
def _leaves(b: Floats, path: Floats, leg: int) -> tuple[int, float]:
    """Return the leg, and the share of that leg, at which a path leaves a box that it is in on a leg."""
    for at in range(leg, len(path) - 1):
        share = 1.0
        for axis in range(3):
            begin, d = path[at, axis], path[at + 1, axis] - path[at, axis]
            if begin + d > b[axis + 3] and d > 0.0:
                share = min(share, (b[axis + 3] - begin) / d)
            elif begin + d < b[axis] and d < 0.0:
                share = min(share, (b[axis] - begin) / d)
        if share < 1.0:
            return at, max(share, 0.0)
    return len(path) - 1, 0.0


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
