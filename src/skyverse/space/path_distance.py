"""How far curves are from a path of straight legs."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner_query, kernel
from skyverse.space import box
from skyverse.space.tree import FIRST, SKIP, STOP, Tree, build


@kernel
def farthest_ends(curves: Floats, path: Floats) -> tuple[float, Floats]:
    """Return how far an end of a curve is from a path at most, and bounds (n,) of how far each curve is, metres.

    The distance from one leg is convex, so that on a curve it is largest at one of its coefficients in Bernstein form.
    The least of these over all legs is the bound.

    Parameters
    ----------
    curves
        (n, degree + 1, 3) metres, in Bernstein form.
    path
        (m, 3) metres.
    """
    legs = np.empty((max(len(path) - 1, 1), 6))
    for i in range(len(legs)):
        legs[i, :3], legs[i, 3:] = path[i], path[min(i + 1, len(path) - 1)]
    boxes = np.empty_like(legs)
    for axis in range(3):
        boxes[:, axis] = np.minimum(legs[:, axis], legs[:, axis + 3])
        boxes[:, axis + 3] = np.maximum(legs[:, axis], legs[:, axis + 3])
    tree, order = build(boxes)
    boxes, legs = boxes[order], legs[order]
    reached, bounds = -np.inf, np.empty(len(curves))
    last = curves.shape[1] - 1
    for i in range(len(curves)):
        bounds[i] = _from_nearest(tree, boxes, legs, curves[i], 0, last)
        for end in (0, last):
            reached = max(reached, _from_nearest(tree, boxes, legs, curves[i], end, end))
    return reached, bounds


@inner_query
def _from_nearest(tree: Tree, boxes: Floats, legs: Floats, points: Floats, first: int, last: int) -> float:
    """Return how far from the leg that is nearest to them the points from `first` to `last` are at most."""
    nearest = np.inf
    node = 0
    while node < len(tree.links):
        if box.gap(tree.bounds, node, points[first, 0], points[first, 1], points[first, 2]) >= nearest:
            node = tree.links[node, SKIP]
            continue
        for i in range(tree.links[node, FIRST], tree.links[node, STOP]):
            farthest = -np.inf
            for k in range(first, last + 1):
                farthest = max(farthest, _from_leg(legs, i, points[k, 0], points[k, 1], points[k, 2]))
            nearest = min(nearest, farthest)
        node += 1
    return nearest


@inner_query
def _from_leg(legs: Floats, i: int, x: float, y: float, z: float) -> float:
    """Return the distance of a point from leg i, metres."""
    dx, dy, dz = legs[i, 3] - legs[i, 0], legs[i, 4] - legs[i, 1], legs[i, 5] - legs[i, 2]
    x, y, z = x - legs[i, 0], y - legs[i, 1], z - legs[i, 2]
    square = dx * dx + dy * dy + dz * dz
    share = min(max((x * dx + y * dy + z * dz) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.sqrt((x - share * dx) ** 2 + (y - share * dy) ** 2 + (z - share * dz) ** 2)
