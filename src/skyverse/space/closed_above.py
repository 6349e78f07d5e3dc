"""Obstacles that are closed above: what is above them, up to above the bounds, belongs to them."""

import math
from collections.abc import Iterable, Iterator

import numpy as np

from skyverse.model.quantities import derived
from skyverse.model.shapes import AnyShape, Box, Cylinder, Sphere, Voxels

ABOVE_BOUNDS = 1.0
"""Metres above the bounds where an obstacle that is closed above ends."""


def numbered_shapes(obstacles: Iterable[AnyShape], top: float) -> Iterator[tuple[int, AnyShape]]:
    """Yield the shapes that fill space, each with the number of its obstacle.

    Parameters
    ----------
    obstacles
        As they are given.
    top
        The z up to which obstacles reach that are closed above, metres.
    """
    for number, obstacle in enumerate(obstacles):
        for shape in _closed(obstacle, top) if obstacle.closed_above else (obstacle,):
            yield number, shape


def _closed(shape: AnyShape, top: float) -> Iterator[AnyShape]:
    """Yield shapes that together fill an obstacle and what is above it."""
    if isinstance(shape, Box):
        (x, y, z) = shape.max
        yield derived(shape, max=(x, y, max(z, top)))
    elif isinstance(shape, Sphere):
        (x, y, z), r = shape.centre, shape.radius
        yield shape
        yield Cylinder(centre=(x, y), radius=r, low=z, high=max(z + r, top))  # grown, it may reach below the top
    elif isinstance(shape, Voxels):
        filled = np.logical_or.accumulate(shape.occupied, axis=2)
        layers = math.ceil((top - shape.origin[2]) / shape.step[2]) - filled.shape[2]
        above = np.repeat(filled[:, :, -1:], max(layers, 0), axis=2)
        yield derived(shape, occupied=np.concatenate([filled, above], axis=2))
    else:
        yield derived(shape, high=max(shape.high, top))
