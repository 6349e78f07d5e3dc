"""Shapes that are closed above: what is above them, up to above the bounds, belongs to them."""

import math

import numpy as np

from skyverse.model.quantities import derived
from skyverse.model.shapes import AnyShape, Box, Cylinder, Sphere, Voxels

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
