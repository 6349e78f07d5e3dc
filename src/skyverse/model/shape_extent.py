"""What shapes take up: the box around one, and, where one is closed above, all that is above it."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.model.mover import Ellipsoid
from skyverse.model.quantities import derived
from skyverse.model.shapes import AnyShape, Box, Cylinder, Prism, Shape, Sphere, Voxels


def extent(shape: Shape) -> tuple[Floats, Floats]:
    """Return the least and the greatest corner of the box around a shape, (3,) metres each."""
    if isinstance(shape, Box):
        return np.array(shape.min), np.array(shape.max)
    if isinstance(shape, Sphere):
        return np.array(shape.centre) - shape.radius, np.array(shape.centre) + shape.radius
    if isinstance(shape, Ellipsoid):
        size = np.array((shape.semi_axis_xy, shape.semi_axis_xy, shape.semi_axis_z))
        return np.array(shape.centre) - size, np.array(shape.centre) + size
    if isinstance(shape, Voxels):
        low = np.array(shape.origin)
        return low, low + np.array(shape.step) * shape.occupied.shape
    if isinstance(shape, Cylinder):
        (x, y), r = shape.centre, shape.radius
        return np.array([x - r, y - r, shape.low]), np.array([x + r, y + r, shape.high])
    assert isinstance(shape, Prism)
    xs, ys = zip(*shape.vertices, strict=True)  # a few numbers, which NumPy takes longer for
    return np.array([min(xs), min(ys), shape.low]), np.array([max(xs), max(ys), shape.high])


ABOVE_BOUNDS = 10.0
"""Metres above the highest of bounds and shape where what is closed above ends; no UAV may be there."""


def extruded(shape: AnyShape, top: float) -> tuple[AnyShape, ...]:
    """Return shapes that together fill a shape and, if it is closed above, what is above it.

    Parameters
    ----------
    shape
        As it is given.
    top
        The z of the upper side of the bounds, metres.
    """
    if not shape.closed_above:
        return (shape,)
    match shape:
        case Box():
            x, y, z = shape.max
            return (derived(shape, max=(x, y, max(z, top) + ABOVE_BOUNDS)),)
        case Sphere():
            (x, y, z), radius = shape.centre, shape.radius
            return shape, Cylinder(centre=(x, y), radius=radius, low=z, high=max(z + radius, top) + ABOVE_BOUNDS)
        case Voxels():
            filled = np.logical_or.accumulate(shape.occupied, axis=2)
            layers = math.ceil((top + ABOVE_BOUNDS - shape.origin[2]) / shape.step[2]) - filled.shape[2]
            above = np.repeat(filled[:, :, -1:], max(layers, 0), axis=2)
            return (derived(shape, occupied=np.concatenate([filled, above], axis=2)),)
    return (derived(shape, high=max(shape.high, top) + ABOVE_BOUNDS),)


def roof_z(shape: AnyShape, point: tuple[float, float, float], clearance: float) -> float:
    """Return the z at which an obstacle ends, metres.

    Parameters
    ----------
    shape
        The obstacle.
    point
        x, y, z in metres: of voxels, only those count that are nearer to this point, as seen from above, than the
        clearance along x and y.
    clearance
        Metres.
    """
    if isinstance(shape, Box):
        return shape.max[2]
    if isinstance(shape, Sphere):
        return shape.centre[2] + shape.radius
    if not isinstance(shape, Voxels):
        return shape.high
    first, step = np.array(shape.origin), np.array(shape.step)
    cells = [np.floor((np.array(point) + side * clearance - first) / step).astype(int) for side in (-1, 1)]
    (i, j, _), (last_i, last_j, _) = np.clip(cells, 0, np.array(shape.occupied.shape) - 1).tolist()
    levels = np.flatnonzero(shape.occupied[i : last_i + 1, j : last_j + 1].any(axis=(0, 1)))
    return float(first[2] + step[2] * (levels.max(initial=-1) + 1))
