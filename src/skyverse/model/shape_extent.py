"""The box around a shape."""

import numpy as np

from skyverse._typing import Floats
from skyverse.model.mover import Ellipsoid
from skyverse.model.shapes import Box, Cylinder, Prism, Shape, Sphere, Voxels


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
