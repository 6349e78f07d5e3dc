"""What is missing of a survey: the gaps of its coverage as rectangles along strips, or as facets."""

import numpy as np
import shapely
from shapely import affinity

from skyverse._typing import Floats
from skyverse.model.coverage import Coverage
from skyverse.model.quantities import Point

FILLED = 0.75
"""The least share of a rectangle that gaps fill which are seen together as that rectangle."""
LEAST = 0.05
"""Metres: narrower gaps are as broad as that."""


def boxes_of(coverage: Coverage, direction: float, near: float) -> list[Floats]:
    """Return the corners (4, 2) of rectangles in a direction about gaps, those as one that together fill one.

    Gaps count as longer by `near` metres at both ends.
    """
    gaps = [shapely.Polygon([corner[:2] for corner in gap.outline]) for gap in coverage.gaps]
    bounds = np.array([affinity.rotate(gap, direction, origin=(0, 0)).bounds for gap in gaps])
    middle, half = (bounds[:, :2] + bounds[:, 2:]) / 2, np.maximum((bounds[:, 2:] - bounds[:, :2]) / 2, LEAST / 2)
    boxes = list(shapely.box(*(middle - half).T, *(middle + half).T))
    pair: tuple[int, int] | None = (0, 0)
    while pair is not None:
        pair = next(((i, j) for i in range(len(boxes)) for j in range(i) if _fill_one(boxes[i], boxes[j], near)), None)
        if pair is not None:
            boxes[pair[1]] = shapely.envelope(shapely.union(boxes.pop(pair[0]), boxes[pair[1]]))
    return [shapely.get_coordinates(affinity.rotate(box, -direction, origin=(0, 0)))[:-1] for box in boxes]


def _fill_one(one: shapely.Polygon, other: shapely.Polygon, near: float) -> bool:
    """Tell whether two boxes together fill a box."""
    both = shapely.envelope(shapely.union(one, other))
    grown = [shapely.box(x, y - near, u, v + near) for x, y, u, v in (one.bounds, other.bounds)]
    return bool(shapely.intersection(both, shapely.union(*grown)).area >= FILLED * both.area)


def facets_of(coverage: Coverage) -> tuple[tuple[Point, Point, Point], ...]:
    """Return the triangles of a coverage's gaps on structures."""
    corners = [gap.outline for gap in coverage.gaps]
    return tuple((one[0], one[k], one[k + 1]) for one in corners for k in range(1, len(one) - 1))  # type: ignore[misc]
