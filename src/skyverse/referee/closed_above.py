"""Obstacles as the referee judges them: those that are closed above reach up to above the bounds."""

from dataclasses import dataclass

import numpy as np

from skyverse.model.scenario import Scenario
from skyverse.model.shapes import AnyShape, Box, Cylinder, Prism, Sphere, Voxels

BEYOND = 10.0
"""Metres above the highest of bounds and obstacle where what is closed above ends; no UAV may be there."""


@dataclass(frozen=True)
class NumberedShape:
    """A shape that must not be entered, and the number of the scenario's obstacle that it belongs to."""

    number: int
    shape: AnyShape


def numbered_shapes(scenario: Scenario) -> list[NumberedShape]:
    """Return all shapes that must not be entered, in the order of the scenario's obstacles."""
    shapes = []
    for number, shape in enumerate(scenario.obstacles):
        shapes.append(NumberedShape(number, _raised(shape, scenario.bounds.max[2]) if shape.closed_above else shape))
        if shape.closed_above and isinstance(shape, Sphere):
            column = _column(shape, scenario.bounds.max[2])
            shapes.append(NumberedShape(number, column))
    return shapes


def _column(sphere: Sphere, bound: float) -> Cylinder:
    """Return what is above the middle of a sphere, as a cylinder."""
    x, y, z = sphere.centre
    return Cylinder(centre=(x, y), radius=sphere.radius, low=z, high=max(z + sphere.radius, bound) + BEYOND)


def _raised(shape: AnyShape, bound: float) -> AnyShape:
    """Return a shape with its upper face above `bound`; spheres have none and stay as they are."""
    match shape:
        case Box():
            return shape.model_copy(update={"max": (*shape.max[:2], max(shape.max[2], bound) + BEYOND)})
        case Cylinder() | Prism():
            return shape.model_copy(update={"high": max(shape.high, bound) + BEYOND})
        case Voxels():
            cells = shape.occupied
            more = max(0, int(np.ceil((bound + BEYOND - shape.origin[2]) / shape.step[2])) - cells.shape[2])
            taller = np.zeros((*cells.shape[:2], cells.shape[2] + more), dtype=bool)
            taller[:, :, : cells.shape[2]] = cells
            return shape.model_copy(update={"occupied": np.cumsum(taller, axis=2) > 0})
    return shape
