"""Polygons on the map, with or without holes: the edges of all their rings, (m, 4) rows x, y, x, y in metres.

One array holds the edges of many polygons; those of one are the rows from ``first`` up to before ``stop``.
"""

import math

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner_query
from skyverse.numerics.tolerances import SURFACE_DEPTH
from skyverse.space.slab import clip


@inner_query
def inside(edges: Floats, first: int, stop: int, x: float, y: float) -> bool:
    """Tell whether a polygon holds a place: a ray from it crosses the rings an odd number of times."""
    odd = False
    for e in range(first, stop):
        ay, by = edges[e, 1], edges[e, 3]
        if (ay > y) != (by > y) and edges[e, 0] + (y - ay) / (by - ay) * (edges[e, 2] - edges[e, 0]) > x:
            odd = not odd
    return odd


@inner_query
def to_edge(edges: Floats, e: int, x: float, y: float) -> float:
    """Return the squared distance from a place to an edge."""
    ax, ay = edges[e, 0] - x, edges[e, 1] - y
    dx, dy = edges[e, 2] - edges[e, 0], edges[e, 3] - edges[e, 1]
    squared = dx * dx + dy * dy
    t = min(max(-(ax * dx + ay * dy) / squared, 0.0), 1.0) if squared > 0.0 else 0.0
    return (ax + t * dx) ** 2 + (ay + t * dy) ** 2


@inner_query
def to_outline(edges: Floats, first: int, stop: int, x: float, y: float) -> float:
    """Return the distance from a place to the nearest edge."""
    least = math.inf
    for e in range(first, stop):
        least = min(least, to_edge(edges, e, x, y))
    return math.sqrt(least)


@inner_query
def holds(edges: Floats, first: int, stop: int, margin: float, x: float, y: float) -> bool:
    """Tell whether a place is nearer to a polygon than a margin; if that is below 0, deeper inside than it."""
    if margin > 0.0:
        for e in range(first, stop):
            if to_edge(edges, e, x, y) < margin * margin:
                return True
        return inside(edges, first, stop, x, y)
    return inside(edges, first, stop, x, y) and to_outline(edges, first, stop, x, y) > -margin


@inner_query
def crosses(edges: Floats, first: int, stop: int, margin: float, ax: float, ay: float, bx: float, by: float) -> bool:
    """Tell whether a segment comes nearer to a polygon than a margin, or meets it if that is 0 or less."""
    margin = max(margin, SURFACE_DEPTH)
    low_x, high_x = min(ax, bx) - margin, max(ax, bx) + margin
    low_y, high_y = min(ay, by) - margin, max(ay, by) + margin
    squared = margin * margin
    for e in range(first, stop):
        px, py, qx, qy = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
        if min(px, qx) >= high_x or max(px, qx) <= low_x or min(py, qy) >= high_y or max(py, qy) <= low_y:
            continue
        if between_segments(ax, ay, bx, by, px, py, qx, qy) < squared:
            return True
    return inside(edges, first, stop, ax, ay)


@inner_query
def between_segments(ax: float, ay: float, bx: float, by: float, px: float, py: float, qx: float, qy: float) -> float:
    """Return the squared distance between the segments a-b and p-q."""
    dx, dy, ex, ey = bx - ax, by - ay, qx - px, qy - py
    p_side, q_side = dx * (py - ay) - dy * (px - ax), dx * (qy - ay) - dy * (qx - ax)
    a_side, b_side = ex * (ay - py) - ey * (ax - px), ex * (by - py) - ey * (bx - px)
    if ((p_side > 0.0) != (q_side > 0.0)) and ((a_side > 0.0) != (b_side > 0.0)) and p_side != q_side:
        return 0.0
    return min(
        min(_to_segment(px, py, ax, ay, dx, dy), _to_segment(qx, qy, ax, ay, dx, dy)),
        min(_to_segment(ax, ay, px, py, ex, ey), _to_segment(bx, by, px, py, ex, ey)),
    )


@inner_query
def _to_segment(x: float, y: float, ax: float, ay: float, dx: float, dy: float) -> float:
    """Return the squared distance from a place to the segment that begins at (ax, ay) and extends by (dx, dy)."""
    squared = dx * dx + dy * dy
    t = min(max(((x - ax) * dx + (y - ay) * dy) / squared, 0.0), 1.0) if squared > 0.0 else 0.0
    return (ax + t * dx - x) ** 2 + (ay + t * dy - y) ** 2


@inner_query
def reaches(edges: Floats, first: int, stop: int, margin: float, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Tell whether a rectangle comes nearer to a polygon than a margin; if that is 0 or less, whether it meets it."""
    if margin <= 0.0:  # what is deeper inside than -margin has half as much of the polygon around it
        shrink_x, shrink_y = min(-margin / 2, (x1 - x0) / 2), min(-margin / 2, (y1 - y0) / 2)
        x0, x1, y0, y1 = x0 + shrink_x, x1 - shrink_x, y0 + shrink_y, y1 - shrink_y
    squared = margin * margin
    for e in range(first, stop):
        apart = to_rectangle(edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3], x0, y0, x1, y1)
        if apart < squared if margin > 0.0 else apart <= 0.0:
            return True
    return inside(edges, first, stop, x0, y0)


@inner_query
def to_rectangle(px: float, py: float, qx: float, qy: float, x0: float, y0: float, x1: float, y1: float) -> float:
    """Return the squared distance between the segment p-q and a rectangle."""
    enter, leave = clip(x0, x1, px, qx - px, 0.0, 1.0)
    enter, leave = clip(y0, y1, py, qy - py, enter, leave)
    if enter <= leave:
        return 0.0
    dx, dy = qx - px, qy - py
    least = min(_outside(px, py, x0, y0, x1, y1), _outside(qx, qy, x0, y0, x1, y1))
    least = min(least, min(_to_segment(x0, y0, px, py, dx, dy), _to_segment(x1, y0, px, py, dx, dy)))
    return min(least, min(_to_segment(x0, y1, px, py, dx, dy), _to_segment(x1, y1, px, py, dx, dy)))


@inner_query
def _outside(x: float, y: float, x0: float, y0: float, x1: float, y1: float) -> float:
    """Return the squared distance from a place to a rectangle."""
    return max(x0 - x, x - x1, 0.0) ** 2 + max(y0 - y, y - y1, 0.0) ** 2
