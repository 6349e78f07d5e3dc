"""The search over edges: A* through points sampled on them, with lazy visibility.

A path can bend at a point of an edge only from beside one of the edge's two faces to beside the other, around the edge.
So a state is a point and the face along which the path reached it: 2 * point for the first face, 2 * point + 1 for the
second. An entry of the heap is a leg: the state that it leaves, and the state that it reaches.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.heap import Heap, make_heap, pop, push
from skyverse.numerics.kernel import inner, inner_query
from skyverse.numerics.norm import distance
from skyverse.search.taut.edge_geometry import beside_faces
from skyverse.space import box
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space, box_crossed
from skyverse.space.world import segment_free

GOAL_STATE = 2
"""The state of point 1, which is the goal and lies on no edge."""


class BendPoints(NamedTuple):
    """Where a path may bend: (n, 3) metres, start and goal first; (n,) the piece each lies on, -1 for none."""

    at: Floats
    edge: Ints


class Runs(NamedTuple):
    """Consecutive points on one piece of an edge: what all of them share, so that they are passed over together.

    Attributes
    ----------
    first
        (k + 1,) the first point of each run; the last number is how many points there are.
    edge
        (k,) the piece that the run lies on, -1 for none.
    across, side
        (k, 2) the axes that follow the piece's own, and on which side of the piece free space lies on them.
    middle
        (k, 3) metres: the middle of the run's points.
    left
        (k,) metres: the distance from the middle to the goal, less the largest detour by which the middle is nearer.
    """

    first: Ints
    edge: Ints
    across: Ints
    side: Floats
    middle: Floats
    left: Floats


class EdgePath(NamedTuple):
    """A path as (k,) numbers of points, empty if none is shorter than asked for; its length; the states expanded."""

    points: Ints
    length: float
    expanded: int


@inner
def search_edges(space: Space, edges: Edges, points: BendPoints, length: float, most: int) -> EdgePath:
    """Find the shortest path from the first point to the second, over the others, that is shorter than `length`.

    None is found where that would take more than `most` states to expand.
    """
    at = points.at
    n = len(at)
    price = np.full(2 * n, np.inf)
    came = np.full(2 * n, -1)
    left = np.empty(n)
    for v in range(n):
        left[v] = distance(at[v], at[1])
    runs = _runs(edges, points)
    heap = push(make_heap(1024), left[0], 0)
    blocked_last = np.full(n, -1)  # the box that blocked a leg from or to a point is likely to block the next one
    expanded = 0
    while True:
        _, before, state = next_leg(heap, price)
        if state < 0:
            break
        v = state >> 1
        if state:
            u = before >> 1
            if _still_blocked(space, at, blocked_last, u, v):
                continue
            obstacle = box_crossed(space, 0.0, at[u], at[v])
            if obstacle >= 0:
                blocked_last[u] = blocked_last[v] = obstacle
                continue
            if not segment_free(space, at[u], at[v]):  # it leads along the bounds, and a box is next to them
                continue
            price[state] = price[before] + distance(at[u], at[v])
            came[state] = before
        else:
            price[state] = 0.0
        expanded += 1
        if v == 1 or expanded > most:
            break
        onward = faces_onward(points.edge[v], state)
        for r in range(len(runs.edge)):
            beside = 1
            if runs.edge[r] >= 0:
                b, c = runs.across[r, 0], runs.across[r, 1]
                rb = runs.side[r, 0] * (at[v, b] - runs.middle[r, b])
                rc = runs.side[r, 1] * (at[v, c] - runs.middle[r, c])
                beside = beside_faces(rb, rb, rc, rc)
                if not beside:
                    continue
            if price[state] + distance(at[v], runs.middle[r]) + runs.left[r] >= length:
                continue
            for w in range(max(runs.first[r], 1), runs.first[r + 1]):
                new = (1 if price[2 * w] == np.inf else 0) + (2 if price[2 * w + 1] == np.inf else 0)
                if w == v or not new & beside:
                    continue
                key = price[state] + distance(at[v], at[w]) + left[w]
                if key >= length:
                    continue
                if onward < 3 and not _beside(edges, points.edge[v], at[v], at[w]) & onward:
                    continue
                if _still_blocked(space, at, blocked_last, v, w):
                    continue
                for face in range(2):
                    if (new & beside) >> face & 1:
                        heap = push(heap, key, state * 2 * n + 2 * w + face)
    if price[GOAL_STATE] == np.inf:
        return EdgePath(np.empty(0, np.int64), np.inf, expanded)
    return EdgePath(walk_back(came, GOAL_STATE)[::-1].copy(), price[GOAL_STATE], expanded)


@inner
def _runs(edges: Edges, points: BendPoints) -> Runs:
    """Return the runs of points that lie on one piece of an edge."""
    at, edge = points
    n = len(edge)
    first, runs = np.empty(n + 1, np.int64), 0
    for i in range(n):
        if i == 0 or edge[i] != edge[i - 1] or not _in_line(edges, edge[i], at[i - 1], at[i]):
            first[runs] = i
            runs += 1
    first[runs] = n
    of, across, side = np.empty(runs, np.int64), np.zeros((runs, 2), np.int64), np.zeros((runs, 2))
    middle, left = np.empty((runs, 3)), np.empty(runs)
    for r in range(runs):
        of[r] = edge[first[r]]
        radius = 0.0
        for axis in range(3):
            low = high = at[first[r], axis]
            for i in range(first[r], first[r + 1]):
                low, high = min(low, at[i, axis]), max(high, at[i, axis])
            middle[r, axis] = 0.5 * (low + high)
            radius += 0.5 * (high - low)
        left[r] = distance(middle[r], at[1]) - 2.0 * radius
        if of[r] >= 0:
            for k in range(2):
                across[r, k] = (edges.axis[of[r]] + 1 + k) % 3
                side[r, k] = edges.side[of[r], k]
                middle[r, across[r, k]] = at[first[r], across[r, k]]
    return Runs(first[: runs + 1], of, across, side, middle, left)


@inner_query
def _in_line(edges: Edges, e: int, p: Floats, q: Floats) -> bool:
    """Tell whether two points of piece e lie exactly along it; bends that are being moved may lie beside it."""
    same = True
    for axis in range(3):
        same &= e < 0 or axis == edges.axis[e] or p[axis] == q[axis]
    return same


@inner_query
def _still_blocked(space: Space, at: Floats, blocked_last: Ints, u: int, v: int) -> bool:
    """Tell whether the box that blocked the last leg from or to one of two points blocks the leg between them."""
    i, j = blocked_last[u], blocked_last[v]
    if i < 0 and j < 0:
        return False
    leg = box.ray(at[u], at[v])
    return (i >= 0 and box.meets(space.boxes, i, space.clearance, leg)) or (
        j >= 0 and box.meets(space.boxes, j, space.clearance, leg)
    )


@inner
def next_leg(heap: Heap, price: Floats) -> tuple[float, int, int]:
    """Remove legs until one reaches a state that has no price yet.

    Returns
    -------
    key
        What it waited with.
    before, state
        The states that it leaves and reaches; the latter is -1 if no leg is left.
    """
    while heap.size[0]:
        key, entry = pop(heap)
        before, state = entry // len(price), entry % len(price)
        if price[state] == np.inf:
            return key, before, state
    return np.inf, -1, -1


@inner
def faces_onward(edge: int, state: int) -> int:
    """Return beside which faces a path may go on from a state: the other one of its edge, or 3 where there is none."""
    return 2 - (state & 1) if edge >= 0 else 3


@inner
def walk_back(came: Ints, state: int) -> Ints:
    """Return the points of the path that reaches a state, from there back to where it begins, (k,)."""
    path = np.empty(len(came), np.int64)
    count = 0
    while state >= 0:
        path[count] = state >> 1
        count += 1
        state = came[state]
    return path[:count]


@inner
def _beside(edges: Edges, e: int, v: Floats, u: Floats) -> int:
    """Return beside which faces of the edge through v the point u lies; see `beside_faces`."""
    axis = edges.axis[e]
    b, c = (axis + 1) % 3, (axis + 2) % 3
    rb = edges.side[e, 0] * (u[b] - v[b])
    rc = edges.side[e, 1] * (u[c] - v[c])
    return beside_faces(rb, rb, rc, rc)
