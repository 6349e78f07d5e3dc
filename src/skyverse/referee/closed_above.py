"""Obstacles as the referee judges them: those that are closed above reach up to above the bounds."""

from collections import defaultdict
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np

from skyverse._typing import Indices
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import AnyShape, Box, Cylinder, Prism, Shape, Sphere, Voxels
from skyverse.referee.outlines import Outlines, outlines_of

ShapeKind = TypeVar("ShapeKind", bound=Shape)

BEYOND = 10.0
"""Metres above the highest of bounds and obstacle where what is closed above ends; no UAV may be there."""


@dataclass(frozen=True, eq=False)
class SolidShapes:
    """All shapes that must not be entered, by their kinds, and the clearance by which they are grown.

    Attributes
    ----------
    clearance
        Metres.
    by_kind
        The shapes of each kind, in the order of the scenario's obstacles, with the numbers of their obstacles.
    outlines
        Those of the prisms.
    """

    clearance: float
    by_kind: dict[type[Shape], tuple[list[Shape], list[int]]]
    outlines: Outlines

    def of(self, kind: type[ShapeKind]) -> tuple[list[ShapeKind], Indices]:
        """Return all shapes of one kind, and the numbers (m,) of the obstacles that they belong to."""
        shapes, numbers = self.by_kind.get(kind, ([], []))
        return cast("list[ShapeKind]", shapes), np.array(numbers, dtype=np.intp)


def solid_shapes(scenario: Scenario) -> SolidShapes:
    """Return all shapes of a scenario that must not be entered."""
    top = scenario.bounds.max[2]
    by_kind: dict[type[Shape], tuple[list[Shape], list[int]]] = defaultdict(lambda: ([], []))
    for number, obstacle in enumerate(scenario.obstacles):
        for shape in _closed(obstacle, top) if obstacle.closed_above else (obstacle,):
            shapes, numbers = by_kind[type(shape)]
            shapes.append(shape)
            numbers.append(number)
    prisms = cast("list[Prism]", by_kind[Prism][0])
    return SolidShapes(scenario.clearance, dict(by_kind), outlines_of(prisms))


def _closed(shape: AnyShape, top: float) -> tuple[AnyShape, ...]:
    """Return what an obstacle that is closed above consists of."""
    return (shape, _column(shape, top)) if isinstance(shape, Sphere) else (_raised(shape, top),)


def _column(sphere: Sphere, bound: float) -> Cylinder:
    """Return what is above the middle of a sphere, as a cylinder."""
    x, y, z = sphere.centre
    return Cylinder(centre=(x, y), radius=sphere.radius, low=z, high=max(z + sphere.radius, bound) + BEYOND)


def _raised(shape: AnyShape, bound: float) -> AnyShape:
    """Return a shape with its upper face above `bound`; spheres have none and stay as they are."""
    match shape:
        case Box():
            return derived(shape, max=(*shape.max[:2], max(shape.max[2], bound) + BEYOND))
        case Cylinder() | Prism():
            return derived(shape, high=max(shape.high, bound) + BEYOND)
        case Voxels():
            cells = shape.occupied
            more = max(0, int(np.ceil((bound + BEYOND - shape.origin[2]) / shape.step[2])) - cells.shape[2])
            taller = np.zeros((*cells.shape[:2], cells.shape[2] + more), dtype=bool)
            taller[:, :, : cells.shape[2]] = cells
            return derived(shape, occupied=np.cumsum(taller, axis=2) > 0)
    return shape
