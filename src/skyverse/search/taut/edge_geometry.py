"""Paths over a piece of an edge: where it is crossed at the least length, how long that is, and which pieces matter."""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, inner_query
from skyverse.numerics.norm import distance
from skyverse.numerics.tolerances import FACE_PLANE
from skyverse.space.edges import Edges
from skyverse.space.tree import FIRST, SKIP, STOP

REACH_BISECTIONS = 20
"""How often the interval between a place that a path can reach and one that it cannot is halved."""


@inner
def spheroid_bounds(start: Floats, goal: Floats, length: float) -> tuple[Floats, Floats]:
    """Return the min and max corner, (3,) each, of the box around all paths from start to goal of at most this length.

    These paths fill a spheroid whose foci are start and goal, whose long axis is the length, and whose short axis is
    sqrt(length^2 - distance^2).
    """
    low, high = np.empty(3), np.empty(3)
    far = distance(start, goal)
    short = 0.5 * np.sqrt(max(length**2 - far**2, 0.0))
    for axis in range(3):
        slope = abs(goal[axis] - start[axis]) / far if far > 0.0 else 0.0
        reach = np.sqrt((0.5 * length * slope) ** 2 + short**2 * (1.0 - slope**2))
        middle = 0.5 * (start[axis] + goal[axis])
        low[axis], high[axis] = middle - reach, middle + reach
    return low, high


@inner
def pieces_within(edges: Edges, start: Floats, goal: Floats, length: float, most: int) -> Ints:
    """Return the pieces that some path from start to goal of at most this length touches.

    At most `most` + 1 are returned; where there are more than `most`, the rest is left out.
    """
    found = np.empty(most + 1, np.int64)
    count = 0
    low, high = spheroid_bounds(start, goal, length)
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
            x = best_crossing(edges, e, start, goal)
            if length_over(edges, e, x, start, goal) < length:
                found[count] = e
                count += 1
                if count > most:
                    return found
        node += 1
    return found[:count]


@inner
def best_crossing(edges: Edges, e: int, p: Floats, q: Floats) -> float:
    """Return where on piece e, metres along its axis, the path from p over it to q is shortest.

    With the distances hp of p and hq of q from the edge's line, and their places xp and xq along it, that is
    (xp hq + xq hp) / (hp + hq), or the nearer end of the piece.
    """
    axis = edges.axis[e]
    b, c = (axis + 1) % 3, (axis + 2) % 3
    hp = np.sqrt((p[b] - edges.ends[e, b]) ** 2 + (p[c] - edges.ends[e, c]) ** 2)
    hq = np.sqrt((q[b] - edges.ends[e, b]) ** 2 + (q[c] - edges.ends[e, c]) ** 2)
    x = (p[axis] * hq + q[axis] * hp) / (hp + hq) if hp + hq > 0.0 else p[axis]
    return min(max(x, edges.ends[e, axis]), edges.ends[e, axis + 3])


@inner
def length_over(edges: Edges, e: int, x: float, p: Floats, q: Floats) -> float:
    """Return the length of the path from p over piece e, crossed at x along its axis, to q."""
    axis = edges.axis[e]
    b, c = (axis + 1) % 3, (axis + 2) % 3
    to_p = (p[b] - edges.ends[e, b]) ** 2 + (p[c] - edges.ends[e, c]) ** 2 + (p[axis] - x) ** 2
    to_q = (q[b] - edges.ends[e, b]) ** 2 + (q[c] - edges.ends[e, c]) ** 2 + (q[axis] - x) ** 2
    return np.sqrt(to_p) + np.sqrt(to_q)


@inner_query
def move_off(edges: Edges, e: int, p: Floats, metres: float) -> None:
    """Move a point of piece e, in place, so many metres off both faces of its edge; towards them if negative."""
    for k in range(2):
        p[(edges.axis[e] + 1 + k) % 3] += edges.side[e, k] * metres


@inner
def crossings_within(edges: Edges, e: int, x: float, p: Floats, q: Floats, length: float) -> tuple[float, float]:
    """Return between which places around x on piece e a path of at most this length from p to q can cross it."""
    axis = edges.axis[e]
    ends = (edges.ends[e, axis], edges.ends[e, axis + 3])
    reached = (x, x)
    for side in range(2):
        inside, outside = x, ends[side]
        if length_over(edges, e, outside, p, q) <= length:
            inside = outside
        else:
            for _ in range(REACH_BISECTIONS):
                middle = 0.5 * (inside + outside)
                if length_over(edges, e, middle, p, q) <= length:
                    inside = middle
                else:
                    outside = middle
        reached = (inside, reached[1]) if side == 0 else (reached[0], inside)
    return reached


@inner_query
def beside_faces(least_b: float, most_b: float, least_c: float, most_c: float) -> int:
    """Return beside which faces of an edge some point of a box lies: bit 1 for the first face, bit 2 for the second.

    The box is given by its least and greatest metres from the edge into free space, along the edge's two normals.
    """
    first = 1 if most_b >= -FACE_PLANE and least_c <= FACE_PLANE else 0
    return first + (2 if most_c >= -FACE_PLANE and least_b <= FACE_PLANE else 0)
