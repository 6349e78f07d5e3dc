"""What no path can beat: the search over edges, with every doubt settled in the path's favour.

Edges are cut into intervals. A leg from one interval to another costs as little as between any two of their points,
whichever points the path came in by; it is forbidden only where one box blocks all legs between the two. The cheapest
way in this graph is a lower bound.

It is raised in two ways. For any vector `pull` of length below 1, a path's length is pull . (goal - start) plus the sum
over its legs d of |d| - pull . d, and the sum is bounded in its place: a pull against the jumps that the cheapest way
makes within intervals takes away what it gains by them (a Lagrangian relaxation; Polyak's steps). And the intervals
that it jumps in are halved.
"""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put, put_box
from skyverse.numerics.heap import make_heap, pop, push
from skyverse.numerics.kernel import inner, inner_query
from skyverse.numerics.tolerances import SURFACE_DEPTH
from skyverse.search.taut.bends import beside_faces, distance, nearby
from skyverse.space import box
from skyverse.space.edges import Edges
from skyverse.space.tree import FIRST, SKIP, STOP
from skyverse.space.world import Space

INTERVALS = 400
"""Intervals at most."""
STEPS = 5
"""Changes of the pull before intervals are halved again."""


@inner
def lower_bound(
    space: Space, growth: float, edges: Edges, start: Floats, goal: Floats, length: float, gap: float, most: int
) -> tuple[float, int]:
    """Return a length that no path from start to goal beats, and the states expanded for it.

    Parameters
    ----------
    length
        Of a path that is known, metres.
    gap
        Done when the bound is so near to it, as a share of the bound.
    most
        States to expand at most, about.
    """
    bound = distance(start, goal)
    pieces = nearby(edges, start, goal, length, INTERVALS - 2)
    if len(pieces) > INTERVALS - 2:
        return bound, 0
    ends = np.empty((INTERVALS, 6))
    edge = np.full(INTERVALS, -1)
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
        found, path, count = _relaxed(space, growth, edges, ends[:n], edge[:n], pull, length)
        expanded += count
        if len(path) == 0:
            if step:  # ways were found before: now it is proven that none is shorter than the one that is known
                bound = length
            break
        bound = max(bound, min(found, length))
        for axis in range(3):
            jump[axis] = goal[axis] - start[axis]
        for k in range(len(path) - 1):
            _, leg = _leg(ends, path[k + 1], path[k], pull)
            for axis in range(3):
                jump[axis] -= leg[axis]
        size = _size(jump)
        step += 1
        if step % STEPS and size > 1e-9 * length:
            for axis in range(3):
                pull[axis] += jump[axis] * ((length - found) / size**2)
            share = min(1.0, 0.999 / max(_size(pull), 1e-9))
            for axis in range(3):
                pull[axis] *= share
            continue
        if n + len(path) > INTERVALS:
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
def _relaxed(
    space: Space, growth: float, edges: Edges, ends: Floats, edge: Ints, pull: Floats, length: float
) -> tuple[float, Ints, int]:
    """Return the least length from interval 0 to 1, infinite if none is below `length`, its intervals, the expanded.

    The intervals are given from the goal back.
    """
    n = len(ends)
    price = np.full(2 * n, np.inf)
    came = np.full(2 * n, -1)
    gained = 0.0
    for axis in range(3):
        gained += pull[axis] * (ends[1, axis] - ends[0, axis])
    left = np.empty(n)
    for v in range(n):
        left[v] = _leg(ends, v, 1, pull)[0]
    # a jump makes what is left rise by more than a leg costs: so in order of price alone
    heap = push(make_heap(1024), 0.0, 0)
    expanded = 0
    while heap.size[0]:
        along, entry = pop(heap)
        before, state = entry // (2 * n), entry % (2 * n)
        if price[state] < np.inf:
            continue
        v = state >> 1
        if state:
            if _blocked(space, growth, ends, before >> 1, v):
                continue
            came[state] = before
        price[state] = along
        expanded += 1
        if v == 1:
            break
        onward = 2 - (state & 1) if edge[v] >= 0 else 3
        for w in range(1, n):
            if w == v:
                continue
            if onward < 3 and not _beside(edges, edge[v], ends, v, w) & onward:
                continue
            beside = _beside(edges, edge[w], ends, w, v) if edge[w] >= 0 else 1
            new = (beside & 1 and price[2 * w] == np.inf) or (beside & 2 and price[2 * w + 1] == np.inf)
            if not new:
                continue
            further = along + _leg(ends, v, w, pull)[0]
            if gained + further + left[w] >= length:
                continue
            if beside & 1:
                heap = push(heap, further, state * 2 * n + 2 * w)
            if beside & 2:
                heap = push(heap, further, state * 2 * n + 2 * w + 1)
    if price[2] == np.inf:
        return np.inf, np.empty(0, np.int64), expanded
    path = np.empty(2 * n, np.int64)
    count = 0
    state = 2
    while state >= 0:
        path[count] = state >> 1
        count += 1
        state = came[state]
    return gained + price[2], path[:count], expanded


@inner
def _leg(ends: Floats, v: int, w: int, pull: Floats) -> tuple[float, Floats]:
    """Bound |d| - pull . d from below over all legs d from interval v to interval w; return it, and about the best d.

    The d make a box, and the function is convex: descend by coordinates, then trust no more than its tangent.
    """
    low, high, d = np.empty(3), np.empty(3), np.empty(3)
    for axis in range(3):
        low[axis] = ends[w, axis] - ends[v, axis + 3]
        high[axis] = ends[w, axis + 3] - ends[v, axis]
        d[axis] = min(max(0.0, low[axis]), high[axis])
    for _ in range(4):
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


@inner_query
def _size(d: Floats) -> float:
    return float(np.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2))


@inner
def _beside(edges: Edges, e: int, ends: Floats, v: int, w: int) -> int:
    """Return beside which faces of interval v's edge some point of interval w lies: bit 1 the first, 2 the second."""
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
def _blocked(space: Space, growth: float, ends: Floats, v: int, w: int) -> bool:
    """Tell whether one box surely blocks all legs from interval v to interval w."""
    a, b = np.empty(3), np.empty(3)
    for axis in range(3):
        a[axis] = 0.5 * (ends[v, axis] + ends[v, axis + 3])
        b[axis] = 0.5 * (ends[w, axis] + ends[w, axis + 3])
    r = box.ray(a, b)
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
    """Tell whether the four legs between the ends of two intervals are in box i at one and the same share of the way.

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
