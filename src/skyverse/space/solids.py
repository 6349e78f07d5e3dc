"""Solids other than boxes: vertical cylinders, spheres, and prisms on polygons, in one table with one index."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.shapes import Box, Cylinder, Prism, Shape, Sphere
from skyverse.model.uav import TrackingError
from skyverse.numerics.kernel import by_reference, inner_query, query
from skyverse.numerics.tolerances import SURFACE_DEPTH
from skyverse.space import box, polygon, tree
from skyverse.space.tracking_error import NO_ERROR, taller, wider
from skyverse.space.tree import FIRST, SKIP, STOP, Tree

BOX, CYLINDER, SPHERE, PRISM = 0, 1, 2, 3
"""Kinds of solids. Boxes that are obstacles have a table of their own; boxes that are zones are solids."""


@by_reference
class Solids(NamedTuple):
    """Solids in the order of their index.

    Attributes
    ----------
    bounds
        (n, 6) metres: min and max corner.
    round
        (n, 4) metres: centre and radius of cylinders and spheres.
    kind
        (n, 3) the kind of each, and its first edge in `edges` and the one after its last.
    edges
        (m, 4) x, y, x, y in metres: the edges of all rings of all prisms; outlines run counterclockwise, holes
        clockwise.
    tree
        The index over `bounds`.
    """

    bounds: Floats
    round: Floats
    kind: Ints
    edges: Floats
    tree: Tree


def make_solids(shapes: Sequence[Shape], error: TrackingError = NO_ERROR) -> tuple[Solids, Ints]:
    """Compile shapes to solids for UAVs that may stray by an error; return also, (n,), which shape each solid is."""
    count = len(shapes)
    bounds, round_ = np.zeros((count, 6)), np.zeros((count, 4))
    kind = np.zeros((count, 3), np.int64)
    for i, shape in enumerate(shapes):
        if isinstance(shape, Box):
            bounds[i] = *shape.min, *shape.max
        elif isinstance(shape, Sphere):
            (x, y, z), r = shape.centre, shape.radius
            round_[i] = x, y, z, r
            kind[i, 0] = SPHERE
        elif isinstance(shape, Cylinder):
            (x, y), r = shape.centre, shape.radius
            bounds[i] = x - r, y - r, shape.low, x + r, y + r, shape.high
            round_[i] = x, y, 0.0, r
            kind[i, 0] = CYLINDER
        elif isinstance(shape, Prism):
            bounds[i, 2], bounds[i, 5] = shape.low, shape.high
            kind[i, 0] = PRISM
    edges = _add_edges([shape if isinstance(shape, Prism) else None for shape in shapes], bounds, kind)
    spheres = kind[:, 0] == SPHERE
    bounds[:, [2, 5]] += np.array([-1.0, 1.0]) * taller(error)
    round_[spheres, 3] += wider(error)
    balls = round_[spheres]
    bounds[spheres] = np.hstack([balls[:, :3] - balls[:, 3:], balls[:, :3] + balls[:, 3:]])
    index, order = tree.build(bounds)
    return Solids(bounds[order], round_[order], kind[order], edges, index), order


def _add_edges(prisms: Sequence[Prism | None], bounds: Floats, kind: Ints) -> Floats:
    """Return the edges of all prisms, (m, 4); write into `kind` where those of each are, and its bounds."""
    rings = [ring for prism in prisms if prism for ring in (prism.vertices, *prism.holes)]
    if not rings:
        return np.zeros((0, 4))
    corners = np.array([corner for ring in rings for corner in ring])
    sizes = np.array([len(ring) for ring in rings])
    starts = np.cumsum(sizes) - sizes
    following = np.arange(1, len(corners) + 1)
    following[starts + sizes - 1] = starts
    first = np.repeat(corners[starts], sizes, axis=0)
    a, b = corners - first, corners[following] - first
    area = np.add.reduceat(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], starts)
    count = np.array([1 + len(prism.holes) if prism else 0 for prism in prisms])
    which = np.flatnonzero(count)
    outline = np.cumsum(count)[which] - count[which]  # the ring that is each prism's outline
    out = np.zeros(len(rings), bool)
    out[outline] = True
    turned = np.repeat((area > 0) != out, sizes)[:, None]
    edges = np.where(turned, np.hstack((corners[following], corners)), np.hstack((corners, corners[following])))
    kind[which, 1] = starts[outline]
    kind[which, 2] = [*starts[outline[1:]], len(corners)]
    bounds[which, 0:2] = np.minimum.reduceat(corners, starts)[outline]
    bounds[which, 3:5] = np.maximum.reduceat(corners, starts)[outline]
    return np.ascontiguousarray(edges)


@inner_query
def holds(solids: Solids, i: int, growth: float, x: float, y: float, z: float) -> bool:
    """Tell whether the interior of solid i, grown by `growth`, holds the point."""
    margin = growth - SURFACE_DEPTH
    kind = solids.kind[i, 0]
    if kind == SPHERE:
        reach = solids.round[i, 3] + margin
        dx, dy, dz = x - solids.round[i, 0], y - solids.round[i, 1], z - solids.round[i, 2]
        return reach > 0.0 and dx * dx + dy * dy + dz * dz < reach * reach
    if not box.holds(solids.bounds, i, growth, x, y, z):
        return False
    if kind == CYLINDER:
        reach = solids.round[i, 3] + margin
        dx, dy = x - solids.round[i, 0], y - solids.round[i, 1]
        return reach > 0.0 and dx * dx + dy * dy < reach * reach
    return kind == BOX or polygon.holds(solids.edges, solids.kind[i, 1], solids.kind[i, 2], margin, x, y)


@inner_query
def meets(solids: Solids, i: int, growth: float, a: Floats, b: Floats) -> bool:
    """Tell exactly whether a segment that meets solid i's bounds, grown by `growth`, meets the solid's interior."""
    margin = growth - SURFACE_DEPTH
    kind = solids.kind[i, 0]
    if kind == BOX:
        return True
    if kind == SPHERE:
        reach = solids.round[i, 3] + margin
        return reach > 0.0 and _nearest(solids.round, i, 3, a, b, 0.0, 1.0) < reach * reach
    enter, leave = 0.0, 1.0
    rise = b[2] - a[2]
    low, high = solids.bounds[i, 2] - margin, solids.bounds[i, 5] + margin
    if rise == 0.0:
        if not low < a[2] < high:
            return False
    else:
        one, other = (low - a[2]) / rise, (high - a[2]) / rise
        enter, leave = max(0.0, min(one, other)), min(1.0, max(one, other))
        if enter >= leave:
            return False
    if kind == CYLINDER:
        reach = solids.round[i, 3] + margin
        return reach > 0.0 and _nearest(solids.round, i, 2, a, b, enter, leave) < reach * reach
    dx, dy = b[0] - a[0], b[1] - a[1]
    px, py, qx, qy = a[0] + enter * dx, a[1] + enter * dy, a[0] + leave * dx, a[1] + leave * dy
    return polygon.crosses(solids.edges, solids.kind[i, 1], solids.kind[i, 2], margin, px, py, qx, qy)


@inner_query
def _nearest(round_: Floats, i: int, axes: int, a: Floats, b: Floats, enter: float, leave: float) -> float:
    """Return the least squared distance to a centre, over two axes or three, between two shares of a segment."""
    squared, t = nearest_share(round_, i, axes, a, b)
    t = min(max(t, enter), leave) if squared > 0.0 else enter
    least = 0.0
    for axis in range(axes):
        least += (a[axis] + t * (b[axis] - a[axis]) - round_[i, axis]) ** 2
    return least


@inner_query
def nearest_share(round_: Floats, i: int, axes: int, a: Floats, b: Floats) -> tuple[float, float]:
    """Return a segment's squared length over two axes or three, and at which share its line is nearest to centre i.

    With the extent d of the segment and its begin a, the share is (centre - a) . d / (d . d); it is 0 where d is 0.
    """
    squared = along = 0.0
    for axis in range(axes):
        d = b[axis] - a[axis]
        squared += d * d
        along += (round_[i, axis] - a[axis]) * d
    return squared, along / squared if squared > 0.0 else 0.0


@inner_query
def reaches(solids: Solids, i: int, growth: float, low: Floats, high: Floats) -> bool:
    """Tell whether the interior of solid i, grown by `growth`, reaches into the open box between two corners."""
    if not box.reaches(solids.bounds, i, growth, low, high):
        return False
    margin = growth - SURFACE_DEPTH
    kind = solids.kind[i, 0]
    if kind == PRISM:
        return polygon.reaches(
            solids.edges, solids.kind[i, 1], solids.kind[i, 2], margin, low[0], low[1], high[0], high[1]
        )
    if kind == BOX:
        return True
    outside = 0.0
    for axis in range(3 if kind == SPHERE else 2):
        centre = solids.round[i, axis]
        outside += max(low[axis] - centre, centre - high[axis], 0.0) ** 2
    reach = solids.round[i, 3] + margin
    return reach > 0.0 and outside < reach * reach


@inner_query
def gap(solids: Solids, i: int, x: float, y: float, z: float) -> float:
    """Return the Euclidean distance to solid i as given, negative inside."""
    kind = solids.kind[i, 0]
    dx, dy, dz = x - solids.round[i, 0], y - solids.round[i, 1], z - solids.round[i, 2]
    if kind == SPHERE:
        return math.sqrt(dx * dx + dy * dy + dz * dz) - solids.round[i, 3]
    if kind == BOX:
        return box.gap(solids.bounds, i, x, y, z)
    if kind == CYLINDER:
        across = math.sqrt(dx * dx + dy * dy) - solids.round[i, 3]
    else:
        first, stop = solids.kind[i, 1], solids.kind[i, 2]
        across = polygon.to_outline(solids.edges, first, stop, x, y)
        if polygon.inside(solids.edges, first, stop, x, y):
            across = -across
    upright = max(solids.bounds[i, 2] - z, z - solids.bounds[i, 5])
    if across <= 0.0 or upright <= 0.0:
        return max(across, upright)
    return math.sqrt(across * across + upright * upright)


def top_above(solids: Solids, i: int, growth: float, x: float, y: float) -> float:
    """Return the z at which solid i, grown by `growth`, ends above a place that it covers, metres."""
    if solids.kind[i, 0] != SPHERE:
        return float(solids.bounds[i, 5] + growth)
    aside = math.hypot(x - solids.round[i, 0], y - solids.round[i, 1])
    reach = solids.round[i, 3] + growth
    return float(solids.round[i, 2] + math.sqrt(max(reach * reach - aside * aside, 0.0)))


@query
def containing(solids: Solids, growth: float, x: float, y: float, z: float) -> int:
    """Return a solid whose interior, grown by `growth`, holds the point, or -1."""
    index = solids.tree
    node = 0
    while node < len(index.links):
        if not box.holds(index.bounds, node, growth, x, y, z):
            node = index.links[node, SKIP]
            continue
        for i in range(index.links[node, FIRST], index.links[node, STOP]):
            if holds(solids, i, growth, x, y, z):
                return i
        node += 1
    return -1


@query
def crossed(solids: Solids, growth: float, a: Floats, b: Floats) -> int:
    """Return a solid whose interior, grown by `growth`, the segment a-b meets, or -1."""
    index = solids.tree
    r = box.ray(a, b)
    node = 0
    while node < len(index.links):
        if not box.meets(index.bounds, node, growth, r):
            node = index.links[node, SKIP]
            continue
        for i in range(index.links[node, FIRST], index.links[node, STOP]):
            if box.meets(solids.bounds, i, growth, r) and meets(solids, i, growth, a, b):
                return i
        node += 1
    return -1


@query
def reaching(solids: Solids, growth: float, low: Floats, high: Floats) -> int:
    """Return a solid that, grown by `growth`, reaches into the open box between two corners, or -1."""
    index = solids.tree
    node = 0
    while node < len(index.links):
        if not box.reaches(index.bounds, node, growth, low, high):
            node = index.links[node, SKIP]
            continue
        for i in range(index.links[node, FIRST], index.links[node, STOP]):
            if reaches(solids, i, growth, low, high):
                return i
        node += 1
    return -1


@inner_query
def distance(solids: Solids, nearest: float, x: float, y: float, z: float) -> float:
    """Return the Euclidean distance to the nearest solid as given, negative inside, or `nearest` if that is less."""
    index = solids.tree
    node = 0
    while node < len(index.links):
        if box.gap(index.bounds, node, x, y, z) >= nearest:
            node = index.links[node, SKIP]
            continue
        for i in range(index.links[node, FIRST], index.links[node, STOP]):
            nearest = min(nearest, gap(solids, i, x, y, z))
        node += 1
    return nearest
