"""All shapes of a scenario that must not be entered, by their kinds."""

from collections import defaultdict
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np

from skyverse._typing import Indices
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extruded
from skyverse.model.shapes import Prism, Shape
from skyverse.referee.outlines import Outlines, outlines_of

ShapeKind = TypeVar("ShapeKind", bound=Shape)


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
        for shape in extruded(obstacle, top):
            shapes, numbers = by_kind[type(shape)]
            shapes.append(shape)
            numbers.append(number)
    prisms = cast("list[Prism]", by_kind[Prism][0])
    return SolidShapes(scenario.clearance, dict(by_kind), outlines_of(prisms))
