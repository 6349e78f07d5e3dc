"""Shapes that must not be entered, by their kinds, and prisms among them as arrays of edges and altitudes."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar, cast

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extruded
from skyverse.model.shapes import Prism, Shape

ShapeKind = TypeVar("ShapeKind", bound=Shape)


class Outlines(NamedTuple):
    """The outlines and altitudes of prisms.

    Attributes
    ----------
    p, q
        (e, 2) metres: the ends of the edges of all outlines and holes, one prism's after another's.
    first, edges
        (m,) the index of each prism's first edge, and how many edges it has.
    low, high
        (m,) altitudes, metres.
    """

    p: Floats
    q: Floats
    first: Indices
    edges: Indices
    low: Floats
    high: Floats

    def of(self, some: Indices) -> "Outlines":
        """Return those of some of the prisms, given by their numbers (k,)."""
        count = self.edges[some]
        first = np.cumsum(count) - count
        edge = np.arange(count.sum()) + np.repeat(self.first[some] - first, count)
        return Outlines(self.p[edge], self.q[edge], first, count, self.low[some], self.high[some])


def outlines_of(prisms: Sequence[Prism]) -> Outlines:
    """Return the outlines of prisms."""
    rings = [ring for prism in prisms for ring in (prism.vertices, *prism.holes)]
    size = np.array([len(ring) for ring in rings], dtype=np.intp)
    p = np.reshape([corner for ring in rings for corner in ring], (int(size.sum()), 2))
    following, begins = np.arange(1, len(p) + 1), np.cumsum(size) - size
    following[begins + size - 1] = begins
    edges = np.array([len(prism.vertices) + sum(map(len, prism.holes)) for prism in prisms], dtype=np.intp)
    low = np.array([prism.low for prism in prisms], dtype=np.float64)
    high = np.array([prism.high for prism in prisms], dtype=np.float64)
    return Outlines(p, p[following], np.cumsum(edges) - edges, edges, low, high)


@dataclass(frozen=True, eq=False)
class SolidShapes:
    """All shapes that must not be entered, by their kinds, and the clearance by which they are grown.

    Attributes
    ----------
    clearance
        Metres.
    by_kind
        The shapes of each kind, in the order in which they are given, with their numbers.
    outlines
        Those of the prisms.
    """

    clearance: float
    by_kind: dict[type[Shape], tuple[list[Shape], list[int]]]
    outlines: Outlines

    def of(self, kind: type[ShapeKind]) -> tuple[list[ShapeKind], Indices]:
        """Return all shapes of one kind, and the numbers (m,) that they are known by."""
        shapes, numbers = self.by_kind.get(kind, ([], []))
        return cast("list[ShapeKind]", shapes), np.array(numbers, dtype=np.intp)


def solid_shapes(scenario: Scenario) -> SolidShapes:
    """Return all shapes of a scenario that must not be entered."""
    top = scenario.bounds.max[2]
    numbered = ((k, shape) for k, obstacle in enumerate(scenario.obstacles) for shape in extruded(obstacle, top))
    return by_kind(numbered, scenario.clearance)


def by_kind(numbered: Iterable[tuple[int, Shape]], clearance: float) -> SolidShapes:
    """Sort shapes by their kinds, each with the number that it is to be known by."""
    kinds: dict[type[Shape], tuple[list[Shape], list[int]]] = defaultdict(lambda: ([], []))
    for number, shape in numbered:
        shapes, numbers = kinds[type(shape)]
        shapes.append(shape)
        numbers.append(number)
    return SolidShapes(clearance, dict(kinds), outlines_of(cast("list[Prism]", kinds[Prism][0])))
