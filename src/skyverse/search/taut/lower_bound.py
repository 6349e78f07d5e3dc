"""A length that no path beats: the search over edges, in which every doubt is settled in the path's favour.

Edges are cut into intervals. A leg from one interval to another costs as little as between any two of their points,
whichever points the path came in by; it is forbidden only where one box blocks all legs between the two. The cheapest
path in this graph is a lower bound.

The bound is raised in two ways. For any vector `pull` of length below 1, the length of a path with the legs d is

    pull . (goal - start) + sum over d of (|d| - pull . d)

and the sum is bounded in place of the length. Between a leg that ends in an interval and the next, which begins
elsewhere in it, the cheapest path jumps; a pull against these jumps takes away what the path gains by them (Lagrangian
relaxation, with Polyak's step lengths). And the intervals that it jumps in are halved.
"""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put, put_box
from skyverse.numerics.heap import make_heap, push
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance, norm
from skyverse.numerics.tolerances import MIN_JUMP, SURFACE_DEPTH
from skyverse.search.taut.edge_geometry import beside_faces, pieces_within
from skyverse.search.taut.edge_search import GOAL_STATE, faces_onward, next_leg, walk_back
from skyverse.space import box
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space
from skyverse.space.tree import FIRST, SKIP, STOP

MAX_INTERVALS = 400
"""Intervals at most."""
PULL_STEPS = 5
"""Changes of the pull before intervals are halved again."""
MAX_PULL = 0.999
"""The length of the pull at most."""
LEG_DESCENTS = 4
"""How often the legs between two intervals are searched for the cheapest, axis by axis."""


@inner
def lower_bound(
    space: Space, edges: Edges, start: Floats, goal: Floats, length: float, gap: float, most: int
) -> tuple[float, int]:
    """Return a length that no path from start to goal beats, and the states expanded for it.

    Parameters
    ----------
    length
        The length of a path that is known, metres.
    gap
        The search ends where the bound is so near to this length, as a share of the bound.
    most
        States to expand at most, about.
    """
    bound = distance(start, goal)
    pieces = pieces_within(edges, start, goal, length, MAX_INTERVALS - 2)
    if len(pieces) > MAX_INTERVALS - 2:
        return bound, 0
    ends = np.empty((MAX_INTERVALS, 6))
    edge = np.full(MAX_INTERVALS, -1)
    put_box(ends, 0, start, start)
    put_box(ends, 1, goal, goal)
    n = 2
    for e in pieces:
        put(ends, n, edges.ends[e])
        edge[n] = e
        n += 1
    pull, jump = np.zeros(3), np.empty(3)
    expanded = 0
    step = 0
    while bound * (1.0 + gap) < length and expanded < most:
        found, path, count = _cheapest(space, edges, ends[:n], edge[:n], pull, length)
        expanded += count
        if len(path) == 0:
            if step:  # paths were found before: now it is proven that none is shorter than the one that is known
                bound = length
            break
        bound = max(bound, min(found, length))
        for axis in range(3):
            jump[axis] = goal[axis] - start[axis]
        for k in range(len(path) - 1):
            _, leg = _cheapest_leg(ends, path[k + 1], path[k], pull)
            for axis in range(3):
                jump[axis] -= leg[axis]
        size = _size(jump)
        step += 1
        if step % PULL_STEPS and size > MIN_JUMP * length:
            for axis in range(3):
                pull[axis] += jump[axis] * ((length - found) / size**2)
            share = min(1.0, MAX_PULL / max(_size(pull), MIN_JUMP))
            for axis in range(3):
                pull[axis] *= share
            continue
        if n + len(path) > MAX_INTERVALS:
            break
        halved = np.zeros(n, np.bool_)
        for i in path:
            halved[i] = edge[i] >= 0
        for i in range(len(halved)):
            e = edge[i]
            if halved[i]:
                axis = edges.axis[e]
                put(ends, n, ends[i])
                edge[n] = e
                ends[n, axis] = ends[i, axis + 3] = 0.5 * (ends[i, axis] + ends[i, axis + 3])
                n += 1
    return bound, expanded


@inner
def _cheapest(
    space: Space, edges: Edges, ends: Floats, edge: Ints, pull: Floats, length: float
) -> tuple[float, Ints, int]:
    """Find the cheapest path over intervals from the first, the start, to the second, the goal.

    Returns
    -------
    bound
        What it costs, metres; infinite if none costs less than `length`.
    path
        (k,) its intervals from the goal back to the start.
    expanded
        How many states were expanded.
    """
    n = len(ends)
    price = np.full(2 * n, np.inf)
    came = np.full(2 * n, -1)
    gained = 0.0
    for axis in range(3):
        gained += pull[axis] * (ends[1, axis] - ends[0, axis])
    left = np.empty(n)
    for v in range(n):
        left[v] = _cheapest_leg(ends, v, 1, pull)[0]
    # where the path jumps, what is left rises by more than a leg costs: so legs wait in order of their price alone
    heap = push(make_heap(1024), 0.0, 0)
    expanded = 0
    while True:
        along, before, state = next_leg(heap, price)
        if state < 0:
            break
        v = state >> 1
        if state:
            if _blocked(space, ends, before >> 1, v):
                continue
            came[state] = before
        price[state] = along
        expanded += 1
        if v == 1:
            break
        onward = faces_onward(edge[v], state)
        for w in range(1, n):
            if w == v:
                continue
            if onward < 3 and not _beside(edges, edge[v], ends, v, w) & onward:
                continue
            beside = _beside(edges, edge[w], ends, w, v) if edge[w] >= 0 else 1
            new = (beside & 1 and price[2 * w] == np.inf) or (beside & 2 and price[2 * w + 1] == np.inf)
            if not new:
                continue
            further = along + _cheapest_leg(ends, v, w, pull)[0]
            if gained + further + left[w] >= length:
                continue
            if beside & 1:
                heap = push(heap, further, state * 2 * n + 2 * w)
            if beside & 2:
                heap = push(heap, further, state * 2 * n + 2 * w + 1)
    if price[GOAL_STATE] == np.inf:
        return np.inf, np.empty(0, np.int64), expanded
    return gained + price[GOAL_STATE], walk_back(came), expanded


@inner
def _cheapest_leg(ends: Floats, v: int, w: int, pull: Floats) -> tuple[float, Floats]:
    """Bound |d| - pull . d from below over all legs d from interval v to interval w; return it, and about the best d.

    The legs d fill a box, and the function is convex. Along one axis, with r the length of d's other components, it is
    least at d_axis = pull_axis r / sqrt(1 - pull_axis^2). After some such steps the function's tangent at d, which lies
    below the function everywhere, is minimised over the box.
    """
    low, high, d = np.empty(3), np.empty(3), np.empty(3)
    for axis in range(3):
        low[axis] = ends[w, axis] - ends[v, axis + 3]
        high[axis] = ends[w, axis + 3] - ends[v, axis]
        d[axis] = min(max(0.0, low[axis]), high[axis])
    for _ in range(LEG_DESCENTS):
        for axis in range(3):
            if low[axis] < high[axis]:
                rest = np.sqrt(max(d[0] ** 2 + d[1] ** 2 + d[2] ** 2 - d[axis] ** 2, 0.0))
                d[axis] = min(max(pull[axis] * rest / np.sqrt(1.0 - pull[axis] ** 2), low[axis]), high[axis])
    size = _size(d)
    if size == 0.0:
        return 0.0, d
    least = 0.0
    for axis in range(3):
        slope = d[axis] / size - pull[axis]
        least += slope * (low[axis] if slope > 0.0 else high[axis])
    return max(least, 0.0), d


@inner
def _size(d: Floats) -> float:
    """Return the length of a vector (3,)."""
    return norm(d[0], d[1], d[2])


@inner
def _beside(edges: Edges, e: int, ends: Floats, v: int, w: int) -> int:
    """Return beside which faces of interval v's edge some point of interval w lies; see `beside_faces`."""
    b, c = (edges.axis[e] + 1) % 3, (edges.axis[e] + 2) % 3
    if edges.side[e, 0] > 0:
        least_b, most_b = ends[w, b] - ends[v, b], ends[w, b + 3] - ends[v, b]
    else:
        least_b, most_b = ends[v, b] - ends[w, b + 3], ends[v, b] - ends[w, b]
    if edges.side[e, 1] > 0:
        least_c, most_c = ends[w, c] - ends[v, c], ends[w, c + 3] - ends[v, c]
    else:
        least_c, most_c = ends[v, c] - ends[w, c + 3], ends[v, c] - ends[w, c]
    return beside_faces(least_b, most_b, least_c, most_c)


@inner
def _blocked(space: Space, ends: Floats, v: int, w: int) -> bool:
    """Tell whether one box surely blocks all legs from interval v to interval w."""
    a, b = np.empty(3), np.empty(3)
    for axis in range(3):
        a[axis] = 0.5 * (ends[v, axis] + ends[v, axis + 3])
        b[axis] = 0.5 * (ends[w, axis] + ends[w, axis + 3])
    r = box.ray(a, b)
    growth = space.clearance
    node = 0
    while node < len(space.tree.links):
        if not box.meets(space.tree.bounds, node, growth, r):
            node = space.tree.links[node, SKIP]
            continue
        for i in range(space.tree.links[node, FIRST], space.tree.links[node, STOP]):
            if box.meets(space.boxes, i, growth, r) and _all_meet(space.boxes, i, growth, ends, v, w):
                return True
        node += 1
    return False


@inner
def _all_meet(boxes: Floats, i: int, growth: float, ends: Floats, v: int, w: int) -> bool:
    """Tell whether the four legs between the ends of two intervals are in box i at one and the same share of the leg.

    Then all legs between the intervals are: at that share, the points of all legs are mixtures of those four.
    """
    margin = growth - SURFACE_DEPTH
    enter, leave = 0.0, 1.0
    for corner in range(4):
        for axis in range(3):
            p = ends[v, axis + 3 * (corner & 1)]
            d = ends[w, axis + 3 * (corner >> 1)] - p
            low, high = boxes[i, axis] - margin, boxes[i, axis + 3] + margin
            if d == 0.0:
                if p <= low or p >= high:
                    return False
            else:
                enter = max(enter, min((low - p) / d, (high - p) / d))
                leave = min(leave, max((low - p) / d, (high - p) / d))
    return enter < leave
