"""How much of a segment lies inside a zone's solid as given: for that much, the zone's price a metre is paid."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner_query
from skyverse.numerics.tolerances import SURFACE_DEPTH
from skyverse.space import box
from skyverse.space.slab import clip
from skyverse.space.solids import BOX, CYLINDER, SPHERE, Solids, nearest_share
from skyverse.space.tree import FIRST, SKIP, STOP

EDGES_A_FRAME = 32
"""How many edges of polygons share a frame, so that a line passes by all of them at once."""


def frames_around(edges: Floats) -> Floats:
    """Return the rectangle around every `EDGES_A_FRAME` edges (m, 4) in a row: low x, low y, high x, high y, (k, 4)."""
    if not len(edges):
        return np.zeros((0, 4))
    begins = np.arange(0, len(edges), EDGES_A_FRAME)
    low, high = np.minimum(edges[:, :2], edges[:, 2:]), np.maximum(edges[:, :2], edges[:, 2:])
    return np.ascontiguousarray(np.hstack([np.minimum.reduceat(low, begins), np.maximum.reduceat(high, begins)]))


@inner_query
def priced(solids: Solids, frames: Floats, prices: Floats, a: Floats, b: Floats) -> float:
    """Return the sum over solids (n,) of the share of the segment a-b that lies inside, times the solid's price.

    `frames` are those around the solids' edges.

    A segment along a surface may count as inside or as outside, but always the same in both directions.
    """
    if b[0] < a[0] or (b[0] == a[0] and (b[1] < a[1] or (b[1] == a[1] and b[2] < a[2]))):
        a, b = b, a
    index = solids.tree
    r = box.ray(a, b)
    total = 0.0
    node = 0
    while node < len(index.links):
        if not box.meets(index.bounds, node, 2.0 * SURFACE_DEPTH, r):
            node = index.links[node, SKIP]
            continue
        for i in range(index.links[node, FIRST], index.links[node, STOP]):
            if box.meets(solids.bounds, i, 2.0 * SURFACE_DEPTH, r):
                total += prices[i] * chord(solids, frames, i, a, b)
        node += 1
    return total


@inner_query
def chord(solids: Solids, frames: Floats, i: int, a: Floats, b: Floats) -> float:
    """Return the share, 0 to 1, of the segment a-b that lies inside solid i."""
    kind = solids.kind[i, 0]
    if kind == SPHERE:
        return _in_round(solids.round, i, 3, a, b, 0.0, 1.0)
    enter, leave = clip(solids.bounds[i, 2], solids.bounds[i, 5], a[2], b[2] - a[2], 0.0, 1.0)
    if kind == BOX:
        enter, leave = clip(solids.bounds[i, 0], solids.bounds[i, 3], a[0], b[0] - a[0], enter, leave)
        enter, leave = clip(solids.bounds[i, 1], solids.bounds[i, 4], a[1], b[1] - a[1], enter, leave)
        return max(0.0, leave - enter)
    if enter >= leave:
        return 0.0
    if kind == CYLINDER:
        return _in_round(solids.round, i, 2, a, b, enter, leave)
    return _in_polygon(solids.edges, frames, solids.kind[i, 1], solids.kind[i, 2], a, b, enter, leave)


@inner_query
def _in_round(round_: Floats, i: int, axes: int, a: Floats, b: Floats, enter: float, leave: float) -> float:
    """Return how much of a segment is within circle i (2 axes) or sphere i (3 axes) between two of its shares."""
    squared, middle = nearest_share(round_, i, axes, a, b)
    half = round_[i, 3] ** 2
    for axis in range(axes):
        half -= (a[axis] + middle * (b[axis] - a[axis]) - round_[i, axis]) ** 2
    if half <= 0.0:
        return 0.0
    if squared == 0.0:
        return leave - enter
    half = math.sqrt(half / squared)
    return max(0.0, min(leave, middle + half) - max(enter, middle - half))


@inner_query
def _in_polygon(
    edges: Floats, frames: Floats, first: int, stop: int, a: Floats, b: Floats, enter: float, leave: float
) -> float:
    """Return how much of a segment is over a polygon between two of its shares.

    A line enters and leaves a polygon in turn, and crosses its rings in opposite senses, because holes turn the other
    way. So the signed sum of the shares at which it crosses them, each clipped to the segment, is what lies inside, and
    the crossings need not be sorted. Edges whose frame the line passes by are left out: it crosses none of them.
    """
    dx, dy = b[0] - a[0], b[1] - a[1]
    squared = dx * dx + dy * dy
    ray = squared == 0.0  # straight up or down: a ray along x tells whether the place is inside
    if ray:
        dx = squared = 1.0
    inside = 0.0
    for frame in range(first // EDGES_A_FRAME, (stop + EDGES_A_FRAME - 1) // EDGES_A_FRAME):
        if not _meets_line(frames, frame, a, dx, dy):
            continue
        for e in range(max(first, frame * EDGES_A_FRAME), min(stop, (frame + 1) * EDGES_A_FRAME)):
            px, py, qx, qy = edges[e, 0] - a[0], edges[e, 1] - a[1], edges[e, 2] - a[0], edges[e, 3] - a[1]
            side, side_q = dx * py - dy * px, dx * qy - dy * qx
            if (side > 0.0) != (side_q > 0.0):
                along, along_q = (dx * px + dy * py) / squared, (dx * qx + dy * qy) / squared
                t = along + (along_q - along) * (side / (side - side_q))
                t = (1.0 if t > 0.0 else 0.0) if ray else min(max(t, enter), leave)
                inside += t if side_q > 0.0 else -t
    return abs(inside) * (leave - enter) if ray else abs(inside)


@inner_query
def _meets_line(frames: Floats, frame: int, a: Floats, dx: float, dy: float) -> bool:
    """Tell whether a frame has places on both sides of the line through a along (dx, dy).

    Each step rounds up and down as the sides of the edges' ends do, so that no edge that crosses the line is lost.
    """
    up, down = dx * (frames[frame, 3] - a[1]), dx * (frames[frame, 1] - a[1])
    left, right = dy * (frames[frame, 0] - a[0]), dy * (frames[frame, 2] - a[0])
    return max(up, down) - min(left, right) > 0.0 >= min(up, down) - max(left, right)
