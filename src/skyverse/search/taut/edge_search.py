"""The search over edges: A* through points sampled on them, with lazy visibility.

A path can bend at a point of an edge only from beside one of the edge's two faces to beside the other, around the edge.
So a state is a point and the face along which the path reached it: 2 * point for the first face, 2 * point + 1 for the
second. An entry of the heap is a leg: the state that it leaves, and the state that it reaches.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.heap import Heap, make_heap, pop, push
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance
from skyverse.search.taut.edge_geometry import beside_faces
from skyverse.space import box, tree
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space
from skyverse.space.world import segment_free

GOAL_STATE = 2
"""The state of point 1, which is the goal and lies on no edge."""


class BendPoints(NamedTuple):
    """Where a path may bend: (n, 3) metres, start and goal first; (n,) the piece each lies on, -1 for none."""

    at: Floats
    edge: Ints


class EdgePath(NamedTuple):
    """A path as (k,) numbers of points, empty if none is shorter than asked for; its length; the states expanded."""

    points: Ints
    length: float
    expanded: int


@inner
def search_edges(space: Space, edges: Edges, points: BendPoints, length: float) -> EdgePath:
    """Find the shortest path from the first point to the second, over the others, that is shorter than `length`."""
    at = points.at
    n = len(at)
    price = np.full(2 * n, np.inf)
    came = np.full(2 * n, -1)
    left = np.empty(n)
    for v in range(n):
        left[v] = distance(at[v], at[1])
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
            leg = box.ray(at[u], at[v])
            if blocked_last[u] >= 0 and box.meets(space.boxes, blocked_last[u], space.clearance, leg):
                continue
            if blocked_last[v] >= 0 and box.meets(space.boxes, blocked_last[v], space.clearance, leg):
                continue
            obstacle = tree.crossed(space.tree, space.boxes, space.clearance, at[u], at[v])
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
        if v == 1:
            break
        onward = faces_onward(points.edge[v], state)
        for w in range(1, n):
            if w == v:
                continue
            key = price[state] + distance(at[v], at[w]) + left[w]
            if key >= length:
                continue
            if onward < 3 and not _beside(edges, points.edge[v], at[v], at[w]) & onward:
                continue
            beside = _beside(edges, points.edge[w], at[w], at[v]) if points.edge[w] >= 0 else 1
            if beside & 1 and price[2 * w] == np.inf:
                heap = push(heap, key, state * 2 * n + 2 * w)
            if beside & 2 and price[2 * w + 1] == np.inf:
                heap = push(heap, key, state * 2 * n + 2 * w + 1)
    if price[GOAL_STATE] == np.inf:
        return EdgePath(np.empty(0, np.int64), np.inf, expanded)
    return EdgePath(walk_back(came)[::-1].copy(), price[GOAL_STATE], expanded)


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
def walk_back(came: Ints) -> Ints:
    """Return the points of the path that reaches the goal, from the goal back to the start, (k,)."""
    path = np.empty(len(came), np.int64)
    count = 0
    state = GOAL_STATE
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
