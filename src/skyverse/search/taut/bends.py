"""The search over edges: A* through points sampled on them, with lazy visibility.

A path can bend at a point of an edge only from beside one of the edge's two faces to beside the other: around it. So a
state is a point and the face that the path came along.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.heap import make_heap, pop, push
from skyverse.numerics.kernel import inner, inner_query, kernel
from skyverse.numerics.norm import norm
from skyverse.numerics.tolerances import FACE_PLANE
from skyverse.space import box, tree
from skyverse.space.edges import Edges
from skyverse.space.tree import FIRST, SKIP, STOP
from skyverse.space.world import Space


class Points(NamedTuple):
    """Where a path may bend: (n, 3) metres, and (n,) the pieces of edges that they lie on; -1 for anywhere else."""

    at: Floats
    edge: Ints


class Found(NamedTuple):
    """A path as numbers of points, (k,), empty if none is shorter than asked for; its length; the states expanded."""

    points: Ints
    length: float
    expanded: int


@kernel
def distance(a: Floats, b: Floats) -> float:
    """Return the Euclidean distance of two points."""
    return norm(a[0] - b[0], a[1] - b[1], a[2] - b[2])


@inner
def spheroid(start: Floats, goal: Floats, length: float) -> tuple[Floats, Floats]:
    """Return the corners of the box around all ways from start to goal of at most this length."""
    low, high = np.empty(3), np.empty(3)
    far = distance(start, goal)
    spare = 0.5 * np.sqrt(max(length**2 - far**2, 0.0))  # half the short axis of the spheroid
    for axis in range(3):
        slope = abs(goal[axis] - start[axis]) / far if far > 0.0 else 0.0
        reach = np.sqrt((0.5 * length * slope) ** 2 + spare**2 * (1.0 - slope**2))
        middle = 0.5 * (start[axis] + goal[axis])
        low[axis], high[axis] = middle - reach, middle + reach
    return low, high


@inner
def nearby(edges: Edges, start: Floats, goal: Floats, length: float, most: int) -> Ints:
    """Return the pieces that some way from start to goal of at most this length touches.

    More than `most` are not returned, and one more stands for all that are left.
    """
    found = np.empty(most + 1, np.int64)
    count = 0
    low, high = spheroid(start, goal, length)
    node = 0
    bounds = edges.tree.bounds
    while node < len(edges.tree.links):
        if (
            bounds[node, 0] > high[0]
            or bounds[node, 3] < low[0]
            or bounds[node, 1] > high[1]
            or bounds[node, 4] < low[1]
            or bounds[node, 2] > high[2]
            or bounds[node, 5] < low[2]
        ):
            node = edges.tree.links[node, SKIP]
            continue
        for e in range(edges.tree.links[node, FIRST], edges.tree.links[node, STOP]):
            x = closest(edges, e, start, goal)
            if through(edges, e, x, start, goal) < length:
                found[count] = e
                count += 1
                if count > most:
                    return found
        node += 1
    return found[:count]


@inner
def closest(edges: Edges, e: int, p: Floats, q: Floats) -> float:
    """Return where on piece e, along its axis, the way from p over it to q is shortest."""
    axis = edges.axis[e]
    b, c = (axis + 1) % 3, (axis + 2) % 3
    hp = np.sqrt((p[b] - edges.ends[e, b]) ** 2 + (p[c] - edges.ends[e, c]) ** 2)
    hq = np.sqrt((q[b] - edges.ends[e, b]) ** 2 + (q[c] - edges.ends[e, c]) ** 2)
    x = (p[axis] * hq + q[axis] * hp) / (hp + hq) if hp + hq > 0.0 else p[axis]
    return min(max(x, edges.ends[e, axis]), edges.ends[e, axis + 3])


@inner
def through(edges: Edges, e: int, x: float, p: Floats, q: Floats) -> float:
    """Return the length of the way from p over piece e, at x along its axis, to q."""
    axis = edges.axis[e]
    b, c = (axis + 1) % 3, (axis + 2) % 3
    to_p = (p[b] - edges.ends[e, b]) ** 2 + (p[c] - edges.ends[e, c]) ** 2 + (p[axis] - x) ** 2
    to_q = (q[b] - edges.ends[e, b]) ** 2 + (q[c] - edges.ends[e, c]) ** 2 + (q[axis] - x) ** 2
    return np.sqrt(to_p) + np.sqrt(to_q)


@inner
def reach_on(edges: Edges, e: int, x: float, p: Floats, q: Floats, length: float) -> tuple[float, float]:
    """Return from where to where on piece e, around x, a way from p to q over it is at most this long."""
    axis = edges.axis[e]
    ends = (edges.ends[e, axis], edges.ends[e, axis + 3])
    reached = (x, x)
    for way in range(2):
        inside, outside = x, ends[way]
        if through(edges, e, outside, p, q) <= length:
            inside = outside
        else:
            for _ in range(20):
                middle = 0.5 * (inside + outside)
                if through(edges, e, middle, p, q) <= length:
                    inside = middle
                else:
                    outside = middle
        reached = (inside, reached[1]) if way == 0 else (reached[0], inside)
    return reached


@inner
def side_of(edges: Edges, e: int, v: Floats, u: Floats) -> int:
    """Return beside which faces of the edge through v the point u lies: 1 the first, 2 the second, 3 both, 0 none."""
    axis = edges.axis[e]
    b, c = (axis + 1) % 3, (axis + 2) % 3
    rb = edges.side[e, 0] * (u[b] - v[b])
    rc = edges.side[e, 1] * (u[c] - v[c])
    return beside_faces(rb, rb, rc, rc)


@inner_query
def beside_faces(least_b: float, most_b: float, least_c: float, most_c: float) -> int:
    """Return beside which faces of an edge some point of a box lies: bit 1 for the first face, bit 2 for the second.

    The box is given by its least and greatest metres from the edge into free space, along the edge's two normals.
    """
    first = 1 if most_b >= -FACE_PLANE and least_c <= FACE_PLANE else 0
    return first + (2 if most_c >= -FACE_PLANE and least_b <= FACE_PLANE else 0)


@inner
def search(space: Space, growth: float, edges: Edges, points: Points, length: float) -> Found:
    """Find the shortest path from the first point to the second, over others, that is shorter than `length`."""
    at = points.at
    n = len(at)
    price = np.full(2 * n, np.inf)
    came = np.full(2 * n, -1)
    left = np.empty(n)
    for v in range(n):
        left[v] = distance(at[v], at[1])
    # an entry stands for a leg: state it leaves, and state it reaches
    heap = push(make_heap(1024), left[0], 0)
    blocked_last = np.full(n, -1)  # what blocked a leg from or to a point is likely to block the next one
    expanded = 0
    while heap.size[0]:
        _, entry = pop(heap)
        before, state = entry // (2 * n), entry % (2 * n)
        if price[state] < np.inf:
            continue
        v = state >> 1
        if state:
            u = before >> 1
            leg = box.ray(at[u], at[v])
            if blocked_last[u] >= 0 and box.meets(space.boxes, blocked_last[u], growth, leg):
                continue
            if blocked_last[v] >= 0 and box.meets(space.boxes, blocked_last[v], growth, leg):
                continue
            obstacle = tree.crossed(space.tree, space.boxes, growth, at[u], at[v])
            if obstacle >= 0:
                blocked_last[u] = blocked_last[v] = obstacle
                continue
            price[state] = price[before] + distance(at[u], at[v])
            came[state] = before
        else:
            price[state] = 0.0
        expanded += 1
        if v == 1:
            break
        onward = 2 - (state & 1) if points.edge[v] >= 0 else 3  # the way on is along the other face
        for w in range(1, n):
            if w == v:
                continue
            key = price[state] + distance(at[v], at[w]) + left[w]
            if key >= length:
                continue
            if onward < 3 and not side_of(edges, points.edge[v], at[v], at[w]) & onward:
                continue
            beside = side_of(edges, points.edge[w], at[w], at[v]) if points.edge[w] >= 0 else 1
            if beside & 1 and price[2 * w] == np.inf:
                heap = push(heap, key, state * 2 * n + 2 * w)
            if beside & 2 and price[2 * w + 1] == np.inf:
                heap = push(heap, key, state * 2 * n + 2 * w + 1)
    if price[2] == np.inf:
        return Found(np.empty(0, np.int64), np.inf, expanded)
    count = 1
    state = 2
    while state:
        state = came[state]
        count += 1
    path = np.empty(count, np.int64)
    state = 2
    for i in range(count - 1, -1, -1):
        path[i] = state >> 1
        state = came[state]
    return Found(path, price[2], expanded)
